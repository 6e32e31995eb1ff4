"""Names on the board, each in the middle of the largest place that it is the name of."""

import math
from typing import Any, Final

import numpy as np
import viser
from scipy import ndimage

from app.page.widgets import assign
from app.picture.layer import Picture

_LEAST_ROOM: Final = 1 / 24
"""Share of the board's side that there is to be at least from the middle of a place to its edge."""
_ABOVE: Final = 0.3
"""Board units."""


def middles(picture: Picture) -> dict[str, int]:
    """Cell in the middle of the place of each name, of those that have room."""
    if picture.regions is None:
        return {}
    size = math.isqrt(picture.regions.size)
    found = {}
    for number, name in enumerate(picture.names):
        # With a frame, so that the edge of the board is one of the place, too.
        place = np.pad(picture.regions.reshape(size, size) == number, 1)
        room = np.asarray(ndimage.distance_transform_edt(place))[1:-1, 1:-1]
        if room.max() >= _LEAST_ROOM * size:
            found[name] = int(room.argmax())
    return found


class BoardNames:
    """What stands written on one browser's board."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._labels: dict[str, Any] = {}

    def show(self, picture: Picture, points: np.ndarray) -> None:
        """Show the names of a picture whose cells lie at ``(y * x, 3)``."""
        found = middles(picture)
        for name, label in self._labels.items():
            assign(label, "visible", name in found)
        for name, cell in found.items():
            place = tuple((points[cell] + np.array([0.0, 0.0, _ABOVE])).tolist())
            label = self._labels.get(name)
            if label is None:
                self._labels[name] = self._scene.add_label(
                    f"/board/names/{len(self._labels)}",
                    name,
                    position=place,
                    anchor="center-center",
                )
            elif tuple(label.position) != place:
                label.position = place

    def remove(self) -> None:
        """Take all names off the board."""
        for label in self._labels.values():
            label.remove()
        self._labels.clear()
