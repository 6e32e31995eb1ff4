"""What all figures share: paper with its small print, texts, and the files that they become."""

import functools
import html
import io
import re
import textwrap
import unicodedata
import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from app.charts.fonts import fonts_for
from app.util import csv_texts
from app.util.texts import written

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GREY = "#666666"
AXIS_LINES = 2
"""Of the title of an axis; what does not fit is in the caption and in the numbers."""
_AXIS_CHARACTERS = 40
_PNG_DPI = 160
_LEAST_SMALL_PRINT, _MOST_SMALL_PRINT = 7.5, 10.0
_SMALL_PRINT_PER_INCH = 0.95
"""Points of the small print by the width of the figure, as a wide one shrinks on paper."""
_CHARACTERS_PER_INCH = 130
"""Of print of one point."""
_MOST_SHOWN = 20
"""Characters that a note names."""
_FILLER = "\x1f"
"""Stands beside a wide character while lines are filled, so that it counts twice."""
_SVG_FAMILIES = "'DejaVu Sans', Verdana, 'Bitstream Vera Sans', sans-serif"
"""What a browser takes for the texts of a figure: fonts as wide as the one that they were laid out
with, and else one that is narrower; it looks for what they lack by itself."""


class Drawing(NamedTuple):
    """A picture and the numbers in it."""

    svg: str
    """An ``svg`` element, to stand in a page or in a file; its texts are texts."""
    png: bytes
    rows: Sequence[Sequence[Any]]
    """The numbers, below the names of their columns."""
    missing: str = ""
    """Characters that are boxes in the PNG, as no font of this machine has them."""

    @property
    def csv(self) -> str:
        """The numbers, for programs."""
        return csv_texts.for_programs(self.rows)

    @property
    def spreadsheet(self) -> str:
        """The numbers, for spreadsheets."""
        return csv_texts.for_spreadsheets(self.rows)


def missing_note(characters: str) -> str:
    """A sentence on characters that no font has; empty where there are none."""
    if not characters:
        return ""
    shown = ", ".join(characters[:_MOST_SHOWN])
    more = f" and {len(characters) - _MOST_SHOWN} more" if len(characters) > _MOST_SHOWN else ""
    return (
        f"No font of this machine has {shown}{more}: boxes in PNG files; SVG files and pages have"
        " them as text."
    )


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
    )
    return figure


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


@functools.cache
def _have_texts_stay_texts() -> None:
    from matplotlib import rcParams

    rcParams["svg.fonttype"] = "none"


def saved(
    name: str, figure: "Figure", rows: Sequence[Sequence[Any]], titles: Mapping[str, str] = {}
) -> Drawing:
    """A figure as its files.

    Args:
        name: begins the names of the element's parts, whatever else is in the page.
        figure: what was drawn.
        rows: its numbers, below the names of their columns.
        titles: what is shown under the pointer, by the names of parts.
    """
    from matplotlib.text import Text

    for axes in figure.axes:
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(labelsize=8)
    texts = figure.findobj(Text)
    fonts = fonts_for("".join(text.get_text() for text in texts))
    for text in texts:
        text.set_fontfamily(fonts.families)
    _have_texts_stay_texts()
    # It is said once for all pictures, by name and not by number.
    warnings.filterwarnings("ignore", r"Glyph \d+ .*missing from font", UserWarning)
    png = io.BytesIO()
    figure.savefig(png, format="png", dpi=_PNG_DPI)
    svg = io.StringIO()
    # The date and the maker's address have no place in a page that is to be the same every time.
    nothing: dict[str, Any] = dict.fromkeys(("Date", "Creator", "Format", "Type"))
    figure.savefig(svg, format="svg", metadata=nothing, dpi=_PNG_DPI)
    element = _as_element(name, svg.getvalue(), titles)
    return Drawing(element, png.getvalue(), rows, fonts.missing)


def _as_element(name: str, document: str, titles: Mapping[str, str]) -> str:
    """An SVG document as an element whose names are its own, whatever else is in the page."""
    element = re.sub(r"<!--.*?-->\n?", "", document[document.index("<svg") :], flags=re.DOTALL)
    tag = re.compile("<[^>]*>")  # What a text says is left alone.
    names = dict.fromkeys(n for t in tag.findall(element) for n in re.findall(r'\bid="([^"]+)"', t))
    own = {old: f"{name}-{index}" for index, old in enumerate(names)}

    def renamed(match: re.Match[str]) -> str:
        return f"{match[1]}{own.get(match[2], match[2])}{match[3]}"

    def changed(match: re.Match[str]) -> str:
        found = re.sub(r'(\bid="|href="#|url\(#)([^")]+)("|\))', renamed, match[0])
        found = re.sub(r"font-family: [^;\"]*(; )?", "", found)
        part = re.fullmatch(r'<g id="([^"]+)">', match[0])
        title = html.escape(written(titles.get(part[1], "")), quote=False) if part else ""
        return found + (f"<title>{title}</title>" if title else "")

    element = tag.sub(changed, element)
    return element.replace("<svg ", f'<svg style="font-family: {_SVG_FAMILIES}" ', 1)
