"""Who may write into a folder of results: whether it is free, and the lock of the one who does."""

import contextlib
import errno
import fcntl
import sqlite3
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Final

LOCK: Final = ".lock"
PASSING: Final = ".*.tmp"
"""What something that kills the program leaves of a file that was being written."""


class FolderError(Exception):
    """Results cannot be kept in that folder; the message says why."""


@contextlib.contextmanager
def claiming() -> Iterator[None]:
    """Whatever is in the way of using a folder is a `FolderError`."""
    try:
        yield
    except sqlite3.Error as error:
        raise FolderError(f"holds a results.sqlite that cannot be used: {error}") from error
    except OSError as error:
        raise unwritable(error) from error


def unwritable(error: OSError) -> FolderError:
    """What is in the way of writing into a folder."""
    return FolderError(
        f"cannot be written to: {error.strerror or error}; allowed: a folder that can"
    )


def is_free(path: Path) -> bool:
    """Whether there is no such folder, or nothing in it but what a killed writer leaves.

    Raises:
        OSError: it cannot be looked into.
    """
    return not path.exists() or _holds_only(path)


def is_new(path: Path, resume: bool, force: bool) -> bool:
    """Whether nothing is there; if something is, it must be results that may be used so.

    Raises:
        FolderError: it is not.
    """
    if is_free(path):
        return True
    if not (force or resume):
        raise FolderError(
            "is there already and not empty; allowed: another folder, --resume to go on, or"
            " --force to begin again"
        )
    # --force begins results again; it clears nothing that is not results.
    if not holds_results(path):
        raise FolderError("holds something else than results; allowed: another folder")
    return False


def holds_results(path: Path) -> bool:
    """Whether there are results in a folder, be they as good as not begun."""
    if (path / "results.sqlite").is_file():
        return True
    if not (path / "experiment.yaml").is_file():
        return False
    # A writer that was killed at once leaves its lock; an experiment of one's own has none.
    begun = (path / LOCK).is_file() and _holds_only(path, "experiment.yaml")
    return begun or (path / "arrays").is_dir()


def _holds_only(path: Path, *names: str) -> bool:
    """Whether all that is in a folder is of these names, or a lock, or what a kill leaves."""
    # While it is locked, SQLite keeps a journal beside the lock.
    ours = {LOCK, f"{LOCK}-journal", *names}
    return all(
        entry.name in ours or (entry.match(PASSING) and entry.is_file()) for entry in path.iterdir()
    )


@contextlib.contextmanager
def tried(path: Path) -> Iterator[None]:
    """Refuse a folder that others write into or that cannot be written to; it stays as it is."""
    # Where there is no lock, nobody holds it, and none is made.
    if (path / LOCK).exists():
        with locked(path):
            yield
    else:
        with tempfile.TemporaryFile(dir=path) as file:
            if not takes_locks(file.fileno()):
                raise _without_locks()
            yield


@contextlib.contextmanager
def locked(path: Path) -> Iterator[None]:
    """Keep others from writing into a folder; whatever ends this program unlocks it.

    Raises:
        FolderError: another one writes into it, or it cannot be locked.
    """
    file = path / LOCK
    was_there = file.exists()
    with contextlib.ExitStack() as stack:
        try:
            # SQLite's locks are there on every system.
            lock = sqlite3.connect(file, timeout=0, isolation_level=None)
            stack.callback(lock.close)
            lock.execute("BEGIN EXCLUSIVE")
        except sqlite3.Error as error:
            if error.sqlite_errorcode & 0xFF == sqlite3.SQLITE_BUSY:
                # To SQLite a disk that knows no locks is one where all is locked.
                with tempfile.TemporaryFile(dir=path) as probe:
                    if not takes_locks(probe.fileno()):
                        if not was_there:
                            file.unlink(missing_ok=True)
                        raise _without_locks() from error
                raise FolderError(
                    "is being written to by another pounce; allowed: another folder, or later"
                ) from error
            raise FolderError(
                f"cannot be locked: {error}; allowed: a folder that can be written to"
            ) from error
        yield


def _without_locks() -> FolderError:
    return FolderError(
        "is on a disk that cannot lock files, as network disks are at times, so two could write to"
        " it at once; allowed: a folder on another disk"
    )


def takes_locks(file: int, kind: int = fcntl.LOCK_EX) -> bool:
    """Whether the disk of a file can lock it; for a moment it is locked, if nobody else does.

    Args:
        file: its descriptor.
        kind: of the lock; to lock a file that is open for reading alone, ``LOCK_SH``.
    """
    try:
        fcntl.lockf(file, kind | fcntl.LOCK_NB)
        fcntl.lockf(file, fcntl.LOCK_UN)
    except OSError as error:
        return error.errno in (errno.EACCES, errno.EAGAIN)
    return True
