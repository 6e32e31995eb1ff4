"""What somebody looks at of the results of an experiment, and what a click makes of it.

Whatever a click says comes from the network, so what makes no sense leaves the view as it is.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, NamedTuple, get_args

from app.analysis.estimates import WINDOWS, Axis, Windows
from app.charts.variants import swept
from app.documents.experiments import Experiment
from app.metrics import IN_TABLE, Metric, of_kind, wants_greedy
from app.results.gather import MOST_CURVES, Gathering, PlacedRun

_USUAL_HEIGHT: Final = 752.0
"""In pixels, for which the heights below hold."""
_PLOT_PX: Final = 208.0
_LEAST_PLOT_PX: Final = 150.0
_PLOT_SHARE: Final = 0.5
"""Of what the panel is higher; its rows get the rest but for a little."""
_ROW_PX: Final = 22.0
_ROWS: Final = 8
_LEAST_ROWS: Final = 5
_ROWS_SHARE: Final = 0.58


class Size(NamedTuple):
    """Room for the results, in pixels."""

    width: float = 650.0
    height: float = _USUAL_HEIGHT
    """Of the whole panel."""

    @property
    def plot_px(self) -> float:
        """Height of a chart within its axes."""
        more = self.height - _USUAL_HEIGHT
        return max(_PLOT_PX + _PLOT_SHARE * more, _LEAST_PLOT_PX)

    @property
    def rows(self) -> int:
        """Runs on a page of the table."""
        more = self.height - _USUAL_HEIGHT
        return max(_ROWS + math.floor(_ROWS_SHARE * more / _ROW_PX), _LEAST_ROWS)


Chart = Literal["curves", "runs", "plane"]
COLUMNS: Final = (
    *("variant", "seed", "value"),
    *(metric.column for metric in IN_TABLE),
    *("seconds", "digest"),
)
"""Of the table of runs, whose value is that of the metric that is charted."""


@dataclass(frozen=True)
class View:
    """What somebody looks at."""

    chart: Chart
    axis: Axis = "steps"
    """What curves are drawn against."""
    windows: Windows = "steps"
    """What their windows are counted in, where that is steps."""
    metric: str = ""
    """Column of what dots and cells show; empty for what the experiment asks for first."""
    variant: int | None = None
    """Place of the one that is chosen: it stands out in charts, and the table lists its runs."""
    order: str = "variant"
    """The one of :data:`COLUMNS` by which the table is sorted."""
    descending: bool = False
    page: int = 0
    """Of the table, from 0."""


def charted(gathering: Gathering) -> Sequence[Metric]:
    """What dots and cells can show of an experiment: how well its learners did."""
    return [metric for metric in of_kind("performance") if _is_measured(metric, gathering)]


def tabled(gathering: Gathering) -> Sequence[Metric]:
    """What the table of its runs can show."""
    return [metric for metric in IN_TABLE if _is_measured(metric, gathering)]


def _is_measured(metric: Metric, gathering: Gathering) -> bool:
    horizon = gathering.horizon
    if metric.is_at_horizon and not (
        horizon and (horizon.is_stated or not wants_greedy([metric.column]))
    ):
        # Where a horizon is found afterwards, no greedy hunts were made there.
        return False
    return metric.kind == "length" or metric.column in gathering.experiment.metrics


def first_view(experiment: Experiment) -> View:
    """Curves of a few variants, the plane of two settings, else all runs."""
    if len(experiment.variants) <= MOST_CURVES:
        return View("curves")
    sweep = swept(experiment)
    return View("plane" if sweep is not None and len(sweep.axles) == 2 else "runs")


def answer(view: View, words: str, gathering: Gathering, rows: int) -> View:
    """The view after a click on a link with these words; the same if they make no sense.

    Args:
        view: what was looked at.
        words: what the link says.
        gathering: the runs that there are.
        rows: on a page of the table.
    """
    verb, _, what = words.partition("/")
    if verb == "chart":
        return _with_chart(view, what, gathering.experiment)
    if verb == "axis":
        return next((replace(view, axis=axis) for axis in get_args(Axis) if axis == what), view)
    if verb == "windows":
        return replace(view, windows=what) if what in WINDOWS else view
    if verb == "metric":
        offered = {metric.column for metric in charted(gathering)}
        return replace(view, metric=what) if what in offered else view
    if verb == "variant":
        return _with_variant(view, what, len(gathering.experiment.variants))
    if verb == "order":
        return _with_order(view, what)
    if verb == "page":
        page = _place(what, n_pages(len(listed(gathering, view)), rows))
        return view if page is None else replace(view, page=page)
    return view


def _with_chart(view: View, what: str, experiment: Experiment) -> View:
    chart = next((chart for chart in get_args(Chart) if chart == what), None)
    if chart is None or (chart == "plane" and swept(experiment) is None):
        return view
    return replace(view, chart=chart)


def _with_variant(view: View, what: str, n_variants: int) -> View:
    place = _place(what, n_variants)
    if place is None and what != "all":
        return view
    return replace(view, variant=None if place == view.variant else place, page=0)


def _with_order(view: View, what: str) -> View:
    if what not in COLUMNS:
        return view
    return replace(view, order=what, descending=what == view.order and not view.descending, page=0)


_LONGEST_PLACE = 9
"""Digits of a number that could be a place; longer ones are not even read."""


def _place(text: str, n: int) -> int | None:
    """The whole number below a limit that a text says; None if it says none."""
    if not (text.isascii() and text.isdigit() and len(text) <= _LONGEST_PLACE):
        return None
    return int(text) if int(text) < n else None


def listed(gathering: Gathering, view: View) -> Sequence[PlacedRun]:
    """Runs in the table: those of the chosen variant, if one is."""
    if view.variant is None:
        return gathering.runs
    return [(place, run) for place, run in gathering.runs if place == view.variant]


def n_pages(n_runs: int, rows: int) -> int:
    """Pages of a table, of which there is always one."""
    return max(math.ceil(n_runs / rows), 1)
