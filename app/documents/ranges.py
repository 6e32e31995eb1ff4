"""Ranges of numbers that an experiment varies a setting over, both ends included."""

import math

Number = int | float


def n_steps(first: Number, last: Number, step: Number) -> int:
    """Numbers from the first to the last, both included."""
    # The last belongs to it even where the sum of steps misses it by a rounding error.
    return math.floor((last - first) / step + 1e-9) + 1


def linear(first: Number, last: Number, step: Number) -> list[Number]:
    """Numbers from the first to the last, both included; whole ones where all three are whole."""
    count = n_steps(first, last, step)
    if all(isinstance(number, int) for number in (first, last, step)):
        return [first + index * step for index in range(count)]
    # Without the 0.30000000000000004 that is the sum of 0.1 and 0.2.
    return [float(f"{first + index * step:.12g}") for index in range(count)]


def logarithmic(first: Number, last: Number, count: int) -> list[Number]:
    """Numbers that grow by a factor; where both ends are whole, whole ones, each once."""
    factor = (last / first) ** (1 / (count - 1))
    between = [first * factor**index for index in range(1, count - 1)]
    if isinstance(first, int) and isinstance(last, int):
        return list(dict.fromkeys([first, *map(round, between), last]))
    return [float(first), *(float(f"{value:.6g}") for value in between), float(last)]
