"""What ends a program from outside does so as Ctrl-C does: nothing is left half done.

A batch system ends a job whose time is over with SIGTERM; a terminal that is closed ends its
programs with SIGHUP.
"""

import contextlib
import signal
import threading
from collections.abc import Iterator

from app.cli_words import EXIT_INTERRUPTED

_ENDING = ("SIGTERM", "SIGHUP")
"""Names, since some systems have not both."""


class Ended(KeyboardInterrupt):
    """A signal is to end the program."""

    def __init__(self, number: int) -> None:
        """Of a signal by its number."""
        self.number = number
        super().__init__(f"ended by {signal.Signals(number).name}")


def ended_by(ending: KeyboardInterrupt) -> tuple[str, int]:
    """What ended the program in words, and the exit code that shells report for it."""
    if isinstance(ending, Ended):
        return str(ending), 128 + ending.number
    return "interrupted", EXIT_INTERRUPTED


@contextlib.contextmanager
def as_interrupts() -> Iterator[None]:
    """Let signals that are to end the program raise `Ended`, once, while this lasts."""
    if threading.current_thread() is not threading.main_thread():
        # Python has signals handled in its main thread alone.
        yield
        return
    numbers = [getattr(signal, name) for name in _ENDING if hasattr(signal, name)]
    before = {number: signal.getsignal(number) for number in numbers}
    # What whoever started it has it ignore, as nohup does, stays so.
    heard = [number for number in numbers if before[number] == signal.SIG_DFL]

    def end(number: int, _: object) -> None:
        # Those who end a program at times say so twice, and it is clearing up already.
        for other in heard:
            signal.signal(other, signal.SIG_IGN)
        raise Ended(number)

    for number in heard:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number in heard:
            signal.signal(number, before[number])
