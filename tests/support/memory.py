"""What something takes of memory, in a process in which nothing else goes on."""

import multiprocessing
import tracemalloc
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from typing import Any


def peak_of(act: Callable[..., object], *args: Any) -> int:
    """Bytes that a function of a module takes at most, beside what it has already.

    Python counts what all threads of a process take, and labs of other tests may go on in this one.
    """
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as alone:
        return alone.submit(_peak, act, args).result()


def _peak(act: Callable[..., object], args: tuple[Any, ...]) -> int:
    # What it imports and keeps for later is no part of it.
    act(*args)
    tracemalloc.start()
    try:
        act(*args)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
