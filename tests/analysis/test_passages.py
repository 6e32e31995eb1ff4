"""Steps until something was reached: known answers, and what is not known of runs that ended."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.analysis import estimates
from app.analysis.passages import Passage, arrivals, later


def passages(*steps: float) -> list[Passage]:
    """Runs that got there; of a negative number, one that ended there."""
    return [Passage(abs(at), at < 0) for at in steps]


def by_seed(*steps: float) -> dict[int, Passage]:
    return dict(enumerate(passages(*steps)))


def test_without_censoring_it_is_the_share_of_the_runs() -> None:
    found = arrivals(passages(*range(1, 31)))
    np.testing.assert_allclose(found.share, np.arange(1, 31) / 30)
    assert found.median.value == 15
    assert found.median.low < 15 < found.median.high < 30


def test_a_run_that_ended_counts_until_then() -> None:
    found = arrivals(passages(10, -20, 30, 40, -50))
    np.testing.assert_array_equal(found.steps, [10, 30, 40])
    # A fifth of all; of three that are left each has a third of the rest.
    np.testing.assert_allclose(found.share, [1 / 5, 1 / 5 + 4 / 15, 1 / 5 + 8 / 15])
    assert (found.median.value, found.reached, found.n) == (40, 3, 5)


def test_a_published_example() -> None:
    """Freireich and others (1963), weeks until relapse of 21 patients on 6-mercaptopurine.

    Kaplan-Meier estimates at 6, 7, 10, 13, 16, 22 and 23 weeks as textbooks have them; the median
    is 23, its interval from 13 and without an end.
    """
    weeks = (
        6,
        6,
        6,
        -6,
        7,
        -9,
        10,
        -10,
        -11,
        13,
        16,
        -17,
        -19,
        -20,
        22,
        23,
        -25,
        -32,
        -32,
        -34,
        -35,
    )
    found = arrivals(passages(*weeks))
    still = [0.857, 0.807, 0.753, 0.690, 0.627, 0.538, 0.448]
    np.testing.assert_allclose(1 - found.share, still, atol=5e-4)
    assert found.median == (23, 13, math.inf, 21)


def test_where_fewer_than_half_get_there_the_median_is_more_than_was_looked_at() -> None:
    found = arrivals(passages(5, *[-20] * 9))
    assert found.median.value == math.inf
    assert found.last == 20
    none = arrivals(passages(-5, -6))
    assert (none.median.value, none.reached, none.last) == (math.inf, 0, 6)


def test_of_one_run_there_is_no_interval_and_of_none_nothing() -> None:
    one = arrivals(passages(7)).median
    assert (one.value, one.n) == (7, 1)
    assert not one.has_interval
    assert arrivals([]).median.n == 0


@given(st.lists(st.tuples(st.integers(1, 30), st.booleans()), min_size=1, max_size=25))
def test_shares_rise_and_lie_in_their_band(runs: list[tuple[int, bool]]) -> None:
    found = arrivals([Passage(steps, censored) for steps, censored in runs])
    assert (np.diff(found.steps) > 0).all()
    assert (np.diff(found.share) > 0).all()
    there = np.isfinite(found.low)
    assert (found.low[there] <= found.share[there]).all()
    assert (found.share[there] <= found.high[there]).all()
    assert found.reached + found.censored.size == found.n == len(runs)


def test_the_interval_of_the_median_covers_it() -> None:
    draw = np.random.default_rng(4)
    n_simulations, n = 300, 30
    covered = 0
    for _ in range(n_simulations):
        steps = draw.exponential(size=n)
        ends = draw.uniform(0.5, 3, size=n)
        found = [Passage(min(at, end), at > end) for at, end in zip(steps, ends, strict=True)]
        median = arrivals(found).median
        covered += median.low <= math.log(2) <= median.high
    assert 0.92 <= covered / n_simulations <= 0.99


# --- Two groups ----------------------------------------------------------------------------------


def compared(first: dict[int, Passage], second: dict[int, Passage]) -> estimates.Comparison:
    return later(first, second, estimates.bootstrap_rng())


def test_of_two_runs_the_one_that_is_known_to_take_more_is_later() -> None:
    # Longer; ended after the other got there; ended before it did; both ended; the same.
    found = compared(by_seed(9, -9, -3, -3, 5), by_seed(4, 4, 4, -8, 5))
    assert found.paired
    assert found.improvement.value == pytest.approx((1 + 1 + 0.5 + 0.5 + 0.5) / 5)
    assert found.improvement.low < 0.7 <= found.improvement.high


def test_the_difference_is_that_of_the_medians_where_both_are_known() -> None:
    assert compared(by_seed(10, 20, 30), by_seed(1, 2, 3)).difference.value == 18
    assert math.isnan(compared(by_seed(10, -20, -30), by_seed(1, 2, 3)).difference.value)
    assert compared(by_seed(10), {}).difference.n == 0
