"""What a run looks like at one moment: a copy that nobody changes any more.

The worker takes one between two slices of learning; views and panels read it and nothing else.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from app.live.watched import Watched, watched_along
from learners import measures
from learners.comparators.feudal import Commanded, commanded
from learners.comparators.q_lambda import eligibility
from learners.control import Control
from learners.kernel.state import (
    CELL,
    CHOICE_STATE,
    CHOICE_STEPS,
    HEADING,
    OPTION,
    TRAIL_LENGTH,
    TRIAL_STEP,
    n_options_of,
    selection_q_of,
    skill_q_of,
    value_of,
)
from learners.measures import Curve, Endings, Progress
from learners.policies.greedy import Choices, Rule, choices_of, rule_of
from learners.run import Run
from learners.spec import RunSpec
from sim.geometry import N_MOVES
from sim.spec import N_HEADINGS
from sim.world import World

TRAIL_STEPS = 120
"""Steps of the running trial that the trail shows."""
FADE = 0.85
"""What is left of a flash of learning from one snapshot to the next."""
RECENT_PATHS = 20
_AXES = 3
"""Of the table of one skill that does not see headings."""
RECENT_ENDS = 16
"""Ends of trials that a snapshot carries."""


@dataclass(frozen=True)
class TrialEnd:
    """Where and how a trial ended."""

    trial: int
    cell: int
    heading: int
    outcome: int


@dataclass(frozen=True)
class TrialPath:
    """The whole way of a trial that has ended."""

    heading: int
    outcome: int
    cells: np.ndarray
    """(step + 1,) int64, its start included."""


class HeldChoice(NamedTuple):
    """A choice that is kept between two steps."""

    option: int
    state: int
    """Main state in which it was made, and for which its reward will be learned."""
    steps: int
    """For which it has been kept so far."""


@dataclass(frozen=True, eq=False)
class Snapshot:
    """One moment of one run. Arrays are copies."""

    preset: str
    spec: RunSpec
    """The preset as commands have changed it."""
    preset_spec: RunSpec
    """The preset as the run started with it."""
    seed: int
    generation: int
    """Counts the runs of a session, so that a view knows which one it is shown."""
    world: World
    control: Control
    present: tuple[str, ...]
    selection_frozen: bool
    step: int
    trial: int
    trial_step: int
    cell: int
    heading: int
    selection_q: np.ndarray
    """(heading, distance, direction, option) float32, minus infinity where not present."""
    value: np.ndarray
    """(heading, distance, direction) float32: the largest of the present options' values."""
    first_reach: np.ndarray
    """(heading, distance, direction) int32: trial in which the value first rose, or -1."""
    visits: np.ndarray
    """(heading, distance, direction, option) uint32: how often an option was taken in a state."""
    option_visits: np.ndarray
    """(option,) int64: how often each option has been taken so far."""
    skill_q: np.ndarray
    """(skill, distance, direction, move) float32, distance and direction as skills see them; with
    an axis of headings before distance where one of the skills sees these."""
    best_ever: np.ndarray
    """(skill,) float32: the most that each ever promised; empty where that does not matter."""
    rule: Rule | None
    """What selects in the place of a table, and what it goes by; None if there is a table."""
    learning_now: np.ndarray
    """(heading, distance, direction) float32: how much values changed lately, fading."""
    trail: np.ndarray
    """(step,) int64: cells of the running trial, oldest first, at most ``TRAIL_STEPS + 1``."""
    ends: tuple[TrialEnd, ...]
    """The most recent ends of trials, oldest first."""
    paths: tuple[TrialPath, ...]
    """Of the most recent trials, oldest first."""
    recent: Endings
    """How the last ``measures.RECENT_TRIALS`` trials ended."""
    recent_reward: float
    """Mean per trial over as many; NaN before the first has ended."""
    curve: Curve
    """Over windows of steps, :func:`curve_window` wide."""
    trial_curve: Curve
    """Over windows of consecutive trials, :func:`curve_window_trials` wide."""
    progress: Progress
    """How steps and trials go together, as far as the curves go."""
    watched: tuple[Watched, ...]
    """What the rules by which skills join have watched, as far as the curves go."""
    eligibility: np.ndarray | None = None
    """(heading, distance, direction, move) float32: traces; None of a learner without any."""
    commanded: Commanded | None = None
    """The command that holds; None where a manager gives one next, or there is none."""
    held: HeldChoice | None = None
    """The choice that is kept; None where one is made next, or none is ever kept."""

    @cached_property
    def choices(self) -> Choices | None:
        """What the rule that selects chooses without exploring; None if there is a table."""
        return None if self.rule is None else choices_of(self.spec, self.rule)

    @property
    def choice_q(self) -> np.ndarray:
        """(heading, distance, direction, option) float32: the option of the largest is chosen."""
        return self.selection_q if self.choices is None else self.choices.share

    @property
    def move_q(self) -> np.ndarray:
        """Like ``skill_q``: once an option is chosen, its move of the largest is made."""
        if self.choices is None:
            return self.skill_q
        moves = self.choices.moves[..., None] >> np.arange(N_MOVES, dtype=np.uint16)
        return (moves & 1).astype(np.float32)

    def skill_q_of(self, skill: int, heading: int) -> np.ndarray:
        """Table of a skill, or of what obeys a command, for a prey that looks that way.

        ``(distance, direction, move) float32``, distance and direction as skills see them.
        """
        table = self.skill_q[skill]
        return table if table.ndim == _AXES else table[heading]


def curve_window(steps: int) -> int:
    """Steps of one window of a curve drawn with at most 250 points: 1, 2 or 5 times 10**k."""
    return _width(steps, 1_000)


def curve_window_trials(trials: int) -> int:
    """Trials of one window of such a curve: 500 unless these are too many points."""
    return _width(trials, measures.CURVE_WINDOW_TRIALS)


def _width(length: int, width: int) -> int:
    """The least of the round widths from ``width`` on of which 250 cover a length."""
    while length > 250 * width:
        width = width * 5 // 2 if str(width)[0] == "2" else width * 2
    return width


def take(
    run: Run,
    preset: str,
    generation: int,
    former: Snapshot | None = None,
    new_curve: bool = True,
    curve_steps: int | None = None,
) -> Snapshot:
    """Copy what is seen of a run.

    Args:
        run: the run.
        preset: name of its preset.
        generation: number of the run in its session.
        former: the last snapshot of the same run, for what fades.
        new_curve: whether the learning curves and the paths, which cost most, are made anew; if
            not, the former ones stay.
        curve_steps: by which the windows of the learning curve are chosen, where it is drawn beside
            others; if None, the run's own.
    """
    state, spec = run.state, run.spec
    shape = (N_HEADINGS, spec.world.n_distances, spec.world.n_directions)
    n_options = n_options_of(spec)
    visits = state.visits.reshape(*shape, n_options).copy()
    selection_q = selection_q_of(spec, state)
    if new_curve or former is None:
        steps = run.step if curve_steps is None else curve_steps
        curve = measures.curve(state, curve_window(steps))
        trial_curve = measures.curve_over_trials(state, curve_window_trials(run.trial))
        progress = measures.progress(state)
        watched = watched_along(run, () if former is None else former.watched)
    else:
        curve, trial_curve, progress = former.curve, former.trial_curve, former.progress
        watched = former.watched
    return Snapshot(
        preset=preset,
        spec=spec,
        preset_spec=run.preset,
        seed=run.seed,
        generation=generation,
        world=run.world,
        control=run.control,
        present=run.present,
        selection_frozen=run.selection_is_frozen,
        step=run.step,
        trial=run.trial,
        trial_step=int(state.tally[TRIAL_STEP]),
        cell=int(state.place[CELL]),
        heading=int(state.place[HEADING]),
        selection_q=selection_q,
        value=value_of(spec, state),
        first_reach=state.first_reach.reshape(shape).copy(),
        visits=visits,
        option_visits=visits.sum(axis=(0, 1, 2), dtype=np.int64),
        skill_q=skill_q_of(spec, state),
        best_ever=state.best_ever.copy(),
        rule=rule_of(spec, state),
        learning_now=_learning_now(selection_q, former),
        trail=_trail(run),
        ends=_ends(run),
        paths=_paths(run) if new_curve or former is None else former.paths,
        recent=measures.endings(state, measures.RECENT_TRIALS),
        recent_reward=measures.recent_reward(state),
        curve=curve,
        trial_curve=trial_curve,
        progress=progress,
        watched=watched,
        eligibility=eligibility(spec, state),
        commanded=commanded(state),
        held=_held(run),
    )


def _held(run: Run) -> HeldChoice | None:
    choice = run.state.choice
    if not choice.size or not choice[CHOICE_STEPS]:
        return None
    option = int(run.state.place[OPTION])
    return HeldChoice(option, int(choice[CHOICE_STATE]), int(choice[CHOICE_STEPS]))


def _learning_now(selection_q: np.ndarray, former: Snapshot | None) -> np.ndarray:
    """What is left of the former flashes, and the changes since."""
    if former is None or former.selection_q.shape != selection_q.shape:
        return np.zeros(selection_q.shape[:3], np.float32)
    since = change_between(former.selection_q, selection_q)
    return np.float32(FADE) * former.learning_now + since


def change_between(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """How much each state's values changed: the most that any option's did.

    Args:
        before: (heading, distance, direction, option) float32, minus infinity where not present.
        after: the same, later; of another shape where an option joined that had no place before.

    Returns:
        (heading, distance, direction) float32; options that were not there both times do not count.
    """
    if before.shape != after.shape:
        return np.zeros(after.shape[:3], np.float32)
    both = np.isfinite(after) & np.isfinite(before)
    change = np.zeros_like(after)
    np.subtract(after, before, out=change, where=both)
    return np.abs(change).max(axis=-1)


def _trail(run: Run) -> np.ndarray:
    """Cells of the running trial in order, its start included while it is recent enough."""
    state = run.state
    made = int(state.tally[TRIAL_STEP])
    count = min(made, TRAIL_STEPS)
    steps = np.arange(run.step - count + 1, run.step + 1)
    cells = state.trail[steps % TRAIL_LENGTH].astype(np.int64)
    if made <= TRAIL_STEPS:
        start, _ = run.start
        cells = np.concatenate([[start], cells])
    return cells


def _paths(run: Run) -> tuple[TrialPath, ...]:
    state = run.state
    last = run.trial
    first = max(last - RECENT_PATHS, 0)
    lengths = state.log_steps[first:last].astype(np.int64)
    if first == 0 < last:
        # Pre-training is logged with the first trial, and is no part of its way.
        lengths[0] -= run.pretrained_steps
    ended_at = run.step - int(state.tally[TRIAL_STEP])
    paths: list[TrialPath] = []
    for back, length in enumerate(reversed(lengths.tolist())):
        if run.step - (ended_at - length) >= TRAIL_LENGTH:
            break
        trial = last - 1 - back
        start, heading = run.start_of(trial)
        steps = np.arange(ended_at - length + 1, ended_at + 1)
        cells = state.trail[steps % TRAIL_LENGTH].astype(np.int64)
        outcome = int(state.log_outcome[trial])
        paths.append(TrialPath(heading, outcome, np.concatenate([[start], cells])))
        ended_at -= length
    return tuple(reversed(paths))


def _ends(run: Run) -> tuple[TrialEnd, ...]:
    state = run.state
    trials = range(max(run.trial - RECENT_ENDS, 0), run.trial)
    return tuple(
        TrialEnd(
            trial=trial,
            cell=int(state.log_cell[trial]),
            heading=run.start_of(trial)[1],
            outcome=int(state.log_outcome[trial]),
        )
        for trial in trials
    )
