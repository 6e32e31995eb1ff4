"""The results of an experiment as one piece of HTML: choices, a chart, and the table of its runs.

Pure functions. Every link calls the lab with words: ``variant/PLACE`` chooses a variant,
``open/KEY`` opens a run, the others are those of :func:`app.charts.view.answer`.
"""

from typing import Final

from app.analysis.estimates import WINDOWS
from app.charts import live, variants
from app.charts.differences import differences_of
from app.charts.model import Curves, Dots, Plane
from app.charts.page.colours import FAILED, LINK, style_sheet
from app.charts.page.curves import curves_html
from app.charts.page.differences import differences_html
from app.charts.page.plane import plane_html
from app.charts.page.points import points_html
from app.charts.page.runs import runs_html
from app.charts.page.svg import Address, Frame, link
from app.charts.page.table import table_html
from app.charts.view import Size, View, charted
from app.charts.wording import short_label
from app.results.gather import Gatherer, Gathering
from app.util.html import escaped

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
    ".pounce-results .differences{margin:6px 0 8px}"
    ".pounce-results .differences .text{padding-left:8px}"
    ".pounce-results .differences .text:first-child{padding-left:0}"
    f".pounce-results .failed td{{color:{FAILED}}}"
)


_SEARCHED: Final = (
    "<p>Values were drawn at random. What each setting does, and what pairs of them do beyond that,"
    " is in the report: <code>pounce report</code> with the folder of these results.</p>"
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
    gathering, what = live.looked_at(gathering, view)
    parts = [_choices(gatherer, gathering, view, address)]
    if not gathering.runs:
        parts.append("<p>No run is over yet.</p>")
    else:
        parts.append(_chart(gatherer, gathering, view, address, size))
        if what:
            parts.append(f"<p>Variants are named by {escaped(what)}.</p>")
        if gathering.experiment.n_drawn:
            parts.append(_SEARCHED)
        found = differences_of(gatherer, gathering, view.variant)
        if found is not None:
            parts.append(differences_html(found, size.width))
        parts.append(table_html(gathering, view, address, size))
    return (
        f'<div class="pounce-results" style="max-width:{size.width:.0f}px">'
        f"<style>{_STYLE}{style_sheet()}</style>{''.join(parts)}</div>"
    )


def _chart(
    gatherer: Gatherer, gathering: Gathering, view: View, address: Address, size: Size
) -> str:
    if all(run.error for _, run in gathering.runs):
        return "<p>Every run that is over has failed.</p>"
    chart = live.chart_of(gatherer, gathering, view)
    left_out = live.left_out(gathering, chart)
    frame = Frame(address, size.width, view.variant, size.plot_px, left_out)
    match chart:
        case Curves():
            return curves_html(chart, frame)
        case Dots():
            return runs_html(chart, frame)
        case Plane():
            return plane_html(chart, frame)
        case _:
            return points_html(chart, frame)


def _choices(gatherer: Gatherer, gathering: Gathering, view: View, address: Address) -> str:
    experiment = gathering.experiment
    names: dict[str, str] = {"curves": "Curves", "runs": "Runs"}
    sweep = variants.swept(experiment)
    if sweep is not None:
        names["plane"] = "Plane" if len(sweep.axles) == 2 else "Sweep"
    parts = [_choice("chart", names, view.chart, address)]
    if view.chart == "curves":
        axes = {"steps": "steps", "trials": "trials"}
        parts.append(f"<span>against {_choice('axis', axes, view.axis, address)}</span>")
        if view.axis == "steps":
            widths = {each: f"{gatherer.width('steps', each):,} {each}" for each in WINDOWS}
            choice = _choice("windows", widths, view.windows, address)
            parts.append(f"<span>in windows of {choice}</span>")
    else:
        metrics = [live.called(metric, gathering) for metric in charted(gathering)]
        shown = {m.column: m.in_table.title if m.in_table else m.title for m in metrics}
        if len(shown) > 1:
            parts.append(
                f"<span>of {_choice('metric', shown, gathering.metric.column, address)}</span>"
            )
    if view.variant is not None:
        label = experiment.variants[view.variant].label
        cross = link(
            address,
            "variant/all",
            "×",
            ' class="cross" title="choose none" aria-label="choose none"',
        )
        parts.append(
            f'<span title="{escaped(label)}">chosen: <b>{escaped(short_label(label, 50))}</b>'
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
