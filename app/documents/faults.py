"""What models allow at each place in a document, and what they fault, in a document's own words.

The one place that knows what pydantic says. A model is read (:func:`faults_of`) for presets as for
experiments, and whatever it faults becomes a problem with a file, a line, a key, a value and what
would be allowed. What is allowed is found in the model itself, so that a setting is stated once.
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
from functools import lru_cache
from types import UnionType
from typing import (
    Annotated,
    Any,
    Final,
    Literal,
    NamedTuple,
    TypeGuard,
    Union,
    cast,
    get_args,
    get_origin,
)

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from app.documents.tree import (
    EXTENDS,
    Key,
    Node,
    PresetProblem,
    Refused,
    children,
    descend,
    plain,
    quoted,
)
from app.words import typed
from learners.names import did_you_mean, listed
from learners.spec import RunSpec
from sim.spec import Problem, ProblemsError

# --- What models allow ---------------------------------------------------------------------------


class Slot(NamedTuple):
    """What the models say of one place in a document."""

    kind: Any
    """Type, without its annotations."""
    limits: tuple[Any, ...] = ()
    text: str | None = None
    """What is allowed, where the model says so itself."""
    optional: bool = False
    """Whether a document may do without it: a default, an item of a list, an entry of a mapping."""
    is_item: bool = False
    """Whether it is an item of a list."""


@lru_cache(maxsize=1024)  # Not more: a mapping of free keys has no end of places.
def slot_of(model: type[BaseModel], key: Key) -> Slot | None:
    """The slot at a key of a model, or None if there is no such place."""
    if not key:
        return Slot(model)
    above = slot_of(model, key[:-1])
    return None if above is None else _inner(above, key[-1])


def _inner(slot: Slot, part: str | int) -> Slot | None:
    if _is_model(slot.kind):
        field = _fields_of(slot.kind).get(str(part))
        if field is None:
            return None
        found = _of_type(field.annotation, optional=not field.is_required())
        limits = (*found.limits, *field.metadata)
        return found._replace(limits=limits, text=field.description or found.text)
    arguments = get_args(slot.kind)
    if _is_union(slot.kind):
        inner = (_inner(_of_type(argument), part) for argument in arguments)
        return next((found for found in inner if found is not None), None)
    if get_origin(slot.kind) is dict and isinstance(part, str):
        return _of_type(arguments[1], optional=not slot.is_item)
    if get_origin(slot.kind) in (tuple, Sequence) and isinstance(part, int):
        if get_origin(slot.kind) is Sequence or arguments[-1] is Ellipsis:
            return _of_type(arguments[0], optional=True)._replace(is_item=True)
        if part < len(arguments):
            return _of_type(arguments[part], slot.text)
    return None


def _of_type(annotation: Any, text: str | None = None, optional: bool = False) -> Slot:
    limits: list[Any] = []
    if get_origin(annotation) is Annotated:
        annotation, *metadata = get_args(annotation)
        for item in metadata:
            if isinstance(item, FieldInfo):
                limits.extend(item.metadata)
                text = text or item.description
            else:
                limits.append(item)
    if _is_union(annotation):
        others = [kind for kind in get_args(annotation) if kind is not type(None)]
        if len(others) == 1:  # Null is not stated but left out.
            found = _of_type(others[0], text, optional)
            return found._replace(limits=(*limits, *found.limits))
    return Slot(annotation, tuple(limits), text, optional)


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _fields_of(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """The fields of a model, by their names in a document."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def _is_union(kind: Any) -> bool:
    return get_origin(kind) in (Union, UnionType)


def _is_mapping(slot: Slot | None) -> TypeGuard[Slot]:
    """Whether it is a mapping whose keys are free."""
    return slot is not None and get_origin(slot.kind) is dict


def _names_of(slot: Slot | None) -> tuple[str, ...]:
    """Keys that a mapping may have; none where there is no mapping, or keys are free."""
    if slot is None or not _is_model(slot.kind):
        return ()
    return (*((EXTENDS,) if slot.kind is RunSpec else ()), *_fields_of(slot.kind))


_LIMITS: Final = {
    "ge": "at least",
    "gt": "above",
    "le": "at most",
    "lt": "below",
    "multiple_of": "multiples of",
}


def _range(limits: Iterable[Any]) -> str:
    """Limits of a number in words, such as ``8 to 48, multiples of 8``."""
    limit = {
        name: typed.plain(getattr(item, name))
        for item in limits
        for name in _LIMITS
        if getattr(item, name, None) is not None
    }
    both = [f"{limit.pop('ge')} to {limit.pop('le')}"] if limit.keys() >= {"ge", "le"} else []
    return ", ".join([*both, *(f"{_LIMITS[name]} {number}" for name, number in limit.items())])


def _allowed(slot: Slot) -> str:
    """What a place in a document allows, in words."""
    arguments = get_args(slot.kind)
    origin = get_origin(slot.kind)
    if slot.text:
        return slot.text
    if names := _names_of(slot):
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


# --- What models fault ---------------------------------------------------------------------------

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
    "too_long": "has more than {max_length} items",
    "too_short": "has too few items",
    "literal_error": "is not among what is allowed",
    "finite_number": "must be finite",
    "greater_than_equal": "must be at least {ge}",
    "greater_than": "must be more than {gt}",
    "less_than_equal": "must be at most {le}",
    "less_than": "must be less than {lt}",
    "multiple_of": "must be a multiple of {multiple_of}",
}
"""What a kind of error of pydantic means, in the words of a document."""


class Fault(NamedTuple):
    """Something that a model says is wrong."""

    key: Key
    message: str
    value: str | None = None
    """What the model took the value to be, for where the document states none."""
    is_lacking: bool = False
    """Whether something is not there: a key, or the items of a list."""
    is_compared: bool = False
    """Whether values that are each well-formed do not go together."""
    is_noted: bool = False
    """Whether the value could not even be read, which is a problem already."""

    def problem(self, tree: Node) -> PresetProblem:
        """The fault where it stands in the tree that was judged."""
        node, rest = descend(tree, self.key)
        value = self.value if rest else quoted(plain(node))
        return node._replace(key=(*node.key, *rest)).problem(self.message, value)


def faults_of(
    error: ValidationError, model: type[BaseModel], names: Collection[str] = ()
) -> Iterator[Fault]:
    """All that a model faults.

    Args:
        error: what it said.
        model: which one.
        names: skills that a schedule may have meant, for hints.
    """
    for found in error.errors(include_url=False):
        key: Key = found["loc"]
        if found["type"] == "too_short" and found["input"]:
            continue  # Items that are wrong are not counted, and each is faulted itself.
        cause = found.get("ctx", {}).get("error")
        slot, is_name = slot_of(model, key), False
        if key[-1:] == ("[key]",) and _is_mapping(mapping := slot_of(model, key[:-2])):
            key, slot, is_name = key[:-1], _of_type(get_args(mapping.kind)[0]), True
        if isinstance(cause, ProblemsError):
            for said in cause.problems:
                yield fault_of(said, key)
            continue
        if cause is not None:
            text = str(cause)
            message = f"cannot be used; {text}" if text.startswith("allowed:") else text
        elif found["type"] == "extra_forbidden":
            message = unknown_key(key[-1], _names_of(slot_of(model, key[:-1])))
        else:
            message = _malformed(found, slot, names if key[0] == "schedule" else (), is_name)
        yield Fault(
            key,
            message,
            is_lacking=found["type"] in ("missing", "too_short"),
            is_noted=_was_not_read(found["input"], as_a_whole=cause is not None),
        )


def fault_of(said: Problem, at: Key = ()) -> Fault:
    """What a model found at a key that does not go together."""
    return Fault(
        (*at, *said.key),
        said.message,
        None if said.value is ... else quoted(said.value),
        is_compared=True,
        is_noted=isinstance(said.value, Refused),
    )


def _was_not_read(value: object, as_a_whole: bool) -> bool:
    if as_a_whole and isinstance(value, list):
        return any(isinstance(item, Refused) for item in cast("list[object]", value))
    return isinstance(value, Refused)


def _malformed(
    found: ErrorDetails, slot: Slot | None, names: Collection[str], is_name: bool
) -> str:
    kind, word = found["type"], found["input"]
    limits = found.get("ctx", {}).items()
    numbers = {name: typed.plain(x) for name, x in limits if isinstance(x, int | float)}
    message = _WRONG.get(kind, "cannot be used").format_map(numbers)
    if is_name:
        message = "is not a possible key"
    if kind.startswith("string_") and isinstance(word, str):
        message += did_you_mean(word, names)
    allowed = "" if slot is None else _allowed(slot)
    message = f"{message}; allowed: {allowed}" if allowed else message
    if kind in ("int_type", "float_type"):
        message += written_so(word, decimals=kind == "float_type")
    return message


def unknown_key(name: str | int, names: Collection[str]) -> str:
    """What is said of a key that is none of these."""
    return f"is not a known key{did_you_mean(name, names)}; allowed: {listed(names)}"


def written_so(word: object, decimals: bool) -> str:
    """How a file writes a number that somebody wrote as people do; empty if it is none."""
    found = typed.rewritten(word, decimals) if isinstance(word, str) else None
    return "" if found is None else f"; in a file it is written {found}"


# --- What is left without it ---------------------------------------------------------------------


def without_nulls(tree: Node, model: type[BaseModel], at: Key = ()) -> Node:
    """A tree in which a key that is null is as if it had not been given.

    Only where the model has such a key and does without it. What holds settings of other documents
    is kept as it is: there null is a value, and takes a setting away in its turn.
    """
    match tree.value:
        case list():
            items = [without_nulls(child, model, (*at, index)) for index, child in children(tree)]
            return tree._replace(value=items)
        case dict():
            kept: dict[str | int, Node] = {}
            has_free_keys = _is_mapping(slot_of(model, at))
            for name, child in children(tree):
                slot = slot_of(model, (*at, name))
                if child.value is not None:
                    kept[name] = without_nulls(child, model, (*at, name))
                elif (
                    slot is None
                    or not slot.optional
                    or (has_free_keys and not _is_model(slot.kind))
                ):
                    kept[name] = child
            return tree._replace(value=kept)
        case _:
            return tree


def may_be_left_out(key: Key, model: type[BaseModel]) -> Key:
    """The least part of a document that holds what is at a key and that the rest can do without."""
    for length in range(len(key), 1, -1):
        slot = slot_of(model, key[:length])
        if slot is None or slot.optional:
            return key[:length]
    return key[:1]
