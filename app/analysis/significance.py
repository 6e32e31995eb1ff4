"""Tests of sums of groups of runs against a bound, and their correction for being many."""

import math
from collections.abc import Sequence
from typing import Any

from app.analysis.estimates import Contrast


def one_sided(effect: Contrast, bound: float) -> tuple[float, float]:
    """Two p values of Student's or Welch's t test against a bound.

    The chance to measure so much, or more, if the truth were no more than the bound, and the chance
    to measure so little, or less, if it were no less. NaN where there is no standard error.
    """
    from scipy import stats

    excess, error = effect.estimate.value - bound, effect.error
    if error == 0:  # All runs say the same.
        return float(excess <= 0), float(excess >= 0)
    t = excess / error
    student: Any = stats.t
    return float(student.sf(t, effect.freedom)), float(student.cdf(t, effect.freedom))


def holm(p_values: Sequence[float]) -> list[float]:
    """The p values, corrected for their number by Holm's step-down procedure (1979).

    To reject all hypotheses whose corrected p is below a level is to reject any true one with at
    most that chance, however they depend on one another. The smallest of m is multiplied by m, the
    next by m - 1, and so on, and none is smaller than the one before. NaN is no test and stays NaN.
    """
    tested = sorted((p, place) for place, p in enumerate(p_values) if not math.isnan(p))
    found, largest = list(p_values), 0.0
    for rank, (p, place) in enumerate(tested):
        largest = max(largest, min(1.0, (len(tested) - rank) * p))
        found[place] = largest
    return found
