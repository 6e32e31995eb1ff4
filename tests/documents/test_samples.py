"""Random search: what a sample draws, the same everywhere, and what it cannot draw."""

from collections import Counter
from typing import Any

import numpy as np
import pytest

from app.documents.experiments import Experiment, ExperimentError, parse


def sampled(keys: str, count: int = 200, seed: int = 1, more: str = "") -> Experiment:
    text = f"presets: [timed]\nsample:\n  count: {count}\n  seed: {seed}\n  keys: {{{keys}}}\n"
    return parse(f"{text}{more}\n", "my.yaml")


def drawn(keys: str, count: int = 200, seed: int = 1) -> list[dict[str, Any]]:
    return [dict(variant.overrides) for variant in sampled(keys, count, seed).variants]


def column(values: str, count: int = 200) -> list[Any]:
    return [draw["world.size"] for draw in drawn(f"world.size: {values}", count)]


def complaints(text: str) -> list[str]:
    with pytest.raises(ExperimentError) as refused:
        parse(f"presets: [timed]\n{text}\n", "my.yaml")
    return str(refused.value).splitlines()


# --- What is drawn -------------------------------------------------------------------------------


def test_each_draw_is_a_variant_with_its_number_and_its_values() -> None:
    experiment = sampled("learner.epsilon: {start: 0.0, stop: 0.5}, world.size: [60, 90]", 12)
    assert [variant.label for variant in experiment.variants] == [
        f"timed, draw {number}" for number in range(1, 13)
    ]
    assert experiment.n_drawn == 12
    for variant in experiment.variants:
        assert variant.spec.learner.epsilon == variant.overrides["learner.epsilon"]
        assert variant.spec.world.size == variant.overrides["world.size"]


def test_draws_are_those_of_their_seed_and_more_of_them_begin_alike() -> None:
    keys = "learner.epsilon: {start: 0.0, stop: 0.5}, learner.alpha: {log_start: 0.01, log_stop: 1}"
    assert drawn(keys, 20) == drawn(keys, 50)[:20]
    assert drawn(keys, 20) != drawn(keys, 20, seed=2)
    # What NumPy's PCG64 makes of this seed; a file has to come to the same runs everywhere.
    first = np.random.Generator(np.random.PCG64(1)).random(2)
    draw = drawn(keys, 1)[0]
    assert draw["learner.epsilon"] == round(first[0] / 2, 5)
    assert draw["learner.alpha"] == float(f"{0.01 * 100 ** first[1]:.6g}")


def test_draws_lie_evenly_between_the_ends() -> None:
    found = [
        draw["learner.epsilon"] for draw in drawn("learner.epsilon: {start: 0.2, stop: 0.6}", 2_000)
    ]
    assert 0.2 <= min(found) < max(found) <= 0.6
    counts = np.histogram(found, bins=4, range=(0.2, 0.6))[0]
    assert counts.min() > 400  # of 500 expected, five times the standard deviation below


def test_draws_of_a_logarithmic_range_lie_evenly_on_a_scale_of_ratios() -> None:
    keys = "learner.alpha: {log_start: 0.0001, log_stop: 1}"
    found = np.asarray([draw["learner.alpha"] for draw in drawn(keys, 2_000)])
    counts = np.histogram(np.log10(found), bins=4, range=(-4, 0))[0]
    assert counts.sum() == 2_000
    assert counts.min() > 400


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ("{start: 60, stop: 64}", [60, 61, 62, 63, 64]),
        ("{log_start: 60, log_stop: 64}", [60, 61, 62, 63, 64]),
        ("[64, 60, 90]", [60, 64, 90]),
    ],
)
def test_whole_ends_and_lists_give_each_of_their_values(values: str, expected: list[int]) -> None:
    found = column(values, len(expected))
    assert sorted(found) == expected
    assert all(isinstance(value, int) for value in found)


def test_no_two_draws_are_alike() -> None:
    found = drawn("world.size: [60, 90, 120], world.start_radius: [[10, 20], [10, 30]]", 6)
    assert len({repr(draw) for draw in found}) == 6


@pytest.mark.parametrize("values", ["[0, 300, 600]", "{start: 0, stop: 600}"])
def test_keys_that_are_the_same_as_another_move_with_it(values: str) -> None:
    circle, avoid = (f"schedule.skills.{skill}.freeze" for skill in ("circle_clockwise", "avoid"))
    found = drawn(f"{avoid}: {{same_as: {circle}}}, {circle}: {values}", 3)
    assert len({draw[avoid] for draw in found}) == 3
    assert all(draw[avoid] == draw[circle] for draw in found)


def test_draws_are_combined_with_what_else_is_varied_and_are_the_same_for_all_presets() -> None:
    experiment = parse(
        "presets:\n"
        "  - timed\n"
        "  - preset: standard_q\n"
        "    grid: {learner.gamma: [0.9, 0.99]}\n"
        "sample: {count: 4, keys: {learner.epsilon: {start: 0.0, stop: 0.5}}}\n",
        "my.yaml",
    )
    epsilons = [variant.spec.learner.epsilon for variant in experiment.variants]
    assert Counter(epsilons) == dict.fromkeys(epsilons[:4], 3)
    assert experiment.variants[4].label == "standard_q, draw 1, learner.gamma=0.9"


def test_a_preset_has_a_sample_of_its_own() -> None:
    experiment = parse(
        "presets:\n"
        "  - timed\n"
        "  - preset: standard_q\n"
        "    sample: {count: 2, keys: {learner.epsilon: [0.0, 0.1, 0.2]}}\n",
        "my.yaml",
    )
    assert [variant.label for variant in experiment.variants] == [
        "timed",
        "standard_q, draw 1",
        "standard_q, draw 2",
    ]
    assert experiment.n_drawn == 2


# --- What is wrong -------------------------------------------------------------------------------

EPSILON = "learner.epsilon: {start: 0.0, stop: 0.5}"


@pytest.mark.parametrize(
    ("sample", "expected"),
    [
        ("3", "my.yaml:2: sample: value 3: must be a mapping; allowed: the keys count, seed, keys"),
        (f"{{keys: {{{EPSILON}}}}}", "my.yaml:2: sample.count: is missing; allowed: 1 to 10000"),
        (
            f"{{count: 10001, keys: {{{EPSILON}}}}}",
            "my.yaml:2: sample.count: value 10001: must be at most 10000; allowed: 1 to 10000",
        ),
        ("{count: 2, keys: {}}", "my.yaml:2: sample.keys: value {}: has too few items;"),
        (
            "{count: 7, keys: {world.size: [60, 90], trials: {start: 1, stop: 3}}}",
            "my.yaml:2: sample.count: value 7: is more than there are different draws;"
            " allowed: 1 to 6",
        ),
        (
            "{count: 2, keys: {world.size: 60}}",
            "my.yaml:2: sample.keys.'world.size': value 60: has nothing to draw from; allowed: a"
            " list of values, {start, stop}, {log_start, log_stop},"
            " or {same_as: another key of the sample}",
        ),
        (
            "{count: 2, keys: {world.size: {start: 90, stop: 60}}}",
            "my.yaml:2: sample.keys.'world.size': value {'start': 90, 'stop': 60}: is no range;"
            " allowed: start below stop",
        ),
        (
            "{count: 2, keys: {learner.alpha: {log_start: 0, log_stop: 1}}}",
            "my.yaml:2: sample.keys.'learner.alpha': value {'log_start': 0, 'log_stop': 1}: is no"
            " range; allowed: 0 < log_start < log_stop",
        ),
        (
            "{count: 2, keys: {learner.alpha: {start: 0.1, stop: 0.10000000001}}}",
            "my.yaml:2: sample.keys.'learner.alpha': value {'start': 0.1, 'stop': 0.10000000001}:"
            " is too narrow to draw from; allowed: ends that are farther apart",
        ),
        (
            "{count: 2, keys: {learner.alpha: {log_start: 0.1, log_stop: 0.101}}}",
            "my.yaml:2: sample.keys.'learner.alpha': value {'log_start': 0.1, 'log_stop': 0.101}:"
            " is too narrow to draw from; allowed: log_stop at least 1.1 times log_start",
        ),
        (
            "{count: 1, keys: {world.size: [60, 60]}}",
            "my.yaml:2: sample.keys.'world.size'.1: value 60: is there twice; allowed: each once",
        ),
        (
            "{count: 1, keys: {world.size: [60, 90], trials: {same_as: world.sizes}}}",
            "my.yaml:2: sample.keys.trials.same_as: value 'world.sizes': is not drawn;"
            " allowed: world.size",
        ),
        (
            "{count: 1, keys: {extends: [timed]}}",
            "my.yaml:2: sample.keys.extends: value ['timed']: cannot be varied;"
            " allowed: in a preset's file",
        ),
        (
            f"{{count: 2, keys: {{{EPSILON}}}}}\ngrid: {{learner.epsilon: [1]}}",
            "my.yaml:1: learner.epsilon is varied twice; allowed: once in each preset",
        ),
    ],
)
def test_what_cannot_be_drawn_is_refused_where_it_stands(sample: str, expected: str) -> None:
    assert any(line.startswith(expected) for line in complaints(f"sample: {sample}"))


def test_a_range_that_is_wrong_for_a_preset_is_one_problem() -> None:
    (line,) = complaints(
        "sample:\n  count: 50\n  keys:\n    learner.epsilon: {start: 2.0, stop: 3.0}"
    )
    assert line.startswith("my.yaml:5: learner.epsilon: value 2.")
    assert line.endswith("must be at most 1; allowed: 0 to 1")


def test_draws_count_as_variants_before_any_is_made() -> None:
    (line,) = complaints(
        "sample: {count: 9000, keys: {learner.alpha: {start: 0.0, stop: 1.0}}}\n"
        "grid: {learner.epsilon: [0.1, 0.2]}\nseeds: 3"
    )
    assert "asks for 18000 variants with 3 seeds each, 54000 runs" in line
