"""Words beside what moves on the board, and beside the prey: none covers another, or a thing."""

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
import viser

from app.page.scene.outlines import BOARD_UNITS
from app.page.widgets import assign

_HEIGHT: Final = 0.36
"""Of a letter's line in board units: 15 pixels on the smallest board, and more on a larger one."""
_LETTER: Final = 0.56 * _HEIGHT
"""What a letter takes along the line, taken large."""
_PAD: Final = 0.12
"""What a word has around it."""
_AROUND: Final = 0.24
"""Half the side of the square that a thing takes, which is to stay in sight."""
_Z: Final = 0.3

_SIDES: Final = ((0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (-1, 1), (1, -1), (-1, -1))
"""Where a word may stand, above what it is of at first."""


class Tag(NamedTuple):
    """A word, and what it stands beside."""

    text: str
    at: tuple[float, float]
    """East and north in board units."""
    within: bool = False
    """Whether it stands in the middle of that place, and not beside a thing there."""


def places_of(tags: Sequence[Tag]) -> list[tuple[float, float]]:
    """Middles of words in board units; the first has the first choice."""
    things = [_box(tag.at, _AROUND, _AROUND) for tag in tags if not tag.within]
    taken: list[np.ndarray] = []
    found: list[tuple[float, float]] = []
    for tag in tags:
        wide, high = len(tag.text) * _LETTER / 2 + _PAD, _HEIGHT / 2 + _PAD
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


class Tags:
    """Words on one board."""

    def __init__(self, scene: viser.SceneApi, name: str) -> None:
        self._scene, self._name = scene, name
        self._labels: list[Any] = []

    def show(self, tags: Sequence[Tag]) -> None:
        """Show these, and no others; what has not changed is not sent."""
        for number, (tag, (east, north)) in enumerate(zip(tags, places_of(tags), strict=True)):
            place = (round(east, 3), round(north, 3), _Z)
            if number == len(self._labels):
                self._labels.append(
                    self._scene.add_label(
                        f"/{self._name}/{number}",
                        tag.text,
                        position=place,
                        anchor="center-center",
                        font_size_mode="scene",
                        font_scene_height=_HEIGHT,
                    )
                )
            label = self._labels[number]
            assign(label, "text", tag.text)
            if tuple(label.position) != place:
                label.position = place
            assign(label, "visible", True)
        for label in self._labels[len(tags) :]:
            assign(label, "visible", False)

    def remove(self) -> None:
        """Take all off the board."""
        for label in self._labels:
            label.remove()
        self._labels.clear()
