"""Sections of a report on variants as they come: curves, numbers, and each beside the first."""

import math
from collections.abc import Callable, Sequence

from app.analysis import estimates
from app.analysis.estimates import Axis, Comparison, Windows, bootstrap_rng
from app.analysis.passages import later
from app.charts.model import NOTHING, Dot, Dots, Panel, RunDot, with_clear_marks
from app.charts.paper.drawing import drawn
from app.charts.read import line_of
from app.charts.styles import style_of
from app.charts.wording import shown_estimate
from app.metrics import AT_HORIZON, BY_COLUMN, PASSAGES, Metric, at_steps
from app.report.document import Page, details, table
from app.report.headline import Against, lead_with_differences
from app.report.parts import (
    CHANCE_RULE,
    DIFFERENCES_RULE,
    MEANS_RULE,
    MOST_LINES,
    MOST_ROWS,
    REACHED_RULE,
    STEPS_DIFFERENCES_RULE,
    Shown,
    bars_note,
    chance_cell,
    curve_pictures,
    difference_cell,
    left_out,
    mean_cell,
    pairing_cell,
    reached_cell,
    scalar_cell,
)
from app.report.sections.passages import passages_picture
from app.results.read import (
    Group,
    Reader,
    measured,
)
from app.results.reference import Setting, reference_of, told_of
from app.util.html import Markup, element, joined
from app.words.numbers import NONE

_MOST_OPEN_ROWS = 16


def write_curves(
    page: Page, reader: Reader, groups: Sequence[Group], metric: Metric, naming: str
) -> None:
    """Curves of all variants, or of a few where they are too many for a picture."""
    shown = _told_of(groups, metric)

    def panels(axis: Axis, windows: Windows) -> list[Panel]:
        lines = [
            line_of(reader, group.label, group.runs, axis, style_of(index), windows)
            for index, group in enumerate(shown)
        ]
        return [Panel("", with_clear_marks(lines))]

    caption, notes = "Reward of each variant", [naming] if naming else []
    if len(shown) < len(groups):
        base = groups[_reference(groups)].label
        caption = f"Reward of {len(shown)} of {len(groups)} variants"
        notes.insert(
            0,
            f"Shown: {base}, and others from the lowest to the highest {metric.title} (mean over"
            " runs), spread evenly by rank; to be the highest of many is luck in part.",
        )
    curves = curve_pictures(page, reader, "curves", caption, panels, " ".join(notes))
    page.say("Learning curves", curves)


def write_passages(page: Page, groups: Sequence[Group], metric: Metric, naming: str) -> None:
    """How soon variants got somewhere, those of which curves are drawn; nothing if unmeasured."""
    variants = [
        (group.label, group.runs, style_of(index))
        for index, group in enumerate(_told_of(groups, metric))
    ]
    caption = "Share of the runs of each variant that have got there"
    picture = passages_picture(page, "passages", caption, variants, naming)
    if picture:
        page.say("How soon it is reached", picture)


def _told_of(groups: Sequence[Group], metric: Metric) -> list[Group]:
    """As many variants as a picture takes, in their own order."""
    every = [[v for v in group.values(metric.column) if math.isfinite(v)] for group in groups]
    means = [sum(values) / len(values) if values else math.nan for values in every]
    return [groups[place] for place in told_of(means, _reference(groups), MOST_LINES)]


def write_scalars(page: Page, groups: Sequence[Group], shown: Shown, naming: str) -> None:
    """Numbers of all variants, averaged over their runs."""
    page.tell("averaging scalars")
    there = [metric for metric in shown.every if measured(groups, metric.column)]
    passages = [name for name in PASSAGES if any(group.passages(name) for group in groups)]
    rule = f"{MEANS_RULE} {REACHED_RULE}" if passages else MEANS_RULE
    how_well, how, endings, length = (
        [metric for metric in there if metric.kind == kind]
        for kind in ("performance", "behaviour", "endings", "length")
    )
    some = groups[:MOST_ROWS]
    by_horizon = [metric for metric in how_well if BY_COLUMN[metric.column].is_at_horizon]
    finals = [metric for metric in how_well if metric not in by_horizon]
    at = AT_HORIZON if shown.horizon is None else at_steps(shown.horizon)
    tables = joined(
        [
            _titled("After the preset's trials", _scalar_table(some, finals, scalar_cell, ())),
            _titled(f"{at[:1].upper()}{at[1:]}", _scalar_table(some, by_horizon, scalar_cell, ())),
            _titled("How it went", _scalar_table(some, how, mean_cell, passages)),
            _titled("How trials ended", _scalar_table(some, endings, mean_cell, ())),
            _titled("How long runs were", _scalar_table(some, length, mean_cell, ())),
            left_out(len(groups)),
        ]
    )
    if len(groups) > _MOST_OPEN_ROWS:
        tables = details(f"The scalars of {len(some)} variants", tables)
    page.say("Scalars", element("p", f"{rule} {naming}".strip()), tables)


def _titled(title: str, content: Markup) -> Markup:
    """A table below its title; nothing where there is none."""
    return joined([element("h3", title), content]) if content else content


def _scalar_table(
    groups: Sequence[Group],
    metrics: Sequence[Metric],
    cell: Callable[[Sequence[float]], Markup],
    passages: Sequence[str],
) -> Markup:
    """Numbers of each variant; nothing where none of them was measured."""
    titles = [*(PASSAGES[name] for name in passages), *(metric.label for metric in metrics)]
    if not titles:
        return Markup()
    rows = [
        (
            group.label,
            len(group.runs),
            *(reached_cell([*group.passages(name).values()]) for name in passages),
            *(cell(group.values(metric.column)) for metric in metrics),
        )
        for group in groups
    ]
    return table(("variant", "n", *titles), rows)


def write_variants(page: Page, groups: Sequence[Group], shown: Shown, naming: str) -> None:
    """Variants beside the first that is a preset as it is, or beside the first of all."""
    page.tell("setting variants beside one another")
    base, *others = with_reference_first(groups)[:MOST_ROWS]
    metric = shown.first
    first = base.by_seed(metric.column)
    found = [
        (group, estimates.compare(group.by_seed(metric.column), first, bootstrap_rng()))
        for group in others
    ]
    difference = f"{metric.title}: difference to {base.label}"
    against = [Against(group.label, compared.difference) for group, compared in found]
    lead_with_differences(page, base.label, against, metric)
    page.say(
        "Variants beside one another",
        _ablation_picture(page, base, found, metric, difference, naming),
        element("p", f"{MEANS_RULE} {DIFFERENCES_RULE} {CHANCE_RULE}"),
        _ablation_table(base, found, metric, difference),
        _other_differences(base, others, shown),
        left_out(len(groups)),
    )


def with_reference_first(groups: Sequence[Group]) -> list[Group]:
    """Variants, first the one that the others are set against."""
    place = _reference(groups)
    return [groups[place], *groups[:place], *groups[place + 1 :]]


def _reference(groups: Sequence[Group]) -> int:
    """The place of the variant that the others are set against."""
    return reference_of(
        Setting(group.runs[0].preset_name, group.overrides, group.runs[0].settings)
        for group in groups
    )


def _other_differences(base: Group, others: Sequence[Group], shown: Shown) -> Markup:
    """How far variants differ from the first one in what is not drawn."""
    some = others[:_MOST_OPEN_ROWS]
    rows: list[Sequence[object]] = []
    for metric in shown.every:
        first = base.by_seed(metric.column)
        if metric != shown.first and any(map(math.isfinite, first.values())):
            for group in some:
                found = estimates.compare(group.by_seed(metric.column), first, bootstrap_rng())
                rows.append((metric.label, group.label, *_difference_cells(found)))
    for name, title in PASSAGES.items():
        first = base.passages(name)
        for group in some:
            passages = group.passages(name)
            if first and passages:
                found = later(passages, first, bootstrap_rng())
                rows.append((title, group.label, *_difference_cells(found)))
    if not rows:
        return Markup()
    header = (
        "quantity",
        "variant",
        f"difference to {base.label} [95 %]",
        "P(variant higher) [95 %]",
        "n",
        "paired",
    )
    rule = element("p", STEPS_DIFFERENCES_RULE)
    fewer = f" of the first {len(some)} variants" if len(some) < len(others) else ""
    summary = f"Differences{fewer} in the other quantities"
    return details(summary, joined([rule, table(header, rows)]))


def _difference_cells(found: Comparison) -> Sequence[object]:
    estimate = found.difference
    return shown_estimate(estimate), chance_cell(found), estimate.n, pairing_cell(found)


def _ablation_picture(
    page: Page,
    base: Group,
    others: Sequence[tuple[Group, Comparison]],
    metric: Metric,
    difference: str,
    naming: str,
) -> Markup:
    every = [base, *(group for group, _ in others)]
    columns = {
        metric.label: [_dot_of(group, metric.column) for group in every],
        difference: [
            Dot(base.label, NOTHING),
            *(Dot(group.label, compared.difference) for group, compared in others),
        ],
    }
    small = page.small_print(
        f"Mean over n runs (seeds). {bars_note(dot.estimate for dot in columns[metric.label])} Pale"
        " dots: single runs. Differences are to"
        f" {base.label}, and paired by seed where enough are shared. {naming}".strip()
    )
    drawing = drawn("variants", Dots(columns, differences=[difference]), small)
    return page.picture("variants", f"{metric.label} of each variant", drawing)


def _dot_of(group: Group, column: str) -> Dot:
    mean = estimates.mean(group.values(column), bootstrap_rng())
    return Dot(group.label, mean, [RunDot(run.values[column], run.seed) for run in group.runs])


def _ablation_table(
    base: Group, others: Sequence[tuple[Group, Comparison]], metric: Metric, difference: str
) -> Markup:
    column = metric.column
    header = (
        "variant",
        f"{metric.label} [95 %]",
        f"{difference} [95 %]",
        "P(variant higher) [95 %]",
        "n of the difference",
        "paired",
    )
    rows = [
        (
            group.label,
            scalar_cell(group.values(column)),
            difference_cell(group, base, column, compared.difference),
            chance_cell(compared),
            compared.difference.n,
            pairing_cell(compared),
        )
        for group, compared in others
    ]
    of_base = (base.label, scalar_cell(base.values(column)), NONE, NONE, NONE, NONE)
    return table(header, [of_base, *rows])
