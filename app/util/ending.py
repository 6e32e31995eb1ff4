"""How a program that serves ends: when a signal says so, and never without a word."""

import contextlib
import faulthandler
import os
import signal
import threading
from collections.abc import Callable, Iterator

_SIGNALS = tuple(
    number
    for name in ("SIGINT", "SIGTERM", "SIGHUP")
    if (number := getattr(signal, name, None)) is not None
)


class Ending:
    """What ended the program, or is to."""

    def __init__(self) -> None:
        self.signal: int | None = None
        self.last_words: dict[str, str] = {}
        """Why a thread ended that should not have, by its name."""
        self._end: Callable[[], object] | None = None

    def by(self, end: Callable[[], object]) -> None:
        """From now on a signal calls ``end()``, which must return at once."""
        self._end = end

    @property
    def exit_code(self) -> int:
        """As shells report it; Ctrl-C is the ordinary way to end what serves."""
        return 0 if self.signal in (None, signal.SIGINT) else 128 + self.signal

    def _take_signal(self, number: int, _: object) -> None:
        self.signal = number
        # Who asks a second time does not want to wait.
        for other in _SIGNALS:
            signal.signal(other, signal.SIG_DFL)
        if self._end is not None:
            self._end()
            return
        # There is nothing to undo as yet, and whatever is being imported or compiled just now could
        # show an exception, or lose it.
        if number == signal.SIGINT:
            os.write(2, b"interrupted\n")
        os._exit(128 + number)

    def _take_last_words(self, end: threading.ExceptHookArgs) -> None:
        name = "a thread" if end.thread is None else end.thread.name
        self.last_words[name] = f"{end.exc_type.__name__}: {end.exc_value}"
        threading.__excepthook__(end)


@contextlib.contextmanager
def watched() -> Iterator[Ending]:
    """Notice signals and the ends of threads, from the first moment on; for the main thread."""
    ending = Ending()
    former = {number: signal.getsignal(number) for number in _SIGNALS}
    for number in _SIGNALS:
        # `nohup` has a program ignore that its terminal is gone, and means it.
        if number == signal.SIGINT or former[number] is not signal.SIG_IGN:
            signal.signal(number, ending._take_signal)
    former_hook, threading.excepthook = threading.excepthook, ending._take_last_words
    # A crash in compiled code says at least where it was.
    if not faulthandler.is_enabled():
        faulthandler.enable()
    try:
        yield ending
    finally:
        threading.excepthook = former_hook
        for number, handler in former.items():
            signal.signal(number, handler)
