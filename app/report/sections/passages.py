"""How soon runs got somewhere: pictures of the share of them that have, by steps."""

from collections.abc import Iterable, Sequence

from app.analysis.passages import arrivals
from app.charts.model import ArrivalLine, ArrivalPanel, Arriving
from app.charts.paper.drawing import drawn
from app.charts.styles import Style
from app.experiments.record import Record
from app.metrics import PASSAGES
from app.report.document import Page
from app.results.read import passages_of
from app.util.html import Markup

Variant = tuple[str, Sequence[Record], Style]
"""The name of a line, the runs that it is of, and how it looks."""


def passages_picture(
    page: Page, name: str, caption: str, variants: Sequence[Variant], note: str = ""
) -> Markup:
    """A picture of the passages that were measured of variants; nothing where none was.

    Args:
        page: that keeps it.
        name: of its files.
        caption: what it is of.
        variants: as many as can be told apart.
        note: what one has to know of which these are.
    """
    panels = [
        ArrivalPanel(title, lines)
        for column, title in PASSAGES.items()
        if (lines := [*_lines(variants, column)])
    ]
    if not panels:
        return Markup()
    small = page.small_print(
        "Kaplan-Meier estimate of the share of n runs (seeds) that have got there by so many"
        " simulation steps; shaded: 95 % interval, point by point (log-log). Ticks: runs that"
        " ended before they got there, or before they had kept to it for long enough, and count"
        f" until then. {note}".strip()
    )
    return page.picture(name, caption, drawn(name, Arriving(panels), small))


def _lines(variants: Sequence[Variant], column: str) -> Iterable[ArrivalLine]:
    for label, runs, style in variants:
        passages = passages_of(runs, column)
        if passages:
            yield ArrivalLine(label, arrivals([*passages.values()]), style)
