"""Documents: from a text in YAML to a tree whose values know their lines, and what is wrong there.

The tree is built from YAML's events, so that nothing is expanded, constructed or overwritten before
it has been looked at. How large, deep and long anything may be is bounded here.
"""

import codecs
import re
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import yaml
from yaml import events

from app.util.texts import as_text

MAX_BYTES: Final = 64 * 1024
MAX_NODES: Final = 2_000
"""Values in one preset; the longest shipped one has about thirty."""
MAX_DEPTH: Final = 20
MAX_DIGITS: Final = 19
"""Of a whole number: as many as the largest seed has, and far below what Python cannot convert."""
MAX_SHOWN: Final = 80
"""Characters of a value or a key that a problem quotes."""
MAX_NAME: Final = 1_024
"""Characters of a file's name or of a setting that a problem is said to be in."""

EXTENDS: Final = "extends"
"""The key under which a preset names the one it starts from."""

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
    known = as_text(text)
    clean = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in known)
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
    """A key as a problem states it."""
    return ".".join(
        str(part) if re.fullmatch(r"[\w-]{1,40}", str(part)) else quoted(part) for part in key
    )


def in_order(problems: Iterable[PresetProblem]) -> list[PresetProblem]:
    """By source, as each first came up, and then by line."""
    found = list(problems)
    sources = list(dict.fromkeys(problem.source for problem in found))
    return sorted(found, key=lambda problem: (sources.index(problem.source), problem.line or 0))


def key_of(name: str) -> Key:
    """The key of a preset that a dotted name stands for; raises `ValueError`."""
    key = tuple(name.split("."))
    if not all(key) or len(key) > MAX_DEPTH:
        raise ValueError("is not a key; allowed: a dotted key of a preset")
    if key[0] == EXTENDS:
        raise ValueError("cannot be varied; allowed: in a preset's file")
    return key


# --- Tree: values that know where they came from -------------------------------------------------


class Place(NamedTuple):
    """Where a value stands."""

    source: str
    line: int | None


@dataclass(frozen=True)
class Refused:
    """Stands for a value that was not read, and whose problem has been noted."""

    shown: str
    """As that problem quotes it, and so any other of a value that holds it."""

    def __repr__(self) -> str:
        return self.shown


class Node(NamedTuple):
    """A value, a list of nodes, or a mapping to nodes."""

    key: Key
    """As the user wrote it: it stays when items before it are taken out of a list."""
    value: Any
    place: Place

    def problem(self, message: str, value: str | None = None) -> PresetProblem:
        return PresetProblem(*self.place, dotted(self.key), value, message)


def plain(node: Node) -> Any:
    """The value of a tree, without its places."""
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
    """Entries of a mapping or items of a list, each with its part of the key; else nothing."""
    match node.value:
        case dict():
            yield from node.value.items()
        case list():
            yield from enumerate(node.value)


def descend(tree: Node, key: Key) -> tuple[Node, Key]:
    """The node at a key, or the nearest one above it and what is left of the key."""
    for depth, part in enumerate(key):
        child = dict(children(tree)).get(part)
        if child is None:
            return tree, key[depth:]
        tree = child
    return tree, ()


def without(node: Node, keys: Collection[Key], at: Key = ()) -> Node:
    """A tree without what is at these keys."""
    kept = {
        part: without(child, keys, (*at, part))
        for part, child in children(node)
        if (*at, part) not in keys
    }
    match node.value:
        case dict():
            return node._replace(value=kept)
        case list():
            return node._replace(value=list(kept.values()))
        case _:
            return node


def merged(base: Node, top: Node) -> Node:
    """Mappings are merged; a list or any other value replaces what is below it."""
    if not isinstance(base.value, dict) or not isinstance(top.value, dict):
        return top
    value = dict(base.value)
    for name, child in top.value.items():
        value[name] = merged(value[name], child) if name in value else child
    return top._replace(value=value)


def placed(node: Node, path: Key, top: Node) -> Node:
    """A tree with another merged into it at a path; raises `UnusableError` if it has no place."""
    if not path:
        return merged(node, top)
    part, *rest = path
    match node.value:
        case list():
            items = list(node.value)
            index = next((i for i in range(len(items)) if str(i) == part), None)
            if index is None:
                allowed = f"0 to {len(items) - 1}" if items else "none, for it is empty"
                what = f"{dotted(node.key)} has no item {quoted(part)}"
                raise UnusableError(f"{what}; allowed: {allowed}")
            items[index] = placed(items[index], tuple(rest), top)
            return node._replace(value=items)
        case None | dict() | Refused():
            entries = node.value if isinstance(node.value, dict) else {}
            child = entries.get(part, Node((*node.key, part), None, top.place))
            return node._replace(value={**entries, part: placed(child, tuple(rest), top)})
        case _:
            raise UnusableError(f"{dotted(node.key)} is {quoted(node.value)}, which has no keys")


# --- From a text to a tree -----------------------------------------------------------------------

# YAML 1.2's core schema. PyYAML's own rules are those of YAML 1.1, in which `1:30` is 90, `010` is
# 8, `no` is false and `1e5` is a text. Whatever these do not match is a text, and so a type error
# that is seen wherever a number was meant.
_NULL: Final = re.compile(r"~|null|Null|NULL|")
_BOOL: Final = re.compile(r"(true|True|TRUE)|false|False|FALSE")
_INT: Final = re.compile(r"[-+]?(0|[1-9][0-9]*)")
_FLOAT: Final = re.compile(r"[-+]?([0-9]+\.[0-9]*|\.[0-9]+|[0-9]+(?=[eE]))([eE][-+]?[0-9]+)?")
_NOT_FINITE: Final = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")


def scalar(text: str) -> bool | int | float | str | None:
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

    def __init__(
        self, text: str, root: Node, problems: list[PresetProblem], scalar: Callable[[str], Any]
    ) -> None:
        self._scalar = scalar
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
        node = Node(key, None, self._place(line))
        refusal = _refusal(event)
        if refusal is not None:
            self._problems.append(node.problem(refusal.message, refusal.shown))
        value = self._value(event, key)
        # An anchor alone does not make its own value doubtful, so that is looked at further.
        if refusal is None or refusal.readable:
            return node._replace(value=value)
        return node._replace(value=Refused(refusal.shown))

    def _value(self, event: events.Event, key: Key) -> Any:
        match event:
            case events.ScalarEvent():
                is_text = _is_quoted(event) or _is_huge(event)
                return event.value if is_text else self._scalar(event.value)
            case events.SequenceStartEvent():
                return self._items(key)
            case events.MappingStartEvent():
                return self._entries(key)
            case _:  # an alias, which is never followed
                return None

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


_UTF_16: Final = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
"""What a text in UTF-16, or in UTF-32, begins with, such as the "Unicode" of some editors."""


def _text(data: bytes | str) -> str:
    """The text of a preset, if it can be one; its lines end as they do here."""
    size = len(data) if isinstance(data, bytes) else len(data.encode(errors="surrogatepass"))
    if size > MAX_BYTES:
        raise UnusableError(f"is too large; allowed: at most {MAX_BYTES} bytes")
    text = data if isinstance(data, str) else _decoded(data)
    return text.removeprefix("\N{BYTE ORDER MARK}").replace("\r\n", "\n").replace("\r", "\n")


def _decoded(data: bytes) -> str:
    hint = "; this is UTF-16, to be saved as UTF-8" if data.startswith(_UTF_16) else ""
    if b"\0" in data:
        raise UnusableError(f"is not a text: it contains a NUL byte; allowed: UTF-8{hint}")
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        line = 1 + len(re.findall(rb"\r\n|\r|\n", data[: error.start]))
        raise UnusableError(f"is not a text; allowed: UTF-8{hint}", line) from None


def built(
    data: bytes | str,
    key: Key,
    place: Place,
    problems: list[PresetProblem],
    scalar: Callable[[str], Any] = scalar,
) -> Node | None:
    """The tree of a text, or None if it has none; raises `UnusableError` alone."""
    text = _text(data)
    try:
        return _TreeBuilder(text, Node(key, None, place), problems, scalar).build()
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


def document_of(
    data: bytes | str,
    source: str,
    problems: list[PresetProblem],
    scalar: Callable[[str], Any] = scalar,
) -> Node | None:
    """The tree of a preset's text; None, with the problem noted, if it is not a mapping.

    What an unquoted text stands for says ``scalar``.
    """
    place = Place(source, 1)
    try:
        root = built(data, (), place, problems, scalar)
    except UnusableError as error:
        problems.append(PresetProblem(source, error.line, "", None, error.message))
        return None
    if root is None or root.value is None:
        problems.append(Node((), None, place).problem("is empty; allowed: a mapping of keys"))
        return None
    if not isinstance(root.value, dict):
        if not isinstance(root.value, Refused):
            shown = quoted(plain(root))
            problems.append(root.problem("must be a mapping; allowed: a mapping of keys", shown))
        return None
    return root


def is_same_text(first: bytes, second: bytes) -> bool:
    """Whether two files hold the same text, however its lines and the file itself end.

    So an experiment stays what it is when an editor or a repository has saved it in its own way.
    Comments belong to a text: what somebody wrote there may be why results are to be kept apart.
    """
    if first == second:
        return True
    try:
        return _text(first).rstrip("\n") == _text(second).rstrip("\n")
    except UnusableError:
        return False
