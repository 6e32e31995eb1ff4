"""What stands written on the board: names, each in the middle of its largest place, and labels."""

import math
from typing import Any, Final

import numpy as np
import viser
from scipy import ndimage

from app.page.scene.outlines import BOARD_UNITS
from app.page.widgets import assign
from app.picture.layer import Label, Picture

_LEAST_ROOM: Final = 1 / 24
"""Share of the board's side that there is to be at least from the middle of a place to its edge."""
_HEIGHT: Final = 0.32
"""Of writing, in board units, so that it grows with the board."""
_ABOVE: Final = 0.06


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
    """What stands written on one browser's board."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._written: list[Any] = []

    def show(self, picture: Picture, size: int) -> None:
        """Show what is written on a picture of a board of so many cells along each side."""
        labels = (*middles(picture), *picture.labels)
        unit = BOARD_UNITS / size
        for number, label in enumerate(labels):
            place = (label.east * unit, label.north * unit, _ABOVE)
            if number == len(self._written):
                self._written.append(
                    self._scene.add_label(
                        f"/board/names/{number}",
                        label.text,
                        position=place,
                        font_size_mode="scene",
                        font_scene_height=_HEIGHT,
                        anchor="center-center",
                    )
                )
            written = self._written[number]
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
