"""Where things lie on the board, and the lines on it.

The board lies in the plane z = 0, twelve units wide whatever the grid, the prey at the origin.
"""

import numpy as np

from app.picture.layer import Picture
from sim import geometry
from sim.spec import STANDARD_SIZE, WorldSpec
from sim.world import World

BOARD_UNITS = 12.0

_GRID_EVERY = 10
_ARC_POINTS = 48
_CIRCLE_POINTS = 73


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


def kept_on_board(points: np.ndarray, spec: WorldSpec, is_round: bool) -> np.ndarray:
    """Points ``(..., 2)``, those off the board moved to its edge.

    A trial's square is turned so that the prey looks as it does in the picture, and its corners may
    then lie outside of what is drawn.
    """
    low, high = edges(spec)
    return np.clip(points, low, high)


def border(spec: WorldSpec) -> np.ndarray:
    """The edge of the board as segments ``(4, 2, 2)``."""
    low, high = edges(spec)
    return segments(np.array([[low, low], [high, low], [high, high], [low, high], [low, low]]))


def grid(spec: WorldSpec) -> np.ndarray:
    """Lines at every tenth cell, as segments."""
    low, high = edges(spec)
    step = _GRID_EVERY * BOARD_UNITS / spec.size
    marks = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step
    lines = [np.array([[mark, low], [mark, high]]) for mark in marks]
    lines += [np.array([[low, mark], [high, mark]]) for mark in marks]
    return np.concatenate([segments(line) for line in lines])


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


def within(parts: np.ndarray, spec: WorldSpec) -> np.ndarray:
    """The segments ``(n, 2, 2)`` that lie on the board."""
    low, high = edges(spec)
    return parts[((parts >= low) & (parts <= high)).all(axis=(1, 2))]


def sensors(spec: WorldSpec) -> np.ndarray:
    """Rings, and sectors from the first ring outwards."""
    unit = BOARD_UNITS / spec.size
    edges = geometry.ring_edges(spec) * unit
    parts = [_circle(edge) for edge in edges]
    radii = np.linspace(edges[0], edges[-1], 40)
    for sector in range(spec.n_directions):
        angle = (sector + 0.5) * 2 * np.pi / spec.n_directions
        parts.append(segments(radii[:, None] * np.array([[np.cos(angle), np.sin(angle)]])))
    return within(np.concatenate(parts), spec)


def start_zone(spec: WorldSpec) -> np.ndarray:
    """Where predators start, as segments."""
    unit = BOARD_UNITS / STANDARD_SIZE
    return np.concatenate([_circle(radius * unit) for radius in spec.start_radius])


def arrow_lines(picture: Picture, spec: WorldSpec) -> np.ndarray:
    """The arrows of a picture as segments ``(3 n, 2, 2)`` in board units."""
    if picture.arrows is None or not len(picture.arrows):
        return np.zeros((0, 2, 2))
    tails, heads = picture.arrows[:, 0], picture.arrows[:, 1]
    back = 0.38 * (tails - heads)
    left = heads + back @ np.array([[0.8, 0.6], [-0.6, 0.8]])
    right = heads + back @ np.array([[0.8, -0.6], [0.6, 0.8]])
    pairs = [np.stack(pair, axis=1) for pair in ((tails, heads), (heads, left), (heads, right))]
    return np.concatenate(pairs) * (BOARD_UNITS / spec.size)
