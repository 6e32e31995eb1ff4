"""How far variants are from the one that they are set against, on the page."""

from functools import partial
from typing import Final

from app.charts.differences import Compared, Differences
from app.charts.wording import short_label, shown_estimate
from app.util.html import escaped
from app.words.numbers import NONE, shared_form

_CHARACTER_PX = 7.0
_COLUMNS: Final = (150, 168, 150)
"""Widths in pixels; names of variants have what they leave."""
_HINT = (
    "Differences and their 95 % intervals are the report's: by seed, where enough seeds are shared;"
    " undecided where the interval holds 0, or there are fewer than 10 runs."
)


def differences_html(found: Differences, width: float) -> str:
    """A row for each variant: its mean, how much higher it is, and whether that is decided.

    Args:
        found: the variants.
        width: that there is, in pixels.
    """
    base, *others = found.rows
    name = escaped(short_label(base.label, 40))
    if not others:
        return (
            f'<p class="note">To set one of the other {found.n_others:,} variants against {name},'
            " choose it in a chart.</p>"
        )
    means = shared_form(number for row in found.rows for number in row.mean[:3])
    differences = shared_form(
        number for row in others if row.difference for number in row.difference.estimate[:3]
    )
    overs = {row.over for row in others if row.over}
    shared = overs.pop() if len(overs) == 1 else ""
    over = f", {shared}" if shared else ""
    room = max(int((width - sum(_COLUMNS)) / _CHARACTER_PX), 8)
    draw = partial(_row, (means, f"+{differences}"), shared, room)
    rows = "".join(map(draw, found.rows))
    columns = "".join(f'<col style="width:{px}px"/>' for px in _COLUMNS)
    return (
        f'<table class="differences" title="{escaped(_HINT)}"><colgroup><col/>{columns}</colgroup>'
        '<thead><tr><th scope="col" class="text">variant</th>'
        f'<th scope="col">{escaped(found.what)}</th>'
        f'<th scope="col">difference to {name}{over}</th><th></th>'
        f"</tr></thead><tbody>{rows}</tbody></table>"
    )


def _row(forms: tuple[str, str], shared: str, characters: int, row: Compared) -> str:
    """A variant; what its difference is over is said where it is not what all of them are."""
    name = escaped(short_label(row.label, characters))
    difference = NONE
    if row.difference is not None:
        difference = shown_estimate(row.difference.estimate, forms[1])
    said = ", ".join(part for part in (row.verdict, row.over) if part and part != shared)
    return (
        f'<tr><td class="text" title="{escaped(row.label)}">{name}</td>'
        f"<td>{shown_estimate(row.mean, forms[0])}</td>"
        f"<td>{difference}</td>"
        f'<td class="text">{escaped(said)}</td></tr>'
    )
