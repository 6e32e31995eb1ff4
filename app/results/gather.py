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
from app.analysis.estimates import Axis, Band, Contrast, Estimate, Windows
from app.documents.experiments import Experiment
from app.experiments.archive import unpacked
from app.experiments.record import Record
from app.metrics import Metric, shown_first
from app.metrics.course import GreedyCurve
from app.results.horizon import Horizon, UpTo, of_shortest, up_to, with_values
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
    greedy: Sequence[GreedyCurve] = ()
    """Of each of its runs."""


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
    horizon: Horizon | None = None
    """Where the runs are compared, as far as they are over."""


_Compared = tuple[dict[int, float], dict[int, float]]
"""Values by seed of two variants, which their difference is of."""


@dataclass
class _Log:
    """What is kept of a variant's runs, in the order of their seeds.

    In whatever order they come, their intervals are then those that a report finds.
    """

    seeds: list[int]
    places: list[int]
    """Among all runs."""
    curves: Mapping[tuple[Axis, Windows], list[np.ndarray]]
    ends: list[np.ndarray]
    """Steps at which the windows of trials ended that are drawn against steps."""
    joined: list[dict[str, tuple[int, int]]]
    greedy: list[GreedyCurve]


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
        self._places = {v.label: place for place, v in enumerate(experiment.variants)}
        longest_trials = min(max(map(experiment.trials_of, experiment.variants)), longest_run)
        of_trials = estimates.window_width(longest_trials, _TRIALS_WINDOW, _WINDOWS)
        self._widths: Mapping[tuple[Axis, Windows], int] = {
            ("steps", "steps"): estimates.window_width(
                longest_run, measures.CURVE_WINDOW_STEPS, _WINDOWS
            ),
            ("steps", "trials"): min(of_trials, measures.CURVE_WINDOW_TRIALS),
            ("trials", "trials"): of_trials,
        }
        self._lock = threading.Lock()
        self._runs: list[PlacedRun] = []
        self._up_to: list[UpTo | None] = []
        """Of these runs, where they have values at a horizon that is not stated."""
        stated = experiment.horizon_steps
        self._metric = shown_first(experiment.metrics, experiment.horizon is not None)
        self._horizon = None if stated is None else Horizon(stated, is_stated=True)
        self._takes_shortest = stated is None and experiment.stop is None
        self._logs = [
            _Log([], [], {key: [] for key in self._widths}, [], [], []) for _ in self._places
        ]
        self._curves: dict[tuple[int, Axis, Windows], Curve] = {}
        self._estimates: dict[tuple[int, str], Estimate] = {}
        self._differences: dict[tuple[int, int, str], tuple[_Compared, Contrast]] = {}
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
                self._up_to.append(None)
            return
        found = unpacked(arrays, record.trials, record.steps)
        world = self._experiment.variants[place].spec.world
        reward = measures.rewards(world, found.outcome)
        windowed: dict[tuple[Axis, Windows], np.ndarray] = {
            (axis, windows): estimates.windowed(reward, found.steps, width, windows)
            for (axis, windows), width in self._widths.items()
        }
        ends = estimates.window_ends(found.steps, self._widths["steps", "trials"])
        known = up_to(reward, found.steps, record.steps) if self._takes_shortest else None
        with self._lock:
            log = self._logs[place]
            at = bisect(log.seeds, record.seed)
            log.seeds.insert(at, record.seed)
            log.places.insert(at, len(self._runs))
            for key, curve in windowed.items():
                log.curves[key].insert(at, curve)
            log.ends.insert(at, ends)
            log.joined.insert(at, found.joined)
            log.greedy.insert(at, found.greedy)
            if self._takes_shortest:
                # First of all, since this run has no values where longer ones were compared.
                self._compare_at_most_after(record.steps)
            self._up_to.append(known)
            self._runs.append((place, with_values(record, self._horizon, known)))

    def _compare_at_most_after(self, steps: int) -> None:
        """See to it that runs are compared where all have got to, by a run of so many steps."""
        found = of_shortest(steps)
        if found is None or (self._horizon is not None and self._horizon.steps <= found.steps):
            return
        self._horizon = found
        self._runs = [
            (place, with_values(run, found, known))
            for (place, run), known in zip(self._runs, self._up_to, strict=True)
        ]
        self._estimates.clear()

    def gathering(self) -> Gathering:
        """What there is."""
        with self._lock:
            runs, horizon = tuple(self._runs), self._horizon
        metric = self._metric.at(horizon.steps if horizon else None)
        return Gathering(self._experiment, metric, runs, *self._range, horizon)

    def width(self, axis: Axis, windows: Windows = "steps") -> int:
        """Steps or trials of a window of the curves; arguments as :meth:`curve` has them."""
        return self._widths[axis, windows if axis == "steps" else "trials"]

    def curve(self, variant: int, axis: Axis, windows: Windows = "steps") -> Curve:
        """The curve of a variant with its interval; found anew only if runs have come.

        Args:
            variant: its place in the experiment.
            axis: what the curve is drawn against.
            windows: what its windows are counted in, where that is steps.
        """
        windows = windows if axis == "steps" else "trials"
        with self._lock:
            log = self._logs[variant]
            curves, joined = tuple(log.curves[axis, windows]), tuple(log.joined)
            ends = tuple(log.ends) if (axis, windows) == ("steps", "trials") else None
            greedy = tuple(log.greedy)
            known = self._curves.get((variant, axis, windows))
        if known is not None and known.n == len(curves):
            return known
        width, rng = self._widths[axis, windows], estimates.bootstrap_rng()
        band = estimates.band(curves, width, rng, ends)
        moments = estimates.medians_of_all(joined)
        shared = [Moment(name, *at) for name, at in moments.items()]
        found = Curve(variant, len(curves), band, shared, greedy)
        with self._lock:
            self._curves[variant, axis, windows] = found
        return found

    def estimate(self, variant: int, metric: Metric | None = None) -> Estimate:
        """The mean of a metric of a variant, with its interval; of the one charted first if none
        is named."""
        column = (metric or self._metric).column
        with self._lock:
            horizon = self._horizon
            runs = [self._runs[place][1] for place in self._logs[variant].places]
            known = self._estimates.get((variant, column))
        values = [run.values[column] for run in runs]
        n = sum(not np.isnan(value) for value in values)
        if known is not None and known.n == n:
            return known
        found = estimates.mean(values, estimates.bootstrap_rng())
        with self._lock:
            # What was compared elsewhere in the meantime is found anew.
            if self._horizon == horizon:
                self._estimates[variant, column] = found
        return found

    def difference(self, variant: int, reference: int, metric: Metric) -> Contrast:
        """How much higher a metric is in one variant than in another, as a report finds it.

        Args:
            variant: its place in the experiment.
            reference: the place of the one that it is set against.
            metric: in which they are compared.
        """
        column = metric.column
        with self._lock:
            groups = [
                [self._runs[at][1] for at in self._logs[place].places]
                for place in (variant, reference)
            ]
            mine, theirs = ({run.seed: run.values[column] for run in group} for group in groups)
            key = variant, reference, column
            known_of, known = self._differences.get(key, (None, None))
        if known is not None and known_of == (mine, theirs):
            return known
        found = estimates.contrast([(1.0, mine), (-1.0, theirs)], estimates.bootstrap_rng())
        with self._lock:
            self._differences[key] = (mine, theirs), found
        return found


def _rewards(spec: RunSpec) -> tuple[float, float]:
    """The lowest and the highest mean reward there can be."""
    ends = (0.0, spec.world.flight_reward, spec.world.capture_reward)
    return min(ends), max(ends)
