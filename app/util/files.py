"""Files that whoever looks finds whole, or as they were before; folders that leave no trace."""

import contextlib
import os
import secrets
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from app.util import leftovers

PASSING: Final = f"{leftovers.NAME}*.tmp"
"""What something that kills the program leaves of a file that was being written."""


def write_whole(path: Path, data: bytes) -> None:
    """Put a file into place, whole or not at all, with the permissions that new files get.

    What is there of that name is replaced. Something that kills the program may leave a file of
    :data:`PASSING` beside it.

    Raises:
        OSError: it cannot be written; what was there before still is.
    """
    while not _is_written(path, data):
        pass


def _is_written(path: Path, data: bytes) -> bool:
    """Whether a file was put into place, and not taken for one that was left and taken away."""
    # Of two that write at once, each has a name of its own, whatever the length of the file's.
    passing = path.with_name(f"{leftovers.NAME}{secrets.token_hex(8)}.tmp")
    try:
        with passing.open("xb") as file:
            if not leftovers.hold(file.fileno(), passing):
                return False
            file.write(data)
            file.flush()
            # A file that is in place must not turn out empty after a loss of power.
            os.fsync(file.fileno())
            os.replace(passing, path)
    except BaseException:
        with contextlib.suppress(OSError):
            passing.unlink(missing_ok=True)
        raise
    return True


def make_folders(folder: Path) -> list[Path]:
    """Make a folder and those above it; returns the ones that were not there, the lowest first.

    Raises:
        OSError: it cannot be made; nothing is left of those above it.
    """
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        remove_folders(missing)
        raise
    return missing


def remove_folders(folders: Iterable[Path]) -> None:
    """Remove folders from the lowest up, as far as they are empty."""
    for folder in folders:
        with contextlib.suppress(OSError):
            folder.rmdir()
