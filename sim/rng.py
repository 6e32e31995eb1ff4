"""SplitMix64 (Steele, Lea and Flood 2014): a counter, and a mix of it.

Because a draw is a function of a counter, draws depend on nothing but their number:
the start of trial t needs no trial before it. Two streams are made from one seed, so
learners that spend their decisions differently still see the same starts
(common random numbers).
"""

import numpy as np

from sim.compiled import piece

GAMMA = np.uint64(0x9E3779B97F4A7C15)
_A = np.uint64(0xBF58476D1CE4E5B9)
_B = np.uint64(0x94D049BB133111EB)
_S30 = np.uint64(30)
_S27 = np.uint64(27)
_S31 = np.uint64(31)

DECISIONS = 0
STARTS = 1

MAX_SEED = 2**63 - 1
"""Highest seed: the most that a signed 64-bit integer holds."""


@piece
def mix(counter: np.uint64) -> np.uint64:
    """64 random bits from a counter."""
    z = (counter ^ (counter >> _S30)) * _A
    z = (z ^ (z >> _S27)) * _B
    return z ^ (z >> _S31)


def streams(seed: int) -> np.ndarray:
    """Counters of the stream of decisions and the stream of starts, ``(2,) uint64``.

    Raises:
        ValueError: the seed is not in 0...``MAX_SEED``.
    """
    if not 0 <= seed <= MAX_SEED:
        raise ValueError(f"seed: {seed} is not allowed; allowed: 0 to {MAX_SEED}")
    with np.errstate(over="ignore"):
        root = np.uint64(seed)
        return np.array([mix(root + GAMMA), mix(root + GAMMA + GAMMA)], dtype=np.uint64)
