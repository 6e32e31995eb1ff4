"""How numbers are written where people read them: amounts, times, values, and marks of axes."""

import math
from collections.abc import Iterable, Iterator
from decimal import Decimal
from statistics import median
from typing import Final

NONE: Final = "\N{EN DASH}"
"""Where there is no number."""
_MINUS: Final = "\N{MINUS SIGN}"


def counted(number: int, what: str) -> str:
    """A number of things, of which one has no s."""
    return f"{number:,} {what}" if number == 1 else f"{number:,} {what}s"


def in_short(number: float, k_from: float = 9_999.5, m_from: float = 999_500.0) -> str:
    """A number of steps or trials in few characters.

    Args:
        number: 0 or more.
        k_from: the least that is given in thousands.
        m_from: the least that is given in millions.
    """
    if number >= m_from:
        return f"{number / 1e6:.3g} M" if number < 999.5e6 else f"{number / 1e6:,.0f} M"
    if number >= k_from:
        return f"{number / 1e3:.0f} k"
    return f"{number:,.0f}"


def in_millions(number: float) -> str:
    """A number of steps without its unit, a million; a dash where there is none."""
    return shown_number(number / 1e6, ".2f")


def rate_in_short(per_second: float) -> str:
    """How many a second, as precisely as such a number holds for more than that second."""
    rate = float(f"{per_second:.2g}") if per_second >= 100 else round(per_second)
    for unit, sign in ((1e6, "M"), (1e3, "k")):
        if rate >= unit:
            return f"{rate / unit:.3g} {sign}"
    return f"{rate:.0f}"


def speed_in_words(steps_per_s: float) -> str:
    """Steps per second in few characters, with their unit."""
    number = rate_in_short(steps_per_s)
    return f"{number} step/s" if number == "1" else f"{number} steps/s"


def duration(seconds: float) -> str:
    """A time in words that are short."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < 90 else f"{minutes / 60:.1f} h"


def megabytes(n_bytes: float) -> str:
    """Room on a disk, with its unit."""
    return f"{max(n_bytes / 1e6, 0.1):,.1f} MB"


def shown_number(value: float, form: str = ".3g") -> str:
    """A measured value, of large ones the whole; a dash where there is none.

    Args:
        value: any number; where it is infinite, it stands for what never comes.
        form: of values below 1,000, as :func:`format` takes it.
    """
    if math.isnan(value):
        return NONE
    if math.isinf(value):
        return "never"
    text = format(value, form if abs(value) < 1_000 else ",.0f").rstrip(".")
    return text.replace("-", _MINUS)


def shared_form(numbers: Iterable[float], digits: int = 3) -> str:
    """The form in which numbers of a column are written: all with as many decimals.

    Args:
        numbers: of which the usual one has so many digits; those that are none are left out.
        digits: of the median of their sizes.
    """
    sizes = [abs(number) for number in numbers if math.isfinite(number) and number]
    before = math.floor(math.log10(median(sizes))) + 1 if sizes else 1
    return f".{max(digits - before, 0)}f"


def of_any_size(amount: float) -> str:
    """An amount that may be tiny or huge, as the ends of a scale are, in few characters."""
    for unit, sign in ((1e6, "M"), (1e3, "k")):
        if amount >= unit:
            return f"{amount / unit:.3g} {sign}"
    shown = amount if abs(amount) >= 1e-6 else 0.0
    # Never as a power of ten.
    return f"{Decimal(f'{shown:.2g}'):f}"


def significant(value: float, digits: int = 3) -> str:
    """A value with so many digits that mean something, however small it is."""
    text = f"{value:.{digits}g}"
    if abs(value) >= 1e-7:
        text = f"{Decimal(text):f}"
    return text.replace("-", _MINUS)


# Marks of axes ------------------------------------------------------------------------------

_NEARLY: Final = 1e-9
"""What is missing to a round number by less than this share of it is a rounding error."""


def round_numbers(least: float) -> Iterator[float]:
    """1, 2 and 5 times the powers of ten, upwards from one that is above 0."""
    power = 10.0 ** math.floor(math.log10(least))
    while True:
        yield from (k * power for k in (1, 2, 5) if k * power >= least * (1 - _NEARLY))
        power *= 10


def tick_step(low: float, high: float, most: int, least: float = 1e-12) -> float:
    """The round number from each mark of an axis to the next, of which at most so many fit."""
    return next(round_numbers(max((high - low) / most, least)))


def ticks(low: float, high: float, most: int, least: float = 1e-12) -> list[float]:
    """Marks of an axis: the multiples of a round number from low to high.

    Args:
        low: one end of the axis.
        high: the other end, above it.
        most: steps from mark to mark that fit between the ends at most.
        least: the smallest step, 1 where only whole numbers mean anything.
    """
    step = tick_step(low, high, most, least)
    first, last = math.ceil(low / step - _NEARLY), math.floor(high / step + _NEARLY)
    return [index * step for index in range(first, last + 1)]


def labelled_ticks(low: float, high: float, most: int) -> list[tuple[float, str]]:
    """Marks of an axis with what is written at them, all with as many decimals."""
    decimals = max(-math.floor(math.log10(tick_step(low, high, most)) + _NEARLY), 0)
    return [(tick, f"{tick:,.{decimals}f}".replace("-", _MINUS)) for tick in ticks(low, high, most)]
