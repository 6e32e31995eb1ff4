"""Tests against a bound, and their correction for being many."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.analysis import estimates, significance

P_VALUES = st.lists(st.floats(0, 1), max_size=30)


def of_one_group(values: list[float]) -> estimates.Contrast:
    return estimates.contrast([(1.0, dict(enumerate(values)))], estimates.bootstrap_rng())


def test_they_are_those_of_a_t_test() -> None:
    from scipy import stats

    scipy: Any = stats
    test = scipy.ttest_1samp
    values = np.random.default_rng(8).normal(1, 2, size=12)
    more, less = significance.one_sided(of_one_group(values.tolist()), 0.5)
    assert more == pytest.approx(test(values, 0.5, alternative="greater").pvalue)
    assert less == pytest.approx(test(values, 0.5, alternative="less").pvalue)


def test_runs_that_all_say_the_same_are_certain() -> None:
    same = of_one_group([3.0] * 10)
    assert significance.one_sided(same, 2) == (0, 1)
    assert significance.one_sided(same, 4) == (1, 0)
    assert significance.one_sided(same, 3) == (1, 1)


def test_a_single_run_is_no_test() -> None:
    assert all(map(math.isnan, significance.one_sided(of_one_group([3.0]), 0)))


def test_holm_steps_down() -> None:
    assert significance.holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert significance.holm([0.4, math.nan, 0.9])[::2] == pytest.approx([0.8, 0.9])
    assert math.isnan(significance.holm([0.4, math.nan, 0.9])[1])


@given(P_VALUES)
def test_a_corrected_p_is_never_below_the_raw_one_nor_out_of_its_order(raw: list[float]) -> None:
    found = significance.holm(raw)
    assert all(p <= corrected <= 1 for p, corrected in zip(raw, found, strict=True))
    order = np.argsort(raw, kind="stable")
    assert (np.diff(np.asarray(found)[order]) >= 0).all()
    # Bonferroni's correction is the same for the smallest, and never smaller.
    assert all(corrected <= min(1, len(raw) * p) for p, corrected in zip(raw, found, strict=True))


@given(P_VALUES, st.floats(0, 1))
def test_one_more_test_corrects_no_less(raw: list[float], another: float) -> None:
    with_it = significance.holm([*raw, another])[:-1]
    assert all(p <= q for p, q in zip(significance.holm(raw), with_it, strict=True))
