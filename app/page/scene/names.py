"""What stands written on the board: names, each in the middle of its largest place, and labels."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
import viser
from scipy import ndimage

from app.page.scene.outlines import BOARD_UNITS
from app.page.scene.parts import Writing
from app.picture.layer import Label, Picture

_LEAST_ROOM: Final = 1 / 24
"""Share of the board's side that there is to be at least from the middle of a place to its edge."""
HEIGHT: Final = 0.34
_ABOVE: Final = 0.06
_MOST: Final = 16


def middles(picture: Picture) -> tuple[Label, ...]:
    """Each name in the middle of its largest place, of those that have room."""
    if picture.regions is None:
        return ()
    size = math.isqrt(picture.regions.size)
    found: list[Label] = []
    for number, name in enumerate(picture.names):
        # With a frame, so that the edge of the board is one of the place, too.
        place = np.pad(picture.regions.reshape(size, size) == number, 1)
        room = np.asarray(ndimage.distance_transform_edt(place))[1:-1, 1:-1]
        if room.max() >= _LEAST_ROOM * size:
            north, east = divmod(int(room.argmax()), size)
            found.append(Label(name, east - size // 2, north - size // 2))
    return tuple(found)


class BoardNames(Writing):
    """What stands written on one browser's board, at most so many words."""

    def __init__(self, scene: viser.SceneApi, height: float = HEIGHT) -> None:
        super().__init__(scene, "board/names", height, _MOST)

    def show(self, labels: Sequence[Label], size: int) -> None:
        """Show the first of some labels on a board of so many cells along each side."""
        unit = BOARD_UNITS / size
        self.write(
            [(label.text, (label.east * unit, label.north * unit, _ABOVE)) for label in labels]
        )
