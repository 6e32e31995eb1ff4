"""Writing a file so that whoever looks finds it whole, or as it was before."""

import contextlib
import os
import secrets
from pathlib import Path


def write_whole(path: Path, data: bytes) -> None:
    """Put a file into place, whole or not at all, with the permissions that new files get.

    What is there of that name is replaced. Something that kills the program may leave a hidden
    ``.*.tmp`` beside it.

    Raises:
        OSError: it cannot be written; what was there before still is.
    """
    # Of two that write at once, each has a name of its own, whatever the length of the file's.
    passing = path.with_name(f".{secrets.token_hex(8)}.tmp")
    try:
        with passing.open("xb") as file:
            file.write(data)
            file.flush()
            # A file that is in place must not turn out empty after a loss of power.
            os.fsync(file.fileno())
        os.replace(passing, path)
    except BaseException:
        with contextlib.suppress(OSError):
            passing.unlink(missing_ok=True)
        raise
