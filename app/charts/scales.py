"""The ends of a scale of colours."""

import math
from collections.abc import Iterable
from typing import Final, NamedTuple

import numpy as np

from app.words.numbers import counted

_FAR: Final = 3.0
"""Numbers that are farther from the middle half than so many times its width are far away."""
_MOST_FAR: Final = 0.1
"""Share of the numbers that may lie beyond the ends."""


class ColourEnds(NamedTuple):
    """Where colours begin and end, and how many numbers are beyond."""

    low: float
    high: float
    below: int
    above: int

    def share(self, value: float) -> float:
        """Where a number is between the ends, from 0 to 1; what is beyond has their colours."""
        return min(max((value - self.low) / (self.high - self.low), 0.0), 1.0)

    def in_words(self, what: str, shown: str) -> str:
        """That some numbers are beyond; empty where none is.

        Args:
            what: each of them is, in the singular.
            shown: both ends, as they are written.
        """
        ways = (self.below, "lower"), (self.above, "higher")
        told = [f"{counted(n, what)} {'is' if n == 1 else 'are'} {way}" for n, way in ways if n]
        return f"Colours go from {shown}; {' and '.join(told)}." if told else ""


def colour_ends(numbers: Iterable[float]) -> ColourEnds:
    """Ends between which numbers can be told apart: a few that are far away do not count.

    Far is beyond three times the width of the middle half from its ends (what Tukey calls far
    out), and the ends are then the outermost numbers that are not. If these few are more than a
    tenth of all, they are what is to be seen, and all count.

    Args:
        numbers: NaN where there is none.
    """
    there = np.asarray([number for number in numbers if math.isfinite(number)], np.float64)
    if not there.size:
        return ColourEnds(0.0, 1.0, 0, 0)
    first, third = np.percentile(there, [25, 75])
    room = _FAR * (third - first)
    near = there[(there >= first - room) & (there <= third + room)]
    kept = near if room and there.size - near.size <= _MOST_FAR * there.size else there
    low, high = float(kept.min()), float(kept.max())
    if low == high:
        half = abs(low) * 0.05 or 0.5
        low, high = low - half, high + half
    return ColourEnds(low, high, int((there < low).sum()), int((there > high).sum()))
