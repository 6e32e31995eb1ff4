"""What the settings of a design do, each and in pairs, on paper."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from app.analysis.effects import Factor, Response, Share
from app.charts.model import Shares, Trends
from app.charts.paper.points import (
    MOST_BESIDE,
    MOST_TICKS,
    SMALL_AXIS_CHARACTERS,
    SMALL_TICK_CHARACTERS,
    places_along,
)
from app.charts.paper.sheet import AXIS_LINES, GREY, INK, new_figure, plain, wrapped
from app.charts.styles import COLOURS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LEAST_RATIO = 20
"""Of the highest value to the lowest, from which on values may be seen on a scale of ratios."""
_NAME_CHARACTERS = 44
_SHADE = 0.2


def trends_figure(chart: Trends, small_print: str) -> "Figure":
    """A small plot for each setting, all on one scale, the variants as pale dots."""
    responses = chart.analysis.responses
    across = min(len(responses), MOST_BESIDE)
    up = math.ceil(len(responses) / across)
    figure = new_figure(2.7 * across + 0.6, 2.9 * up, small_print, least_width=5.5)
    found: Any = figure.subplots(up, across, sharey=True, squeeze=False)
    for axes, factor, response in zip(found.flat, chart.analysis.factors, responses, strict=False):
        _draw_trend(axes, factor, response, chart.analysis.values)
        axes.grid(axis="y", color="#E0E0E0", linewidth=0.6)
        axes.set_xlabel(wrapped(factor.axle.label, SMALL_AXIS_CHARACTERS, AXIS_LINES), fontsize=8)
    for axes in found.flat[len(responses) :]:
        axes.set_visible(False)
    for axes in found[:, 0]:
        axes.set_ylabel(wrapped(chart.what, SMALL_TICK_CHARACTERS, AXIS_LINES), fontsize=8)
    return figure


def _draw_trend(axes: Any, factor: Factor, response: Response, values: np.ndarray) -> None:
    axle = factor.axle
    is_curve = len(response.values) != len(axle.values)
    if is_curve:
        x = np.asarray(response.values, np.float64)
        dots = np.asarray(factor.column, np.float64)
        if _is_logarithmic(dots):
            axes.set_xscale("log")
    else:
        x = places_along(axes, axle)
        dots = x[[list(axle.values).index(value) for value in factor.column]]
        if len(axle.values) > MOST_TICKS:
            axes.tick_params(axis="x", rotation=45)
    axes.scatter(dots, values, s=9, color=GREY, alpha=0.35, linewidths=0)
    if axle.is_numeric:
        axes.plot(x, response.mean, color=COLOURS[0], linewidth=1.8, marker=_marker(is_curve))
        axes.fill_between(
            x, response.low, response.high, color=COLOURS[0], alpha=_SHADE, linewidth=0
        )
    else:
        # A line between values that have no order would say that there is one.
        arms = np.maximum([response.mean - response.low, response.high - response.mean], 0)
        axes.errorbar(
            x, response.mean, arms, color=COLOURS[0], linestyle="none", marker="o", capsize=3
        )
    axes.margins(x=0.08)


def _marker(is_curve: bool) -> str:
    return "" if is_curve else "o"


def _is_logarithmic(values: np.ndarray) -> bool:
    """Whether values, of a setting that has many, lie more evenly on a scale of ratios."""
    low, middle, high = (float(x) for x in np.quantile(values, [0, 0.5, 1]))
    if low <= 0 or high < _LEAST_RATIO * low:
        return False
    by_ratio = math.log(middle / low) / math.log(high / low)
    return abs(by_ratio - 0.5) < abs((middle - low) / (high - low) - 0.5)


def shares_figure(chart: Shares, small_print: str) -> "Figure":
    """A triangle: on its edge what each setting does by itself, within it what pairs do beyond."""
    from matplotlib import colormaps
    from matplotlib.colors import Normalize
    from matplotlib.patches import Rectangle

    names, analysis = chart.names, chart.analysis
    n = len(names)
    figure = new_figure(4.2 + 0.62 * n, 1.4 + 0.46 * n, small_print, least_width=5.5)
    axes: Any = figure.subplots()
    cells: dict[tuple[int, int], Share] = {
        **{(place, place): share for place, share in enumerate(analysis.alone)},
        **analysis.together,
    }
    largest = max(max(share.of_variance for share in cells.values()), 0.01)
    colours, norm = colormaps["cividis"], Normalize(0, largest)
    for across in range(n):
        for down in range(across, n):
            share = cells.get((across, down))
            face = Rectangle((across - 0.5, down - 0.5), 1, 1, edgecolor="white", linewidth=0.6)
            axes.add_patch(face)
            if share is None:
                face.set(facecolor="#EEEEEE", hatch="////", edgecolor="#BBBBBB")
                continue
            colour = colours(norm(share.of_variance))
            face.set_facecolor(colour)
            axes.text(
                across,
                down,
                _per_cent(share),
                ha="center",
                va="center",
                fontsize=8,
                color=_ink_on(colour),
                weight="bold" if share.is_significant else "normal",
            )
        axes.add_patch(
            Rectangle((across - 0.46, across - 0.46), 0.92, 0.92, fill=False, edgecolor=INK, lw=1.4)
        )
    axes.set_xlim(-0.5, n - 0.5)
    axes.set_ylim(n - 0.5, -0.5)
    axes.set_xticks(range(n), [str(place + 1) for place in range(n)])
    axes.set_yticks(range(n), _numbered(names))
    axes.spines[["left", "bottom"]].set_visible(False)
    axes.tick_params(length=0)
    return figure


def _numbered(names: Sequence[str]) -> list[str]:
    return [
        wrapped(f"{place}. {name}", _NAME_CHARACTERS, AXIS_LINES)
        for place, name in enumerate(names, 1)
    ]


def _per_cent(share: Share) -> str:
    return plain(f"{100 * share.of_variance:.0f} %")


def _ink_on(colour: Any) -> str:
    """White on dark colours and black on light ones."""
    red, green, blue, _ = colour
    return "white" if 0.299 * red + 0.587 * green + 0.114 * blue < 0.5 else "black"
