"""A thread that makes what viewers wish: of what one of them wishes only the newest counts.

It has its own copies of everything, so a run that goes on has no business with it. Viewers are
served in turn. What else is to be done beside the runs is done here too, and what can wait is done
while nobody wishes anything.
"""

import logging
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Hashable
from typing import Final, Generic, NamedTuple, TypeVar

from learners.commands import CommandError

Wish = TypeVar("Wish")
Made = TypeVar("Made")
"""What comes of a wish."""
Done = TypeVar("Done")

log = logging.getLogger(__name__)

MOST_WAITING: Final = 100
"""Things to be done that may wait, besides the viewers' wishes."""

_GIVEN_UP_AFTER_S: Final = 0.15
"""What takes longer is given up once its viewer wishes something else."""
_IDLE_EVERY_S: Final = 0.25
"""What can wait is done a little so often even if there is always something to do."""
_FAREWELL_S: Final = 2.0


class _Job(NamedTuple):
    do: Callable[[], object]
    failed: Callable[[str], object]


class Wishes(ABC, Generic[Wish, Made]):
    """The thread, whatever is wished. All methods may be called from any thread."""

    def __init__(self, name: str) -> None:
        """Prepare; the thread, of that name, begins with the first wish."""
        self._name = name
        self._changed = threading.Condition()
        self._thread: threading.Thread | None = None
        self._stopping = False
        self._wishes: dict[Hashable, Wish] = {}
        """The newest of each viewer; who waits longest comes first."""
        self._found: dict[Hashable, tuple[Wish, Made]] = {}
        """What was made for each, and of which wish."""
        self._faults: dict[Hashable, str] = {}
        self._viewers: set[Hashable] = set()
        self._asked: deque[_Job] = deque()
        self._idle: deque[_Job] = deque()
        self._idled_s = time.perf_counter()
        self._asked_last = False
        self._making: Hashable = None
        """Whose wish is being made; None if nobody's is."""
        self._on_found: Callable[[], object] = lambda: None

    # What is wished

    @abstractmethod
    def _made(self, wish: Wish, is_wanted: Callable[[], bool]) -> Made | None:
        """What is wished; None if it is not wanted any more, which is asked on the way.

        Raises:
            CommandError: it cannot be made, as the message says.
        """

    @abstractmethod
    def _is_still(self, wish: Wish, made: Made) -> bool:
        """Whether what was made would be the same if it were made now."""

    # What viewers wish

    def want(self, viewer: Hashable, wish: Wish) -> None:
        """Have something made for a viewer, who wishes nothing of before any more."""
        found = self._found.get(viewer)
        is_there = found is not None and found[0] == wish and self._is_still(*found)
        with self._changed:
            # What is being made for the viewer would take its place.
            if is_there and self._making != viewer:
                self._wishes.pop(viewer, None)
                return
            self._viewers.add(viewer)
            self._wishes[viewer] = wish
            self._wake()

    def found(self, viewer: Hashable) -> Made | None:
        """The newest that was made for a viewer; None before the first."""
        found = self._found.get(viewer)
        return None if found is None else found[1]

    def fault(self, viewer: Hashable) -> str | None:
        """Why what a viewer wished last could not be made; None if it was."""
        return self._faults.get(viewer)

    def forget(self, viewer: Hashable) -> None:
        """Make nothing any more for a viewer, who is gone or looks at what is live."""
        with self._changed:
            self._viewers.discard(viewer)
            for kept in (self._wishes, self._found, self._faults):
                kept.pop(viewer, None)

    def call_when_found(self, callback: Callable[[], object]) -> None:
        """Have this called, in the thread, when something was made or could not be."""
        self._on_found = callback

    # What else is done in this thread

    def ask(
        self,
        do: Callable[[], Done],
        then: Callable[[Done], object],
        failed: Callable[[str], object] = lambda reason: None,
    ) -> None:
        """Have something done in the thread, before what is wished after it.

        Args:
            do: the work.
            then: told what came of it, in the thread.
            failed: told why nothing did.
        """
        job = _Job(lambda: then(do()), failed)
        with self._changed:
            is_taken = len(self._asked) < MOST_WAITING and not self._stopping
            if is_taken:
                self._asked.append(job)
                self._wake()
        if not is_taken:
            failed(f"{MOST_WAITING} things wait to be done in the past; ask again later")

    def do_meanwhile(
        self, do: Callable[[], bool], failed: Callable[[str], object] = lambda reason: None
    ) -> None:
        """Have something done little by little, while there is nothing else to do.

        Args:
            do: does some milliseconds' worth of it, and tells whether there is more to do.
            failed: told why that is the end of it, if it is.
        """
        with self._changed:
            self._idle.append(_Job(do, failed))
            self._wake()

    def stop(self) -> None:
        """End the thread and wait for it, unless it is deaf because it compiles."""
        with self._changed:
            self._stopping = True
            self._changed.notify_all()
            thread = self._thread
        if thread is not None:
            thread.join(timeout=_FAREWELL_S)

    # What the thread does

    def _wake(self) -> None:
        if self._thread is None and not self._stopping:
            self._thread = threading.Thread(target=self._work, name=self._name, daemon=True)
            self._thread.start()
        self._changed.notify_all()

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(
                    lambda: self._stopping or self._asked or self._wishes or self._idle
                )
                if self._stopping:
                    return
                next_to_do = self._next()
            next_to_do()

    def _next(self) -> Callable[[], object]:
        """What is to be done now; there is something."""
        now_s = time.perf_counter()
        is_busy = bool(self._asked or self._wishes)
        if self._idle and (not is_busy or now_s - self._idled_s >= _IDLE_EVERY_S):
            job = self._idle.popleft()
            return lambda: self._do_a_little(job)
        # What is asked for and what is wished are done in turn, so that neither waits for long.
        if self._asked and not (self._asked_last and self._wishes):
            self._asked_last = True
            job = self._asked.popleft()
            return lambda: self._do(job)
        self._asked_last = False
        viewer, wish = next(iter(self._wishes.items()))
        del self._wishes[viewer]
        self._making = viewer
        return lambda: self._make(viewer, wish)

    def _do(self, job: _Job) -> object:
        """Do something; returns what came of it, None if it failed, which is told."""
        try:
            return job.do()
        except CommandError as error:
            reason = str(error)
        except Exception as error:
            # Whatever went wrong with one thing, all others are still to be done.
            log.exception("something could not be done")
            reason = _reason_of(error)
        try:
            job.failed(reason)
        except Exception:
            log.exception("a refusal could not be told")
        return None

    def _do_a_little(self, job: _Job) -> None:
        is_more = self._do(job)
        with self._changed:
            self._idled_s = time.perf_counter()
            if is_more:
                self._idle.append(job)

    def _make(self, viewer: Hashable, wish: Wish) -> None:
        started_s = time.perf_counter()

        def is_wanted() -> bool:
            if self._stopping or viewer not in self._viewers:
                return False
            is_late = time.perf_counter() - started_s >= _GIVEN_UP_AFTER_S
            return not (is_late and viewer in self._wishes)

        made, fault = None, None
        try:
            made = self._made(wish, is_wanted)
        except CommandError as error:
            fault = str(error)
        except Exception as error:
            # The page must say so, and the next wish is made all the same.
            log.exception("what was wished could not be made")
            fault = _reason_of(error)
        with self._changed:
            self._making = None
            if viewer not in self._viewers or (made is None and fault is None):
                return
            if made is not None:
                self._found[viewer] = wish, made
            self._faults.pop(viewer, None)
            if fault is not None:
                self._faults[viewer] = fault
        try:
            self._on_found()
        except Exception:
            log.exception("what was made could not be told of")


def _reason_of(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"
