"""Records of a session as texts, and read back: only what this program knows, and within bounds.

Nothing is unpickled. What is read is checked by models that are made from the records and commands
themselves, so that a new one of either needs nothing here but its name.
"""

import dataclasses
import json
import re
from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, Final, cast, get_args, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model

from app.live.records import MOST_COMMANDS, Record
from app.live.story import MOST_TEXT, LongText
from learners.commands import Command

KIND: Final = "kind"
"""The key that says which record it is."""
_DO: Final = "do"
"""The key that says which command it is."""
_MOST: Final = 2**63 - 1
"""Of a whole number: the largest seed; steps are far fewer."""
_LONGEST: Final = 1_000
"""Characters of a text: names and marks have fewer."""


def kind_of(record: type[Record]) -> str:
    """What a kind of record is called in a file: ``went_live``."""
    return re.sub("(?<=[a-z])(?=[A-Z])", "_", record.__name__).lower()


_RECORDS: Final[Mapping[str, type[Any]]] = {kind_of(kind): kind for kind in get_args(Record)}
_COMMANDS: Final[Mapping[str, type[Any]]] = {kind.__name__: kind for kind in get_args(Command)}
_PLAIN: Final[Mapping[Any, Any]] = {
    int: Annotated[int, Field(ge=0, le=_MOST)],
    int | None: Annotated[int | None, Field(ge=0, le=_MOST)],
    float: Annotated[float, Field(allow_inf_nan=False)],
    float | None: Annotated[float | None, Field(allow_inf_nan=False)],
    str: Annotated[str, Field(max_length=_LONGEST)],
    LongText: Annotated[str, Field(max_length=MOST_TEXT)],
}


class UnknownRecordError(ValueError):
    """A text that is no record of this program; the message says what in it is not allowed."""


def encoded(record: Record) -> dict[str, Any]:
    """A record as JSON has it; :func:`decoded` makes an equal one of it."""
    return {KIND: kind_of(type(record)), **_values_of(record)}


def encoded_command(command: Command) -> dict[str, Any]:
    """A command as JSON has it."""
    return {_DO: type(command).__name__, **_values_of(command)}


def decoded(document: object) -> Record:
    """The record that something from JSON states.

    Raises:
        UnknownRecordError: it states none that this program knows.
    """
    kind, values = _taken_apart(document, KIND, _RECORDS)
    if "command" in values:
        values["command"] = _command(values["command"])
    if "commands" in values:
        given: Any = values["commands"]
        listed = cast(list[object], given) if isinstance(given, list) else None
        if listed is None or len(listed) > MOST_COMMANDS:
            raise UnknownRecordError(
                f"commands: {_shown(values['commands'])} is not allowed; allowed: up to"
                f" {MOST_COMMANDS:,} commands"
            )
        values["commands"] = tuple(map(_command, listed))
    return _made(kind, values)


def _command(document: object) -> Command:
    return _made(*_taken_apart(document, _DO, _COMMANDS))


def _values_of(stated: Record | Command) -> dict[str, Any]:
    values = {field.name: getattr(stated, field.name) for field in dataclasses.fields(stated)}
    left_out = {field.name for field in dataclasses.fields(stated) if _is_optional(stated, field)}
    return {
        name: _plain(value)
        for name, value in values.items()
        if value is not None or name not in left_out
    }


def _is_optional(stated: Record | Command | type[Any], field: "dataclasses.Field[Any]") -> bool:
    """Whether a value of a command is written only where it is given: files of before have none."""
    kind = stated if isinstance(stated, type) else type(stated)
    return kind in _COMMANDS.values() and field.default is None


def _plain(value: Any) -> Any:
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    if isinstance(value, tuple):
        return [_plain(part) for part in cast(tuple[Any, ...], value)]
    return encoded_command(value) if type(value) in _COMMANDS.values() else value


def _taken_apart(
    document: object, key: str, kinds: Mapping[str, type[Any]]
) -> tuple[type[Any], dict[str, Any]]:
    """Which of some kinds is meant, and its values."""
    if not isinstance(document, dict):
        raise UnknownRecordError(f"{_shown(document)} is not allowed; allowed: values with keys")
    values = dict(cast(dict[str, Any], document))
    name = values.pop(key, None)
    kind = kinds.get(name) if isinstance(name, str) else None
    if kind is None:
        raise UnknownRecordError(
            f"{key}: {_shown(name)} is not allowed; allowed: {', '.join(kinds)}"
        )
    return kind, values


def _made(kind: type[Any], values: dict[str, Any]) -> Any:
    try:
        found = _model_of(kind).model_validate(values)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"]))
        raise UnknownRecordError(
            f"{where}: {_shown(first['input'])} is not allowed: {first['msg']}"
        ) from None
    return kind(**{name: getattr(found, name) for name in type(found).model_fields})


@cache
def _model_of(kind: type[Any]) -> type[BaseModel]:
    """What the values of a record or a command must be: all of them but those that are written only
    where they are given, no others, and of their types.

    Commands within a record have been read before it is.
    """
    hints = get_type_hints(kind)
    fields: dict[str, Any] = {}
    for field in dataclasses.fields(kind):
        hint = hints[field.name]
        if hint in (Command, tuple[Command, ...]):
            hint = Any
        default = None if _is_optional(kind, field) else ...
        fields[field.name] = (_PLAIN.get(hint, hint), default)
    settings = ConfigDict(strict=True, extra="forbid", protected_namespaces=())
    return create_model(kind.__name__, __config__=settings, **fields)


def _shown(value: object) -> str:
    """A value in a message, on one line and not too long."""
    try:
        text = json.dumps(value, default=str)
    except RecursionError:
        # It could be read, but only just.
        return "what lies as deep"
    return text if len(text) <= 60 else f"{text[:57]}..."
