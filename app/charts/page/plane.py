"""The plane of two settings that were swept together, on the page."""

import math
from collections.abc import Sequence
from itertools import product
from typing import Final, Literal, NamedTuple

from app.analysis.axles import Axle, grouped
from app.charts.model import NOTHING, Plane
from app.charts.page import svg
from app.charts.page.colours import heat
from app.charts.page.svg import Frame, Scale
from app.charts.scales import ColourEnds, colour_ends
from app.charts.wording import described, few_in_words, short_label
from app.util.html import escaped
from app.words.numbers import counted, labelled_ticks, shared_form, shown_number

_FRAMES: Final = {
    "own": (
        'stroke="#fff" stroke-width="2"',
        'stroke="#000" stroke-width="2" stroke-dasharray="4 4"',
    ),
    # White within black shows on every colour of the map.
    "chosen": ('stroke="#000" stroke-width="5"', 'stroke="#fff" stroke-width="2"'),
}
"""Lines on top of one another, by what they tell of a cell."""


def plane_html(chart: Plane, frame: Frame) -> str:
    """A map of the plane, each cell with its value; a click chooses the variant of a cell."""
    across, up = chart.axles
    estimates = {at: chart.cells.get(at, NOTHING) for at in chart.choices}
    values = [estimate.value for estimate in estimates.values()]
    ends, form = colour_ends(values), shared_form(values)
    low, high = ends.low, ends.high
    names_up = [short_label(grouped(value), 16) for value in up.values]
    grid = _grid_for(len(across.values), names_up, svg.gutter(low, high), frame)
    cells: list[str] = []
    frames: list[str] = []
    for i, j in product(range(len(across.values)), range(len(up.values))):
        box, choice = grid.box(i, j), chart.choices.get((i, j))
        if choice is None:
            cells.append(_empty_cell(box))
            continue
        estimate = estimates[i, j]
        title = escaped(described(choice.label, estimate))
        cell = _cell(box, estimate.value, ends, form)
        words = f"variant/{choice.place}"
        cells.append(svg.link(frame.address, words, f"<title>{title}</title>{cell}"))
        if (i, j) == chart.framed:
            frames.append(_outline(box, "own"))
        if choice.place == frame.chosen:
            frames.append(_outline(box, "chosen"))
    content = (
        _axes(chart, names_up, grid, frame.width)
        + _colour_bar(grid, low, high)
        + f'<g class="cells" text-anchor="middle"{svg.SMALL}>{"".join(cells)}</g>{"".join(frames)}'
    )
    counts = [estimate.n for estimate in estimates.values()]
    return svg.picture(frame.width, grid.bottom + 38, "Plane of two settings", content) + svg.note(
        _cells_in_words(counts),
        "" if chart.framed is None else "Dashed frame: the preset's own setting.",
        ends.in_words("cell", " to ".join(shown_number(end, form) for end in (low, high))),
        few_in_words(counts),
        frame.note,
    )


class _Box(NamedTuple):
    """Where a cell is drawn."""

    x: float
    y: float
    width: float
    height: float

    @property
    def path(self) -> str:
        """Its outline, with a gap to the next one."""
        w, h = self.width - 1, self.height - 1
        return f"M{self.x:.1f} {self.y:.1f}h{w:.1f}v{h:.1f}h{-w:.1f}z"


class _Grid(NamedTuple):
    """Where the cells of a plane are drawn."""

    left: float
    right: float
    top: float
    bottom: float
    wide: float
    """Of a cell."""
    tall: float

    def box(self, i: int, j: int) -> _Box:
        """Where the cell is drawn that is the i-th from the left and the j-th from below."""
        x, y = self.left + self.wide * i, self.bottom - self.tall * (j + 1)
        return _Box(x, y, self.wide, self.tall)


def _grid_for(n_across: int, names_up: Sequence[str], bar_px: float, frame: Frame) -> _Grid:
    """The grid between the names on its left and the numbers of the colour bar on its right."""
    left, right = max(map(len, names_up)) * svg.CHARACTER_PX + 12, frame.width - (bar_px + 22) - 14
    top, tall = 36.0, min(max(frame.tall / len(names_up), 18), frame.tall / 6)
    bottom = top + tall * len(names_up)
    return _Grid(left, right, top, bottom, (right - left) / n_across, tall)


def _axes(chart: Plane, names_up: Sequence[str], grid: _Grid, width: float) -> str:
    """What the map is of, the names of both settings, and their values."""
    across, up = chart.axles
    most = int(width / svg.CHARACTER_PX)
    what = short_label(chart.what, most)
    up_label = short_label(up.label, int(grid.right / svg.CHARACTER_PX))
    across_label = short_label(across.label, most - 2)
    middle = (grid.left + grid.right) / 2
    values_up = (
        svg.text(grid.left - 7, grid.bottom - grid.tall * (j + 0.5), name, "end", svg.DIM)
        for j, name in enumerate(names_up)
    )
    return (
        svg.text(width - 2, 12, what, "end", svg.DIM)
        + svg.text(2, 28, f"↑ {up_label}", "start", svg.DIM)
        + svg.text(middle, grid.bottom + 32, f"{across_label} →", "middle", svg.DIM)
        + _names_across(across, grid.left, grid.wide, grid.bottom + 16)
        + f'<g class="y-ticks" dominant-baseline="central">{"".join(values_up)}</g>'
    )


def _outline(box: _Box, kind: Literal["own", "chosen"]) -> str:
    lines = "".join(f'<path d="{box.path}" {look}/>' for look in _FRAMES[kind])
    return f'<g class="{kind}" fill="none" pointer-events="none">{lines}</g>'


def _cells_in_words(counts: Sequence[int]) -> str:
    """What a cell is, of those that have runs."""
    there = [n for n in counts if n > 0]
    fewest, most = min(there, default=0), max(there, default=0)
    if most <= 1:
        return "Each cell is one run; a click chooses it."
    each = counted(most, "run") if fewest == most else f"{fewest:,} to {counted(most, 'run')}"
    return f"Each cell is the mean of {each}, its interval under the pointer; a click chooses it."


def _cell(box: _Box, value: float, ends: ColourEnds, form: str) -> str:
    if math.isnan(value):
        return _empty_cell(box)
    colours, inks = heat()
    index = round(ends.share(value) * (len(colours) - 1))
    text = shown_number(value, form)
    name = ""
    if len(text) * svg.SMALL_CHARACTER_PX + 3 <= box.width:
        at = box.x + (box.width - 1) / 2, box.y + (box.height - 1) / 2 + 4
        name = f'<text x="{at[0]:.1f}" y="{at[1]:.1f}" fill="{inks[index]}">{text}</text>'
    return f'<path d="{box.path}" fill="{colours[index]}"/>{name}'


def _empty_cell(box: _Box) -> str:
    w, h = box.width - 1, box.height - 1
    # Lines from the lower left to the upper right, as far apart as a third of the height.
    hatching = "".join(
        f"M{box.x + k * w / 4:.1f} {box.y + h:.1f}l{w / 4:.1f} {-h:.1f}" for k in range(4)
    )
    return (
        f'<path class="empty" d="{box.path}" fill="transparent" stroke="currentColor"'
        f' stroke-opacity="0.25"/><path d="{hatching}" stroke="currentColor" stroke-opacity="0.2"/>'
    )


def _names_across(axle: Axle, left: float, wide: float, y: float) -> str:
    """Values of cells in a row; only as many as have room."""
    names = [grouped(value) for value in axle.values]
    room = max(int(3 * wide / svg.CHARACTER_PX), 4)
    names = [short_label(name, max(room, 8)) for name in names]
    every = math.ceil(max(len(name) * svg.CHARACTER_PX + 6 for name in names) / wide)
    texts = (
        svg.text(left + wide * (i + 0.5), y, name, "middle", svg.DIM)
        for i, name in enumerate(names)
        if i % every == 0
    )
    return f'<g class="x-ticks">{"".join(texts)}</g>'


def _colour_bar(grid: _Grid, low: float, high: float) -> str:
    x, top, bottom = grid.right + 22, grid.top, grid.bottom
    colours, _ = heat()
    shown = colours[::3]
    tall = (bottom - top) / len(shown)
    # A hair more than its share for each, so that no page shines through between two of them.
    stripes = "".join(
        f'<path d="M{x:.1f} {bottom - tall * (k + 1):.1f}h14v{tall + 0.4:.1f}h-14z"'
        f' fill="{colour}"/>'
        for k, colour in enumerate(shown)
    )
    scale = Scale(low, high, bottom, top)
    names = "".join(
        svg.text(x + 19, scale.at(value) + 4, name, "start", svg.DIM)
        for value, name in labelled_ticks(low, high, 5)
    )
    return f'<g class="colour-bar">{stripes}{names}</g>'
