"""Words beside what moves on the board, and beside the prey: none covers another, or a thing."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from app.picture.outlines import BOARD_UNITS

HEIGHT: Final = 0.42
"""Of a line of letters in board units: 13 pixels on the board of a phone, and more on others."""
_LETTER: Final = 0.5 * HEIGHT
"""What a letter takes along the line, taken large."""
_PAD: Final = 0.12
"""What a word has around it."""
_AROUND: Final = 0.24
"""Half the side of the square that a thing takes, which is to stay in sight."""
_SIDES: Final = ((0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (-1, 1), (1, -1), (-1, -1))
"""Where a word may stand, above what it is of at first."""


class Tag(NamedTuple):
    """A word, and what it stands beside."""

    text: str
    at: tuple[float, float]
    """East and north in board units."""
    within: bool = False
    """Whether it stands in the middle of that place, and not beside a thing there."""


def room_of(text: str) -> np.ndarray:
    """Half the width and half the height of a word with what it has around it, in board units."""
    return np.array([len(text) * _LETTER / 2 + _PAD, HEIGHT / 2 + _PAD])


def places_of(
    tags: Sequence[Tag], clear: Sequence[tuple[float, float]] = ()
) -> list[tuple[float, float]]:
    """Middles of words in board units; the first has the first choice.

    They stand clear of what they are of, and of the places ``clear``.
    """
    there = [tag.at for tag in tags if not tag.within]
    things = [_box(at, _AROUND, _AROUND) for at in (*there, *clear)]
    taken: list[np.ndarray] = []
    found: list[tuple[float, float]] = []
    for tag in tags:
        wide, high = room_of(tag.text).tolist()
        places = [tag.at]
        if not tag.within:
            places = [
                (tag.at[0] + x * (wide + _AROUND), tag.at[1] + y * (high + _AROUND))
                for x, y in _SIDES
            ]
        place = min(
            places, key=lambda at: _overlap(_box(at, wide, high), [*taken, *things]), default=tag.at
        )
        taken.append(_box(place, wide, high))
        found.append(place)
    return found


def _box(middle: tuple[float, float], wide: float, high: float) -> np.ndarray:
    """West, south, east and north edge."""
    (x, y) = middle
    return np.array([x - wide, y - high, x + wide, y + high])


def _overlap(box: np.ndarray, others: Sequence[np.ndarray]) -> float:
    """How much of a box others cover, and what lies off the board."""
    half = BOARD_UNITS / 2
    inside = _shared(box, np.array([-half, -half, half, half]))
    area = float((box[2] - box[0]) * (box[3] - box[1]))
    return round(area - inside + sum(_shared(box, other) for other in others), 6)


def _shared(one: np.ndarray, other: np.ndarray) -> float:
    """Area that two boxes have in common."""
    width, height = np.minimum(one[2:], other[2:]) - np.maximum(one[:2], other[:2])
    return float(max(width, 0.0) * max(height, 0.0))
