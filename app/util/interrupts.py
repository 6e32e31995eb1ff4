"""What Ctrl-C does: from the first moment to the last it ends the program, with one word.

As long as there is nothing to undo it does so at once, from within the signal's handler: an
exception would be shown, or lost, by whatever is being imported or compiled just then. While there
is, :func:`undoing`, it is the exception ``KeyboardInterrupt``.

What ends a program from outside does so likewise: a batch system ends a job whose time is over with
SIGTERM, a terminal that is closed ends its programs with SIGHUP. Nothing is left half done.
"""

import atexit
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType

EXIT_INTERRUPTED = 130
"""As shells report a program that SIGINT ended."""

_AGAIN_S = 0.01
_ENDING = ("SIGTERM", "SIGHUP")
"""Names, since some systems have not both."""

_undoing = False
_interrupted = False


def end_the_program() -> None:
    """Let an interrupt end the program, unless whoever started it has it ignored."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)
        sys.unraisablehook = _raise_again
        # What is registered first is done last.
        atexit.register(_leave)


@contextmanager
def undoing() -> Iterator[None]:
    """While this lasts, an interrupt is an exception, so that what was begun is undone or kept."""
    global _undoing
    _undoing = True
    try:
        yield
    finally:
        _undoing = False


def _end(signum: int, frame: FrameType | None) -> None:
    global _interrupted
    if _undoing:
        _interrupted = True
        raise KeyboardInterrupt
    os.write(2, b"interrupted\n")
    os._exit(EXIT_INTERRUPTED)


def _leave() -> None:
    """Exit with the code of an interrupt.

    With ``-m`` Python itself would end by the signal, if the exception went through a text that was
    executed.
    """
    if _interrupted:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError):
                stream.flush()
        os._exit(EXIT_INTERRUPTED)


def _raise_again(lost: "sys.UnraisableHookArgs") -> None:
    """An interrupt that came where exceptions are lost, as in a finalizer, comes once more."""
    if not issubclass(lost.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(lost)
        return
    import _thread

    # A little later, since here it would be lost again.
    threading.Timer(_AGAIN_S, _thread.interrupt_main).start()


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


@contextmanager
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
