"""The results of an experiment as one piece of HTML: choices, a chart, and the table of its runs.

Pure functions: a :class:`View` says what somebody looks at, :func:`results_html` shows it, and
:func:`answer` says what they look at after a click. Whatever a click says comes from the network,
so what makes no sense leaves the view as it is.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final, Literal, NamedTuple, get_args

import numpy as np

from app.analysis.estimates import Axis, Estimate
from app.analysis.sweeps import BETWEEN, Sweep, own_place, short_names, sweep_of
from app.charts import curves, sweeps
from app.charts.parts import (
    FAILED,
    LINK,
    Address,
    Context,
    link,
    shortened,
    shown_number,
    style_sheet,
)
from app.documents import presets
from app.documents.experiments import Experiment
from app.metrics import Metric, final_trials
from app.results.gather import MOST_CURVES, Gatherer, Gathering, RunFact
from app.util.html import escaped

MOST_CELLS: Final = 300
"""Cells of a plane, or points of a line, that can be told apart and clicked."""

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
Column = Literal["variant", "seed", "value", "success", "steps_to_70", "steps", "seconds", "digest"]


@dataclass(frozen=True)
class View:
    """What somebody looks at."""

    chart: Chart
    axis: Axis = "steps"
    """What curves are drawn against."""
    variant: int | None = None
    """Place of the one that is chosen: it stands out in charts, and the table lists its runs."""
    order: Column = "variant"
    descending: bool = False
    page: int = 0
    """Of the table, from 0."""


# --- What can be looked at -----------------------------------------------------------------------


@lru_cache(maxsize=2)
def swept(experiment: Experiment) -> Sweep | None:
    """What was swept, if all variants belong to one preset and fit into a plane or on a line."""
    variants = experiment.variants
    one_preset = len({variant.preset for variant in variants}) == 1
    if not one_preset or len(variants) > MOST_CELLS:
        return None
    found = sweep_of([v.overrides for v in variants], variants[0].spec.model_dump())
    if found is None or math.prod(len(axle.values) for axle in found.axles) > MOST_CELLS:
        return None
    return found


@lru_cache(maxsize=2)
def own_setting(experiment: Experiment) -> int | None:
    """Place of the variant with the shipped preset's own values of what was swept, if any."""
    sweep, variants = swept(experiment), experiment.variants
    shipped = presets.shipped_settings(variants[0].preset)
    if sweep is None or shipped is None:
        return None
    found = own_place(
        {at: variants[place].overrides for at, place in sweep.places.items()},
        {at: variants[place].spec.model_dump(mode="json") for at, place in sweep.places.items()},
        shipped,
    )
    return None if found is None else sweep.places[found]


@lru_cache(maxsize=2)
def in_short(experiment: Experiment) -> tuple[Experiment, str]:
    """An experiment whose variants have short labels, and what these are made of.

    Variants that set the same keys are told apart by the values of those that differ; the preset
    stays before them where there are several. Others keep their labels, and nothing is said.
    """
    variants = experiment.variants
    found = short_names(
        [variant.label for variant in variants],
        [variant.preset for variant in variants],
        [variant.overrides for variant in variants],
        variants[0].spec.model_dump(mode="json"),
    )
    if found is None:
        return experiment, ""
    named = tuple(
        replace(variant, label=name) for variant, name in zip(variants, found.of, strict=True)
    )
    return experiment.model_copy(update={"variants": named}), BETWEEN.join(found.what)


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
    if verb == "variant":
        return _with_variant(view, what, len(gathering.experiment.variants))
    if verb == "order":
        return _with_order(view, what)
    if verb == "page":
        page = _place(what, _n_pages(len(_listed(gathering, view)), rows))
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
    column = next((column for column in get_args(Column) if column == what), None)
    if column is None:
        return view
    return replace(
        view, order=column, descending=column == view.order and not view.descending, page=0
    )


_LONGEST_PLACE = 9
"""Digits of a number that could be a place; longer ones are not even read."""


def _place(text: str, n: int) -> int | None:
    """The whole number below a limit that a text says; None if it says none."""
    if not (text.isascii() and text.isdigit() and len(text) <= _LONGEST_PLACE):
        return None
    return int(text) if int(text) < n else None


# --- The whole -----------------------------------------------------------------------------------

_STYLE = (
    ".pounce-results{font-size:12.5px;line-height:1.4}"
    f".pounce-results a{{color:{LINK};text-decoration:none}}"
    ".pounce-results a:hover{text-decoration:underline}"
    f".pounce-results a:focus-visible{{outline:2px solid {LINK};outline-offset:1px}}"
    ".pounce-results .bar{display:flex;flex-wrap:wrap;gap:2px 18px;align-items:baseline}"
    ".pounce-results .bar .pager{margin-left:auto}"
    ".pounce-results .choice>*{margin-right:10px}"
    ".pounce-results .cross{padding:0 6px;font-weight:700}"
    ".pounce-results p{margin:6px 0}"
    ".pounce-results table{border-collapse:collapse;width:100%;table-layout:fixed;"
    "font-size:inherit;font-variant-numeric:tabular-nums}"
    ".pounce-results th,.pounce-results td{padding:2px 6px 2px 0;text-align:right;"
    "white-space:nowrap;overflow:hidden;text-overflow:ellipsis;font-weight:400}"
    ".pounce-results thead th{white-space:normal;vertical-align:bottom;"
    "border-bottom:1px solid currentColor}"
    ".pounce-results tbody td:has(>a){padding:0}"
    ".pounce-results tbody td>a{display:block;padding:2px 6px 2px 0;overflow:hidden;"
    "text-overflow:ellipsis}"
    ".pounce-results tbody td>a:hover{text-decoration:none}"
    ".pounce-results tbody td>a.plain{color:inherit}"
    ".pounce-results tbody tr:not(.failed):hover{background:rgba(128,128,128,.15)}"
    ".pounce-results .text{text-align:left}"
    f".pounce-results .failed td{{color:{FAILED}}}"
)


def results_html(
    gatherer: Gatherer, gathering: Gathering, view: View, address: Address, size: Size
) -> str:
    """Everything that is shown of the results.

    Args:
        gatherer: what knows averages.
        gathering: the runs that there are.
        view: what is looked at.
        address: what a link refers to, to call the lab with words.
        size: of the page's panel.
    """
    sweep, own = swept(gathering.experiment), own_setting(gathering.experiment)
    experiment, what = in_short(gathering.experiment)
    gathering = replace(gathering, experiment=experiment, metric=metric_of(gathering))
    parts = [_choices(experiment, view, sweep, address)]
    if not gathering.runs:
        parts.append("<p>No run is over yet.</p>")
    else:
        context = Context(gathering, address, size.width, view.variant, size.plot_px)
        parts.append(_chart(gatherer, context, view, sweep, own))
        if what:
            parts.append(f"<p>Variants are named by {escaped(what)}.</p>")
        parts += _table(gathering, view, address, size)
    return (
        f'<div class="pounce-results" style="max-width:{size.width:.0f}px">'
        f"<style>{_STYLE}{style_sheet()}</style>{''.join(parts)}</div>"
    )


def metric_of(gathering: Gathering) -> Metric:
    """The number that is charted, called as it is of runs as long as these."""
    return gathering.metric.of_runs(*_lengths(gathering.experiment))


def _lengths(experiment: Experiment) -> tuple[int, int]:
    """Trials of the shortest run that there can be, and of the longest."""
    trials = [experiment.trials_of(variant) for variant in experiment.variants]
    ends_earlier = experiment.stop is not None or experiment.steps is not None
    return 0 if ends_earlier else min(trials), max(trials)


def _choices(experiment: Experiment, view: View, sweep: Sweep | None, address: Address) -> str:
    names: dict[str, str] = {"curves": "Curves", "runs": "Runs"}
    if sweep is not None:
        names["plane"] = "Plane" if len(sweep.axles) == 2 else "Sweep"
    parts = [_choice("chart", names, view.chart, address)]
    if view.chart == "curves":
        axes = {"steps": "steps", "trials": "trials"}
        parts.append(f"<span>against {_choice('axis', axes, view.axis, address)}</span>")
    if view.variant is not None:
        label = experiment.variants[view.variant].label
        cross = link(
            address,
            "variant/all",
            "×",
            ' class="cross" title="choose none" aria-label="choose none"',
        )
        parts.append(
            f'<span title="{escaped(label)}">chosen: <b>{escaped(shortened(label, 50))}</b>'
            f" {cross}</span>"
        )
    return f'<div class="bar">{"".join(parts)}</div>'


def _choice(verb: str, names: dict[str, str], present: str, address: Address) -> str:
    """Links between which one chooses; the present choice is none, and bold."""
    parts = (
        f"<b>{name}</b>" if word == present else link(address, f"{verb}/{word}", name)
        for word, name in names.items()
    )
    return f'<span class="choice">{"".join(parts)}</span>'


# --- The chart -----------------------------------------------------------------------------------


def _chart(
    gatherer: Gatherer, context: Context, view: View, sweep: Sweep | None, own: int | None
) -> str:
    gathering = context.gathering
    if all(run.error for run in gathering.runs):
        return "<p>Every run that is over has failed.</p>"
    if view.chart == "curves":
        places = places_of_curves(len(context.variants), view.variant)
        found = [gatherer.curve(place, view.axis) for place in places]
        return curves.curves(context, found, view.axis)
    estimates = _estimates(gatherer, gathering)
    if view.chart == "runs" or sweep is None:
        return curves.runs(context, estimates)
    if len(sweep.axles) == 1:
        return sweeps.line(context, sweep, estimates)
    return sweeps.plane(context, sweep, estimates, own)


def places_of_curves(n_variants: int, chosen: int | None) -> Sequence[int]:
    """The first few variants; if the chosen one is not among them, it comes last."""
    first = range(min(n_variants, MOST_CURVES))
    return first if chosen is None or chosen in first else [*first[:-1], chosen]


def _estimates(gatherer: Gatherer, gathering: Gathering) -> Sequence[Estimate]:
    """Means of all variants, with intervals unless there are so many that these take seconds."""
    n_variants = len(gathering.experiment.variants)
    if n_variants <= MOST_CELLS:
        return [gatherer.estimate(place) for place in range(n_variants)]
    there = [run for run in gathering.runs if not run.error and math.isfinite(run.value)]
    places = np.asarray([run.variant for run in there], np.int64)
    values = np.asarray([run.value for run in there], np.float64)
    n = np.bincount(places, minlength=n_variants)
    totals = np.bincount(places, values, minlength=n_variants)
    means = np.divide(totals, n, out=np.full(n_variants, np.nan), where=n > 0)
    return [
        Estimate(mean, math.nan, math.nan, count)
        for mean, count in zip(means.tolist(), n.tolist(), strict=True)
    ]


# --- The table of runs ---------------------------------------------------------------------------


class _Head(NamedTuple):
    """A column of the table."""

    column: Column
    title: str
    hint: str
    width: int
    """In pixels; the first has what the others leave."""


def _heads(gathering: Gathering) -> Sequence[_Head]:
    metric, final = gathering.metric, final_trials(*_lengths(gathering.experiment))
    return (
        _Head("variant", "variant", "", 0),
        _Head("seed", "seed", "", 54),
        _Head("value", metric.title, metric.label, 76),
        _Head("success", "success", f"captures in per cent, {final}", 60),
        _Head(
            "steps_to_70",
            "M steps to 70\N{NO-BREAK SPACE}%",
            "steps until 70 % of the last 500 trials end in a capture, in millions",
            82,
        ),
        _Head("steps", "M steps", "simulation steps in millions", 62),
        _Head("seconds", "seconds", "that the run took", 60),
        _Head("digest", "digest", "of the learned tables: equal ones learned the same", 70),
    )


_MOST_STRETCH = 1.5
"""Of columns in a wide table."""


def _table(gathering: Gathering, view: View, address: Address, size: Size) -> list[str]:
    listed = _in_order(_listed(gathering, view), gathering.experiment, view)
    page = min(view.page, _n_pages(len(listed), size.rows) - 1)
    first = page * size.rows
    stretch = min(max(size.width / Size().width, 1), _MOST_STRETCH)
    heads = [head._replace(width=round(head.width * stretch)) for head in _heads(gathering)]
    label_px = size.width - sum(head.width for head in heads) - _OPEN_PX
    head = "".join(_head(head, view, address) for head in heads)
    rows = "".join(
        _row(run, gathering.experiment.variants[run.variant].label, address, label_px)
        for run in listed[first : first + size.rows]
    )
    columns = "".join(f'<col style="width:{head.width}px"/>' for head in heads[1:])
    return [
        f'<div class="bar"><b>Runs</b>{_pager(len(listed), page, address, size.rows)}</div>',
        f'<table><colgroup><col/>{columns}<col style="width:{_OPEN_PX}px"/></colgroup>'
        f"<thead><tr>{head}<th></th></tr></thead><tbody>{rows}</tbody></table>",
    ]


def _listed(gathering: Gathering, view: View) -> Sequence[RunFact]:
    if view.variant is None:
        return gathering.runs
    return [run for run in gathering.runs if run.variant == view.variant]


def _n_pages(n_runs: int, rows: int) -> int:
    return max(math.ceil(n_runs / rows), 1)


def _in_order(listed: Sequence[RunFact], experiment: Experiment, view: View) -> list[RunFact]:
    """Runs by a column, and where that is the same by place and seed; without a value come last."""
    by_place = sorted(listed, key=lambda run: (run.variant, run.seed, run.key))
    if view.order == "variant":
        # As the experiment has them, which is an order of its values.
        if not view.descending:
            return by_place
        return sorted(by_place, key=lambda run: -run.variant)
    keyed = [(_sort_value(run, view.order), run) for run in by_place]
    there = [pair for pair in keyed if pair[0] is not None]
    there.sort(key=lambda pair: pair[0], reverse=view.descending)
    return [run for _, run in there] + [run for value, run in keyed if value is None]


def _sort_value(run: RunFact, column: Column) -> Any:
    """What a run is sorted by; None if it has nothing there."""
    if column == "seed":
        return run.seed
    if run.error:
        return None
    value = getattr(run, column)
    is_missing = isinstance(value, float) and math.isnan(value)
    return None if is_missing or value == "" else value


def _head(head: _Head, view: View, address: Address) -> str:
    arrow, sort = "", ""
    if head.column == view.order:
        arrow = "\N{NO-BREAK SPACE}" + ("▼" if view.descending else "▲")
        sort = f' aria-sort="{"descending" if view.descending else "ascending"}"'
    title = f' title="{escaped(head.hint or head.title)}: sort"'
    text = link(address, f"order/{head.column}", f"{escaped(head.title)}{arrow}", title)
    is_text = ' class="text"' if head.column == "variant" else ""
    return f'<th scope="col"{is_text}{sort}>{text}</th>'


_OPEN_PX = 50
_CHARACTER_PX = 7.6
_LONGEST_ERROR, _LONGEST_HINT = 100, 400


def _row(run: RunFact, label: str, address: Address, label_px: float) -> str:
    name = escaped(shortened(label, max(int(label_px / _CHARACTER_PX), 8)))
    hint = escaped(label)
    if run.error:
        error, whole_error = (
            escaped(run.error if len(run.error) <= most else f"{run.error[:most]}…")
            for most in (_LONGEST_ERROR, _LONGEST_HINT)
        )
        return (
            f'<tr class="failed"><td class="text" title="{hint}">{name}</td>'
            f'<td title="{run.seed}">{run.seed}</td>'
            f'<td class="text" colspan="7" title="{whole_error}">failed: {error}</td></tr>'
        )
    words = f"open/{run.key}"
    opened = link(address, words, name, f' title="{hint}: open this run in the lab"')
    # The whole row does the same, which those who go by keyboard need not pass nine times.
    again = ' tabindex="-1"'
    seed = link(address, words, str(run.seed), f'{again} class="plain" title="{run.seed}"')
    opens = link(address, words, "open ▸", f'{again} title="open this run in the lab"')
    cells = (
        shown_number(run.value, 4),
        "–" if math.isnan(run.success) else f"{100 * run.success:.0f} %",
        _reached(run.steps_to_70),
        f"{run.steps / 1e6:.2f}",
        "–" if math.isnan(run.seconds) else f"{run.seconds:.1f}",
        escaped(run.digest[:8]),
    )
    links = [
        seed,
        *(link(address, words, cell, f'{again} class="plain"') for cell in cells),
        opens,
    ]
    others = "".join(f"<td>{content}</td>" for content in links)
    return f'<tr><td class="text">{opened}</td>{others}</tr>'


def _reached(steps: float) -> str:
    """Steps in millions; where it was not measured, a dash."""
    if math.isnan(steps):
        return "–"
    return "never" if math.isinf(steps) else f"{steps / 1e6:.2f}"


def _pager(n_runs: int, page: int, address: Address, rows: int) -> str:
    """Which runs are shown, and the way to others."""
    n_pages = _n_pages(n_runs, rows)
    first, last = page * rows + 1, min((page + 1) * rows, n_runs)
    span = f"{first:,}–{last:,} of {n_runs:,}" if n_runs else "none yet"
    if n_pages == 1:
        return f'<span class="pager">{span}</span>'
    near = range(max(page - 1, 0), min(page + 2, n_pages))
    numbers = sorted({0, *near, n_pages - 1})
    parts = [_step(page - 1, n_pages, "◂", "previous page", address)]
    for number, before in zip(numbers, [-1, *numbers], strict=False):
        if number > before + 1:
            parts.append("<span>…</span>")
        name = f"{number + 1:,}"
        parts.append(f"<b>{name}</b>" if number == page else link(address, f"page/{number}", name))
    parts.append(_step(page + 1, n_pages, "▸", "next page", address))
    return f'<span class="pager choice"><span>{span}</span>{"".join(parts)}</span>'


def _step(page: int, n_pages: int, sign: str, name: str, address: Address) -> str:
    if not 0 <= page < n_pages:
        return f'<span style="opacity:.35">{sign}</span>'
    return link(address, f"page/{page}", sign, f' title="{name}" aria-label="{name}"')
