"""How many runs have got somewhere, on paper."""

from typing import TYPE_CHECKING, Any

import numpy as np

from app.charts.model import AXIS_UNITS, ArrivalLine, ArrivalPanel, Arriving
from app.charts.paper.sheet import new_figure, plain, wrapped

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LEGEND_CHARACTERS = 46


def arrivals_figure(chart: Arriving, small_print: str) -> "Figure":
    """A panel for each thing that was reached, in rows of two."""
    panels = chart.panels
    n_columns = min(len(panels), 2)
    n_rows = -(-len(panels) // n_columns)
    figure = new_figure(8.0 if n_columns == 1 else 8.8, 1.0 + 3.2 * n_rows, small_print)
    found = figure.subplots(n_rows, n_columns, sharex=True, sharey=True, squeeze=False)
    for axes in found.flat[len(panels) :]:
        axes.set_visible(False)
    for axes, panel in zip(found.flat, panels, strict=False):
        _draw_panel(axes, panel)
    scale, label = AXIS_UNITS["steps"]
    for axes in found[-1]:
        axes.set_xlabel(label)
    for axes in found[:, 0]:
        axes.set_ylabel("share of runs that have got there")
    # Lines lie on both ends of the scale.
    found[0, 0].set_ylim(-0.02, 1.02)
    last = max(line.arrivals.last for panel in panels for line in panel.lines)
    found[0, 0].set_xlim(0, 1.02 * last * scale)
    _legend(figure, chart)
    return figure


def _draw_panel(axes: Any, panel: ArrivalPanel) -> None:
    scale, _ = AXIS_UNITS["steps"]
    axes.axhline(0.5, color="#E0E0E0", linewidth=0.8, zorder=1)
    for line in panel.lines:
        _draw_line(axes, line, scale)
    axes.set_title(plain(panel.title), fontsize=9.5)


def _draw_line(axes: Any, line: ArrivalLine, scale: float) -> None:
    found, style = line.arrivals, line.style
    # From none at the start to the last steps of which anything is known.
    x = np.concatenate([[0.0], found.steps, [found.last]]) * scale
    share, low, high = (
        np.concatenate([[0.0], part, part[-1:] if part.size else [0.0]])
        for part in (found.share, found.low, found.high)
    )
    axes.fill_between(x, low, high, step="post", color=style.colour, alpha=0.15, linewidth=0)
    (drawn,) = axes.plot(
        x, share, drawstyle="steps-post", color=style.colour, linewidth=style.width, zorder=3
    )
    if style.dashes:
        drawn.set_dashes(style.dashes)
    places = np.searchsorted(found.steps, found.censored, side="right")
    axes.plot(
        found.censored * scale,
        np.concatenate([[0.0], found.share])[places],
        linestyle="none",
        marker="|",
        markersize=7,
        color=style.colour,
        zorder=3,
    )


def _legend(figure: Any, chart: Arriving) -> None:
    from matplotlib.lines import Line2D

    handles: list[Line2D] = []
    for (label, style), counts in chart.counts.items():
        handle = Line2D([], [], color=style.colour, linewidth=style.width)
        if style.dashes:
            handle.set_dashes(style.dashes)
        handle.set_label(wrapped(f"{label} ({counts})", _LEGEND_CHARACTERS))
        handles.append(handle)
    figure.legend(
        handles=handles,
        loc="outside upper center",
        ncols=min(len(handles), 2),
        frameon=False,
        fontsize=8.5,
        handlelength=4,
    )
