"""Settings that were swept one by one, on paper."""

import math
from typing import TYPE_CHECKING

import numpy as np

from app.analysis.axles import Axle, told_apart
from app.charts.model import Effects, Points
from app.charts.paper.sheet import (
    AXIS_LINES,
    arms,
    axis_title,
    new_figure,
    plain,
    span,
    wrapped,
)
from app.charts.styles import COLOURS, style_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_BESIDE = 4
"""Small plots in a row."""
SMALL_AXIS_CHARACTERS = 40
SMALL_TICK_CHARACTERS = 32
"""Of all ticks of a small plot, and of its title that stands upright."""
MOST_TICKS = 6
"""Values that a small plot has a tick for each of."""


def points_figure(chart: Points, small_print: str) -> "Figure":
    """Points with intervals, a line through them for each series."""
    figure = new_figure(7.2, 4.2, small_print)
    axes = figure.subplots()
    x = places_along(axes, chart.axle)
    for index, (label, estimates, _) in enumerate(chart.series):
        there = [k for k, estimate in enumerate(estimates) if estimate is not None]
        found = [estimate for estimate in estimates if estimate is not None]
        style = style_of(index)
        middle = np.asarray([estimate.value for estimate in found])
        axes.errorbar(
            x[there],
            middle,
            arms(found),
            color=style.colour,
            linewidth=style.width,
            linestyle=(0, style.dashes) if style.dashes else "-",
            elinewidth=1,
            marker="osD^v"[index % 5],
            markersize=5,
            capsize=3,
            label=plain(f"{label} (n = {span({e.n for e in found} or {0})})"),
        )
    axes.set_xlabel(wrapped(chart.axle.label, most_lines=AXIS_LINES))
    axes.set_ylabel(axis_title(chart.what))
    figure.legend(loc="outside upper center", ncols=2, frameon=False, fontsize=8.5)
    return figure


def effects_figure(chart: Effects, small_print: str) -> "Figure":
    """A small plot for each setting, all on one scale."""
    effects = chart.effects
    across = min(len(effects), MOST_BESIDE)
    up = math.ceil(len(effects) / across)
    figure = new_figure(2.7 * across + 0.6, 2.9 * up, small_print, least_width=5.5)
    found = figure.subplots(up, across, sharey=True, squeeze=False)
    for axes, (axle, estimates) in zip(found.flat, effects, strict=False):
        x = places_along(axes, axle)
        axes.errorbar(
            x,
            [estimate.value for estimate in estimates],
            arms(estimates),
            color=COLOURS[0],
            # A line between values that have no order would say that there is one.
            linestyle="-" if axle.is_numeric else "none",
            linewidth=1.2,
            elinewidth=1,
            marker="o",
            markersize=5,
            capsize=3,
        )
        axes.margins(x=0.12)
        shown = told_apart(axle.values)
        if len(shown) <= MOST_TICKS:
            axes.set_xticks(x, list(map(plain, shown)))
        if sum(map(len, shown)) > SMALL_TICK_CHARACTERS:
            axes.tick_params(axis="x", rotation=45)
        axes.grid(axis="y", color="#E0E0E0", linewidth=0.6)
        axes.set_xlabel(wrapped(axle.label, SMALL_AXIS_CHARACTERS, AXIS_LINES), fontsize=8)
    for axes in found.flat[len(effects) :]:
        axes.set_visible(False)
    for axes in found[:, 0]:
        axes.set_ylabel(wrapped(chart.what, SMALL_TICK_CHARACTERS, AXIS_LINES), fontsize=8)
    return figure


def places_along(axes: "Axes", axle: Axle) -> np.ndarray:
    """Where the values of a setting lie along the axis, which is made to suit them."""
    x = np.asarray(axle.places)
    if axle.is_logarithmic:
        axes.set_xscale("log")
        axes.minorticks_off()
    if axle.is_logarithmic or axle.is_even:
        axes.set_xticks(x, [*map(plain, told_apart(axle.values))])
    return x
