"""One setting that was swept, on the page."""

import math
from collections.abc import Sequence

from app.analysis.axles import Axle, grouped
from app.analysis.estimates import Estimate
from app.charts.model import NOTHING, Choice, Points
from app.charts.page import svg
from app.charts.page.colours import LINK
from app.charts.page.svg import Frame, Scale
from app.charts.wording import described, few_in_words, short_label
from app.util.html import escaped
from app.words.numbers import labelled_ticks
from app.words.placing import Room


def points_html(chart: Points, frame: Frame) -> str:
    """Means with intervals against the value of the setting; a click chooses a variant.

    Args:
        chart: of one series.
        frame: what it is drawn for.
    """
    axle, (series,) = chart.axle, chart.series
    estimates = [estimate or NOTHING for estimate in series.estimates]
    low, high = svg.padded([number for estimate in estimates for number in estimate[:3]])
    left, y = svg.gutter(low, high), svg.upwards(low, high, frame.tall)
    values = axle.places
    x = Scale(min(values), max(values), left + 20, frame.width - 34, axle.is_logarithmic)
    path = "L".join(
        f"{x.at(value):.1f} {y.at(estimate.value):.1f}"
        for value, estimate in zip(values, estimates, strict=True)
        if math.isfinite(estimate.value)
    )
    parts = [
        svg.quantity(chart.what, frame.width),
        svg.y_axis(y, left, frame.width - 10),
        svg.x_axis(x, _names_of(axle, x), (y.end, y.start), axle.label, frame.width),
        f'<path d="M{path}" fill="none" stroke="{LINK}" stroke-opacity="0.5"/>' if path else "",
    ]
    radius = 4.5 if len(values) <= 40 else 3
    for value, estimate, choice in zip(values, estimates, series.choices, strict=True):
        if choice is not None:
            parts.append(_point(choice, estimate, x.at(value), y, radius, frame))
    counts = [estimate.n for estimate in estimates if estimate.n]
    return svg.picture(frame.width, y.start + 36, "One setting swept", "".join(parts)) + svg.note(
        few_in_words(counts), _points_in_words(counts), frame.note
    )


def _points_in_words(counts: Sequence[int]) -> str:
    """What a point is, of those that have runs."""
    fewest, most = min(counts, default=0), max(counts, default=0)
    if most <= 1:
        return "Each point is one run; a click chooses a variant."
    each = f"{fewest:,}" if fewest == most else f"{fewest:,} to {most:,}"
    return f"Means with their 95 % intervals, n = {each}; a click chooses a variant."


def _point(
    choice: Choice, estimate: Estimate, at: float, y: Scale, radius: float, frame: Frame
) -> str:
    """A mean that chooses its variant, with its interval; empty where there is no mean."""
    interval, look, ring = "", f'fill="{LINK}"', ""
    is_there = math.isfinite(estimate.value)
    if estimate.has_interval:
        interval = (
            f'<path class="interval" d="M{at:.1f} {y.at(estimate.low):.1f}'
            f'V{y.at(estimate.high):.1f}" stroke="{LINK}" stroke-width="2"/>'
        )
    if not is_there:
        look, ring = 'fill="transparent"', ' stroke="currentColor" stroke-opacity="0.4"'
    if choice.place == frame.chosen:
        radius += 2
        ring = ' stroke="currentColor" stroke-width="2.5"'
    height = y.at(estimate.value) if is_there else y.start
    title = escaped(described(choice.label, estimate))
    dot = f'<circle class="mark" cx="{at:.1f}" cy="{height:.1f}" r="{radius:g}" {look}{ring}/>'
    words = f"variant/{choice.place}"
    return interval + svg.link(frame.address, words, f"<title>{title}</title>{dot}")


def _names_of(axle: Axle, x: Scale) -> list[tuple[float, str]]:
    """Ticks at values of a setting that have room for their names; at round ones on a scale."""
    if not axle.is_even and not axle.is_logarithmic:
        return labelled_ticks(x.low, x.high, 8)
    room = Room(-math.inf, math.inf)
    named: list[tuple[float, str]] = []
    for at, value in zip(axle.places, axle.values, strict=True):
        name = short_label(grouped(value), 14)
        half = len(name) * svg.CHARACTER_PX / 2 + 3
        if room.taken(x.at(at) - half, x.at(at) + half):
            named.append((at, name))
    return named
