"""The file of a session, as it is read: a line for each record, and what is wrong with it.

A line is a JSON object with a checksum in front, over it and over the checksum of the line before:
so no line can be changed, left out or moved without notice. The first line is the header, the
others are records (:mod:`app.live.records`). Where the last line has no end the writer was killed
while it wrote; that record was never answered, and is dropped. Anything else that is wrong is
damage: such a file is refused, with all that comes before it. :mod:`app.live.journal` writes it.
"""

import contextlib
import hashlib
import json
import re
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple, cast

from app.live.codec import KIND, UnknownRecordError, decoded, encoded, kind_of
from app.live.records import Began, Branched, Gave, Record, Stood, WentLive
from app.util.files import write_whole

FORMAT: Final = 1
SUFFIX: Final = ".pounce"
MAX_BYTES: Final = 64 * 2**20
"""Of a file; what would make it longer is not written, and what is longer is not read."""
MAX_LINE: Final = 2**20
"""Bytes of a line."""
MOST_NAMES: Final = 1_000
"""Tried, where files have been given the first ones."""

_MOST_STOOD: Final = 100
"""Of branches, that are passed over to find where the live run stood."""
_LONGEST: Final = 500
"""Characters of what a header says."""
_SUM: Final = re.compile(rb'\{"sum":"([0-9a-f]{16})",')
_SUM_LENGTH: Final = len(b'{"sum":"0123456789abcdef",')
_FIRST: Final = b'"pounce_session":'


# --- What is wrong with a file -------------------------------------------------------------------


class SessionError(Exception):
    """A session that cannot be had; the message says which, why, and what would be allowed."""


class DamagedError(SessionError):
    """A file that is damaged; what comes before the damage could be saved."""

    def __init__(self, message: str, saved: "Written | None") -> None:
        super().__init__(message)
        self.saved = saved
        """All up to the damage; None if there is nothing before it."""


@dataclass(frozen=True)
class Header:
    """What the first line says of a session."""

    version: str
    """Of the pounce that began it."""
    preset: str
    """With which it began, as shown."""
    seed: int
    began: str
    """The day and the time, as ISO 8601 has them."""


@dataclass(frozen=True)
class Written:
    """A session as it was read."""

    path: Path
    header: Header
    records: tuple[Record, ...]
    is_torn: bool
    """Whether a last record was dropped, in the midst of which the writer was killed."""
    n_bytes: int
    """Of all that is whole."""
    last_sum: str
    """Checksum of the last line that is whole."""


# --- Lines ---------------------------------------------------------------------------------------


class Line(NamedTuple):
    """A line with its end, and its checksum."""

    data: bytes
    sum: str


def line_of(document: dict[str, Any], former_sum: str) -> Line:
    """What JSON has as an object, behind a line with a checksum."""
    body = json.dumps(document, separators=(",", ":"), allow_nan=False).encode("ascii")[1:]
    total = _sum_of(former_sum, body)
    return Line(b'{"sum":"%b",%b\n' % (total.encode(), body), total)


def _sum_of(former_sum: str, body: bytes) -> str:
    return hashlib.sha256(former_sum.encode() + body).hexdigest()[:16]


def header_line(header: Header) -> Line:
    """The first line of a file."""
    return line_of({"pounce_session": FORMAT, **asdict(header)}, "")


def _document_in(line: bytes, former_sum: str) -> tuple[object, str]:
    """What a line without its end says, and its checksum.

    Raises:
        ValueError: it is not as it was written; the message says so.
    """
    found = _SUM.match(line)
    if found is None or len(line) > MAX_LINE:
        raise ValueError("is not a line of a session")
    body, total = line[found.end() :], found[1].decode()
    if _sum_of(former_sum, body) != total:
        raise ValueError("does not have the checksum that it states")
    try:
        return json.loads(b"{" + body, object_pairs_hook=_each_once), total
    except (ValueError, RecursionError):
        raise ValueError("is not JSON") from None


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object of JSON.

    Raises:
        ValueError: it has a key twice, of which readers may take either.
    """
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a key is there twice")
    return found


def _header_in(document: object) -> Header:
    """The header that a first line states.

    Raises:
        ValueError: it states none.
    """
    values = dict(cast(dict[str, Any], document)) if isinstance(document, dict) else {}
    found = values.pop("pounce_session", None)
    if found != FORMAT:
        raise ValueError(
            f"pounce_session: {found!r:.40} is not allowed; allowed: {FORMAT}, the format of this"
            " pounce"
        )
    kinds = Header.__annotations__
    if values.keys() != kinds.keys() or any(type(values[key]) is not kinds[key] for key in kinds):
        raise ValueError("is not the first line of a session")
    texts = [value for value in values.values() if isinstance(value, str)]
    if not all(text.isprintable() and len(text) <= _LONGEST for text in texts):
        # They are shown in terminals and in pages.
        raise ValueError("says what is no name")
    return Header(**values)


# --- Reading -------------------------------------------------------------------------------------


def read(path: Path) -> Written:
    """Read a session; it may be one that a lab still writes.

    Raises:
        DamagedError: it is damaged, or has a record that this pounce does not know.
        SessionError: it cannot be read, or is none.
    """
    return read_data(path, _data_in(path))


def read_data(path: Path, data: bytes) -> Written:
    """Read a session that was a file elsewhere; ``path`` is what it was called.

    Raises:
        DamagedError: as :func:`read`.
        SessionError: it is none.
    """
    first, others, is_torn = _lines_of(path, data)
    header, total = _header_of(path, first)
    n_bytes, records = len(first) + 1, list[Record]()
    for line in others.split(b"\n")[:-1]:
        try:
            document, next_sum = _document_in(line, total)
            records.append(decoded(document))
        except ValueError as error:
            saved = Written(path, header, tuple(records), False, n_bytes, total)
            what = f"{path}: line {len(records) + 2}"
            mark = ", " if isinstance(error, UnknownRecordError) else " "
            raise DamagedError(f"{what}{mark}{error}", saved) from None
        n_bytes, total = n_bytes + len(line) + 1, next_sum
    return Written(path, header, tuple(records), is_torn, n_bytes, total)


class Glance(NamedTuple):
    """What a session is told from others by; none of it is checked but the header."""

    header: Header
    trial: int
    """Of the live run, where it was last written down."""
    n_commands: int
    """Given by hand; branches count as well."""


def glance(path: Path) -> Glance:
    """Look at a session without making sense of all its lines.

    Raises:
        SessionError: it cannot be read, or is none.
    """
    first, others, _ = _lines_of(path, _data_in(path))
    header, _ = _header_of(path, first)
    trial = _live_trial(others)
    return Glance(header, trial, sum(others.count(_mark_of(kind)) for kind in (Gave, Branched)))


def _live_trial(lines: bytes) -> int:
    """Where the live run was last written down to stand; if it never was, where another one was."""
    run = getattr(
        _record_at(max(_last_of(Began, lines), _last_of(WentLive, lines)), lines), "run", None
    )
    newest, at = 0, _last_of(Stood, lines)
    # What branches came to is written down as well, of each once when all stands still.
    for n in range(_MOST_STOOD):
        stood = _record_at(at, lines)
        if not isinstance(stood, Stood):
            break
        if stood.run == run:
            return stood.trial
        newest = newest if n else stood.trial
        at = _last_of(Stood, lines, at)
    return newest


def _last_of(kind: type[Record], lines: bytes, before: int | None = None) -> int:
    """Where the last record of a kind has its mark, before a place; -1 if there is none."""
    return lines.rfind(_mark_of(kind), 0, before)


def _record_at(at: int, lines: bytes) -> Record | None:
    """The record that has its mark there; None if there is none, or it is damaged."""
    if at < 0:
        return None
    line = lines[lines.rfind(b"\n", 0, at) + 1 :].partition(b"\n")[0]
    with contextlib.suppress(ValueError, RecursionError):
        return decoded(json.loads(b"{" + line[_SUM_LENGTH:]))
    return None


def _mark_of(kind: type[Record]) -> bytes:
    # In a text a quotation mark has a backslash before it.
    return b'"%b":"%b",' % (KIND.encode(), kind_of(kind).encode())


def _header_of(path: Path, first: bytes) -> tuple[Header, str]:
    """What the first line says, and its checksum.

    Raises:
        DamagedError: it is damaged, or of another format.
        SessionError: it is not the first line of a session.
    """
    try:
        document, total = _document_in(first, "")
        return _header_in(document), total
    except ValueError as error:
        if _FIRST in first[:80]:
            message = f"{path}: line 1 {error}; nothing could be saved"
            raise DamagedError(message, saved=None) from None
        raise _no_session(path) from None


def _lines_of(path: Path, data: bytes) -> tuple[bytes, bytes, bool]:
    """The first line without its end, all others that have an end, and whether one has none.

    Raises:
        SessionError: there is no line.
    """
    lines, end, rest = data.rpartition(b"\n")
    if not end:
        raise _no_session(path)
    first, _, others = (lines + end).partition(b"\n")
    return first, others, bool(rest)


def _no_session(path: Path) -> SessionError:
    return SessionError(f"{path}: is no session of pounce; allowed: a file {SUFFIX} of a lab")


def _data_in(path: Path) -> bytes:
    """All bytes of a file.

    Raises:
        SessionError: it cannot be read, or has too many.
    """
    try:
        # What is no file, such as a pipe, might never end or never begin.
        if not path.is_file():
            raise SessionError(f"{path}: is no file; allowed: a session that there is")
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise SessionError(f"{path}: cannot be read: {error.strerror or error}") from None
    if len(data) > MAX_BYTES:
        raise SessionError(f"{path}: is too large; allowed: up to {MAX_BYTES:,} bytes")
    return data


def save(written: Written) -> Path:
    """Write a session anew beside its file, up to where that is whole; returns where.

    One that was saved there before, and may have gone on since, is left as it is.

    Raises:
        OSError: it cannot be written.
    """
    data, path = whole(written.header, written.records), written.path
    for number in range(1, MOST_NAMES):
        other = path.with_name(f"{path.stem}-saved{'' if number == 1 else number}{SUFFIX}")
        if not other.exists():
            write_whole(other, data)
            return other
        if other.is_file():
            with other.open("rb") as file:
                if file.read(len(data)) == data:
                    return other
    raise FileExistsError("no name is free for another session")


def without_sums(data: bytes) -> bytes:
    """The lines of a file that is whole, without their checksums, which follow from them."""
    return b"".join(b"{%b\n" % line[_SUM_LENGTH:] for line in data.split(b"\n")[:-1])


def with_sums(data: bytes) -> bytes:
    """A file of lines without their checksums, whatever they say."""
    lines, total = list[bytes](), ""
    for line in data.split(b"\n")[:-1]:
        total = _sum_of(total, line[1:])
        lines.append(b'{"sum":"%b",%b\n' % (total.encode(), line[1:]))
    return b"".join(lines)


def whole(header: Header, records: Iterable[Record]) -> bytes:
    """A session as a file has it."""
    lines = [header_line(header)]
    for record in records:
        lines.append(line_of(encoded(record), lines[-1].sum))
    return b"".join(line.data for line in lines)
