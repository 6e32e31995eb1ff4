"""Pictures of results: curves, sweeps, comparisons and value maps, each as SVG, PNG and CSV.

A picture is drawn on a figure of its own, so threads can draw at the same time; matplotlib is
imported when the first one is. Colours are those of Okabe and Ito, which people with a colour
vision deficiency can tell apart, and every line differs in width and dashes as well, as in the
thesis, so that a copy in black and white still tells who is who.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from app.analysis.estimates import Axis, Band, Estimate
from app.charts.drawing import (
    AXIS_LINES,
    GREY,
    Drawing,
    axis_title,
    new_figure,
    plain,
    saved,
    wrapped,
)
from app.picture.colours import gain_colours, over_board, palette
from app.picture.shading import Ruler, nearness
from app.picture.theme import LIGHT
from learners.measures import FoldedValue

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_INK = "#222222"
_LEGEND_CHARACTERS = 46
_ROW_CHARACTERS = 44
_ROW_LINES = 4
_MOST_BESIDE = 4
"""Small plots in a row."""
_SMALL_AXIS_CHARACTERS = 40
_SMALL_TICK_CHARACTERS = 32
"""Of all ticks of a small plot, and of its title that stands upright."""
_MOST_TICKS = 6
"""Values that a small plot has a tick for each of."""
_RUN_HEIGHTS = 5
"""At which the runs of a row are drawn, so that equal ones can be told apart."""
_RUNS_SPREAD = 0.5
"""Of a row's height, that its runs lie in."""
_MOST_SHAPES = 1_000
_FAINT = 0.5
_MOST_UNEVEN = 10
"""Times that one gap between swept values may be as wide as another on their own scale."""
_MOST_LABELLED_CELLS = 400
SKY_BLUE = "#56B4E9"
_OTHERS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", SKY_BLUE, "#222222", "#B8A800")
MOST_STYLES = len(_OTHERS)
"""Lines after which colours come again."""
_DASHES: Sequence[tuple[float, ...]] = ((), (6, 2), (1.5, 1.5), (7, 2, 1.5, 2), (3, 1.5))
_DIFFERENCES = ("#0D2A5B", "#4A70A8", "#B4B4B4", "#F2D18E", "#FFF6DC")
"""From below zero to above it: blue to orange, and from dark to light."""
_VALUE_SCALE = Ruler(0, 200, "root")
"""Equivalent distances; hardly a state is farther."""
_VALUE_TICKS = (0, 10, 25, 50, 100, 150, 200)
_PARTS_OF_SECTOR = 6
"""Straight pieces that an arc of a sector is drawn as."""
_TITLE_ROOM = 0.34
"""Height above a map, in its radii."""
_LEGEND_PIXELS = 256
AXIS_UNITS: Mapping[Axis, tuple[float, str]] = {
    "steps": (1e-6, "simulation steps (millions)"),
    "trials": (1e-3, "trials (thousands)"),
}
"""What steps or trials are multiplied by to be drawn, and what an axis of them is called."""


class Style(NamedTuple):
    """How a line looks."""

    colour: str
    width: float
    dashes: tuple[float, ...] = ()
    """Lengths of dashes and gaps in line widths; none for a solid line."""


THESIS_STYLES: Mapping[str, Style] = {
    "timed": Style("#005A8F", 2.6),
    "hierarchical_3": Style("#E69F00", 2.6, (3, 1)),
    "standard_q": Style("#111111", 1.1),
    "hierarchical_2": Style("#C2609A", 1.1, (5, 1.5, 1.5, 1.5)),
}
"""Dark and thick, light and thick, dark and thin, light and thin, as in Figure 4.1."""


class Mark(NamedTuple):
    """A moment that the axis shows: the introduction of a skill."""

    at: float
    label: str


class Line(NamedTuple):
    """A curve with its name."""

    label: str
    band: Band
    style: Style
    n: int
    """Runs it began with."""
    marks: Sequence[Mark] = ()


class Panel(NamedTuple):
    """Curves that share their axes."""

    title: str
    lines: Sequence[Line]


class Dot(NamedTuple):
    """An estimate with its name, and the values of the runs that it is from."""

    label: str
    estimate: Estimate
    runs: Sequence[float] = ()


class Axle(NamedTuple):
    """A setting that was swept, and its values in order."""

    key: str
    values: Sequence[Any]
    words: str = ""
    """What it is in plain words; empty where there are none but its key."""

    @property
    def label(self) -> str:
        """What it is, in words if there are any."""
        return self.words or self.key

    @property
    def is_numeric(self) -> bool:
        """Whether its values lie on a scale."""
        return all(isinstance(v, int | float) and not isinstance(v, bool) for v in self.values)

    @property
    def is_logarithmic(self) -> bool:
        """Whether its values are better seen on a scale of ratios."""
        if len(self.values) < 3 or not self.is_numeric or min(self.values) <= 0:
            return False
        ratios = [b / a for a, b in zip(self.values, self.values[1:], strict=False)]
        return min(ratios) > 1.3 and max(ratios) / min(ratios) < 1.3

    @property
    def is_crowded(self) -> bool:
        """Whether its values, on a scale, would lie on top of one another."""
        if len(self.values) < 2 or not self.is_numeric:
            return False
        gaps = [b - a for a, b in zip(self.values, self.values[1:], strict=False)]
        return min(gaps) * _MOST_UNEVEN < max(gaps)


def style_of(index: int) -> Style:
    """The style of one of several lines that have none of their own."""
    colour = _OTHERS[index % len(_OTHERS)]
    return Style(colour, 1.2 + 0.7 * (index % 2), _DASHES[index % len(_DASHES)])


# --- Learning curves -----------------------------------------------------------------------------


def with_clear_marks(lines: Sequence[Line]) -> Sequence[Line]:
    """Lines without marks where theirs differ: it could not be seen which are whose."""
    if len({tuple(line.marks) for line in lines if line.marks}) <= 1:
        return lines
    return [line._replace(marks=()) for line in lines]


def draw_curves(name: str, panels: Sequence[Panel], axis: Axis, small_print: str) -> Drawing:
    """Reward against steps or trials: a panel for each world, one scale of reward for all."""
    width = 8.0 if len(panels) == 1 else min(3.9 * len(panels), 12.5)
    figure = new_figure(width, 4.6 if len(panels) == 1 else 4.2, small_print)
    found = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for axes, panel in zip(found, panels, strict=True):
        _draw_panel(axes, panel, axis)
    found[0].set_ylabel("mean reward per trial")
    _legend(figure, panels)
    return saved(name, figure, _curve_rows(panels, axis))


def _draw_panel(axes: "Axes", panel: Panel, axis: Axis) -> None:
    scale, label = AXIS_UNITS[axis]
    for line in panel.lines:
        band, style = line.band, line.style
        if not band.mean.size:
            continue
        x = band.middle * scale
        all_there = _windows_of_all(line)
        _draw_mean(axes, style, x[:all_there], band.mean[:all_there], 1)
        # The runs that go on longest may not be typical: what they alone say is drawn faintly.
        rest = slice(max(all_there - 1, 0), None)
        _draw_mean(axes, style, x[rest], band.mean[rest], _FAINT)
        axes.fill_between(x, band.low, band.high, color=style.colour, alpha=0.2, linewidth=0)
    axes.axhline(0, color=GREY, linewidth=0.5, zorder=1)
    axes.set_xlim(left=0)
    axes.margins(x=0.02)
    axes.set_xlabel(label)
    axes.set_title(
        plain(panel.title), fontsize=9.5, pad=22 if any(p.marks for p in panel.lines) else 6
    )
    for mark in _distinct(mark for line in panel.lines for mark in line.marks):
        at = mark.at * scale
        axes.axvline(at, color=GREY, linewidth=0.9, dashes=(5, 4), zorder=1)
    _name_marks(axes, panel, scale)


def _distinct(marks: Any) -> list[Mark]:
    return sorted(set(marks))


def _name_marks(axes: "Axes", panel: Panel, scale: float) -> None:
    """Names above the axes, each to the right of its mark; the earlier of two close ones higher."""
    names = _distinct(mark for line in panel.lines for mark in line.marks)
    room = axes.get_xlim()[1] * 0.24
    following, level = math.inf, 0
    for mark in reversed(names):
        at = mark.at * scale
        level = level + 1 if following - at < room else 0
        following = at
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


def _draw_mean(axes: "Axes", style: Style, x: np.ndarray, y: np.ndarray, alpha: float) -> None:
    width = style.width if alpha == 1 else 0.6 * style.width
    (drawn,) = axes.plot(x, y, color=style.colour, linewidth=width, alpha=alpha, zorder=3)
    if style.dashes:
        drawn.set_dashes(style.dashes)


def _windows_of_all(line: Line) -> int:
    """Windows from the first on in which no run is missing."""
    fewer = np.flatnonzero(line.band.n < line.n)
    return int(fewer[0]) if fewer.size else line.band.n.size


def _legend(figure: "Figure", panels: Sequence[Panel]) -> None:
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
        handle.set_label(wrapped(f"{label} (n = {_span(found)})", _LEGEND_CHARACTERS))
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


def _span(numbers: set[int]) -> str:
    low, high = min(numbers), max(numbers)
    return str(low) if low == high else f"{low}–{high}"


def _curve_rows(panels: Sequence[Panel], axis: Axis) -> list[Sequence[Any]]:
    rows: list[Sequence[Any]] = [
        ["panel", "line", f"from_{axis}", f"to_{axis}", "reward", "low", "high", "n"]
    ]
    for panel in panels:
        for line in panel.lines:
            columns = (column.tolist() for column in line.band)
            rows += [
                [panel.title, line.label, start, end, mean, low, high, n]
                for start, end, mean, low, high, n in zip(*columns, strict=True)
            ]
            rows += [
                [panel.title, f"{line.label}: introduction of {mark.label}", mark.at, mark.at]
                for mark in line.marks
            ]
    return rows


# --- Sweeps --------------------------------------------------------------------------------------

Cells = Mapping[tuple[int, int], Estimate]
"""Estimates by place: index along the first axle, and along the second."""


def draw_plane(
    name: str,
    axles: tuple[Axle, Axle],
    cells: Cells,
    what: str,
    small: str,
    framed: tuple[int, int] | None = None,
) -> Drawing:
    """Two settings swept together: a map of the plane, each cell with its value.

    Cells have equal sizes whatever their values; those without runs stay hatched. In a page, the
    interval of a cell shows under the pointer.

    Args:
        name: of the drawing.
        axles: the settings.
        cells: the estimates.
        what: they are of.
        small: small print.
        framed: place of the cell that has a frame, if any.
    """
    norm, colours = _scale_of([cell.value for cell in cells.values()])
    faces = {
        place: _Face(colours(norm(cell.value)), _number(cell.value, ".3g"), framed=place == framed)
        for place, cell in cells.items()
        if math.isfinite(cell.value)
    }
    return _plane(name, axles, cells, faces, (norm, colours), what, small)


def draw_differences(
    name: str,
    axles: tuple[Axle, Axle],
    cells: Cells,
    reference: tuple[int, int],
    what: str,
    small: str,
) -> Drawing:
    """The plane of two settings once more: how far each cell lies from one of them.

    The scale of colours has its middle at no difference, and grows lighter all the way, so that a
    copy in black and white keeps the sign. A number is bold where its interval excludes 0.

    Args:
        name: of the drawing.
        axles: the settings.
        cells: the differences.
        reference: place of the cell that they are to, which is framed.
        what: differs.
        small: small print.
    """
    norm, colours = _scale_around_zero([cell.value for cell in cells.values()])
    faces = {
        place: _Face(colours(norm(cell.value)), _signed(cell.value, norm.vmax), excludes_zero(cell))
        for place, cell in cells.items()
        if math.isfinite(cell.value)
    }
    faces[reference] = _Face(colours(norm(0.0)), "0", framed=True)
    return _plane(name, axles, cells, faces, (norm, colours), what, small, has_zero=True)


class _Face(NamedTuple):
    """How a cell of a plane looks."""

    colour: tuple[float, float, float, float]
    text: str
    bold: bool = False
    framed: bool = False


def _plane(
    name: str,
    axles: tuple[Axle, Axle],
    cells: Cells,
    faces: Mapping[tuple[int, int], _Face],
    scale: tuple[Any, Any],
    what: str,
    small: str,
    has_zero: bool = False,
) -> Drawing:
    from matplotlib.cm import ScalarMappable

    across, up = axles
    n_across, n_up = len(across.values), len(up.values)
    figure = new_figure(
        min(3.2 + 0.62 * n_across, 12), min(2.6 + 0.45 * n_up, 10), small, least_width=5.5
    )
    axes = figure.subplots()
    _draw_cells(axes, (n_across, n_up), faces)
    axes.set_xlim(-0.5, n_across - 0.5)
    axes.set_ylim(-0.5, n_up - 0.5)
    shown_across, shown_up = (told_apart(axle.values, grouped) for axle in axles)
    crowded = max(map(len, shown_across), default=0) > 6
    axes.set_xticks(range(n_across), list(map(plain, shown_across)))
    axes.tick_params(axis="x", rotation=45 if crowded else 0)
    axes.set_yticks(range(n_up), list(map(plain, shown_up)))
    axes.set_xlabel(wrapped(across.label, most_lines=AXIS_LINES))
    axes.set_ylabel(axis_title(up.label))
    axes.set_facecolor("#EEEEEE")
    bar = figure.colorbar(ScalarMappable(*scale), ax=axes, label=axis_title(what))
    if has_zero:
        bar.ax.axhline(0, color=_INK, linewidth=1.5)
    titles = {
        f"cell-{i}-{j}": f"{across.label} = {shown_across[i]}, "
        f"{up.label} = {shown_up[j]}: {shown_estimate(cell)}, n = {cell.n}"
        for (i, j), cell in cells.items()
    }
    rows: list[Sequence[Any]] = [[across.key, up.key, what, "low", "high", "n"]]
    rows += [[across.values[i], up.values[j], *cell] for (i, j), cell in sorted(cells.items())]
    return saved(name, figure, rows, titles)


def _scale_of(values: Sequence[float]) -> tuple[Any, Any]:
    from matplotlib import colormaps
    from matplotlib.colors import Normalize

    there = [value for value in values if math.isfinite(value)] or [0.0]
    low, high = min(there), max(there)
    return Normalize(low, high if high > low else low + 1), colormaps["cividis"]


def _scale_around_zero(values: Sequence[float]) -> tuple[Any, Any]:
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    colours = LinearSegmentedColormap.from_list("differences", _DIFFERENCES)
    farthest = max((abs(value) for value in values if math.isfinite(value)), default=0) or 1.0
    return Normalize(-farthest, farthest), colours


def excludes_zero(estimate: Estimate) -> bool:
    """Whether the whole interval lies on one side of 0; without one, it does not."""
    return estimate.low > 0 or estimate.high < 0


def _signed(value: float, largest: float) -> str:
    """A difference with its sign, as precise as the largest one is with three digits."""
    digits = max(2 - math.floor(math.log10(largest)), 0)
    text = f"{value:+.{digits}f}"
    return text.replace("-", "\N{MINUS SIGN}") if float(text) else text[1:]


def _draw_cells(
    axes: "Axes", shape: tuple[int, int], faces: Mapping[tuple[int, int], _Face]
) -> None:
    from matplotlib.patches import Rectangle

    labelled = shape[0] * shape[1] <= _MOST_LABELLED_CELLS
    for i in range(shape[0]):
        for j in range(shape[1]):
            face = faces.get((i, j))
            patch = Rectangle((i - 0.5, j - 0.5), 1, 1, facecolor="#EEEEEE", edgecolor="white")
            patch.set_linewidth(0.6)
            if face is None:
                patch.set(hatch="////", edgecolor="#BBBBBB")
            else:
                patch.set_facecolor(face.colour)
            patch.set_gid(f"cell-{i}-{j}")
            axes.add_patch(patch)
            if face is not None and labelled:
                ink, weight = _ink_on(face.colour), "bold" if face.bold else "normal"
                axes.text(
                    i, j, face.text, ha="center", va="center", fontsize=7, color=ink, weight=weight
                )
            if face is not None and face.framed:
                axes.add_patch(
                    Rectangle((i - 0.46, j - 0.46), 0.92, 0.92, fill=False, edgecolor=_INK, lw=1.6)
                )


def _ink_on(colour: tuple[float, float, float, float]) -> str:
    """White on dark colours and black on light ones."""
    red, green, blue, _ = colour
    return "white" if 0.299 * red + 0.587 * green + 0.114 * blue < 0.5 else "black"


class Series(NamedTuple):
    """Estimates along a swept setting; None where nothing was run."""

    label: str
    estimates: Sequence[Estimate | None]


def draw_points(name: str, axle: Axle, series: Sequence[Series], what: str, small: str) -> Drawing:
    """One setting swept: points with intervals."""
    figure = new_figure(7.2, 4.2, small)
    axes = figure.subplots()
    x = _places_along(axes, axle)
    rows: list[Sequence[Any]] = [["line", axle.key, what, "low", "high", "n"]]
    for index, (label, estimates) in enumerate(series):
        there = [k for k, estimate in enumerate(estimates) if estimate is not None]
        found = [estimate for estimate in estimates if estimate is not None]
        style = style_of(index)
        middle = np.asarray([estimate.value for estimate in found])
        axes.errorbar(
            x[there],
            middle,
            _arms(found),
            color=style.colour,
            linewidth=style.width,
            linestyle=(0, style.dashes) if style.dashes else "-",
            elinewidth=1,
            marker="osD^v"[index % 5],
            markersize=5,
            capsize=3,
            label=plain(f"{label} (n = {_span({e.n for e in found} or {0})})"),
        )
        rows += [[label, axle.values[k], *e] for k, e in zip(there, found, strict=True)]
    axes.set_xlabel(wrapped(axle.label, most_lines=AXIS_LINES))
    axes.set_ylabel(axis_title(what))
    figure.legend(loc="outside upper center", ncols=2, frameon=False, fontsize=8.5)
    return saved(name, figure, rows)


def _places_along(axes: "Axes", axle: Axle) -> np.ndarray:
    """Where the values of a setting lie along the axis, which is made to suit them."""
    on_scale = axle.is_numeric and (axle.is_logarithmic or not axle.is_crowded)
    x = np.asarray(axle.values if on_scale else range(len(axle.values)), np.float64)
    if axle.is_logarithmic:
        axes.set_xscale("log")
        axes.minorticks_off()
    if axle.is_logarithmic or not on_scale:
        axes.set_xticks(x, [*map(plain, told_apart(axle.values))])
    return x


class Effect(NamedTuple):
    """A setting, and an estimate at each of its values."""

    axle: Axle
    estimates: Sequence[Estimate]


def draw_effects(name: str, effects: Sequence[Effect], what: str, small: str) -> Drawing:
    """Several settings, a small plot for each: points with intervals, all on one scale."""
    across = min(len(effects), _MOST_BESIDE)
    up = math.ceil(len(effects) / across)
    figure = new_figure(2.7 * across + 0.6, 2.9 * up, small, least_width=5.5)
    found = figure.subplots(up, across, sharey=True, squeeze=False)
    rows: list[Sequence[Any]] = [["setting", "value", what, "low", "high", "n"]]
    for axes, (axle, estimates) in zip(found.flat, effects, strict=False):
        x = _places_along(axes, axle)
        axes.errorbar(
            x,
            [estimate.value for estimate in estimates],
            _arms(estimates),
            color=_OTHERS[0],
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
        if len(shown) <= _MOST_TICKS:
            axes.set_xticks(x, list(map(plain, shown)))
        if sum(map(len, shown)) > _SMALL_TICK_CHARACTERS:
            axes.tick_params(axis="x", rotation=45)
        axes.grid(axis="y", color="#E0E0E0", linewidth=0.6)
        axes.set_xlabel(wrapped(axle.label, _SMALL_AXIS_CHARACTERS, AXIS_LINES), fontsize=8)
        rows += [[axle.key, value, *e] for value, e in zip(axle.values, estimates, strict=True)]
    for axes in found.flat[len(effects) :]:
        axes.set_visible(False)
    for axes in found[:, 0]:
        axes.set_ylabel(wrapped(what, _SMALL_TICK_CHARACTERS, AXIS_LINES), fontsize=8)
    return saved(name, figure, rows)


def draw_dots(
    name: str, columns: Mapping[str, Sequence[Dot]], small: str, zero: Sequence[str] = ()
) -> Drawing:
    """Estimates under one another, one column for each quantity, rows shared by their order.

    Args:
        name: of the drawing.
        columns: the rows of each quantity, by its name with unit.
        small: small print.
        zero: quantities that are differences, whose zero is marked.
    """
    n_rows = max(len(dots) for dots in columns.values())
    first = next(iter(columns.values()))
    labels = [_row_label(dot) for dot in first]
    # Rows are as far apart as the longest label needs, so that none runs into the next.
    lines = max((label.count("\n") + 1 for label in labels), default=1)
    height = 1.6 + max(0.34, 0.17 * lines + 0.08) * n_rows
    figure = new_figure(4.2 + 3.2 * len(columns), height, small, least_width=7)
    found = figure.subplots(1, len(columns), sharey=True, squeeze=False)[0]
    rows: list[Sequence[Any]] = [["quantity", "row", "value", "low", "high", "n"]]
    for index, (axes, (what, dots)) in enumerate(zip(found, columns.items(), strict=True)):
        there = [(k, dot) for k, dot in enumerate(dots) if math.isfinite(dot.estimate.value)]
        if what in zero:
            axes.axvline(0, color=_INK, linewidth=0.8, dashes=(4, 3), zorder=1)
        _draw_runs(axes, dots)
        axes.errorbar(
            [dot.estimate.value for _, dot in there],
            [k for k, _ in there],
            xerr=_arms([dot.estimate for _, dot in there]),
            color=_OTHERS[index % 2 * 3],
            linestyle="none",
            marker="os"[index % 2],
            markersize=5.5,
            capsize=3,
            elinewidth=1.3,
        )
        axes.set_xlabel(axis_title(what))
        axes.grid(axis="y", color="#E0E0E0", linewidth=0.6)
        rows += [[what, dot.label, *dot.estimate] for dot in dots]
    found[0].set_yticks(range(len(labels)), labels)
    found[0].set_ylim(n_rows - 0.5, -0.5)
    return saved(name, figure, rows)


def _draw_runs(axes: "Axes", dots: Sequence[Dot]) -> None:
    """Each run small and pale, a little above or below the middle of its row."""
    heights = _RUNS_SPREAD * (np.arange(_RUN_HEIGHTS) / (_RUN_HEIGHTS - 1) - 0.5)
    places = [
        (value, k + heights[index % _RUN_HEIGHTS])
        for k, dot in enumerate(dots)
        for index, value in enumerate(dot.runs)
        if math.isfinite(value)
    ]
    if places:
        x, y = zip(*places, strict=True)
        axes.plot(
            x,
            y,
            linestyle="none",
            marker="o",
            markersize=2.6,
            markeredgewidth=0,
            color=GREY,
            alpha=0.5,
            zorder=1.5,
            # As shapes, thousands of them would make a page that no browser opens quickly.
            rasterized=len(places) > _MOST_SHAPES,
        )


def _row_label(dot: Dot) -> str:
    return f"{wrapped(dot.label, _ROW_CHARACTERS, _ROW_LINES)}  (n = {dot.estimate.n})"


def _arms(estimates: Sequence[Estimate]) -> np.ndarray:
    """Lengths of error bars, (2, estimate); zero where there is no interval."""
    arms = [(e.value - e.low, e.high - e.value) for e in estimates]
    # A bootstrap interval may, through rounding, end a hair on the wrong side of the mean.
    return np.maximum(np.nan_to_num(np.asarray(arms, np.float64).reshape(-1, 2).T), 0)


# --- Maps of value -------------------------------------------------------------------------------


class ValueMap(NamedTuple):
    """How far value had spread at a moment, averaged over runs, in the prey's own frame."""

    title: str
    value: FoldedValue
    n: int
    """Runs that it is over."""


def draw_values(
    name: str, maps: Sequence[ValueMap], edges: np.ndarray, vision: float, small: str
) -> Drawing:
    """Maps of value beside one another, the prey in the middle of each and facing right.

    The colour is the equivalent distance to capture; it covers the paper by the share of headings
    and runs that have a value. The maps are pixels in the SVG, as their sectors are many.

    Args:
        name: of the drawing.
        maps: what to draw, all with the same rings and directions.
        edges: (ring,): outer edge of each ring, in cells.
        vision: radius of the visual field, in cells.
        small: small print.
    """
    figure = new_figure(2.9 * len(maps) + 1.3, 3.75, small, least_width=5.5)
    grid = figure.add_gridspec(1, len(maps) + 1, width_ratios=[*[1] * len(maps), 0.13])
    for index, map_ in enumerate(maps):
        _draw_value(figure.add_subplot(grid[0, index]), map_, edges, vision)
    _draw_value_scale(figure.add_subplot(grid[0, -1]))
    return saved(name, figure, _value_rows(maps, edges))


def _draw_value(axes: "Axes", map_: ValueMap, edges: np.ndarray, vision: float) -> None:
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
    field = Wedge((0, 0), vision, -90, 90, fill=False, edgecolor=_INK, linewidth=1)
    axes.add_patch(field)
    axes.plot([0], [0], marker="o", markersize=4.5, color=_INK)
    axes.annotate(
        "",
        (0.62 * vision, 0),
        (0, 0),
        arrowprops={"arrowstyle": "-|>", "color": _INK, "linewidth": 1.3, "shrinkA": 0},
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
    gain = palette(gain_colours(), nearness(distance, _VALUE_SCALE))
    return over_board(gain, np.where(np.isfinite(distance), share, 0), LIGHT)


def _draw_value_scale(axes: "Axes") -> None:
    """The scale of colours: upwards the distance, from left to right the share of headings."""
    place, share = np.meshgrid(
        (np.arange(_LEGEND_PIXELS) + 0.5) / _LEGEND_PIXELS, np.linspace(0, 1, 24), indexing="ij"
    )
    low, high = _VALUE_SCALE.low, _VALUE_SCALE.high
    distance = low + (high - low) * place**2
    axes.imshow(value_colours(distance, share), origin="lower", extent=(0, 1, 0, 1), aspect="auto")
    axes.set_xticks([0, 1], ["0", "1"])
    axes.set_xlabel("share with\na value", fontsize=8)
    axes.yaxis.tick_right()
    axes.yaxis.set_label_position("right")
    shown = [str(tick) for tick in _VALUE_TICKS[:-1]] + [f"≥ {_VALUE_TICKS[-1]}"]
    axes.set_yticks([float(_VALUE_SCALE.place(tick)) for tick in _VALUE_TICKS], shown)
    axes.set_ylabel("equivalent distance to capture (steps)", fontsize=8)


def _value_rows(maps: Sequence[ValueMap], edges: np.ndarray) -> list[Sequence[Any]]:
    inner = [0.0, *edges[:-1].tolist()]
    rows: list[Sequence[Any]] = [
        ["moment", "from_cells", "to_cells", "degrees_from_ahead", "share", "steps", "n"]
    ]
    for title, (distance, share), n in maps:
        n_rings, n_directions = share.shape
        rows += [
            [
                title,
                inner[ring],
                float(edges[ring]),
                360 * direction / n_directions,
                float(share[ring, direction]),
                float(distance[ring, direction]),
                n,
            ]
            for ring in range(n_rings)
            for direction in range(n_directions)
        ]
    return rows


# --- Numbers in words ----------------------------------------------------------------------------


def shown_value(value: Any) -> str:
    """The value of a setting."""
    return f"{value:g}" if isinstance(value, float) else str(value)


def grouped(value: Any) -> str:
    """The value of a setting, a large whole number with a comma at the thousands."""
    is_large = isinstance(value, int) and abs(value) >= 1_000
    return f"{value:,}" if is_large else shown_value(value)


def told_apart(values: Sequence[Any], shown: Callable[[Any], str] = shown_value) -> list[str]:
    """The values of a setting, in all their digits where two would else look the same.

    Args:
        values: of one setting; the same value may be there more than once.
        shown: a value in short.
    """
    short = [shown(value) for value in values]
    exact = [repr(value) if isinstance(value, float) else shown(value) for value in values]
    return short if len(set(short)) == len(set(exact)) else exact


def shown_estimate(estimate: Estimate, form: str = ".3g") -> str:
    """A value with its interval; without, where a single run gives none."""
    if math.isnan(estimate.value):
        return "–"
    value = _number(estimate.value, form)
    if math.isnan(estimate.low):
        return value
    return f"{value} [{_number(estimate.low, form)}, {_number(estimate.high, form)}]"


def _number(value: float, form: str) -> str:
    if math.isinf(value):
        return "never"
    if abs(value) >= 1000:
        form = ",.0f"
    return format(value, form).replace("-", "\N{MINUS SIGN}")
