"""Presets: from a name, a file or a text to a validated run, or to all that is wrong with it.

A preset passes through four stages, each of which notes what is wrong and carries on:

- *text*: a small, plain file in UTF-8 (:mod:`app.documents.sources`);
- *tree*: its values, each with the file and line it came from (:mod:`app.documents.tree`);
- *merge*: the presets it starts from (``extends``) below it, settings (``--set``) on top;
- *run*: the models' verdict (:mod:`app.documents.faults`): all that is wrong with single values,
  and, of what they find sound, all that does not go together.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import cache, lru_cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, Final, NamedTuple

import yaml
from pydantic import ValidationError

from app.documents.faults import faults_of, unknown_key, without_nulls
from app.documents.sources import Shipped, Source, called
from app.documents.tree import (
    EXTENDS,
    MAX_BYTES,
    MAX_DEPTH,
    MAX_NAME,
    Key,
    Node,
    Place,
    PresetError,
    PresetProblem,
    Refused,
    UnusableError,
    built,
    children,
    descend,
    document_of,
    in_order,
    merged,
    placed,
    plain,
    printable,
    quoted,
    scalar,
)
from app.util.texts import as_text
from learners.skill_spec import BUILT_IN
from learners.spec import RunSpec

MAX_BASES: Final = 8
"""Presets below one another by ``extends``."""
MAX_SHELF_BYTES: Final = (MAX_BASES + 2) * MAX_BYTES
"""Of all files that the presets of one experiment are read from: hundreds of ordinary ones."""

_SHIPPED: Final = Shipped(
    "preset",
    "presets",
    files("presets"),
    ("standard_q", "hierarchical_2", "hierarchical_3", "timed"),
)


# --- Files, and the presets that a preset starts from --------------------------------------------


def shipped() -> dict[str, Traversable]:
    """The presets that come with the lab, by name: first the thesis's own, then the others."""
    return _SHIPPED.files()


@cache
def shipped_settings(name: str) -> Mapping[str, Any] | None:
    """All settings of a shipped preset, as JSON has them; None if there is none of that name."""
    return load(name).model_dump(mode="json") if name in shipped() else None


def _base(node: Node, source: Source, above: Sequence[str]) -> Source:
    """The preset that ``extends`` names; raises `UnusableError` alone."""
    if not isinstance(node.value, str):
        raise UnusableError(f"must be a text; allowed: {', '.join(shipped())}, or a path")
    if len(above) > MAX_BASES:
        raise UnusableError(f"is one base too many; allowed: {MAX_BASES} below one another")
    base = _SHIPPED.opened(node.value, source.folder)
    if base.identity in above:
        raise UnusableError("starts from itself; allowed: a preset that does not lead back here")
    return base


# --- Settings ------------------------------------------------------------------------------------


def _with_setting(tree: Node, setting: str, problems: list[PresetProblem]) -> Node:
    """The tree with one ``KEY=VALUE`` on top."""
    place = Place(f"--set {printable(setting, MAX_NAME)}", None)
    known = as_text(setting)
    if known != setting and "\N{REPLACEMENT CHARACTER}" in known:
        problems.append(Node((), None, place).problem("is not a text; allowed: UTF-8"))
        return tree
    name, equals, text = known.partition("=")
    path = tuple(name.strip().split("."))
    if not equals or not all(path) or len(path) > MAX_DEPTH:
        node = Node((), None, place)
        problems.append(node.problem("is not a setting; allowed: KEY=VALUE with a dotted KEY"))
        return tree
    node = Node(path, None, place)
    if path[0] == EXTENDS:
        problems.append(node.problem("cannot be set; allowed: in a preset's file"))
        return tree
    try:
        return placed(tree, path, built(text, path, place, problems) or node)
    except UnusableError as error:
        problems.append(node.problem(error.message))
        return tree


# --- From a tree to a run ------------------------------------------------------------------------


def _entries(tree: Node, key: Key) -> Mapping[Any, Node] | None:
    """The mapping at a key, empty if it is not given; None if something else is there."""
    node, rest = descend(tree, key)
    if not isinstance(node.value, dict):
        return None
    return {} if rest else dict(children(node))


def _validated(tree: Node, complete: bool, problems: list[PresetProblem]) -> RunSpec:
    """The run that a merged tree states; raises `PresetError` if there are any problems.

    First every value is looked at by itself, then those that are sound are compared.
    """
    custom = _entries(tree, ("learner", "custom_skills"))
    named = (name for name in custom or () if name.isidentifier())
    skills = list(dict.fromkeys([*BUILT_IN, *(printable(name) for name in named)]))
    if complete and custom is not None:
        for name, timer in (_entries(tree, ("schedule", "skills")) or {}).items():
            if timer.value is None and name not in skills:
                problems.append(timer.problem(unknown_key(name, skills), "null"))
    tree = without_nulls(tree, RunSpec)
    try:
        spec = RunSpec.model_validate(plain(tree))
    except ValidationError as error:
        spec = None
        faults = [fault for fault in faults_of(error, RunSpec, skills) if not fault.is_noted]
        if not complete:
            # What is missing or does not fit may do so for a part that could not be had.
            faults = [fault for fault in faults if not (fault.is_lacking or fault.is_compared)]
        faults.sort(key=lambda fault: fault.is_compared)
        problems += [fault.problem(tree) for fault in faults]
    if problems or spec is None:
        raise PresetError(in_order(problems))
    return spec


class Base(NamedTuple):
    """A preset as it is read once, to be completed with different settings many times."""

    tree: Node
    complete: bool
    """Whether all that it starts from could be had."""
    problems: tuple[PresetProblem, ...]
    """What was wrong with it before any setting."""


class Shelf:
    """The presets that others start from: however often one is named, it is read once."""

    def __init__(self, folder: Path | None) -> None:
        """Paths start at the folder; without one, there are shipped presets alone."""
        self._folder = folder
        self._bases: dict[str, Base] = {}
        self._documents: dict[str, tuple[Node | None, tuple[PresetProblem, ...]]] = {}
        self._n_bytes = 0

    def base_of(self, name: str) -> Base:
        """A shipped preset, or the file at a path; raises `UnusableError` alone."""
        source = _SHIPPED.opened(name, self._folder)
        if source.identity not in self._bases:
            self._bases[source.identity] = self.stacked(source)
        return self._bases[source.identity]

    def base_within(self, node: Node) -> Base:
        """A preset that is written within another file; raises `UnusableError` alone."""
        entries = dict(node.value)
        extends = entries.pop(EXTENDS, None)
        below = Base(Node((), {}, node.place), True, ())
        if extends is not None and isinstance(extends.value, Refused):
            below = below._replace(complete=False)
        elif extends is not None:
            if not isinstance(extends.value, str):
                raise UnusableError(f"must be a text; allowed: {', '.join(shipped())}, or a path")
            below = self.base_of(extends.value)
        return below._replace(tree=merged(below.tree, node._replace(value=entries)))

    def stacked(self, source: Source) -> Base:
        """A preset on top of all it starts from."""
        layers: list[Node] = []
        problems: list[PresetProblem] = []
        complete = self._add_layers(source, layers, problems)
        tree = Node((), {}, Place(source.label, 1))
        for layer in reversed(layers):
            tree = merged(tree, layer)
        return Base(tree, complete, tuple(problems))

    def _add_layers(
        self, source: Source, layers: list[Node], problems: list[PresetProblem]
    ) -> bool:
        """A preset and all it starts from, topmost first; returns whether all could be had."""
        above: list[str] = []
        while (root := self._read(source, problems)) is not None:
            above.append(source.identity)
            entries = dict(root.value)
            extends = entries.pop(EXTENDS, None)
            layers.append(root._replace(value=entries))
            if extends is None or extends.value is None:
                return True
            if isinstance(extends.value, Refused):
                return False
            try:
                source = _base(extends, source, above)
            except UnusableError as error:
                problems.append(extends.problem(error.message, quoted(plain(extends))))
                return False
        return False

    def _read(self, source: Source, problems: list[PresetProblem]) -> Node | None:
        if source.identity not in self._documents:
            self._n_bytes += min(len(source.data), MAX_BYTES)  # No more than that is looked at.
            if self._n_bytes > MAX_SHELF_BYTES:
                message = f"is one preset too many; allowed: {MAX_SHELF_BYTES} bytes in all of them"
                raise UnusableError(message)
            self._documents[source.identity] = _document(source.data, source.label)
        root, noted = self._documents[source.identity]
        problems += noted
        return root


@lru_cache(maxsize=32)
def _document(data: bytes | str, label: str) -> tuple[Node | None, tuple[PresetProblem, ...]]:
    """The tree of a text and what is wrong with it; the last ones are not read a second time.

    A preset of a program's is asked for again and again, and YAML takes some milliseconds.
    """
    found: list[PresetProblem] = []
    root = document_of(data, label, found)
    return root, tuple(found)


def with_settings(base: Base, settings: Iterable[Node]) -> Base:
    """A preset with settings on top, each a value that knows its key."""
    tree, problems = base.tree, list(base.problems)
    for setting in settings:
        try:
            tree = placed(tree, setting.key, setting)
        except UnusableError as error:
            problems.append(setting.problem(error.message, quoted(plain(setting))))
    return Base(tree, base.complete, tuple(problems))


def completed(base: Base, settings: Iterable[Node]) -> RunSpec:
    """The run that a preset with settings on top states; raises `PresetError`."""
    tree, complete, problems = with_settings(base, settings)
    return _validated(tree, complete, list(problems))


# --- Reading and writing -------------------------------------------------------------------------


def load(name_or_path: str, settings: Sequence[str] = ()) -> RunSpec:
    """Read a shipped preset, a file or standard input, with ``KEY=VALUE`` settings on top.

    Raises `PresetError`.
    """
    try:
        base = Shelf(None).stacked(_SHIPPED.asked_for(name_or_path))
    except UnusableError as error:
        problem = PresetProblem(called(name_or_path), error.line, "", None, error.message)
        base = Base(Node((), {}, Place("", 1)), False, (problem,))
    tree, problems = base.tree, list(base.problems)
    for setting in settings:
        tree = _with_setting(tree, setting, problems)
    return _validated(tree, base.complete, problems)


def parse(text: bytes | str, source: str) -> RunSpec:
    """Read a preset from a text; ``source`` is what its problems call it.

    It may start from shipped presets alone: no other file is looked at. Raises `PresetError`.
    """
    found = Source(printable(source, MAX_NAME), text, "", None)
    return completed(Shelf(None).stacked(found), ())


class _Row(dict[str, Any]):
    """A mapping that is written on one line."""


class _Dumper(yaml.SafeDumper):
    """Writes so that :func:`scalar` reads the same back."""

    def ignore_aliases(self, data: object) -> bool:
        return True


def _represent_text(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    is_word = text.isascii() and text.isidentifier() and scalar(text) == text
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=None if is_word else '"')


def _represent_items(dumper: yaml.SafeDumper, items: tuple[object, ...]) -> yaml.SequenceNode:
    return dumper.represent_sequence("tag:yaml.org,2002:seq", items, flow_style=True)


def _represent_row(dumper: yaml.SafeDumper, row: _Row) -> yaml.MappingNode:
    return dumper.represent_mapping("tag:yaml.org,2002:map", row.items(), flow_style=True)


_Dumper.add_representer(str, _represent_text)
_Dumper.add_representer(tuple, _represent_items)
_Dumper.add_representer(_Row, _represent_row)


def dump(spec: RunSpec) -> str:
    """Write a run as a preset that :func:`parse` reads back as an equal one.

    Keys come in the order of the reference; those at their defaults are left out.
    """
    document = spec.model_dump(exclude_defaults=True)
    learner = document["learner"]
    if "custom_skills" in learner:
        custom = learner["custom_skills"]
        learner["custom_skills"] = {skill: _Row(weights) for skill, weights in custom.items()}
    schedule = document.get("schedule", {})
    if "skills" in schedule:
        schedule["skills"] = {skill: _Row(timer) for skill, timer in schedule["skills"].items()}
    if "episodes" in schedule:
        schedule["episodes"] = [_Row(episode) for episode in schedule["episodes"]]
    return yaml.dump(
        document, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=float("inf")
    )
