"""What a lesson can measure of a run, at one of its moments.

A :class:`View` is all that there is to measure: the run's values and log, and what people did since
the card was entered. It is made of a run (:func:`view_of_run`), or of what is looked at in a
session (:func:`view_of`), and what is measured of both is the same where the moments are.
:data:`MEASURES` is the closed list, by the names that :mod:`app.documents.lesson_grammar` allows.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final, NamedTuple, TypeAlias

import numpy as np

from app.documents.lesson_grammar import (
    COMMANDS,
    DIRECTIONS,
    EACH_OCTANT,
    MEASURE_NAMES,
    OCTANTS,
    OfExperiment,
    Opened,
    Reading,
    Window,
)
from app.explain.shape import shape_of
from app.lessons import regions
from app.live.past import Past
from app.live.snapshot import Snapshot
from learners import commands as given
from learners.checkpoints import Logs, logs_of
from learners.control import Control
from learners.kernel.state import TRIAL_STEP, value_of
from learners.measures import RECENT_TRIALS
from learners.run import Run
from learners.spec import RunSpec
from sim.world import CAPTURE

LEADER_STEPS: Final = 250_000
"""Steps by whose trials it is said which of several runs leads."""
SPREAD_SHARE: Final = 0.25
"""Of the states of a flank: where more have a value, value has spread there; it is the bound of the
findings for what has not been reached."""

Found: TypeAlias = float | int | str | bool | Mapping[str, float] | None
"""What a measure finds: a number, a word, whether something is so, or numbers by name; None where
there is nothing to measure yet."""


# --- What people did -----------------------------------------------------------------------------


class Done(NamedTuple):
    """Something that somebody did."""

    what: str
    """A command of ``app.documents.lesson_grammar.DEEDS``."""
    step: int
    """Of the run that the lesson is about, when it was done."""


class Looked(NamedTuple):
    """Something that somebody opened; a place lies in every region that its reading belongs to."""

    opened: Opened
    step: int
    """Of the run that the lesson is about, when it was opened."""


class Racing(NamedTuple):
    """One of several runs side by side, as far as it has come."""

    name: str
    """Of its entry; for a preset, that of the preset."""
    reward: np.ndarray
    """(trial,) float64: of the trials that have ended."""
    ends: np.ndarray
    """(trial,) int64: steps made when each had ended."""
    step: int
    """Steps made so far."""
    is_over: bool
    """Whether it makes no more."""


Columns: TypeAlias = Mapping[str, Sequence[float]]
"""Values of the runs that are over, by the column of the table of results."""


@dataclass(frozen=True, eq=False)
class Deeds:
    """What was done since a card was entered, and what there is beside the run."""

    done: tuple[Done, ...] = ()
    opened: tuple[Looked, ...] = ()
    race: tuple[Racing, ...] = ()
    """The runs that are side by side; none if there are none."""
    divergence: int | None = None
    """Trial in which the first two of them part; None if they do not, or nobody looked."""
    experiments: Mapping[str, Mapping[str, Columns]] = field(
        default_factory=dict[str, Mapping[str, Columns]]
    )
    """Results by experiment and variant."""


NO_DEEDS: Final = Deeds()


# --- What there is to measure --------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class View:
    """One moment of a run. Arrays are not to be written to."""

    spec: RunSpec
    """The preset as commands have changed it."""
    control: Control
    step: int
    trial: int
    trial_step: int
    """Steps made in the running trial."""
    value: np.ndarray
    """(heading, distance, direction) float32: the largest of the present options' values."""
    logs: Logs
    """Of the trials that have ended, and perhaps of later ones."""
    deeds: Deeds
    since: int = 0
    """Trial in which the card was entered."""
    since_step: int = 0
    """Step at which it was."""
    since_event: int = 0
    """Events there had been by then."""

    @cached_property
    def share(self) -> np.ndarray:
        """(distance, direction) float64: share of the headings, turned, whose value is above 0."""
        return regions.share(self.value)

    @property
    def outcome(self) -> np.ndarray:
        """(trial,) int8: how each trial ended, of those that have."""
        return self.logs.log_outcome[: self.trial]

    @property
    def reward(self) -> np.ndarray:
        """(trial,) float64: reward of each trial, of those that have ended."""
        return self.logs.log_reward[: self.trial]


class Began(NamedTuple):
    """Where a card was entered."""

    trial: int
    step: int
    events: int = 0
    """That the history of the run had by then."""


AT_START: Final = Began(0, 0, 0)


def began_at(run: Run) -> Began:
    """Where a card is entered that is entered now."""
    return Began(run.trial, run.step, len(run.control.history))


def view_of_run(run: Run, deeds: Deeds = NO_DEEDS, began: Began = AT_START) -> View:
    """What there is to measure of a run as it stands; its tables are copied, its logs are not."""
    value = value_of(run.spec, run.state)
    logs = logs_of(run.state)
    made = int(run.state.tally[TRIAL_STEP])
    return View(run.spec, run.control, run.step, run.trial, made, value, logs, deeds, *began)


def view_of(
    snapshot: Snapshot, past: Past, deeds: Deeds = NO_DEEDS, began: Began = AT_START
) -> View:
    """The same of a moment of a session.

    Args:
        snapshot: the moment.
        past: of the line that the moment is of.
        deeds: what was done by then.
        began: where the card was entered.
    """
    return View(
        snapshot.spec,
        snapshot.control,
        snapshot.step,
        snapshot.trial,
        snapshot.trial_step,
        snapshot.value,
        past.logs,
        deeds,
        *began,
    )


# --- Measures ------------------------------------------------------------------------------------


def _of(name: str) -> Callable[[View, Any], Found]:
    return lambda view, _: getattr(view, name)


def _present(view: View, skill: str) -> bool:
    return skill in view.control.present


def _value_states(view: View, _: None) -> int:
    return int(np.count_nonzero(view.value > 0))


def _behind_share(view: View, _: None) -> float | None:
    total = float(view.share.sum())
    behind = regions.masks(view.spec.world)["behind"]
    return float(view.share[behind].sum()) / total if total else None


def _reach(view: View, region: str) -> float | Mapping[str, float] | None:
    if region == EACH_OCTANT:
        found = {octant: _reach_of(view, octant) for octant in OCTANTS}
        return {octant: share for octant, share in found.items() if share is not None}
    return _reach_of(view, region)


def _reach_of(view: View, region: str) -> float | None:
    mask = regions.masks(view.spec.world)[region]
    return float(view.share[mask].mean()) if mask.any() else None


def _thinnest(view: View, _: None) -> float:
    return float(view.share[regions.ring(view.spec.world)].mean(axis=0).min())


def _spread_direction(view: View, _: None) -> str | None:
    left, right = _reach_of(view, "left_flank"), _reach_of(view, "right_flank")
    if left is None or right is None:
        return None
    clockwise, counter_clockwise, both, neither = DIRECTIONS
    # From behind the prey, counter-clockwise comes to its right first.
    match left > SPREAD_SHARE, right > SPREAD_SHARE:
        case True, True:
            return both
        case True, False:
            return clockwise
        case False, True:
            return counter_clockwise
        case _:
            return neither


def _shape(view: View, _: None) -> str:
    return shape_of(view.spec.world, view.value)


def _reward(view: View, window: Window) -> float | None:
    if window.last is not None:
        trials = view.reward[-window.last :]
    elif view.trial >= window.end:
        trials = view.reward[window.first : window.end]
    else:
        return None
    return float(trials.mean()) if trials.size else None


def _change(view: View, windows: tuple[Window, Window]) -> float | None:
    before, after = (_reward(view, window) for window in windows)
    return None if before is None or after is None else after - before


def _captures(view: View, _: None) -> int:
    return int(np.count_nonzero(view.outcome[view.since :] == CAPTURE))


def _success(view: View, _: None) -> float | None:
    recent = view.outcome[-RECENT_TRIALS:]
    return float((recent == CAPTURE).mean()) if recent.size else None


def _leader(view: View, steps: int) -> str | None:
    race = view.deeds.race
    if not race or not all(runner.step >= steps or runner.is_over for runner in race):
        return None
    return max(race, key=lambda runner: _lead(runner, steps)).name


def _lead(runner: Racing, steps: int) -> float:
    """Mean reward of the trials that ended in the last steps up to some, or to where it is over."""
    until = min(steps, runner.step)
    ends = runner.ends
    first, end = np.searchsorted(ends, [until - LEADER_STEPS, until], side="right")
    return float(runner.reward[first:end].mean()) if end > first else -math.inf


def _divergence(view: View, _: None) -> int | None:
    return view.deeds.divergence


_GIVEN: Final[Mapping[str, type[given.Command]]] = {
    "introduce": given.Introduce,
    "explore": given.Explore,
    "stop_exploring": given.StopExploring,
    "freeze_selection": given.FreezeSelection,
    "freeze_skills": given.FreezeSkills,
    "follow_schedule": given.FollowSchedule,
    "remove": given.Remove,
}
assert _GIVEN.keys() == set(COMMANDS)


def _command(view: View, name: str) -> bool:
    kind = _GIVEN.get(name)
    if kind is None:
        return any(done.what == name and done.step <= view.step for done in view.deeds.done)
    return any(
        isinstance(event.command, kind) and event.author == "hand" and not event.undone
        for event in view.control.history[view.since_event :]
    )


def _opened(view: View, what: Opened) -> bool:
    return any(looked.opened == what and looked.step <= view.step for looked in view.deeds.opened)


def _experiment(view: View, of: OfExperiment) -> float | Mapping[str, float] | None:
    variants = view.deeds.experiments.get(of.name, {})
    means = {
        label: float(np.mean(columns[of.quantity]))
        for label, columns in variants.items()
        if len(columns.get(of.quantity, ()))
    }
    if of.variant is None:
        return means
    found, other = means.get(of.variant), means.get(of.against or "")
    if of.against is None or found is None:
        return found
    return None if other is None else found - other


class Measure(NamedTuple):
    """One thing that can be measured."""

    title: str
    """In plain words, as in "the share of ...": what it is."""
    unit: str
    """"" where it has none; "%" of a share, which is shown as so many of a hundred."""
    of: Callable[[View, Any], Found]
    """Finds it in a view; the other argument is what it is of (``Reading.args``)."""
    grows: bool = False
    """Whether it never becomes less in the course of a run."""


MEASURES: Final[Mapping[str, Measure]] = {
    "trial": Measure("the running trial", "trials", _of("trial"), grows=True),
    "step": Measure("steps made", "steps", _of("step"), grows=True),
    "present": Measure("whether a skill has joined", "", _present),
    "value_states": Measure("places that have a value", "places", _value_states),
    "behind_share": Measure(
        "the share of the places with a value that lie behind the prey", "%", _behind_share
    ),
    "reach": Measure("the share of a region that has a value", "%", _reach),
    "thinnest": Measure(
        "the share that has a value where the ring round the prey is thinnest", "%", _thinnest
    ),
    "spread_direction": Measure("the way value has spread", "", _spread_direction),
    "shape": Measure("the shape of the places that have a value", "", _shape),
    "reward": Measure("the mean reward of some trials", "reward per trial", _reward),
    "change": Measure("the change of the mean reward", "reward per trial", _change),
    "captures": Measure("catches since the card", "catches", _captures, grows=True),
    "success": Measure("the share of the last 500 trials that ended in a catch", "%", _success),
    "leader": Measure("the run that leads", "", _leader),
    "first_divergence": Measure("the trial in which two runs part", "trials", _divergence),
    "command": Measure("whether something was done", "", _command),
    "opened": Measure("whether something was opened", "", _opened),
    "experiment": Measure("the mean over an experiment's runs", "", _experiment),
}
"""All measures, by their names."""
assert tuple(sorted(MEASURES)) == tuple(sorted(MEASURE_NAMES))


def measured(reading: Reading, view: View) -> Found:
    """What a measure finds in a view."""
    return MEASURES[reading.name].of(view, reading.args)


def is_settled(reading: Reading, view: View) -> bool:
    """Whether it will find the same in every later moment of this run, whatever is done.

    Of one that grows, :mod:`app.lessons.checks` knows by what it is held against. A command can be
    taken back, and another race begun, so these are never settled.
    """
    match reading.name:
        case "reward":
            return _is_past(view, reading.args)
        case "change":
            return all(_is_past(view, window) for window in reading.args)
        case "command":
            return reading.args not in COMMANDS and _command(view, reading.args)
        case "opened":
            return _opened(view, reading.args)
        case _:
            return False


def _is_past(view: View, window: Window) -> bool:
    return window.last is None and view.trial >= window.end
