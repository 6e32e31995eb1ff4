"""What the places that are worth something look like, seen by a prey that looks right."""

from typing import Literal

import numpy as np

from sim import geometry
from sim.spec import WorldSpec

Shape = Literal["traces", "cone", "arm", "open ring", "ring", "filled"]

_KNOWN_SHARE = 1 / 2
"""Of the headings: a place that so many know is seen as coloured on the folded board."""
_BEHIND = np.radians(97)
"""What reaches farther than this from straight behind the prey, on one side, is more than a cone,
..."""
_LEAN = np.radians(25)
"""... and an arm if it reaches so much farther than on the other."""
_RING_SHARE = 2 / 3
"""Of the sectors round the prey: so many are a ring that has a gap ..."""
_FULL_RING_SHARE = 0.9
"""... and so many are a closed one."""
_FULL_SHARE = 0.6
"""Of all that the prey does not see; its outermost corners may never be known."""


def unseen(world: WorldSpec) -> np.ndarray:
    """Sensor readings out of the sight of a prey that looks east, ``(distance, direction) bool``.

    Of a ring, or a sector, that lies on the edge of the visual field, its middle counts.
    """
    outer = geometry.ring_edges(world)
    middle = (outer + np.concatenate([[0], outer[:-1]])) / 2
    near = middle <= world.vision_radius * world.scale
    return ~(near[:, None] & (np.cos(bearings(world)) > 1e-9))


def bearings(world: WorldSpec) -> np.ndarray:
    """Where the middle of each sector lies from the prey, ``(direction,)``, in radians."""
    return np.arange(world.n_directions) * 2 * np.pi / world.n_directions


def shape_of(world: WorldSpec, value: np.ndarray) -> Shape:
    """What the places of value look like on the folded board.

    Args:
        world: the world.
        value: of each state, ``(heading, distance, direction)``.
    """
    share = (geometry.fold(value, world.n_directions) > 0).mean(axis=0)
    out_of_sight = unseen(world)
    share = np.where(out_of_sight, share, 0.0)
    beyond_sight = out_of_sight.all(axis=1)
    reached = share[beyond_sight if beyond_sight.any() else slice(None)].max(axis=0) >= _KNOWN_SHARE
    if not reached.any():
        return "traces"
    if reached.mean() >= _FULL_RING_SHARE:
        return "filled" if share[out_of_sight].mean() >= _FULL_SHARE else "ring"
    if reached.mean() >= _RING_SHARE:
        return "open ring"
    from_behind = bearings(world)[reached] - np.pi
    sides = from_behind.max(), -from_behind.min()
    is_arm = max(sides) > _BEHIND and max(sides) - min(sides) > _LEAN
    return "arm" if is_arm else "cone"
