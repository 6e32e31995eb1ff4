"""What the lab's log says on the terminal: nothing of a stranger's raw, and of each kind little.

Texts of pages, files and headers end up in log lines, of this program and of the libraries that it
uses. A control character among them would act on the terminal; a line for each message that a page
sends would bury everything else.
"""

import contextlib
import logging
import math
import sys
import threading
import time
import warnings
from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from typing import Any, Final, TextIO

from app.util.texts import for_terminal

LEVELS: Final = {
    "debug": logging.DEBUG,
    "info": logging.INFO,
    "warning": logging.WARNING,
    "error": logging.ERROR,
}
"""What can be asked to be said, and all that is worse: with ``debug`` what the learner is asked for
and where failures come from, with ``info`` which pages come, go, and send what is not taken."""

OWN_PACKAGES: Final = ("app", "sim", "learners")

QUIET_S = 10.0
"""A line of one kind comes at most once in this time; the next one says how many were left out."""

MAX_KINDS: Final = 200
"""Kinds of lines that are told apart; of more, the one that rests longest is forgotten."""

MAX_CHARACTERS: Final = 2_000
"""Longest text of a line, before it is escaped; of a traceback ten times as much."""


def _in_one_line(text: str) -> str:
    return for_terminal(text).replace("\n", "\\n").replace("\t", "\\t")


def _shortened(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[:most]} … ({len(text) - most:,} characters more)"


class Plain(logging.Formatter):
    """The message of a record in one line, and its traceback, with all that is special escaped."""

    def format(self, record: logging.LogRecord) -> str:
        """The text of a record."""
        text = _in_one_line(_shortened(record.getMessage(), MAX_CHARACTERS))
        if record.exc_info:
            trace = self.formatException(record.exc_info)
            # Its end says most.
            trace = for_terminal(trace[-10 * MAX_CHARACTERS :])
            text = f"{text}\n{trace}"
        return text


@dataclass
class _Kind:
    said_s: float
    left_out: int = 0
    text: str = ""
    """Of the latest that was left out."""


class Sparing(logging.StreamHandler[Any]):
    """Writes at most one line of each kind in :data:`QUIET_S`, and then how many there were.

    Lines are of one kind if the same place in a program wrote them: what they say may differ.
    """

    def __init__(self, stream: TextIO) -> None:
        super().__init__(stream)
        self.setFormatter(Plain())
        self._kinds: dict[Hashable, _Kind] = {}
        """The one that was heard of longest ago first."""
        self._timer: threading.Timer | None = None

    def emit(self, record: logging.LogRecord) -> None:
        """Write a record, or count it."""
        now_s = time.monotonic()
        key = getattr(record, "kind", (record.name, record.pathname, record.lineno))
        kind = self._kinds.pop(key, None)
        if kind is None:
            self._forget_one()
            kind = _Kind(-math.inf)
        self._kinds[key] = kind
        if now_s - kind.said_s < QUIET_S:
            kind.left_out += 1
            kind.text = _shortened(self.format(record).partition("\n")[0], 200)
            self._look_again()
            return
        self._say_rest(kind)
        kind.said_s = now_s
        super().emit(record)

    def close(self) -> None:
        """Say what was left out so far."""
        self.acquire()
        try:
            if self._timer is not None:
                self._timer.cancel()
            for kind in self._kinds.values():
                self._say_rest(kind)
        finally:
            self.release()
        super().close()

    def _forget_one(self) -> None:
        if len(self._kinds) >= MAX_KINDS:
            self._say_rest(self._kinds.pop(next(iter(self._kinds))))

    def _say_rest(self, kind: _Kind) -> None:
        if kind.left_out:
            self.stream.write(f"… and {kind.left_out:,} more, the last: {kind.text}\n")
            self.flush()
        kind.left_out = 0

    def _look_again(self) -> None:
        """Have the rest said once it is due, also if nothing more comes."""
        if self._timer is None:
            self._timer = threading.Timer(QUIET_S, self._say_what_is_due)
            self._timer.daemon = True
            self._timer.start()

    def _say_what_is_due(self) -> None:
        self.acquire()
        try:
            self._timer = None
            now_s = time.monotonic()
            for kind in self._kinds.values():
                if kind.left_out and now_s - kind.said_s >= QUIET_S:
                    self._say_rest(kind)
                    kind.said_s = now_s
            if any(kind.left_out for kind in self._kinds.values()):
                self._look_again()
        finally:
            self.release()


def _log_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Log a warning in the place of printing it; those of one line of code are of one kind."""
    logging.getLogger("warnings").warning(
        "%s:%d: %s: %s",
        filename,
        lineno,
        category.__name__,
        message,
        extra={"kind": (filename, lineno)},
    )


@contextlib.contextmanager
def sparing_log(level: int = logging.WARNING) -> Iterator[None]:
    """Have all that is logged or warned of inside the context written to stderr in this way.

    Args:
        level: the least that is said (of :data:`LEVELS`). What is less than a warning is said of
            this program alone: libraries put requests into it, with cookies and tokens.
    """
    handler = Sparing(sys.stderr)
    handler.setLevel(level)
    root = logging.getLogger()
    root.addHandler(handler)
    own = [logging.getLogger(package) for package in OWN_PACKAGES]
    before = [logger.level for logger in own]
    for logger in own:
        logger.setLevel(level)
    # Whatever is warned of once for each text is remembered for ever, with the text.
    warnings.simplefilter("always", append=True)
    show, warnings.showwarning = warnings.showwarning, _log_warning
    try:
        yield
    finally:
        warnings.showwarning = show
        for logger, former in zip(own, before, strict=True):
            logger.setLevel(former)
        root.removeHandler(handler)
        handler.close()
