"""Watkins's Q(λ): Q-learning in which each reward reaches the moves that led to it.

Standard Q-learning learns from a step about the move that made it alone, so the news of a capture
comes one move nearer to the start in each trial. Here a *trace* e of each of the last moves is
kept, and all of them learn from the error of the newest (Watkins 1989; Sutton and Barto 1998, 7.6):

    δ = r + γ max_a Q(s', a) - Q(s, a)
    Q(x, b) += α δ e(x, b)            for each trace, that of (s, a) being 1
    e(x, b) *= γ λ                    before the next step

A move that is made again has the trace of 1 once more (replacing traces). A trace below
``LEAST_TRACE`` is dropped, and so are all earlier ones where the learner takes a move that is not
greedy: what comes of that says nothing of what the greedy policy would have come to. A trial begins
without traces. With λ = 0 this is standard Q-learning, to the last bit.

Draws. A step takes one draw of 64 bits, and uses the same parts of it as that of standard
Q-learning: the lowest 16 bits for whether to explore, the next for which move.
"""

import numpy as np

from learners.kernel import rows
from learners.kernel.choices import selected_option
from learners.kernel.layout import by_main_state
from learners.kernel.loop import Settings
from learners.kernel.records import note_reach, note_step, note_trial
from learners.kernel.state import (
    CELL,
    HEADING,
    LEAST_TRACE,
    MAX_TRACES,
    NO_OPTION,
    OPTION,
    REPERTOIRE,
    STEP,
    TRIAL,
    TRIAL_NEW_STATES,
    TRIAL_STEP,
    TRIAL_SWITCHES,
    LearnerState,
)
from learners.spec import RunSpec
from sim.bits import U
from sim.compiled import loop, piece
from sim.geometry import N_MOVES
from sim.rng import DECISIONS, GAMMA, STARTS, mix
from sim.world import (
    CAPTURE,
    FLIGHT,
    ONGOING,
    READING_SHIFT,
    TIMEOUT,
    World,
    moved,
    outcome_of,
    start_of_trial,
)

_ONE = U(1)
_ROW_SHIFT = U(4)
_ACTION_MASK = U(rows.WORDS - 1)
_BEST = U(rows.BEST)
_GREEDY = U(rows.GREEDY)
_NOTHING = np.float32(0)
_WHOLE = np.float32(1)
_LEAST = np.float32(LEAST_TRACE)


@piece
def learn_traced(state: LearnerState, at: np.uint64, change: np.float32, trial: int) -> np.float32:
    """Change one value of the table, and note if its state is worth something now.

    Args:
        state: of the learner.
        at: place of the value in the table.
        change: what is added to it.
        trial: the running one.

    Returns:
        How much the value changed, which is ``change`` but for rounding.
    """
    table = state.selection
    row, action = at & ~_ACTION_MASK, at & _ACTION_MASK
    utility_tm1, q_tm1 = table[row + _BEST], table[at]
    q_t = q_tm1 + change
    rows.write(table, state.selection_words, row, action, q_t)
    if utility_tm1 <= _NOTHING and table[row + _BEST] > _NOTHING:
        note_reach(state, row >> _ROW_SHIFT, trial)
    return q_t - q_tm1


def eligibility(spec: RunSpec, state: LearnerState) -> np.ndarray | None:
    """How much each move would learn from what comes next; None of a learner without traces.

    ``(heading, distance, direction, move) float32``: the traces, which are 0 but of the last moves,
    and of these in the running trial alone.
    """
    if spec.learner.trace_decay is None:
        return None
    found = np.zeros((spec.world.n_states, rows.WORDS), np.float32)
    is_there = state.trace > 0
    found.ravel()[state.trace_at[is_there]] = state.trace[is_there]
    return by_main_state(spec, found[:, :N_MOVES])


@loop
def advance(
    world: World, state: LearnerState, settings: Settings, max_steps: int, until_trial: int
) -> int:
    """Learn for at most ``max_steps`` steps, and only while the trial is below ``until_trial``.

    Changes the arrays of ``state``. The logs must have room for ``until_trial`` trials.

    Returns:
        The number of steps made.
    """
    table = state.selection
    words = state.selection_words
    trace_at = state.trace_at
    trace = state.trace
    assert settings.trace_decay is not None
    decay = settings.gamma * settings.trace_decay

    cell = state.place[CELL]
    heading = state.place[HEADING]
    previous = state.place[OPTION]
    counter = state.streams[DECISIONS]
    step = state.tally[STEP]
    trial = state.tally[TRIAL]
    trial_step = state.tally[TRIAL_STEP]
    new_states = state.tally[TRIAL_NEW_STATES]
    switches = state.tally[TRIAL_SWITCHES]
    repertoire = np.uint8(state.tally[REPERTOIRE])
    change = state.change[0]
    n_traces = 0
    while n_traces < MAX_TRACES and trace[n_traces] > _NOTHING:
        n_traces += 1

    end_step = step + max_steps
    while step < end_step and trial < until_trial:
        reading = U(world.cell_word[cell]) >> READING_SHIFT
        s_tm1 = heading * world.n_readings + reading
        row = s_tm1 << _ROW_SHIFT
        counter += GAMMA
        draw = mix(counter)
        move = selected_option(table, words, row, settings.present, settings.epsilon16, draw)
        if U(words[row + _GREEDY]) & (_ONE << move) == U(0):
            n_traces = 0

        cell_t = moved(world.cell_word, world.clipped, world.move_step, cell, move)
        outcome = outcome_of(world, cell, cell_t, heading)
        reading_t = U(world.cell_word[cell_t]) >> READING_SHIFT
        reward = _NOTHING
        future = table[((heading * world.n_readings + reading_t) << _ROW_SHIFT) + _BEST]
        if outcome == FLIGHT:
            reward, future = world.flight_reward, _NOTHING
        elif outcome == CAPTURE:
            reward, future = world.capture_reward, _NOTHING
        step += 1
        trial_step += 1
        if outcome == ONGOING and trial_step == world.step_limit:
            outcome = TIMEOUT

        new_states += note_step(state, s_tm1, settings.n_options, move, repertoire, step, cell_t)
        if move != previous:
            switches += 1

        here = row + move
        error = settings.alpha * (reward + settings.gamma * future - table[here])
        kept = 0
        number = 1 if n_traces == MAX_TRACES else 0
        while number < n_traces:
            at = trace_at[number]
            share = trace[number] * decay
            number += 1
            if at != here and share >= _LEAST:
                trace_at[kept] = at
                trace[kept] = share
                kept += 1
                if error != _NOTHING:
                    change += float(abs(learn_traced(state, at, error * share, trial)))
        trace_at[kept] = here
        trace[kept] = _WHOLE
        n_traces = kept + 1
        if error != _NOTHING:
            change += float(abs(learn_traced(state, here, error, trial)))

        cell = cell_t
        previous = move
        if outcome != ONGOING:
            note_trial(state, trial, outcome, trial_step, new_states, switches, change, cell)
            trial += 1
            trial_step = 0
            new_states = 0
            switches = 0
            change = 0.0
            n_traces = 0
            previous = U(NO_OPTION)
            cell, heading = start_of_trial(world, state.streams[STARTS], trial)

    trace[n_traces:] = _NOTHING
    made = step - state.tally[STEP]
    state.place[CELL] = cell
    state.place[HEADING] = heading
    state.place[OPTION] = previous
    state.streams[DECISIONS] = counter
    state.tally[STEP] = step
    state.tally[TRIAL] = trial
    state.tally[TRIAL_STEP] = trial_step
    state.tally[TRIAL_NEW_STATES] = new_states
    state.tally[TRIAL_SWITCHES] = switches
    state.change[0] = change
    return made
