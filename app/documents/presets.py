"""Presets: from a name, a file or a text to a validated run, with every error at once.

A preset passes through four stages, each of which notes what is wrong and carries on:

- *text*: a small, plain file in UTF-8;
- *tree*: its values, each with the file and line it came from (:mod:`app.documents.tree`);
- *merge*: the presets it starts from (``extends``) below it, settings (``--set``) on top;
- *run*: the models' verdict (:mod:`app.documents.faults`). What they fault is replaced by something
  harmless and they are asked again, because they compare values with each other only once every
  value is fine by itself.
"""

import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, Final, NamedTuple

import yaml
from pydantic import TypeAdapter, ValidationError

from app.documents.faults import Fault, faults_of, names_of, slot_of, unknown_key
from app.documents.tree import (
    EXTENDS,
    MAX_BYTES,
    MAX_DEPTH,
    MAX_NAME,
    NO_PATH,
    STDIN,
    Key,
    Node,
    Place,
    PresetError,
    PresetProblem,
    Refused,
    UnusableError,
    as_tree,
    built,
    called,
    children,
    descend,
    document_of,
    file_of,
    in_order,
    merged,
    placed,
    plain,
    printable,
    quoted,
    scalar,
    standard_input,
)
from app.util.texts import as_path, as_text
from learners.kernel.rows import MAX_ACTIONS
from learners.skills import SKILLS
from learners.spec import MAX_TRIALS, RunSpec, SkillName, did_you_mean

MAX_BASES: Final = 8
"""Presets below one another by ``extends``."""
MAX_SHELF_BYTES: Final = (MAX_BASES + 2) * MAX_BYTES
"""Of all files that the presets of one experiment are read from: hundreds of ordinary ones."""

_FIRST: Final = ("standard_q", "hierarchical_2", "hierarchical_3", "timed")
"""Presets of the thesis, in its order; others follow by name."""


# --- Files, and the presets that a preset starts from --------------------------------------------


def shipped() -> dict[str, Traversable]:
    """The presets that come with the lab, by name: first the thesis's own, then the others."""
    found = {
        entry.name.removesuffix(".yaml"): entry
        for entry in files("presets").iterdir()
        if entry.name.endswith(".yaml") and entry.is_file()
    }
    names = [name for name in _FIRST if name in found] + sorted(found.keys() - set(_FIRST))
    return {name: found[name] for name in names}


@cache
def shipped_settings(name: str) -> Mapping[str, Any] | None:
    """All settings of a shipped preset, as JSON has them; None if there is none of that name."""
    return load(name).model_dump(mode="json") if name in shipped() else None


class _Source(NamedTuple):
    """Where the text of a preset was found."""

    label: str
    data: bytes | str
    identity: str
    """Equal for two names of one file."""
    folder: Path | None
    """Where paths in ``extends`` start; None if it may name shipped presets alone."""


def _opened(name: str, folder: Path | None) -> _Source:
    """A shipped preset, or the file at a path from a folder; raises `UnusableError` alone."""
    presets = shipped()
    names = ", ".join(presets)
    if name in presets:
        label = f"presets/{name}.yaml"
        return _Source(label, presets[name].read_bytes(), f"shipped:{name}", None)
    if folder is None:
        hint = did_you_mean(name, presets)
        raise UnusableError(f"is not a shipped preset{hint}; allowed: {names}")
    try:
        path = folder / as_path(name)
        data = file_of(path)
    except (FileNotFoundError, NotADirectoryError):
        hint = did_you_mean(name, presets)
        message = f"is neither a shipped preset nor a file{hint}; allowed: {names}, or a path"
        raise UnusableError(message) from None
    except OSError as error:
        raise UnusableError(f"cannot be read: {error.strerror}") from None
    except ValueError:
        raise UnusableError(NO_PATH) from None
    return _Source(printable(str(path), MAX_NAME), data, os.path.realpath(path), path.parent)


def _base(node: Node, source: _Source, above: Sequence[str]) -> _Source:
    """The preset that ``extends`` names; raises `UnusableError` alone."""
    if not isinstance(node.value, str):
        raise UnusableError(f"must be a text; allowed: {', '.join(shipped())}, or a path")
    if len(above) > MAX_BASES:
        raise UnusableError(f"is one base too many; allowed: {MAX_BASES} below one another")
    base = _opened(node.value, source.folder)
    if base.identity in above:
        raise UnusableError("starts from itself; allowed: a preset that does not lead back here")
    return base


def _layers(
    source: _Source | None,
    problems: list[PresetProblem],
    read: Callable[[_Source, list[PresetProblem]], Node | None],
) -> tuple[list[Node], bool]:
    """A preset and all it starts from, topmost first, and whether all of it could be had."""
    layers: list[Node] = []
    above: list[str] = []
    while source is not None:
        above.append(source.identity)
        root = read(source, problems)
        if root is None:
            return layers, False
        entries = dict(root.value)
        extends = entries.pop(EXTENDS, None)
        layers.append(root._replace(value=entries))
        if extends is None or extends.value is None:
            return layers, True
        if isinstance(extends.value, Refused):
            return layers, False
        try:
            source = _base(extends, source, above)
        except UnusableError as error:
            problems.append(extends.problem(error.message, quoted(plain(extends))))
            return layers, False
    return layers, False


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


# --- The skills that a tree knows ----------------------------------------------------------------

_LEARNER: Final[Key] = ("learner",)
_OPTIONS: Final[Key] = ("learner", "options")
_CUSTOM_SKILLS: Final[Key] = ("learner", "custom_skills")
_TIMERS: Final[Key] = ("schedule", "skills")
_EPISODES: Final[Key] = ("schedule", "episodes")

_SKILL_NAME: Final = TypeAdapter(SkillName)


def _is_skill_name(word: object) -> bool:
    try:
        _SKILL_NAME.validate_python(word, strict=True)
    except ValidationError:
        return False
    return True


def _within(tree: Node, key: Key) -> Iterator[tuple[str | int, Node]]:
    """What is within the place at a key; nothing if there is no such place."""
    node, rest = descend(tree, key)
    if not rest:
        yield from children(node)


def _defined(tree: Node) -> list[str]:
    """Skills of one's own that a tree defines."""
    return [str(name) for name, _ in _within(tree, _CUSTOM_SKILLS) if _is_skill_name(name)]


def _mentioned(tree: Node) -> list[str]:
    """What the options and the schedule of a tree take for the names of skills."""
    words = [
        *(option.value for _, option in _within(tree, _OPTIONS)),
        *(skill for skill, _ in _within(tree, _TIMERS)),
        *(
            child.value
            for _, episode in _within(tree, _EPISODES)
            for part, child in children(episode)
            if part == "skill"
        ),
    ]
    return list(dict.fromkeys(word for word in words if _is_skill_name(word)))


def _could_be_had(tree: Node) -> bool:
    """Is nothing in the place of the custom skills, or of what they are in, but a mapping?"""
    return isinstance(descend(tree, _CUSTOM_SKILLS)[0].value, dict)


def _known_skills(tree: Node, complete: bool) -> tuple[str, ...]:
    """The skills that a tree knows. Where some may have been lost, it may know any."""
    names = [*SKILLS, *_defined(tree)]
    if not complete or not _could_be_had(tree):
        names += _mentioned(tree)
    return tuple(dict.fromkeys(names))


def _with_custom_skills(tree: Node, names: Iterable[str]) -> Node:
    """A tree in which skills of these names are defined."""
    defined = {*SKILLS, *_defined(tree)}
    for name in names:
        if name not in defined:
            key = (*_CUSTOM_SKILLS, name)
            tree = placed(tree, key, as_tree({}, key, tree.place))
    return tree


# --- From a tree to a run ------------------------------------------------------------------------


def _every_skill(tree: Node) -> list[str]:
    """As many of the known skills as there may be options; first those that are scheduled."""
    known = dict.fromkeys([*SKILLS, *_defined(tree)])
    scheduled = set(_mentioned(tree))
    chosen = sorted(known, key=lambda name: name not in scheduled)[:MAX_ACTIONS]
    return [name for name in known if name in chosen]


# What takes the place of a missing or wrong value that a run cannot be judged without. Each faults
# nothing that was not wrong before: the finest grid, every skill, the longest run.
_STAND_INS: Final[dict[Key, Callable[[Node], Any]]] = {
    ("world", "size"): lambda _: 400,
    _LEARNER: lambda _: {},
    ("learner", "alpha"): lambda _: 0.0,
    _CUSTOM_SKILLS: lambda tree: {name: {} for name in _mentioned(tree) if name not in SKILLS},
    _OPTIONS: _every_skill,
    ("trials",): lambda _: MAX_TRIALS,
}
_OF_A_LEARNER: Final[set[Key]] = {("learner", "alpha"), _CUSTOM_SKILLS, _OPTIONS}
"""What a learner that nothing is left of needs."""


def _located(tree: Node, fault: Fault) -> PresetProblem:
    node, rest = descend(tree, fault.key)
    value = fault.value if rest else quoted(plain(node))
    return node._replace(key=(*node.key, *rest)).problem(fault.message, value)


def _without_nulls(
    node: Node, at: Key, skills: Collection[str], problems: list[PresetProblem]
) -> Node:
    """A key set to null is as if it had not been given, where there is such a key to leave out."""
    match node.value:
        case list():
            items = [
                _without_nulls(child, (*at, index), skills, problems)
                for index, child in enumerate(node.value)
            ]
            return node._replace(value=items)
        case dict():
            entries = {}
            for name, child in node.value.items():
                if child.value is not None:
                    entries[name] = _without_nulls(child, (*at, name), skills, problems)
                    continue
                names = skills if at == _TIMERS else names_of(slot_of(at))
                slot = slot_of((*at, name))
                if names and name not in names:
                    problems.append(child.problem(unknown_key(name, names), "null"))
                elif slot is not None and not slot.optional:
                    entries[name] = child
            return node._replace(value=entries)
        case _:
            return node


def _refused(node: Node, at: Key = ()) -> Iterator[Key]:
    """Where a tree holds values that were not read."""
    if isinstance(node.value, Refused):
        yield at
    for part, child in children(node):
        yield from _refused(child, (*at, part))


def _droppable(key: Key) -> Key:
    """The least part of a preset that holds a wrong value and that the rest can be judged without.

    An item of a list goes as a whole, and so do options: without one of their values they would
    mean something else.
    """
    for length in range(1, len(key) + 1):
        slot = slot_of(key[:length])
        if slot is not None and (slot.in_item or slot.is_union):
            return key[:length]
    for length in range(len(key), 1, -1):
        slot = slot_of(key[:length])
        if slot is None or slot.optional or key[:length] in _STAND_INS:
            return key[:length]
    return key[:1]


def _mended(tree: Node, wrong: Collection[Key]) -> Node:
    """A tree without what is wrong in it, so that the rest can be judged."""
    if not wrong:
        return tree
    dropped = {_droppable(key) for key in wrong}
    # When a skill joins decides when its episodes start: without its timer they would seem to
    # overlap, or not to.
    timers = [key[2] for key in dropped if len(key) == 3 and key[:2] == _TIMERS]
    for index, episode in _within(tree, _EPISODES):
        if any(part == "skill" and child.value in timers for part, child in children(episode)):
            dropped.add((*_EPISODES, index))
    if _LEARNER in dropped:
        dropped |= _OF_A_LEARNER
    tree = _without(tree, (), dropped)
    # A skill whose weights are wrong is one all the same.
    skills = [str(key[2]) for key in dropped if len(key) == 3 and key[:2] == _CUSTOM_SKILLS]
    tree = _with_custom_skills(tree, filter(_is_skill_name, skills))
    for key in sorted(dropped & _STAND_INS.keys()):
        tree = placed(tree, key, as_tree(_STAND_INS[key](tree), key, tree.place))
    return tree


def _without(node: Node, at: Key, dropped: set[Key]) -> Node:
    kept = [
        (part, _without(child, (*at, part), dropped))
        for part, child in children(node)
        if (*at, part) not in dropped
    ]
    match node.value:
        case dict():
            return node._replace(value=dict(kept))
        case list():
            return node._replace(value=[child for _, child in kept])
        case _:
            return node


def _validated(tree: Node, complete: bool, problems: list[PresetProblem]) -> RunSpec:
    """The run that a merged tree states; raises `PresetError` if there are any problems."""
    skills = _known_skills(tree, complete)
    tree = _without_nulls(tree, (), skills, problems)
    if not complete and _could_be_had(tree):
        tree = _with_custom_skills(tree, skills)
    tree = _mended(tree, list(_refused(tree)))
    spec = None
    while spec is None:
        try:
            spec = RunSpec.model_validate(plain(tree))
        except ValidationError as error:
            # What is missing may have been in a part that could not be had.
            faults = list(faults_of(error, skills))
            problems += [_located(tree, f) for f in faults if complete or not f.is_missing]
            mended = _mended(tree, [fault.key for fault in faults])
            if plain(mended) == plain(tree):
                break
            tree = mended
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
    """The presets that an experiment starts from: however often one is named, it is read once."""

    def __init__(self, folder: Path | None) -> None:
        """Paths start at the folder; without one, there are shipped presets alone."""
        self._folder = folder
        self._bases: dict[str, Base] = {}
        self._documents: dict[str, tuple[Node | None, tuple[PresetProblem, ...]]] = {}
        self._n_bytes = 0

    def base_of(self, name: str) -> Base:
        """A shipped preset, or the file at a path; raises `UnusableError` alone."""
        source = _opened(name, self._folder)
        if source.identity not in self._bases:
            problems: list[PresetProblem] = []
            tree, complete = _stacked(source, problems, self._read)
            self._bases[source.identity] = Base(tree, complete, tuple(problems))
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

    def _read(self, source: _Source, problems: list[PresetProblem]) -> Node | None:
        if source.identity not in self._documents:
            self._n_bytes += len(source.data)
            if self._n_bytes > MAX_SHELF_BYTES:
                message = f"is one preset too many; allowed: {MAX_SHELF_BYTES} bytes in all of them"
                raise UnusableError(message)
            found: list[PresetProblem] = []
            root = document_of(source.data, source.label, found)
            self._documents[source.identity] = root, tuple(found)
        root, noted = self._documents[source.identity]
        problems += noted
        return root


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


def _read(source: _Source, problems: list[PresetProblem]) -> Node | None:
    return document_of(source.data, source.label, problems)


def _stacked(
    source: _Source | None,
    problems: list[PresetProblem],
    read: Callable[[_Source, list[PresetProblem]], Node | None] = _read,
) -> tuple[Node, bool]:
    """A preset on top of all it starts from, and whether all of it could be had."""
    layers, complete = _layers(source, problems, read)
    tree = Node((), {}, Place("" if source is None else source.label, 1))
    for layer in reversed(layers):
        tree = merged(tree, layer)
    return tree, complete


def _run(source: _Source | None, settings: Iterable[str], problems: list[PresetProblem]) -> RunSpec:
    tree, complete = _stacked(source, problems)
    for setting in settings:
        tree = _with_setting(tree, setting, problems)
    return _validated(tree, complete, problems)


# --- Reading and writing -------------------------------------------------------------------------


def load(name_or_path: str, settings: Sequence[str] = ()) -> RunSpec:
    """Read a shipped preset or a file, with ``KEY=VALUE`` settings on top.

    A name that is shipped is never taken for a path; ``./timed`` is one, and ``-`` is standard
    input. Raises `PresetError`.
    """
    problems: list[PresetProblem] = []
    source: _Source | None = None
    label = called(name_or_path)
    try:
        if name_or_path == STDIN:
            source = _Source(label, standard_input(), name_or_path, Path())
        else:
            source = _opened(name_or_path, Path())
    except UnusableError as error:
        problems.append(PresetProblem(label, error.line, "", None, error.message))
    return _run(source, settings, problems)


def parse(text: bytes | str, source: str) -> RunSpec:
    """Read a preset from a text; ``source`` is what its problems call it.

    It may start from shipped presets alone: no other file is looked at. Raises `PresetError`.
    """
    return _run(_Source(printable(source, MAX_NAME), text, "", None), (), [])


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
