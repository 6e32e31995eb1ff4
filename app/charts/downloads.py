"""The chart that a browser looks at, as a file: its numbers, or drawn as in a report."""

from collections import Counter
from typing import Final

from app.charts import live
from app.charts.live import LiveChart
from app.charts.model import Curves, Dots, Panel, Plane, Rows, with_clear_marks
from app.charts.paper.drawing import Drawing, drawn
from app.charts.view import View
from app.metrics import Metric
from app.results.gather import Gatherer, Gathering

_MOST_ROWS: Final = 60


def numbers_of(gatherer: Gatherer, gathering: Gathering, view: View) -> Rows:
    """The numbers of what a browser looks at; variants are called as they are there."""
    gathering, _ = live.looked_at(gathering, view)
    return _on_paper(live.chart_of(gatherer, gathering, view), gatherer, gathering.metric).numbers


def drawing_of(gatherer: Gatherer, gathering: Gathering, view: View) -> Drawing:
    """What a browser looks at, on paper; variants are called as they are there."""
    gathering, what = live.looked_at(gathering, view)
    chart = live.chart_of(gatherer, gathering, view)
    experiment = gathering.experiment
    has_means = max(Counter(place for place, _ in gathering.runs).values(), default=0) > 1
    small = [
        f"{experiment.name}: {len(gathering.runs):,} of {experiment.n_runs:,} runs are over;",
        "n runs (seeds) each; 95 % bootstrap intervals over runs."
        if has_means
        else "one run (seed) each, which has no interval.",
    ]
    if isinstance(chart, Plane) and chart.framed is not None:
        small.append("The frame is the preset's own setting.")
    if isinstance(chart, Curves | Dots) and what:
        small.append(f"Variants are named by {what}.")
    if isinstance(chart, Dots):
        n_variants = len(experiment.variants)
        small += ["Pale dots are single runs."] * has_means
        small += [f"The first {_MOST_ROWS} of {n_variants:,} variants."] * (n_variants > _MOST_ROWS)
    return drawn(experiment.name, _on_paper(chart, gatherer, gathering.metric), " ".join(small))


def _on_paper(chart: LiveChart, gatherer: Gatherer, metric: Metric) -> LiveChart:
    """As much of a chart as paper can show."""
    if isinstance(chart, Curves):
        (panel,) = chart.panels
        lines = with_clear_marks([line for line in panel.lines if line.n])
        return chart._replace(panels=[Panel(panel.title, lines)])
    if isinstance(chart, Dots):
        ((what, dots),) = chart.columns.items()
        # On the page the means of very many variants have no intervals; those of the first have.
        rows = [
            dot._replace(estimate=gatherer.estimate(place, metric))
            for place, dot in enumerate(dots[:_MOST_ROWS])
        ]
        return Dots({what: rows})
    return chart
