"""Learners in several worlds, in rows, on paper."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from app.charts.paper.sheet import INK, arms, axis_title, new_figure, plain
from app.charts.standings import Standing, Standings
from app.charts.styles import COLOURS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ROW_IN = 0.34
_COLUMN_IN = 2.55
_LABELS_IN = 1.9
_MARKERS = "ovs^D"
_OFFSETS = (0.0, -0.27, -0.14, 0.14, 0.27)
"""Of a row's height, by which the worlds lie apart in it; the first in the middle."""


def standings_figure(chart: Standings, small_print: str) -> "Figure":
    """A column for each quantity, a row for each learner, and in it a mark for each world."""
    columns = chart.columns
    labels = [plain(standing.label) for standing in next(iter(columns.values()))]
    width = _LABELS_IN + _COLUMN_IN * len(columns)
    figure: Any = new_figure(width, 1.15 + _ROW_IN * len(labels), small_print, least_width=7)
    found = figure.subplots(1, len(columns), sharey=True, squeeze=False)[0]
    for axes, (what, standings) in zip(found, columns.items(), strict=True):
        for row in range(0, len(standings), 2):
            axes.axhspan(row - 0.5, row + 0.5, color="#F3F3F3", linewidth=0, zorder=0)
        _mark(axes, chart, standings)
        for place in range(len(chart.worlds) - 1, -1, -1):
            _draw_world(axes, chart.worlds[place], place, standings)
        axes.set_xlabel(axis_title(what), fontsize=9)
        axes.grid(axis="x", color="#E0E0E0", linewidth=0.6)
        axes.set_axisbelow(True)
    found[0].set_yticks(range(len(labels)), labels)
    found[0].set_ylim(len(labels) - 0.5, -0.5)
    handles, names = found[0].get_legend_handles_labels()
    figure.legend(
        handles[::-1],
        names[::-1],
        loc="outside upper center",
        ncols=len(names),
        frameon=False,
        fontsize=9,
        columnspacing=1.2,
        handletextpad=0.3,
    )
    return figure


def _mark(axes: Any, chart: Standings, standings: Sequence[Standing]) -> None:
    """A line at the value of the row that the others are set against."""
    for standing in standings:
        if standing.label == chart.against and math.isfinite(standing.estimates[0].value):
            value = standing.estimates[0].value
            axes.axvline(value, color=INK, linewidth=0.8, dashes=(4, 3), zorder=1)


def _draw_world(axes: Any, world: str, place: int, standings: Sequence[Standing]) -> None:
    """All learners in one world; in the first one large, the new ones filled."""
    is_first = place == 0
    colour = INK if is_first else COLOURS[(place - 1) % len(COLOURS)]
    for row, standing in enumerate(standings):
        estimate = standing.estimates[place]
        if not math.isfinite(estimate.value):
            continue
        axes.errorbar(
            [estimate.value],
            [row + _OFFSETS[place % len(_OFFSETS)]],
            xerr=arms([estimate]),
            color=colour,
            markerfacecolor=colour if standing.is_new or not is_first else "white",
            linestyle="none",
            marker=_MARKERS[place % len(_MARKERS)],
            markersize=8 if is_first else 3.8,
            markeredgewidth=1.6 if is_first else 0,
            elinewidth=2.2 if is_first else 0.9,
            alpha=1 if is_first else 0.85,
            zorder=3 if is_first else 2,
        )
    axes.plot(
        [],
        [],
        color=colour,
        linestyle="none",
        marker=_MARKERS[place % len(_MARKERS)],
        markersize=8 if is_first else 5,
        label=plain(world),
    )
