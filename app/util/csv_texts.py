"""Tables as comma-separated values: the same rows for programs, and for spreadsheets.

Both are to be written in UTF-8, with a comma between cells and a decimal point. What spreadsheets
open begins with a byte order mark, without which some of them take it for another encoding, and no
text in it is taken for a formula.
"""

import csv
import io
import math
from collections.abc import Iterable, Sequence
from typing import Any, Final

_BEGINS_A_FORMULA: Final = tuple("=+-@\t\r\n\uff1d\uff0b\uff0d\uff20")
"""The last four are the first four in the width of Chinese characters."""

Rows = Iterable[Sequence[Any]]


def for_programs(rows: Rows) -> str:
    """Rows as they are; numbers that are not there stay empty."""
    return _text(rows)


def for_spreadsheets(rows: Rows) -> str:
    """The same for people: numbers stay numbers, and a text that would be a formula is a text.

    It gets an apostrophe before it, which spreadsheets take for the sign of a text.
    """
    defused = ([_defused(cell) for cell in row] for row in rows)
    return "\N{BYTE ORDER MARK}" + _text(defused)


def _text(rows: Rows) -> str:
    out = io.StringIO(newline="")
    writer = csv.writer(out)
    for row in rows:
        writer.writerow(["" if _is_missing(cell) else cell for cell in row])
    return out.getvalue()


def _is_missing(cell: Any) -> bool:
    return isinstance(cell, float) and math.isnan(cell)


def _defused(cell: Any) -> Any:
    begins = isinstance(cell, str) and cell.lstrip(" ").startswith(_BEGINS_A_FORMULA)
    return f"'{cell}" if begins else cell
