"""The bar as data: curves, bands, marks and lanes of a moment, along one axis.

Nothing here knows how it is drawn. Places are shares of the axis (:mod:`app.charts.bar.axis`), but
for blocks, which a hand may move along it: these are told in trials.
"""

from collections.abc import Sequence
from typing import Final, Literal, NamedTuple

import numpy as np

from app.analysis.estimates import Axis
from app.charts.bar.axis import TimeAxis, axis_of
from app.charts.bar.lanes import Lane, lanes_of
from app.charts.bar.marks import Mark, marks_of
from app.charts.bar.rule import Rule, rules_of
from app.live.places import Mark as Note
from app.live.snapshot import Snapshot, curve_window, curve_window_trials
from app.metrics.course import GREEDY_HUNTS, NO_CURVE, GreedyCurve
from app.schedule.blocks import FREEZES, NEVER, Block
from learners.measures import Curve, Progress

Held = Literal["forced", "taught", "frozen"]


class Ghost(NamedTuple):
    """Another run that stands behind this one, to be compared with it."""

    name: str
    """In a few words."""
    hint: str
    """Which run it is."""
    curve: Curve
    trial_curve: Curve
    progress: Progress


class Moment(NamedTuple):
    """All that a bar is made of."""

    snapshot: Snapshot
    blocks: tuple[Block, ...]
    left_out: int = 0
    """Blocks by hand that are over and not among these."""
    chosen: str = ""
    """Id of the block that stands out."""
    greedy: GreedyCurve = NO_CURVE
    ghost: Ghost | None = None
    notes: tuple[Note, ...] = ()
    """Marks with a text, of those that lie on this run."""


class View(NamedTuple):
    """A part of a run that is looked at by itself, against trials."""

    first: int
    end: int
    hides_after: int | None = None
    """The trial after which no reward is to be seen, be it known; None if all are."""


class Band(NamedTuple):
    """Where something is held from outside: forced exploration, teaching, or a freeze."""

    block: Block
    kind: Held


class Points(NamedTuple):
    """A curve."""

    at: np.ndarray
    """(point,) float64: places along the axis."""
    reward: np.ndarray
    """(point,) float64: per trial."""


class Bar(NamedTuple):
    """The whole of it."""

    axis: TimeAxis
    window: str
    """What each point of the learning curve is a mean over, in words."""
    rewards: tuple[float, float]
    """Ends of the axis of rewards."""
    learned: Points
    greedy: Points
    greedy_gaps: tuple[bool, ...]
    """Of each pair of neighbours of the greedy curve: whether they are far apart."""
    ghost: Points | None
    ghost_name: str
    ghost_hint: str
    rules: tuple[Rule, ...]
    bands: tuple[Band, ...]
    marks: tuple[Mark, ...]
    lanes: tuple[Lane, ...]
    left_out: int
    n_hunts: int = GREEDY_HUNTS


_NO_POINTS: Final = Points(np.zeros(0), np.zeros(0))


def bar_of(moment: Moment, unit: Axis, greedy_every: int, view: View | None = None) -> Bar:
    """The bar of a moment.

    Args:
        moment: the moment.
        unit: what its axis is of.
        greedy_every: trials after which greedy reward is measured as a rule; a line between two
            measurements that are more than twice as far apart says little.
        view: the part that is seen, without anything to compare it with; None for all of it.
    """
    snapshot, ghost = moment.snapshot, moment.ghost
    axis = axis_of(snapshot, unit)
    known = moment.greedy.step <= snapshot.step
    blocks, history, notes = moment.blocks, snapshot.control.history, moment.notes
    if view is not None:
        axis = axis._replace(start=float(view.first), end=float(view.end))
        ghost = None
        seen = moment.greedy.trial <= _last_of(view)
        known = known & seen & (moment.greedy.trial >= view.first)
        blocks = tuple(block for block in blocks if _is_in(block, view))
        history = tuple(event for event in history if view.first <= event.trial <= view.end)
        notes = tuple(note for note in notes if view.first <= note.trial <= view.end)
    trials = moment.greedy.trial[known]
    return Bar(
        axis=axis,
        window=_window(snapshot, unit),
        rewards=rewards_of(snapshot),
        learned=_within(learned_of(snapshot, axis), axis, view),
        greedy=Points(axis.of_steps(moment.greedy.step[known]), moment.greedy.reward[known]),
        greedy_gaps=tuple((np.diff(trials) > 2 * greedy_every).tolist()),
        ghost=None if ghost is None else ghost_of(ghost, axis),
        ghost_name="" if ghost is None else ghost.name,
        ghost_hint="" if ghost is None else ghost.hint,
        rules=rules_of(snapshot.watched, None if view is None else _last_of(view)),
        bands=bands_of(blocks),
        marks=marks_of(history, axis, notes),
        lanes=lanes_of(blocks, snapshot.spec.learner.skills, axis, moment.chosen),
        left_out=moment.left_out,
    )


def learned_of(snapshot: Snapshot, axis: TimeAxis) -> Points:
    """The learning curve, each point where its window ends; level over the whole of the first."""
    curve = snapshot.curve if axis.unit == "steps" else snapshot.trial_curve
    keep = np.isfinite(curve.reward)
    steps, reward = curve.steps[keep], curve.reward[keep]
    is_short = len(steps) > 2 and 2 * (steps[-1] - steps[-2]) < steps[1] - steps[0]
    if axis.unit == "steps" and is_short:
        # A window that has just begun may hold a single trial, and would end the curve in a spike.
        steps, reward = steps[:-1], reward[:-1]
    return _from_the_start(axis.along(steps), reward, axis)


def _is_in(block: Block, view: View) -> bool:
    """Whether a part of a block lies where it is looked; what is over by then does not."""
    return block.until is None or block.until > view.first


def _last_of(view: View) -> int:
    """The trial after which nothing of it is seen."""
    return view.end if view.hides_after is None else view.hides_after


def _within(points: Points, axis: TimeAxis, view: View | None) -> Points:
    """The part of a curve that is seen.

    It begins at the axis; what it ends with is a point that is known by then, for a place between
    two points would tell of the second one.
    """
    if view is None or not points.at.size:
        return points
    last = (_last_of(view) - axis.start) / (axis.end - axis.start)
    at, reward = points.at[points.at <= last], points.reward[points.at <= last]
    # The first point is at the beginning of the run, which is not after that of the axis.
    inside = at > 0.0
    level = float(np.interp(0.0, at, reward))
    return Points(np.append(0.0, at[inside]), np.append(level, reward[inside]))


def ghost_of(ghost: Ghost, axis: TimeAxis) -> Points:
    """The curve of a ghost by its own trials, or by its own steps, as far as the axis goes."""
    curve = ghost.curve if axis.unit == "steps" else ghost.trial_curve
    keep = np.isfinite(curve.reward)
    along = curve.steps[keep].astype(np.float64)
    if axis.unit == "trials":
        along = np.interp(along, ghost.progress.steps, ghost.progress.trials)
    is_there = along <= axis.end
    return _from_the_start(along[is_there] / axis.end, curve.reward[keep][is_there], axis)


def _from_the_start(at: np.ndarray, reward: np.ndarray, axis: TimeAxis) -> Points:
    """The curve from the beginning of the run on."""
    if not at.size:
        return _NO_POINTS
    first = -axis.start / (axis.end - axis.start)
    return Points(np.append(first, at), np.append(reward[0], reward))


def bands_of(blocks: Sequence[Block]) -> tuple[Band, ...]:
    """Where exploration is forced, a script teaches or something is frozen, or going to be."""
    bands: list[Band] = []
    for block in blocks:
        is_freeze = block.kind in (*FREEZES, "introduction")
        is_taught = block.kind == "teaching"
        is_held = is_freeze or is_taught or block.kind == "exploration"
        if block.first >= NEVER:
            continue
        if is_held and block.state != "idle" and block.until != block.first:
            kind: Held = "taught" if is_taught else "frozen" if is_freeze else "forced"
            bands.append(Band(block, kind))
    return tuple(bands)


def _window(snapshot: Snapshot, unit: Axis) -> str:
    if unit == "trials":
        return f"{curve_window_trials(snapshot.trial):,} trials"
    return f"the trials of {curve_window(snapshot.step):,} steps"


def rewards_of(snapshot: Snapshot) -> tuple[float, float]:
    """Ends of the axis of rewards: what a trial can come to."""
    world = snapshot.spec.world
    low, high = sorted((world.flight_reward, world.capture_reward))
    return min(low, 0.0), max(high, 1.0)
