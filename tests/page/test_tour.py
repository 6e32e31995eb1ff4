"""The tour says little at each stop, and the page's script knows what each is about."""

import re
from pathlib import Path

import pytest

from app.page import tour
from app.page.tour import STOPS, Stop, tour_html
from tests.support.person import words

SCRIPT = Path(tour.__file__).parents[1] / "web" / "tour.js"


@pytest.mark.parametrize("stop", STOPS, ids=lambda stop: stop.at)
def test_a_stop_has_thirty_words_at_most_and_is_about_something_that_the_script_finds(
    stop: Stop,
) -> None:
    text = words("".join(stop.text))
    assert len(text.split()) <= 30
    assert text.endswith(".")
    assert re.search(rf"^  {stop.at}: \(\) =>", SCRIPT.read_text("utf-8"), re.MULTILINE)


def test_there_are_as_many_stops_as_are_offered() -> None:
    html = tour_html(0)
    assert html.count("data-at=") == 5
    assert "See five stops" in html


def test_a_command_for_the_tour_is_counted() -> None:
    assert 'data-times="3"' in tour_html(3)
