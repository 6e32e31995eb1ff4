"""Two settings that were swept together, on paper."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from app.analysis.axles import grouped, told_apart
from app.analysis.sweeps import Place
from app.charts.model import Plane
from app.charts.paper.sheet import AXIS_LINES, INK, axis_title, new_figure, plain, wrapped
from app.charts.scales import colour_ends
from app.charts.wording import shown_estimate
from app.words.numbers import shown_number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_LABELLED_CELLS = 400
_DIFFERENCES = ("#0D2A5B", "#4A70A8", "#B4B4B4", "#F2D18E", "#FFF6DC")
"""From below zero to above it: blue to orange, and from dark to light."""


def plane_figure(chart: Plane, small_print: str) -> "Figure":
    """A map of the plane; in a page, the interval of a cell shows under the pointer.

    The colours of differences have their middle at none, and grow lighter all the way, so that a
    copy in black and white keeps the sign. A number is bold where its interval excludes 0.
    """
    from matplotlib.cm import ScalarMappable

    across, up = chart.axles
    n_across, n_up = len(across.values), len(up.values)
    figure = new_figure(
        min(3.2 + 0.62 * n_across, 12), min(2.6 + 0.45 * n_up, 10), small_print, least_width=5.5
    )
    axes = figure.subplots()
    norm, colours = (scale_around_zero if chart.is_difference else _scale_of)(
        [cell.value for cell in chart.cells.values()]
    )
    _draw_cells(axes, (n_across, n_up), _faces_of(chart, norm, colours))
    axes.set_xlim(-0.5, n_across - 0.5)
    axes.set_ylim(-0.5, n_up - 0.5)
    shown_across, shown_up = (told_apart(axle.values, grouped) for axle in chart.axles)
    crowded = max(map(len, shown_across), default=0) > 6
    axes.set_xticks(range(n_across), list(map(plain, shown_across)))
    axes.tick_params(axis="x", rotation=45 if crowded else 0)
    axes.set_yticks(range(n_up), list(map(plain, shown_up)))
    axes.set_xlabel(wrapped(across.label, most_lines=AXIS_LINES))
    axes.set_ylabel(axis_title(up.label))
    axes.set_facecolor("#EEEEEE")
    bar = figure.colorbar(ScalarMappable(norm, colours), ax=axes, label=axis_title(chart.what))
    if chart.is_difference:
        bar.ax.axhline(0, color=INK, linewidth=1.5)
    return figure


def hints_of(chart: Plane) -> Mapping[str, str]:
    """What is shown under the pointer, by the names of parts of the figure."""
    across, up = chart.axles
    shown_across, shown_up = (told_apart(axle.values, grouped) for axle in chart.axles)
    return {
        f"cell-{i}-{j}": f"{across.label} = {shown_across[i]}, "
        f"{up.label} = {shown_up[j]}: {shown_estimate(cell)}, n = {cell.n}"
        for (i, j), cell in chart.cells.items()
    }


class _Face(NamedTuple):
    """How a cell of a plane looks."""

    colour: tuple[float, float, float, float]
    text: str
    is_bold: bool = False
    is_framed: bool = False


def _faces_of(chart: Plane, norm: Any, colours: Any) -> Mapping[Place, _Face]:
    """The looks of all cells that have a number."""
    faces = {}
    for place, cell in chart.cells.items():
        if not math.isfinite(cell.value):
            continue
        if chart.is_difference:
            text, is_bold = _signed(cell.value, norm.vmax), cell.excludes_zero
        else:
            text, is_bold = shown_number(cell.value), False
        colour = colours(norm(cell.value))
        faces[place] = _Face(colour, text, is_bold, place == chart.framed)
    if chart.is_difference and chart.framed is not None:
        faces[chart.framed] = _Face(colours(norm(0.0)), "0", is_framed=True)
    return faces


def _scale_of(values: Sequence[float]) -> tuple[Any, Any]:
    from matplotlib import colormaps
    from matplotlib.colors import Normalize

    ends = colour_ends(values)
    return Normalize(ends.low, ends.high, clip=True), colormaps["cividis"]


def scale_around_zero(values: Sequence[float]) -> tuple[Any, Any]:
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    colours = LinearSegmentedColormap.from_list("differences", _DIFFERENCES)
    farthest = max((abs(value) for value in values if math.isfinite(value)), default=0) or 1.0
    return Normalize(-farthest, farthest), colours


def _signed(value: float, largest: float) -> str:
    """A difference with its sign, as precise as the largest one is with three digits."""
    digits = max(2 - math.floor(math.log10(largest)), 0)
    text = f"{value:+.{digits}f}"
    return text.replace("-", "\N{MINUS SIGN}") if float(text) else text[1:]


def _draw_cells(axes: "Axes", shape: tuple[int, int], faces: Mapping[Place, _Face]) -> None:
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
                ink, weight = _ink_on(face.colour), "bold" if face.is_bold else "normal"
                axes.text(
                    i, j, face.text, ha="center", va="center", fontsize=7, color=ink, weight=weight
                )
            if face is not None and face.is_framed:
                axes.add_patch(
                    Rectangle((i - 0.46, j - 0.46), 0.92, 0.92, fill=False, edgecolor=INK, lw=1.6)
                )


def _ink_on(colour: tuple[float, float, float, float]) -> str:
    """White on dark colours and black on light ones."""
    red, green, blue, _ = colour
    return "white" if 0.299 * red + 0.587 * green + 0.114 * blue < 0.5 else "black"
