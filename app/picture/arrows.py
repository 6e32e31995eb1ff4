"""Arrows over the board: the way that is gone from each of some places."""

import functools

import numpy as np

from app.picture.raster import raster
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
        moves: ``(heading, distance, direction)``, -1 where there is none to show.
        world: the board.
    """
    places, states = _lattice(world.size, world.n_directions, world.n_distances)
    move = moves.reshape(len(moves), -1)[:, states]
    mean = (_POINTING[move] * (move >= 0)[..., None]).mean(axis=0)
    length = np.hypot(mean[:, 0], mean[:, 1])
    shown = length > _AGREEMENT
    # A board of few cells has an arrow on each; a larger one on every so many.
    spacing = max(world.size / _LATTICE, 1.0)
    half = mean[shown] / length[shown, None] * (spacing * _LENGTH / 2)
    return np.stack([places[shown] - half, places[shown] + half], axis=1).astype(np.float32)


@functools.lru_cache(maxsize=8)
def _lattice(size: int, n_directions: int, n_distances: int) -> tuple[np.ndarray, np.ndarray]:
    """Cells that carry arrows: ``(n, xy)`` from the prey, and ``(n,)`` their states.

    All but the prey's own, where no arrow means anything.
    """
    world = WorldSpec(size=size, n_directions=n_directions, n_distances=n_distances)
    found = raster(world, min(_LATTICE, size))
    prey = np.array(geometry.prey_xy(world))
    places = np.stack([found.cells % size, found.cells // size], axis=1) - prey
    kept = places.any(axis=1)
    return places[kept], found.states[kept]
