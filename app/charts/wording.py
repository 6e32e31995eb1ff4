"""Estimates and names as charts and tables write them, and what is said of how many runs."""

import math
from collections.abc import Callable, Iterable
from typing import Final

from app.analysis.estimates import LEAST_RUNS, Estimate
from app.analysis.passages import Arrivals
from app.words.numbers import shown_number
from app.words.plain import shortened

PADDED: Final = "#.3g"
"""The form of a number with three digits, also where they are zero."""

_TITLE_CHARACTERS = 80
"""Of a label in the hint of a dot or a cell, of which there may be hundreds."""
_BETWEEN = ", "


def shown_estimate(estimate: Estimate, form: str = ".3g") -> str:
    """A value with its interval; without, where a single run gives none."""
    value = shown_number(estimate.value, form)
    if math.isnan(estimate.value) or not estimate.has_interval:
        return value
    return f"{value} [{shown_number(estimate.low, form)}, {shown_number(estimate.high, form)}]"


def shown_median(found: Arrivals, steps: Callable[[float], str]) -> str:
    """After how many steps half of the runs have got somewhere, with the interval of that.

    Args:
        found: of one run at the least.
        steps: how a finite number of them is written.
    """

    def end(value: float) -> str:
        return "\N{INFINITY}" if math.isinf(value) else steps(value)

    median = found.median
    value = f"more than {steps(found.last)}" if math.isinf(median.value) else steps(median.value)
    # An interval of nothing but "may never" says no more than the median does.
    if not math.isfinite(median.low):
        return value
    return f"{value} [{end(median.low)}, {end(median.high)}]"


def shown_p(p: float) -> str:
    """A p value, as far as it can be relied on; nothing where nothing was tested."""
    return "< 0.001" if p < 0.001 else shown_number(p, ".3f" if p < 0.1 else ".2f")


def described(label: str, estimate: Estimate) -> str:
    """A variant with its mean, for a hint."""
    if not estimate.n:
        return f"{short_title(label)}: no run yet"
    return f"{short_title(label)}: {shown_estimate(estimate, PADDED)}, n = {estimate.n:,}"


def short_title(label: str) -> str:
    """A label in a hint."""
    return short_label(label, _TITLE_CHARACTERS)


def few_in_words(counts: Iterable[int]) -> str:
    """A warning where intervals cannot be wide enough, or where there are none."""
    there = {n for n in counts if n > 0}
    if there == {1}:
        return "One run has no interval."
    return (
        f"With fewer than {LEAST_RUNS} runs, intervals are too narrow"
        f"{', and of one there is none' if 1 in there else ''}."
        if any(n < LEAST_RUNS for n in there)
        else ""
    )


def short_label(text: str, characters: int) -> str:
    """A text that fits; of ``name, key=value``, as variants are called, the values stay."""
    if len(text) <= characters:
        return text
    parts = text.split(_BETWEEN)
    lengths = [len(f"…={part.rpartition('=')[2]}") if "=" in part else 1 for part in parts]
    lengths = [min(length, len(part)) for length, part in zip(lengths, parts, strict=True)]
    room = characters - len(_BETWEEN) * (len(parts) - 1) - sum(lengths)
    if room < 0 or len(parts) == 1:
        kept = max(characters - 1, 0)
        return f"{text[: kept - kept // 2]}…{text[len(text) - kept // 2 :]}"
    # First what lacks least, so that what it leaves is there for the others.
    order = sorted(range(len(parts)), key=lambda index: len(parts[index]) - lengths[index])
    for taken, index in enumerate(order):
        more = min(len(parts[index]) - lengths[index], room // (len(parts) - taken))
        lengths[index] += more
        room -= more
    return _BETWEEN.join(map(_cut, parts, lengths))


def _cut(part: str, characters: int) -> str:
    """Part of a label without the beginning of its key; a name without its end."""
    if "=" not in part or len(part) <= characters:
        return shortened(part, characters)
    return f"…{part[len(part) - characters + 1 :]}"
