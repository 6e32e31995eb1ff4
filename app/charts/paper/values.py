"""Maps of value on paper."""

from typing import TYPE_CHECKING

import numpy as np

from app.charts.model import ValueMap, ValueMaps
from app.charts.paper.sheet import INK, new_figure, plain
from app.picture.colours import gain_colours, over_board, palette
from app.picture.shading import Ruler, nearness
from app.picture.theme import LIGHT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SCALE = Ruler(0, 200, "root")
"""Equivalent distances; hardly a state is farther."""
_TICKS = (0, 10, 25, 50, 100, 150, 200)
_PARTS_OF_SECTOR = 6
"""Straight pieces that an arc of a sector is drawn as."""
_TITLE_ROOM = 0.34
"""Height above a map, in its radii."""
_LEGEND_PIXELS = 256


def values_figure(chart: ValueMaps, small_print: str) -> "Figure":
    """Maps beside one another, and the scale of their colours.

    The colour is the equivalent distance to capture; it covers the paper by the share of headings
    and runs that have a value. The maps are pixels in the SVG, as their sectors are many.
    """
    n_maps = len(chart.maps)
    figure = new_figure(2.9 * n_maps + 1.3, 3.75, small_print, least_width=5.5)
    grid = figure.add_gridspec(1, n_maps + 1, width_ratios=[*[1] * n_maps, 0.13])
    for index, map_ in enumerate(chart.maps):
        _draw_map(figure.add_subplot(grid[0, index]), map_, chart.edges, chart.vision)
    _draw_scale(figure.add_subplot(grid[0, -1]))
    return figure


def _draw_map(axes: "Axes", map_: ValueMap, edges: np.ndarray, vision: float) -> None:
    from matplotlib.patches import Wedge

    n_directions = map_.value.share.shape[1]
    turn = np.arange(n_directions * _PARTS_OF_SECTOR + 1) / (n_directions * _PARTS_OF_SECTOR)
    # The first sector is centred on straight ahead.
    angle = 2 * np.pi * (turn - 0.5 / n_directions)
    radius = np.concatenate([[0], edges])[:, np.newaxis]
    colours = np.repeat(value_colours(*map_.value), _PARTS_OF_SECTOR, axis=1)
    mesh = axes.pcolormesh(
        radius * np.cos(angle), radius * np.sin(angle), colours, antialiased=False
    )
    mesh.set_rasterized(True)
    field = Wedge((0, 0), vision, -90, 90, fill=False, edgecolor=INK, linewidth=1)
    axes.add_patch(field)
    axes.plot([0], [0], marker="o", markersize=4.5, color=INK)
    axes.annotate(
        "",
        (0.62 * vision, 0),
        (0, 0),
        arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.3, "shrinkA": 0},
    )
    far = float(edges[-1])
    axes.set_xlim(-far, far)
    axes.set_ylim(-far, (1 + _TITLE_ROOM) * far)
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set_visible(False)
    # Inside of the axes: the layout does not make room above axes whose aspect is fixed.
    title = plain(f"{map_.title}\nn = {map_.n}")
    axes.text(0, 1.05 * far, title, fontsize=9, ha="center", va="bottom")


def value_colours(distance: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Colours as on the page of the lab, ``(..., 3) uint8``.

    Args:
        distance: ``(...)``: equivalent distances to capture in steps, NaN where there is none.
        share: ``(...)``: share of headings and runs that have one, 0 to 1.
    """
    gain = palette(gain_colours(), nearness(distance, _SCALE))
    return over_board(gain, np.where(np.isfinite(distance), share, 0), LIGHT)


def _draw_scale(axes: "Axes") -> None:
    """The scale of colours: upwards the distance, from left to right the share of headings."""
    place, share = np.meshgrid(
        (np.arange(_LEGEND_PIXELS) + 0.5) / _LEGEND_PIXELS, np.linspace(0, 1, 24), indexing="ij"
    )
    low, high = _SCALE.low, _SCALE.high
    distance = low + (high - low) * place**2
    axes.imshow(value_colours(distance, share), origin="lower", extent=(0, 1, 0, 1), aspect="auto")
    axes.set_xticks([0, 1], ["0", "1"])
    axes.set_xlabel("share with\na value", fontsize=8)
    axes.yaxis.tick_right()
    axes.yaxis.set_label_position("right")
    shown = [str(tick) for tick in _TICKS[:-1]] + [f"≥ {_TICKS[-1]}"]
    axes.set_yticks([float(_SCALE.place(tick)) for tick in _TICKS], shown)
    axes.set_ylabel("equivalent distance to capture (steps)", fontsize=8)
