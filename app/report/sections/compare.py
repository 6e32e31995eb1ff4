"""Sections of a report on two folders of results, of which one is set against the other."""

import json
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace

from app.analysis import estimates
from app.analysis.axles import grouped
from app.analysis.estimates import Axis, Windows, bootstrap_rng
from app.analysis.passages import Passage, later
from app.analysis.sweeps import differing
from app.charts.model import Dot, Dots, Panel, with_clear_marks
from app.charts.paper.drawing import drawn
from app.charts.read import line_of
from app.charts.styles import style_of
from app.charts.wording import shown_estimate
from app.metrics import PASSAGES, Metric
from app.report.document import Page, table
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
    pairing_cell,
    reached_cell,
    scalar_cell,
)
from app.report.sections.stops import write_stops
from app.results.read import Folder, Group, Reader, ResultsError, groups_of
from app.util.html import Markup, element, joined
from app.words.numbers import counted

Pair = tuple[Group, Group]

_MOST_KEYS = 10


# --- Variants that belong together ---------------------------------------------------------------


def pairs_of(first: Sequence[Group], second: Sequence[Group]) -> tuple[list[Pair], list[Group]]:
    """Variants of two folders that belong together, and those left alone.

    They do if preset and overrides agree; else if all settings do, however they came about; else
    if the overrides do; else if they have the same label. Each time only where no other variant
    has the same.
    """
    pairs: list[Pair] = []
    left, right = first, second
    for key_of in (_full_key, _spec_key, _overrides_key, _label_of):
        mine, theirs = ([(key_of(group), group) for group in side] for side in (left, right))
        alike = _single(mine) & _single(theirs)
        partners = dict(theirs)
        pairs += [(group, partners[key]) for key, group in mine if key in alike]
        left, right = (
            [group for key, group in side if key not in alike] for side in (mine, theirs)
        )
    return pairs, [*left, *right]


def _single(keyed: Iterable[tuple[str, Group]]) -> set[str]:
    """Keys that a single group has."""
    return {key for key, n in Counter(key for key, _ in keyed).items() if n == 1}


def _full_key(group: Group) -> str:
    return json.dumps([group.preset, group.overrides], sort_keys=True)


def _spec_key(group: Group) -> str:
    settings = group.runs[0].settings
    return json.dumps({**settings, "description": ""}, sort_keys=True)


def _overrides_key(group: Group) -> str:
    return json.dumps(group.overrides, sort_keys=True)


def _label_of(group: Group) -> str:
    return group.label


# --- What differs --------------------------------------------------------------------------------


def write_comparison(
    page: Page, reader: Reader, first: Folder, second: Folder, shown: Shown
) -> None:
    """Write sections on how much higher the second folder's runs are than the first's.

    Args:
        page: to write on.
        reader: of their logs.
        first: A.
        second: B.
        shown: the numbers that are compared.

    Raises:
        ResultsError: the folders have no variant in common.
    """
    pairs, alone = pairs_of(groups_of(first.rows), groups_of(second.rows))
    if not pairs:
        raise ResultsError(
            f"{str(first.path)!r} and {str(second.path)!r} have no variant in common;"
            " allowed: folders whose variants set the same keys to the same values, or have the"
            " same labels"
        )
    both = [
        replace(group, label=f"{side}: {group.label}")
        for pair in pairs
        for side, group in zip("AB", pair, strict=True)
    ]
    write_stops(page, reader, both)
    against = [Against(_pair_name(pair), _compared(pair, shown.first).difference) for pair in pairs]
    lead_with_differences(page, "A", against, shown.first, "variants of B")
    picture = _comparison_picture(page, pairs, shown.first)
    rules = [MEANS_RULE, DIFFERENCES_RULE, _SAMPLES_RULE, CHANCE_RULE]
    if any(group.passages(name) for pair in pairs for group in pair for name in PASSAGES):
        rules += [REACHED_RULE, STEPS_DIFFERENCES_RULE]
    page.say(
        "Difference B \N{MINUS SIGN} A",
        picture,
        element("p", " ".join(rules)),
        *_comparison_tables(page, pairs, shown.every),
    )
    for number, pair in enumerate(pairs[:MOST_LINES], 1):
        _pair_curves(page, reader, number, pair)
    if alone:
        names = element("ul", joined(element("li", group.label) for group in alone))
        page.say("In one folder only", names)


_SAMPLES_RULE = (
    "A and B are over the seeds that their difference is over, n of them, if it is paired, and"
    " else over all runs that each of them has."
)


def _pair_name(pair: Pair) -> str:
    first, second = pair
    return first.label if first.label == second.label else f"{first.label} / {second.label}"


def _compared(pair: Pair, metric: Metric) -> estimates.Comparison:
    before, after = (group.by_seed(metric.column) for group in pair)
    return estimates.compare(after, before, bootstrap_rng())


def _comparison_picture(page: Page, pairs: Sequence[Pair], metric: Metric) -> Markup:
    dots = [Dot(_pair_name(pair), _compared(pair, metric).difference) for pair in pairs[:MOST_ROWS]]
    what = f"B \N{MINUS SIGN} A: {metric.label}"
    small = page.small_print(
        "Difference of means over n pairs of runs of the same seed, or over all runs where too"
        f" few have a partner. {bars_note(dot.estimate for dot in dots)}"
    )
    drawing = drawn("difference", Dots({what: dots}, differences=[what]), small)
    return page.picture("difference", what, drawing)


def _comparison_tables(
    page: Page, pairs: Sequence[Pair], metrics: Sequence[Metric]
) -> list[Markup]:
    header = (
        "quantity",
        "A",
        "B",
        "B \N{MINUS SIGN} A [95 %]",
        "P(B > A) [95 %]",
        "n",
        "paired",
    )
    tables = []
    for number, pair in enumerate(pairs[:MOST_ROWS], 1):
        page.tell(f"comparing variants: {number} of {len(pairs)}")
        rows: list[Sequence[object]] = []
        for metric in metrics:
            found = _compared(pair, metric)
            values = _samples(pair, metric.column, found.paired)
            if found.difference.n:
                rows.append(
                    (
                        metric.label,
                        *map(scalar_cell, values),
                        difference_cell(pair[1], pair[0], metric.column, found.difference),
                        chance_cell(found),
                        found.difference.n if found.paired else " and ".join(map(_n, values)),
                        pairing_cell(found),
                    )
                )
        rows += [_steps_row(pair, name) for name in PASSAGES if all(_measured(pair, name))]
        text = element("p", _identical(pair), class_="minor")
        unlike = _unlike(pair)
        differing = element("p", unlike) if unlike else Markup()
        tables.append(
            joined([element("h3", _pair_name(pair)), differing, table(header, rows), text])
        )
    return tables


def _samples(pair: Pair, column: str, paired: bool) -> tuple[list[float], list[float]]:
    """Values of A and of B: of the seeds that a paired difference is over, else all."""
    before, after = (
        {seed: value for seed, value in group.by_seed(column).items() if not math.isnan(value)}
        for group in pair
    )
    if not paired:
        return [*before.values()], [*after.values()]
    shared = [seed for seed in before if seed in after]
    return [before[seed] for seed in shared], [after[seed] for seed in shared]


def _measured(pair: Pair, passage: str) -> Iterable[bool]:
    return (bool(group.passages(passage)) for group in pair)


def _steps_row(pair: Pair, name: str) -> Sequence[object]:
    """A row on the steps until something was reached."""
    before, after = (group.passages(name) for group in pair)
    found = later(after, before, bootstrap_rng())
    values: list[list[Passage]] = [
        [passage for seed, passage in mine.items() if not found.paired or seed in theirs]
        for mine, theirs in ((before, after), (after, before))
    ]
    return (
        PASSAGES[name],
        *map(reached_cell, values),
        shown_estimate(found.difference),
        chance_cell(found),
        found.difference.n if found.paired else " and ".join(map(_n, values)),
        pairing_cell(found),
    )


def _n(values: Sequence[object]) -> str:
    return str(len(values))


def _unlike(pair: Pair) -> str:
    """In which settings A and B differ, and how; empty if they do not."""
    first, second = pair
    found = differing(first.runs[0].settings, second.runs[0].settings)
    if first.preset != second.preset:
        found.insert(0, ("preset", first.preset, second.preset))
    if not found:
        return ""
    shown = [f"{key} (A: {grouped(a)}, B: {grouped(b)})" for key, a, b in found[:_MOST_KEYS]]
    more = f"; and {len(found) - len(shown)} more" if len(found) > len(shown) else ""
    return f"A and B differ in their settings: {'; '.join(shown)}{more}."


def _identical(pair: Pair) -> str:
    digests = [{run.seed: run.digest for run in group.runs if run.digest} for group in pair]
    shared = [seed for seed in digests[0] if seed in digests[1]]
    same = sum(digests[0][seed] == digests[1][seed] for seed in shared)
    are = "is" if len(shared) == 1 else "are"
    return (
        f"{counted(len(shared), 'seed')} {are} in both; {same} of these runs are alike digest for"
        " digest."
    )


def _pair_curves(page: Page, reader: Reader, number: int, pair: Pair) -> None:
    def panels(axis: Axis, windows: Windows) -> list[Panel]:
        lines = [
            line_of(reader, f"{side}: {group.label}", group.runs, axis, style_of(index), windows)
            for index, (side, group) in enumerate(zip("AB", pair, strict=True))
        ]
        return [Panel(_pair_name(pair), with_clear_marks(lines))]

    name = f"pair_{number}"
    caption = f"Reward in A and B: {_pair_name(pair)}"
    page.say(_pair_name(pair), curve_pictures(page, reader, name, caption, panels))
