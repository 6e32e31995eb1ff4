"""Lessons: from a file to what it teaches, or to all that is wrong with it.

A lesson is read as presets are: nothing in it is evaluated, how large it may be is bounded, and all
that is wrong is said at once. The preset of its setup is read with it, so that a lesson that is
sound can also be run.
"""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from app.documents import presets
from app.documents.faults import fault_of, faults_of, without_nulls
from app.documents.lesson_fits import misfits
from app.documents.lesson_spec import LessonSpec
from app.documents.sources import STDIN, Shipped, called
from app.documents.tree import (
    MAX_SHOWN,
    Key,
    Node,
    PresetError,
    PresetProblem,
    UnusableError,
    children,
    descend,
    document_of,
    in_order,
    key_of,
    plain,
    printable,
    quoted,
    scalar,
)
from app.util.texts import as_text, folder_name
from learners.spec import RunSpec

_SHIPPED: Final = Shipped(
    "lesson",
    "presets/lessons",
    files("presets") / "lessons",
    (
        "where_value_comes_from",
        "the_cone",
        "which_way_round",
        "worse_first",
        "closing_the_ring",
        "all_at_once",
        "no_evidence",
    ),
)


class LessonError(PresetError):
    """A lesson that cannot be taught; carries everything that is wrong with it."""


@dataclass(frozen=True, eq=False)
class Lesson:
    """A lesson, and the run that it is about."""

    name: str
    spec: LessonSpec
    run_spec: RunSpec
    """What its setup comes to."""
    starts: Mapping[str, RunSpec]
    """What each card that starts again comes to, by the card's id."""
    text: bytes
    """The file as it was given."""
    source: str
    """How it was named, where it can be named again; empty if it was given as a text, or came by
    standard input."""
    digest: str
    """Equal for lessons that say the same of the same run, however their files are laid out and
    whatever evidence there is."""


def shipped() -> dict[str, Traversable]:
    """The lessons that come with the lab, by name, in the order of the syllabus."""
    return _SHIPPED.files()


def load(name_or_path: str) -> Lesson:
    """Read a shipped lesson, a file or standard input.

    Raises:
        LessonError: it cannot be taught; with all that is wrong with it.
    """
    try:
        found = _SHIPPED.asked_for(name_or_path)
    except UnusableError as error:
        problem = PresetProblem(called(name_or_path), error.line, "", None, error.message)
        raise LessonError([problem]) from None
    # Standard input can be read but once.
    named = "" if name_or_path == STDIN else as_text(name_or_path)
    return _parsed(found.data, found.label, found.folder, named)


def parse(data: bytes | str, source: str, folder: Path | None = None) -> Lesson:
    """Read a lesson from a text.

    Args:
        data: the text.
        source: what its problems call it; the lesson's name is the stem of it.
        folder: where the path of a preset starts; None if only a shipped one may be named.

    Raises:
        LessonError: it cannot be taught; with all that is wrong with it.
    """
    return _parsed(data, source, folder, "")


def _parsed(data: bytes | str, source: str, folder: Path | None, named: str) -> Lesson:
    problems: list[PresetProblem] = []
    root = document_of(data, printable(source), problems, _scalar)
    if root is None:
        raise LessonError(problems)
    tree = without_nulls(root, LessonSpec)
    spec = _judged(tree, problems)
    shelf = presets.Shelf(folder)
    run = _run_of(tree, ("setup",), (), shelf, problems)
    starts: dict[str, RunSpec] = {}
    if spec is not None:
        starts = _starts(spec, tree, shelf, problems)
        problems += [fault_of(misfit).problem(tree) for misfit in misfits(spec, run, starts)]
    if problems or spec is None or run is None:
        raise LessonError(in_order(dict.fromkeys(problems)))
    return Lesson(
        name=printable(folder_name(Path(source).stem), MAX_SHOWN),
        spec=spec,
        run_spec=run,
        starts=starts,
        text=data.encode() if isinstance(data, str) else data,
        source=named,
        digest=_digest(tree, [run, *starts.values()]),
    )


def _scalar(text: str) -> Any:
    """As in presets, but that +5000 stays what it looks like: so many trials from here on."""
    return text if text.startswith("+") else scalar(text)


def _judged(tree: Node, problems: list[PresetProblem]) -> LessonSpec | None:
    try:
        return LessonSpec.model_validate(plain(tree))
    except ValidationError as error:
        faults = [fault for fault in faults_of(error, LessonSpec) if not fault.is_noted]
        problems += [fault.problem(tree) for fault in faults]
        return None


def _run_of(
    tree: Node,
    at: Key,
    settings: Sequence[Key],
    shelf: presets.Shelf,
    problems: list[PresetProblem],
) -> RunSpec | None:
    """The preset that is named at a key, with settings; None, with what is wrong noted.

    Args:
        tree: of the lesson.
        at: where ``preset`` is named.
        settings: of further settings, on top of those beside it.
        shelf: from which the preset is taken.
        problems: to which what is wrong is added.
    """
    node, rest = descend(tree, (*at, "preset"))
    if rest or not isinstance(node.value, str):
        return None  # The model has said so.
    on_top = [setting for key in ((*at, "set"), *settings) for setting in _settings(tree, key)]
    try:
        return presets.completed(shelf.base_of(node.value), on_top)
    except UnusableError as error:
        problems.append(node.problem(error.message, quoted(node.value)))
    except PresetError as error:
        problems += error.problems
    return None


def _settings(tree: Node, key: Key) -> Iterator[Node]:
    node, rest = descend(tree, key)
    for name, child in () if rest or not isinstance(node.value, dict) else children(node):
        try:
            yield child._replace(key=key_of(str(name)))
        except ValueError:
            continue  # The model has said so.


def _starts(
    spec: LessonSpec, tree: Node, shelf: presets.Shelf, problems: list[PresetProblem]
) -> dict[str, RunSpec]:
    """What each card that starts again comes to, as far as it can be had."""
    found: dict[str, RunSpec] = {}
    for n, card in enumerate(spec.steps):
        if card.do is None or card.do.command != "start_again":
            continue
        at = ("steps", n, "do")
        own = card.do.preset is not None
        run = _run_of(
            tree, at if own else ("setup",), () if own else [(*at, "set")], shelf, problems
        )
        if run is not None:
            found[card.id] = run
    return found


def _digest(tree: Node, runs: list[RunSpec]) -> str:
    stated = {name: value for name, value in plain(tree).items() if name != "evidence"}
    text = json.dumps([stated, *(run.model_dump(mode="json") for run in runs)], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
