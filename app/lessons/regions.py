"""Regions of the board that lessons speak of, as sensor readings round a prey that looks east.

All of them are in the prey's own frame: the map of each heading is turned so that the prey looks
east, and bearings count counter-clockwise from straight ahead. Lengths are those of a board of 120
and scale with it. A reading belongs to a region by the middle of its ring and of its sector.

``behind``        more than 97.5 degrees to either side of straight ahead, at any distance
``ahead``         less than 82.5 degrees to either side, at any distance
``right_flank``   82.5 to 112.5 degrees to the right, 35 to 58 cells away
``left_flank``    the same to the left
``visual_field``  what the prey sees: less than 90 degrees to either side, up to the vision radius
``near``          out of the prey's sight, up to 16 cells away
``far``           out of the prey's sight, from 30 cells to the farthest start of a trial
``e`` ... ``se``  the eight octants, 45 degrees each, ``e`` straight ahead, ``n`` on the left, ``w``
                  behind: out of sight, up to the farthest start. A sector whose middle lies between
                  two octants belongs to both.

Of the flanks, and of the ring on which :func:`ring` finds the thinnest place, the readings are
those of the findings on the spread of value (:mod:`app.results.spread`), in a world of any sensors.
"""

import functools
from collections.abc import Mapping
from typing import Final

import numpy as np

from app.documents.lesson_grammar import OCTANTS
from app.explain.shape import bearings, unseen
from sim import geometry
from sim.spec import WorldSpec

RING_CELLS: Final = (35.0, 58.25)
"""Nearest and farthest of the ring, on a board of 120: outside of the visual field, and within all
that the prey can be hunted from."""
NEAR_CELLS: Final = 16.5
FAR_CELLS: Final = 30.0

_BEHIND_DEGREES: Final = 97.5
_FLANK_DEGREES: Final = (82.5, 112.5)
_HAIR: Final = 1e-6


def masks(world: WorldSpec) -> Mapping[str, np.ndarray]:
    """Readings of each region, ``(distance, direction) bool``; none where sensors are coarse."""
    return _masks(world.model_dump_json())


@functools.lru_cache(maxsize=8)
def _masks(document: str) -> Mapping[str, np.ndarray]:
    world = WorldSpec.model_validate_json(document)
    middle, hidden = _middles(world), unseen(world)
    bearing = np.degrees(bearings(world))
    bearing = np.where(bearing > 180, bearing - 360, bearing)
    on_ring = ring(world)[:, None]
    nearest, farthest = (limit - _HAIR for limit in _FLANK_DEGREES)
    anywhere = np.ones_like(hidden)
    huntable = hidden & (middle <= world.start_radius[1] * world.scale + _HAIR)[:, None]
    far = huntable & (middle >= FAR_CELLS * world.scale)[:, None]
    found = {
        "behind": anywhere & (np.abs(bearing) > _BEHIND_DEGREES),
        "ahead": anywhere & (np.abs(bearing) < _FLANK_DEGREES[0]),
        "left_flank": on_ring & ((bearing > nearest) & (bearing < farthest)),
        "right_flank": on_ring & ((-bearing > nearest) & (-bearing < farthest)),
        "visual_field": ~hidden,
        "near": hidden & (middle <= NEAR_CELLS * world.scale)[:, None],
        "far": far,
    }
    for place, octant in enumerate(OCTANTS):
        off = (bearing - 45 * place + 180) % 360 - 180
        found[octant] = huntable & (np.abs(off) <= 22.5 + _HAIR)
    for mask in found.values():
        mask.setflags(write=False)
    return found


def share(value: np.ndarray) -> np.ndarray:
    """Share of the headings, turned, whose value is above 0, ``(distance, direction) float64``.

    Args:
        value: ``(heading, distance, direction)``.
    """
    return (value > 0).ravel()[_turned(value.shape)].mean(axis=0)


@functools.lru_cache(maxsize=8)
def _turned(shape: tuple[int, ...]) -> np.ndarray:
    """(heading, distance, direction) int64: the state that each turned state was."""
    return geometry.fold(np.arange(np.prod(shape)).reshape(shape), shape[-1])


def _middles(world: WorldSpec) -> np.ndarray:
    """Distance of the middle of each ring, ``(distance,)``, in cells."""
    outer = geometry.ring_edges(world)
    return (outer + np.concatenate([[0], outer[:-1]])) / 2


def ring(world: WorldSpec) -> np.ndarray:
    """Which rings of the distance sensor are the ring round the prey, ``(distance,) bool``."""
    return _ring(world.model_dump_json())


@functools.lru_cache(maxsize=8)
def _ring(document: str) -> np.ndarray:
    world = WorldSpec.model_validate_json(document)
    middle = _middles(world) / world.scale
    found = (middle > RING_CELLS[0]) & (middle < RING_CELLS[1])
    if not found.any():
        found[np.argmin(np.abs(middle - sum(RING_CELLS) / 2))] = True
    return found
