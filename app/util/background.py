"""What takes too long for the render loop is made elsewhere: one thing at a time, on copies.

The newest wish wins, and a result says what it is of.
"""

import logging
import threading
import time
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

Made = TypeVar("Made")

log = logging.getLogger(__name__)

_RETRY_S = 2.0
"""Pause after a thing could not be made, before the same is tried once more."""


class Maker(Generic[Made]):
    """Makes one thing at a time in a thread of its own; may be asked again and again."""

    def __init__(
        self,
        made: Callable[[], object] = lambda: None,
        rest_s: float = 0.0,
        rest_ratio: float = 0.0,
    ) -> None:
        """Prepare.

        Args:
            made: called once a thing is there, in that thread, or in the one that asked if no
                other could be started.
            rest_s: pause between two things, so that others get their share of the cores.
            rest_ratio: pause after a thing, as a multiple of what it took, if that is longer.
        """
        self._made = made
        self._rest_s, self._rest_ratio = rest_s, rest_ratio
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._busy = self._stopped = False
        self._found: tuple[Hashable, Made | Exception] | None = None
        self._found_at = self._took_s = 0.0

    @property
    def found(self) -> Made | Exception | None:
        """The latest thing there is, or what went wrong with it."""
        return None if self._found is None else self._found[1]

    @property
    def latest(self) -> tuple[Hashable, Made | Exception | None]:
        """What the latest thing is of, and :attr:`found`, which belongs to it."""
        return self._found or (None, None)

    def want(self, of: Hashable, make: Callable[[], Made]) -> None:
        """Ask for a thing; does nothing while one is being made, or if it is there.

        What could not be made is not there: it is tried again after a while, since what was in
        its way may be gone.
        """
        with self._lock:
            if self._busy or self._stopped or not self._is_time_for(of):
                return
            thread = threading.Thread(target=self._make, args=(of, make), daemon=True)
            try:
                thread.start()
            except RuntimeError as error:
                log.debug("no thread to make it in", exc_info=True)
                self._keep(of, error)
            else:
                self._thread, self._busy = thread, True
                return
        self._made()

    def stop(self) -> None:
        """Make nothing more, and wait for what is being made."""
        with self._lock:
            self._stopped = True
            thread = self._thread
        if thread is not None:
            thread.join()

    def _is_time_for(self, of: Hashable) -> bool:
        if self._found is None:
            return True
        pause_s = max(self._rest_s, self._rest_ratio * self._took_s)
        if self._found[0] == of:
            if not isinstance(self._found[1], Exception):
                return False
            pause_s = max(pause_s, _RETRY_S)
        return time.perf_counter() - self._found_at >= pause_s

    def _make(self, of: Hashable, make: Callable[[], Made]) -> None:
        found: Made | Exception
        started = time.perf_counter()
        try:
            found = make()
        except Exception as error:
            # It is not lost: whoever asked is given it in place of the thing.
            log.debug("not made", exc_info=True)
            found = error
        with self._lock:
            self._keep(of, found)
            self._took_s = self._found_at - started
            self._busy = False
        self._made()

    def _keep(self, of: Hashable, found: Made | Exception) -> None:
        self._found = (of, found)
        self._found_at = time.perf_counter()
