"""From states to pixels: which state lies under each pixel of the board.

Arrays over the board are ``(y, x)``, row by row from the south-west.
"""

import functools
from typing import NamedTuple

import numpy as np

from sim import geometry
from sim.spec import WorldSpec


class Raster(NamedTuple):
    """Pixels that a picture has, and what decides how each looks.

    Most are a square of pixels over the board, row by row from the south-west. One that
    :func:`by_state` makes has a few for each state instead, and says all that the square would.
    """

    cells: np.ndarray
    """(pixel,) int64: the board's cell under each pixel, ``y * size + x``."""
    states: np.ndarray
    """(pixel,) int64: its state, ``distance * n_directions + direction``."""
    states_of_skills: np.ndarray
    """(pixel,) int64: its state as skills tell them apart."""
    dotted: np.ndarray
    """(pixel,) bool: whether it is on a dot of a lattice; patterns go by the board's cells, so that
    they are as fine on a raster of any size."""
    rising: np.ndarray
    """(pixel,) bool: whether it is on a line of a diagonal hatch that rises to the east."""
    falling: np.ndarray
    """(pixel,) bool: the same of one that falls."""
    side: int
    """Pixels along each side of the square."""

    @property
    def as_skills_see(self) -> "Raster":
        """The same pixels with the states that skills tell apart."""
        return self._replace(states=self.states_of_skills)


def raster(world: WorldSpec, side: int | None = None) -> Raster:
    """The board in so many pixels along each side; one for each cell unless given."""
    return _raster(sensors_of(world), sensors_of(world.of_skills), side or world.size)


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
def _raster(sensors: Sensors, of_skills: Sensors, side: int) -> Raster:
    size = sensors.size
    nearest = (np.arange(side) * 2 + 1) * size // (2 * side)
    cells = (nearest[:, None] * size + nearest).ravel()
    east, north = cells % size, cells // size
    return Raster(
        cells,
        _states(sensors)[cells],
        _states(of_skills)[cells],
        dotted=(east % 3 == 1) & (north % 3 == 1),
        rising=(east - north) % 4 == 0,
        falling=(east + north) % 4 == 0,
        side=side,
    )


def _states(sensors: Sensors) -> np.ndarray:
    """(cell,) int64."""
    return geometry.readings(WorldSpec.model_validate(sensors._asdict())).ravel()


def on_raster(per_state: np.ndarray, raster: Raster) -> np.ndarray:
    """Spread states ``(distance, direction, ...)`` over pixels, ``(pixel, ...)``."""
    return per_state.reshape(-1, *per_state.shape[2:]).take(raster.states, axis=0)


# The board by states --------------------------------------------------------------------------

PATTERNS = ("plain", "falling", "rising", "dots")
"""Kinds of pixels that a state may have, each over those before it where they differ."""


class Areas(NamedTuple):
    """Parts of a board whose cells nothing tells apart but a pattern.

    They are the states, where skills tell the same apart; otherwise what both tell apart.
    """

    of_cells: np.ndarray
    """(cell,) uint16: the area of each cell, row by row from the south-west."""
    states: np.ndarray
    """(area,) int64: the state there."""
    states_of_skills: np.ndarray
    """(area,) int64."""


def areas(world: WorldSpec) -> Areas:
    """The areas of a board."""
    return _areas(sensors_of(world), sensors_of(world.of_skills))


@functools.lru_cache(maxsize=8)
def _areas(sensors: Sensors, of_skills: Sensors) -> Areas:
    states = _states(sensors)
    if of_skills == sensors:
        every = np.arange(sensors.n_distances * sensors.n_directions)
        return Areas(states.astype(np.uint16), every, every)
    n_of_skills = of_skills.n_distances * of_skills.n_directions
    both, of_cells = np.unique(states * n_of_skills + _states(of_skills), return_inverse=True)
    return Areas(of_cells.astype(np.uint16), both // n_of_skills, both % n_of_skills)


def by_state(world: WorldSpec, side: int) -> Raster:
    """A pixel for each area and pattern: all areas without a pattern, then all of the next.

    What is drawn on it is what is drawn on a square of ``side``, for all that goes by states and
    patterns. Its cells are none of the board.
    """
    return _by_state(sensors_of(world), sensors_of(world.of_skills), side)


@functools.lru_cache(maxsize=8)
def _by_state(sensors: Sensors, of_skills: Sensors, side: int) -> Raster:
    found = _areas(sensors, of_skills)
    n_areas, n_kinds = len(found.states), len(PATTERNS)
    kind = np.repeat(np.arange(n_kinds), n_areas)
    return Raster(
        np.full(n_areas * n_kinds, -1),
        np.tile(found.states, n_kinds),
        np.tile(found.states_of_skills, n_kinds),
        dotted=kind == PATTERNS.index("dots"),
        rising=kind == PATTERNS.index("rising"),
        falling=kind == PATTERNS.index("falling"),
        side=side,
    )
