"""Schedules on paper: when skills join, how long the selection is frozen then, what is explored."""

from typing import TYPE_CHECKING, Any

from app.charts.model import AXIS_UNITS, Lane, Schedules
from app.charts.paper.sheet import GREY, INK, new_figure, plain, wrapped
from app.charts.styles import COLOURS
from app.words.plain import plain as plain_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_EXPLORED, _FROZEN = COLOURS[2], COLOURS[3]
_ROW_IN = 0.27
_NAME_CHARACTERS = 60
_LATE = 0.55
"""Share of the axis from which on words stand before what they are about."""
_LEAST_SHARE = 0.004
"""Of the axis, that a freeze takes at least, to be seen."""


def schedules_figure(chart: Schedules, small_print: str) -> "Figure":
    """A lane for each skill of each variant, against trials."""
    n_rows = len(chart.lanes) + len({lane.variant for lane in chart.lanes})
    figure = new_figure(8.0, 1.0 + _ROW_IN * n_rows, small_print)
    axes: Any = figure.subplots()
    end = max(lane.trials for lane in chart.lanes)
    scale, label = AXIS_UNITS["trials"]
    axes.set_xlim(0, end * scale)
    axes.set_ylim(n_rows - 0.4, -0.6)
    places: list[int] = []
    row, variant = 0, None
    for lane in chart.lanes:
        if lane.variant != variant:
            variant = lane.variant
            name = wrapped(variant, _NAME_CHARACTERS, 1)
            axes.annotate(
                name,
                (0, row),
                (4, 0),
                textcoords="offset points",
                fontsize=9,
                fontweight="bold",
                va="center",
                color=INK,
            )
            row += 1
        _draw_lane(axes, row, lane, end, scale)
        places.append(row)
        row += 1
    axes.set_yticks(places, [plain(plain_name(lane.skill)) for lane in chart.lanes])
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(label)
    _legend(figure)
    return figure


def _draw_lane(axes: Any, row: int, lane: Lane, end: int, scale: float) -> None:
    axes.axhline(row, color="#E8E8E8", linewidth=0.8, zorder=0)
    if lane.joins >= lane.trials:
        axes.text(
            0.5 * end * scale,
            row,
            lane.words if lane.rule else "does not join",
            fontsize=7.5,
            color=GREY,
            ha="center",
            va="center",
        )
        return
    axes.plot([lane.joins * scale, lane.trials * scale], [row, row], color=GREY, linewidth=1.6)
    axes.plot([lane.joins * scale] * 2, [row - 0.34, row + 0.34], color=INK, linewidth=1.6)
    for first, until, _ in lane.explored:
        width = (min(until, lane.trials) - first) * scale
        axes.barh(row, width, 0.5, first * scale, color=_EXPLORED, zorder=2)
    if lane.freeze:
        width = max(lane.freeze, _LEAST_SHARE * end) * scale
        axes.barh(row - 0.3, width, 0.16, lane.joins * scale, color=_FROZEN, zorder=3)
    # Beside all that is drawn, on the side where there is more room.
    last = max([lane.joins + lane.freeze, *(until for _, until, _ in lane.explored)])
    is_late = lane.joins > _LATE * end
    axes.annotate(
        lane.words,
        ((lane.joins if is_late else last) * scale, row),
        (-5 if is_late else 5, 0),
        textcoords="offset points",
        ha="right" if is_late else "left",
        va="center",
        fontsize=7.5,
        color=INK,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.85},
    )


def _legend(figure: Any) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles = [
        Line2D([], [], color=INK, linewidth=0, marker="|", markersize=10, label="joins"),
        Line2D([], [], color=GREY, linewidth=1.6, label="can be chosen"),
        Patch(color=_EXPLORED, label="explored: taken with the probability given"),
        Patch(color=_FROZEN, label="selection frozen"),
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=4, frameon=False, fontsize=8)
