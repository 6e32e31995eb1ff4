"""What programs that were killed leave, told from what living ones work with: these lock it."""

import contextlib
import fcntl
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

NAME = ".pounce-"
"""How the names of files and folders begin that are to pass."""


def hold(file: int, path: Path) -> bool:
    """Keep others from taking a file or a folder for one that was left, until it is closed.

    Args:
        file: descriptor of the file or the folder; whatever ends this program closes it.
        path: where it is.

    Returns:
        Whether it is still there: somebody may have taken it away since it was made.
    """
    # Where a disk has no locks, nothing is taken away there either.
    with contextlib.suppress(OSError):
        fcntl.flock(file, fcntl.LOCK_EX)
    return path.exists()


def clear(folder: Path, pattern: str) -> None:
    """Take away the files and folders of a pattern that were left; what cannot be taken stays."""
    for path in folder.glob(pattern):
        with contextlib.suppress(OSError), _unused(path):
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink()


@contextlib.contextmanager
def _unused(path: Path) -> Iterator[None]:
    """Hold a file or a folder that nobody else does.

    Raises:
        OSError: somebody does, or nobody can.
    """
    file = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(file)
