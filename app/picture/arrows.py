"""Arrows over the board: the way that is gone from each of some places."""

import functools
from typing import NamedTuple

import numpy as np

from app.picture.raster import Sensors, raster, sensors_of
from sim import geometry
from sim.spec import WorldSpec

_LATTICE, _COARSE = 20, 10
"""Arrows along each side of the board, and of a smaller picture of it."""
_LENGTH = 0.75
"""Of the distance between two arrows."""
_AGREEMENT = 0.5
"""Mean of the headings' unit vectors that is too short to be a direction."""
_POINTING = geometry.MOVES / np.maximum(np.hypot(*geometry.MOVES.T), 1)[:, None]
"""(move, xy) float64: direction of a move, of length 1; 0 for staying."""


class Arrows(NamedTuple):
    """Arrows of one length on a lattice over the board."""

    ends: np.ndarray
    """(n, 2, 2) float32: tail and head, each in cells east and north of the prey."""
    shown: np.ndarray
    """(place,) bool: the places of the lattice that have one."""


def arrows(moves: np.ndarray, world: WorldSpec, side: int) -> Arrows:
    """Arrows that point the mean way of the headings; none where these disagree, or stay.

    Args:
        moves: ``(heading, place)``, -1 where there is none to show; see :func:`at_places`.
        world: the board.
        side: pixels along each side of the picture that they are for.
    """
    places, _ = _lattice(sensors_of(world), side)
    mean = (_POINTING[moves] * (moves >= 0)[..., None]).mean(axis=0)
    length = np.hypot(mean[:, 0], mean[:, 1])
    shown = length > _AGREEMENT
    spacing = world.size / _along(world.size, side)
    half = mean[shown] / length[shown, None] * (spacing * _LENGTH / 2)
    ends = np.stack([places[shown] - half, places[shown] + half], axis=1)
    return Arrows(ends.astype(np.float32), shown)


def at_places(per_state: np.ndarray, world: WorldSpec, side: int) -> np.ndarray:
    """What holds where arrows may be, ``(..., place)`` from ``(..., distance, direction)``."""
    _, states = _lattice(sensors_of(world), side)
    return per_state.reshape(*per_state.shape[:-2], -1)[..., states]


def _along(size: int, side: int) -> int:
    """Arrows along each side of a board; one of few cells has an arrow on each."""
    return min(_LATTICE if side == size else _COARSE, size)


@functools.lru_cache(maxsize=8)
def _lattice(sensors: Sensors, side: int) -> tuple[np.ndarray, np.ndarray]:
    """Cells that carry arrows: ``(n, xy)`` from the prey, and ``(n,)`` their states.

    All but the prey's own, where no arrow means anything.
    """
    world = WorldSpec.model_validate(sensors._asdict())
    size = world.size
    found = raster(world, _along(size, side))
    prey = np.array(geometry.prey_xy(world))
    places = np.stack([found.cells % size, found.cells // size], axis=1) - prey
    kept = places.any(axis=1)
    return places[kept], found.states[kept]
