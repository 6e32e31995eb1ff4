"""Writing a file so that whoever looks finds it whole, or as it was before."""

import contextlib
import os
import secrets
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
