"""What the page knows of an experiment: the record of every run, and curves of variants.

Runs are added as they are over; a :class:`Gathering` is what there is at a moment. Averages and
intervals are found when somebody wants to see them, and then only for what has changed.
"""

import threading
from bisect import bisect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from app.analysis import estimates
from app.analysis.estimates import Axis, Band, Estimate
from app.documents.experiments import Experiment
from app.experiments.archive import unpacked
from app.experiments.record import Record
from app.metrics import Metric, shown_first
from learners import measures
from learners.spec import RunSpec

MOST_CURVES: Final = 8
"""Variants whose curves are drawn together."""

_WINDOWS: Final = 50
_TRIALS_WINDOW: Final = 2_000

PlacedRun = tuple[int, Record]
"""A run that is over, after the place of its variant in the experiment."""


class Moment(NamedTuple):
    """When a skill joined, the median over the runs of a variant."""

    skill: str
    trial: float
    step: float


class Curve(NamedTuple):
    """The learning curve of a variant."""

    variant: int
    n: int
    """Runs it is from."""
    band: Band
    joined: Sequence[Moment]
    """Skills that joined after the start, in all of its runs."""


@dataclass(frozen=True)
class Gathering:
    """What there is at a moment."""

    experiment: Experiment
    metric: Metric
    runs: Sequence[PlacedRun]
    """In the order in which they came."""
    low: float
    """The lowest mean reward there can be, and the highest."""
    high: float


@dataclass
class _Log:
    """What is kept of a variant's runs, in the order of their seeds.

    In whatever order they come, their intervals are then those that a report finds.
    """

    seeds: list[int]
    curves: Mapping[Axis, list[np.ndarray]]
    joined: list[dict[str, tuple[int, int]]]
    values: list[Mapping[str, float]]
    """Of each run, by the column of a metric."""


class Gatherer:
    """Takes runs in, from one thread, and gives averages out, to any."""

    def __init__(self, experiment: Experiment, longest_run: int) -> None:
        """Prepare.

        Args:
            experiment: whose runs it takes in.
            longest_run: steps that the longest of them may take, roughly; curves have windows that
                suit it.
        """
        self._experiment = experiment
        self._metric = shown_first(experiment.metrics)
        self._places = {v.label: place for place, v in enumerate(experiment.variants)}
        longest_trials = min(max(map(experiment.trials_of, experiment.variants)), longest_run)
        self._widths: Mapping[Axis, int] = {
            "steps": estimates.window_width(longest_run, measures.CURVE_WINDOW_STEPS, _WINDOWS),
            "trials": estimates.window_width(longest_trials, _TRIALS_WINDOW, _WINDOWS),
        }
        self._lock = threading.Lock()
        self._runs: list[PlacedRun] = []
        self._logs = [_Log([], {"steps": [], "trials": []}, [], []) for _ in experiment.variants]
        self._curves: dict[tuple[int, Axis], Curve] = {}
        self._estimates: dict[tuple[int, str], Estimate] = {}
        rewards = [_rewards(v.spec) for v in experiment.variants]
        self._range = min(low for low, _ in rewards), max(high for _, high in rewards)

    def add(self, record: Record, arrays: bytes) -> None:
        """Take in a run that is over, with the archive of its arrays, empty if it has failed.

        Raises:
            ArchiveError: these cannot be read; nothing was taken in.
        """
        place = self._places[record.variant]
        if record.error:
            with self._lock:
                self._runs.append((place, record))
            return
        found = unpacked(arrays, record.trials, record.steps)
        world = self._experiment.variants[place].spec.world
        reward = measures.rewards(world, found.outcome)
        windowed: dict[Axis, np.ndarray] = {
            axis: estimates.windowed(reward, found.steps, width, axis)
            for axis, width in self._widths.items()
        }
        with self._lock:
            self._runs.append((place, record))
            log = self._logs[place]
            at = bisect(log.seeds, record.seed)
            log.seeds.insert(at, record.seed)
            for axis, curve in windowed.items():
                log.curves[axis].insert(at, curve)
            log.joined.insert(at, found.joined)
            log.values.insert(at, record.values)

    def gathering(self) -> Gathering:
        """What there is."""
        with self._lock:
            runs = tuple(self._runs)
        return Gathering(self._experiment, self._metric, runs, *self._range)

    def curve(self, variant: int, axis: Axis) -> Curve:
        """The curve of a variant with its interval; found anew only if runs have come."""
        with self._lock:
            log = self._logs[variant]
            curves, joined = tuple(log.curves[axis]), tuple(log.joined)
            known = self._curves.get((variant, axis))
        if known is not None and known.n == len(curves):
            return known
        band = estimates.band(curves, self._widths[axis], estimates.bootstrap_rng())
        moments = estimates.medians_of_all(joined)
        shared = [Moment(name, *at) for name, at in moments.items()]
        found = Curve(variant, len(curves), band, shared)
        with self._lock:
            self._curves[variant, axis] = found
        return found

    def estimate(self, variant: int, metric: Metric | None = None) -> Estimate:
        """The mean of a metric of a variant, with its interval; of the one charted first if none
        is named."""
        column = (metric or self._metric).column
        with self._lock:
            values = [values[column] for values in self._logs[variant].values]
            known = self._estimates.get((variant, column))
        n = sum(not np.isnan(value) for value in values)
        if known is not None and known.n == n:
            return known
        found = estimates.mean(values, estimates.bootstrap_rng())
        with self._lock:
            self._estimates[variant, column] = found
        return found


def _rewards(spec: RunSpec) -> tuple[float, float]:
    """The lowest and the highest mean reward there can be."""
    ends = (0.0, spec.world.flight_reward, spec.world.capture_reward)
    return min(ends), max(ends)
