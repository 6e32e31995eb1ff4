"""What takes too long for the render loop: success maps, and whatever else is made elsewhere.

One thread at a time, on copies; the newest wish wins, and a result says what it is of.
"""

import logging
import threading
import time
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

from app.layers import SuccessMap
from app.snapshot import Snapshot
from learners import greedy

Made = TypeVar("Made")

log = logging.getLogger(__name__)

_REST_S = 1.5
"""Pause between two maps, so that the learner keeps its cores."""


class SuccessFinder:
    """Finds success maps while somebody wants them."""

    def __init__(self) -> None:
        self._thread: threading.Thread | None = None
        self._stopping = threading.Event()
        self._found: SuccessMap | None = None
        self._of: tuple[int, int] | None = None
        self._done_at = 0.0

    @property
    def found(self) -> SuccessMap | None:
        """The latest map there is."""
        return self._found

    def want(self, snapshot: Snapshot) -> None:
        """Ask for a map of a moment; does nothing while one is being made, or if it is known."""
        moment = (snapshot.generation, snapshot.step)
        busy = self._thread is not None and self._thread.is_alive()
        if busy or moment == self._of or time.perf_counter() - self._done_at < _REST_S:
            return
        self._of = moment
        self._thread = threading.Thread(target=self._find, args=(snapshot,), daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the work and wait for it."""
        self._stopping.set()
        if self._thread is not None:
            self._thread.join()

    def _find(self, snapshot: Snapshot) -> None:
        skill_q = snapshot.skill_q if snapshot.spec.learner.skills else None
        policy = greedy.greedy_moves(snapshot.selection_q, skill_q)
        outcomes = greedy.success_map(
            snapshot.world, policy, snapshot.seed, lambda: not self._stopping.is_set()
        )
        if outcomes is not None:
            self._found = SuccessMap(outcomes, snapshot.trial, snapshot.generation)
        self._done_at = time.perf_counter()


class Maker(Generic[Made]):
    """Makes one thing at a time in a thread of its own; may be asked again and again."""

    def __init__(self, made: Callable[[], object] = lambda: None) -> None:
        """``made`` is called, in that thread, once a thing is there."""
        self._made = made
        self._lock = threading.Lock()
        self._busy = False
        self._of: Hashable = None
        self._found: tuple[Hashable, Made | Exception] | None = None

    @property
    def found(self) -> Made | Exception | None:
        """The latest thing there is, or what went wrong with it."""
        return None if self._found is None else self._found[1]

    @property
    def found_of(self) -> Hashable:
        """What the latest thing is of."""
        return None if self._found is None else self._found[0]

    def want(self, of: Hashable, make: Callable[[], Made]) -> None:
        """Ask for a thing; does nothing while one is being made, or if it is there."""
        with self._lock:
            if self._busy or (self._found is not None and self._of == of):
                return
            self._busy, self._of = True, of
        threading.Thread(target=self._make, args=(of, make), daemon=True).start()

    def _make(self, of: Hashable, make: Callable[[], Made]) -> None:
        found: Made | Exception
        try:
            found = make()
        except Exception as error:
            # It is not lost: whoever asked is given it in place of the thing.
            log.debug("not made", exc_info=True)
            found = error
        self._found = (of, found)
        with self._lock:
            self._busy = False
        self._made()
