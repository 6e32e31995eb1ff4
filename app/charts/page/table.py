"""The table of runs on the page, whose rows open them."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter
from typing import Any, Final

from app.analysis.passages import arrivals
from app.charts.live import called
from app.charts.page.svg import Address, link
from app.charts.view import Size, View, listed, n_pages, tabled
from app.charts.wording import short_label
from app.experiments.record import Record
from app.metrics import Metric
from app.results.gather import Gathering, PlacedRun
from app.results.read import passages_of
from app.util.html import escaped
from app.words.numbers import NONE, shared_form, shown_number


@dataclass(frozen=True)
class _Head:
    """A column of the table."""

    column: str
    """One of :data:`app.charts.view.COLUMNS`."""
    title: str
    hint: str
    width: int
    """In pixels; the first has what the others leave."""
    value: Callable[[Record], Any]
    """What runs are sorted by."""
    text: Callable[[Record], str]
    """What is written, as HTML."""


_LEAST_LABEL_PX: Final = 100
"""For the name of a variant, before there are further columns; for long names it is more, ..."""
_MOST_LABEL_SHARE: Final = 0.42
"""... up to this share of the width."""
_DIGITS: Final = 4
"""Of the largest value."""
_OPEN_PX: Final = 50
_CHARACTER_PX: Final = 7.0
_FIRST: Final = (
    *("final_reward", "final_greedy", "steps_to_70", "final_success"),
    *("horizon_reward", "horizon_area"),
)
"""Columns that are there where not all have room, the foremost first."""


def _heads(gathering: Gathering, width: float) -> Sequence[_Head]:
    """As many columns as there is room for, in their order."""
    charted = gathering.metric
    form = shared_form((run.values[charted.column] for _, run in gathering.runs), _DIGITS)
    heads = [
        _Head("variant", "variant", "", 0, attrgetter("variant"), lambda run: escaped(run.variant)),
        _Head("seed", "seed", "", 54, attrgetter("seed"), lambda run: str(run.seed)),
        _Head(
            *("value", charted.title, charted.label, 76),
            _value_of(charted.column),
            lambda run: shown_number(run.values[charted.column], form),
        ),
    ]
    metrics = [_head_of(metric, gathering) for metric in tabled(gathering)]
    digest = "of the learned tables: equal ones learned the same"
    last = [
        _Head(
            *("seconds", "seconds", "that the run took", 60),
            attrgetter("seconds"),
            lambda run: _seconds(run.seconds),
        ),
        _Head(
            *("digest", "digest", digest, 70),
            attrgetter("digest"),
            lambda run: escaped(run.digest[:8]),
        ),
    ]
    every = [*heads, *(head for head in metrics if head.column != charted.column), *last]
    always = {"variant", "seed", "value", "steps", "digest"}
    longest = max((len(v.label) for v in gathering.experiment.variants), default=0)
    label_px = min(longest * _CHARACTER_PX + 8, _MOST_LABEL_SHARE * width)
    room = width - _OPEN_PX - max(label_px, _LEAST_LABEL_PX)
    room -= sum(head.width for head in every if head.column in always)
    ranked = sorted((head for head in every if head.column not in always), key=_rank)
    for head in ranked:
        if head.width <= room:
            room -= head.width
            always.add(head.column)
    return [head for head in every if head.column in always]


def _rank(head: _Head) -> int:
    return _FIRST.index(head.column) if head.column in _FIRST else len(_FIRST)


def _head_of(metric: Metric, gathering: Gathering) -> _Head:
    shown = called(metric, gathering).in_table
    assert shown is not None
    column, text = metric.column, shown.text
    value: Callable[[Record], Any] = _value_of(column)
    if metric.kind == "passage":
        value, text = _passage_of(column), partial(_passage_text, text)
    return _Head(column, shown.title, shown.hint, shown.width, value, lambda run: text(value(run)))


def _value_of(column: str) -> Callable[[Record], float]:
    return lambda run: run.values[column]


def _passage_of(column: str) -> Callable[[Record], Any]:
    """Whether a run ended before it got somewhere, and its steps there: in this order they sort."""

    def value(run: Record) -> tuple[bool, float] | float:
        passage = passages_of([run], column).get(run.seed)
        return math.nan if passage is None else (passage.censored, passage.steps)

    return value


def _passage_text(text: Callable[[float], str], value: tuple[bool, float] | float) -> str:
    """Steps until something was reached; of a run that ended before, that it takes more."""
    if not isinstance(value, tuple):
        return text(value)
    censored, steps = value
    return f"{_MORE_THAN if censored else ''}{text(steps)}"


def _seconds(value: float) -> str:
    return NONE if math.isnan(value) else f"{value:.1f}"


_MORE_THAN = "&gt;\N{NO-BREAK SPACE}"
_MOST_MEDIANS = 8
"""Variants whose medians are told."""
_MEDIAN_CHARACTERS = 40
_MOST_STRETCH = 1.5
"""Of columns in a wide table."""


def table_html(gathering: Gathering, view: View, address: Address, size: Size) -> str:
    """A page of the table, with the way to its other pages."""
    stretch = min(max(size.width / Size().width, 1), _MOST_STRETCH)
    heads = [
        replace(head, width=round(head.width * stretch))
        for head in _heads(gathering, size.width / stretch)
    ]
    shown = _in_order(listed(gathering, view), view, heads)
    page = min(view.page, n_pages(len(shown), size.rows) - 1)
    first = page * size.rows
    label_px = size.width - sum(head.width for head in heads) - _OPEN_PX
    head = "".join(_head(head, view, address) for head in heads)
    rows = "".join(
        _row(run, heads, gathering.experiment.variants[place].label, address, label_px)
        for place, run in shown[first : first + size.rows]
    )
    columns = "".join(f'<col style="width:{head.width}px"/>' for head in heads[1:])
    return (
        f'<div class="bar"><b>Runs</b>{_pager(len(shown), page, address, size.rows)}</div>'
        f'<table class="runs"><colgroup><col/>{columns}<col style="width:{_OPEN_PX}px"/></colgroup>'
        f"<thead><tr>{head}<th></th></tr></thead><tbody>{rows}</tbody></table>{_medians(gathering)}"
    )


def _medians(gathering: Gathering) -> str:
    """Medians of the steps until something was reached, of variants that are not too many."""
    every = gathering.experiment.variants
    if len(every) > _MOST_MEDIANS:
        return ""
    told: list[str] = []
    for metric in tabled(gathering):
        if metric.kind != "passage" or metric.in_table is None:
            continue
        medians: list[str] = []
        for place, variant in enumerate(every):
            runs = [run for at, run in gathering.runs if at == place and not run.error]
            found = arrivals([*passages_of(runs, metric.column).values()])
            if found.n:
                beyond = math.isinf(found.median.value)
                steps = metric.in_table.text(found.last if beyond else found.median.value)
                name = escaped(short_label(variant.label, _MEDIAN_CHARACTERS))
                medians.append(f"{name} {_MORE_THAN if beyond else ''}{steps}")
        if medians:
            told.append(
                f"<p>Median {escaped(metric.in_table.title)}, runs that ended before counted until"
                f" then: {'; '.join(medians)}.</p>"
            )
    return "".join(told)


def _in_order(runs: Sequence[PlacedRun], view: View, heads: Sequence[_Head]) -> Sequence[PlacedRun]:
    """Runs by a column, and where that is the same by place and seed; without a value come last."""
    by_place = sorted(runs, key=lambda placed: (placed[0], placed[1].seed, placed[1].key))
    if view.order == "variant":
        # As the experiment has them, which is an order of its values.
        if not view.descending:
            return by_place
        return sorted(by_place, key=lambda placed: -placed[0])
    head = next((head for head in heads if head.column == view.order), None)
    if head is None:
        # A column for which there was room in a larger window.
        return by_place
    keyed = [(_sort_value(run, head), (place, run)) for place, run in by_place]
    there = [pair for pair in keyed if pair[0] is not None]
    there.sort(key=lambda pair: pair[0], reverse=view.descending)
    return [run for _, run in there] + [run for value, run in keyed if value is None]


def _sort_value(run: Record, head: _Head) -> Any:
    """What a run is sorted by; None if it has nothing there."""
    value = head.value(run)
    if head.column == "seed":
        return value
    is_missing = isinstance(value, float) and math.isnan(value)
    return None if run.error or is_missing or value == "" else value


def _head(head: _Head, view: View, address: Address) -> str:
    arrow, sort = "", ""
    if head.column == view.order:
        arrow = "\N{NO-BREAK SPACE}" + ("▼" if view.descending else "▲")
        sort = f' aria-sort="{"descending" if view.descending else "ascending"}"'
    title = f' title="{escaped(head.hint or head.title)}: sort"'
    text = link(address, f"order/{head.column}", f"{escaped(head.title)}{arrow}", title)
    is_text = ' class="text"' if head.column == "variant" else ""
    return f'<th scope="col"{is_text}{sort}>{text}</th>'


_LONGEST_ERROR, _LONGEST_HINT = 100, 400


def _row(run: Record, heads: Sequence[_Head], label: str, address: Address, label_px: float) -> str:
    name = escaped(short_label(label, max(int(label_px / _CHARACTER_PX), 8)))
    hint = escaped(label)
    if run.error:
        gist = run.gist
        error, whole_error = (
            escaped(gist if len(gist) <= most else f"{gist[:most]}…")
            for most in (_LONGEST_ERROR, _LONGEST_HINT)
        )
        return (
            f'<tr class="failed"><td class="text" title="{hint}">{name}</td>'
            f'<td title="{run.seed}">{run.seed}</td>'
            f'<td class="text" colspan="{len(heads) - 1}" title="{whole_error}">'
            f"failed: {error}</td></tr>"
        )
    words = f"open/{run.key}"
    opened = link(address, words, name, f' title="{hint}: open this run in the lab"')
    # The whole row does the same, which those who go by keyboard need not pass nine times.
    again = ' tabindex="-1"'
    seed = link(address, words, str(run.seed), f'{again} class="plain" title="{run.seed}"')
    opens = link(address, words, "open ▸", f'{again} title="open this run in the lab"')
    cells = [head.text(run) for head in heads[2:]]
    links = [
        seed,
        *(link(address, words, cell, f'{again} class="plain"') for cell in cells),
        opens,
    ]
    others = "".join(f"<td>{content}</td>" for content in links)
    return f'<tr><td class="text">{opened}</td>{others}</tr>'


def _pager(n_runs: int, page: int, address: Address, rows: int) -> str:
    """Which runs are shown, and the way to others."""
    last_page = n_pages(n_runs, rows) - 1
    first, last = page * rows + 1, min((page + 1) * rows, n_runs)
    span = f"{first:,}–{last:,} of {n_runs:,}" if n_runs else "none yet"
    if last_page == 0:
        return f'<span class="pager">{span}</span>'
    near = range(max(page - 1, 0), min(page + 1, last_page) + 1)
    numbers = sorted({0, *near, last_page})
    parts = [_step(page - 1, last_page, "◂", "previous page", address)]
    for number, before in zip(numbers, [-1, *numbers], strict=False):
        if number > before + 1:
            parts.append("<span>…</span>")
        name = f"{number + 1:,}"
        parts.append(f"<b>{name}</b>" if number == page else link(address, f"page/{number}", name))
    parts.append(_step(page + 1, last_page, "▸", "next page", address))
    return f'<span class="pager choice"><span>{span}</span>{"".join(parts)}</span>'


def _step(page: int, last_page: int, sign: str, name: str, address: Address) -> str:
    if not 0 <= page <= last_page:
        return f'<span style="opacity:.35">{sign}</span>'
    return link(address, f"page/{page}", sign, f' title="{name}" aria-label="{name}"')
