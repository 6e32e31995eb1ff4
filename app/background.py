"""What takes too long for the render loop: where a greedy hunt from each cell would end.

One thread at a time, on copies; the newest moment wins, and a result says of which trial it is.
"""

import threading
import time

from app.layers import SuccessMap
from app.snapshot import Snapshot
from learners import greedy

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
