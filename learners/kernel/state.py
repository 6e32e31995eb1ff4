"""All that a learner is at a moment: its arrays, and how they are made, copied and identified."""

import hashlib
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from learners.kernel import rows
from learners.kernel.layout import by_main_state, by_sub_policy, first_rows, n_selection_rows
from learners.kernel.templates import seed_moves
from learners.learner_spec import LearnerSpec
from learners.names import COMMANDS, MAX_TRIALS, MOVES
from learners.spec import RunSpec
from learners.template_spec import SELECTION
from sim import rng
from sim.geometry import N_MOVES
from sim.spec import N_HEADINGS
from sim.world import World, start_of_trial

TRAIL_LENGTH = 16_384
"""Cells the trail remembers, a power of two: at least the last 32 trials of 500 steps."""

NO_OPTION = 255
NOT_REACHED = -1

# Slots of ``LearnerState.place``.
CELL = 0
HEADING = 1
OPTION = 2

# Slots of ``LearnerState.tally``.
STEP = 0
TRIAL = 1
TRIAL_STEP = 2
TRIAL_NEW_STATES = 3
TRIAL_SWITCHES = 4
REPERTOIRE = 5
TRIAL_REACHED = 6
EXERCISES = 7
EARLIER = 8
N_TALLIES = 9

# Slots of ``LearnerState.choice``.
CHOICE_STATE = 0
CHOICE_STEPS = 1

# Slots of ``LearnerState.choice_sums``.
CHOICE_REWARD = 0
CHOICE_DISCOUNT = 1

# Slots of ``LearnerState.command``.
COMMAND_STEPS = 0
COMMAND_REGION = 1

MAX_TRACES = 256
"""Moves that have a trace at most, the latest; up to γ λ = 0.973 no earlier one would have any."""
LEAST_TRACE = 0.001


class LearnerState(NamedTuple):
    """All that a learner is at a moment: copy these arrays and you have a checkpoint."""

    selection: np.ndarray
    """(heading, distance, direction) rows of options, see ``learners.kernel.rows``; float32."""
    selection_words: np.ndarray
    """The same memory seen as uint32."""
    skills: np.ndarray
    """(skill, distance, direction) rows of moves, as skills see these; float32."""
    skill_words: np.ndarray
    """The same memory seen as uint32."""
    visits: np.ndarray
    """(heading, distance, direction, option) uint32: how often an option was taken in a state."""
    first_reach: np.ndarray
    """(heading, distance, direction) int32: trial in which the value first rose above 0, or -1."""
    seen: np.ndarray
    """(heading, distance, direction) uint8: repertoire at the last visit, counted from 1."""
    trail: np.ndarray
    """(TRAIL_LENGTH,) uint32 ring: the cell after step n is at n % TRAIL_LENGTH."""
    place: np.ndarray
    """(3,) uint64: cell, heading, option of the last step."""
    tally: np.ndarray
    """(N_TALLIES,) int64: steps and trials so far, what the running trial counts, and of
    pre-training how often a skill was placed somewhere, and the steps until a trial has ended."""
    change: np.ndarray
    """(1,) float64: sum of |dQ| of the selection in the running trial."""
    streams: np.ndarray
    """(2,) uint64: counters of the decisions and the starts."""
    choice: np.ndarray
    """(2,) int64: main state in which the choice was made that is kept, and for how many steps it
    was, 0 if one is to be made; empty where choices are not kept."""
    choice_sums: np.ndarray
    """(2,) float32: reward of these steps, and the discount of what follows; or empty."""
    best_ever: np.ndarray
    """(skill,) float32: the most that each promised where a skill was selected; empty where it does
    not matter which skills are applicable."""
    trace_at: np.ndarray
    """(MAX_TRACES,) uint64: places in the selection of the last moves, the latest of all last; of
    size 0 without traces."""
    trace: np.ndarray
    """(MAX_TRACES,) float32: eligibility of each; 0 from the first on that is none."""
    command: np.ndarray
    """(2,) int64: steps for which the command of the last step has been held, 0 if it is over, and
    the region in which it was given; of size 0 without a manager."""
    w_values: np.ndarray
    """(skill, heading, distance, direction) float32: W of each skill; empty but in W-learning."""
    log_outcome: np.ndarray
    """(trial,) int8: how each trial ended; the logs grow with the trials."""
    log_reward: np.ndarray
    """(trial,) float64: reward of each trial, as rewards were when it ended.

    Outcome and rewards say it, so the loop leaves it to ``learners.run``: kept until the end of a
    step, the reward would cost a register.
    """
    log_steps: np.ndarray
    """(trial,) int32: steps in each trial; in the first, with those of pre-training before it."""
    log_new_states: np.ndarray
    """(trial,) int32: visits of states not visited before with the repertoire of the time."""
    log_reached: np.ndarray
    """(trial,) int32: states whose value rose above 0 for the first time."""
    log_switches: np.ndarray
    """(trial,) int32: steps with another option than the step before; the first counts as one."""
    log_change: np.ndarray
    """(trial,) float32: sum of |dQ| of the selection."""
    log_cell: np.ndarray
    """(trial,) uint32: where the trial ended."""


_LOGS = tuple(name for name in LearnerState._fields if name.startswith("log_"))
_ALIASES = {"selection_words": "selection", "skill_words": "skills"}
_TABLES = ("visits", "first_reach", "seen", "best_ever")


def n_options_of(spec: RunSpec) -> int:
    """Columns of the selection table."""
    return len(spec.learner.sub_policies) or N_MOVES


def learns_w(spec: RunSpec) -> bool:
    """Whether skills learn what it costs them that another moves (W-learning)."""
    return spec.learner.selection == "w_learning"


def new_state(spec: RunSpec, world: World, seed: int) -> LearnerState:
    """The state before the first step; no skill is present yet."""
    n_states, n_options = spec.world.n_states, n_options_of(spec)
    n_skills = len(spec.learner.skills)
    initial_q = spec.learner.initial_q
    selection = rows.new_table(n_selection_rows(spec), 0 if n_skills else n_options, initial_q)
    skills = rows.new_table(int(first_rows(spec)[-1]), N_MOVES, initial_q)
    for number, skill in enumerate(spec.learner.skills):
        first, last = (int(row) for row in first_rows(spec)[number : number + 2])
        seed_moves(spec, skill, rows.values(skills)[first:last])
    if spec.learner.options == MOVES:
        seed_moves(spec, SELECTION, rows.values(selection))
    if spec.learner.templates:
        rows.rescan_all(skills, skills.view(np.uint32))
        rows.rescan_all(selection, selection.view(np.uint32))
    streams = rng.streams(seed)
    is_pretrained = n_skills > 0 and spec.schedule.pretrain > 0
    first = MAX_TRIALS if is_pretrained else 0
    cell, heading = start_of_trial(world, streams[rng.STARTS], first)
    # Values that start above 0 have been there from the first trial on.
    first_reach = np.full(n_states, 0 if initial_q > 0 else NOT_REACHED, np.int32)
    if spec.learner.options == MOVES:
        first_reach[rows.best(selection) > 0] = 0
    tally = np.zeros(N_TALLIES, np.int64)
    tally[REPERTOIRE] = 1
    tally[EXERCISES] = int(is_pretrained)
    is_held = spec.learner.held is not None
    n_applicable = 0 if spec.learner.applicable is None else n_skills
    n_traces = 0 if spec.learner.trace_decay is None else MAX_TRACES
    return LearnerState(
        selection=selection,
        selection_words=selection.view(np.uint32),
        skills=skills,
        skill_words=skills.view(np.uint32),
        visits=np.zeros(n_states * n_options, np.uint32),
        first_reach=first_reach,
        seen=np.zeros(n_states, np.uint8),
        trail=np.full(TRAIL_LENGTH, cell, np.uint32),
        place=np.array([cell, heading, NO_OPTION], np.uint64),
        tally=tally,
        change=np.zeros(1),
        streams=streams,
        choice=np.zeros(2 if is_held else 0, np.int64),
        choice_sums=np.zeros(2 if is_held else 0, np.float32),
        best_ever=np.full(n_applicable, initial_q, np.float32),
        trace_at=np.zeros(n_traces, np.uint64),
        trace=np.zeros(n_traces, np.float32),
        command=np.zeros(2 if spec.learner.options == COMMANDS else 0, np.int64),
        w_values=np.zeros(n_skills * n_states if learns_w(spec) else 0, np.float32),
        log_outcome=np.zeros(spec.trials, np.int8),
        log_reward=np.zeros(spec.trials, np.float64),
        log_steps=np.zeros(spec.trials, np.int32),
        log_new_states=np.zeros(spec.trials, np.int32),
        log_reached=np.zeros(spec.trials, np.int32),
        log_switches=np.zeros(spec.trials, np.int32),
        log_change=np.zeros(spec.trials, np.float32),
        log_cell=np.zeros(spec.trials, np.uint32),
    )


def copy_state(state: LearnerState) -> LearnerState:
    """An independent copy."""
    copied = {name: array.copy() for name, array in state._asdict().items() if name not in _ALIASES}
    copied["selection"] = rows.copy_table(state.selection)
    copied["skills"] = rows.copy_table(state.skills)
    for alias, owner in _ALIASES.items():
        copied[alias] = copied[owner].view(np.uint32)
    return LearnerState(**copied)


def with_room_for(state: LearnerState, trials: int) -> LearnerState:
    """The same state, its logs grown to hold at least so many trials."""
    room = state.log_outcome.size
    if trials <= room:
        return state
    grown = max(trials, min(2 * room, MAX_TRIALS))
    return state._replace(**{name: _longer(getattr(state, name), grown) for name in _LOGS})


def _longer(log: np.ndarray, size: int) -> np.ndarray:
    """A log with zeros behind it, of which the system gives memory only where one is written."""
    longer = np.zeros(size, log.dtype)
    longer[: log.size] = log
    return longer


def join_option(
    state: LearnerState,
    option: int,
    initial_q: float,
    *,
    safely: bool,
    seed: Callable[[np.ndarray], None] = lambda _column: None,
) -> None:
    """Give an option its first values.

    Args:
        state: that of the learner whose selection it joins.
        option: column of the selection table; absent so far.
        initial_q: value of everything not yet tried.
        safely: Q(s, new) = min(initial, max of the present) for every s, so that no state's utility
            changes (section 3.3.4); otherwise Q(s, new) = initial, which raises the utility of
            states that are known to be worth less.
        seed: changes what a template says of some states, ``(state,) float32``; that is known, and
            not held down by what the present are worth.
    """
    utility = rows.best(state.selection)
    column = np.full_like(utility, initial_q)
    if safely:
        present = np.isfinite(utility)
        column[present] = np.minimum(column[present], utility[present])
    seed(column)
    rows.values(state.selection)[:, option] = column
    rows.rescan_all(state.selection, state.selection_words)


def with_option(state: LearnerState, former: RunSpec, spec: RunSpec) -> LearnerState:
    """The same state with room for the skill that ``spec`` has more than ``former``, absent yet."""
    n_former = len(former.learner.skills)
    n_rows = int(first_rows(spec)[-1])
    skills = rows.new_table(n_rows, N_MOVES, spec.learner.initial_q)
    skills[: state.skills.size] = state.skills
    visits = np.pad(state.visits.reshape(-1, n_former), ((0, 0), (0, 1))).ravel()
    w_values = np.zeros((n_former + 1) * len(state.seen) if learns_w(spec) else 0, np.float32)
    w_values[: state.w_values.size] = state.w_values
    best_ever = state.best_ever
    if best_ever.size:
        best_ever = np.append(best_ever, np.float32(former.learner.initial_q))
    return state._replace(
        skills=skills,
        skill_words=skills.view(np.uint32),
        visits=visits,
        w_values=w_values,
        best_ever=best_ever,
    )


def leave_option(state: LearnerState, option: int) -> np.ndarray:
    """Take an option's values out of the selection table; returns them, ``(state,) float32``."""
    column = rows.values(state.selection)[:, option].copy()
    return_option(state, option, np.full_like(column, rows.NO_VALUE))
    return column


def return_option(state: LearnerState, option: int, column: np.ndarray) -> None:
    """Put values that were taken out back into the selection table."""
    rows.values(state.selection)[:, option] = column
    rows.rescan_all(state.selection, state.selection_words)


def selection_q_of(spec: RunSpec, state: LearnerState) -> np.ndarray:
    """Values of the options, ``(heading, distance, direction, option) float32``, as a copy.

    They are minus infinity where an option is not present. A static selection has no table; what
    its rules weigh stands in its place, w_i max_a Q_i(x, a).
    """
    if spec.learner.selection != "learned":
        return _wishes(spec, state)
    return by_main_state(spec, rows.values(state.selection)[:, : n_options_of(spec)])


def value_of(spec: RunSpec, state: LearnerState) -> np.ndarray:
    """Largest value of the present options, ``(heading, distance, direction) float32``, a copy."""
    if spec.learner.selection != "learned":
        return _wishes(spec, state).max(axis=-1)
    return by_main_state(spec, rows.best(state.selection))


def _wishes(spec: RunSpec, state: LearnerState) -> np.ndarray:
    """What the skills of a static selection are worth to it, as values of options."""
    of_skills = by_sub_policy(spec, rows.best(state.skills))
    shape = (N_HEADINGS, *of_skills.shape[-2:], len(of_skills))
    if of_skills.ndim == len(shape) - 1:
        of_skills = of_skills[:, None]
    found = np.empty(shape, np.float32)
    weights = weights_of(spec.learner)
    present = np.isfinite(rows.values(state.selection)[0, : len(of_skills)])
    for number, values in enumerate(of_skills):
        found[..., number] = weights[number] * values if present[number] else rows.NO_VALUE
    return found


def weights_of(learner: LearnerSpec) -> np.ndarray:
    """Weight of each skill in a static selection, ``(skill,) float32``."""
    return np.array([learner.weights.get(skill, 1.0) for skill in learner.skills], np.float32)


def skill_q_of(spec: RunSpec, state: LearnerState) -> np.ndarray:
    """Values of the moves, ``(skill, distance, direction, move) float32``, as a copy.

    Distance and direction are as skills see them, and commands count as skills. If one of them sees
    headings, it is ``(skill, heading, distance, direction, move)``, see
    :func:`learners.kernel.layout.by_sub_policy`.
    """
    return by_sub_policy(spec, rows.values(state.skills)[:, :N_MOVES])


def tables(spec: RunSpec, state: LearnerState) -> dict[str, np.ndarray]:
    """The tables under their own shapes, as copies.

    ``selection_q (heading, distance, direction, option)``, NaN where an option is absent;
    ``skill_q (skill, distance, direction, move)``, see :func:`skill_q_of`;
    ``visits`` like ``selection_q``; ``first_reach (heading, distance, direction)``, -1 where never.
    """
    shape = (N_HEADINGS, spec.world.n_distances, spec.world.n_directions)
    selection = selection_q_of(spec, state)
    selection[np.isneginf(selection)] = np.nan
    return {
        "selection_q": selection,
        "skill_q": skill_q_of(spec, state),
        "visits": state.visits.reshape(*shape, n_options_of(spec)).copy(),
        "first_reach": state.first_reach.reshape(shape).copy(),
    }


def digest(state: LearnerState) -> str:
    """SHA-256 of all tables and of the steps and trials it took to fill them."""
    total = hashlib.sha256()
    total.update(np.ascontiguousarray(rows.values(state.selection), "<f4").tobytes())
    total.update(np.ascontiguousarray(rows.values(state.skills), "<f4").tobytes())
    total.update(state.w_values.astype("<f4").tobytes())
    for name in _TABLES:
        array = getattr(state, name)
        # What a learner has no use for is empty, and adds nothing.
        total.update(array.astype(array.dtype.newbyteorder("<")).tobytes())
    total.update(state.tally[: TRIAL + 1].astype("<i8").tobytes())
    return total.hexdigest()
