"""Averages over seeds, and how sure they are. Pure: numbers in, numbers out.

Every interval is a percentile bootstrap over *runs*, which are independent of one another (the
trials of a run are not). The plain percentile interval is too narrow for few runs, so its level
is raised as Hesterberg proposes (2015, "What teachers should know about the bootstrap", the
expanded percentile interval): the tail is that of ``t * sqrt(n / (n - 1))`` under the normal
distribution. Of runs that are spread like a normal it then covers what it says from five on (below,
even the whole range of the data covers too little), but runs of learners that sometimes fail are
not: of a mixture of four good runs to one bad an interval from five runs covers two times in three.
So below ``LEAST_RUNS`` nothing is decided; whoever draws conclusions has to look at ``n``.
"""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cache
from typing import Any, Final, Literal, NamedTuple, get_args

import numpy as np

CONFIDENCE = 0.95
RESAMPLES = 4_999
"""Of every interval, wherever it is shown, so that page, report and files agree.

By them an end of an interval is known to within 1 % of its width (one standard error; with 999 it
is 2.3 %), and a curve of 50 windows over 30 runs takes 17 ms of a core of 2.6 GHz (3.5): eight of
them 0.14 s where all have new runs, in a thread that holds nobody up.
"""
LEAST_RUNS = 10
"""Runs below which no bootstrap interval can be relied on to be wide enough."""
LEAST_PAIRED = 0.5
"""Share of every group's runs that must have a partner for groups to be paired by seed."""
LEAST_SHARE = 0.5
"""Share of runs that must still go on for their average to be shown."""

PHASE_STEPS = 500_000
"""Window of the coarse learning curve by which learners are compared."""
PHASES: Mapping[str, int] = {"0–0.5 M": 0, "0.5–1 M": 1, "1–1.5 M": 2, "1.5–2 M": 3, "3.5–4 M": 7}
"""Those of its windows that are tabulated, by the steps that they are of: their places in it."""

_BOOTSTRAP_SEED = 20
_BATCH_NUMBERS = 4_000_000
"""Numbers that are resampled at a time: 32 MB."""

Axis = Literal["steps", "trials"]
Windows = Literal["steps", "trials"]
"""What the windows of a learning curve against steps are counted in. The thesis's are consecutive
trials (section 4.1.2): where trials are short for a while, a window of steps holds very many of
them, and what happened in that while is averaged away. Against trials, windows are of trials."""
WINDOWS: Final[tuple[Windows, ...]] = get_args(Windows)


class Estimate(NamedTuple):
    """A quantity of a population of runs, from a few of them."""

    value: float
    low: float
    """Lower end of the interval; NaN where there is none."""
    high: float
    n: int
    """Runs, or pairs of runs, that it rests on."""

    @property
    def has_interval(self) -> bool:
        """Whether it rests on more than a single run."""
        return not math.isnan(self.low)

    @property
    def excludes_zero(self) -> bool:
        """Whether the whole interval lies on one side of 0; without one, it does not."""
        return self.low > 0 or self.high < 0


class Band(NamedTuple):
    """A curve averaged over runs, with its pointwise interval."""

    start: np.ndarray
    """(window,) int64: first step or trial of each window, from 0."""
    end: np.ndarray
    """(window,) int64: the one after its last."""
    mean: np.ndarray
    """(window,) float64."""
    low: np.ndarray
    high: np.ndarray
    n: np.ndarray
    """(window,) int64: runs that the mean is over."""
    is_at_end: bool = False
    """Whether a window's mean belongs where it ended, as that of trials against steps does."""

    @property
    def columns(self) -> tuple[np.ndarray, ...]:
        """All arrays, in their order."""
        return self.start, self.end, self.mean, self.low, self.high, self.n

    @property
    def at(self) -> np.ndarray:
        """Where a window's mean belongs on the axis, (window,) float64."""
        return self.end.astype(np.float64) if self.is_at_end else (self.start + self.end) / 2


class Contrast(NamedTuple):
    """A weighted sum of several groups of runs, each taken as its mean or its middle half."""

    estimate: Estimate
    paired: bool
    """Whether runs were paired by seed, and not resampled group by group."""
    error: float = math.nan
    """Standard error of a sum of means; NaN where there is none, as below two runs."""
    freedom: float = math.nan
    """Degrees of freedom of that error."""


class Comparison(NamedTuple):
    """How much larger one group of runs is than another."""

    difference: Estimate
    improvement: Estimate
    """Chance that a run of the first exceeds one of the second, ties counted half."""
    paired: bool


# --- The bootstrap -------------------------------------------------------------------------------


def bootstrap_rng() -> np.random.Generator:
    """A generator for one interval, so that no interval depends on which came before it."""
    return np.random.default_rng(_BOOTSTRAP_SEED)


@cache
def expanded_level(n: int) -> float:
    """Level of the percentile interval that covers ``CONFIDENCE`` with ``n`` runs."""
    from scipy import stats

    tail = (1 - CONFIDENCE) / 2
    quantile = stats.t.ppf(tail, n - 1) * math.sqrt(n / (n - 1))
    return 1 - 2 * float(stats.norm.cdf(quantile))


def _interval(
    samples: Sequence[np.ndarray],
    statistic: Callable[..., Any],
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray]:
    """Interval of a statistic of samples with runs along their first axis; NaN below two runs.

    The columns of a sample are resampled together, as they are columns of the same runs.
    """
    from scipy import stats

    fewest = min(sample.shape[0] for sample in samples)
    if fewest < 2:
        nothing = np.full(samples[0].shape[1:], np.nan)
        return nothing, nothing
    size = max(sample.size for sample in samples)
    found = stats.bootstrap(
        tuple(samples),
        statistic,
        n_resamples=RESAMPLES,
        batch=max(1, _BATCH_NUMBERS // size),
        vectorized=True,
        axis=0,
        confidence_level=expanded_level(fewest),
        method="percentile",
        rng=rng,
    ).confidence_interval
    return found.low, found.high


def _estimate(
    values: Sequence[float],
    statistic: Callable[..., Any],
    rng: np.random.Generator,
) -> Estimate:
    there = np.asarray([value for value in values if not math.isnan(value)], np.float64)
    if not there.size:
        return Estimate(math.nan, math.nan, math.nan, 0)
    low, high = _interval([there], statistic, rng)
    return Estimate(float(statistic(there, axis=0)), float(low), float(high), there.size)


# --- Scalars -------------------------------------------------------------------------------------


def mean(values: Sequence[float], rng: np.random.Generator) -> Estimate:
    """Mean over runs; those without a value (NaN) are left out, and ``n`` says so."""
    return _estimate(values, np.mean, rng)


def average(values: np.ndarray) -> float:
    """Mean of numbers of one run; NaN where there are none."""
    return float(values.mean()) if values.size else math.nan


def interquartile_mean(values: Sequence[float], rng: np.random.Generator) -> Estimate:
    """Mean of the middle half of the runs: hardly moved by a few wild ones."""
    return _estimate(values, _middle_half, rng)


def _middle_half(values: np.ndarray, axis: int) -> Any:
    # A page takes it of thousands of resamples hundreds of times, and sorting them is an order of
    # magnitude faster than what scipy's trimmed mean does.
    n = values.shape[axis]
    middle = np.take(np.sort(values, axis=axis), range(n // 4, n - n // 4), axis=axis)
    return middle.mean(axis=axis)


def medians_of_all(
    moments: Sequence[Mapping[str, tuple[int, int]]],
) -> dict[str, tuple[float, float]]:
    """Medians over runs of two numbers that go by a name, of the names that every run has."""
    names = dict.fromkeys(name for run in moments for name in run)
    return {
        name: (
            float(np.median([run[name][0] for run in moments])),
            float(np.median([run[name][1] for run in moments])),
        )
        for name in names
        if all(name in run for run in moments)
    }


# --- Comparisons ---------------------------------------------------------------------------------

Term = tuple[float, Mapping[int, float]]
"""A weight, and the values of a group of runs by seed."""


def pairing(groups: Sequence[Collection[int]]) -> list[int]:
    """Seeds that groups are paired by, in order; none where they are taken group by group.

    Runs of the same seed share their trial starts, so their differences vary less. But what has no
    partner is left out of pairs, so groups are paired only where each of them has a partner for at
    least ``LEAST_PAIRED`` of its runs, and where there are two pairs or more: 120 runs set against
    30 of the same seeds are 120 runs.

    Args:
        groups: seeds of the runs of each.
    """
    shared = [seed for seed in sorted(groups[0]) if all(seed in group for group in groups)]
    fewest = max(2.0, LEAST_PAIRED * max(map(len, groups)))
    return shared if len(shared) >= fewest else []


def contrast(terms: Sequence[Term], rng: np.random.Generator) -> Contrast:
    """Weighted sum of group means: by seed where groups can be paired, else group by group.

    The standard error is that of the sums by seed, or else Welch's, with the degrees of freedom of
    Welch and Satterthwaite: of parts ``v = w ** 2 * variance / n`` it is the root of their sum,
    and these are ``sum(v) ** 2 / sum(v ** 2 / (n - 1))``.
    """
    found = _contrast(terms, np.mean, rng)
    by_seed = weighted_by_seed(terms)
    groups = [(1.0, by_seed)] if by_seed else [(w, [*known(by).values()]) for w, by in terms]
    if found.estimate.n < 2:
        return found
    parts = [
        (weight**2 * np.var(values, ddof=1) / len(values), len(values)) for weight, values in groups
    ]
    total = sum(part for part, _ in parts)
    squares = sum(part**2 / (n - 1) for part, n in parts)
    freedom = total**2 / squares if squares else min(n for _, n in parts) - 1
    return found._replace(error=math.sqrt(total), freedom=float(freedom))


def weighted_by_seed(terms: Sequence[Term]) -> list[float]:
    """The weighted sum of the values of each seed that groups are paired by; none where not."""
    groups = [(weight, known(values)) for weight, values in terms]
    seeds = pairing([values for _, values in groups])
    return [sum(weight * values[seed] for weight, values in groups) for seed in seeds]


def _contrast(
    terms: Sequence[Term], statistic: Callable[..., Any], rng: np.random.Generator
) -> Contrast:
    """A statistic of the weighted sums by seed, or else the weighted sum of it over groups."""
    by_seed = weighted_by_seed(terms)
    if by_seed:
        return Contrast(_estimate(by_seed, statistic, rng), paired=True)
    groups = [(weight, known(values)) for weight, values in terms]
    weights = [weight for weight, _ in groups]
    samples = [np.asarray(list(values.values()), np.float64) for _, values in groups]
    fewest = min(sample.size for sample in samples)
    if not fewest:
        return Contrast(Estimate(math.nan, math.nan, math.nan, 0), paired=False)

    def weighted(*samples: np.ndarray, axis: int) -> Any:
        found = (statistic(sample, axis=axis) for sample in samples)
        return sum(weight * value for weight, value in zip(weights, found, strict=True))

    low, high = _interval(samples, weighted, rng)
    value = float(weighted(*samples, axis=0))
    return Contrast(Estimate(value, float(low), float(high), fewest), paired=False)


def compare(
    first: Mapping[int, float], second: Mapping[int, float], rng: np.random.Generator
) -> Comparison:
    """How much larger the first group is than the second; values are by seed."""
    found = contrast([(1.0, first), (-1.0, second)], rng)
    mine, theirs = known(first), known(second)
    seeds = pairing([mine, theirs]) if mine and theirs else []
    scores = scored(
        np.asarray([mine[seed] for seed in seeds or mine]),
        np.asarray([theirs[seed] for seed in seeds or theirs]),
    )
    chance = improvement(scores.diagonal() if seeds else scores, rng)
    return Comparison(found.estimate, chance, found.paired)


def interquartile_difference(
    first: Mapping[int, float], second: Mapping[int, float], rng: np.random.Generator
) -> Estimate:
    """Mean of the middle half of the differences by seed; values are by seed.

    Where they are not paired, the difference of the means of both middle halves.
    """
    return _contrast([(1.0, first), (-1.0, second)], _middle_half, rng).estimate


def scored(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Which runs of two groups have more, ``(first, second) float64``: 1 if the first's, ties 0.5.

    Args:
        first: (first,) values of runs.
        second: (second,) values of runs.
    """
    mine, theirs = first[:, np.newaxis], second[np.newaxis]
    return (mine > theirs) + (mine == theirs) / 2


def improvement(scores: np.ndarray, rng: np.random.Generator) -> Estimate:
    """Chance that a run of the first of two groups has more, with its interval.

    The bootstrap is over runs: over pairs, or over both groups. Where every run of one group
    has more than every one it meets, there is nothing to resample, and the interval is the exact
    one of as many pairs without exception: the tail is p to the power of n.

    Args:
        scores: (pair,) of pairs of runs, or (first, second) of any run with any other.
    """
    n = min(scores.shape)
    if not n:
        return Estimate(math.nan, math.nan, math.nan, 0)
    value = float(scores.mean())
    least = ((1 - CONFIDENCE) / 2) ** (1 / n)
    if n > 1 and value in (0.0, 1.0):
        return Estimate(value, least if value else 0.0, 1.0 if value else 1 - least, n)
    if scores.ndim == 1:
        low, high = _interval([scores], np.mean, rng)
    else:

        def mean(first: np.ndarray, second: np.ndarray, axis: int) -> Any:
            del axis  # Always the last one.
            mine, theirs = (
                _times_drawn(drawn, size)
                for drawn, size in zip((first, second), scores.shape, strict=True)
            )
            return np.einsum("...i,ij,...j->...", mine, scores, theirs) / scores.size

        low, high = _interval([*map(np.arange, scores.shape)], mean, rng)
    return Estimate(value, float(low), float(high), n)


def _times_drawn(drawn: np.ndarray, size: int) -> np.ndarray:
    """How often each of so many rows was drawn, ``(..., row)``; draws are along the last axis."""
    flat = drawn.reshape(-1, drawn.shape[-1])
    numbered = flat + size * np.arange(len(flat))[:, np.newaxis]
    counts = np.bincount(numbered.ravel(), minlength=size * len(flat))
    return counts.reshape(*drawn.shape[:-1], size)


def known(values: Mapping[int, float]) -> dict[int, float]:
    """Values by seed, without those that are none."""
    return {seed: value for seed, value in values.items() if not math.isnan(value)}


# --- Curves --------------------------------------------------------------------------------------


def windowed(reward: np.ndarray, steps: np.ndarray, width: int, axis: Axis) -> np.ndarray:
    """Mean reward of the trials that ended in each window, ``(window,) float64``.

    Only windows that the run went through wholly are there, so a run that ended in the middle of
    one says nothing about it. NaN where no trial ended.

    Args:
        reward: (trial,) of each trial.
        steps: (trial,) that each trial took.
        width: of a window, in steps or trials.
        axis: what windows are counted in.
    """
    ends = np.cumsum(steps, dtype=np.int64) if axis == "steps" else np.arange(1, reward.size + 1)
    if not ends.size:
        return np.zeros(0)
    n_windows = int(ends[-1]) // width
    window = (ends - 1) // width
    whole = window < n_windows
    count = np.bincount(window[whole], minlength=n_windows)
    total = np.bincount(window[whole], reward[whole], minlength=n_windows)
    return np.divide(total, count, out=np.full(n_windows, np.nan), where=count > 0)


def window_ends(steps: np.ndarray, width: int) -> np.ndarray:
    """Steps at which windows of so many consecutive trials ended, ``(window,) int64``.

    Args:
        steps: (trial,) that each trial took.
        width: of a window, in trials.
    """
    return np.cumsum(steps, dtype=np.int64)[width - 1 :: width]


def band(
    curves: Sequence[np.ndarray],
    width: int,
    rng: np.random.Generator,
    ends: Sequence[np.ndarray] | None = None,
) -> Band:
    """Average of the curves of several runs, aligned at their first window.

    In each window the mean is over the runs that went through it, and ``n`` says how many those
    are; the curve is cut where fewer than ``LEAST_SHARE`` of the runs are left. Nothing is
    extrapolated.

    Args:
        curves: (window,) of each run.
        width: of a window, on the axis.
        rng: of the bootstrap.
        ends: (window,) of each run: steps at which its windows ended, where these are of trials and
            the axis is of steps; each is then placed at the mean over runs, and has no one width.
    """
    longest = max((curve.size for curve in curves), default=0)
    values = np.full((len(curves), longest), np.nan)
    for row, curve in zip(values, curves, strict=True):
        row[: curve.size] = curve
    lengths = np.asarray([curve.size for curve in curves])
    going = (lengths[:, np.newaxis] > np.arange(longest)).sum(axis=0)
    n_windows = int((going >= LEAST_SHARE * len(curves)).sum())
    values = values[:, :n_windows]
    averages, low, high = _averages(values, rng)
    counts = np.isfinite(values).sum(axis=0)
    if ends is None:
        start = np.arange(n_windows, dtype=np.int64) * width
        return Band(start, start + width, averages, low, high, counts)
    reached = np.full((len(ends), longest), np.nan)
    for row, of_run in zip(reached, ends, strict=True):
        row[: of_run.size] = of_run
    end = np.zeros(n_windows, np.int64)
    np.rint(np.nanmean(reached[:, :n_windows], axis=0), out=end, casting="unsafe")
    start = np.zeros(n_windows, np.int64)
    start[1:] = end[:-1]
    return Band(start, end, averages, low, high, counts, is_at_end=True)


def _averages(
    values: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean and interval of each column over the rows that have a value in it."""
    out = np.full((3, values.shape[1]), np.nan)
    there = np.isfinite(values)
    # Neighbouring windows are mostly over the same runs, and are resampled together.
    changes = np.flatnonzero((there[:, 1:] != there[:, :-1]).any(axis=0)) + 1
    for columns in np.split(np.arange(values.shape[1]), changes):
        rows = there[:, columns[0]] if columns.size else np.zeros(0, bool)
        if rows.any():
            sample = values[np.ix_(rows, columns)]
            out[0, columns] = sample.mean(axis=0)
            out[1, columns], out[2, columns] = _interval([sample], np.mean, rng)
    return out[0], out[1], out[2]


def window_width(longest: int, widest: int, fewest_windows: int = 40) -> int:
    """A round width (1, 2 or 5 times a power of ten) that divides a run into enough windows."""
    wanted = max(longest / fewest_windows, 1.0)
    power = 10 ** math.floor(math.log10(wanted))
    width = max(factor * power for factor in (1, 2, 5) if factor * power <= wanted)
    return min(int(width), widest)
