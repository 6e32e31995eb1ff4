"""Skills and the local rewards they learn from (section 4.2.2).

Every local reward is a weighted sum of metrics of one move, which took the predator from
distance d0 to d1 and turned its bearing from the prey by dtheta, counter-clockwise positive:

====== =============== =========================================================
name   metric          meaning
====== =============== =========================================================
gain   d0 - d1         ground gained towards the prey
arc    dtheta * d0     arc length, counter-clockwise
inward max(d0 - d1, 0) ground given up towards the prey; its weight is a penalty
behind d0 - d1         the same as gain, of moves that begin behind the prey; else 0
flight 1               of moves that put the prey to flight; else 0
====== =============== =========================================================

The thesis's four skills earn the first three; the other two, see ``learners.kernel.forms``, are for
skills that see where the prey looks. Behind the prey is more than 105 degrees from there.

The penalty keeps a circle from spiralling inwards into the prey's view. How large it is the thesis
leaves open, as it does whether a local reward says how well a move did or only that it did well:
both are settings of the learner.
"""

from typing import NamedTuple

import numpy as np

from sim.compiled import piece

SPIRAL_PENALTY = 0.2
"""Share of the ground given up towards the prey that a circle is charged for, unless stated."""

_ZERO = np.float32(0)
_ONE = np.float32(1)
_PI = np.float32(np.pi)
_TURN = np.float32(2 * np.pi)


class LocalReward(NamedTuple):
    """Weights of the first three metrics."""

    gain: float
    arc: float
    inward: float


CIRCLES = ("circle_clockwise", "circle_counterclockwise")

SKILLS = ("approach", "avoid", "circle_clockwise", "circle_counterclockwise")
"""The skills of the thesis, from whose rewards those of other skills may be made."""


def rewards(spiral_penalty: float) -> dict[str, LocalReward]:
    """Local rewards of the ``SKILLS``, the circles charged so much for the ground they give up."""
    return {
        "approach": LocalReward(gain=1.0, arc=0.0, inward=0.0),
        "avoid": LocalReward(gain=-1.0, arc=0.0, inward=0.0),
        "circle_clockwise": LocalReward(gain=0.0, arc=-1.0, inward=-spiral_penalty),
        "circle_counterclockwise": LocalReward(gain=0.0, arc=1.0, inward=-spiral_penalty),
    }


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
    weights: np.ndarray,
    binary: bool | None,
    skill: np.uint64,
    d_tm1: np.float32,
    d_t: np.float32,
    turn: np.float32,
) -> np.float32:
    """Local reward of a move by the first three metrics.

    Args:
        weights: ``(skill * 4,) float32``: gain, arc, inward, and 0.
        binary: whether it is only told that the sum is above 0, by a reward of 1; None if not.
        skill: whose reward.
        d_tm1: distance before the move, in cells.
        d_t: distance after it.
        turn: of the bearing, in radians.
    """
    gain = d_tm1 - d_t
    base = skill * np.uint64(4)
    total = (
        weights[base] * gain
        + weights[base + np.uint64(1)] * (turn * d_tm1)
        + weights[base + np.uint64(2)] * max(gain, _ZERO)
    )
    # Told by the type, so that the compiler leaves out what is not asked for.
    if binary is None:
        return total
    return _ONE if total > _ZERO else _ZERO
