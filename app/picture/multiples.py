"""All headings side by side: a layer for each of them, two rows of four, as one picture.

They lie where the board does otherwise, and take its whole width.
"""

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

from app.live.snapshot import Snapshot
from app.picture.contours import Contour
from app.picture.layer import Extras, Label, Layer, Over, Picture
from app.picture.look import Look
from app.picture.raster import Raster, raster
from app.words.plain import HEADING_NAMES
from sim.spec import N_HEADINGS

SIDE: Final = 60
"""Pixels along each side of one of the eight: half of the board's, so that a frame stays small."""
SHARE: Final = 0.24
"""Side of one of them as a share of the board's."""
_COLUMNS: Final = 4
_GAP: Final = (1 - _COLUMNS * SHARE) / (_COLUMNS - 1)
_NAME: Final = 0.04
"""Room for the name above each."""
_PITCH: Final = SHARE + _NAME + _GAP
HALF_HEIGHT: Final = (2 * _PITCH - _GAP) / 2
"""From the middle of all to their upper edge, as a share of the board's side."""


class Tile(NamedTuple):
    """Where one of the eight lies."""

    heading: int
    east: float
    """Of the middle of all, to its own middle, as a share of the board's side."""
    north: float

    def place(self, points: np.ndarray, side: float) -> np.ndarray:
        """Points ``(..., 2)`` of a whole board of that side, where they lie here."""
        return points * SHARE + np.array([self.east, self.north]) * side


def _tile(heading: int) -> Tile:
    row, column = divmod(heading, _COLUMNS)
    east = (column - (_COLUMNS - 1) / 2) * (SHARE + _GAP)
    return Tile(heading, east, HALF_HEIGHT - _NAME - SHARE / 2 - row * _PITCH)


TILES: Final = tuple(_tile(heading) for heading in range(N_HEADINGS))
"""From east on counter-clockwise, as one reads."""


def tile_at(east: float, north: float) -> Tile | None:
    """The one at a place, as shares of the board's side from the middle of all; None if none is."""
    for tile in TILES:
        if max(abs(east - tile.east), abs(north - tile.north)) <= SHARE / 2:
            return tile
    return None


def all_headings(
    snapshot: Snapshot, look: Look, layer: Layer, extras: Extras, small: Raster | None = None
) -> Picture:
    """A layer for each heading by itself, north up in each, with its name above.

    Pixels are those of the first tile, row by row from the south-west, then those of the next.

    Args:
        snapshot: the moment.
        look: how it is seen.
        layer: what is drawn of each.
        extras: what it shows besides.
        small: what each is drawn on, if not on a square of ``SIDE``.
    """
    world = snapshot.spec.world
    small = raster(world, SIDE) if small is None else small
    each = [
        layer.draw(snapshot, look._replace(frame=tile.heading), extras, small) for tile in TILES
    ]
    names = tuple(
        Label(
            f"prey faces {HEADING_NAMES[tile.heading]}",
            tile.east * world.size,
            (tile.north + SHARE / 2 + _NAME / 2) * world.size,
        )
        for tile in TILES
    )
    return Picture(
        np.concatenate([picture.colours for picture in each]),
        arrows=_joined([picture.arrows for picture in each], world.size),
        arrow_colours=_together([picture.arrow_colours for picture in each]),
        edges=lambda: tuple(_edges(each, world.size)),
        within=lambda: Over(labels=names),
    )


def _edges(each: list[Picture], size: int) -> Iterator[Contour]:
    """Where regions end in each of the pictures; as small as these are, no other line has room."""
    for tile, picture in zip(TILES, each, strict=True):
        for contour in picture.edges():
            yield contour._replace(segments=tile.place(_within(contour.segments, size), size))


def _within(segments: np.ndarray, size: int) -> np.ndarray:
    """The segments ``(n, 2, 2)`` that lie on a board of that size, in cells from the prey."""
    low, high = -0.5 - size // 2, size - 0.5 - size // 2
    return segments[((segments >= low) & (segments <= high)).all(axis=(1, 2))]


def _joined(arrows: list[np.ndarray | None], size: int) -> np.ndarray | None:
    """The arrows of all tiles where they lie, in cells from the middle of all."""
    there = zip(TILES, arrows, strict=True)
    return _together([None if ways is None else tile.place(ways, size) for tile, ways in there])


def _together(parts: list[np.ndarray | None]) -> np.ndarray | None:
    there = [part for part in parts if part is not None]
    return np.concatenate(there) if there else None
