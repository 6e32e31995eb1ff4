"""What all commands of ``pounce`` share: how words become values, are refused and are answered.

Like the command line, it imports what takes long only once it is needed.
"""

import math
import re
import sys
import textwrap
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Annotated

from tyro.conf import arg

from app.util.machine import available_cores
from app.util.texts import as_text, for_terminal
from app.words import typed

if TYPE_CHECKING:
    from learners.spec import RunSpec

EXIT_OK = 0
EXIT_FAILED = 1
EXIT_USAGE = 2
EXIT_PIPE_CLOSED = 141
"""As shells report a program that SIGPIPE ended."""

RESULTS = "results"
"""Folder of the results of experiments that are not told where to put them."""
MAX_WORKERS = 1_024

HIDDEN_HINT = ""
"""Of an option whose help is to say nothing of its default."""
Flag = Annotated[bool, arg(help_behavior_hint=HIDDEN_HINT)]
"""The type of an option that takes no value."""

COLUMNS = 80
"""Of a terminal that is not told to be wider."""
_SHOWN_CHARACTERS = 40
_NOTHING = "\N{EN DASH}"


class UsageError(Exception):
    """What was asked for makes no sense; the message says what does. Exit code 2."""


class WrongPresetError(UsageError):
    """A preset that cannot be used; the message has one line for each of its problems."""


# --- From words to values ------------------------------------------------------------------------


def shown(value: str) -> str:
    """A user's text as a message quotes it: on one line, and not too long."""
    value = as_text(value)
    if len(value) > _SHOWN_CHARACTERS:
        value = value[: _SHOWN_CHARACTERS - 3] + "..."
    return repr(value)


def whole_number(option: str, text: str, low: int, high: int) -> int:
    """The number that an option was given, as people write it (:mod:`app.words.typed`).

    Raises:
        UsageError: it is not a whole number between the limits.
    """
    try:
        return typed.whole(text, low, high)
    except typed.NumeralError:
        raise UsageError(
            f"{option}: {shown(text)} is not allowed; allowed: a whole number, {low} to {high}"
        ) from None


def parts_of(option: str, text: str, what: str) -> list[str]:
    """The parts of a list that an option was given, as texts.

    Raises:
        UsageError: its commas may be those that group the digits of a number.
    """
    first, *others = text.split(",")
    if any(re.fullmatch(r"0\d\d", part) for part in others):
        raise UsageError(
            f"{option}: {shown(text)} is not allowed, as its commas may be within a number;"
            f" allowed: {what} with commas between them alone"
        )
    return [first, *others]


def workers_of(text: str | None) -> int:
    """Runs at a time, from what ``--workers`` was given; all cores if that is None.

    Raises:
        UsageError: it is not such a number.
    """
    if text is None:
        return available_cores()
    return whole_number("--workers", text, 1, MAX_WORKERS)


def spec_of(preset: str, settings: Sequence[str] = ()) -> "RunSpec":
    """A preset with other values for some of its keys, each as ``KEY=VALUE``.

    Raises:
        WrongPresetError: it cannot be used.
    """
    from app.documents import presets
    from app.documents.tree import PresetError

    try:
        return presets.load(preset, settings)
    except PresetError as error:
        raise WrongPresetError(str(error)) from error


# --- What is printed -----------------------------------------------------------------------------


def say(text: str) -> None:
    """Answer on standard output."""
    sys.stdout.write(for_terminal(text) + "\n")


def complain(text: str) -> None:
    """Say on standard error what is wrong, or what else there is to know."""
    sys.stderr.write(for_terminal(text) + "\n")


def filled(text: str, indent: str = "  ") -> str:
    """A text in lines that fit a terminal, those after the first indented."""
    return textwrap.fill(text, COLUMNS, subsequent_indent=indent, break_on_hyphens=False)


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Rows of texts in columns, aligned to the right but for the first."""
    lines = [header, *rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        " ".join(
            cell.rjust(width) if column else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in lines
    )


def number(value: float | None, form: str = ".1f") -> str:
    """A number as a table shows it; neither None nor NaN is one."""
    return _NOTHING if value is None or math.isnan(value) else format(value, form)
