"""The loop that learns: timed hierarchical Q-learning, one step after another (section 3.3).

Every step chooses an option, lets the option choose a move, makes the move, and learns twice:
the selection table from the global reward, and the chosen skill, or every skill that is present,
from its local reward. An option is a primitive move or a skill; all learners of the thesis are
settings of this loop.

Switches. What a setting or a table does only where it is asked for is None elsewhere: the compiler
goes by types, makes a loop for each combination that is met, and leaves out of it what is None.

Draws. A step takes one draw of 64 bits from the stream of decisions and splits it into four of
16 bits, from the low end: whether to explore at the selection, which option, whether to explore
in the skill, which move. While biased exploration episodes run, each of them that acts in the
state, the newest first, takes a draw of its own before that, until one takes the step. A script
that teaches is asked before them, and takes none; where it chooses, episodes are not asked. In a
step in which a choice is kept, neither is asked, and the draw's part for the selection goes unused.
A trial's start comes from a stream of its own, by the trial's number.

The loop allocates nothing, touches no clock, and stops only between steps, so how many steps a
call makes does not change what is learned.
"""

from typing import NamedTuple

import numpy as np

from learners.kernel import rows
from learners.kernel.choices import imposed_option, selected_option, skill_move
from learners.kernel.forms import Forms, skill_row
from learners.kernel.layout import Regions
from learners.kernel.state import (
    CELL,
    EARLIER,
    EXERCISES,
    HEADING,
    NO_OPTION,
    NOT_REACHED,
    OPTION,
    REPERTOIRE,
    STEP,
    TRAIL_LENGTH,
    TRIAL,
    TRIAL_NEW_STATES,
    TRIAL_REACHED,
    TRIAL_STEP,
    TRIAL_SWITCHES,
    LearnerState,
)
from learners.kernel.updates import backup, learn_skill
from learners.names import MAX_TRIALS
from learners.policies.alone import is_alone, lone_option
from learners.policies.applicable import applicable_among
from learners.policies.held import Held, begin_choice, concluded, kept_option
from learners.policies.lesson import learn_from, note_wish
from learners.policies.static import Static, static_choice
from learners.policies.taught import is_taught, scripted_option
from learners.skills import local_reward, wrapped
from learners.triggers.watch import Watch, is_below, sums_after, sums_before
from sim.bits import U, lowest
from sim.compiled import loop
from sim.rng import DECISIONS, GAMMA, STARTS, mix
from sim.spec import N_HEADINGS
from sim.world import (
    CAPTURE,
    FLIGHT,
    ONGOING,
    PREY_BIT,
    READING_SHIFT,
    TIMEOUT,
    World,
    in_view,
    moved,
    skill_state_of,
    start_of_trial,
)


class Settings(NamedTuple):
    """What the loop is told for one call; constant while it runs."""

    n_options: np.uint64
    present: np.uint64
    """Options present, as bits."""
    options_are_moves: bool
    """Whether options are the primitive moves; otherwise each is the skill of its number."""
    reward_weights: np.ndarray
    """(skill * 4,) float32, see ``learners.skills.local_reward``."""
    rewards_are_binary: bool | None
    """Whether a local reward only tells that a move earned anything; None if not."""
    all_skills_learn: bool | None
    """Whether every skill that is present learns from every move; None if only the chosen one."""
    alpha: np.float32
    """Learning rate of the selection; 0 while it is frozen."""
    skill_alpha: np.float32
    gamma: np.float32
    epsilon16: np.uint64
    """Chance of a random choice at either level, in units of 2**-16."""
    n_episodes: int
    episode_option: np.ndarray
    """(episode,) uint64: option of each running exploration episode, the newest first."""
    episode_chance: np.ndarray
    """(episode,) uint64: its probability in units of 2**-32."""
    script: np.ndarray | None = None
    """(heading * cell,) uint8: option that a script chooses, or ``NO_OPTION``; None without one."""
    held: Held | None = None
    """For how long a choice is kept; None for one step."""
    applicable: np.float32 | None = None
    """Share of what a skill ever promised that it must promise to be selected; None for any."""
    alone: np.uint64 | None = None
    """The skill that is being pre-trained, see ``learners.policies.alone``; None in trials."""
    episode_value_at_most: np.ndarray | None = None
    """(episode,) float32: it acts where no other present option is worth more than this; None if
    all act everywhere."""
    watch: Watch | None = None
    """The rule by which the next skill joins; None if there is none."""
    trace_decay: np.float32 | None = None
    """Share of a trace that is left in the next step, the discount aside; None without traces."""
    regions: Regions | None = None
    """What the manager takes for one place; None without one."""
    forms: Forms | None = None
    """What the skills are like where they differ; None where they do not."""
    static: Static | None = None
    """The rule that selects in the place of a table; such a learner's skills have forms."""


_ZERO = U(0)
_ONE = U(1)
_ROW_SHIFT = U(4)
_LOW16 = U(0xFFFF)
_TRAIL_MASK = U(TRAIL_LENGTH - 1)
_BEST = U(rows.BEST)
_NOTHING = np.float32(0)


@loop
def advance(
    world: World, state: LearnerState, settings: Settings, max_steps: int, until_trial: int
) -> int:
    """Learn for at most ``max_steps`` steps, and only while the trial is below ``until_trial``.

    Where there is a rule by which a skill joins, it stops as well before the trial in which that is
    met. Changes the arrays of ``state``. The logs must have room for ``until_trial`` trials.

    Returns:
        The number of steps made.
    """
    table = state.selection
    words = state.selection_words
    skill_table = state.skills
    skill_words = state.skill_words
    cell_word = world.cell_word
    n_readings = world.n_readings
    skill_states = world.skill_states
    n_skill_states = n_readings if skill_states is None else world.n_skill_states
    n_states = n_readings * U(N_HEADINGS)
    forms = settings.forms
    static = settings.static
    n_options = settings.n_options
    present = settings.present
    epsilon16 = settings.epsilon16
    alpha = settings.alpha
    skill_alpha = settings.skill_alpha
    gamma = settings.gamma
    n_episodes = settings.n_episodes
    episode_option = settings.episode_option
    episode_chance = settings.episode_chance
    script = settings.script
    is_directed = n_episodes > 0 or is_taught(script)
    n_cells = U(cell_word.size)
    held = settings.held
    choice = state.choice
    choice_sums = state.choice_sums
    value_at_most = settings.episode_value_at_most
    watch = settings.watch
    options_are_moves = settings.options_are_moves
    weights = settings.reward_weights
    binary = settings.rewards_are_binary
    distance = world.distance
    angle = world.angle
    clipped = world.clipped
    move_step = world.move_step
    step_limit = world.step_limit
    visits = state.visits
    seen = state.seen
    trail = state.trail
    first_reach = state.first_reach
    w_values = state.w_values

    cell = state.place[CELL]
    heading = state.place[HEADING]
    previous = state.place[OPTION]
    counter = state.streams[DECISIONS]
    step = state.tally[STEP]
    trial = state.tally[TRIAL]
    trial_step = state.tally[TRIAL_STEP]
    new_states = state.tally[TRIAL_NEW_STATES]
    reached = state.tally[TRIAL_REACHED]
    switches = state.tally[TRIAL_SWITCHES]
    repertoire = np.uint8(state.tally[REPERTOIRE])
    change = state.change[0]

    reading = U(cell_word[cell]) >> READING_SHIFT
    watched, watched_size = sums_before(state, watch, trial)
    end_step = step + max_steps
    while step < end_step and trial < until_trial:
        word = U(cell_word[cell])
        s_tm1 = heading * n_readings + reading
        row = s_tm1 << _ROW_SHIFT

        skill_state = _ZERO
        if not options_are_moves:
            skill_state = skill_state_of(skill_states, cell, reading)
        option = lone_option(settings.alone, kept_option(held, choice, previous, present))
        is_kept = option != U(NO_OPTION)
        allowed = present
        if is_directed and not is_kept:
            option = scripted_option(script, n_cells, heading, cell)
            if option == U(NO_OPTION):
                option, allowed, counter = imposed_option(
                    present,
                    n_episodes,
                    episode_option,
                    episode_chance,
                    value_at_most,
                    table,
                    words,
                    row,
                    counter,
                )
        counter += GAMMA
        draw = mix(counter)
        row_tm1 = _ZERO
        if static is None:
            if option == U(NO_OPTION):
                allowed = applicable_among(
                    settings.applicable,
                    forms,
                    state.best_ever,
                    skill_table,
                    n_skill_states,
                    skill_state,
                    heading,
                    present,
                    allowed,
                    bool(skill_alpha > _NOTHING),
                )
                option = selected_option(table, words, row, allowed, epsilon16, draw)
            if not is_kept:
                begin_choice(held, choice, choice_sums, s_tm1)
            if options_are_moves:
                move = option
            else:
                row_tm1 = skill_row(forms, n_skill_states, option, skill_state, heading)
                move = skill_move(skill_words, row_tm1, epsilon16, draw)
        else:
            option, move = static_choice(
                static,
                forms,
                skill_table,
                skill_words,
                w_values,
                n_states,
                s_tm1,
                n_skill_states,
                skill_state,
                heading,
                allowed,
                option,
                epsilon16,
                draw,
            )

        cell_t = moved(cell_word, clipped, move_step, cell, move)
        word_t = U(cell_word[cell_t])
        reading_t = word_t >> READING_SHIFT
        outcome = ONGOING
        reward = _NOTHING
        future = table[((heading * n_readings + reading_t) << _ROW_SHIFT) + _BEST]
        if word_t & (PREY_BIT | (_ONE << heading)):
            if in_view(word, word_t, heading) and distance[cell_t] < distance[cell]:
                outcome = FLIGHT
                reward = world.flight_reward
                future = _NOTHING
            elif word_t & PREY_BIT:
                outcome = CAPTURE
                reward = world.capture_reward
                future = _NOTHING
        step += 1
        trial_step += 1
        if outcome == ONGOING and trial_step == step_limit:
            outcome = TIMEOUT

        if seen[s_tm1] != repertoire:
            seen[s_tm1] = repertoire
            new_states += 1
        visits[s_tm1 * n_options + option] += np.uint32(1)
        if option != previous:
            switches += 1
        trail[U(step) & _TRAIL_MASK] = np.uint32(cell_t)

        if static is None:
            is_over, s_choice, target = concluded(
                held,
                choice,
                choice_sums,
                s_tm1,
                reward,
                future,
                gamma,
                reading_t != reading,
                outcome != ONGOING,
            )
            if is_over and not is_alone(settings.alone):
                row_choice = s_choice << _ROW_SHIFT
                utility_tm1 = table[row_choice + _BEST]
                delta = backup(table, words, row_choice, option, target, alpha)
                if delta != _NOTHING:
                    change += float(abs(delta))
                    rose = utility_tm1 <= _NOTHING and table[row_choice + _BEST] > _NOTHING
                    if rose and first_reach[s_choice] == NOT_REACHED:
                        first_reach[s_choice] = trial
                        reached += 1

        if not options_are_moves:
            turn = _NOTHING
            if not word_t & PREY_BIT:
                turn = wrapped(angle[cell_t] - angle[cell])
            skill_state_t = skill_state_of(skill_states, cell_t, reading_t)
            if forms is not None:
                change += learn_from(
                    world,
                    state,
                    settings,
                    option,
                    move,
                    bool(draw & _LOW16 < epsilon16),
                    heading,
                    cell,
                    cell_t,
                    skill_state,
                    skill_state_t,
                    turn,
                    outcome,
                )
                if static is not None:
                    reached += note_wish(world, state, settings, heading, skill_state, trial)
            elif settings.all_skills_learn is None:
                r_t = local_reward(weights, binary, option, distance[cell], distance[cell_t], turn)
                row_t = (option * n_skill_states + skill_state_t) << _ROW_SHIFT
                learn_skill(skill_table, skill_words, row_tm1, row_t, move, r_t, gamma, skill_alpha)
            else:
                learning = present
                while learning != _ZERO:
                    skill = lowest(learning)
                    learning &= learning - _ONE
                    r_t = local_reward(
                        weights, binary, skill, distance[cell], distance[cell_t], turn
                    )
                    row_tm1 = (skill * n_skill_states + skill_state) << _ROW_SHIFT
                    row_t = (skill * n_skill_states + skill_state_t) << _ROW_SHIFT
                    learn_skill(
                        skill_table, skill_words, row_tm1, row_t, move, r_t, gamma, skill_alpha
                    )

        cell = cell_t
        reading = reading_t
        previous = option
        if outcome != ONGOING:
            number = trial + 1
            if is_alone(settings.alone):
                number = MAX_TRIALS + state.tally[EXERCISES]
                state.tally[EXERCISES] += 1
            else:
                state.log_outcome[trial] = outcome
                state.log_steps[trial] = trial_step + state.tally[EARLIER]
                state.log_new_states[trial] = new_states
                state.log_reached[trial] = reached
                state.log_switches[trial] = switches
                state.log_change[trial] = change
                state.log_cell[trial] = np.uint32(cell)
                state.tally[EARLIER] = 0
                watched, watched_size = sums_after(state, watch, trial, watched, watched_size)
                trial += 1
                if is_below(watch, trial, watched, watched_size):
                    until_trial = trial
            trial_step = 0
            new_states = 0
            reached = 0
            switches = 0
            change = 0.0
            previous = U(NO_OPTION)
            cell, heading = start_of_trial(world, state.streams[STARTS], number)
            reading = U(cell_word[cell]) >> READING_SHIFT

    made = step - state.tally[STEP]
    if is_alone(settings.alone):
        state.tally[EARLIER] += made
    state.place[CELL] = cell
    state.place[HEADING] = heading
    state.place[OPTION] = previous
    state.streams[DECISIONS] = counter
    state.tally[STEP] = step
    state.tally[TRIAL] = trial
    state.tally[TRIAL_STEP] = trial_step
    state.tally[TRIAL_NEW_STATES] = new_states
    state.tally[TRIAL_REACHED] = reached
    state.tally[TRIAL_SWITCHES] = switches
    state.change[0] = change
    return made
