"""Clients of a lab in a process of their own, so that what they take is not taken from the lab."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def clients(module: str, port: int, n_clients: int, *words: str) -> Iterator[subprocess.Popen[str]]:
    """The process of so many clients, which ends with the block.

    Args:
        module: what they do, a module of this package; it reads lines and answers by lines of JSON.
        port: of the lab.
        n_clients: how many they are.
        words: what else it is told.
    """
    command = [sys.executable, "-m", f"benchmarks.{module}", str(port), str(n_clients), *words]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()
