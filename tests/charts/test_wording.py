"""Numbers and names as charts write them."""

import re

from hypothesis import given
from hypothesis import strategies as st

from app.charts.wording import short_label


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
