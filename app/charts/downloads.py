"""The chart that a browser looks at, as a file: drawn as in a report."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from app.analysis.estimates import Axis, Estimate
from app.analysis.sweeps import Sweep
from app.charts import paper
from app.charts.drawing import Drawing
from app.charts.paper import Dot, Line, Mark, Panel, Series, with_clear_marks
from app.charts.parts import styles_of
from app.charts.view import View, in_short, metric_of, own_setting, places_of_curves, swept
from app.documents.experiments import Experiment
from app.results.gather import Curve, Gatherer, Gathering
from app.words.plain import plain

_MOST_ROWS: Final = 60


def drawing_of(gatherer: Gatherer, gathering: Gathering, view: View) -> Drawing:
    """What a browser looks at, with its numbers; variants are called as they are there."""
    experiment, what = in_short(gathering.experiment)
    metric = metric_of(gathering)
    sweep, own = (
        swept(gathering.experiment),
        own_setting(gathering.experiment),
    )
    most_runs = max(Counter(run.variant for run in gathering.runs).values(), default=0)
    small = (
        f"{experiment.name}: {len(gathering.runs):,} of {experiment.n_runs:,} runs are over;"
        + (
            " n runs (seeds) each; 95 % bootstrap intervals over runs."
            if most_runs > 1
            else " one run (seed) each, which has no interval."
        )
    )
    if view.chart == "plane" and sweep is not None:
        return _swept(gatherer, replace(gathering, metric=metric), sweep, own, small)
    if what:
        small += f" Variants are named by {what}."
    if view.chart == "curves":
        found = [
            gatherer.curve(variant, view.axis)
            for variant in places_of_curves(len(experiment.variants), view.variant)
        ]
        lines = _lines(experiment, [curve for curve in found if curve.n], view.axis)
        return paper.draw_curves(experiment.name, [Panel(experiment.name, lines)], view.axis, small)
    values: list[list[float]] = [[] for _ in experiment.variants]
    for run in gathering.runs:
        values[run.variant].append(run.value)
    shown = experiment.variants[:_MOST_ROWS]
    dots = [
        Dot(variant.label, gatherer.estimate(place), values[place])
        for place, variant in enumerate(shown)
    ]
    if most_runs > 1:
        small += " Pale dots are single runs."
    if len(shown) < len(experiment.variants):
        small += f" The first {len(shown)} of {len(experiment.variants):,} variants."
    return paper.draw_dots(experiment.name, {metric.label: dots}, small)


def _lines(experiment: Experiment, curves: Sequence[Curve], axis: Axis) -> Sequence[Line]:
    variants = [experiment.variants[curve.variant] for curve in curves]
    lines = []
    for curve, variant, style in zip(curves, variants, styles_of(variants), strict=True):
        marks = [
            Mark(moment.step if axis == "steps" else moment.trial, plain(moment.skill))
            for moment in curve.joined
        ]
        lines.append(Line(variant.label, curve.band, style, curve.n, marks))
    return with_clear_marks(lines)


def _swept(
    gatherer: Gatherer, gathering: Gathering, sweep: Sweep, own: int | None, small: str
) -> Drawing:
    name, label = gathering.experiment.name, gathering.metric.label
    there = {place: gatherer.estimate(variant) for place, variant in sweep.places.items()}
    if len(sweep.axles) == 2:
        cells = {(at[0], at[1]): found for at, found in there.items() if found.n}
        across, up = sweep.axles
        framed = next(
            ((at[0], at[1]) for at, variant in sweep.places.items() if variant == own), None
        )
        if framed is not None:
            small += " The frame is the preset's own setting."
        return paper.draw_plane(name, (across, up), cells, label, small, framed)
    (axle,) = sweep.axles
    nothing = Estimate(math.nan, math.nan, math.nan, 0)
    series = [there.get((index,), nothing) for index in range(len(axle.values))]
    points = [found if found.n else None for found in series]
    preset = gathering.experiment.variants[0].preset
    return paper.draw_points(name, axle, [Series(preset, points)], label, small)
