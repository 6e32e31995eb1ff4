"""Where things lie on the board, and the lines on it.

The board lies in the plane z = 0, twelve units wide whatever the grid, the prey at the origin. It
is a square, and round where all headings are shown at once: their squares share a circle.
"""

import math
from collections.abc import Sequence

import numpy as np

from app.picture.contours import Contour
from app.picture.frames import rim
from app.picture.layer import Picture
from app.picture.multiples import HALF_HEIGHT, SIDE, TILES
from sim import geometry
from sim.spec import STANDARD_SIZE, WorldSpec
from sim.world import World

BOARD_UNITS = 12.0

_GRID_EVERY = 10
_ARC_POINTS = 48
_CIRCLE_POINTS = 73
_SECTOR_POINTS = 9


def on_picture(
    world: World, cells: np.ndarray, heading: int | np.ndarray, shown: int
) -> np.ndarray:
    """Where cells of a trial lie in a picture whose prey faces another way.

    Args:
        world: the world.
        cells: ``(n,)`` cells.
        heading: the prey's heading in that trial.
        shown: the heading in the picture.

    Returns:
        ``(n, 2) float64`` in board units.
    """
    width = int(world.width)
    middle = world.size // 2
    east = cells % width - 1 - middle
    north = cells // width - 1 - middle
    turn = (shown - np.asarray(heading)) * np.pi / 4
    cos, sin = np.cos(turn), np.sin(turn)
    unit = BOARD_UNITS / world.size
    return np.stack([east * cos - north * sin, east * sin + north * cos], axis=-1) * unit


def cell_centres(spec: WorldSpec) -> np.ndarray:
    """Centres of all cells, ``(y * x, 3) float32`` in board units."""
    east, north = geometry.offsets(spec)
    flat = np.stack([east, north, np.zeros_like(east)], axis=-1).reshape(-1, 3)
    return (flat * BOARD_UNITS / spec.size).astype(np.float32)


def lifted(points: np.ndarray, above: float) -> np.ndarray:
    """Points ``(..., 2)`` of the board so far above it, ``(..., 3) float32``."""
    z = np.full((*points.shape[:-1], 1), above)
    return np.concatenate([points, z], axis=-1).astype(np.float32)


def segments(points: np.ndarray) -> np.ndarray:
    """A line through points ``(n, 2 or 3)`` as segments ``(n - 1, 2, 2 or 3)``."""
    return np.stack([points[:-1], points[1:]], axis=1)


def edges(spec: WorldSpec) -> tuple[float, float]:
    """West (south) and east (north) edge of the board in board units."""
    unit = BOARD_UNITS / spec.size
    middle = spec.size // 2
    return (-0.5 - middle) * unit, (spec.size - 0.5 - middle) * unit


def _rim(spec: WorldSpec) -> float:
    """Radius of the round board in board units."""
    return rim(spec) * BOARD_UNITS / spec.size


def is_on_board(points: np.ndarray, spec: WorldSpec, is_round: bool) -> np.ndarray:
    """Whether points ``(..., 2)`` lie on the board, ``(...) bool``."""
    if is_round:
        return np.asarray(np.hypot(points[..., 0], points[..., 1]) <= _rim(spec))
    low, high = edges(spec)
    return np.asarray(((points >= low) & (points <= high)).all(axis=-1))


def kept_on_board(points: np.ndarray, spec: WorldSpec, is_round: bool) -> np.ndarray:
    """Points ``(..., 2)``, those off the board moved to its edge.

    A trial's square is turned so that the prey looks as it does in the picture, and its corners may
    then lie outside of what is drawn.
    """
    if is_round:
        distance = np.hypot(points[..., 0], points[..., 1])[..., None]
        return points * np.minimum(_rim(spec) / np.maximum(distance, 1e-9), 1.0)
    low, high = edges(spec)
    return np.clip(points, low, high)


def border(spec: WorldSpec, is_round: bool) -> np.ndarray:
    """The edge of the board as segments."""
    if is_round:
        return _circle(_rim(spec))
    low, high = edges(spec)
    return segments(np.array([[low, low], [high, low], [high, high], [low, high], [low, low]]))


def tile_pixels(spec: WorldSpec) -> np.ndarray:
    """Middles of the pixels of all headings side by side, ``(tile * y * x, 3)`` in board units."""
    low, high = edges(spec)
    along = low + (np.arange(SIDE) + 0.5) / SIDE * (high - low)
    north, east = np.meshgrid(along, along, indexing="ij")
    one = np.stack([east.ravel(), north.ravel()], axis=-1)
    return lifted(np.concatenate([tile.place(one, BOARD_UNITS) for tile in TILES]), 0.0)


def tiles_border(spec: WorldSpec) -> np.ndarray:
    """The edges of all headings side by side, as segments.

    The last ones have no length: they are the corners of all that is to be seen, names included.
    """
    square = border(spec, is_round=False)
    squares = np.concatenate([tile.place(square, BOARD_UNITS) for tile in TILES])
    corner = np.array([0.5, HALF_HEIGHT]) * BOARD_UNITS
    corners = np.stack([-corner, corner])
    return np.concatenate([squares, np.stack([corners, corners], axis=1)])


def grid(spec: WorldSpec, is_round: bool) -> np.ndarray:
    """Lines at every tenth cell, as segments."""
    low, high = edges(spec)
    step = _GRID_EVERY * BOARD_UNITS / spec.size
    marks = step * np.arange(math.ceil(low / step), math.floor(high / step) + 1)
    first, last = np.full(len(marks), low), np.full(len(marks), high)
    if is_round:
        marks = marks[np.abs(marks) < _rim(spec)]
        last = np.sqrt(_rim(spec) ** 2 - marks**2)
        first = -last
    ends = [np.stack([marks, first], axis=1), np.stack([marks, last], axis=1)]
    upright = np.stack(ends, axis=1)
    return np.concatenate([upright, upright[..., ::-1]])


def _turned(points: np.ndarray, heading: int) -> np.ndarray:
    """Points drawn for a prey that faces east, for one that faces another way."""
    cos, sin = np.cos(heading * np.pi / 4), np.sin(heading * np.pi / 4)
    return points @ np.array([[cos, sin], [-sin, cos]])


def visual_field(spec: WorldSpec, heading: int) -> np.ndarray:
    """The edge of what a prey sees that faces that way, as segments."""
    radius = spec.vision_radius * BOARD_UNITS / STANDARD_SIZE
    angles = np.linspace(-np.pi / 2, np.pi / 2, _ARC_POINTS)
    arc = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return segments(_turned(np.concatenate([arc, arc[:1]]), heading))


def arrow(heading: int) -> np.ndarray:
    """Where the prey faces, as segments."""
    tip, wing, tail = 0.62, 0.2, 0.12
    shaft = np.array([[tail, 0.0], [tip, 0.0]])
    head = np.array([[tip - wing, wing], [tip, 0.0], [tip - wing, -wing]])
    return np.concatenate([segments(_turned(part, heading)) for part in (shaft, head)])


def _circle(radius: float) -> np.ndarray:
    angles = np.linspace(0, 2 * np.pi, _CIRCLE_POINTS)
    return segments(radius * np.column_stack([np.cos(angles), np.sin(angles)]))


def within(parts: np.ndarray, spec: WorldSpec, is_round: bool) -> np.ndarray:
    """Which of the segments ``(n, 2, 2)`` lie on the board, ``(n,) bool``."""
    return np.asarray(is_on_board(parts, spec, is_round).all(axis=1))


def sensors(spec: WorldSpec, is_round: bool) -> np.ndarray:
    """Rings, and sectors from the first ring outwards."""
    unit = BOARD_UNITS / spec.size
    edges = geometry.ring_edges(spec) * unit
    parts = [_circle(edge) for edge in edges]
    radii = np.linspace(float(edges[0]), float(edges[-1]), 40)
    for sector in range(spec.n_directions):
        angle = (sector + 0.5) * 2 * np.pi / spec.n_directions
        parts.append(segments(radii[:, None] * np.array([[np.cos(angle), np.sin(angle)]])))
    lines = np.concatenate(parts)
    return lines[within(lines, spec, is_round)]


def region_lines(mask: np.ndarray, spec: WorldSpec, heading: int, is_round: bool) -> np.ndarray:
    """The edge of a region of sensor readings.

    Args:
        mask: ``(distance, direction) bool``, of a prey that looks east.
        spec: of the world.
        heading: where the prey looks in the picture.
        is_round: whether the board is.

    Returns:
        Segments ``(n, 2, 2)`` in board units.
    """
    turned = np.roll(mask, heading * spec.n_directions // 8, axis=1)
    radii = np.concatenate([[0.0], geometry.ring_edges(spec)]) * (BOARD_UNITS / spec.size)
    wide = 2 * np.pi / spec.n_directions
    parts = [np.zeros((0, 2, 2))]
    outwards = turned != np.concatenate([turned[1:], np.zeros_like(turned[:1])])
    for ring, sector in np.argwhere(outwards):
        angles = (sector + np.linspace(-0.5, 0.5, _SECTOR_POINTS)) * wide
        arc = radii[ring + 1] * np.column_stack([np.cos(angles), np.sin(angles)])
        parts.append(segments(arc))
    for ring, sector in np.argwhere(turned != np.roll(turned, -1, axis=1)):
        angle = (sector + 0.5) * wide
        along = np.linspace(radii[ring], radii[ring + 1], _SECTOR_POINTS)
        parts.append(segments(along[:, None] * np.array([[np.cos(angle), np.sin(angle)]])))
    lines = np.concatenate(parts)
    return lines[within(lines, spec, is_round)]


def start_zone(spec: WorldSpec) -> np.ndarray:
    """Where predators start, as segments."""
    unit = BOARD_UNITS / STANDARD_SIZE
    return np.concatenate([_circle(radius * unit) for radius in spec.start_radius])


def contour_lines(
    contours: Sequence[Contour], spec: WorldSpec, is_round: bool
) -> tuple[np.ndarray, np.ndarray]:
    """The parts of contours that lie on the board, and their colours, both ends of each.

    Returns:
        ``(n, 2, 2)`` in board units and ``(n, 2, 3) uint8``.
    """
    if not contours:
        return np.zeros((0, 2, 2)), np.zeros((0, 2, 3), np.uint8)
    parts = np.concatenate([contour.segments for contour in contours]) * (BOARD_UNITS / spec.size)
    counts = [len(contour.segments) for contour in contours]
    colours = np.repeat(
        np.array([contour.colour for contour in contours], np.uint8), counts, axis=0
    )
    there = within(parts, spec, is_round)
    return parts[there], np.repeat(colours[there][:, None], 2, axis=1)


def arrow_lines(picture: Picture, spec: WorldSpec, is_round: bool) -> tuple[np.ndarray, np.ndarray]:
    """The arrows of a picture that lie on the board.

    Returns:
        Segments ``(3 n, 2, 2)`` in board units, the shafts first, and which arrows these are,
        ``(arrow,) bool``.
    """
    if picture.arrows is None:
        return np.zeros((0, 2, 2)), np.zeros(0, bool)
    unit = BOARD_UNITS / spec.size
    there = within(picture.arrows * unit, spec, is_round)
    shown = picture.arrows[there]
    tails, heads = shown[:, 0], shown[:, 1]
    back = 0.38 * (tails - heads)
    left = heads + back @ np.array([[0.8, 0.6], [-0.6, 0.8]])
    right = heads + back @ np.array([[0.8, -0.6], [0.6, 0.8]])
    pairs = [np.stack(pair, axis=1) for pair in ((tails, heads), (heads, left), (heads, right))]
    return np.concatenate(pairs) * unit, there
