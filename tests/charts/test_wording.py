"""Numbers and names as charts write them."""

import re
from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.analysis.passages import Passage, arrivals
from app.charts.wording import short_label, shown_median
from app.words.numbers import in_millions


@given(st.text(max_size=80), st.integers(1, 60))
def test_shortened_texts_fit(text: str, characters: int) -> None:
    short = short_label(text, characters)
    assert len(short) <= characters
    assert short == text or "…" in short


def test_the_values_in_a_label_outlive_its_keys() -> None:
    label = "timed, circle_clockwise.at=12000, avoid.at=14500"
    for characters in range(20, len(label)):
        short = short_label(label, characters)
        assert len(short) <= characters
        assert re.search(r"=12000, .*=14500$", short), short


@pytest.mark.parametrize(
    ("reached", "ended", "text"),
    [
        ([2.41e6], [], "2.41"),
        ([], [5.5e6], "more than 5.50"),
        ([], [5.5e6, 5.5e6], "more than 5.50"),
        ([1e6, 2e6], [5.5e6, 5.5e6, 5.5e6], "more than 5.50 [1.00, ∞]"),
    ],
)
def test_medians_of_passages_are_as_certain_as_their_runs(
    reached: Sequence[float], ended: Sequence[float], text: str
) -> None:
    passages = [Passage(steps, False) for steps in reached]
    passages += [Passage(steps, True) for steps in ended]
    assert shown_median(arrivals(passages), in_millions) == text
