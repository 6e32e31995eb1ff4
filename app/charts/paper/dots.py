"""Estimates and their runs in rows, on paper."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from app.charts.model import Dot, Dots
from app.charts.paper.sheet import GREY, INK, arms, axis_title, new_figure, wrapped
from app.charts.styles import COLOURS
from app.charts.wording import PADDED
from app.words.numbers import shown_number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ROW_CHARACTERS = 44
_ROW_LINES = 4
_MOST_WIDE = 2
"""Columns that are wide; of more, each is narrower, so that their texts do not shrink on a page."""
_RUNS_SPREAD = 0.5
"""Of a row's height, that its runs lie in."""
_MOST_SHAPES = 1_000


def dots_figure(chart: Dots, small_print: str) -> "Figure":
    """A column for each quantity, and a row for each name."""
    columns = chart.columns
    n_rows = max(len(dots) for dots in columns.values())
    labels = [_row_label(dot) for dot in next(iter(columns.values()))]
    # Rows are as far apart as the longest label needs, so that none runs into the next.
    lines = max((label.count("\n") + 1 for label in labels), default=1)
    height = 1.6 + max(0.34, 0.17 * lines + 0.08) * n_rows
    column_in = 3.2 if len(columns) <= _MOST_WIDE else 2.6
    figure = new_figure(4.2 + column_in * len(columns), height, small_print, least_width=7)
    found = figure.subplots(1, len(columns), sharey=True, squeeze=False)[0]
    for index, (axes, (what, dots)) in enumerate(zip(found, columns.items(), strict=True)):
        there = [(k, dot) for k, dot in enumerate(dots) if math.isfinite(dot.estimate.value)]
        if what in chart.differences:
            axes.axvline(0, color=INK, linewidth=0.8, dashes=(4, 3), zorder=1)
        _draw_runs(axes, index, dots)
        for k, dot in there:
            axes.errorbar(
                [dot.estimate.value],
                [k],
                xerr=arms([dot.estimate]),
                color=dot.style.colour if dot.style else COLOURS[index % 2 * 3],
                linestyle="none",
                marker="os"[index % 2],
                markersize=5.5,
                capsize=3,
                elinewidth=1.3,
            )
        axes.set_xlabel(axis_title(what), fontsize=10 if len(columns) <= _MOST_WIDE else 8)
        axes.grid(axis="y", color="#E0E0E0", linewidth=0.6)
    found[0].set_yticks(range(len(labels)), labels)
    found[0].set_ylim(n_rows - 0.5, -0.5)
    return figure


def run_hints_of(chart: Dots) -> Mapping[str, Sequence[str]]:
    """What is shown under the pointer of each run, by the names of the parts that runs are in."""
    return {
        _part_of(index, k): [
            f"{dot.label}, seed {run.seed}: {shown_number(run.value, PADDED)}"
            for run in dot.runs
            if math.isfinite(run.value)
        ]
        for index, dots in enumerate(chart.columns.values())
        for k, dot in enumerate(dots)
    }


def _part_of(column: int, row: int) -> str:
    return f"runs-{column}-{row}"


def _draw_runs(axes: Any, column: int, dots: Sequence[Dot]) -> None:
    """Each run small and pale, a little above or below the middle of its row."""
    n_runs = sum(len(dot.runs) for dot in dots)
    for k, dot in enumerate(dots):
        there = [run for run in dot.runs if math.isfinite(run.value)]
        if there:
            axes.plot(
                [run.value for run in there],
                [k + _RUNS_SPREAD * run.height for run in there],
                linestyle="none",
                marker="o",
                markersize=3.2 if dot.style else 2.6,
                markeredgewidth=0,
                color=dot.style.colour if dot.style else GREY,
                alpha=0.5,
                zorder=1.5,
                gid=_part_of(column, k),
                # As shapes, thousands of them would make a page that no browser opens quickly.
                rasterized=n_runs > _MOST_SHAPES,
            )


def _row_label(dot: Dot) -> str:
    return f"{wrapped(dot.label, _ROW_CHARACTERS, _ROW_LINES)}  (n = {dot.estimate.n})"
