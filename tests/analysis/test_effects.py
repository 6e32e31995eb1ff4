"""What settings of a design do: found again where it is known, and not seen where there is none."""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from app.analysis import effects
from app.analysis.effects import Analysis, Factor
from app.documents import presets

TIMED = presets.load("timed").model_dump(mode="json")
N = 120


def drawn(n_keys: int = 4, n: int = N, seed: int = 0) -> list[dict[str, float]]:
    shares = np.random.default_rng(seed).random((n, n_keys))
    return [{f"k{j}.x": float(x) for j, x in enumerate(row)} for row in shares]


def found(
    variants: Sequence[Mapping[str, Any]],
    of: Callable[[Mapping[str, Any]], float],
    noise: float = 0.0,
) -> Analysis:
    factors = effects.factors_of(variants, {})
    rng = np.random.default_rng(1)
    values = [of(v) + noise * rng.standard_normal() for v in variants]
    analysis = effects.analysed(factors, values)
    assert analysis is not None
    return analysis


# --- Settings ------------------------------------------------------------------------------------


def test_settings_of_draws_are_apart_though_none_has_a_value_twice() -> None:
    factors = effects.factors_of(drawn(3), {})
    assert [factor.axle.key for factor in factors] == ["k0.x", "k1.x", "k2.x"]
    assert len(factors[0].column) == N


def test_what_is_always_the_same_is_one_setting_and_what_does_not_differ_is_none() -> None:
    circle, avoid = (f"schedule.skills.{name}.freeze" for name in ("circle_clockwise", "avoid"))
    variants = [
        {circle: freeze, "trials": 9, avoid: freeze, "learner.alpha": alpha}
        for freeze, alpha in [(0, 0.1), (30, 0.4), (7, 0.2)]
    ]
    freeze, alpha = effects.factors_of(variants, TIMED)
    assert freeze.axle.label == "freeze when circle clockwise and avoid join (trials)"
    assert list(freeze.axle.values) == [0, 7, 30]
    assert alpha.column == [0.1, 0.4, 0.2]


# --- What they do --------------------------------------------------------------------------------


def test_a_sum_of_settings_is_found_again() -> None:
    # The middles of eleven equal parts, all with all: two settings that have nothing in common.
    middles = [(k + 0.5) / 11 for k in range(11)]
    pairs = itertools.product(middles, middles)
    variants = [
        {"a.x": a, "b.x": b, **others} for (a, b), others in zip(pairs, drawn(2, 121), strict=True)
    ]
    analysis = found(variants, lambda v: 10 + 4 * v["a.x"] - 2 * v["b.x"] ** 2, noise=0.02)
    assert analysis.of_sum > 0.99
    straight, square, *nothing = analysis.alone
    of_straight, of_square = 16 / 12, 4 * (1 / 5 - 1 / 9)
    total = of_straight + of_square
    assert straight.of_variance == pytest.approx(of_straight / total, abs=0.05)
    assert square.of_variance == pytest.approx(of_square / total, abs=0.05)
    assert straight.is_significant
    assert square.is_significant
    assert all(share.of_variance < 0.001 for share in nothing)
    response = analysis.responses[0]
    slope = np.polyfit(np.asarray(response.values, float), response.mean, 1)[0]
    assert slope == pytest.approx(4, abs=0.05)
    assert np.all(response.low <= response.mean)
    assert np.all(response.mean <= response.high)


def test_the_scale_of_a_setting_makes_no_difference() -> None:
    variants = drawn(2)
    plain = found(variants, lambda v: v["k0.x"])
    stretched = [{"k0.x": 10 ** (4 * v["k0.x"]), "k1.x": v["k1.x"]} for v in variants]
    scaled = found(stretched, lambda v: math.log10(v["k0.x"]) / 4)
    assert scaled.alone[0].of_variance == pytest.approx(plain.alone[0].of_variance)


def test_what_only_a_pair_does_is_of_that_pair() -> None:
    analysis = found(drawn(3), lambda v: (2 * v["k0.x"] - 1) * (2 * v["k1.x"] - 1), noise=0.05)
    assert analysis.of_sum < 0.15
    assert not any(share.is_significant for share in analysis.alone)
    pairs = sorted(analysis.together, key=lambda pair: -analysis.together[pair].of_variance)
    assert pairs[0] == (0, 1)
    assert analysis.together[0, 1].of_variance > 0.8
    assert [pair for pair, share in analysis.together.items() if share.is_significant] == [(0, 1)]


def test_chance_is_seldom_taken_for_an_effect() -> None:
    wrong = 0
    for seed in range(24):
        variants = drawn(4, 60, seed)
        values = np.random.default_rng(1000 + seed).standard_normal(60).tolist()
        analysis = effects.analysed(effects.factors_of(variants, {}), values)
        assert analysis is not None
        wrong += any(share.is_significant for share in analysis.alone)
        assert analysis.of_sum < 0.5
    # One of twenty is expected, as all settings of a search are tested together.
    assert wrong <= 5


def test_settings_that_are_no_numbers_enter_by_their_levels() -> None:
    names = ("all", "chosen", "none")
    worth = dict(zip(names, (3.0, 0.0, 1.0), strict=True))
    variants = [
        {"learner.mode": name, "k.x": x} for name, (x,) in zip(names * 30, _rows(90), strict=True)
    ]
    analysis = found(variants, lambda v: worth[v["learner.mode"]] + v["k.x"])
    response = dict(zip(analysis.responses[0].values, analysis.responses[0].mean, strict=True))
    assert response["all"] - response["chosen"] == pytest.approx(3, abs=0.1)
    assert response["none"] - response["chosen"] == pytest.approx(1, abs=0.1)


def _rows(n: int) -> list[tuple[float]]:
    return [(float(x),) for x in np.random.default_rng(3).random(n)]


def test_all_combinations_are_a_design_as_well() -> None:
    variants = [
        {"a.x": a, "b.x": b, "c.x": c}
        for a, b, c in itertools.product((1, 2, 3, 4), (1, 2, 3), (0, 1))
    ]
    analysis = found(variants, lambda v: 5 * v["a.x"] + v["b.x"] * v["c.x"])
    assert list(analysis.responses[0].values) == [1, 2, 3, 4]
    assert analysis.alone[0].of_variance > 0.9
    assert analysis.together[1, 2].is_significant
    assert not analysis.together[0, 1].is_significant


def test_variants_without_a_value_are_left_out() -> None:
    variants = drawn(2)
    factors = effects.factors_of(variants, {})
    values = [v["k0.x"] for v in variants]
    with_gap = effects.analysed(factors, [float("nan"), *values[1:]])
    assert with_gap is not None
    assert with_gap.used == list(range(1, N))
    assert len(with_gap.factors[0].column) == N - 1


@pytest.mark.parametrize("n", [1, 2, 8])
def test_too_few_draws_say_nothing(n: int) -> None:
    variants = drawn(3, n)
    factors = [
        Factor(f.axle, f.column) for f in effects.factors_of([*variants, *drawn(3, 2, 5)], {})
    ]
    values = [*(float(k) for k in range(n)), float("nan"), float("nan")]
    assert effects.analysed(factors, values) is None


def test_values_that_are_all_the_same_say_nothing() -> None:
    assert effects.analysed(effects.factors_of(drawn(2), {}), [7.0] * N) is None
