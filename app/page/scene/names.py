"""What stands written on the board: names, each in the middle of its largest place, and labels."""

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import viser
from scipy import ndimage

from app.page.scene.outlines import BOARD_UNITS
from app.page.scene.parts import AWAY
from app.page.widgets import assign
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


class BoardNames:
    """What stands written on one browser's board, at most so many words."""

    def __init__(self, scene: viser.SceneApi, height: float = HEIGHT) -> None:
        """``height`` is that of writing, in board units, so that it grows with the board."""
        # All at once: a board that takes the place of another one in a page has what that has.
        self._written: list[Any] = [
            scene.add_label(
                f"/board/names/{number}",
                "",
                position=AWAY,
                anchor="center-center",
                font_size_mode="scene",
                font_scene_height=height,
                visible=False,
            )
            for number in range(_MOST)
        ]

    def show(self, labels: Sequence[Label], size: int) -> None:
        """Show the first of some labels on a board of so many cells along each side."""
        labels = labels[:_MOST]
        unit = BOARD_UNITS / size
        for written, label in zip(self._written, labels, strict=False):
            place = (label.east * unit, label.north * unit, _ABOVE)
            assign(written, "text", label.text)
            if tuple(written.position) != place:
                written.position = place
            assign(written, "visible", True)
        for written in self._written[len(labels) :]:
            assign(written, "visible", False)

    def remove(self) -> None:
        """Take everything off the board."""
        for written in self._written:
            written.remove()
        self._written.clear()
