"""A board that was sent (:mod:`app.player.boards`) as shapes: what the scripts of
``app/web/player`` draw on a canvas, for pictures in files and on paper.
"""

import base64
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from app.player.shapes import Area, Box, Disc, Lines, Pixels, Points, Shape, Words, width_of

_UNITS: Final = 12
"""The board of the lab is so many units wide, in which sizes of things on it are given."""
_WIDTHS_FOR: Final = 640
"""Pixels along each side of the board for which the widths of lines are meant."""
_BORDER, _FIELD, _ARROW, _TRAIL = 2.0, 3.0, 4.0, 3.0
_PREY, _PREDATOR, _HALO, _END, _RIM = 0.13, 0.13, 0.17, 0.1, 1.5
_TAIL, _TIP, _WING = 0.12, 0.62, 0.2
_BARB: Final = 0.38
"""Wings of an arrow among many, as a share of it."""
_LABEL, _TILE_LABEL, _TAG = 0.34, 0.29, 0.42
_TRAIL_PIECES: Final = 12
_ARC: Final = 144
"""Straight pieces of a circle."""
# In the order in which one lies over another, where they differ.
_PATTERNS: Final = ("falling", "rising", "dots")


class _Place(NamedTuple):
    """Where a board lies in a picture."""

    x: float
    """Of the middle of the prey's cell."""
    y: float
    cell: float
    """Pixels of a cell."""
    size: int
    """Cells along each side."""

    def to(self, east: float, north: float) -> tuple[float, float]:
        return self.x + east * self.cell, self.y - north * self.cell

    def way(self, points: Sequence[float]) -> Points:
        return [self.to(*points[i : i + 2]) for i in range(0, len(points), 2)]

    @property
    def side(self) -> float:
        return self.size * self.cell

    @property
    def unit(self) -> float:
        return self.side / _UNITS

    @property
    def corner(self) -> tuple[float, float]:
        """The upper left one."""
        low = -0.5 - self.size // 2
        return self.to(low, low + self.size)

    def width(self, width: float) -> float:
        return max(width * min(max(self.side / _WIDTHS_FOR, 0.5), 1.6), 0.9)


def sketch(
    board: Mapping[str, Any], world: Mapping[str, Any], x: float, y: float, side: float
) -> Iterator[Shape]:
    """The shapes of a board.

    Args:
        board: as it was sent.
        world: that it is of, as that was sent.
        x: left edge of the board.
        y: its upper edge.
        side: its width and height.
    """
    size = int(world["size"])
    cell = side / size
    middle = (size // 2 + 0.5) * cell
    whole = _Place(x + middle, y + side - middle, cell, size)
    places = _tiles(whole, world) if board["tiles"] else [whole]
    for number, place in enumerate(places):
        yield _ground(board, world, place, number)
    for line in board["lines"]:
        ways = [whole.way(points) for points in line["points"]]
        if line.get("arrows"):
            ways += [_wings(way) for way in ways]
        yield Lines(ways, line["colour"], whole.width(line["width"]))
    tiles = [number if board["tiles"] else None for number in range(len(places))]
    for tile, place in zip(tiles, places, strict=True):
        yield from _border(board, world, place, tile)
    if board["hunt"] is not None:
        yield from _ends(board, whole)
    for tile, place in zip(tiles, places, strict=True):
        yield from _prey(board, place, tile)
    if board["hunt"] is not None:
        yield from _predator(board, whole)
    for label in board["labels"]:
        height = _TILE_LABEL if board["tiles"] else _LABEL
        yield from _word(board["theme"], whole, label, height)


def _wings(arrow: Points) -> Points:
    """The wings of an arrow from its tail to its head, as a line from one over the tip."""
    (from_x, from_y), (x, y) = arrow
    back_x, back_y = _BARB * (from_x - x), _BARB * (from_y - y)
    # To both sides of the shaft, by a triangle of sides 3, 4 and 5.
    return [
        (x + 0.8 * back_x - 0.6 * back_y, y + 0.6 * back_x + 0.8 * back_y),
        (x, y),
        (x + 0.8 * back_x + 0.6 * back_y, y - 0.6 * back_x + 0.8 * back_y),
    ]


def _tiles(whole: _Place, world: Mapping[str, Any]) -> list[_Place]:
    share, places = world["tiles"]["share"], world["tiles"]["places"]
    return [
        _Place(*whole.to(e * whole.size, n * whole.size), whole.cell * share, whole.size)
        for e, n in places
    ]


def _ground(
    board: Mapping[str, Any], world: Mapping[str, Any], place: _Place, number: int
) -> Pixels:
    side = int(world["tiles"]["side"] if board["tiles"] else world["size"])
    pixels = np.zeros((side, side, 4), np.uint8)
    pixels[..., :3] = colours_on(board, world, side, number)[::-1]
    pixels[..., 3] = 255
    if board["round"]:
        away = np.arange(side) - side // 2
        pixels[np.hypot(away[:, None], away)[::-1] > world["rim"]] = 0
    return Pixels(*place.corner, place.side, place.side, pixels)


def colours_on(
    board: Mapping[str, Any], world: Mapping[str, Any], side: int, number: int = 0
) -> np.ndarray:
    """What is drawn on a board, ``(y, x, 3) uint8`` from the south-west on.

    Args:
        board: as it was sent.
        world: that it is of.
        side: pixels along each side.
        number: of the tile, if there are tiles.
    """
    if board["by"] == "cell":
        every = np.frombuffer(base64.b64decode(board["colours"]), np.uint8)
        return every.reshape(-1, side, side, 3)[number]
    size = int(world["size"])
    states = np.frombuffer(base64.b64decode(world["states"]), "<u2").reshape(size, size)
    along = (np.arange(side) * 2 + 1) * size // (2 * side)
    under = states[along[:, None], along]
    east, north = along[None, :], along[:, None]
    on = {
        "falling": (east + north) % 4 == 0,
        "rising": (east - north) % 4 == 0,
        "dots": (east % 3 == 1) & (north % 3 == 1),
    }

    def of(plane: str) -> np.ndarray:
        colours = np.frombuffer(base64.b64decode(board[plane]), np.uint8).reshape(-1, 3)
        n_states = int(world["n_states"])
        return colours[number * n_states : (number + 1) * n_states][under]

    plain = of("colours")
    found = plain
    for pattern in _PATTERNS:
        if pattern in board:
            colours = of(pattern)
            differs = on[pattern][..., None] & (colours != plain).any(axis=-1, keepdims=True)
            found = np.where(differs, colours, found)
    return found


def _arc(place: _Place, radius: float, first: float, last: float) -> list[tuple[float, float]]:
    """Points on a circle round the prey, ``radius`` in cells, angles counter-clockwise."""
    angles = np.linspace(first, last, _ARC + 1)
    return [place.to(radius * math.cos(a), radius * math.sin(a)) for a in angles.tolist()]


def _heading(board: Mapping[str, Any], tile: int | None) -> int | None:
    """Where the prey looks; None where that does not matter."""
    return board["prey"] if tile is None or board["prey"] is None else tile


def _border(
    board: Mapping[str, Any], world: Mapping[str, Any], place: _Place, tile: int | None
) -> Iterator[Shape]:
    """The border of a board, and what the prey sees."""
    theme = board["theme"]
    if board["round"]:
        border: Points = _arc(place, world["rim"], 0.0, 2 * math.pi)
    else:
        (left, top), side = place.corner, place.side
        right, bottom = left + side, top + side
        border = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)]
    yield Lines([border], theme["border"], place.width(_BORDER))
    heading = _heading(board, tile)
    if heading is not None and board["sees"]:
        angle = heading * math.pi / 4
        half = _arc(place, world["field"], angle - math.pi / 2, angle + math.pi / 2)
        yield Lines([[*half, half[0]]], theme["field"], place.width(_FIELD))


def _prey(board: Mapping[str, Any], place: _Place, tile: int | None) -> Iterator[Shape]:
    """The prey, and where it looks; both larger in a tile, which is small."""
    theme, heading = board["theme"], _heading(board, tile)
    long = (1 if tile is None else 2) * place.unit
    yield Disc(place.x, place.y, _PREY * long, theme["prey"])
    if heading is None:
        return
    angle = heading * math.pi / 4

    def turned(ahead: float, left: float) -> tuple[float, float]:
        cos, sin = math.cos(angle), math.sin(angle)
        return (
            place.x + (ahead * cos - left * sin) * long,
            place.y - (ahead * sin + left * cos) * long,
        )

    shaft = [turned(_TAIL, 0), turned(_TIP, 0)]
    head = [turned(_TIP - _WING, _WING), turned(_TIP, 0), turned(_TIP - _WING, -_WING)]
    yield Lines([shaft, head], theme["prey"], place.width(_ARROW))


def _ends(board: Mapping[str, Any], place: _Place) -> Iterator[Shape]:
    """The way of the predator, and where the last trials ended."""
    hunt, theme, unit = board["hunt"], board["theme"], place.unit
    trail, ended = place.way(hunt["trail"]), hunt.get("ended")
    last = len(trail) - 1
    pieces = 0 if last < 1 else 1 if ended else min(_TRAIL_PIECES, last)
    for piece in range(pieces):
        first, until = round(piece * last / pieces), round((piece + 1) * last / pieces)
        shade = _between(theme["unknown"], theme["predator"], (piece + 1) / pieces)
        colour = ended["colour"] if ended else shade
        yield Lines([trail[first : until + 1]], colour, place.width(_TRAIL))
    for east, north, _, _ in hunt["ends"]:
        yield Disc(*place.to(east, north), _END * _RIM * unit, theme["unknown"])
    for east, north, shape, colour in hunt["ends"]:
        yield _dot(*place.to(east, north), _END * unit, shape, colour)


def _predator(board: Mapping[str, Any], place: _Place) -> Iterator[Shape]:
    hunt, theme, unit = board["hunt"], board["theme"], place.unit
    ended = hunt.get("ended")
    if hunt["predator"] is None:
        return
    x, y = place.to(*hunt["predator"])
    yield Disc(x, y, _HALO * unit, theme["unknown"])
    yield Disc(x, y, _PREDATOR * unit, theme["predator"])
    if ended:
        yield _dot(x, y, _END * unit, ended["shape"], ended["colour"])
    for word in hunt["words"]:
        yield from _word(theme, place, word, _TAG)


def _dot(x: float, y: float, radius: float, shape: str, colour: str) -> Shape:
    if shape == "circle":
        return Disc(x, y, radius, colour)
    if shape == "square":
        return Box(x - radius, y - radius, 2 * radius, 2 * radius, colour)
    around = [(x - radius, y), (x, y - radius), (x + radius, y), (x, y + radius)]
    return Area(around, colour)


def _between(first: str, last: str, share: float) -> str:
    ends = [[int(part) for part in re.findall(r"\d+", colour)] for colour in (first, last)]
    parts = (round(a + (b - a) * share) for a, b in zip(*ends, strict=True))
    return f"rgb({','.join(map(str, parts))})"


def _word(
    theme: Mapping[str, Any], place: _Place, label: Sequence[Any], height: float
) -> Iterator[Shape]:
    text, east, north = label
    if not text:
        return
    size = max(height * place.unit * 0.95, 9.5)
    x, y = place.to(east, north)
    wide, high = width_of(text, size) + size * 0.4, size * 1.15
    patch = x - wide / 2, y - high / 2, wide, high
    yield Box(*patch, theme["unknown"], opacity=0.88, radius=size * 0.2)
    yield Words(x, y + size * 0.35, text, size, theme["ink"], anchor="middle")
