"""What searches found is what the experiments that try it on other seeds run.

``docs/replication.json`` holds the best variants of the shipped searches.
"""

import json
from typing import Any

import pytest

from app.documents import experiments
from app.replication.variants import SEARCHED_FOR
from app.replication.write import NUMBERS
from tests.support.pages import ROOT

TRIED = [
    ("baselines", "standard Q, tuned for the end", "baselines_search", "standard_q", 0),
    ("baselines", "standard Q, tuned for speed", "baselines_search", "standard_q", 1),
    ("baselines", "timed, tuned for the end", "baselines_search", "timed", 0),
    ("baselines", "timed, tuned for speed", "baselines_search", "timed", 1),
    ("baselines", "timed, better schedule, tuned for speed", "baselines_search", "timed", 1),
    ("timing_test", "best of timing_seven", "timing_seven", "timed", 0),
]
"""An experiment and its variant, the search, the preset that was searched, and the criterion."""


@pytest.fixture(scope="module")
def kept() -> dict[str, Any]:
    return json.loads((ROOT / "docs" / NUMBERS).read_text("utf-8"))["searches"]


def overrides_of(experiment: str, label: str) -> dict[str, Any]:
    variants = {variant.label: variant for variant in experiments.load(experiment).variants}
    return dict(variants[label].overrides)


@pytest.mark.parametrize("search", ["baselines_search", "timing_seven"])
def test_what_is_kept_is_of_the_search_that_is_shipped(search: str, kept: dict[str, Any]) -> None:
    for of_preset in kept[search].values():
        assert list(of_preset) == list(SEARCHED_FOR)
        for best in of_preset.values():
            assert overrides_of(search, best["variant"]) == best["sets"]


@pytest.mark.parametrize(("experiment", "label", "search", "preset", "criterion"), TRIED)
def test_what_is_tried_is_what_was_found(
    experiment: str, label: str, search: str, preset: str, criterion: int, kept: dict[str, Any]
) -> None:
    best = kept[search][preset][SEARCHED_FOR[criterion]]
    assert overrides_of(experiment, label) == best["sets"]


def test_nothing_is_tried_on_the_seeds_of_a_search() -> None:
    searched = {*experiments.load("baselines_search").seeds}
    searched |= {*experiments.load("timing_seven").seeds}
    for name, *_ in TRIED:
        assert not searched & {*experiments.load(name).seeds}
