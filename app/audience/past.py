"""Moments of the past for those who look around, made apart from all others, and not many a second.

What the presenter and the learner have is left to them: no checkpoint is kept for it, nobody waits
behind it, and after each moment there is a rest that is several times as long.
"""

import logging
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Iterable
from typing import Final

from app.live.moments import moment_at
from app.live.past import Past
from app.live.places import Place
from app.live.snapshot import Snapshot

REST_RATIO: Final = 4.0
"""Pause after a moment, as a multiple of what it took."""
LEAST_REST_S: Final = 0.05
MOST_KEPT: Final = 24
"""Moments that are kept; each is some hundred kilobytes."""

log = logging.getLogger(__name__)


class Rarely:
    """Makes moments in a thread of its own, in turn. Methods may be called from any thread."""

    def __init__(self, past_of: Callable[[int], Past | None], found: Callable[[], object]) -> None:
        """``found`` is called in the thread when there is one more."""
        self._past_of = past_of
        self._found = found
        self._kept: OrderedDict[Place, Snapshot | None] = OrderedDict()
        """None of those that cannot be made."""
        self._wanted: tuple[tuple[Place, str], ...] = ()
        self._turn = 0
        self._changed = threading.Condition()
        self._stopping = False
        self._thread: threading.Thread | None = None

    def at(self, place: Place) -> Snapshot | None:
        """A moment that has been made; None if it has not, or its line is another by now."""
        with self._changed:
            found = self._kept.get(place)
            if found is not None:
                self._kept.move_to_end(place)
        past = self._past_of(place.line)
        if found is None or past is None or not past.is_still(found.step, found.control):
            return None
        return found

    def want(self, places: Iterable[tuple[Place, str]]) -> None:
        """Have these made, one after the other, and none that was wished before.

        Each with the name of its preset.
        """
        wanted = tuple(wish for wish in places if self._is_to_be_made(wish[0]))
        with self._changed:
            self._wanted = wanted
            if wanted and self._thread is None and not self._stopping:
                self._thread = threading.Thread(target=self._work, name="audience past")
                self._thread.daemon = True
                self._thread.start()
            self._changed.notify_all()

    def _is_to_be_made(self, place: Place) -> bool:
        with self._changed:
            cannot_be = place in self._kept and self._kept[place] is None
        return not cannot_be and self.at(place) is None

    def stop(self) -> None:
        """Make nothing more."""
        with self._changed:
            self._stopping = True
            self._changed.notify_all()
            thread = self._thread
        if thread is not None:
            thread.join(timeout=2.0)

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._stopping or self._wanted)
                if self._stopping:
                    return
                # Each of them has its turn, however many are wished.
                self._turn += 1
                place, preset = self._wanted[self._turn % len(self._wanted)]
            began_s = time.perf_counter()
            made = self._made(place, preset)
            with self._changed:
                self._kept[place] = made
                self._kept.move_to_end(place)
                while len(self._kept) > MOST_KEPT:
                    self._kept.popitem(last=False)
                self._wanted = tuple(wish for wish in self._wanted if wish[0] != place)
            self._found()
            rest_s = max(REST_RATIO * (time.perf_counter() - began_s), LEAST_REST_S)
            with self._changed:
                self._changed.wait_for(lambda: self._stopping, rest_s)

    def _made(self, place: Place, preset: str) -> Snapshot | None:
        past = self._past_of(place.line)
        try:
            if past is None:
                return None
            return moment_at(past, place, preset, lambda: not self._stopping, quietly=True)
        except Exception:
            # Whoever wished it goes on to see what they saw, and the next one is made all the same.
            log.exception("a moment for the audience could not be made")
            return None
