"""What was swept: places, names, the preset's own values, and how much difference it makes."""

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.analysis import sweeps
from app.analysis.sweeps import Sweep
from app.documents import presets

TIMED = presets.load("timed").model_dump(mode="json")
CIRCLE = "schedule.skills.circle_clockwise.at"
AVOID = "schedule.skills.avoid.at"


def grid(**values: Sequence[Any]) -> list[dict[str, Any]]:
    """Variants as a grid makes them; underscores of names stand for dots."""
    keys = [key.replace("_", ".") for key in values]
    return [dict(zip(keys, chosen, strict=True)) for chosen in itertools.product(*values.values())]


def found(variants: Sequence[Mapping[str, Any]], settings: Mapping[str, Any] = {}) -> Sweep:
    swept = sweeps.sweep_of(variants, settings)
    assert swept is not None
    return swept


# --- What was swept ------------------------------------------------------------------------------

numbers = st.lists(st.integers(-1000, 1000) | st.floats(-1, 1).map(lambda x: x + 2000), unique=True)
texts = st.lists(st.text("abc", min_size=1, max_size=3), unique=True)
columns = (numbers | texts).filter(lambda values: len(values) >= 2)


@given(across=columns, up=columns)
def test_each_variant_of_a_grid_has_its_own_place(across: Sequence[Any], up: Sequence[Any]) -> None:
    variants = grid(x=across, y=up)
    swept = found(variants)
    assert len(swept.axles) == 2
    assert sorted(swept.places.values()) == list(range(len(variants)))
    for place, index in swept.places.items():
        chosen = [axle.values[k] for axle, k in zip(swept.axles, place, strict=True)]
        assert chosen == [variants[index]["x"], variants[index]["y"]]
    assert all(list(a.values) == sorted(a.values) for a in swept.axles if a.is_numeric)


@given(values=columns.filter(lambda values: len(values) >= 3), data=st.data())
def test_keys_that_move_together_count_as_one_axle(
    values: Sequence[Any], data: st.DataObject
) -> None:
    others = data.draw(st.permutations(values))
    variants = [{"a.x": a, "b.x": b, "same": 1} for a, b in zip(values, others, strict=True)]
    swept = found(variants)
    assert [axle.key for axle in swept.axles] == ["{a, b}.x"]
    assert sorted(swept.places.values()) == list(range(len(variants)))


@pytest.mark.parametrize("near", [2000.00390625, 2000.0000000000002])
def test_values_that_look_the_same_in_short_are_told_apart(near: float) -> None:
    swept = found([{"a.x": a, "b.x": b} for a, b in [(0, 1), (2000.0, near), (near, 2000.0)]])
    assert list(swept.axles[0].values) == ["0, 1", f"2000.0, {near}", f"{near}, 2000.0"]
    names = sweeps.names_of([{"x": 2000.0}, {"x": near}], {})
    assert names is not None
    assert names.of == ("2000.0", str(near))


def test_keys_that_have_the_same_value_are_one_number() -> None:
    swept = found([{"a.x": at, "b.x": at, "fixed": 7} for at in (30, 0, 300)])
    assert list(swept.axles[0].values) == [0, 30, 300]
    assert swept.places == {(0,): 1, (1,): 0, (2,): 2}


@pytest.mark.parametrize(
    "variants",
    [
        [],
        grid(x=[1, 2]),
        [*grid(x=[1, 2]), {"y": 1}],
        grid(x=[1, 2], y=[1, 2], z=[1, 2]),
        [{"x": 1}, {"x": 1}, {"x": 1}],
        [{"x": 1}, {"x": 2}, {"x": 2}],
    ],
)
def test_what_is_no_sweep(variants: Sequence[Mapping[str, Any]]) -> None:
    assert sweeps.sweep_of(variants, {}) is None


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ([CIRCLE], "trial at which circle clockwise joins"),
        ([CIRCLE, AVOID], "trial at which circle clockwise and avoid join"),
        (["schedule.episodes.1.duration"], "exploration of avoid (trials)"),
        (["schedule.episodes.9.duration"], "schedule.episodes.9.duration"),
        ([AVOID, "trials"], f"{AVOID}, trials"),
        (["learner.alpha"], "learner.alpha"),
    ],
)
def test_axles_are_named_in_words_where_there_are_any(keys: Sequence[str], words: str) -> None:
    swept = found([dict.fromkeys(keys, value) for value in (1, 2, 3)], TIMED)
    assert [axle.label for axle in swept.axles] == [words]


# --- More settings than a plane has --------------------------------------------------------------


def test_each_value_of_many_settings_has_the_variants_that_have_it() -> None:
    variants = [{**v, "b.z": v["a.z"]} for v in grid(x=[1, 2], y=["s", "t", "u"], a_z=[4, 3])]
    design = sweeps.design_of(variants, {})
    assert design is not None
    assert [axle.key for axle in design.axles] == ["x", "y", "{a, b}.z"]
    assert design.is_whole
    for axle, having in zip(design.axles, design.having, strict=True):
        key = axle.key.replace("{a, b}", "a")
        for value, places in zip(axle.values, having, strict=True):
            assert list(places) == [k for k, sets in enumerate(variants) if sets[key] == value]


def test_few_settings_and_few_combinations_are_no_design() -> None:
    whole = grid(x=[1, 2], y=[1, 2], z=[1, 2])
    assert sweeps.design_of(grid(x=[1, 2], y=[1, 2]), {}) is None
    assert sweeps.design_of([*whole, whole[0]], {}) is None
    assert sweeps.design_of([*whole[:-1], {"x": 2}], {}) is None
    fewer = sweeps.design_of(whole[:-1], {})
    assert fewer is not None
    assert not fewer.is_whole
    one_at_a_time = [
        {"x": x, "y": y, "z": z}
        for x, y, z in ((0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (0, 2, 0), (0, 0, 1), (0, 0, 2))
    ]
    assert sweeps.design_of(one_at_a_time, {}) is None


def test_settings_that_differ_are_found_wherever_they_are() -> None:
    first = {"description": "one", "a": {"b": [1, {"c": 2}], "d": 3}, "e": None}
    second = {"description": "other", "a": {"b": [1, {"c": 4}], "d": 3}, "f": 0}
    assert sweeps.differing(first, second) == [
        ("a.b.1.c", 2, 4),
        ("e", None, sweeps.NOT_SET),
        ("f", sweeps.NOT_SET, 0),
    ]
    assert sweeps.differing(first, {**first, "description": "other"}) == []


# --- The preset's own values ---------------------------------------------------------------------


def own_place(
    variants: Sequence[Mapping[str, Any]], more: Sequence[str] = ()
) -> sweeps.Place | None:
    """The own place of variants of the timed preset; ``more`` settings are in none of them."""
    places = found(variants, TIMED).places
    settings = {}
    for place, index in places.items():
        words = [*more, *(f"{key}={value}" for key, value in variants[index].items())]
        settings[place] = presets.load("timed", words).model_dump(mode="json")
    return sweeps.own_place({p: variants[i] for p, i in places.items()}, settings, TIMED)


def plane(circle: Sequence[int], avoid: Sequence[int], **fixed: Any) -> list[dict[str, Any]]:
    return [{CIRCLE: c, AVOID: a, **fixed} for c in circle for a in avoid]


def test_the_presets_own_values_are_found() -> None:
    assert own_place(plane([0, 12_000, 24_000], [14_500, 0])) == (1, 1)
    assert own_place(plane([0, 24_000], [14_500, 0])) is None


def test_what_is_set_in_all_variants_does_not_matter() -> None:
    assert own_place(plane([12_000, 0], [14_500, 0], trials=24_000)) == (1, 1)


def test_a_preset_of_the_same_name_with_other_settings_is_not_the_preset() -> None:
    assert own_place(plane([12_000, 0], [14_500, 0]), ["learner.alpha=0.2"]) is None


# --- Whether it makes a difference ---------------------------------------------------------------


def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def test_differences_are_paired_by_seed() -> None:
    values: dict[sweeps.Place, sweeps.Values] = {
        (0,): {0: 1.0, 1: 50.0, 2: 9.0},
        (1,): {0: 3.0, 1: 52.0, 2: 11.0},
    }
    (difference,) = sweeps.differences(values, (0,)).values()
    assert difference.paired
    assert difference.estimate == (2.0, 2.0, 2.0, 3)


def test_the_highest_is_the_one_with_the_highest_mean_of_what_is_there() -> None:
    values = {(0,): {0: 1.0, 1: 5.0}, (1,): {0: 4.0, 1: math.nan}, (2,): {0: math.nan}}
    assert sweeps.highest(values) == (1,)


def test_a_place_that_is_always_highest_loses_nothing_by_being_chosen_blindly() -> None:
    values = {(0,): {0: 1.0, 1: 2.0, 2: 3.0}, (1,): {0: 11.0, 1: 12.0, 2: 13.0}}
    assert sweeps.highest_unseen(values) == 12


def test_the_luck_of_the_highest_of_many_is_taken_from_it() -> None:
    """All places are alike, so that the highest of them is so by luck alone."""
    draw = rng()
    values: dict[sweeps.Place, sweeps.Values] = {
        (place,): dict(enumerate(draw.normal(80, 5, 4).tolist())) for place in range(2_000)
    }
    best = values[sweeps.highest(values)]
    assert sum(best.values()) / len(best) > 87
    assert abs(sweeps.highest_unseen(values) - 80) < 4 * 5 / math.sqrt(4)


def test_without_two_shared_seeds_nothing_is_known_of_the_highest() -> None:
    assert math.isnan(sweeps.highest_unseen({(0,): {0: 1.0, 1: 2.0}, (1,): {1: 2.0, 2: 3.0}}))
    assert math.isnan(sweeps.highest_unseen({(0,): {0: 1.0, 1: math.nan}, (1,): {0: 2.0, 1: 3.0}}))
