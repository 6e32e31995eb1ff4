"""Charts of settings that were swept, as HTML whose parts are links: a plane of two, a line of one.

Pure functions; what a link calls, and what a place is, is as in :mod:`app.charts.curves`.
"""

import math
from collections.abc import Sequence
from itertools import product
from typing import Final, Literal, NamedTuple

from app.analysis.estimates import Estimate
from app.analysis.sweeps import Sweep
from app.charts.paper import Axle, grouped
from app.charts.parts import (
    CHARACTER_PX,
    DIM,
    LINK,
    SMALL,
    SMALL_CHARACTER_PX,
    Context,
    Scale,
    described,
    few_in_words,
    gutter,
    heat,
    labelled,
    link,
    missing,
    note,
    padded,
    picture,
    quantity,
    runs_in_words,
    shortened,
    shown_number,
    svg_text,
    upwards,
    x_axis,
    y_axis,
)
from app.util.html import escaped

_FRAMES: Final = {
    "own": (
        'stroke="#fff" stroke-width="2"',
        'stroke="#000" stroke-width="2" stroke-dasharray="4 4"',
    ),
    # White within black shows on every colour of the map.
    "chosen": ('stroke="#000" stroke-width="5"', 'stroke="#fff" stroke-width="2"'),
}
"""Lines on top of one another, by what they tell of a cell."""


# --- Two settings --------------------------------------------------------------------------------


def plane(
    context: Context, sweep: Sweep, estimates: Sequence[Estimate], own: int | None = None
) -> str:
    """Two settings swept together: a map of the plane, each cell with its value.

    Cells have equal sizes whatever their values; those without runs stay hatched.

    Args:
        context: what every chart is asked for.
        sweep: with two axles; its places are those of the experiment.
        estimates: means by the place of their variant.
        own: place of the variant that has the preset's own values, if there is one.
    """
    across, up = sweep.axles
    low, high = _ends_of([estimates[place].value for place in sweep.places.values()])
    names_up = [shortened(grouped(value), 16) for value in up.values]
    grid = _grid_for(len(across.values), names_up, gutter(low, high), context)
    cells, frames = [], []
    for i, j in product(range(len(across.values)), range(len(up.values))):
        box, place = grid.box(i, j), sweep.places.get((i, j))
        if place is None:
            cells.append(_empty_cell(box))
            continue
        title = escaped(described(context.variants[place], estimates[place]))
        cell = _cell(box, estimates[place].value, low, high)
        cells.append(link(context.address, f"variant/{place}", f"<title>{title}</title>{cell}"))
        if place == own:
            frames.append(_frame(box, "own"))
        if place == context.chosen:
            frames.append(_frame(box, "chosen"))
    content = (
        _plane_axes(context, across, up, names_up, grid)
        + _colour_bar(grid, low, high)
        + f'<g class="cells" text-anchor="middle"{SMALL}>{"".join(cells)}</g>{"".join(frames)}'
    )
    return picture(context.width, grid.bottom + 38, "Plane of two settings", content) + note(
        _cells_in_words([estimate.n for estimate in estimates]),
        "" if own is None else "Dashed frame: the preset's own setting.",
        few_in_words(estimate.n for estimate in estimates),
        missing(context.gathering),
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


def _grid_for(n_across: int, names_up: Sequence[str], bar_px: float, context: Context) -> _Grid:
    """The grid between the names on its left and the numbers of the colour bar on its right."""
    left, right = max(map(len, names_up)) * CHARACTER_PX + 12, context.width - (bar_px + 22) - 14
    top, tall = 36.0, min(max(context.tall / len(names_up), 18), context.tall / 6)
    bottom = top + tall * len(names_up)
    return _Grid(left, right, top, bottom, (right - left) / n_across, tall)


def _plane_axes(
    context: Context, across: Axle, up: Axle, names_up: Sequence[str], grid: _Grid
) -> str:
    """What the map is of, the names of both settings, and their values."""
    most = int(context.width / CHARACTER_PX)
    what = shortened(context.gathering.metric.label, most)
    up_label = shortened(up.label, int(grid.right / CHARACTER_PX))
    across_label = shortened(across.label, most - 2)
    middle = (grid.left + grid.right) / 2
    values_up = (
        svg_text(grid.left - 7, grid.bottom - grid.tall * (j + 0.5), name, "end", DIM)
        for j, name in enumerate(names_up)
    )
    return (
        svg_text(context.width - 2, 12, what, "end", DIM)
        + svg_text(2, 28, f"↑ {up_label}", "start", DIM)
        + svg_text(middle, grid.bottom + 32, f"{across_label} →", "middle", DIM)
        + _names_across(across, grid.left, grid.wide, grid.bottom + 16)
        + f'<g class="y-ticks" dominant-baseline="central">{"".join(values_up)}</g>'
    )


def _frame(box: _Box, kind: Literal["own", "chosen"]) -> str:
    lines = "".join(f'<path d="{box.path}" {look}/>' for look in _FRAMES[kind])
    return f'<g class="{kind}" fill="none" pointer-events="none">{lines}</g>'


def _cells_in_words(counts: Sequence[int]) -> str:
    """What a cell is, of those that have runs."""
    there = [n for n in counts if n > 0]
    fewest, most = min(there, default=0), max(there, default=0)
    if most <= 1:
        return "Each cell is one run; a click chooses it."
    each = runs_in_words(most) if fewest == most else f"{fewest:,} to {runs_in_words(most)}"
    return f"Each cell is the mean of {each}, its interval under the pointer; a click chooses it."


def _ends_of(values: Sequence[float]) -> tuple[float, float]:
    found = [value for value in values if math.isfinite(value)]
    low, high = min(found, default=0.0), max(found, default=1.0)
    return (low, high) if low < high else padded([low])


def _cell(box: _Box, value: float, low: float, high: float) -> str:
    if math.isnan(value):
        return _empty_cell(box)
    colours, inks = heat()
    index = round((value - low) / (high - low) * (len(colours) - 1))
    text = shown_number(value)
    name = ""
    if len(text) * SMALL_CHARACTER_PX + 3 <= box.width:
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
    room = max(int(3 * wide / CHARACTER_PX), 4)
    names = [shortened(name, max(room, 8)) for name in names]
    every = math.ceil(max(len(name) * CHARACTER_PX + 6 for name in names) / wide)
    texts = (
        svg_text(left + wide * (i + 0.5), y, name, "middle", DIM)
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
        svg_text(x + 19, scale.at(value) + 4, name, "start", DIM)
        for value, name in labelled(low, high, 5)
    )
    return f'<g class="colour-bar">{stripes}{names}</g>'


# --- One setting ---------------------------------------------------------------------------------


def line(context: Context, sweep: Sweep, estimates: Sequence[Estimate]) -> str:
    """One setting swept: means with intervals against its value.

    Args:
        context: what every chart is asked for.
        sweep: with one axle; its places are those of the experiment.
        estimates: means by the place of their variant.
    """
    (axle,) = sweep.axles
    there = {index: estimates[place] for (index,), place in sweep.places.items()}
    low, high = padded([number for estimate in there.values() for number in estimate[:3]])
    left, y = gutter(low, high), upwards(low, high, context.tall)
    x, values = _values_across(axle, left + 20, context.width - 34)

    drawn = [i for i in sorted(there) if math.isfinite(there[i].value)]
    path = "L".join(f"{x.at(values[i]):.1f} {y.at(there[i].value):.1f}" for i in drawn)
    parts = [
        quantity(context),
        y_axis(y, left, context.width - 10),
        x_axis(x, _names_of(axle, x, values), y.end, y.start, axle.label),
        f'<path d="M{path}" fill="none" stroke="{LINK}" stroke-opacity="0.5"/>' if path else "",
    ]
    radius = 4.5 if len(there) <= 40 else 3
    for (index,), place in sweep.places.items():
        parts.append(_point(context, place, there[index], x.at(values[index]), y, radius))
    n = [estimate.n for estimate in there.values() if estimate.n]
    return picture(context.width, y.start + 36, "One setting swept", "".join(parts)) + note(
        few_in_words(estimate.n for estimate in estimates),
        _points_in_words(n),
        missing(context.gathering),
    )


def _points_in_words(counts: Sequence[int]) -> str:
    """What a point is, of those that have runs."""
    fewest, most = min(counts, default=0), max(counts, default=0)
    if most <= 1:
        return "Each point is one run; a click chooses a variant."
    each = f"{fewest:,}" if fewest == most else f"{fewest:,} to {most:,}"
    return f"Means with their 95 % intervals, n = {each}; a click chooses a variant."


def _point(
    context: Context, place: int, estimate: Estimate, at: float, y: Scale, radius: float
) -> str:
    """A mean that chooses its variant, with its interval; empty where there is no mean."""
    interval, look, ring = "", f'fill="{LINK}"', ""
    is_there = math.isfinite(estimate.value)
    if math.isfinite(estimate.low):
        interval = (
            f'<path class="interval" d="M{at:.1f} {y.at(estimate.low):.1f}'
            f'V{y.at(estimate.high):.1f}" stroke="{LINK}" stroke-width="2"/>'
        )
    if not is_there:
        look, ring = 'fill="transparent"', ' stroke="currentColor" stroke-opacity="0.4"'
    if place == context.chosen:
        radius += 2
        ring = ' stroke="currentColor" stroke-width="2.5"'
    height = y.at(estimate.value) if is_there else y.start
    title = escaped(described(context.variants[place], estimate))
    dot = f'<circle class="mark" cx="{at:.1f}" cy="{height:.1f}" r="{radius:g}" {look}{ring}/>'
    return interval + link(context.address, f"variant/{place}", f"<title>{title}</title>{dot}")


def _values_across(axle: Axle, start: float, end: float) -> tuple[Scale, Sequence[float]]:
    """The scale of a setting, and where each of its values lies on it."""
    if not axle.is_numeric or (axle.is_crowded and not axle.is_logarithmic):
        n = len(axle.values)
        return Scale(0, n - 1, start, end), [float(i) for i in range(n)]
    values = [float(value) for value in axle.values]
    return Scale(min(values), max(values), start, end, axle.is_logarithmic), values


def _names_of(axle: Axle, x: Scale, values: Sequence[float]) -> list[tuple[float, str]]:
    """Ticks at values of a setting that have room for their names; at round ones on a scale."""
    if axle.is_numeric and not axle.is_logarithmic and not axle.is_crowded:
        return labelled(x.low, x.high, 8)
    named: list[tuple[float, str]] = []
    free = -math.inf
    for at, value in zip(values, axle.values, strict=True):
        name = shortened(grouped(value), 14)
        half = len(name) * CHARACTER_PX / 2 + 3
        if x.at(at) - half >= free:
            named.append((at, name))
            free = x.at(at) + half
    return named
