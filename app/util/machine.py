"""What this machine offers, and what it gives to this process."""

import contextlib
import ctypes
import os
import resource
import sys
import threading
from pathlib import Path


def available_cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def memory_mb() -> float:
    """Memory that there is for this process and others beside it, in MB."""
    size = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    for limit in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        # A container may have less; some say "max" where they have not.
        with contextlib.suppress(OSError, ValueError):
            size = min(size, int(Path(limit).read_text()))
    return size / 1e6


def resident_mb() -> float:
    """Memory that this process holds, in MB; the most it ever held, where only that is told."""
    with contextlib.suppress(OSError):
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize() / 1e6
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    # In kilobytes, but for macOS.
    return most / 1e6 if sys.platform == "darwin" else most / 1e3


_MODEST = 10
"""Niceness of a thread that can wait."""
_SWITCH_S = 0.001
"""For so long a thread may hold the interpreter while others wait for it."""
_M_ARENA_MAX, _ARENAS = -8, 2
"""Of ``mallopt`` of the GNU C library: from how many places threads may be given memory."""
_M_MMAP_THRESHOLD, _LARGE = -3, 2**20
"""Of the same: what has so many bytes, as the log of a run, has a place of its own, and leaves none
when it goes."""


def share_among_threads() -> None:
    """Let many threads of this process get along.

    The learner needs the interpreter for a moment after each slice, and would wait as long for it
    as the slice took. And all take memory from the same places, where the C library can be told so;
    otherwise each would keep for itself what it once needed.
    """
    sys.setswitchinterval(_SWITCH_S)
    with contextlib.suppress(OSError, AttributeError):
        library = ctypes.CDLL(None)
        library.mallopt(_M_ARENA_MAX, _ARENAS)
        library.mallopt(_M_MMAP_THRESHOLD, _LARGE)


def give_back_memory() -> None:
    """Return memory that is free to the system, where the C library can be told so.

    It keeps what lies between things that are still in use: after many pages have come and gone,
    a quarter of all that the process holds.
    """
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)


def be_modest() -> None:
    """Let the calling thread give way to others of this process, where the system knows that."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _MODEST)
