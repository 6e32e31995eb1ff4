"""Presets: from a name, a file or a text to a validated run, with every error at once.

A preset passes through four stages, each of which notes what is wrong and carries on:

- *text*: a small, plain file in UTF-8;
- *tree*: its values, each with the file and line it came from. It is built from YAML's events, so
  that nothing is expanded, constructed or overwritten before it has been looked at;
- *merge*: the presets it starts from (``extends``) below it, settings (``--set``) on top;
- *run*: the models' verdict. What they fault is replaced by something harmless and they are asked
  again, because they compare values with each other only once every value is fine by itself.
"""

import os
import re
import stat
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache, lru_cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Final, Literal, NamedTuple, Union, get_args, get_origin

import yaml
from pydantic import BaseModel, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails
from yaml import events

from learners.rows import MAX_ACTIONS
from learners.skills import SKILLS
from learners.spec import MAX_TRIALS, RunSpec, SkillName, did_you_mean, listed
from sim.spec import ProblemsError

MAX_BYTES: Final = 64 * 1024
MAX_NODES: Final = 2_000
"""Values in one preset; the longest shipped one has about thirty."""
MAX_DEPTH: Final = 20
MAX_DIGITS: Final = 18
"""Of a whole number: what fits 64 bits, and far below what Python refuses to convert."""
MAX_BASES: Final = 8
"""Presets below one another by ``extends``."""
MAX_SHELF_BYTES: Final = (MAX_BASES + 2) * MAX_BYTES
"""Of all files that the presets of one experiment are read from: hundreds of ordinary ones."""
MAX_SHOWN: Final = 80
"""Characters of a value or a key that a problem quotes."""
MAX_NAME: Final = 1_024
"""Characters of a file's name or of a setting that a problem is said to be in."""

EXTENDS: Final = "extends"

_FIRST: Final = ("standard_q", "hierarchical_2", "hierarchical_3", "timed")
"""Presets of the thesis, in its order; others follow by name."""

Key = tuple[str | int, ...]


# --- Problems ------------------------------------------------------------------------------------


class PresetProblem(NamedTuple):
    """One thing that is wrong with a preset. Every text is printable and bounded."""

    source: str
    """File, or ``--set KEY=VALUE``."""
    line: int | None
    """From 1; None where there is no file to point into."""
    key: str
    """Dotted, such as ``schedule.episodes.0.at``; empty if the whole source is meant."""
    value: str | None
    """As quoted; None where there is none, such as for a key that is missing."""
    message: str
    """What is wrong and what is allowed."""

    def __str__(self) -> str:
        where = self.source if self.line is None else f"{self.source}:{self.line}"
        value = None if self.value is None else f"value {self.value}"
        return ": ".join(part for part in (where, self.key, value, self.message) if part)


class PresetError(ValueError):
    """A preset that cannot be used; carries everything that is wrong with it."""

    def __init__(self, problems: Iterable[PresetProblem]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(map(str, self.problems)))


class UnusableError(Exception):
    """A file, a text or a setting that nothing can be read from."""

    def __init__(self, message: str, line: int | None = None) -> None:
        self.message = message
        self.line = line
        super().__init__(message)


def _bounded(text: str, longest: int = MAX_SHOWN) -> str:
    return text if len(text) <= longest else text[: longest - 1] + "…"


def printable(text: str, longest: int = MAX_SHOWN) -> str:
    """A name as it may be shown in a terminal: no line breaks, no escape sequences."""
    clean = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
    return _bounded(clean, longest)


def quoted(value: object) -> str:
    """A value as a problem quotes it, near to how YAML writes it."""
    match value:
        case None:
            return "null"
        case bool():
            return str(value).lower()
        case _:
            return _bounded(repr(value))


def dotted(key: Key) -> str:
    return ".".join(
        str(part) if re.fullmatch(r"[\w-]{1,40}", str(part)) else quoted(part) for part in key
    )


# --- Tree: values that know where they came from -------------------------------------------------


class Place(NamedTuple):
    source: str
    line: int | None


class _Refused:
    """Stands for a value that was not read, and whose problem has been noted."""


REFUSED: Final = _Refused()


class Node(NamedTuple):
    """A value, a list of nodes, or a mapping to nodes."""

    key: Key
    """As the user wrote it: it stays when items before it are taken out of a list."""
    value: Any
    place: Place

    def problem(self, message: str, value: str | None = None) -> PresetProblem:
        return PresetProblem(*self.place, dotted(self.key), value, message)


def plain(node: Node) -> Any:
    match node.value:
        case dict():
            return {name: plain(child) for name, child in node.value.items()}
        case list():
            return [plain(child) for child in node.value]
        case _:
            return node.value


def n_values(node: Node) -> int:
    """Values in a tree, as `MAX_NODES` counts them."""
    return 1 + sum(n_values(child) for _, child in children(node))


def children(node: Node) -> Iterator[tuple[str | int, Node]]:
    match node.value:
        case dict():
            yield from node.value.items()
        case list():
            yield from enumerate(node.value)


def _descend(tree: Node, key: Key) -> tuple[Node, Key]:
    """The node at a key, or the nearest one above it and what is left of the key."""
    for depth, part in enumerate(key):
        child = dict(children(tree)).get(part)
        if child is None:
            return tree, key[depth:]
        tree = child
    return tree, ()


def _merged(base: Node, top: Node) -> Node:
    """Mappings are merged; a list or any other value replaces what is below it."""
    if not isinstance(base.value, dict) or not isinstance(top.value, dict):
        return top
    value = dict(base.value)
    for name, child in top.value.items():
        value[name] = _merged(value[name], child) if name in value else child
    return top._replace(value=value)


# --- From a text to a tree -----------------------------------------------------------------------

# YAML 1.2's core schema. PyYAML's own rules are those of YAML 1.1, in which `1:30` is 90, `010` is
# 8, `no` is false and `1e5` is a text. Whatever these do not match is a text, and so a type error
# that is seen wherever a number was meant.
_NULL: Final = re.compile(r"~|null|Null|NULL|")
_BOOL: Final = re.compile(r"(true|True|TRUE)|false|False|FALSE")
_INT: Final = re.compile(r"[-+]?(0|[1-9][0-9]*)")
_FLOAT: Final = re.compile(r"[-+]?([0-9]+\.[0-9]*|\.[0-9]+|[0-9]+(?=[eE]))([eE][-+]?[0-9]+)?")
_NOT_FINITE: Final = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")


def _scalar(text: str) -> bool | int | float | str | None:
    """What an unquoted text stands for."""
    if _NULL.fullmatch(text):
        return None
    if match := _BOOL.fullmatch(text):
        return match[1] is not None
    if _INT.fullmatch(text):
        return int(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    if _NOT_FINITE.fullmatch(text):
        return float(text.replace(".", ""))
    return text


class _TreeBuilder:
    """Builds the tree of one document out of YAML's events."""

    def __init__(self, text: str, root: Node, problems: list[PresetProblem]) -> None:
        self._events = yaml.parse(text, Loader=yaml.SafeLoader)
        self._root = root
        self._problems = problems
        self._nodes = 0

    def build(self) -> Node | None:
        """The document of the text, or None if it has none."""
        self._next()  # the stream's start
        if not isinstance(self._next(), events.DocumentStartEvent):
            return None
        first = self._next()
        root = self._node(first, self._root.key, first.start_mark.line)
        self._next()  # the document's end
        second = self._next()
        if isinstance(second, events.DocumentStartEvent):
            node = Node(self._root.key, None, self._place(second.start_mark.line))
            self._problems.append(node.problem("a second document starts; allowed: one document"))
        return root

    def _next(self) -> events.Event:
        return next(self._events)

    def _place(self, line: int) -> Place:
        place = self._root.place
        return place if place.line is None else place._replace(line=line + 1)

    def _node(self, event: events.Event, key: Key, line: int) -> Node:
        self._nodes += 1
        if self._nodes > MAX_NODES:
            raise UnusableError(f"has too many values; allowed: {MAX_NODES}", line + 1)
        if len(key) > MAX_DEPTH:
            raise UnusableError(f"is nested too deeply; allowed: {MAX_DEPTH} levels", line + 1)
        node = Node(key, REFUSED, self._place(line))
        refusal = _refusal(event)
        if refusal is not None:
            self._problems.append(node.problem(refusal.message, refusal.shown))
        value = self._value(event, key)
        # An anchor alone does not make its own value doubtful, so that is looked at further.
        return node._replace(value=value) if refusal is None or refusal.readable else node

    def _value(self, event: events.Event, key: Key) -> Any:
        match event:
            case events.ScalarEvent():
                return event.value if _is_quoted(event) or _is_huge(event) else _scalar(event.value)
            case events.SequenceStartEvent():
                return self._items(key)
            case events.MappingStartEvent():
                return self._entries(key)
            case _:  # an alias, which is never followed
                return REFUSED

    def _items(self, key: Key) -> list[Node]:
        items: list[Node] = []
        while not isinstance(event := self._next(), events.SequenceEndEvent):
            items.append(self._node(event, (*key, len(items)), event.start_mark.line))
        return items

    def _entries(self, key: Key) -> dict[str, Node]:
        entries: dict[str, Node] = {}
        while not isinstance(event := self._next(), events.MappingEndEvent):
            line = event.start_mark.line
            name = self._name(event, key)
            child = self._node(self._next(), (*key, "?" if name is None else name), line)
            if name is None:
                continue
            if name in entries:
                # YAML would silently keep the last.
                first = entries[name].place.line
                where = "" if first is None else f", first on line {first}"
                message = f"is given twice{where}; allowed: once"
                self._problems.append(child.problem(message, quoted(plain(child))))
            else:
                entries[name] = child
        return entries

    def _name(self, event: events.Event, key: Key) -> str | None:
        """A key of a mapping as written, so that `on` and `1` are the texts they look like."""
        if isinstance(event, events.ScalarEvent) and not _refusal(event):
            if event.value != "<<" or _is_quoted(event):
                return event.value
            node = Node((*key, "<<"), None, self._place(event.start_mark.line))
            self._problems.append(node.problem(f"merges are not read; allowed: {EXTENDS}"))
            return None
        node = self._node(event, (*key, "?"), event.start_mark.line)
        if not _refusal(event):
            self._problems.append(node.problem("is no key; allowed: a text", quoted(plain(node))))
        return None


class _Refusal(NamedTuple):
    shown: str
    message: str
    readable: bool = False


def _refusal(event: events.Event) -> _Refusal | None:
    """Why a value is not read, if it is not."""
    if isinstance(event, events.AliasEvent):
        message = "aliases are not read; allowed: the value itself, written out"
        return _Refusal(printable(f"*{event.anchor}"), message)
    if tag := getattr(event, "tag", None):
        shown = printable(tag.replace("tag:yaml.org,2002:", "!!"))
        return _Refusal(shown, "tags are not read; allowed: the value alone")
    if anchor := getattr(event, "anchor", None):
        message = "anchors are not read; allowed: the value alone"
        return _Refusal(printable(f"&{anchor}"), message, readable=True)
    if not isinstance(event, events.ScalarEvent):
        return None
    if _is_huge(event):
        message = f"has too many digits; allowed: at most {MAX_DIGITS}"
        return _Refusal(_bounded(event.value), message)
    if any("\ud800" <= character <= "\udfff" for character in event.value):
        return _Refusal(quoted(event.value), "has half a character; allowed: whole ones")
    return None


def _is_quoted(event: events.ScalarEvent) -> bool:
    return not event.implicit[0]


def _is_huge(event: events.ScalarEvent) -> bool:
    digits = len(event.value.lstrip("+-"))
    return digits > MAX_DIGITS and not _is_quoted(event) and bool(_INT.fullmatch(event.value))


def _text(data: bytes | str) -> str:
    """The text of a preset, if it can be one."""
    size = len(data) if isinstance(data, bytes) else len(data.encode(errors="surrogatepass"))
    if size > MAX_BYTES:
        raise UnusableError(f"is too large; allowed: at most {MAX_BYTES} bytes")
    if isinstance(data, str):
        return data.removeprefix("\N{BYTE ORDER MARK}")
    if b"\0" in data:
        raise UnusableError("is not a text: it contains a NUL byte; allowed: UTF-8")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = 1 + data.count(b"\n", 0, error.start)
        raise UnusableError("is not a text; allowed: UTF-8", line) from None


def _built(data: bytes | str, key: Key, place: Place, problems: list[PresetProblem]) -> Node | None:
    """The tree of a text, or None if it has none; raises `UnusableError` alone."""
    text = _text(data)
    try:
        return _TreeBuilder(text, Node(key, None, place), problems).build()
    except yaml.MarkedYAMLError as error:
        line = None if error.problem_mark is None else error.problem_mark.line + 1
        raise UnusableError(f"is not YAML: {printable(str(error.problem))}", line) from None
    except yaml.reader.ReaderError as error:
        line = 1 + text.count("\n", 0, error.position)
        character = f"U+{error.character:04X}"
        message = f"is not YAML: it contains the control character {character}"
        raise UnusableError(message, line) from None
    except (ValueError, OverflowError):
        # PyYAML converts escapes such as "\UFFFFFFFF" and version numbers without looking at them.
        raise UnusableError("is not YAML: an escape or a version is out of range") from None


def document_of(data: bytes | str, source: str, problems: list[PresetProblem]) -> Node | None:
    """The tree of a preset's text; None, with the problem noted, if it is not a mapping."""
    place = Place(source, 1)
    try:
        root = _built(data, (), place, problems)
    except UnusableError as error:
        problems.append(PresetProblem(source, error.line, "", None, error.message))
        return None
    if root is None or root.value is None:
        problems.append(Node((), None, place).problem("is empty; allowed: a mapping of keys"))
        return None
    if not isinstance(root.value, dict):
        if root.value is not REFUSED:
            shown = quoted(plain(root))
            problems.append(root.problem("must be a mapping; allowed: a mapping of keys", shown))
        return None
    return root


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
    path = folder / name
    try:
        data = file_of(path)
    except (FileNotFoundError, NotADirectoryError):
        hint = did_you_mean(name, presets)
        message = f"is neither a shipped preset nor a file{hint}; allowed: {names}, or a path"
        raise UnusableError(message) from None
    except OSError as error:
        raise UnusableError(f"cannot be read: {error.strerror}") from None
    except ValueError:
        raise UnusableError("is not a path: it contains a NUL character") from None
    return _Source(printable(str(path), MAX_NAME), data, os.path.realpath(path), path.parent)


def file_of(path: Path) -> bytes:
    """What a file holds, if it is one and small: both are seen before anything is read."""
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise UnusableError("is a directory; allowed: a file")
    if not stat.S_ISREG(status.st_mode):
        raise UnusableError("is not a regular file; allowed: a file")
    if status.st_size > MAX_BYTES:
        message = f"is too large, {status.st_size} bytes; allowed: at most {MAX_BYTES} bytes"
        raise UnusableError(message)
    with path.open("rb") as file:
        return file.read(MAX_BYTES + 1)


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
        if extends.value is REFUSED:
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
    name, equals, text = setting.partition("=")
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
        return _placed(tree, path, _built(text, path, place, problems) or node)
    except UnusableError as error:
        problems.append(node.problem(error.message))
        return tree


def _placed(node: Node, path: Key, top: Node) -> Node:
    """A tree with another merged into it at a path."""
    if not path:
        return _merged(node, top)
    part, *rest = path
    match node.value:
        case list():
            items = list(node.value)
            index = next((i for i in range(len(items)) if str(i) == part), None)
            if index is None:
                allowed = f"0 to {len(items) - 1}" if items else "none, for it is empty"
                what = f"{dotted(node.key)} has no item {quoted(part)}"
                raise UnusableError(f"{what}; allowed: {allowed}")
            items[index] = _placed(items[index], tuple(rest), top)
            return node._replace(value=items)
        case None | dict() | _Refused():
            entries = node.value if isinstance(node.value, dict) else {}
            child = entries.get(part, Node((*node.key, part), None, top.place))
            return node._replace(value={**entries, part: _placed(child, tuple(rest), top)})
        case _:
            raise UnusableError(f"{dotted(node.key)} is {quoted(node.value)}, which has no keys")


# --- What the models allow -----------------------------------------------------------------------


class _Slot(NamedTuple):
    """What the models say of one place in a preset."""

    kind: Any
    """Type, without its annotations."""
    limits: tuple[Any, ...] = ()
    text: str | None = None
    """What is allowed, where the model says so itself."""
    optional: bool = False
    in_item: bool = False
    """Is an item of a list, or part of one."""


@lru_cache(maxsize=1024)  # Not more: a mapping of free keys has no end of places.
def _slot(key: Key) -> _Slot | None:
    """The slot at a key, or None if the models have no such place."""
    slot: _Slot | None = _Slot(RunSpec)
    for part in key:
        slot = None if slot is None else _inner(slot, part)
    return slot


def _inner(slot: _Slot, part: str | int) -> _Slot | None:
    if _is_model(slot.kind):
        field = slot.kind.model_fields.get(part)
        if field is None:
            return None
        optional = not field.is_required()
        limits = tuple(field.metadata)
        return _Slot(field.annotation, limits, field.description, optional, slot.in_item)
    arguments = get_args(slot.kind)
    if get_origin(slot.kind) is dict:
        return _of_type(arguments[1], optional=True)
    if get_origin(slot.kind) is tuple and isinstance(part, int):
        if arguments[-1] is Ellipsis:
            return _of_type(arguments[0], optional=True, in_item=True)
        if part < len(arguments):
            return _of_type(arguments[part], slot.text)
    return None


def _name_of(mapping: _Slot | None) -> _Slot | None:
    """The slot of the keys of a mapping in which they are free."""
    if mapping is None or get_origin(mapping.kind) is not dict:
        return None
    return _of_type(get_args(mapping.kind)[0])


def _of_type(
    annotation: Any, text: str | None = None, optional: bool = False, in_item: bool = False
) -> _Slot:
    limits: list[Any] = []
    if get_origin(annotation) is Annotated:
        annotation, *metadata = get_args(annotation)
        for item in metadata:
            if isinstance(item, FieldInfo):
                limits.extend(item.metadata)
                text = text or item.description
            else:
                limits.append(item)
    return _Slot(annotation, tuple(limits), text, optional, in_item)


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _is_union(kind: Any) -> bool:
    return get_origin(kind) in (Union, UnionType)


def _names(slot: _Slot | None) -> tuple[str, ...]:
    """Keys that a mapping may have; none where there is no mapping, or keys are free."""
    if slot is None or not _is_model(slot.kind):
        return ()
    return (*((EXTENDS,) if slot.kind is RunSpec else ()), *slot.kind.model_fields)


_LIMITS: Final = {
    "ge": "at least",
    "gt": "above",
    "le": "at most",
    "lt": "below",
    "multiple_of": "multiples of",
}


def _number(value: float) -> str:
    return f"{value:.0f}" if value == int(value) else f"{value:g}"


def _range(limits: Iterable[Any]) -> str:
    """Limits of a number in words, such as ``8 to 48, multiples of 8``."""
    limit = {
        name: _number(getattr(item, name))
        for item in limits
        for name in _LIMITS
        if getattr(item, name, None) is not None
    }
    both = [f"{limit.pop('ge')} to {limit.pop('le')}"] if limit.keys() >= {"ge", "le"} else []
    return ", ".join([*both, *(f"{_LIMITS[name]} {number}" for name, number in limit.items())])


def _allowed(slot: _Slot) -> str:
    """What a place in a preset allows, in words."""
    arguments = get_args(slot.kind)
    origin = get_origin(slot.kind)
    if slot.text:
        return slot.text
    if names := _names(slot):
        return f"the keys {', '.join(names)}"
    if origin is Literal:
        return ", ".join(map(str, arguments))
    if _is_union(slot.kind):
        return ", or ".join(_allowed(_of_type(argument)) for argument in arguments)
    if origin is tuple and arguments[-1] is Ellipsis:
        return f"a list, each item {_allowed(_of_type(arguments[0]))}"
    if origin is dict:
        name, value = (_allowed(_of_type(argument)) for argument in arguments)
        return f"a mapping, each key {name}, each value {value}"
    if slot.kind is str:
        longest = next((m.max_length for m in slot.limits if hasattr(m, "max_length")), None)
        return "a text" if longest is None else f"a text of up to {longest} characters"
    return _range(slot.limits) or {int: "a whole number", float: "a number"}.get(slot.kind, "")


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
    node, rest = _descend(tree, key)
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
    return isinstance(_descend(tree, _CUSTOM_SKILLS)[0].value, dict)


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
            tree = _placed(tree, key, _as_tree({}, key, tree.place))
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

_WRONG: Final = {
    "missing": "is missing",
    "int_type": "must be a whole number",
    "float_type": "must be a number",
    "string_type": "must be a text",
    "string_too_long": "is too long",
    "string_pattern_mismatch": "is not a plain name",
    "model_type": "must be a mapping",
    "dict_type": "must be a mapping",
    "tuple_type": "must be a list",
    "too_long": "has too many items",
    "too_short": "has too few items",
    "literal_error": "is not among what is allowed",
    "finite_number": "must be finite",
    "greater_than_equal": "must be at least {ge}",
    "greater_than": "must be more than {gt}",
    "less_than_equal": "must be at most {le}",
    "less_than": "must be less than {lt}",
    "multiple_of": "must be a multiple of {multiple_of}",
}
"""What a kind of error of pydantic means, in the words of a preset."""


class _Fault(NamedTuple):
    """Something that the models say is wrong."""

    key: Key
    message: str
    value: str | None = None
    """What the models took the value to be, for where the preset states none."""
    is_missing: bool = False


def _faults(error: ValidationError, skills: Collection[str]) -> Iterator[_Fault]:
    """What the models say, with hints at the skills that a tree knows."""
    for found in error.errors(include_url=False):
        key: Key = found["loc"]
        cause = found.get("ctx", {}).get("error")
        if isinstance(cause, ProblemsError):
            for problem in cause.problems:
                yield _Fault((*key, *problem.key), problem.message, quoted(problem.value))
        elif cause is not None:
            text = str(cause)
            yield _Fault(key, f"cannot be used; {text}" if text.startswith("allowed:") else text)
        elif found["type"] == "extra_forbidden":
            yield _Fault(key, _unknown(key[-1], _names(_slot(key[:-1]))))
        else:
            yield _malformed(found, skills)


def _unknown(name: str | int, names: Collection[str]) -> str:
    return f"is not a known key{did_you_mean(name, names)}; allowed: {listed(names)}"


def _malformed(found: ErrorDetails, skills: Collection[str]) -> _Fault:
    kind, word, key = found["type"], found["input"], found["loc"]
    limits = found.get("ctx", {}).items()
    numbers = {name: _number(x) for name, x in limits if isinstance(x, int | float)}
    message = _WRONG.get(kind, "cannot be used").format_map(numbers)
    slot = _slot(key)
    if kind.startswith("string_"):
        if key[-1] == "[key]":
            message, key = "is not a possible key", key[:-1]
            slot = _name_of(_slot(key[:-1]))
        if key[0] == "schedule" and isinstance(word, str):
            message += did_you_mean(word, skills)
    allowed = "" if slot is None else _allowed(slot)
    return _Fault(
        key, f"{message}; allowed: {allowed}" if allowed else message, None, kind == "missing"
    )


def _located(tree: Node, fault: _Fault) -> PresetProblem:
    node, rest = _descend(tree, fault.key)
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
                names = skills if at == _TIMERS else _names(_slot(at))
                slot = _slot((*at, name))
                if names and name not in names:
                    problems.append(child.problem(_unknown(name, names), "null"))
                elif slot is not None and not slot.optional:
                    entries[name] = child
            return node._replace(value=entries)
        case _:
            return node


def _refused(node: Node, at: Key = ()) -> Iterator[Key]:
    """Where a tree holds values that were not read."""
    if node.value is REFUSED:
        yield at
    for part, child in children(node):
        yield from _refused(child, (*at, part))


def _droppable(key: Key) -> Key:
    """The least part of a preset that holds a wrong value and that the rest can be judged without.

    An item of a list goes as a whole, and so do options: without one of their values they would
    mean something else.
    """
    for length in range(1, len(key) + 1):
        slot = _slot(key[:length])
        if slot is not None and (slot.in_item or _is_union(slot.kind)):
            return key[:length]
    for length in range(len(key), 1, -1):
        slot = _slot(key[:length])
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
        tree = _placed(tree, key, _as_tree(_STAND_INS[key](tree), key, tree.place))
    return tree


def _as_tree(value: Any, key: Key, place: Place) -> Node:
    if isinstance(value, dict):
        value = {name: _as_tree(inner, (*key, name), place) for name, inner in value.items()}
    elif isinstance(value, list):
        value = [_as_tree(inner, (*key, index), place) for index, inner in enumerate(value)]
    return Node(key, value, place)


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
            faults = list(_faults(error, skills))
            problems += [_located(tree, f) for f in faults if complete or not f.is_missing]
            mended = _mended(tree, [fault.key for fault in faults])
            if plain(mended) == plain(tree):
                break
            tree = mended
    if problems or spec is None:
        raise PresetError(in_order(problems))
    return spec


def in_order(problems: Iterable[PresetProblem]) -> list[PresetProblem]:
    """By source, as each first came up, and then by line."""
    found = list(problems)
    sources = list(dict.fromkeys(problem.source for problem in found))
    return sorted(found, key=lambda problem: (sources.index(problem.source), problem.line or 0))


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
        if extends is not None:
            if not isinstance(extends.value, str):
                raise UnusableError(f"must be a text; allowed: {', '.join(shipped())}, or a path")
            below = self.base_of(extends.value)
        return below._replace(tree=_merged(below.tree, node._replace(value=entries)))

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
            tree = _placed(tree, setting.key, setting)
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
        tree = _merged(tree, layer)
    return tree, complete


def _run(source: _Source | None, settings: Iterable[str], problems: list[PresetProblem]) -> RunSpec:
    tree, complete = _stacked(source, problems)
    for setting in settings:
        tree = _with_setting(tree, setting, problems)
    return _validated(tree, complete, problems)


# --- Reading and writing -------------------------------------------------------------------------


def load(name_or_path: str, settings: Sequence[str] = ()) -> RunSpec:
    """Read a shipped preset or a file, with ``KEY=VALUE`` settings on top.

    A name that is shipped is never taken for a path; ``./timed`` is one. Raises `PresetError`.
    """
    problems: list[PresetProblem] = []
    source: _Source | None = None
    try:
        source = _opened(name_or_path, Path())
    except UnusableError as error:
        label = printable(name_or_path, MAX_NAME) or "''"
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
    """Writes so that :func:`_scalar` reads the same back."""

    def ignore_aliases(self, data: object) -> bool:
        return True


def _represent_text(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    is_word = text.isascii() and text.isidentifier() and _scalar(text) == text
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
