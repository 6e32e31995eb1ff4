"""The journal of a session: a file that grows by a line before each command takes effect.

A line is a JSON object with a checksum in front, over it and over the checksum of the line before:
so no line can be changed, left out or moved without notice. The first line is the header, the
others are records (:mod:`app.live.records`). Where the last line has no end the writer was killed
while it wrote; that record was never answered, and is dropped. Anything else that is wrong is
damage: such a file is refused, with all that comes before it.
"""

import contextlib
import fcntl
import hashlib
import json
import os
import re
import threading
import time
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple, Self, cast

from app.live.codec import UnknownRecordError, decoded, encoded
from app.live.records import Record, Stood
from app.util.files import write_whole

FORMAT: Final = 1
SUFFIX: Final = ".pounce"
MAX_BYTES: Final = 64 * 2**20
"""Of a file; what would make it longer is not written, and what is longer is not read."""
MAX_LINE: Final = 2**20
"""Bytes of a line."""
_MOST_NAMES: Final = 1_000
"""Tried, where files have been given the first ones."""
_STANDS: Final = 20_000
"""By so many parts of its age where a run stands is written down apart: a month is 20 MB."""

_SUM: Final = re.compile(rb'\{"sum":"([0-9a-f]{16})",')
_FIRST: Final = b'"pounce_session":'


# --- What is wrong with a file -------------------------------------------------------------------


class SessionError(Exception):
    """A session that cannot be had; the message says which, why, and what would be allowed."""


class InUseError(SessionError):
    """Another lab writes the session."""


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


class _Line(NamedTuple):
    data: bytes
    sum: str


def _line(document: dict[str, Any], former_sum: str) -> _Line:
    body = json.dumps(document, separators=(",", ":"), allow_nan=False).encode("ascii")[1:]
    total = _sum_of(former_sum, body)
    return _Line(b'{"sum":"%b",%b\n' % (total.encode(), body), total)


def _sum_of(former_sum: str, body: bytes) -> str:
    return hashlib.sha256(former_sum.encode() + body).hexdigest()[:16]


def _header_line(header: Header) -> _Line:
    return _line({"pounce_session": FORMAT, **asdict(header)}, "")


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
        return json.loads(b"{" + body), total
    except (ValueError, RecursionError):
        raise ValueError("is not JSON") from None


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
    return Header(**values)


# --- Reading -------------------------------------------------------------------------------------


def read(path: Path) -> Written:
    """Read a session; it may be one that a lab still writes.

    Raises:
        DamagedError: it is damaged, or has a record that this pounce does not know.
        SessionError: it cannot be read, or is none.
    """
    lines, end, rest = _data_in(path).rpartition(b"\n")
    if not end:
        raise SessionError(f"{path}: is no session of pounce; allowed: a file {SUFFIX} of a lab")
    first, *others = lines.split(b"\n")
    try:
        document, total = _document_in(first, "")
        header = _header_in(document)
    except ValueError as error:
        if _FIRST in first[:80]:
            raise DamagedError(
                f"{path}: line 1 {error}; nothing could be saved", saved=None
            ) from None
        raise SessionError(
            f"{path}: is no session of pounce; allowed: a file {SUFFIX} of a lab"
        ) from None
    n_bytes, records = len(first) + 1, list[Record]()
    for line in others:
        try:
            document, next_sum = _document_in(line, total)
            records.append(decoded(document))
        except (ValueError, UnknownRecordError) as error:
            saved = Written(path, header, tuple(records), False, n_bytes, total)
            what = f"{path}: line {len(records) + 2}"
            mark = ", " if isinstance(error, UnknownRecordError) else " "
            raise DamagedError(f"{what}{mark}{error}", saved) from None
        n_bytes, total = n_bytes + len(line) + 1, next_sum
    return Written(path, header, tuple(records), bool(rest), n_bytes, total)


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
    for number in range(1, _MOST_NAMES):
        other = path.with_name(f"{path.stem}-saved{'' if number == 1 else number}{SUFFIX}")
        if not other.exists():
            write_whole(other, data)
            return other
        if other.is_file():
            with other.open("rb") as file:
                if file.read(len(data)) == data:
                    return other
    raise FileExistsError("no name is free for another session")


def whole(header: Header, records: Iterable[Record]) -> bytes:
    """A session as a file has it."""
    lines = [_header_line(header)]
    for record in records:
        lines.append(_line(encoded(record), lines[-1].sum))
    return b"".join(line.data for line in lines)


# --- Writing -------------------------------------------------------------------------------------


class Journal:
    """Writes a session. Methods may be called from any thread, and none of them fails.

    What cannot be written is kept, and tried again with the next record: the file has no gap.
    """

    def __init__(self, path: Path, header: Header) -> None:
        """Of a session that begins; the file is made with its first record."""
        self._path = path
        self._file: int | None = None
        self._first: _Line | None = _header_line(header)
        self._good = 0
        """Bytes of the file that are known to be whole, and on the disk."""
        self._sum = self._first.sum
        self._start()

    def _start(self) -> None:
        self._waiting: list[Record] = []
        self._is_unsure = False
        """Whether the file may have something behind what is whole."""
        self._fault: str | None = None
        self._is_over = False
        self._began_s = self._stood_s = time.monotonic()
        self._lock = threading.Lock()

    @classmethod
    def going_on(cls, written: Written) -> Self:
        """Of a session that was read; what was torn is cut off.

        Raises:
            InUseError: another lab writes it.
            SessionError: it cannot be written to, or is not what was read any more.
        """
        path = written.path
        try:
            file = os.open(path, os.O_RDWR | os.O_CLOEXEC)
        except OSError as error:
            raise SessionError(
                f"{path}: cannot be written to: {error.strerror or error}"
            ) from error
        try:
            if not _is_held(file):
                raise InUseError(
                    f"{path}: another lab is at work on it; allowed: a session that is over"
                )
            if os.fstat(file).st_size < written.n_bytes:
                raise SessionError(f"{path}: has changed since it was read")
            if read(path).n_bytes != written.n_bytes:
                raise SessionError(f"{path}: has changed since it was read")
        except BaseException:
            os.close(file)
            raise
        journal = cls.__new__(cls)
        journal._path, journal._file, journal._first = path, file, None
        journal._good, journal._sum = written.n_bytes, written.last_sum
        journal._start()
        journal._is_unsure = written.is_torn
        return journal

    @property
    def path(self) -> Path:
        """Where it is."""
        return self._path

    @property
    def fault(self) -> str | None:
        """What is wrong, as a sentence; None if all is on the disk."""
        return self._fault

    def note(self, record: Record) -> None:
        """Write a record down; it is on the disk when this returns, or there is a fault."""
        with self._lock:
            if not self._is_over:
                self._waiting.append(record)
                self._write()

    def stood(self, record: Stood, at_rest: bool = False) -> None:
        """Write down where the live run stands: always where it rests, else now and then."""
        with self._lock:
            now_s = time.monotonic()
            is_due = now_s - self._stood_s >= (now_s - self._began_s) / _STANDS
            if self._is_over or not (at_rest or is_due):
                return
            self._stood_s = now_s
            newest = self._waiting[-1] if self._waiting else None
            if isinstance(newest, Stood) and newest.run == record.run:
                # Where it stood before that nobody will ask, and a disk may be full for days.
                self._waiting.pop()
            self._waiting.append(record)
            self._write()

    def close(self) -> None:
        """Try once more to write what waits, and let the file go."""
        with self._lock:
            if not self._is_over and self._waiting:
                self._write()
            self._end(self._fault)

    def _end(self, fault: str | None) -> None:
        self._is_over, self._fault = True, fault
        self._waiting.clear()
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def _write(self) -> None:
        """Bring all that waits to the disk, or note why that cannot be."""
        lines = [] if self._first is None else [self._first]
        total = self._sum
        for record in self._waiting:
            lines.append(_line(encoded(record), total))
            total = lines[-1].sum
        data = b"".join(line.data for line in lines)
        if self._good + len(data) > MAX_BYTES or max(len(line.data) for line in lines) > MAX_LINE:
            self._end(
                f"This session has all the {MAX_BYTES // 2**20} MB that one may have: what is done"
                " from here on is not kept."
            )
            return
        try:
            self._put(data)
        except OSError as error:
            self._is_unsure = True
            self._fault = f"This session is not kept: {self._path.parent}: {_reason(error)}."
            return
        self._good, self._sum, self._first = self._good + len(data), total, None
        self._waiting.clear()
        self._fault = None

    def _put(self, data: bytes) -> None:
        """Write behind what is whole.

        Raises:
            OSError: not all of it is on the disk.
        """
        file = self._opened()
        if self._is_unsure:
            os.ftruncate(file, self._good)
            self._is_unsure = False
        at = self._good
        while data:
            n = os.pwrite(file, data, at)
            at, data = at + n, data[n:]
        os.fsync(file)
        if os.fstat(file).st_nlink == 0:
            raise OSError("the file has been taken away")

    def _opened(self) -> int:
        if self._file is None:
            self._path, self._file = _new_file(self._path)
            _sync_folder(self._path.parent)
        return self._file


def _new_file(path: Path) -> tuple[Path, int]:
    """Make a file of a name, or of the next that is free, and hold it.

    Raises:
        OSError: it cannot be made.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    for number in range(1, _MOST_NAMES):
        name = path if number == 1 else path.with_name(f"{path.stem}-{number}{path.suffix}")
        with contextlib.suppress(FileExistsError):
            file = os.open(name, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
            if _is_held(file):
                return name, file
            os.close(file)
    raise OSError("no name is free for another session")


def _is_held(file: int) -> bool:
    """Keep a file from other labs until it is closed; returns whether none had it."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        # Where a disk has no locks there is no telling.
        return True
    return True


def is_in_use(path: Path) -> bool:
    """Whether a lab writes a session now."""
    try:
        file = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        return not _is_held(file)
    finally:
        os.close(file)


def _sync_folder(folder: Path) -> None:
    """Have the name of a new file outlast a loss of power, where a disk can be told so."""
    with contextlib.suppress(OSError):
        file = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
        try:
            os.fsync(file)
        finally:
            os.close(file)


def _reason(error: OSError) -> str:
    text = error.strerror or str(error)
    return text[:1].lower() + text[1:]
