"""The folder in which sessions are kept: what they are called, which there are, and how many."""

import contextlib
import glob
import os
import re
import tempfile
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from typing import Final

from app import __version__
from app.live.journal import Journal, is_in_use
from app.live.written import SUFFIX, Glance, Header, SessionError, glance
from app.util import leftovers

LATEST: Final = "latest"
"""What the session is called that was written last."""
MOST_SESSIONS: Final = 50
MOST_BYTES: Final = 256 * 2**20
"""Of all sessions in a folder that were named here; the oldest go first."""

_NAMED_HERE: Final = re.compile(
    r"\d{4}-\d\d-\d\d-\d{6}-[A-Za-z0-9_-]+-seed\d+(-\d+)?(-saved\d*)?\.pounce"
)
"""A file that was given another name is its owner's, and stays, even if it begins so."""


def default_folder() -> Path:
    """The user's own, where programs keep what they would go on with.

    Raises:
        RuntimeError: there is no telling where this user's files are.
    """
    state = os.environ.get("XDG_STATE_HOME", "")
    base = Path(state) if os.path.isabs(state) else Path.home() / ".local" / "state"
    return base / "pounce" / "sessions"


def try_out(folder: Path) -> None:
    """Make the folder, and write something there.

    Raises:
        OSError: that cannot be.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=folder) as file:
        file.write(b"\n")
        file.flush()


def begun(folder: Path, preset: str, seed: int) -> Journal:
    """The journal of a session that begins now; its file is made with its first record."""
    now = datetime.now(UTC)
    header = Header(__version__, preset, seed, now.isoformat(timespec="seconds"))
    return Journal(folder / name_of_file(header, now), header)


def name_of_file(header: Header, now: datetime) -> str:
    """What the file of a session is called that is written at a time."""
    preset = re.sub(r"[^A-Za-z0-9_-]+", "_", header.preset).strip("_")[:40] or "preset"
    return f"{now:%Y-%m-%d-%H%M%S}-{preset}-seed{header.seed}{SUFFIX}"


@dataclass(frozen=True)
class Kept:
    """A session in the folder, as it is told from others."""

    path: Path
    glance: Glance
    written_at: float
    """When something was last written, in seconds since 1970."""
    n_bytes: int
    in_use: bool
    """Whether a lab writes it now."""

    @property
    def name(self) -> str:
        """What it is called."""
        return self.path.stem

    @property
    def is_begun(self) -> bool:
        """Whether anything has been learned or done in it."""
        return self.glance.trial > 0 or self.glance.n_commands > 0


def sessions_in(folder: Path) -> list[Kept]:
    """The sessions in a folder, the one first that was written last; what is none is left out."""
    found: list[Kept] = []
    for path in _files_in(folder):
        with contextlib.suppress(OSError, SessionError):
            stand = path.stat()
            seen = _glance(path, stand.st_mtime_ns, stand.st_size)
            found.append(Kept(path, seen, stand.st_mtime, stand.st_size, is_in_use(path)))
    return sorted(found, key=lambda kept: (kept.written_at, kept.name), reverse=True)


@lru_cache(maxsize=2 * MOST_SESSIONS)
def _glance(path: Path, changed_ns: int, n_bytes: int) -> Glance:
    """A look at a file as it is since then: each page that comes asks for all of them."""
    return glance(path)


def found(name: str, folder: Path | None) -> Path:
    """The file of a session that is asked for by its name, by its path, or as the latest.

    Raises:
        SessionError: there is none.
    """
    if name == LATEST:
        if folder is None:
            raise SessionError("no folder has sessions here; allowed: the file of one")
        latest = next((kept for kept in sessions_in(folder) if kept.is_begun), None)
        if latest is None:
            raise SessionError(f"{folder}: no session is kept there; allowed: the file of one")
        return latest.path
    path = Path(name)
    if folder is not None and path.name == name and not path.exists():
        for other in (folder / name, folder / f"{name}{SUFFIX}"):
            if other.exists():
                return other
    return path


def clear(folder: Path) -> None:
    """Delete the oldest sessions, so many that what stays is within bounds.

    One that a lab writes stays, and so does a file whose name was given by hand.
    """
    stands = list[tuple[float, Path, int]]()
    for path in _files_in(folder):
        if _NAMED_HERE.fullmatch(path.name):
            with contextlib.suppress(OSError):
                stand = path.lstat()
                stands.append((stand.st_mtime, path, stand.st_size))
    n_sessions = n_bytes = 0
    for _, path, size in sorted(stands, reverse=True):
        n_sessions, n_bytes = n_sessions + 1, n_bytes + size
        if n_sessions > MOST_SESSIONS or n_bytes > MOST_BYTES:
            leftovers.clear(folder, glob.escape(path.name))


def _files_in(folder: Path) -> list[Path]:
    try:
        return list(folder.glob(f"*{SUFFIX}"))
    except OSError:
        return []
