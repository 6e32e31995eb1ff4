"""A picture of every run, since runs of one learner may end in more than one way."""

from collections.abc import Sequence
from typing import Final, NamedTuple

from app.analysis import estimates
from app.analysis.estimates import bootstrap_rng
from app.charts.model import Dot, Dots, RunDot
from app.charts.paper.drawing import drawn
from app.charts.styles import Style
from app.experiments.record import Record
from app.metrics import Metric
from app.report.document import Page
from app.report.parts import GREED, NO_INTERVAL
from app.util.html import Markup

_COLUMNS: Final = ("final_reward", "final_greedy", "horizon_reward")
"""What runs are shown by, of what was measured: as they learn, by pure greed, and after as many
steps as the others."""


class Row(NamedTuple):
    """Runs that belong together."""

    label: str
    runs: Sequence[Record]
    style: Style | None = None


def runs_picture(
    page: Page, name: str, caption: str, rows: Sequence[Row], metrics: Sequence[Metric]
) -> Markup:
    """A dot for each run, in rows, and a column for each number; nothing where none was measured.

    Args:
        page: that keeps the picture.
        name: of its files.
        caption: of the picture.
        rows: the runs.
        metrics: all that there are, with their words.
    """
    columns = {
        metric.label: [_dot(row, metric.column) for row in rows]
        for metric in metrics
        if metric.column in _COLUMNS
    }
    columns = {what: dots for what, dots in columns.items() if any(dot.estimate.n for dot in dots)}
    if not columns:
        return Markup()
    has_bars = any(dot.estimate.has_interval for dots in columns.values() for dot in dots)
    bars = "with its 95 % bootstrap interval" if has_bars else f"over the runs. {NO_INTERVAL}"
    is_greedy = any(
        metric.label in columns for metric in metrics if metric.column == "final_greedy"
    )
    greed = f" {GREED}" if is_greedy else ""
    small = page.small_print(
        f"Small: a run each. Large: their mean {bars.rstrip('.')}. Where runs end in several ways,"
        f" their mean may lie where none of them does.{greed}"
    )
    return page.picture(name, caption, drawn(name, Dots(columns), small))


def _dot(row: Row, column: str) -> Dot:
    values = [run.values[column] for run in row.runs]
    mean = estimates.mean(values, bootstrap_rng())
    dots = [RunDot(run.values[column], run.seed) for run in row.runs]
    return Dot(row.label, mean, dots, row.style)
