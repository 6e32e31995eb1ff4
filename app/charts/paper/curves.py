"""Learning curves on paper."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from app.analysis.estimates import Axis
from app.charts.greedy import joined_up
from app.charts.model import AXIS_UNITS, Curves, Mark, Panel, levels
from app.charts.paper.sheet import GREY, new_figure, plain, span, wrapped
from app.charts.styles import Style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LEGEND_CHARACTERS = 46
_FAINT = 0.5
_GREEDY_WIDTH = 0.9
_MARGIN = 1.02
"""Of the axis, by the end of what goes on longest."""
_NAME_ROOM = 0.24
"""Of the name of a mark, as a share of the axis."""


def curves_figure(chart: Curves, small_print: str) -> "Figure":
    """A panel for each world, all with the same scales."""
    panels = chart.panels
    width = 8.0 if len(panels) == 1 else min(3.9 * len(panels), 12.5)
    figure = new_figure(width, 4.6 if len(panels) == 1 else 4.2, small_print)
    found = figure.subplots(1, len(panels), sharex=True, sharey=True, squeeze=False)[0]
    for axes, panel in zip(found, panels, strict=True):
        _draw_panel(axes, panel, chart.axis)
    ends = [line.band.end[-1] for panel in panels for line in panel.lines if line.band.end.size]
    found[0].set_xlim(0, _MARGIN * AXIS_UNITS[chart.axis][0] * max(ends, default=1))
    # Where the names of marks fit is known once all panels have their scale.
    for axes, panel in zip(found, panels, strict=True):
        _draw_marks(axes, panel, chart.axis)
    found[0].set_ylabel("mean reward per trial")
    _legend(figure, panels)
    return figure


def _draw_panel(axes: Any, panel: Panel, axis: Axis) -> None:
    scale, label = AXIS_UNITS[axis]
    for line in panel.lines:
        band, style = line.band, line.style
        if not band.mean.size:
            continue
        x = band.at * scale
        _draw_mean(axes, style, x[: line.n_whole], band.mean[: line.n_whole], 1)
        rest = slice(max(line.n_whole - 1, 0), None)
        _draw_mean(axes, style, x[rest], band.mean[rest], _FAINT)
        if line.greedy is not None:
            for part in joined_up(line.greedy.at):
                axes.plot(
                    line.greedy.at[part] * scale,
                    line.greedy.reward[part],
                    color=style.colour,
                    linewidth=_GREEDY_WIDTH,
                    linestyle=(0, (1, 1.5)),
                    marker=".",
                    markersize=2.5,
                    zorder=2.5,
                )
        axes.fill_between(x, band.low, band.high, color=style.colour, alpha=0.2, linewidth=0)
    axes.axhline(0, color=GREY, linewidth=0.5, zorder=1)
    axes.set_xlabel(label)


def _draw_marks(axes: Any, panel: Panel, axis: Axis) -> None:
    """The title, and lines with their names above the axes, each to the right of its mark."""
    scale, _ = AXIS_UNITS[axis]
    marks: Sequence[Mark] = sorted({mark for line in panel.lines for mark in line.marks})
    axes.set_title(plain(panel.title), fontsize=9.5, pad=22 if marks else 6)
    places = [mark.at * scale for mark in marks]
    heights = levels(places, axes.get_xlim()[1] * _NAME_ROOM)
    for mark, at, level in zip(marks, places, heights, strict=True):
        axes.axvline(at, color=GREY, linewidth=0.9, dashes=(5, 4), zorder=1)
        axes.annotate(
            plain(mark.label),
            (at, 1),
            (0, 2 + 9 * level),
            xycoords=axes.get_xaxis_transform(),
            textcoords="offset points",
            ha="left",
            va="bottom",
            fontsize=7,
            color=GREY,
        )


def _draw_mean(axes: Any, style: Style, x: np.ndarray, y: np.ndarray, alpha: float) -> None:
    width = style.width if alpha == 1 else 0.6 * style.width
    (drawn,) = axes.plot(x, y, color=style.colour, linewidth=width, alpha=alpha, zorder=3)
    if style.dashes:
        drawn.set_dashes(style.dashes)


def _legend(figure: Any, panels: Sequence[Panel]) -> None:
    from matplotlib.lines import Line2D

    counts: dict[tuple[str, Style], set[int]] = {}
    for panel in panels:
        for line in panel.lines:
            counts.setdefault((line.label, line.style), set()).add(line.n)
    handles = []
    for (label, style), found in counts.items():
        handle = Line2D([], [], color=style.colour, linewidth=style.width)
        if style.dashes:
            handle.set_dashes(style.dashes)
        handle.set_label(wrapped(f"{label} (n = {span(found)})", _LEGEND_CHARACTERS))
        handles.append(handle)
    columns = min(len(handles), 4 if len(panels) > 1 else 2)
    figure.legend(
        handles=handles,
        loc="outside upper center",
        ncols=columns,
        frameon=False,
        fontsize=8.5,
        handlelength=4,
    )
