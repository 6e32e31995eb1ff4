"""The command ``pounce lesson``: what lessons there are, whether they hold, a new one, a sheet.

Like the command line, it imports what takes long only once it is needed.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

from tyro.conf import Positional, arg

from app.cli.answers import (
    EXIT_OK,
    Flag,
    UsageError,
    WrongPresetError,
    say,
    shown,
    table,
)

if TYPE_CHECKING:
    from app.documents.lessons import Lesson as Loaded

EXAMPLES = (
    "pounce lesson",
    "pounce lesson new --out mine.yaml",
)

_NO_HINT = "(default: none)"


@dataclass(frozen=True)
class Lesson:
    """List the lessons, or begin a new one."""

    action: Annotated[Positional[str], arg(metavar="[ACTION]")] = "list"
    """What to do: list says which lessons there are; new begins a file of one, which says what each
    of its parts is for."""
    out: Annotated[str | None, arg(metavar="FILE", help_behavior_hint=_NO_HINT)] = None
    """Of new: the file to write; without it, standard output."""
    json: Flag = False
    """Of list: print one JSON object and nothing else."""


_OPTIONS: Final[Mapping[str, frozenset[str]]] = {
    "list": frozenset({"json"}),
    "new": frozenset({"out"}),
}
"""What each action heeds besides its own name."""


def obey(command: Lesson) -> int:
    """Do what was asked for; returns the exit code.

    Raises:
        UsageError: the words make no sense, or a lesson cannot be used.
    """
    actions: dict[str, Callable[[Lesson], int]] = {"list": _list, "new": _new}
    if command.action not in actions:
        raise UsageError(
            f"ACTION: {shown(command.action)} is not allowed; allowed: {', '.join(actions)}"
        )
    for field in fields(command):
        given = getattr(command, field.name) != field.default
        if given and field.name != "action" and field.name not in _OPTIONS[command.action]:
            owners = " and ".join(name for name, own in _OPTIONS.items() if field.name in own)
            raise UsageError(f"--{field.name} is of {owners}, not of {command.action}")
    return actions[command.action](command)


def _loaded(name: str) -> "Loaded":
    """A shipped lesson, a file or standard input.

    Raises:
        WrongPresetError: it cannot be used.
    """
    from app.documents import lessons
    from app.documents.tree import PresetError

    try:
        return lessons.load(name)
    except PresetError as error:
        raise WrongPresetError(str(error)) from error


# --- Which there are -----------------------------------------------------------------------------


def _list(command: Lesson) -> int:
    from app.documents import lessons

    loaded = [_loaded(name) for name in lessons.shipped()]
    if command.json:
        say(json.dumps({"lessons": [_described(lesson) for lesson in loaded]}))
        return EXIT_OK
    rows = [
        (
            lesson.name,
            f"{lesson.spec.minutes} min",
            lesson.spec.title,
            " ".join(lesson.spec.languages),
        )
        for lesson in loaded
    ]
    say(table(("lesson", "takes", "title", "in"), rows))
    return EXIT_OK


def _described(lesson: "Loaded") -> dict[str, object]:
    spec = lesson.spec
    return {
        "name": lesson.name,
        "title": spec.title,
        "minutes": spec.minutes,
        "needs": list(spec.needs),
        "languages": list(spec.languages),
        "cards": len(spec.steps),
    }


# --- A new one -----------------------------------------------------------------------------------


def template() -> str:
    """A short lesson that says what each of its parts is for."""
    return (files("app.lessons") / "template.yaml").read_text("utf-8")


def _new(command: Lesson) -> int:
    if command.out is None:
        say(template().rstrip("\n"))
        return EXIT_OK
    path = _place(command.out, (".yaml", ".yml"))
    if path.exists():
        raise UsageError(f"--out: {shown(command.out)} is there already; allowed: a new file")
    _write(path, template().encode())
    say(str(path))
    return EXIT_OK


# --- Files ---------------------------------------------------------------------------------------


def _place(name: str, suffixes: tuple[str, ...]) -> Path:
    """Where to write a file.

    Raises:
        UsageError: it cannot be written there.
    """
    if "\0" in name or Path(name).suffix.lower() not in suffixes or Path(name).is_dir():
        raise UsageError(
            f"--out: {shown(name)} is not allowed; allowed: a file that ends in"
            f" {' or '.join(suffixes)}"
        )
    if not Path(name).absolute().parent.is_dir():
        raise UsageError(f"--out: {shown(name)} is in no folder; allowed: one there is")
    return Path(name)


def _write(path: Path, content: bytes) -> None:
    """Put a file into place, whole or not at all.

    Raises:
        UsageError: it cannot be written.
    """
    from app.util.files import write_whole

    try:
        write_whole(path, content)
    except OSError as error:
        raise UsageError(
            f"{shown(str(path))} cannot be written: {error.strerror or error}; allowed: a place"
            " that can"
        ) from error
