"""Every run a dot on the page, with mean and interval of each variant."""

import math
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

import numpy as np

from app.analysis.estimates import Estimate
from app.charts.model import Dot, Dots, RunDot
from app.charts.page import svg
from app.charts.page.colours import LINK, colour_of
from app.charts.page.svg import Frame, Scale
from app.charts.wording import (
    PADDED,
    described,
    few_in_words,
    short_label,
    short_title,
    shown_estimate,
)
from app.util.html import escaped
from app.words.numbers import labelled_ticks, shared_form, shown_number

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
_LONGEST_COLUMN_NAME = 18
"""Characters of the longest name for which columns are called by their names."""
_NUMBERED = "number of the variant in the experiment; its name is under the pointer"


def runs_html(chart: Dots, frame: Frame) -> str:
    """A row for each variant; a column for each where there are more than ``MOST_ROWS``.

    Args:
        chart: of one svg.quantity.
        frame: what it is drawn for.
    """
    ((what, dots),) = chart.columns.items()
    draw = _rows if len(dots) <= MOST_ROWS else _columns
    drawn, words = draw(what, dots, frame)
    return drawn + svg.note(few_in_words(dot.estimate.n for dot in dots), words, frame.note)


def _value_range(dots: Sequence[Dot]) -> tuple[float, float]:
    values = [run.value for dot in dots for run in dot.runs]
    return svg.padded([*values, *(number for dot in dots for number in dot.estimate[:3])])


def _told_of(dot: Dot) -> str:
    """What the page's script says of each dot of a path, as attributes."""
    seeds = " ".join(str(run.seed) for run in dot.runs)
    values = " ".join(shown_number(run.value, PADDED) for run in dot.runs)
    label = escaped(short_title(dot.label))
    return f' data-label="{label}" data-seeds="{seeds}" data-values="{values}"'


def _plain_dots(
    places: Iterable[tuple[float, float]],
    colour: str,
    wide: float = 4,
    opacity: float = 0.55,
    told: str = "",
) -> str:
    """Dots as one path: strokes without length have round ends; ``told`` are attributes."""
    path = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in places)
    if not path:
        return ""
    return (
        f'<path class="dots"{told} d="{path}" stroke="{colour}" stroke-width="{wide:g}"'
        f' stroke-linecap="round" stroke-opacity="{opacity:g}" fill="none"/>'
    )


# --- Rows ----------------------------------------------------------------------------------------


class _Rows(NamedTuple):
    """What rows share."""

    x: Scale
    height: float
    form: str
    """How their numbers are written."""
    linked: Sequence[int]
    """Places of the variants whose dots are links, and of those whose dots are not."""
    plainly: Sequence[int]


def _rows(what: str, dots: Sequence[Dot], frame: Frame) -> tuple[str, str]:
    """A row for each variant, and what its dots are in words."""
    width = frame.width
    widest = max(len(dot.label) for dot in dots)
    left = min(widest * _BOLD_PX + 14, _LARGEST_GUTTER * width)
    count_px = max(len(_count(dot)) for dot in dots) * svg.CHARACTER_PX + 4
    form = shared_form(number for dot in dots for number in dot.estimate[:3])
    mean_px = max(len(shown_estimate(dot.estimate, form)) for dot in dots) * svg.CHARACTER_PX
    x = Scale(*_value_range(dots), left, width - mean_px - count_px - 16)
    least, most = (26, 44) if dots[0].style else (18, 30)
    height = min(max(frame.tall / len(dots) / 2, least), most)
    rows = _Rows(x, height, form, *_places_by_use(dots, frame.chosen))
    bottom = 8.0 + height * len(dots)
    marks = labelled_ticks(x.low, x.high, max(int((x.end - x.start) / 50), 2))
    parts = [svg.x_axis(x, marks, (4.0, bottom), what, width)]
    parts += [_row(rows, place, dot, frame) for place, dot in enumerate(dots)]
    return svg.picture(width, bottom + 36, "Every run", "".join(parts)), _dots_in_words(rows, dots)


def _count(dot: Dot) -> str:
    return f"n = {dot.estimate.n:,}"


def _row(rows: _Rows, place: int, dot: Dot, frame: Frame) -> str:
    """A variant: its label, its dots, its mean as a tick and as a number."""
    x, colour = rows.x, colour_of(dot.style) if dot.style else LINK
    middle = 6.0 + rows.height * (place + 0.5)

    def at(run: RunDot) -> tuple[float, float]:
        return x.at(run.value), middle + run.height * rows.height * 0.6

    name = svg.text(
        x.start - 10,
        middle + 4,
        short_label(dot.label, int((x.start - 14) / _BOLD_PX)),
        "end",
        f' fill="{LINK}"' + (' font-weight="700"' if place == frame.chosen else ""),
        title=dot.label,
    )
    linked = (_linked_dot(run, dot.label, at(run), frame) for run in dot.runs)
    return (
        svg.link(frame.address, f"variant/{place}", name)
        + f'<g class="row" data-variant="{place}" fill="{colour}"'
        f' opacity="{1.0 if frame.is_told(place) else 0.35}">'
        + _plain_dots(
            map(at, dot.runs if place in rows.plainly else ()), colour, told=_told_of(dot)
        )
        + '<g fill-opacity="0.75" stroke="transparent" stroke-width="2">'
        + "".join(linked if place in rows.linked else ())
        + "</g>"
        + _mean_across(dot.estimate, rows, middle)
        + "</g>"
        + svg.text(x.end + 12, middle + 4, shown_estimate(dot.estimate, rows.form))
        + svg.text(frame.width - 2, middle + 4, _count(dot), "end", svg.DIM)
    )


def _places_by_use(dots: Sequence[Dot], chosen: int | None) -> tuple[Sequence[int], Sequence[int]]:
    """Places of variants whose dots are links, and of those whose dots are only drawn."""
    every, n_dots = range(len(dots)), sum(len(dot.runs) for dot in dots)
    if n_dots <= MOST_LINKED_DOTS:
        return every, ()
    linked = [
        place
        for place in every
        if place == chosen and 0 < len(dots[place].runs) <= MOST_LINKED_DOTS
    ]
    return linked, [] if n_dots > MOST_DOTS else [place for place in every if place not in linked]


def _dots_in_words(rows: _Rows, dots: Sequence[Dot]) -> str:
    n_runs = max(dot.estimate.n for dot in dots)
    mean = "; the tick is the mean, the bar its 95 % interval." if n_runs > 1 else "."
    if len(rows.linked) == len(dots):
        return f"Each dot is a run, which a click opens{mean}"
    if rows.plainly:
        which = "those of the chosen variant" if rows.linked else "rows of the table"
        return f"Each dot is a run; a click opens {which}{mean}"
    if rows.linked:
        return f"Dots are the runs of the chosen variant, which a click opens{mean}"
    return _too_many(dots) + " only means and intervals are."


def _too_many(dots: Sequence[Dot]) -> str:
    return f"{sum(len(dot.runs) for dot in dots):,} runs are too many to draw one by one:"


def _linked_dot(run: RunDot, label: str, at: tuple[float, float], frame: Frame) -> str:
    value = shown_number(run.value, PADDED)
    title = f"{short_title(label)}, seed {run.seed}: {value} (a click opens this run)"
    dot = f'<circle class="mark" cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="3.5"/>'
    return svg.link(frame.address, f"open/{run.key}", f"<title>{escaped(title)}</title>{dot}")


def _mean_across(estimate: Estimate, rows: _Rows, y: float) -> str:
    # The mean of one run is its dot, which a tick would hide.
    if math.isnan(estimate.value) or (estimate.n == 1 and (rows.linked or rows.plainly)):
        return ""
    x = rows.x
    at, half = x.at(estimate.value), min(rows.height, 26) * 0.36
    bar = ""
    if estimate.has_interval:
        bar = (
            f'<path class="interval" d="M{x.at(estimate.low):.1f} {y:.1f}'
            f'H{x.at(estimate.high):.1f}" stroke-width="5" stroke-opacity="0.4"/>'
        )
    return (
        f'<g stroke="currentColor" pointer-events="none">{bar}<path class="mean"'
        f' d="M{at:.1f} {y - half:.1f}v{2 * half:.1f}" stroke-width="3"/></g>'
    )


# --- Columns -------------------------------------------------------------------------------------


def _columns(what: str, dots: Sequence[Dot], frame: Frame) -> tuple[str, str]:
    """A column for each variant, and what its dots are in words."""
    low, high = _value_range(dots)
    y = svg.upwards(low, high, frame.tall)
    x = Scale(0.5, len(dots) + 0.5, svg.gutter(low, high), frame.width - 10)
    step = (x.end - x.start) / len(dots)
    is_numbered = max(len(dot.label) for dot in dots) > _LONGEST_COLUMN_NAME
    named = _numbers_of(len(dots)) if is_numbered else _names_of(dots, x)
    parts = [
        svg.quantity(what, frame.width),
        svg.y_axis(y, x.start, x.end),
        svg.x_axis(
            x, named, (y.end, y.start), _NUMBERED if is_numbered else "variant", frame.width
        ),
    ]
    if frame.chosen is not None:
        parts.append(
            f'<path class="chosen" d="M{x.at(frame.chosen + 1):.1f} {y.end}V{y.start:.1f}"'
            f' stroke="{LINK}" stroke-opacity="0.35" stroke-width="{max(step, 4):.1f}"/>'
        )
    places = [
        (x.at(place + 1) + run.height * min(step, 12) * 0.6, y.at(run.value))
        for place, dot in enumerate(dots)
        for run in dot.runs
    ]
    is_drawn = 0 < len(places) <= MOST_DOTS
    if is_drawn and max(dot.estimate.n for dot in dots) <= 1:
        # The mean of one run is its dot, which a dash would hide.
        parts.append(_plain_dots(places, LINK, 6, 0.9))
        words = "Each dot is a run. A click chooses a variant."
    else:
        parts.append(_plain_dots(places if is_drawn else (), LINK))
        parts.append(_means_up(dots, x, y, min(max(step * 0.8, 2), 12)))
        has_intervals = any(dot.estimate.has_interval for dot in dots)
        interval = ", the line its 95 % interval" if has_intervals else ""
        which = "Each dot is a run;" if is_drawn else _too_many(dots)
        words = f"{which} the dash is the mean{interval}. A click chooses a variant."
    parts += _zones(dots, x, y, is_numbered, frame)
    return svg.picture(frame.width, y.start + 36, "Every run", "".join(parts)), words


def _names_of(dots: Sequence[Dot], x: Scale) -> list[tuple[float, str]]:
    """The names of as many columns as there is room for."""
    longest = max(len(dot.label) for dot in dots)
    share = (longest + 2) * svg.CHARACTER_PX / (x.end - x.start)
    every = max(math.ceil(share * len(dots)), 1)
    return [(place + 1.0, dots[place].label) for place in range(0, len(dots), every)]


def _numbers_of(n_columns: int) -> list[tuple[float, str]]:
    return [(tick, name) for tick, name in labelled_ticks(1, n_columns, 8) if tick == int(tick)]


def _means_up(dots: Sequence[Dot], x: Scale, y: Scale, wide: float) -> str:
    means: list[str] = []
    bars: list[str] = []
    for place, dot in enumerate(dots):
        estimate = dot.estimate
        if math.isnan(estimate.value):
            continue
        at = x.at(place + 1)
        means.append(f"M{at - wide / 2:.1f} {y.at(estimate.value):.1f}h{wide:.1f}")
        if estimate.has_interval:
            bars.append(f"M{at:.1f} {y.at(estimate.low):.1f}V{y.at(estimate.high):.1f}")
    return (
        '<g stroke="currentColor" fill="none">'
        f'<path class="interval" d="{"".join(bars)}" stroke-opacity="0.5" stroke-width="1.5"/>'
        f'<path class="mean" d="{"".join(means)}" stroke-width="2.5"/></g>'
    )


def _zones(
    dots: Sequence[Dot], x: Scale, y: Scale, is_numbered: bool, frame: Frame
) -> Iterable[str]:
    """What can be clicked: each column; of columns too narrow for it, some with their highest."""
    together = math.ceil(len(dots) / MOST_COLUMNS)
    for first in range(0, len(dots), together):
        places = range(first, min(first + together, len(dots)))
        place = max(places, key=lambda p: np.nan_to_num(dots[p].estimate.value, nan=-math.inf))
        a, b = x.at(first + 0.5), x.at(places[-1] + 1.5)
        highest = "" if together == 1 else f"highest of {places[0] + 1} to {places[-1] + 1}: "
        number = f"{place + 1}: " if is_numbered else ""
        title = f"{highest}{number}{described(dots[place].label, dots[place].estimate)}"
        yield svg.link(
            frame.address,
            f"variant/{place}",
            f"<title>{escaped(title)}</title>"
            f'<path class="zone" d="M{a:.1f} {y.end:.0f}H{b:.1f}V{y.start:.0f}H{a:.1f}Z"'
            ' fill="transparent"/>',
        )
