"""Names of what a picture shows, each in the middle of its largest place."""

import math
from typing import Final

import numpy as np
from scipy import ndimage

from app.picture.layer import Label, Picture

_LEAST_ROOM: Final = 1 / 24
"""Share of the board's side that there is to be at least from the middle of a place to its edge."""


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
