"""The command ``pounce lesson``: which there are, whether they hold, a new one, and one on paper.

Like the command line, it imports what takes long only once it is needed.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

from tyro.conf import Positional, arg

from app.cli import terminal
from app.cli.answers import (
    EXIT_FAILED,
    EXIT_OK,
    HIDDEN_HINT,
    Flag,
    UsageError,
    WrongPresetError,
    complain,
    filled,
    say,
    shown,
    table,
    whole_number,
)
from app.util import interrupts

if TYPE_CHECKING:
    from app.documents.lessons import Lesson as Loaded
    from app.lessons.proof import Proof

EXAMPLES = (
    "pounce lesson",
    "pounce lesson new --out mine.yaml",
    "pounce lesson check mine.yaml --seeds 30",
    "pounce lesson check --all --json",
    "pounce lesson sheet the_cone --out cone.html --language de",
)

MOST_SEEDS = 1_000
_NO_HINT = "(default: none)"


@dataclass(frozen=True)
class Lesson:
    """List the lessons, check one over many seeds, begin a new one, or print one."""

    action: Annotated[Positional[str], arg(metavar="[ACTION]")] = "list"
    """What to do: list says which lessons there are; check plays one with many seeds and says
    whether it holds; new begins a file of one, which says what each of its parts is for; sheet
    writes one to be printed, with room for answers, and the answers at the end."""
    lesson: Annotated[Positional[str], arg(metavar="[LESSON]", help_behavior_hint=HIDDEN_HINT)] = ""
    """Of check and sheet: a shipped lesson, or a file (- is standard input)."""
    all: Flag = False
    """Of check: all shipped lessons."""
    out: Annotated[str | None, arg(metavar="FILE", help_behavior_hint=_NO_HINT)] = None
    """Of new and sheet: the file to write. New prints its own without it."""
    language: Annotated[
        str | None, arg(metavar="LANGUAGE", help_behavior_hint="(default: the lesson's own)")
    ] = None
    """Of sheet: the language that it is in, such as de."""
    seeds: Annotated[str, arg(metavar="N")] = "20"
    """Of check: seeds that it has to hold with, from 0 on. Of sheet: runs whose spread it tells."""
    write: Flag = False
    """Of check: write into the lesson's file with how many seeds it held."""
    json: Flag = False
    """Of list and check: print one JSON object and nothing else."""


_OPTIONS: Final[Mapping[str, frozenset[str]]] = {
    "list": frozenset({"json"}),
    "check": frozenset({"lesson", "all", "seeds", "write", "json"}),
    "new": frozenset({"out"}),
    "sheet": frozenset({"lesson", "out", "language", "seeds"}),
}
"""What each action heeds besides its own name."""


def obey(command: Lesson) -> int:
    """Do what was asked for; returns the exit code.

    Raises:
        UsageError: the words make no sense, or a lesson cannot be used.
    """
    actions: dict[str, Callable[[Lesson], int]] = {
        "list": _list,
        "check": _check,
        "new": _new,
        "sheet": _sheet,
    }
    if command.action not in actions:
        raise UsageError(
            f"ACTION: {shown(command.action)} is not allowed; allowed: {', '.join(actions)}"
        )
    for field in fields(command):
        given = getattr(command, field.name) != field.default
        if given and field.name != "action" and field.name not in _OPTIONS[command.action]:
            owners = " and ".join(name for name, own in _OPTIONS.items() if field.name in own)
            option = "LESSON" if field.name == "lesson" else f"--{field.name}"
            raise UsageError(f"{option} is of {owners}, not of {command.action}")
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


# --- Whether it holds ----------------------------------------------------------------------------


def _check(command: Lesson) -> int:
    from app.documents import lessons
    from app.lessons.proof import as_json, proofs

    if command.all == bool(command.lesson):
        raise UsageError("LESSON is missing; allowed: a shipped lesson, a file, or --all")
    n = whole_number("--seeds", command.seeds, 1, MOST_SEEDS)
    if command.write and command.lesson == "-":
        raise UsageError("--write has no file to write into; allowed: a shipped lesson, or a file")
    names = list(lessons.shipped()) if command.all else [command.lesson]
    wanted = [_loaded(name) for name in names]
    with terminal.status() as show:
        found = proofs(wanted, n, lambda done, of: show(f"{done} of {of} seeds"))
    if command.json:
        say(json.dumps({"lessons": [as_json(one) for one in found]}))
    else:
        say("\n\n".join(map(_told, found)))
    if command.write:
        for name, one in zip(names, found, strict=True):
            _write_evidence(name, one)
    return EXIT_OK if all(one.holds for one in found) else EXIT_FAILED


def _told(found: "Proof") -> str:
    from app.lessons import proof

    problems = [filled(problem) for problem in found.problems]
    return "\n".join(
        [table(proof.COLUMNS, proof.rows_of(found)), *problems, proof.headline_of(found)]
    )


def _write_evidence(name: str, found: "Proof") -> None:
    """Write what was proved into the lesson's file, if it holds.

    Raises:
        UsageError: it cannot be written there.
    """
    from app.documents import lessons
    from app.lessons.proof import ProofError, write_evidence

    if not found.holds:
        complain(filled(f"{name} does not hold; nothing was written into its file."))
        return
    path = Path(str(lessons.shipped().get(name, name)))
    try:
        write_evidence(path, found)
    except (ProofError, OSError) as error:
        raise UsageError(f"{shown(str(path))}: {error}") from error


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


# --- On paper ------------------------------------------------------------------------------------


def _sheet(command: Lesson) -> int:
    if not command.lesson:
        raise UsageError("LESSON is missing; allowed: a shipped lesson, or a file")
    if command.out is None:
        raise UsageError("--out is missing; allowed: a file that ends in .html")
    path, n = _place(command.out, (".html",)), whole_number("--seeds", command.seeds, 1, MOST_SEEDS)
    lesson = _loaded(command.lesson)
    language = command.language or lesson.spec.language
    if language not in lesson.spec.languages:
        allowed = ", ".join(lesson.spec.languages)
        raise UsageError(f"--language: {shown(language)} is not allowed; allowed: {allowed}")
    from app.lessons.sheet import findings_of, sheet

    with interrupts.undoing(), terminal.status() as show:
        found = findings_of(lesson, range(n), show)
    _write(path, sheet(lesson, language, found).encode())
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
