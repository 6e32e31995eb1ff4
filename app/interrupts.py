"""What Ctrl-C does: from the first moment to the last it ends the program, with one word.

As long as there is nothing to undo it does so at once, from within the signal's handler: an
exception would be shown, or lost, by whatever is being imported or compiled just then. While there
is, :func:`undoing`, it is the exception ``KeyboardInterrupt``.
"""

import atexit
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType

EXIT_INTERRUPTED = 130
"""As shells report a program that SIGINT ended."""

_AGAIN_S = 0.01

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
    import threading

    # A little later, since here it would be lost again.
    threading.Timer(_AGAIN_S, _thread.interrupt_main).start()
