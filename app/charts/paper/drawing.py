"""Charts on paper: each as SVG, PNG and CSV.

A chart is drawn on a figure of its own, so threads can draw at the same time; matplotlib is
imported when the first one is.
"""

import functools
import io
import re
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from app.charts.model import (
    Arriving,
    Chart,
    Curves,
    Dots,
    Effects,
    Plane,
    Points,
    Rows,
    Schedules,
    Shares,
    Trends,
)
from app.charts.paper.arrivals import arrivals_figure
from app.charts.paper.curves import curves_figure
from app.charts.paper.designs import shares_figure, trends_figure
from app.charts.paper.dots import dots_figure, run_hints_of
from app.charts.paper.fonts import fonts_for
from app.charts.paper.plane import hints_of, plane_figure
from app.charts.paper.points import effects_figure, points_figure
from app.charts.paper.schedules import schedules_figure
from app.charts.paper.sheet import SMALL_PRINT, foot_of
from app.charts.paper.standings import standings_figure
from app.charts.paper.values import values_figure
from app.charts.standings import Standings
from app.util import csv_texts
from app.util.html import escaped

_PNG_DPI = 160
_MOST_SHOWN = 20
"""Characters that a note names."""
_SVG_FAMILIES = "'DejaVu Sans', Verdana, 'Bitstream Vera Sans', sans-serif"
"""What a browser takes for the texts of a figure: fonts as wide as the one that they were laid out
with, and else one that is narrower; it looks for what they lack by itself."""


class Drawing(NamedTuple):
    """A picture and the numbers in it."""

    svg: str
    """An ``svg`` element for a file; its texts are texts."""
    inline: str
    """The same without its small print, for a page that has it as a text of its own."""
    png: bytes
    rows: Rows
    """The numbers, below the names of their columns."""
    small_print: str
    """What one has to know of the picture, a note a line."""
    width: float
    """In inches."""
    height: float
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


_Hints = Mapping[str, str | Sequence[str]]
"""What is shown under the pointer, by the names of parts of a figure: of the whole part, or of each
of its marks."""


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


def drawn(name: str, chart: Chart, small_print: str) -> Drawing:
    """A chart on paper, with its numbers.

    Args:
        name: begins the names of the element's parts, whatever else is in the page.
        chart: what is drawn.
        small_print: what one has to know of it, below it.
    """
    hints: _Hints = {}
    match chart:
        case Curves():
            figure = curves_figure(chart, small_print)
        case Arriving():
            figure = arrivals_figure(chart, small_print)
        case Dots():
            figure, hints = dots_figure(chart, small_print), run_hints_of(chart)
        case Standings():
            figure = standings_figure(chart, small_print)
        case Plane():
            figure, hints = plane_figure(chart, small_print), hints_of(chart)
        case Points():
            figure = points_figure(chart, small_print)
        case Effects():
            figure = effects_figure(chart, small_print)
        case Schedules():
            figure = schedules_figure(chart, small_print)
        case Trends():
            figure = trends_figure(chart, small_print)
        case Shares():
            figure = shares_figure(chart, small_print)
        case _:
            figure = values_figure(chart, small_print)
    return _saved(name, figure, chart.numbers, hints, small_print)


@functools.cache
def _have_texts_stay_texts() -> None:
    from matplotlib import rcParams

    rcParams["svg.fonttype"] = "none"


def _saved(name: str, figure: Any, rows: Rows, hints: _Hints, small_print: str) -> Drawing:
    """A figure as its files, with hints by the names of its parts."""
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
    foot = foot_of(figure)
    # All has its place now; to find it a second time would take a third of the time of a picture.
    figure.set_layout_engine("none")
    svg = io.StringIO()
    # The date and the maker's address have no place in a page that is to be the same every time.
    nothing: dict[str, Any] = dict.fromkeys(("Date", "Creator", "Format", "Type"))
    figure.savefig(svg, format="svg", metadata=nothing, dpi=_PNG_DPI)
    document = svg.getvalue()
    width, height = figure.get_size_inches()
    return Drawing(
        svg=_as_element(name, document, hints),
        inline=_as_element(name, _without_foot(document, height, foot), hints),
        png=png.getvalue(),
        rows=rows,
        small_print=small_print,
        width=width,
        height=height - foot,
        missing=fonts.missing,
    )


def _without_foot(document: str, height: float, foot: float) -> str:
    """An SVG document that ends above its small print.

    Args:
        document: the whole one.
        height: of it, in inches.
        foot: height of the small print, in inches.
    """
    begin = end = document.find(f'<g id="{SMALL_PRINT}">')
    if begin < 0:
        return document
    depth = 0
    for tag in re.finditer(r"<(/?)g\b[^>]*>", document[begin:]):
        depth += -1 if tag[1] else 1
        if not depth:
            end = begin + tag.end()
            break
    kept = f"{72 * (height - foot):.6g}"
    text = document[:begin] + document[end:]
    text = re.sub(r'(<svg [^>]*?height=")[^"]*(pt")', rf"\g<1>{kept}\2", text, count=1)
    return re.sub(r'(viewBox="0 0 [^ "]+ )[^"]+"', rf'\g<1>{kept}"', text, count=1)


def _as_element(name: str, document: str, hints: _Hints) -> str:
    """An SVG document as an element whose names are its own, whatever else is in the page."""
    element = re.sub(r"<!--.*?-->\n?", "", document[document.index("<svg") :], flags=re.DOTALL)
    tag = re.compile("<[^>]*>")  # What a text says is left alone.
    names = dict.fromkeys(n for t in tag.findall(element) for n in re.findall(r'\bid="([^"]+)"', t))
    own = {old: f"{name}-{index}" for index, old in enumerate(names)}
    waiting: list[str] = []
    """Hints of the marks that are still to come in a part, the next one last."""

    def renamed(match: re.Match[str]) -> str:
        return f"{match[1]}{own.get(match[2], match[2])}{match[3]}"

    def changed(match: re.Match[str]) -> str:
        found = re.sub(r'(\bid="|href="#|url\(#)([^")]+)("|\))', renamed, match[0])
        found = re.sub(r"font-family: [^;\"]*(; )?", "", found)
        part = re.fullmatch(r'<g id="([^"]+)">', match[0])
        if part:
            hint = hints.get(part[1], "")
            waiting[:] = () if isinstance(hint, str) else hint[::-1]
            return found + (
                f"<title>{escaped(hint)}</title>" if isinstance(hint, str) and hint else ""
            )
        if waiting and found.startswith("<use ") and found.endswith("/>"):
            return f"{found[:-2]}><title>{escaped(waiting.pop())}</title></use>"
        return found

    element = tag.sub(changed, element)
    return element.replace("<svg ", f'<svg style="font-family: {_SVG_FAMILIES}" ', 1)
