"""Charts of the results of an experiment, as HTML whose parts are links: curves, and single runs.

Pure functions. Texts and axes take the colour of the page, and lines have colours that stand out
from white and from nearly black, so that one chart is right in both themes. Every link calls the
lab with words: ``variant/PLACE`` chooses a variant, ``open/KEY`` opens a run. Places are pixels of
a picture that is as wide as it is asked to be, and that shrinks with the page.
"""

import math
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

import numpy as np

from app.analysis.estimates import Axis, Estimate
from app.charts.paper import AXIS_UNITS, Style
from app.charts.parts import (
    CHARACTER_PX,
    DIM,
    LINK,
    SMALL,
    SMALL_CHARACTER_PX,
    TITLE_CHARACTERS,
    Address,
    Context,
    Scale,
    colour_of,
    described,
    few_in_words,
    gutter,
    labelled,
    link,
    missing,
    note,
    padded,
    picture,
    quantity,
    runs_in_words,
    shortened,
    shown_mean,
    shown_number,
    styles_of,
    svg_text,
    upwards,
    x_axis,
    y_axis,
)
from app.documents.variants import Variant
from app.results.gather import MOST_CURVES, Curve, Gathering, RunFact
from app.util.html import escaped
from app.words.plain import plain

MOST_ROWS: Final = 24
"""Variants that have a row of their own; more become columns without labels."""
MOST_COLUMNS: Final = 200
"""Variants that have a column of their own; of more, neighbours share one."""
MOST_DOTS: Final = 1_500
"""Runs that are drawn one by one."""
MOST_LINKED_DOTS: Final = 240
"""Dots that are links, which take a hundred times the room of one that is not."""

_BOLD_PX = 7.2
"""Width of a bold character, on the safe side."""
_LARGEST_GUTTER = 0.36
"""Share of the width that labels of rows may take."""
_SAMPLE_PX = 28
"""Length of a line in the legend."""
_LEAST_WIDTH = 1.5
"""Lines thinner than this are lost on a projector."""
_FAINT = 0.55
_GREY = 0.4
"""Opacity of lines that another one is told from."""


# --- Learning curves -----------------------------------------------------------------------------


def curves(context: Context, found: Sequence[Curve], axis: Axis) -> str:
    """Learning curves with their intervals, and the moments at which skills joined.

    Where a variant is chosen, the others turn grey.

    Args:
        context: what every chart is asked for.
        found: curves of at most ``MOST_CURVES`` variants.
        axis: what they are drawn against.
    """
    styles = styles_of([context.variants[curve.variant] for curve in found])
    drawn = [curve for curve in found if curve.band.mean.size]
    marks = _common_marks([curve for curve in found if context.is_told(curve.variant)], axis)
    plot = _plot_of(context, drawn, marks, axis)
    parts = [_curve_axes(plot, axis), _marks_drawn(marks, plot)]
    for curve, style in sorted(
        zip(found, styles, strict=True), key=lambda pair: pair[0].variant == context.chosen
    ):
        parts.append(_curve(curve, _look_of(style, context.is_told(curve.variant)), plot))
    if not drawn:
        middle = (plot.x.start + plot.x.end) / 2, (plot.y.start + plot.y.end) / 2
        parts.append(svg_text(*middle, "No curve yet", "middle"))
    left_out = len(context.variants) - len(found)
    return (
        _legend(context, found, styles)
        + picture(context.width, plot.y.start + 36, "Learning curves", "".join(parts))
        + note(
            _lines_in_words(max((curve.n for curve in found), default=0)),
            _marks_in_words(context.variants, found) if marks else "",
            few_in_words(curve.n for curve in found),
            f"{left_out:,} other variants are not drawn; choose any of them in another chart."
            if left_out
            else "",
        )
    )


def _lines_in_words(most_runs: int) -> str:
    if most_runs <= 1:
        return "Each line is one run."
    return (
        "Lines are means over runs, shaded their 95 % intervals; faint where some runs have ended."
    )


class _Plot(NamedTuple):
    """Where curves are drawn."""

    x: Scale
    y: Scale
    factor: float
    """From steps or trials to numbers of the x axis."""
    levels: Sequence[int]
    """How high the name of each mark is written."""


def _plot_of(
    context: Context, drawn: Sequence[Curve], marks: Sequence[tuple[float, str]], axis: Axis
) -> _Plot:
    gathering, width = context.gathering, context.width
    factor, _ = AXIS_UNITS[axis]
    end = max((float(curve.band.end[-1]) for curve in drawn), default=0.0) * factor or 1.0
    levels = _levels([at * factor / end * width for at, _ in marks])
    means = [value for curve in drawn for value in _finite(curve.band.mean)]
    low, high = min([gathering.low, *means]), max([gathering.high, *means])
    if low == high:
        low, high = padded([low])
    y = upwards(low, high, context.tall, top=10.0 + 13 * (max(levels, default=-1) + 1))
    return _Plot(Scale(0.0, end, gutter(low, high) + 16, width - 14), y, factor, levels)


def _curve_axes(plot: _Plot, axis: Axis) -> str:
    x, y = plot.x, plot.y
    zero = (
        f'<path d="M{x.start:.1f} {y.at(0):.1f}H{x.end:.1f}" stroke="currentColor"'
        ' stroke-opacity="0.4"/>'
    )
    return (
        y_axis(y, x.start, x.end)
        + x_axis(x, labelled(0, x.high, 8), y.end, y.start, AXIS_UNITS[axis][1])
        + f'<text transform="translate(11 {(y.end + y.start) / 2:.1f}) rotate(-90)"'
        f' text-anchor="middle"{DIM}>mean reward per trial</text>'
        + (zero if y.low < 0 < y.high else "")
    )


def _marks_in_words(variants: Sequence[Variant], found: Sequence[Curve]) -> str:
    """What the marks are, and whose if they are not everybody's."""
    whose = [variants[curve.variant].label for curve in found if curve.joined]
    if len(whose) in (1, 2) and len(whose) < len(found):
        names = " and ".join(shortened(label, 40) for label in whose)
        return f"Dashed: a skill joins in {names}."
    return "Dashed: a skill joins."


def _finite(numbers: np.ndarray) -> list[float]:
    return numbers[np.isfinite(numbers)].tolist()


def _common_marks(found: Sequence[Curve], axis: Axis) -> list[tuple[float, str]]:
    """When skills joined; nothing where curves differ in it, as nobody could see which is whose."""
    each = {
        tuple(sorted((m.step if axis == "steps" else m.trial, plain(m.skill)) for m in c.joined))
        for c in found
        if c.joined
    }
    return list(each.pop()) if len(each) == 1 else []


_NAME_ROOM_PX = 110


def _levels(places: Sequence[float]) -> list[int]:
    """How high each of several names in a row is written, so that none lies on the next one."""
    levels: list[int] = []
    following, level = math.inf, 0
    for place in reversed(places):
        level = level + 1 if following - place < _NAME_ROOM_PX else 0
        following = place
        levels.insert(0, level)
    return levels


def _marks_drawn(marks: Sequence[tuple[float, str]], plot: _Plot) -> str:
    x, top, bottom = plot.x, plot.y.end, plot.y.start
    parts = []
    for (moment, name), level in zip(marks, plot.levels, strict=True):
        at = x.at(moment * plot.factor)
        if at > x.end + 0.5:
            continue
        is_late = x.end - at < _NAME_ROOM_PX
        high = top - 13 * level
        parts.append(
            f'<path d="M{at:.1f} {high - 9:.1f}V{bottom:.1f}" stroke="currentColor"'
            ' stroke-opacity="0.55" stroke-dasharray="5 3"/>'
            + svg_text(
                at - 4 if is_late else at + 4,
                high - 2,
                shortened(name, int(_NAME_ROOM_PX / SMALL_CHARACTER_PX)),
                "end" if is_late else "start",
                SMALL + DIM,
            )
        )
    return f'<g class="joined">{"".join(parts)}</g>'


class _Look(NamedTuple):
    """How a line is drawn."""

    colour: str
    width: float
    opacity: float
    dashes: Sequence[float] = ()
    """Lengths of dashes and gaps in line widths."""
    has_band: bool = True

    def dashed(self, width: float) -> str:
        """Its dashes as an attribute, if the line is so wide; nothing for a solid one."""
        dashes = " ".join(f"{length * width:.1f}" for length in self.dashes)
        return f' stroke-dasharray="{dashes}"' if dashes else ""


def _look_of(style: Style, is_told: bool) -> _Look:
    """The look of a line, which is grey and alone where another one is told from it."""
    if not is_told:
        return _Look("currentColor", 1.0, _GREY, has_band=False)
    return _Look(colour_of(style), max(style.width, _LEAST_WIDTH), 1.0, style.dashes)


def _curve(curve: Curve, look: _Look, plot: _Plot) -> str:
    """A mean with its interval."""
    band, x, y = curve.band, plot.x, plot.y
    if not band.mean.size:
        return ""
    across = x.start + band.middle * plot.factor / x.high * (x.end - x.start)
    up = [y.start + (v - y.low) / (y.high - y.low) * (y.end - y.start) for v in band[2:5]]
    fewer = np.flatnonzero(band.n < curve.n)
    all_there = int(fewer[0]) if fewer.size else band.n.size
    first, rest = slice(0, all_there), slice(max(all_there - 1, 0), None)
    parts = []
    if look.has_band:
        parts.append(
            f'<path class="band" d="{_ribbon(across, up[1], up[2])}" fill="{look.colour}"'
            ' fill-opacity="0.2"/>'
        )
    # The runs that go on longest may not be typical: what they alone say is drawn faintly.
    thin = max(0.6 * look.width, 1.2)
    for piece, share, thick in ((first, 1.0, look.width), (rest, _FAINT, thin)):
        path = _line_path(across[piece], up[0][piece])
        if path and (share == 1.0 or all_there < band.n.size):
            parts.append(
                f'<path d="{path}" fill="none" stroke="{look.colour}" stroke-width="{thick:.2g}"'
                f' stroke-opacity="{share * look.opacity:.2g}" stroke-linejoin="round"'
                f"{look.dashed(thick)}/>"
            )
    return f'<g class="curve" data-variant="{curve.variant}">{"".join(parts)}</g>'


def _stretches(there: np.ndarray) -> list[slice]:
    """Where something is there without a gap."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], there.astype(np.int8), [0]))))
    return [slice(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _points(x: np.ndarray, y: np.ndarray) -> str:
    return "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))


def _line_path(x: np.ndarray, y: np.ndarray) -> str:
    """A line with its gaps; a point between two gaps becomes a dash."""
    parts = []
    for part in _stretches(np.isfinite(y)):
        alone = part.stop - part.start == 1
        start = f"M{x[part.start] - 1:.1f} {y[part.start]:.1f}h2"
        parts.append(start if alone else f"M{_points(x[part], y[part])}")
    return "".join(parts)


def _ribbon(x: np.ndarray, low: np.ndarray, high: np.ndarray) -> str:
    parts = []
    for part in _stretches(np.isfinite(low) & np.isfinite(high)):
        back = slice(part.start, part.stop)
        upper, lower = _points(x[part], high[part]), _points(x[back][::-1], low[back][::-1])
        parts.append(f"M{upper}L{lower}Z")
    return "".join(parts)


_COUNT = " (99 runs)"
"""As long as what is said of the runs of a curve."""


def _legend(context: Context, found: Sequence[Curve], styles: Sequence[Style]) -> str:
    """Names of curves: in one line if they fit, else in at least two columns."""
    width = context.width
    characters = int((width / 2 - _SAMPLE_PX - 20) / CHARACTER_PX) - len(_COUNT)
    entries = [
        _legend_entry(context, curve, _look_of(style, context.is_told(curve.variant)), characters)
        for curve, style in zip(found, styles, strict=True)
    ]
    names = [shortened(context.variants[curve.variant].label, characters) for curve in found]
    widths = [_SAMPLE_PX + 18 + len(name + _COUNT) * CHARACTER_PX for name in names]
    columns = f' style="grid-template-columns:repeat(auto-fill,minmax({max(widths):.0f}px,1fr))"'
    # Characters are narrower than allowed for, and if some are not, a second line does no harm.
    look = 'class="legend"' if 0.93 * sum(widths) <= width else f'class="legend grid"{columns}'
    return f"<div {look}>{''.join(entries)}</div>"


def _legend_entry(context: Context, curve: Curve, look: _Look, characters: int) -> str:
    label = context.variants[curve.variant].label
    sample = (
        f'<svg width="{_SAMPLE_PX}" height="10" aria-hidden="true"><path d="M0 5H{_SAMPLE_PX}"'
        f' stroke="{look.colour}" stroke-width="{look.width}" stroke-opacity="{look.opacity:g}"'
        f"{look.dashed(look.width)}/></svg>"
    )
    name = escaped(shortened(label, characters))
    text = f'<span><span class="name">{name}</span> ({runs_in_words(curve.n)})</span>'
    title = f' title="{escaped(label)}: choose"'
    return link(context.address, f"variant/{curve.variant}", sample + text, title)


# --- Every run a dot -----------------------------------------------------------------------------


def runs(context: Context, estimates: Sequence[Estimate]) -> str:
    """Every run a dot at its value, with mean and interval of each variant.

    A row for each variant; a column for each where there are more than ``MOST_ROWS``.

    Args:
        context: what every chart is asked for.
        estimates: means by the place of their variant.
    """
    dots = _with_value(context.gathering)
    draw = _rows if len(context.variants) <= MOST_ROWS else _columns
    drawn, words = draw(context, estimates, dots)
    return drawn + note(
        few_in_words(estimate.n for estimate in estimates), words, missing(context.gathering)
    )


def _with_value(gathering: Gathering) -> list[RunFact]:
    return [run for run in gathering.runs if not run.error and math.isfinite(run.value)]


def _value_range(dots: Sequence[RunFact], estimates: Sequence[Estimate]) -> tuple[float, float]:
    values = [run.value for run in dots]
    return padded([*values, *(number for e in estimates for number in e[:3])])


def _jitter(seed: int) -> float:
    """A number from -0.5 to 0.5, the same for a seed every time; far apart for seeds in a row."""
    return (9 * (seed % 3) + 3 * (seed // 3 % 3) + seed // 9 % 3) / 26 - 0.5


class _Rows(NamedTuple):
    """What rows share."""

    x: Scale
    height: float
    colours: Sequence[str]
    linked: Sequence[RunFact]
    """Runs whose dots are links, and those whose dots are not."""
    plainly: Sequence[RunFact]


def _rows(
    context: Context, estimates: Sequence[Estimate], dots: Sequence[RunFact]
) -> tuple[str, str]:
    """A row for each variant, and what its dots are in words."""
    variants, width = context.variants, context.width
    widest = max(len(variant.label) for variant in variants)
    left = min(widest * _BOLD_PX + 14, _LARGEST_GUTTER * width)
    count_px = max(len(_count(estimate)) for estimate in estimates) * CHARACTER_PX + 4
    mean_px = max(len(shown_mean(estimate)) for estimate in estimates) * CHARACTER_PX
    x = Scale(*_value_range(dots, estimates), left, width - mean_px - count_px - 16)
    least, most = (26, 44) if len(variants) <= MOST_CURVES else (18, 30)
    height = min(max(context.tall / len(variants) / 2, least), most)
    linked, plainly = _dots_by_use(dots, context.chosen)
    rows = _Rows(x, height, _row_colours(variants), linked, plainly)
    bottom = 8.0 + height * len(variants)
    marks = labelled(x.low, x.high, max(int((x.end - x.start) / 70), 2))
    parts = [x_axis(x, marks, 4.0, bottom, context.gathering.metric.label)]
    parts += [_row(context, rows, place, estimate) for place, estimate in enumerate(estimates)]
    drawn = picture(width, bottom + 36, "Every run", "".join(parts))
    return drawn, _dots_in_words(linked, plainly, dots, max(e.n for e in estimates))


def _count(estimate: Estimate) -> str:
    return f"n = {estimate.n:,}"


def _row(context: Context, rows: _Rows, place: int, estimate: Estimate) -> str:
    """A variant: its label, its dots, its mean as a tick and as a number."""
    variant, x, colour = context.variants[place], rows.x, rows.colours[place]
    middle = 6.0 + rows.height * (place + 0.5)

    def height_of(run: RunFact) -> float:
        return middle + _jitter(run.seed) * rows.height * 0.6

    name = svg_text(
        x.start - 10,
        middle + 4,
        shortened(variant.label, int((x.start - 14) / _BOLD_PX)),
        "end",
        f' fill="{LINK}"' + (' font-weight="700"' if place == context.chosen else ""),
        title=variant.label,
    )
    plain_dots = [(x.at(r.value), height_of(r)) for r in rows.plainly if r.variant == place]
    linked_dots = (
        _linked_dot(run, variant, x, height_of(run), context.address)
        for run in rows.linked
        if run.variant == place
    )
    return (
        link(context.address, f"variant/{place}", name)
        + f'<g class="row" data-variant="{place}" fill="{colour}"'
        f' opacity="{1.0 if context.is_told(place) else 0.35}">'
        + _plain_dots(plain_dots, colour)
        + '<g fill-opacity="0.75" stroke="transparent" stroke-width="2">'
        + "".join(linked_dots)
        + "</g>"
        + _mean_across(estimate, rows, middle)
        + "</g>"
        + svg_text(x.end + 12, middle + 4, shown_mean(estimate))
        + svg_text(context.width - 2, middle + 4, _count(estimate), "end", DIM)
    )


def _row_colours(variants: Sequence[Variant]) -> list[str]:
    """As the curves have them where there are as few; one colour for all where there are more."""
    if len(variants) <= MOST_CURVES:
        return [colour_of(style) for style in styles_of(variants)]
    return [LINK] * len(variants)


def _dots_by_use(
    dots: Sequence[RunFact], chosen: int | None
) -> tuple[Sequence[RunFact], Sequence[RunFact]]:
    """Runs whose dots are links, and runs whose dots are only drawn."""
    if len(dots) <= MOST_LINKED_DOTS:
        return dots, ()
    mine = [run for run in dots if run.variant == chosen]
    if len(mine) > MOST_LINKED_DOTS:
        mine = []
    rest = () if len(dots) > MOST_DOTS else [r for r in dots if not mine or r.variant != chosen]
    return mine, rest


def _dots_in_words(
    linked: Sequence[RunFact],
    plainly: Sequence[RunFact],
    dots: Sequence[RunFact],
    most_runs: int,
) -> str:
    mean = "; the tick is the mean, the bar its 95 % interval." if most_runs > 1 else "."
    if len(linked) == len(dots):
        return f"Each dot is a run, which a click opens{mean}"
    if plainly:
        which = "those of the chosen variant" if linked else "rows of the table"
        return f"Each dot is a run; a click opens {which}{mean}"
    if linked:
        return f"Dots are the runs of the chosen variant, which a click opens{mean}"
    return f"{len(dots):,} runs are too many to draw one by one: only means and intervals are."


def _linked_dot(run: RunFact, variant: Variant, x: Scale, y: float, address: Address) -> str:
    value = shown_number(run.value)
    label = shortened(variant.label, TITLE_CHARACTERS)
    title = f"{label}, seed {run.seed}: {value} - click to open this run in the lab"
    dot = f'<circle class="mark" cx="{x.at(run.value):.1f}" cy="{y:.1f}" r="3.5"/>'
    return link(address, f"open/{run.key}", f"<title>{escaped(title)}</title>{dot}")


def _plain_dots(
    places: Iterable[tuple[float, float]], colour: str, wide: float = 4, opacity: float = 0.55
) -> str:
    """Dots as one path: strokes without length have round ends."""
    path = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in places)
    if not path:
        return ""
    return (
        f'<path class="dots" d="{path}" stroke="{colour}" stroke-width="{wide:g}"'
        f' stroke-linecap="round" stroke-opacity="{opacity:g}" fill="none"/>'
    )


def _mean_across(estimate: Estimate, rows: _Rows, y: float) -> str:
    # The mean of one run is its dot, which a tick would hide.
    if math.isnan(estimate.value) or (estimate.n == 1 and (rows.linked or rows.plainly)):
        return ""
    x = rows.x
    at, half = x.at(estimate.value), min(rows.height, 26) * 0.36
    bar = ""
    if math.isfinite(estimate.low):
        bar = (
            f'<path class="interval" d="M{x.at(estimate.low):.1f} {y:.1f}'
            f'H{x.at(estimate.high):.1f}" stroke-width="5" stroke-opacity="0.4"/>'
        )
    return (
        f'<g stroke="currentColor" pointer-events="none">{bar}<path class="mean"'
        f' d="M{at:.1f} {y - half:.1f}v{2 * half:.1f}" stroke-width="3"/></g>'
    )


def _columns(
    context: Context, estimates: Sequence[Estimate], dots: Sequence[RunFact]
) -> tuple[str, str]:
    """A column for each variant, and what its dots are in words."""
    variants, chosen = context.variants, context.chosen
    low, high = _value_range(dots, estimates)
    y = upwards(low, high, context.tall)
    x = Scale(0.5, len(variants) + 0.5, gutter(low, high), context.width - 10)
    step = (x.end - x.start) / len(variants)
    is_numbered = max(len(v.label) for v in variants) > _LONGEST_COLUMN_NAME
    named = _numbers_of_columns(variants) if is_numbered else _names_of_columns(variants, x)
    parts = [
        quantity(context),
        y_axis(y, x.start, x.end),
        x_axis(x, named, y.end, y.start, _NUMBERED if is_numbered else "variant"),
    ]
    if chosen is not None:
        parts.append(
            f'<path class="chosen" d="M{x.at(chosen + 1):.1f} {y.end}V{y.start:.1f}"'
            f' stroke="{LINK}" stroke-opacity="0.35" stroke-width="{max(step, 4):.1f}"/>'
        )
    shown = dots if len(dots) <= MOST_DOTS else ()
    places = [
        (x.at(run.variant + 1) + _jitter(run.seed) * min(step, 12) * 0.6, y.at(run.value))
        for run in shown
    ]
    if shown and max(estimate.n for estimate in estimates) <= 1:
        # The mean of one run is its dot, which a dash would hide.
        parts.append(_plain_dots(places, LINK, 6, 0.9))
        words = "Each dot is a run. A click chooses a variant."
    else:
        parts.append(_plain_dots(places, LINK))
        parts.append(_means_up(estimates, x, y, min(max(step * 0.8, 2), 12)))
        has_intervals = any(math.isfinite(estimate.low) for estimate in estimates)
        interval = ", the line its 95 % interval" if has_intervals else ""
        which = (
            "Each dot is a run;"
            if shown
            else f"{len(dots):,} runs are too many to draw one by one:"
        )
        words = f"{which} the dash is the mean{interval}. A click chooses a variant."
    parts += _zones(context, estimates, x, y, is_numbered)
    return picture(context.width, y.start + 36, "Every run", "".join(parts)), words


_LONGEST_COLUMN_NAME = 18
"""Characters of the longest name for which columns are called by their names."""


_NUMBERED = "number of the variant in the experiment; its name is under the pointer"


def _names_of_columns(variants: Sequence[Variant], x: Scale) -> list[tuple[float, str]]:
    """The names of as many columns as there is room for."""
    longest = max(len(variant.label) for variant in variants)
    share = (longest + 2) * CHARACTER_PX / (x.end - x.start)
    every = max(math.ceil(share * len(variants)), 1)
    return [(place + 1.0, variants[place].label) for place in range(0, len(variants), every)]


def _numbers_of_columns(variants: Sequence[Variant]) -> list[tuple[float, str]]:
    marks = labelled(1, len(variants), 8)
    return [(tick, name) for tick, name in marks if tick == int(tick)]


def _means_up(estimates: Sequence[Estimate], x: Scale, y: Scale, wide: float) -> str:
    means, bars = [], []
    for place, estimate in enumerate(estimates):
        if math.isnan(estimate.value):
            continue
        at = x.at(place + 1)
        means.append(f"M{at - wide / 2:.1f} {y.at(estimate.value):.1f}h{wide:.1f}")
        if math.isfinite(estimate.low):
            bars.append(f"M{at:.1f} {y.at(estimate.low):.1f}V{y.at(estimate.high):.1f}")
    return (
        '<g stroke="currentColor" fill="none">'
        f'<path class="interval" d="{"".join(bars)}" stroke-opacity="0.5" stroke-width="1.5"/>'
        f'<path class="mean" d="{"".join(means)}" stroke-width="2.5"/></g>'
    )


def _zones(
    context: Context, estimates: Sequence[Estimate], x: Scale, y: Scale, is_numbered: bool
) -> Iterable[str]:
    """What can be clicked: each column; of columns too narrow for it, some with their highest."""
    variants = context.variants
    together = math.ceil(len(variants) / MOST_COLUMNS)
    for first in range(0, len(variants), together):
        places = range(first, min(first + together, len(variants)))
        place = max(places, key=lambda p: np.nan_to_num(estimates[p].value, nan=-math.inf))
        a, b = x.at(first + 0.5), x.at(places[-1] + 1.5)
        highest = "" if together == 1 else f"highest of {places[0] + 1} to {places[-1] + 1}: "
        number = f"{place + 1}: " if is_numbered else ""
        title = f"{highest}{number}{described(variants[place], estimates[place])}"
        yield link(
            context.address,
            f"variant/{place}",
            f"<title>{escaped(title)}</title>"
            f'<path class="zone" d="M{a:.1f} {y.end:.0f}H{b:.1f}V{y.start:.0f}H{a:.1f}Z"'
            ' fill="transparent"/>',
        )
