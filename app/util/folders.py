"""Folders that are made for results, and taken away again where none come to lie in them."""

import contextlib
from collections.abc import Iterable
from pathlib import Path


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
