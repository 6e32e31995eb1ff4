"""The journal of a session: a file that grows by a line before each command takes effect."""

import contextlib
import fcntl
import logging
import os
import threading
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Final, Self

from app.live.codec import encoded
from app.live.records import Began, Record, Stood
from app.live.written import (
    MAX_BYTES,
    MAX_LINE,
    MOST_NAMES,
    Header,
    Line,
    SessionError,
    Written,
    header_line,
    line_of,
    read,
)

log = logging.getLogger(__name__)

_STANDS: Final = 20_000
"""By so many parts of its age where a run stands is written down apart: a month is 20 MB."""


class InUseError(SessionError):
    """Another lab writes the session."""


class Journal:
    """Writes a session. Methods may be called from any thread, and none of them fails.

    What cannot be written is kept, and tried again with the next record: the file has no gap.
    """

    def __init__(self, path: Path, header: Header) -> None:
        """Of a session that begins; the file is made with its first record."""
        self._path = path
        self._file: int | None = None
        self._first: Line | None = header_line(header)
        self._good = 0
        """Bytes of the file that are known to be whole, and on the disk."""
        self._sum = self._first.sum
        self._start()

    def _start(self) -> None:
        self._waiting: list[Record] = []
        self._is_unsure = False
        """Whether the file may have something behind what is whole."""
        self._fault: str | None = None
        self._is_begun = False
        """Whether anything has been learned or done."""
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
        journal._is_begun = True
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
                self._is_begun = self._is_begun or not isinstance(record, Began)
                self._waiting.append(record)
                self._write()

    def begin_with(self, records: Iterable[Record]) -> None:
        """Write down at once what was done before, in a session from elsewhere."""
        with self._lock:
            self._is_begun = True
            self._waiting.extend(records)
            self._write()

    def stood(self, record: Stood, at_rest: bool = False) -> None:
        """Write down where the live run stands: always where it rests, else now and then."""
        with self._lock:
            now_s = time.monotonic()
            is_due = now_s - self._stood_s >= (now_s - self._began_s) / _STANDS
            if self._is_over or not (at_rest or is_due):
                return
            self._stood_s = now_s
            self._is_begun = self._is_begun or record.step > 0
            newest = self._waiting[-1] if self._waiting else None
            if isinstance(newest, Stood) and newest.run == record.run:
                # Where it stood before that nobody will ask, and a disk may be full for days.
                self._waiting.pop()
            self._waiting.append(record)
            self._write()

    def close(self) -> None:
        """Try once more to write what waits, and let the file go.

        There is no file any more if nothing has been learned or done in the session.
        """
        with self._lock:
            if not self._is_over and self._waiting:
                self._write()
            if self._file is not None and not self._is_begun:
                with contextlib.suppress(OSError):
                    self._path.unlink()
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
            lines.append(line_of(encoded(record), total))
            total = lines[-1].sum
        data = b"".join(line.data for line in lines)
        if self._good + len(data) > MAX_BYTES or max(len(line.data) for line in lines) > MAX_LINE:
            fault = (
                f"This session has all the {MAX_BYTES // 2**20} MB that one may have: what is done"
                " from here on is not kept."
            )
            log.warning("%s", fault)
            self._end(fault)
            return
        try:
            self._put(data)
        except OSError as error:
            self._is_unsure = True
            if self._fault is None:
                log.warning("this session is not kept: %s: %s", self._path.parent, _reason(error))
            # Pages are not told where files of this machine are.
            self._fault = f"This session is not kept: {_reason(error)}."
            return
        self._good, self._sum, self._first = self._good + len(data), total, None
        self._waiting.clear()
        if self._fault is not None:
            log.warning("the session is kept again")
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
    for number in range(1, MOST_NAMES):
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
