"""Settings that were swept, each with its values: where these lie on a scale, and as texts."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

_MOST_UNEVEN = 10
"""Times that one gap between swept values may be as wide as another on their own scale."""


class Axle(NamedTuple):
    """A setting that was swept, and its values in order."""

    key: str
    values: Sequence[Any]
    words: str = ""
    """What it is in plain words; empty where there are none but its key."""

    @property
    def label(self) -> str:
        """What it is, in words if there are any."""
        return self.words or self.key

    @property
    def is_numeric(self) -> bool:
        """Whether its values lie on a scale."""
        return all(isinstance(v, int | float) and not isinstance(v, bool) for v in self.values)

    @property
    def is_logarithmic(self) -> bool:
        """Whether its values are better seen on a scale of ratios."""
        if len(self.values) < 3 or not self.is_numeric or min(self.values) <= 0:
            return False
        ratios = [b / a for a, b in zip(self.values, self.values[1:], strict=False)]
        return min(ratios) > 1.3 and max(ratios) / min(ratios) < 1.3

    @property
    def is_crowded(self) -> bool:
        """Whether its values, on a scale, would lie on top of one another."""
        if len(self.values) < 2 or not self.is_numeric:
            return False
        gaps = [b - a for a, b in zip(self.values, self.values[1:], strict=False)]
        return min(gaps) * _MOST_UNEVEN < max(gaps)

    @property
    def is_even(self) -> bool:
        """Whether its values are drawn one beside the other, and not where they lie on a scale."""
        return not self.is_numeric or (self.is_crowded and not self.is_logarithmic)

    @property
    def places(self) -> Sequence[float]:
        """Where its values are drawn: at themselves, or at their numbers from 0."""
        return [float(v) for v in (range(len(self.values)) if self.is_even else self.values)]


def shown_value(value: Any) -> str:
    """The value of a setting."""
    return f"{value:g}" if isinstance(value, float) else str(value)


def grouped(value: Any) -> str:
    """The value of a setting, a large whole number with a comma at the thousands."""
    is_large = isinstance(value, int) and abs(value) >= 1_000
    return f"{value:,}" if is_large else shown_value(value)


def told_apart(values: Sequence[Any], shown: Callable[[Any], str] = shown_value) -> list[str]:
    """The values of a setting, in all their digits where two would else look the same.

    Args:
        values: of one setting; the same value may be there more than once.
        shown: a value in short.
    """
    short = [shown(value) for value in values]
    exact = [repr(value) if isinstance(value, float) else shown(value) for value in values]
    return short if len(set(short)) == len(set(exact)) else exact
