"""Feudal Q-learning: a manager that commands, and sub-policies that learn to obey (section 3.2).

After Dayan and Hinton (1993), on two levels. The *manager* sees the prey's heading and the region,
a block of sectors and rings, and gives one of five commands: to leave the region counter-clockwise,
clockwise, inwards or outwards, or to search it. A command holds until the region changes, the trial
ends, or ``MOST_STEPS`` steps have been made; then the manager learns from it, discounted once a
command however long that took. With S and S' what the manager saw when it gave the command and sees
now, and R the reward since then:

    M(S, c) += α (R + γ max_c' M(S', c') - M(S, c))

where nothing follows a capture or a flight. There is no reward before the end of a trial, so R is
that of the last step.

Each command has a sub-policy that chooses the moves while it holds. All five learn from each move,
whichever command it was made for:

    Q_c(x, a) += α_s (r_c + γ max_a' Q_c(x', a') - Q_c(x, a))

r_c is 1 for the commanded crossing into another region, whatever else the move led to, and
otherwise 0; of the search it is the reward of the world, a hundredth of it. Nothing follows for a
sub-policy where the region changes or the prey is caught or flees. The four that cross see
direction and distance, as skills do; the search sees the prey's heading as well.

Draws. A step takes one draw of 64 bits and splits it as the loop of skills does: of the low end, 16
bits for whether the manager explores and 16 for which command, in steps in which it gives one; then
16 for whether to explore among the moves, and 16 for which.
"""

from typing import NamedTuple

import numpy as np

from learners.kernel import rows
from learners.kernel.choices import selected_option, skill_move
from learners.kernel.layout import Regions
from learners.kernel.loop import Settings, backup
from learners.kernel.records import note_reach, note_step, note_trial
from learners.kernel.state import (
    CELL,
    COMMAND_REGION,
    COMMAND_STEPS,
    HEADING,
    NO_OPTION,
    NOT_REACHED,
    OPTION,
    REPERTOIRE,
    STEP,
    TRIAL,
    TRIAL_NEW_STATES,
    TRIAL_STEP,
    TRIAL_SWITCHES,
    LearnerState,
)
from learners.names import COMMAND_NAMES, SEARCH
from sim.bits import U
from sim.compiled import loop, piece
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
    skill_state_of,
    start_of_trial,
)

MOST_STEPS = 50
"""A command holds for at most so many steps."""

COUNTERCLOCKWISE, CLOCKWISE, INWARDS, OUTWARDS = (
    U(COMMAND_NAMES.index(name))
    for name in ("counterclockwise", "clockwise", "inwards", "outwards")
)
_SEARCH = U(COMMAND_NAMES.index(SEARCH))
_N_COMMANDS = U(len(COMMAND_NAMES))
SEARCHED = np.float32(0.01)
"""Share of the world's reward that the search is told."""

_ZERO = U(0)
_ONE = U(1)
_ROW_SHIFT = U(4)
_BEST = U(rows.BEST)
_NOTHING = np.float32(0)
_CROSSED = np.float32(1)


class Commanded(NamedTuple):
    """A command that holds between two steps."""

    command: int
    """Its number, see ``learners.names.COMMAND_NAMES``."""
    region: int
    """In which it was given; ``ring * n_sectors + sector`` of the regions."""
    steps: int
    """For which it has been obeyed so far; of ``MOST_STEPS`` at most."""


def commanded(state: LearnerState) -> Commanded | None:
    """The command that holds; None where the manager gives one next, or there is no manager."""
    if not state.command.size or not state.command[COMMAND_STEPS]:
        return None
    given_in, steps = state.command[COMMAND_REGION], state.command[COMMAND_STEPS]
    return Commanded(int(state.place[OPTION]), int(given_in), int(steps))


@piece
def crossing(regions: Regions, region_tm1: np.uint64, region_t: np.uint64) -> np.uint64:
    """The commands that are fulfilled by getting from one region to another, as bits.

    A move that changes sector and ring at once fulfils two. Near the prey it may pass over sectors:
    the shorter way round counts, and both do if neither is.
    """
    n_sectors = regions.n_sectors
    ring_tm1, ring_t = region_tm1 // n_sectors, region_t // n_sectors
    turned = (region_t % n_sectors + n_sectors - region_tm1 % n_sectors) % n_sectors
    fulfilled = _ZERO
    if turned != _ZERO and turned + turned <= n_sectors:
        fulfilled |= _ONE << COUNTERCLOCKWISE
    if turned + turned >= n_sectors:
        fulfilled |= _ONE << CLOCKWISE
    if ring_t < ring_tm1:
        fulfilled |= _ONE << INWARDS
    if ring_t > ring_tm1:
        fulfilled |= _ONE << OUTWARDS
    return fulfilled


@piece
def note_reach_of_region(
    state: LearnerState, regions: Regions, heading: np.uint64, region: np.uint64, trial: int
) -> None:
    """Note of all main states of a region that their value has risen above 0."""
    n_readings = U(regions.of_reading.size)
    reading = _ZERO
    while reading < n_readings:
        if U(regions.of_reading[reading]) == region:
            note_reach(state, heading * n_readings + reading, trial)
        reading += _ONE


@piece
def obey(
    world: World,
    state: LearnerState,
    settings: Settings,
    heading: np.uint64,
    skill_state: np.uint64,
    skill_state_t: np.uint64,
    move: np.uint64,
    fulfilled: np.uint64,
    reward: np.float32,
    is_over: bool,
) -> None:
    """Let all sub-policies learn from a move.

    Args:
        world: the world.
        state: of the learner.
        settings: of the learner.
        heading: of the prey.
        skill_state: what skills saw before the move.
        skill_state_t: what they see after it.
        move: the move.
        fulfilled: commands that the move fulfilled, as bits.
        reward: of the world.
        is_over: whether nothing follows for any of them.
    """
    table, words = state.skills, state.skill_words
    command = _ZERO
    while command < _N_COMMANDS:
        first = command * world.n_skill_states
        r_t = _CROSSED if fulfilled >> command & _ONE != _ZERO else _NOTHING
        if command == _SEARCH:
            first += heading * world.n_skill_states
            r_t = reward * SEARCHED
        target = r_t
        if not is_over:
            target += settings.gamma * table[((first + skill_state_t) << _ROW_SHIFT) + _BEST]
        row = (first + skill_state) << _ROW_SHIFT
        backup(table, words, row, move, target, settings.skill_alpha)
        command += _ONE


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
    regions = settings.regions
    assert regions is not None
    of_reading = regions.of_reading
    n_regions = regions.n_regions

    cell = state.place[CELL]
    heading = state.place[HEADING]
    previous = state.place[OPTION]
    held = state.command[COMMAND_STEPS]
    region = U(state.command[COMMAND_REGION])
    counter = state.streams[DECISIONS]
    step = state.tally[STEP]
    trial = state.tally[TRIAL]
    trial_step = state.tally[TRIAL_STEP]
    new_states = state.tally[TRIAL_NEW_STATES]
    switches = state.tally[TRIAL_SWITCHES]
    repertoire = np.uint8(state.tally[REPERTOIRE])
    change = state.change[0]
    command = previous

    end_step = step + max_steps
    while step < end_step and trial < until_trial:
        reading = U(world.cell_word[cell]) >> READING_SHIFT
        s_tm1 = heading * world.n_readings + reading
        counter += GAMMA
        draw = mix(counter)
        if held == 0:
            region = U(of_reading[reading])
            row = (heading * n_regions + region) << _ROW_SHIFT
            command = selected_option(table, words, row, settings.present, settings.epsilon16, draw)
        skill_state = skill_state_of(world.skill_states, cell, reading)
        first = command * world.n_skill_states
        if command == _SEARCH:
            first += heading * world.n_skill_states
        skill_row = (first + skill_state) << _ROW_SHIFT
        move = skill_move(state.skill_words, skill_row, settings.epsilon16, draw)

        cell_t = moved(world.cell_word, world.clipped, world.move_step, cell, move)
        outcome = outcome_of(world, cell, cell_t, heading)
        reading_t = U(world.cell_word[cell_t]) >> READING_SHIFT
        region_t = U(of_reading[reading_t])
        reward = _NOTHING
        if outcome == FLIGHT:
            reward = world.flight_reward
        elif outcome == CAPTURE:
            reward = world.capture_reward
        is_end = outcome != ONGOING
        step += 1
        trial_step += 1
        held += 1
        if outcome == ONGOING and trial_step == world.step_limit:
            outcome = TIMEOUT

        new_states += note_step(state, s_tm1, settings.n_options, command, repertoire, step, cell_t)
        if command != previous:
            switches += 1

        if outcome != ONGOING or region_t != region or held == MOST_STEPS:
            row = (heading * n_regions + region) << _ROW_SHIFT
            future = _NOTHING
            if not is_end:
                future = table[((heading * n_regions + region_t) << _ROW_SHIFT) + _BEST]
            utility_tm1 = table[row + _BEST]
            target = reward + settings.gamma * future
            change += float(abs(backup(table, words, row, command, target, settings.alpha)))
            rose = utility_tm1 <= _NOTHING and table[row + _BEST] > _NOTHING
            if rose and state.first_reach[s_tm1] == NOT_REACHED:
                note_reach_of_region(state, regions, heading, region, trial)
            held = 0

        obey(
            world,
            state,
            settings,
            heading,
            skill_state,
            skill_state_of(world.skill_states, cell_t, reading_t),
            move,
            crossing(regions, region, region_t),
            reward,
            is_end or region_t != region,
        )

        cell = cell_t
        previous = command
        if outcome != ONGOING:
            note_trial(state, trial, outcome, trial_step, new_states, switches, change, cell)
            trial += 1
            trial_step = 0
            new_states = 0
            switches = 0
            change = 0.0
            previous = U(NO_OPTION)
            cell, heading = start_of_trial(world, state.streams[STARTS], trial)

    made = step - state.tally[STEP]
    state.place[CELL] = cell
    state.place[HEADING] = heading
    state.place[OPTION] = previous
    state.command[COMMAND_STEPS] = held
    state.command[COMMAND_REGION] = region
    state.streams[DECISIONS] = counter
    state.tally[STEP] = step
    state.tally[TRIAL] = trial
    state.tally[TRIAL_STEP] = trial_step
    state.tally[TRIAL_NEW_STATES] = new_states
    state.tally[TRIAL_SWITCHES] = switches
    state.change[0] = change
    return made
