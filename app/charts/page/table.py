"""The table of runs on the page, whose rows open them."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from app.charts.live import trials_of
from app.charts.page.svg import Address, link
from app.charts.view import Column, Size, View, listed, n_pages
from app.charts.wording import short_label
from app.metrics import final_trials
from app.results.gather import Gathering, RunFact
from app.util.html import escaped
from app.words.numbers import NONE, shown_number


class _Head(NamedTuple):
    """A column of the table."""

    column: Column
    title: str
    hint: str
    width: int
    """In pixels; the first has what the others leave."""


def _heads(gathering: Gathering) -> Sequence[_Head]:
    metric, final = gathering.metric, final_trials(*trials_of(gathering.experiment))
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


def table_html(gathering: Gathering, view: View, address: Address, size: Size) -> str:
    """A page of the table, with the way to its other pages."""
    shown = _in_order(listed(gathering, view), view)
    page = min(view.page, n_pages(len(shown), size.rows) - 1)
    first = page * size.rows
    stretch = min(max(size.width / Size().width, 1), _MOST_STRETCH)
    heads = [head._replace(width=round(head.width * stretch)) for head in _heads(gathering)]
    label_px = size.width - sum(head.width for head in heads) - _OPEN_PX
    head = "".join(_head(head, view, address) for head in heads)
    rows = "".join(
        _row(run, gathering.experiment.variants[run.variant].label, address, label_px)
        for run in shown[first : first + size.rows]
    )
    columns = "".join(f'<col style="width:{head.width}px"/>' for head in heads[1:])
    return (
        f'<div class="bar"><b>Runs</b>{_pager(len(shown), page, address, size.rows)}</div>'
        f'<table><colgroup><col/>{columns}<col style="width:{_OPEN_PX}px"/></colgroup>'
        f"<thead><tr>{head}<th></th></tr></thead><tbody>{rows}</tbody></table>"
    )


def _in_order(runs: Sequence[RunFact], view: View) -> list[RunFact]:
    """Runs by a column, and where that is the same by place and seed; without a value come last."""
    by_place = sorted(runs, key=lambda run: (run.variant, run.seed, run.key))
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
    name = escaped(short_label(label, max(int(label_px / _CHARACTER_PX), 8)))
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
        shown_number(run.value, "#.4g"),
        NONE if math.isnan(run.success) else f"{100 * run.success:.0f} %",
        shown_number(run.steps_to_70 / 1e6, ".2f"),
        f"{run.steps / 1e6:.2f}",
        NONE if math.isnan(run.seconds) else f"{run.seconds:.1f}",
        escaped(run.digest[:8]),
    )
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
