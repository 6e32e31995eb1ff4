"""Arrows over the board: the way that is gone from each of some places."""

import functools

import numpy as np

from app.picture.raster import Sensors, raster, sensors_of
from sim import geometry
from sim.spec import WorldSpec

_LATTICE = 20
"""Arrows along each side of the board."""
_LENGTH = 0.75
"""Of the distance between two arrows."""
_AGREEMENT = 0.5
"""Mean of the headings' unit vectors that is too short to be a direction."""
_POINTING = geometry.MOVES / np.maximum(np.hypot(*geometry.MOVES.T), 1)[:, None]
"""(move, xy) float64: direction of a move, of length 1; 0 for staying."""


def arrows(moves: np.ndarray, world: WorldSpec) -> np.ndarray:
    """Arrows of one length on a lattice over the board, ``(n, 2, 2) float32``.

    They point the mean way of the headings; where these disagree, or stay, there is none.

    Args:
        moves: ``(heading, place)``, -1 where there is none to show; see :func:`at_places`.
        world: the board.
    """
    places, _ = _lattice(sensors_of(world))
    mean = (_POINTING[moves] * (moves >= 0)[..., None]).mean(axis=0)
    length = np.hypot(mean[:, 0], mean[:, 1])
    shown = length > _AGREEMENT
    # A board of few cells has an arrow on each; a larger one on every so many.
    spacing = max(world.size / _LATTICE, 1.0)
    half = mean[shown] / length[shown, None] * (spacing * _LENGTH / 2)
    return np.stack([places[shown] - half, places[shown] + half], axis=1).astype(np.float32)


def at_places(per_state: np.ndarray, world: WorldSpec) -> np.ndarray:
    """What holds where arrows may be, ``(..., place)`` from ``(..., distance, direction)``."""
    _, states = _lattice(sensors_of(world))
    return per_state.reshape(*per_state.shape[:-2], -1)[..., states]


@functools.lru_cache(maxsize=8)
def _lattice(sensors: Sensors) -> tuple[np.ndarray, np.ndarray]:
    """Cells that carry arrows: ``(n, xy)`` from the prey, and ``(n,)`` their states.

    All but the prey's own, where no arrow means anything.
    """
    world = WorldSpec.model_validate(sensors._asdict())
    size = world.size
    found = raster(world, min(_LATTICE, size))
    prey = np.array(geometry.prey_xy(world))
    places = np.stack([found.cells % size, found.cells // size], axis=1) - prey
    kept = places.any(axis=1)
    return places[kept], found.states[kept]
