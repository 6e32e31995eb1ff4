"""The chart that a browser looks at, as a file: drawn as in a report."""

import math
from collections.abc import Sequence
from typing import Final

from app import figures, results_view
from app.charts import styles_of
from app.figures import Dot, Drawing, Line, Mark, Panel, Series, with_clear_marks
from app.gathered import Curve, Gatherer, Gathering
from app.results_view import View
from app.statistics import Axis, Estimate
from app.sweep import Sweep

_MOST_ROWS: Final = 60


def drawing_of(gatherer: Gatherer, gathering: Gathering, view: View) -> Drawing:
    """What a browser looks at, with its numbers."""
    small = (
        f"{gathering.experiment.name}: {len(gathering.runs):,} of"
        f" {gathering.experiment.n_runs:,} runs are over; n runs (seeds) each; 95 % bootstrap"
        " intervals over runs."
    )
    name = gathering.experiment.name
    sweep = results_view.swept(gathering.experiment)
    if view.chart == "plane" and sweep is not None:
        return _swept(name, gatherer, gathering, sweep, small)
    if view.chart == "curves":
        found = [
            gatherer.curve(variant, view.axis)
            for variant in results_view.places_of_curves(
                len(gathering.experiment.variants), view.variant
            )
        ]
        lines = _lines(gathering, [curve for curve in found if curve.n], view.axis)
        return figures.draw_curves(
            name, [Panel(gathering.experiment.name, lines)], view.axis, small
        )
    dots = [
        Dot(variant.label, gatherer.estimate(place))
        for place, variant in enumerate(gathering.experiment.variants[:_MOST_ROWS])
    ]
    return figures.draw_dots(name, {gathering.metric.label: dots}, small)


def _lines(gathering: Gathering, curves: Sequence[Curve], axis: Axis) -> Sequence[Line]:
    variants = [gathering.experiment.variants[curve.variant] for curve in curves]
    lines = []
    for curve, variant, style in zip(curves, variants, styles_of(variants), strict=True):
        marks = [
            Mark(moment.step if axis == "steps" else moment.trial, moment.skill.replace("_", " "))
            for moment in curve.joined
        ]
        lines.append(Line(variant.label, curve.band, style, curve.n, marks))
    return with_clear_marks(lines)


def _swept(
    name: str, gatherer: Gatherer, gathering: Gathering, sweep: Sweep, small: str
) -> Drawing:
    there = {place: gatherer.estimate(variant) for place, variant in sweep.places.items()}
    if len(sweep.axles) == 2:
        cells = {(at[0], at[1]): found for at, found in there.items() if found.n}
        across, up = sweep.axles
        return figures.draw_plane(name, (across, up), cells, gathering.metric.label, small)
    (axle,) = sweep.axles
    nothing = Estimate(math.nan, math.nan, math.nan, 0)
    series = [there.get((index,), nothing) for index in range(len(axle.values))]
    points = [found if found.n else None for found in series]
    label = gathering.experiment.variants[0].preset
    return figures.draw_points(name, axle, [Series(label, points)], gathering.metric.label, small)
