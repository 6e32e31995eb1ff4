"""What the models allow at each place in a preset, and what they fault, in a preset's own words."""

from collections.abc import Collection, Iterable, Iterator
from functools import lru_cache
from types import UnionType
from typing import Annotated, Any, Final, Literal, NamedTuple, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from app.documents.tree import EXTENDS, Key, quoted
from app.words import typed
from learners.spec import RunSpec, did_you_mean, listed
from sim.spec import ProblemsError

# --- What the models allow -----------------------------------------------------------------------


class Slot(NamedTuple):
    """What the models say of one place in a preset."""

    kind: Any
    """Type, without its annotations."""
    limits: tuple[Any, ...] = ()
    text: str | None = None
    """What is allowed, where the model says so itself."""
    optional: bool = False
    in_item: bool = False
    """Is an item of a list, or part of one."""

    @property
    def is_union(self) -> bool:
        """Whether its value may be of several types, which say different things."""
        return get_origin(self.kind) in (Union, UnionType)


@lru_cache(maxsize=1024)  # Not more: a mapping of free keys has no end of places.
def slot_of(key: Key) -> Slot | None:
    """The slot at a key, or None if the models have no such place."""
    slot: Slot | None = Slot(RunSpec)
    for part in key:
        slot = None if slot is None else _inner(slot, part)
    return slot


def _inner(slot: Slot, part: str | int) -> Slot | None:
    if _is_model(slot.kind):
        field = slot.kind.model_fields.get(part)
        if field is None:
            return None
        optional = not field.is_required()
        limits = tuple(field.metadata)
        return Slot(field.annotation, limits, field.description, optional, slot.in_item)
    arguments = get_args(slot.kind)
    if get_origin(slot.kind) is dict:
        return _of_type(arguments[1], optional=True)
    if get_origin(slot.kind) is tuple and isinstance(part, int):
        if arguments[-1] is Ellipsis:
            return _of_type(arguments[0], optional=True, in_item=True)
        if part < len(arguments):
            return _of_type(arguments[part], slot.text)
    return None


def _name_of(mapping: Slot | None) -> Slot | None:
    """The slot of the keys of a mapping in which they are free."""
    if mapping is None or get_origin(mapping.kind) is not dict:
        return None
    return _of_type(get_args(mapping.kind)[0])


def _of_type(
    annotation: Any, text: str | None = None, optional: bool = False, in_item: bool = False
) -> Slot:
    limits: list[Any] = []
    if get_origin(annotation) is Annotated:
        annotation, *metadata = get_args(annotation)
        for item in metadata:
            if isinstance(item, FieldInfo):
                limits.extend(item.metadata)
                text = text or item.description
            else:
                limits.append(item)
    return Slot(annotation, tuple(limits), text, optional, in_item)


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def names_of(slot: Slot | None) -> tuple[str, ...]:
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
    """What a place in a preset allows, in words."""
    arguments = get_args(slot.kind)
    origin = get_origin(slot.kind)
    if slot.text:
        return slot.text
    if names := names_of(slot):
        return f"the keys {', '.join(names)}"
    if origin is Literal:
        return ", ".join(map(str, arguments))
    if slot.is_union:
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


# --- What the models fault -----------------------------------------------------------------------

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


class Fault(NamedTuple):
    """Something that the models say is wrong."""

    key: Key
    message: str
    value: str | None = None
    """What the models took the value to be, for where the preset states none."""
    is_missing: bool = False


def faults_of(error: ValidationError, skills: Collection[str]) -> Iterator[Fault]:
    """What the models say, with hints at the skills that a tree knows."""
    for found in error.errors(include_url=False):
        key: Key = found["loc"]
        cause = found.get("ctx", {}).get("error")
        if isinstance(cause, ProblemsError):
            for problem in cause.problems:
                yield Fault((*key, *problem.key), problem.message, quoted(problem.value))
        elif cause is not None:
            text = str(cause)
            yield Fault(key, f"cannot be used; {text}" if text.startswith("allowed:") else text)
        elif found["type"] == "extra_forbidden":
            yield Fault(key, unknown_key(key[-1], names_of(slot_of(key[:-1]))))
        else:
            yield _malformed(found, skills)


def unknown_key(name: str | int, names: Collection[str]) -> str:
    """What is said of a key that is none of these."""
    return f"is not a known key{did_you_mean(name, names)}; allowed: {listed(names)}"


def _malformed(found: ErrorDetails, skills: Collection[str]) -> Fault:
    kind, word, key = found["type"], found["input"], found["loc"]
    limits = found.get("ctx", {}).items()
    numbers = {name: typed.plain(x) for name, x in limits if isinstance(x, int | float)}
    message = _WRONG.get(kind, "cannot be used").format_map(numbers)
    slot = slot_of(key)
    if kind.startswith("string_"):
        if key[-1] == "[key]":
            message, key = "is not a possible key", key[:-1]
            slot = _name_of(slot_of(key[:-1]))
        if key[0] == "schedule" and isinstance(word, str):
            message += did_you_mean(word, skills)
    allowed = "" if slot is None else _allowed(slot)
    message = f"{message}; allowed: {allowed}" if allowed else message
    if kind in ("int_type", "float_type"):
        message += written_so(word, decimals=kind == "float_type")
    return Fault(key, message, None, kind == "missing")


def written_so(word: object, decimals: bool) -> str:
    """How a file writes a number that somebody wrote as people do; empty if it is none."""
    found = typed.rewritten(word, decimals) if isinstance(word, str) else None
    return "" if found is None else f"; in a file it is written {found}"
