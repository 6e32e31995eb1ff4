"""What this machine offers, and how long things take on it, in words."""

import contextlib
import ctypes
import os
import resource
import sys
from pathlib import Path


def available_cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def duration(seconds: float) -> str:
    """A time in words that are short."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < 90 else f"{minutes / 60:.1f} h"


def resident_mb() -> float:
    """Memory that this process holds, in MB; the most it ever held, where only that is told."""
    with contextlib.suppress(OSError):
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize() / 1e6
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    # In kilobytes, but for macOS.
    return most / 1e6 if sys.platform == "darwin" else most / 1e3


_M_ARENA_MAX = -8
"""Of ``mallopt`` of the GNU C library: from how many places threads may be given memory."""
_ARENAS = 2


def share_memory() -> None:
    """Let all threads take memory from the same places, where the C library can be told so.

    Otherwise each of many threads keeps for itself what it once needed.
    """
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).mallopt(_M_ARENA_MAX, _ARENAS)


def give_back_memory() -> None:
    """Return memory that is free to the system, where the C library can be told so.

    It keeps what lies between things that are still in use: after many pages have come and gone,
    a quarter of all that the process holds.
    """
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)
