"""Words on the board: beside what they are of, and never over one another."""

import itertools

import numpy as np
import pytest

from app.picture.outlines import BOARD_UNITS
from app.player.tags import Tag, places_of, room_of

HALF = BOARD_UNITS / 2


def overlap(tags: list[Tag]) -> bool:
    """Whether two of some words cover each other."""
    boxes = [
        (np.array(place) - room_of(tag.text), np.array(place) + room_of(tag.text))
        for tag, place in zip(tags, places_of(tags), strict=True)
    ]
    return any(
        bool(((one[0] < other[1] - 1e-6) & (other[0] < one[1] - 1e-6)).all())
        for one, other in itertools.combinations(boxes, 2)
    )


@pytest.mark.parametrize("word", ["predator", "noticed", "out of time", "caught"])
def test_wherever_the_predator_is_no_word_covers_another(word: str) -> None:
    places = np.linspace(-HALF, HALF, 31)
    for east, north in itertools.product(places.tolist(), places.tolist()):
        tags = [
            Tag("what it sees", (1.3, 1.05), within=True),
            Tag("prey", (0.0, 0.0)),
            Tag(word, (east, north)),
        ]
        assert not overlap(tags)
        assert places_of(tags)[0] == (1.3, 1.05)


def test_words_stand_clear_of_what_else_is_to_be_seen() -> None:
    tag = Tag("prey", (0.0, 0.0))
    ((east, north),) = places_of([tag], [(0.0, 0.5), (0.0, -0.5)])
    assert north == 0.0
    assert east > 0.0


def test_a_word_stays_on_the_board_and_off_its_thing() -> None:
    for east, north in itertools.product((-5.9, 0.0, 5.9), (-5.9, 0.0, 5.9)):
        tag = Tag("predator", (east, north))
        (place,) = places_of([tag])
        assert (np.abs(place) + room_of(tag.text) <= HALF + 0.2).all()
        assert (np.abs(np.array(place) - tag.at) > room_of(tag.text) - 1e-6).any()


def test_a_word_stands_above_if_nothing_is_there() -> None:
    ((east, north),) = places_of([Tag("predator", (2.0, -3.0))])
    assert east == 2.0
    assert north > -3.0
