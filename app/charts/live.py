"""Charts of live results: built alike for the page and for the files that can be kept of it."""

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from app.analysis.estimates import Estimate
from app.analysis.sweeps import Sweep
from app.charts import variants
from app.charts.greedy import averaged
from app.charts.model import (
    Choice,
    Curves,
    Dot,
    Dots,
    Line,
    Mark,
    Panel,
    Plane,
    Points,
    RunDot,
    Series,
)
from app.charts.styles import styles_of
from app.charts.view import View, charted
from app.charts.wording import short_label
from app.documents.experiments import Experiment
from app.metrics import Metric
from app.results.gather import MOST_CURVES, Gatherer, Gathering
from app.results.reference import told_of
from app.words.numbers import counted
from app.words.plain import plain

LiveChart = Curves | Dots | Plane | Points
"""Each of one panel, one quantity, or one series."""


def looked_at(gathering: Gathering, view: View) -> tuple[Gathering, str]:
    """What there is as somebody looks at it, and what short names are made of (else nothing).

    Variants have short names, and the number that is charted is the one that was chosen.
    """
    experiment, what = variants.with_short_names(gathering.experiment)
    wanted = next((m for m in charted(gathering) if m.column == view.metric), gathering.metric)
    return replace(gathering, experiment=experiment, metric=called(wanted, gathering)), what


def called(metric: Metric, gathering: Gathering) -> Metric:
    """A metric in words that hold for the runs that there are."""
    horizon = gathering.horizon
    named = metric.of_runs(*trials_of(gathering.experiment))
    return named.at(horizon.steps if horizon else None)


def trials_of(experiment: Experiment) -> tuple[int, int]:
    """Trials of the shortest run that there can be, and of the longest."""
    trials = [experiment.trials_of(variant) for variant in experiment.variants]
    ends_earlier = experiment.stop is not None or experiment.steps is not None
    return 0 if ends_earlier else min(trials), max(trials)


def chart_of(gatherer: Gatherer, gathering: Gathering, view: View) -> LiveChart:
    """The chart that somebody looks at.

    Args:
        gatherer: what knows averages.
        gathering: the runs that there are; their variants are called as they are here.
        view: what is looked at.
    """
    if view.chart == "curves":
        return _curves(gatherer, gathering, view)
    sweep = variants.swept(gathering.experiment)
    if view.chart == "runs" or sweep is None:
        return _runs(gatherer, gathering)
    build = _plane if len(sweep.axles) == 2 else _points
    return build(gatherer, gathering, sweep)


def left_out(gathering: Gathering, chart: LiveChart) -> str:
    """What a chart does not show, in words; empty if it shows all."""
    if isinstance(chart, Curves):
        n_others = len(gathering.experiment.variants) - len(chart.panels[0].lines)
        base = gathering.experiment.variants[variants.reference(gathering.experiment)]
        words = (
            f"Drawn: {len(chart.panels[0].lines)} of {n_others + len(chart.panels[0].lines):,}"
            f" variants, {short_label(base.label, 40)} and others from the lowest to the highest"
            f" {gathering.metric.title}; one that is chosen in another chart is drawn as well."
        )
        return words if n_others else ""
    done = [run for _, run in gathering.runs if not run.error]
    failed = len(gathering.runs) - len(done)
    without = sum(1 for run in done if math.isnan(run.values[gathering.metric.column]))
    said = {"failed": failed, "without a value": without}
    return " ".join(f"{counted(n, 'run')} {what}." for what, n in said.items() if n)


def _curves(gatherer: Gatherer, gathering: Gathering, view: View) -> Curves:
    """Of many variants a few; if the chosen one is not among them, it comes last."""
    axis, chosen = view.axis, view.variant
    every = gathering.experiment.variants
    places = _drawn(gatherer, gathering, chosen)
    styles = styles_of([every[place].preset for place in places])
    lines: list[Line] = []
    for place, style in zip(places, styles, strict=True):
        found = gatherer.curve(place, axis, view.windows)
        marks = [
            Mark(moment.step if axis == "steps" else moment.trial, plain(moment.skill))
            for moment in found.joined
        ]
        lines.append(
            Line(
                every[place].label,
                found.band,
                style,
                found.n,
                marks,
                place,
                averaged(found.greedy, axis),
            )
        )
    ends = gathering.low, gathering.high
    return Curves(axis, [Panel(gathering.experiment.name, lines)], ends)


def _drawn(gatherer: Gatherer, gathering: Gathering, chosen: int | None) -> Sequence[int]:
    """Places of the variants whose curves are drawn."""
    every = gathering.experiment.variants
    if len(every) <= MOST_CURVES:
        return range(len(every))
    of_each: dict[int, list[float]] = defaultdict(list)
    for place, run in gathering.runs:
        value = run.values[gathering.metric.column]
        if not run.error and math.isfinite(value):
            of_each[place].append(value)
    means = [float(np.mean(of_each[p])) if of_each[p] else math.nan for p in range(len(every))]
    places = told_of(means, variants.reference(gathering.experiment), MOST_CURVES)
    return places if chosen is None or chosen in places else [*places[:-1], chosen]


def _runs(gatherer: Gatherer, gathering: Gathering) -> Dots:
    """Every run that has a value, by variant; of dots that meet, the highest seed's is on top."""
    every = gathering.experiment.variants
    dots: Mapping[int, list[RunDot]] = defaultdict(list)
    for place, run in sorted(gathering.runs, key=lambda placed: placed[1].seed):
        value = run.values[gathering.metric.column]
        if not run.error and math.isfinite(value):
            dots[place].append(RunDot(value, run.seed, run.key))
    if len(every) <= variants.MOST_CELLS:
        metric = gathering.metric
        estimates = [gatherer.estimate(place, metric) for place in range(len(every))]
    else:  # The intervals of so many take seconds.
        estimates = [_mean([dot.value for dot in dots[place]]) for place in range(len(every))]
    styles = styles_of([v.preset for v in every]) if len(every) <= MOST_CURVES else []
    rows = [
        Dot(variant.label, estimates[place], dots[place], styles[place] if styles else None)
        for place, variant in enumerate(every)
    ]
    return Dots({gathering.metric.label: rows})


def _mean(values: Sequence[float]) -> Estimate:
    """A mean without its interval."""
    mean = float(np.mean(values)) if values else math.nan
    return Estimate(mean, math.nan, math.nan, len(values))


def _plane(gatherer: Gatherer, gathering: Gathering, sweep: Sweep) -> Plane:
    across, up = sweep.axles
    metric = gathering.metric
    there = {at: gatherer.estimate(place, metric) for at, place in sweep.places.items()}
    cells = {at: found for at, found in there.items() if found.n}
    own = variants.own_setting(gathering.experiment)
    framed = next((at for at, place in sweep.places.items() if place == own), None)
    every = gathering.experiment.variants
    choices = {at: Choice(place, every[place].label) for at, place in sweep.places.items()}
    return Plane((across, up), gathering.metric.label, cells, framed, choices=choices)


def _points(gatherer: Gatherer, gathering: Gathering, sweep: Sweep) -> Points:
    (axle,) = sweep.axles
    every = gathering.experiment.variants
    places = [sweep.places.get((index,)) for index in range(len(axle.values))]
    metric = gathering.metric
    found = [None if place is None else gatherer.estimate(place, metric) for place in places]
    series = Series(
        every[0].preset,
        [estimate if estimate is not None and estimate.n else None for estimate in found],
        [None if place is None else Choice(place, every[place].label) for place in places],
    )
    return Points(axle, gathering.metric.label, [series])
