"""Ranges of numbers that an experiment varies a setting over, both ends included.

How many numbers a range has is known long before any of them is made.
"""

import math
from functools import cached_property
from typing import Annotated, Any, Final, Self

from pydantic import PlainValidator, model_validator

from app.documents.faults import written_so
from sim.spec import Spec

Number = int | float

MAX_NUMBERS: Final = 10_000
"""A range has fewer."""


def _finite(value: Any) -> Number:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not math.isfinite(value):
        hint = written_so(value, decimals=True)
        raise ValueError(f"must be a finite number; allowed: a number{hint}")
    return value


Finite = Annotated[Number, PlainValidator(_finite)]
"""A whole number stays one: where all of a range are, so are its numbers."""


def _check_count(count: float) -> None:
    if count >= MAX_NUMBERS:
        raise ValueError(f"has too many values; allowed: fewer than {MAX_NUMBERS}")


class Linear(Spec):
    """Numbers that are one step apart."""

    start: Finite
    stop: Finite
    step: Finite

    @model_validator(mode="after")
    def _has_an_end(self) -> Self:
        if not (self.start <= self.stop and self.step > 0):
            raise ValueError("is no range; allowed: start up to stop, and a step above 0")
        _check_count((self.stop - self.start) / self.step)
        return self

    @property
    def size(self) -> int:
        """How many numbers there are."""
        # The last belongs to it even where the sum of steps misses it by a rounding error.
        return math.floor((self.stop - self.start) / self.step + 1e-9) + 1

    def numbers(self) -> list[Number]:
        """The numbers; whole ones where start, stop and step are whole."""
        numbers = [self.start + index * self.step for index in range(self.size)]
        if all(isinstance(number, int) for number in (self.start, self.stop, self.step)):
            return numbers
        # Without the 0.30000000000000004 that is the sum of 0.1 and 0.2.
        return [float(f"{number:.12g}") for number in numbers]


class Logarithmic(Spec):
    """Numbers that grow by a factor."""

    log_start: Finite
    log_stop: Finite
    count: Finite

    @model_validator(mode="after")
    def _has_an_end(self) -> Self:
        has_order = 0 < self.log_start < self.log_stop
        if not (has_order and isinstance(self.count, int) and self.count >= 2):
            raise ValueError("is no range; allowed: 0 < log_start < log_stop, count 2 or more")
        _check_count(self.count)
        return self

    @cached_property
    def size(self) -> int:
        """How many numbers there are."""
        # Rounded to whole numbers, some may be the same: to be counted they must be made.
        return len(self.numbers()) if self._is_whole else int(self.count)

    def numbers(self) -> list[Number]:
        """The numbers; where both ends are whole, whole ones, each once."""
        first, last, steps = self.log_start, self.log_stop, int(self.count) - 1
        factor = (last / first) ** (1 / steps)
        between = [first * factor**index for index in range(1, steps)]
        if self._is_whole:
            return list(dict.fromkeys([first, *map(round, between), last]))
        return [float(first), *(float(f"{value:.6g}") for value in between), float(last)]

    @property
    def _is_whole(self) -> bool:
        return isinstance(self.log_start, int) and isinstance(self.log_stop, int)


def range_of(value: Any) -> Linear | Logarithmic:
    """The range that a mapping states; raises `ValueError`, with all that is wrong with it."""
    for kind in (Linear, Logarithmic):
        if isinstance(value, dict) and value.keys() == kind.model_fields.keys():
            return kind.model_validate(value)
    raise ValueError(
        "has no values;"
        " allowed: a list of values, {start, stop, step}, or {log_start, log_stop, count}"
    )
