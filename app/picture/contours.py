"""Lines through a map over states: where a quantity has a level, and where a region ends.

A map over states is one over the plane of distance and direction. Lines are found there, where the
middles of states form a grid, and then bent round the prey, so that they are as smooth on a board
of any size as the sensors' rings are.
"""

from collections.abc import Iterable
from typing import NamedTuple

import contourpy
import numpy as np

from app.picture.theme import Colour
from sim import geometry
from sim.spec import WorldSpec

_PIECE = np.radians(4)
"""A line is drawn as straight pieces that turn so far round the prey at most."""


class Isoline(NamedTuple):
    """One line on which a quantity has a level."""

    level: float
    points: np.ndarray
    """(n, 2) float64: along the line, in cells east and north of the prey."""


class Contour(NamedTuple):
    """A line that a picture has on the board."""

    segments: np.ndarray
    """(n, 2, 2) float64: from where to where, in cells east and north of the prey."""
    colour: Colour
    is_edge: bool = False
    """Whether a region ends there, which is drawn thicker."""


def isolines(per_state: np.ndarray, world: WorldSpec, levels: Iterable[float]) -> list[Isoline]:
    """Lines through a map over states, linear between the middles of states.

    Args:
        per_state: ``(distance, direction)``, NaN where it is not known; no line runs there.
        world: whose sensors tell the states apart.
        levels: of the lines, in the quantity's unit.
    """
    width = 2 * np.pi / world.n_directions
    outer = geometry.ring_edges(world)
    radius = (outer + np.concatenate([[0.0], outer[:-1]])) / 2
    # The first sector once more at the end: lines go all round the prey.
    angle = np.arange(world.n_directions + 1) * width
    around = np.concatenate([per_state, per_state[:, :1]], axis=1).astype(np.float64)
    maker = contourpy.contour_generator(
        angle, radius, np.ma.masked_invalid(around), line_type=contourpy.LineType.Separate
    )
    found: list[Isoline] = []
    for level in levels:
        found += [Isoline(level, _bent(np.asarray(line))) for line in maker.lines(level)]
    return found


def edges(region: np.ndarray, world: WorldSpec) -> np.ndarray:
    """Where a region of states ends, as segments ``(n, 2, 2)`` in cells from the prey.

    Along the arcs and rays that part its states from others; the border of the board is none.

    Args:
        region: ``(distance, direction) bool``.
        world: whose sensors tell the states apart.
    """
    width = 2 * np.pi / world.n_directions
    outer = geometry.ring_edges(world)
    inner = np.concatenate([[0.0], outer[:-1]])
    rings, sectors = np.nonzero(region[:-1] != region[1:])
    pieces = max(int(np.ceil(width / _PIECE)), 1)
    turns = (np.arange(pieces + 1) / pieces - 0.5) * width
    angles = sectors[:, None] * width + turns
    arcs = _polar(angles, np.broadcast_to(outer[rings][:, None], angles.shape))
    rings, sectors = np.nonzero(region != np.roll(region, -1, axis=1))
    ends = np.stack([inner[rings], outer[rings]], axis=1)
    rays = _polar(np.broadcast_to((sectors[:, None] + 0.5) * width, ends.shape), ends)
    return np.concatenate([segments(line) for line in (arcs, rays)])


def segments(lines: np.ndarray) -> np.ndarray:
    """Lines through points ``(..., n, 2)`` as segments ``(m, 2, 2)``."""
    return np.stack([lines[..., :-1, :], lines[..., 1:, :]], axis=-2).reshape(-1, 2, 2)


def _polar(angle: np.ndarray, radius: np.ndarray) -> np.ndarray:
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)


def _bent(line: np.ndarray) -> np.ndarray:
    """A line through ``(angle, radius)`` as one on the board, in pieces that are short enough."""
    turn = np.abs(np.diff(line[:, 0]))
    count = np.maximum(np.ceil(turn / _PIECE), 1).astype(np.int64)
    at = np.concatenate([[0], np.cumsum(count)])
    every = np.arange(int(count.sum()) + 1)
    return _polar(np.interp(every, at, line[:, 0]), np.interp(every, at, line[:, 1]))
