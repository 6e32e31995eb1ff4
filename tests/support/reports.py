"""What a written report says, and reports whose pictures are not drawn."""

import io
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from matplotlib.figure import Figure

from app.charts.model import Chart, Rows
from app.charts.paper import drawing
from app.charts.paper.drawing import Drawing
from app.experiments.store import REPORT_PAGE
from app.report import write

SAVE = Figure.savefig


@cache
def empty_picture(kind: str) -> bytes:
    """A picture of nothing, as matplotlib writes it."""
    out = io.BytesIO()
    SAVE(Figure(figsize=(1, 1)), out, format=kind, metadata={"Date": None} if kind == "svg" else {})
    return out.getvalue()


def without_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures of reports are empty, since they take most time.

    Of each kind of chart the first figure of a test is made: whatever is to be in it must still be
    there. How figures look and come out as files is tested with the charts.
    """
    made: dict[type[Chart], Figure] = {}

    def once(draw: Callable[[Any, str], Figure]) -> Callable[[Any, str], Figure]:
        def figure_of(chart: Any, small_print: str) -> Figure:
            if type(chart) not in made:
                made[type(chart)] = draw(chart, small_print)
                assert made[type(chart)].axes
            return made[type(chart)]

        return figure_of

    def saved(name: str, figure: Figure, rows: Rows, hints: Any, small_print: str) -> Drawing:
        svg = drawing._as_element(name, empty_picture("svg").decode(), {})
        return Drawing(svg, svg, empty_picture("png"), rows, small_print, 8.0, 5.0)

    for name in [name for name in vars(drawing) if name.endswith("_figure")]:
        monkeypatch.setattr(drawing, name, once(getattr(drawing, name)))
    monkeypatch.setattr(drawing, "_saved", saved)


def page_of(*folders: Path, compare: bool = False) -> str:
    """A page on folders, kept in the first of them with its pictures."""
    out = folders[0] / REPORT_PAGE if len(folders) > 1 else None
    return write.write_report(folders, out, compare).page.read_text(encoding="utf-8")


def text_of(page: str) -> str:
    return "\n".join(ET.fromstring(page.removeprefix("<!DOCTYPE html>")).itertext())


def table_of(page: str, word: str) -> list[dict[str, str]]:
    """Rows by their header of the first table that has a word in it; lines of cells by blanks."""
    root = ET.fromstring(page.removeprefix("<!DOCTYPE html>"))
    table = next(t for t in root.iter("table") if word in "".join(t.itertext()))
    head, *rows = ([" ".join(cell.itertext()) for cell in row] for row in table.iter("tr"))
    return [dict(zip(head, row, strict=True)) for row in rows]


def pictures_of(folder: Path) -> list[str]:
    return sorted(path.stem for path in (folder / "report_figures").glob("*.svg"))
