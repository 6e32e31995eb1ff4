"""From states to pixels: which state lies under each pixel of the board.

Arrays over the board are ``(y, x)``, row by row from the south-west.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from sim import geometry
from sim.spec import WorldSpec


class Raster(NamedTuple):
    """A square of pixels over the board, row by row from the south-west."""

    cells: np.ndarray
    """(pixel,) int64: the board's cell under each pixel, ``y * size + x``."""
    states: np.ndarray
    """(pixel,) int64: its state, ``distance * n_directions + direction``."""

    @property
    def side(self) -> int:
        """Pixels along each side."""
        return math.isqrt(len(self.cells))


def raster(world: WorldSpec, side: int | None = None) -> Raster:
    """The board in so many pixels along each side; one for each cell unless given."""
    return _raster(sensors_of(world), side or world.size)


def as_skills_see(raster: Raster, world: WorldSpec) -> Raster:
    """The same pixels with the states that skills tell apart."""
    return _raster(sensors_of(world.of_skills), raster.side)


class Sensors(NamedTuple):
    """What decides which state lies where: found again after a change of all else in a world."""

    size: int
    n_directions: int
    n_distances: int
    ring_exponent: float


def sensors_of(world: WorldSpec) -> Sensors:
    """The part of a world that decides which state lies where."""
    return Sensors(world.size, world.n_directions, world.n_distances, world.ring_exponent)


@functools.lru_cache(maxsize=8)
def _raster(sensors: Sensors, side: int) -> Raster:
    world = WorldSpec.model_validate(sensors._asdict())
    size = world.size
    nearest = (np.arange(side) * 2 + 1) * size // (2 * side)
    cells = (nearest[:, None] * size + nearest).ravel()
    states = geometry.readings(world).ravel()[cells]
    return Raster(cells, states)


def on_raster(per_state: np.ndarray, raster: Raster) -> np.ndarray:
    """Spread states ``(distance, direction, ...)`` over pixels, ``(pixel, ...)``."""
    return per_state.reshape(-1, *per_state.shape[2:]).take(raster.states, axis=0)


# Patterns, by the board's cells, so that they are as fine on a raster of any size. ------------


def hatched(raster: Raster, world: WorldSpec, falls: bool = False) -> np.ndarray:
    """Whether a pixel is on a line of a diagonal hatch, ``(pixel,) bool``.

    Args:
        raster: the pixels.
        world: the board.
        falls: whether the lines fall to the east, and do not rise.
    """
    east, north = raster.cells % world.size, raster.cells // world.size
    return np.asarray((east + north if falls else east - north) % 4 == 0)


def dotted(raster: Raster, world: WorldSpec) -> np.ndarray:
    """Whether a pixel is on a dot of a lattice, ``(pixel,) bool``."""
    return (raster.cells % world.size % 3 == 1) & (raster.cells // world.size % 3 == 1)
