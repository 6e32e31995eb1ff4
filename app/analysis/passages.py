"""After how many steps runs got somewhere, those that ended before they did among them.

A run that ended without having got there says only that it would have taken more steps than it had
(it is *censored*): neither "never", since others may have had more steps, nor nothing. The
share of runs that have got there is estimated as Kaplan and Meier do (1958); its interval is that
of Greenwood's variance on the scale of log(-log) (Kalbfleisch and Prentice 2002), pointwise, and
the interval of the median is where this band crosses one half (Brookmeyer and Crowley 1982).
"""

import math
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from app.analysis import estimates
from app.analysis.estimates import CONFIDENCE, Comparison, Estimate

_ROUNDING = 1e-9
"""By which a product of shares may miss one half."""


class Passage(NamedTuple):
    """What a run says of how many steps it takes to get somewhere."""

    steps: float
    """At which it got there; if it did not, that it had."""
    censored: bool
    """Whether it did not."""


class Arrivals(NamedTuple):
    """How many of several runs have got somewhere, by steps."""

    steps: np.ndarray
    """(event,) float64, increasing: at which runs got there."""
    share: np.ndarray
    """(event,) float64: that has got there from these steps on, until the next ones."""
    low: np.ndarray
    """(event,) float64: pointwise interval of the share; NaN where there is none."""
    high: np.ndarray
    censored: np.ndarray
    """(run,) float64, increasing: steps at which runs ended that had not got there."""
    n: int
    """Runs."""

    @property
    def reached(self) -> int:
        """Runs that got there."""
        return self.n - self.censored.size

    @property
    def last(self) -> float:
        """Steps up to which anything is known; NaN without any run."""
        ends = [*self.steps[-1:].tolist(), *self.censored[-1:].tolist()]
        return max(ends, default=math.nan)

    @property
    def median(self) -> Estimate:
        """Steps until half of the runs have got there.

        Infinite, for more than :attr:`last`, where fewer have; the interval is open above, with an
        infinite end, where it cannot be told that half would.
        """
        if not self.n:
            return Estimate(math.nan, math.nan, math.nan, 0)
        value = self._first(self.share)
        if self.n < 2:
            return Estimate(value, math.nan, math.nan, self.n)
        return Estimate(value, self._first(self.high), self._first(self.low), self.n)

    def _first(self, share: np.ndarray) -> float:
        """The first steps by which a share is one half."""
        (found,) = np.nonzero(share >= 0.5 - _ROUNDING)
        return float(self.steps[found[0]]) if found.size else math.inf


def arrivals(passages: Sequence[Passage]) -> Arrivals:
    """The Kaplan-Meier estimate of the share of runs that have got somewhere, with its interval."""
    from scipy import stats

    survival: Any = stats  # Its types do not know of censored data.
    steps = np.asarray([passage.steps for passage in passages], np.float64)
    censored = np.asarray([passage.censored for passage in passages], np.bool_)
    ended = np.sort(steps[censored])
    if censored.all():
        nothing = np.zeros(0)
        return Arrivals(nothing, nothing, nothing, nothing, ended, steps.size)
    still = survival.ecdf(survival.CensoredData.right_censored(steps, censored)).sf
    events = np.isin(still.quantiles, steps[~censored])
    # Where all runs have got there, or none, there is no interval, and NaN says so.
    warnings.filterwarnings("ignore", "The confidence interval is undefined", RuntimeWarning)
    band = still.confidence_interval(CONFIDENCE, method="log-log")
    low, high = (1 - bound.probabilities[events] for bound in (band.high, band.low))
    return Arrivals(
        still.quantiles[events], 1 - still.probabilities[events], low, high, ended, steps.size
    )


def later(
    first: Mapping[int, Passage], second: Mapping[int, Passage], rng: np.random.Generator
) -> Comparison:
    """How many more steps the first group takes to get somewhere; passages are by seed.

    The difference is that of the medians, without an interval, and NaN where one is unknown. Of two
    runs that one takes more whose steps are known to be more; where the shorter of both ended
    before it got there it cannot be told, and counts half (Gehan 1965). Where none got there, there
    is no chance either.
    """
    seeds = estimates.pairing([first, second]) if first and second else []
    mine = [first[seed] for seed in seeds or first]
    theirs = [second[seed] for seed in seeds or second]
    medians = [arrivals(group).median.value for group in (mine, theirs)]
    n = min(len(mine), len(theirs))
    if all(passage.censored for passage in (*mine, *theirs)):
        return Comparison(_nothing(n), _nothing(n), bool(seeds))
    value = medians[0] - medians[1] if all(map(math.isfinite, medians)) else math.nan
    scores = np.asarray([[_later(one, other) for other in theirs] for one in mine])
    scores = scores.reshape(len(mine), len(theirs))
    chance = estimates.improvement(scores.diagonal() if seeds else scores, rng)
    return Comparison(_nothing(n)._replace(value=value), chance, bool(seeds))


def _nothing(n: int) -> Estimate:
    return Estimate(math.nan, math.nan, math.nan, n)


def _later(one: Passage, other: Passage) -> float:
    """Whether one is known to be later than another: 1, 0, or 0.5 where it cannot be told."""
    if not other.censored and (one.steps > other.steps or one == (other.steps, True)):
        return 1.0
    if not one.censored and (other.steps > one.steps or other == (one.steps, True)):
        return 0.0
    return 0.5
