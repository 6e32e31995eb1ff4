"""Averages over seeds: known answers, and how often an interval covers the truth."""

import math
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest
from scipy import stats as stats_of_scipy

from app.analysis import estimates

stats: Any = stats_of_scipy  # Its types do not know of all that it has.


def rng() -> np.random.Generator:
    return np.random.default_rng(1)


# --- Scalars -------------------------------------------------------------------------------------


def test_the_interval_of_a_constant_is_that_constant() -> None:
    assert estimates.mean([3.5] * 6, rng()) == (3.5, 3.5, 3.5, 6)
    assert estimates.interquartile_mean([3.5] * 6, rng()) == (3.5, 3.5, 3.5, 6)


def test_one_run_has_no_interval_and_none_no_mean() -> None:
    one = estimates.mean([2.0], rng())
    assert (one.value, one.n) == (2.0, 1)
    assert math.isnan(one.low)
    assert math.isnan(one.high)
    none = estimates.mean([math.nan], rng())
    assert none.n == 0
    assert math.isnan(none.value)


def test_runs_without_a_value_are_left_out_and_counted() -> None:
    assert estimates.mean([1.0, math.nan, 3.0], rng())[::3] == (2.0, 2)


def test_the_interquartile_mean_leaves_out_a_quarter_at_each_end() -> None:
    values = [-1000.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 1000.0]
    assert estimates.interquartile_mean(values, rng()).value == pytest.approx(2.5)


def test_the_interval_depends_on_the_generator_alone() -> None:
    values = np.random.default_rng(3).normal(size=12).tolist()
    assert estimates.mean(values, rng()) == estimates.mean(values, rng())


def test_three_runs_have_their_range_as_interval() -> None:
    assert estimates.mean([1.0, 2.0, 6.0], rng()) == (3.0, 1.0, 6.0, 3)


@pytest.mark.parametrize("n", [10, 30])
def test_the_interval_covers_the_mean_of_a_normal_as_often_as_it_says(n: int) -> None:
    # Windows are resampled together, and each of them is a sample of its own.
    n_samples = 800
    curves = np.random.default_rng(11).normal(size=(n, n_samples))
    found = estimates.band([*curves], 1, rng())
    covered = float(((found.low <= 0) & (found.high >= 0)).mean())
    # Two standard errors of a share of so many are 0.015.
    assert covered == pytest.approx(estimates.CONFIDENCE, abs=0.02)


# --- Comparisons ---------------------------------------------------------------------------------


def by_seed(values: np.ndarray, first: int = 0) -> dict[int, float]:
    """Values of runs whose seeds count up from the first."""
    return {first + seed: float(value) for seed, value in enumerate(values)}


def test_paired_by_seed_a_constant_difference_is_certain() -> None:
    first = {1: 11.0, 2: 52.0, 3: 93.0}
    second = {3: 90.0, 2: 49.0, 1: 8.0}
    found = estimates.compare(first, second, rng())
    assert found.difference == (3.0, 3.0, 3.0, 3)
    assert found.paired
    assert found.improvement.value == 1.0


def test_only_shared_seeds_are_paired() -> None:
    found = estimates.compare({1: 1.0, 2: 2.0, 9: 50.0}, {1: 0.0, 2: 0.0, 8: 70.0}, rng())
    assert found.paired
    assert found.difference[::3] == (1.5, 2)


def test_unpaired_where_no_seed_is_shared() -> None:
    found = estimates.compare({1: 4.0, 2: 6.0}, {3: 1.0, 4: 3.0, 5: 5.0}, rng())
    assert not found.paired
    assert found.difference.value == pytest.approx(2.0)
    assert found.difference.low == pytest.approx(4 - 5)
    assert found.difference.high == pytest.approx(6 - 1)
    # Of six pairs, all are larger but for 4 < 5.
    assert found.improvement.value == pytest.approx(5 / 6)
    assert found.improvement.low < 5 / 6
    assert found.improvement.high == 1.0


def test_the_interquartile_mean_of_differences_by_seed() -> None:
    second = {seed: 100.0 * seed for seed in range(8)}
    gains = [-1000.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 1000.0]
    first = {seed: second[seed] + gain for seed, gain in enumerate(gains)}
    found = estimates.interquartile_difference(first, second, rng())
    assert (found.value, found.n) == (2.5, 8)
    assert found.low >= -1000
    assert found.high <= 1000
    # Of those without a partner nothing counts.
    assert estimates.interquartile_difference({**first, 9: 1e9}, second, rng()) == found


def test_the_interquartile_difference_of_unpaired_runs_is_that_of_their_middle_halves() -> None:
    first = dict(enumerate([-1000.0, 10.0, 12.0, 1000.0]))
    second = dict(enumerate([-5.0, 1.0, 1.0, 80.0], 10))
    found = estimates.interquartile_difference(first, second, rng())
    assert (found.value, found.n) == (10.0, 4)
    assert found.low < 10 < found.high


def test_ties_count_half() -> None:
    first, second = {1: 1.0, 2: 2.0, 3: 3.0, 4: 0.0}, {1: 1.0, 2: 1.0, 3: 3.0, 4: 5.0}
    assert estimates.compare(first, second, rng()).improvement.value == pytest.approx(0.5)
    unpaired = estimates.compare({1: 1.0}, {2: 1.0, 3: 0.0}, rng())
    assert unpaired.improvement.value == pytest.approx(0.75)


def test_without_an_exception_the_chance_has_the_exact_interval_of_so_many_pairs() -> None:
    low, high = dict.fromkeys(range(10), 0.0), dict.fromkeys(range(10), 1.0)
    least = 0.025 ** (1 / 10)
    assert estimates.compare(high, low, rng()).improvement == (1.0, least, 1.0, 10)
    assert estimates.compare(low, high, rng()).improvement == (0.0, 0.0, 1 - least, 10)
    others = {100 + seed: value for seed, value in low.items()}
    assert estimates.compare(high, others, rng()).improvement == (1.0, least, 1.0, 10)


@pytest.mark.parametrize("paired", [True, False])
def test_the_interval_of_a_chance_covers_it(paired: bool) -> None:
    draw = np.random.default_rng(5)
    n_simulations, n, shift = 60, 20, 0.6
    covered = 0
    for _ in range(n_simulations):
        first = by_seed(draw.normal(shift, size=n))
        second = by_seed(draw.normal(size=n), 0 if paired else n)
        found = estimates.compare(first, second, rng())
        assert found.paired is paired
        truth = NormalDist().cdf(shift / 2**0.5)
        covered += found.improvement.low <= truth <= found.improvement.high
    assert covered / n_simulations > 0.88


def test_groups_are_paired_where_half_of_every_group_has_a_partner() -> None:
    assert estimates.pairing([range(30), range(15, 60)]) == []  # 15 of 45.
    assert estimates.pairing([range(30), range(30), range(10, 40)]) == [*range(10, 30)]
    assert estimates.pairing([range(60), range(30)]) == [*range(30)]
    assert estimates.pairing([[1], [1]]) == []


def test_many_runs_set_against_a_few_of_their_seeds_are_all_counted() -> None:
    first = {seed: float(seed % 2) for seed in range(120)}
    second = {seed: 10.0 * seed for seed in range(30)}
    found = estimates.compare(first, second, rng())
    assert not found.paired
    assert found.difference.value == pytest.approx(0.5 - 145)
    assert found.difference.n == 30


def test_the_error_of_a_contrast_is_that_of_a_t_test() -> None:
    draw = np.random.default_rng(2)
    first, second = draw.normal(size=12), draw.normal(1, 3, size=20)
    mine, theirs = by_seed(first), by_seed(second, 50)
    welch = stats.ttest_ind(first, second, equal_var=False)
    found = estimates.contrast([(1.0, mine), (-1.0, theirs)], rng())
    assert found.estimate.value / found.error == pytest.approx(welch.statistic)
    assert found.freedom == pytest.approx(welch.df)
    paired = stats.ttest_rel(first, second[:12])
    found = estimates.contrast([(1.0, mine), (-1.0, by_seed(second[:12]))], rng())
    assert found.estimate.value / found.error == pytest.approx(paired.statistic)
    assert found.freedom == pytest.approx(paired.df)


def test_a_contrast_of_four_groups() -> None:
    groups = [{1: 10.0, 2: 20.0}, {1: 4.0, 2: 5.0}, {1: 3.0, 2: 3.0}, {1: 1.0, 2: 2.0}]
    weights = [1.0, -1.0, -1.0, 1.0]
    found = estimates.contrast(list(zip(weights, groups, strict=True)), rng())
    assert found.estimate == (9.0, 4.0, 14.0, 2)


def test_a_contrast_with_an_empty_group_says_nothing() -> None:
    found = estimates.compare({1: 1.0}, {}, rng())
    assert found.difference.n == 0
    assert math.isnan(found.improvement.value)


# --- Curves --------------------------------------------------------------------------------------


def test_windows_of_steps_and_of_trials() -> None:
    reward = np.array([100.0, -50.0, 0.0, 100.0, 100.0])
    steps = np.array([5, 5, 10, 3, 2])
    np.testing.assert_array_equal(estimates.windowed(reward, steps, 10, "steps"), [25.0, 0.0])
    np.testing.assert_array_equal(estimates.windowed(reward, steps, 2, "trials"), [25.0, 50.0])


def test_a_window_in_which_no_trial_ended_is_empty() -> None:
    values = estimates.windowed(np.array([1.0, 2.0]), np.array([5, 25]), 10, "steps")
    np.testing.assert_array_equal(values, [1.0, np.nan, 2.0])


def test_a_run_without_trials_has_no_windows() -> None:
    assert estimates.windowed(np.zeros(0), np.zeros(0, np.int64), 10, "steps").size == 0


def test_the_band_of_two_runs() -> None:
    band = estimates.band([np.array([0.0, 2.0]), np.array([4.0, 2.0])], 10, rng())
    np.testing.assert_array_equal(band.at, [5.0, 15.0])
    np.testing.assert_array_equal(band.mean, [2.0, 2.0])
    np.testing.assert_array_equal(band.low, [0.0, 2.0])
    np.testing.assert_array_equal(band.high, [4.0, 2.0])
    np.testing.assert_array_equal(band.n, [2, 2])


def test_the_mean_is_over_the_runs_that_go_on_and_the_curve_is_cut() -> None:
    curves = [np.full(length, float(value)) for value, length in enumerate((2, 3, 4, 5))]
    band = estimates.band(curves, 1, rng())
    # From the fifth window on, one run of four is left, fewer than half.
    np.testing.assert_array_equal(band.n, [4, 4, 3, 2])
    np.testing.assert_array_equal(band.mean, [1.5, 1.5, 2.0, 2.5])


def test_the_band_of_one_run_has_no_interval() -> None:
    band = estimates.band([np.array([1.0, 2.0])], 10, rng())
    np.testing.assert_array_equal(band.mean, [1.0, 2.0])
    assert np.isnan(band.low).all()


def test_the_band_of_runs_shorter_than_a_window_is_empty() -> None:
    assert estimates.band([np.zeros(0), np.zeros(0)], 10, rng()).mean.size == 0


def test_an_empty_window_of_one_run_is_left_to_the_others() -> None:
    band = estimates.band([np.array([1.0, np.nan]), np.array([3.0, 5.0])], 10, rng())
    np.testing.assert_array_equal(band.mean, [2.0, 5.0])
    np.testing.assert_array_equal(band.n, [2, 1])


@pytest.mark.parametrize(
    ("longest", "width"),
    [(5_500_000, 100_000), (350_000, 5_000), (3_999, 50), (39, 1), (10**9, 100_000)],
)
def test_windows_have_a_round_width(longest: int, width: int) -> None:
    assert estimates.window_width(longest, 100_000) == width


def test_windows_of_trials_stand_at_the_mean_step_at_which_they_ended() -> None:
    reward, steps = np.array([0.0, 100.0, 50.0, 50.0, 9.0]), np.array([10, 10, 40, 60, 5])
    values = estimates.windowed(reward, steps, 2, "trials")
    ends = estimates.window_ends(steps, 2)
    np.testing.assert_array_equal(ends, [20, 120])
    found = estimates.band([values, values + 10], 2, rng(), [ends, ends + 100])
    np.testing.assert_array_equal(found.mean, [55.0, 55.0])
    np.testing.assert_array_equal(found.at, [70.0, 170.0])
    np.testing.assert_array_equal(found.start, [0, 70])
