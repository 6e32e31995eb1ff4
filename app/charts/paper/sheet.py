"""What all figures share: paper with its small print, and the texts and bars on it."""

import textwrap
import unicodedata
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from app.analysis.estimates import Estimate
from app.util.texts import written

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GREY = "#666666"
INK = "#222222"
AXIS_LINES = 2
"""Of the title of an axis; what does not fit is in the caption and in the numbers."""
_AXIS_CHARACTERS = 40
_LEAST_SMALL_PRINT, _MOST_SMALL_PRINT = 7.5, 10.0
_SMALL_PRINT_PER_INCH = 0.95
"""Points of the small print by the width of the figure, as a wide one shrinks on paper."""
_CHARACTERS_PER_INCH = 130
"""Of print of one point."""
SMALL_PRINT = "small-print"
"""Name of the small print among the parts of a figure."""
_FILLER = "\x1f"
"""Stands beside a wide character while lines are filled, so that it counts twice."""


def new_figure(width: float, height: float, small_print: str, least_width: float = 0) -> "Figure":
    """Paper of so many inches, and more below for its small print."""
    from matplotlib.figure import Figure

    width = max(width, least_width)
    size = min(max(_SMALL_PRINT_PER_INCH * width, _LEAST_SMALL_PRINT), _MOST_SMALL_PRINT)
    lines = [
        line
        for paragraph in small_print.splitlines()
        for line in _lines(paragraph, int(width * _CHARACTERS_PER_INCH / size))
    ]
    foot = (len(lines) * size * 1.35 + 5) / 72
    figure = Figure((width, height + foot), facecolor="white")
    share = foot / (height + foot)
    figure.set_layout_engine("constrained", rect=(0, share, 1, 1 - share))
    figure.text(
        0.012,
        share * 0.94,
        plain("\n".join(lines)),
        fontsize=size,
        color=GREY,
        va="top",
        linespacing=1.3,
        gid=SMALL_PRINT,
    )
    return figure


def foot_of(figure: "Figure") -> float:
    """Height of the small print of a figure, in inches."""
    engine = figure.get_layout_engine()
    assert engine is not None
    return float(engine.get()["rect"][1]) * float(figure.get_size_inches()[1])


def wrapped(text: str, width: int = 60, most_lines: int | None = None) -> str:
    """A text in lines of so many characters, of which a Chinese one counts as two."""
    return plain("\n".join(_lines(text, width, most_lines)))


def _lines(text: str, width: int, most_lines: int | None = None) -> list[str]:
    wide = "".join(c + _FILLER if unicodedata.east_asian_width(c) in "WF" else c for c in text)
    lines = textwrap.wrap(
        wide, width, break_on_hyphens=False, max_lines=most_lines, placeholder=" …"
    )
    return [line.replace(_FILLER, "") for line in lines]


def axis_title(text: str) -> str:
    """A text that stands along an axis."""
    return wrapped(text, _AXIS_CHARACTERS, AXIS_LINES)


def plain(text: str) -> str:
    """A text that matplotlib does not take for mathematics."""
    return written(text).replace("$", r"\$")


def arms(estimates: Sequence[Estimate]) -> np.ndarray:
    """Lengths of error bars, (2, estimate); zero where there is no interval."""
    found = [(e.value - e.low, e.high - e.value) for e in estimates]
    # A bootstrap interval may, through rounding, end a hair on the wrong side of the mean.
    return np.maximum(np.nan_to_num(np.asarray(found, np.float64).reshape(-1, 2).T), 0)


def span(numbers: Iterable[int]) -> str:
    """From the least of some numbers to the largest."""
    low, high = min(numbers), max(numbers)
    return str(low) if low == high else f"{low}–{high}"
