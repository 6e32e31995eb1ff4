"""Skills and the local rewards they learn from (section 4.2.2).

Every local reward is a weighted sum of three metrics of one move, which took the predator from
distance d0 to d1 and turned its bearing from the prey by dtheta, counter-clockwise positive:

====== =============== =========================================================
name   metric          meaning
====== =============== =========================================================
gain   d0 - d1         ground gained towards the prey
arc    dtheta * d0     arc length, counter-clockwise
inward max(d0 - d1, 0) ground given up towards the prey; its weight is a penalty
====== =============== =========================================================

The penalty keeps a circle from spiralling inwards into the prey's view.
"""

from typing import NamedTuple

import numpy as np

from sim.compiled import piece

SPIRAL_PENALTY = 0.2
"""Share of the ground given up towards the prey that a circle is charged for."""

_ZERO = np.float32(0)
_PI = np.float32(np.pi)
_TURN = np.float32(2 * np.pi)


class LocalReward(NamedTuple):
    """Weights of the three metrics."""

    gain: float
    arc: float
    inward: float


SKILLS: dict[str, LocalReward] = {
    "approach": LocalReward(gain=1.0, arc=0.0, inward=0.0),
    "avoid": LocalReward(gain=-1.0, arc=0.0, inward=0.0),
    "circle_clockwise": LocalReward(gain=0.0, arc=-1.0, inward=-SPIRAL_PENALTY),
    "circle_counterclockwise": LocalReward(gain=0.0, arc=1.0, inward=-SPIRAL_PENALTY),
}
"""The skills that a preset can name."""


@piece
def wrapped(angle: np.float32) -> np.float32:
    """A difference of two bearings as the turn of at most half a circle that it is."""
    if angle > _PI:
        return angle - _TURN
    if angle < -_PI:
        return angle + _TURN
    return angle


@piece
def local_reward(
    weights: np.ndarray, skill: np.uint64, d_tm1: np.float32, d_t: np.float32, turn: np.float32
) -> np.float32:
    """Local reward of a move; ``weights`` is ``(skill * 4,) float32``: gain, arc, inward, and 0."""
    gain = d_tm1 - d_t
    base = skill * np.uint64(4)
    return (
        weights[base] * gain
        + weights[base + np.uint64(1)] * (turn * d_tm1)
        + weights[base + np.uint64(2)] * max(gain, _ZERO)
    )
