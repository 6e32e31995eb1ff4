"""Which shapes the messages of a page have. A stranger's bytes are read here first.

viser's decoder takes any value for any field: where a tuple has a wrong length it warns with the
whole value, and of any nest of containers it makes objects that are many times as large as their
bytes. So nothing reaches it that does not fit the annotations of its message types; those are
handed to a decoder that checks while it reads.
"""

import functools
import sys
import typing
from types import UnionType
from typing import Annotated, Any, Final, NamedTuple

import msgspec
from viser import _messages as wire

MAX_SHORT_BYTES: Final = 64 * 1024
"""Largest message of those that carry no file and no picture."""

_LONG: Final = (wire.FileTransferPart, wire.GetRenderResponseMessage)
_TYPE: Final = "type"
_MOST_FIELDS: Final = 32

Finite = Annotated[float, msgspec.Meta(ge=-sys.float_info.max, le=sys.float_info.max)]

_ENVELOPE: Final = msgspec.msgpack.Decoder(
    Annotated[dict[str, msgspec.Raw], msgspec.Meta(max_length=_MOST_FIELDS)]
)
_NAME: Final = msgspec.msgpack.Decoder(str)


class NotAMessageError(ValueError):
    """These bytes are no message of viser's."""


class SenselessError(ValueError):
    """A message that no page of ours sends; says so in words for the page."""

    def __init__(self) -> None:
        super().__init__("This page sent a message that makes no sense here.")


class Shaped(NamedTuple):
    """A message whose fields hold what they are annotated with."""

    frame: bytes
    """As it came, which is what viser gets."""
    kind: type[wire.Message]
    content: Any
    """Has the fields of `kind`."""


def read(frame: Any, allowed: typing.Container[type[wire.Message]]) -> Shaped:
    """The message in a frame, of one of the allowed types.

    Raises:
        NotAMessageError: there is none in it.
        SenselessError: it is of another type, too long, or a field holds something else.
    """
    if not isinstance(frame, bytes):
        raise NotAMessageError
    try:
        fields = _ENVELOPE.decode(frame)
        kind = _kinds()[_NAME.decode(fields.pop(_TYPE))]
        if kind not in allowed:
            raise SenselessError
        names, decoder = _shape(kind)
        if fields.keys() != names:
            raise NotAMessageError
        if len(frame) > MAX_SHORT_BYTES and kind not in _LONG:
            raise SenselessError
        try:
            return Shaped(frame, kind, decoder.decode(frame))
        except msgspec.ValidationError as error:
            raise SenselessError from error
    except (NotAMessageError, SenselessError):
        raise
    except Exception as error:
        # The bytes are a stranger's: what a decoder trips over (cut short, no text, too deep a
        # nest) differs, what follows does not. No list of errors would be complete.
        raise NotAMessageError from error


def _kinds() -> dict[str, type[wire.Message]]:
    """viser's message types by their names on the wire."""
    return typing.cast(dict[str, type[wire.Message]], wire.Message._subclass_from_type_string())


@functools.cache
def _shape(kind: type[wire.Message]) -> tuple[frozenset[str], msgspec.msgpack.Decoder[Any]]:
    """Names of a message type's fields, and what reads them."""
    hints = typing.get_type_hints(kind)
    names = kind.__dataclass_fields__  # type: ignore[attr-defined]
    shape = msgspec.defstruct(kind.__name__, [(name, _strict(hints[name])) for name in names])
    return frozenset(names), msgspec.msgpack.Decoder(shape)


def _strict(hint: Any) -> Any:
    """An annotation of viser's with numbers that must be finite, and mappings of anything.

    Whoever judges a mapping says what is wrong with it; so a wrong key is told as well.
    """
    kind, parts = typing.get_origin(hint), typing.get_args(hint)
    if hint is float:
        return Finite
    if kind is tuple:
        return tuple[tuple(part if part is ... else _strict(part) for part in parts)]
    if kind in (typing.Union, UnionType):
        return typing.Union[tuple(map(_strict, parts))]  # noqa: UP007
    return dict if kind is dict else hint
