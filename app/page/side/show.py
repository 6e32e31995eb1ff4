"""The thread that shows runs side by side to all browsers that look at them.

The runs are the session's, and so is their thread (:mod:`app.live.race`); which moment of them a
browser looks at, and how, is its own. All of it is done here and nothing in the render loop, whose
frames are seldom, and no widget is touched here: what a frame is sent goes over its channel.
"""

import logging
import math
import threading
import time
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any, Final, Protocol

import msgspec

from app.charts.race import curves_sent
from app.explain.happenings import Happening, first_capture_in, happenings_of
from app.live.race import Race, RaceStatus
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.page.side.measured import Apart, GreedyRuns, Successes
from app.picture.layer import Extras
from app.picture.look import Look
from app.player.boards import ground_sent, over_sent

_FRAME_S: Final = 1 / 30
_LEAST_PAUSE: Final = 1.25
"""From one round to the next, as a multiple of what it took: learners get their share."""
_CURVES_S: Final = 0.2

_FAREWELL_S: Final = 2.0
_QUIET_S: Final = 10.0
_MOST_KEPT: Final = 64
_UNSEEN: Final = "runs side by side could not be shown"
_SHOWN_KINDS: Final = frozenset({"join", "capture"})
"""Of what happens to runs, what their common bar has a sign for."""

log = logging.getLogger(__name__)


class Viewer(Protocol):
    """One browser that looks."""

    def draw(self, hall: "Hall | None", now_s: float) -> None:
        """Do what was asked for, and send what is to be seen."""
        ...

    def say(self, text: str) -> None:
        """Say that something went wrong."""
        ...


class Hall:
    """The runs that stand side by side now, with what is found of them once for all who look."""

    def __init__(self, race: Race) -> None:
        self.race = race
        self.status: RaceStatus = race.status
        """Of this round."""
        self.greedy = GreedyRuns(len(self.status.entries))
        self.apart = Apart()
        self._successes = Successes()
        self.curves: dict[str, Any] = {}
        """As they are sent; another object when they are others."""
        self.happenings: tuple[tuple[int, Happening], ...] = ()
        """What happened to which run, by step."""
        self._curves_s = 0.0
        self._made: dict[Hashable, tuple[Snapshot, tuple[object, ...], msgspec.Raw]] = {}
        """Parts of boards, with what they are of."""

    @property
    def events(self) -> list[int]:
        """Steps at which something happened."""
        return [happening.step for _, happening in self.happenings]

    @property
    def events_sent(self) -> list[dict[str, Any]]:
        """The same, as the bar shows them."""
        return [
            {"step": one.step, "kind": one.kind, "text": one.text, "run": place}
            for place, one in self.happenings
        ]

    def look_again(self, now_s: float) -> None:
        """Take in how the runs stand now."""
        self.status = self.race.status
        snapshots = self.status.snapshots
        self.greedy.follow(snapshots)
        if now_s - self._curves_s >= _CURVES_S or not self.curves:
            self._curves_s = now_s
            curves = curves_sent(snapshots)
            if curves != self.curves:
                self.curves = curves
            self.happenings = tuple(self._happenings())

    def _happenings(self) -> list[tuple[int, Happening]]:
        found: list[tuple[int, Happening]] = []
        for place, snapshot in enumerate(self.status.snapshots):
            past = self.race.past(place)
            capture = first_capture_in(past.outcomes)
            happened = happenings_of(snapshot.control, snapshot.trial, past.step_of_trial, capture)
            found += [(place, one) for one in happened if one.kind in _SHOWN_KINDS]
        return sorted(found, key=lambda one: one[1].step)

    def extras(self, snapshot: Snapshot, look: Look, since: Snapshot | None) -> Extras:
        """What a layer shows besides a moment."""
        success = self._successes.of(snapshot) if look.layer == "success" else None
        return Extras(success=success, since=since)

    def ground(
        self, place: Hashable, snapshot: Snapshot, look: Look, since: Snapshot | None, rests: bool
    ) -> msgspec.Raw:
        """Colours and hunt of a board as JSON; the same object until they are others.

        Args:
            place: which of the boards it is.
            snapshot: the moment.
            look: how it is seen.
            since: the other run, of a map of what is different.
            rests: whether the runs stand still.
        """
        extras = self.extras(snapshot, look, since)
        return self._kept(
            ("ground", place, look, rests),
            snapshot,
            (extras.success, since),
            lambda: ground_sent(snapshot, look, extras, rests),
        )

    def over(
        self, place: Hashable, snapshot: Snapshot, look: Look, since: Snapshot | None
    ) -> msgspec.Raw:
        """Lines and words over a board as JSON, likewise."""
        extras = self.extras(snapshot, look, since)
        return self._kept(
            ("over", place, look),
            snapshot,
            (extras.success, since),
            lambda: over_sent(snapshot, look, extras),
        )

    def _kept(
        self,
        key: Hashable,
        snapshot: Snapshot,
        besides: tuple[object, ...],
        make: Callable[[], Mapping[str, Any]],
    ) -> msgspec.Raw:
        known = self._made.pop(key, None)
        if known is None or known[0] is not snapshot or not are_same(known[1], besides):
            known = (snapshot, besides, msgspec.Raw(msgspec.json.encode(make())))
        self._made[key] = known
        while len(self._made) > _MOST_KEPT:
            del self._made[next(iter(self._made))]
        return known[2]

    def stop(self) -> None:
        """Find nothing more."""
        self.greedy.stop()
        self.apart.stop()
        self._successes.stop()


def are_same(some: Sequence[object], others: Sequence[object]) -> bool:
    """Whether these are the very same objects, which may be long to compare."""
    return len(some) == len(others) and all(a is b for a, b in zip(some, others, strict=True))


class SideShow:
    """The thread. All methods may be called from any thread."""

    def __init__(self, session: Session) -> None:
        """Prepare; the thread begins with the first who looks."""
        self._session = session
        self._lock = threading.Lock()
        self._viewers: tuple[Viewer, ...] = ()
        self._awake = threading.Event()
        self._stopping = False
        self._thread: threading.Thread | None = None
        self._hall: Hall | None = None
        self._failed_s = -math.inf
        """When it was told last that something went wrong."""

    def enter(self, viewer: Viewer) -> None:
        """Show runs to one more."""
        with self._lock:
            if viewer not in self._viewers:
                self._viewers += (viewer,)
            if self._thread is None and not self._stopping:
                self._thread = threading.Thread(target=self._work, name="side", daemon=True)
                self._thread.start()
        self._awake.set()

    def leave(self, viewer: Viewer) -> None:
        """Show it nothing more; runs that nobody looks at stand still."""
        with self._lock:
            was_there = viewer in self._viewers
            self._viewers = tuple(one for one in self._viewers if one is not viewer)
            race = None if self._viewers or not was_there else self._session.race
        if race is not None:
            race.pause()

    def wake(self) -> None:
        """Draw at once, because something was asked for."""
        self._awake.set()

    def stop(self) -> None:
        """End the thread, and wait for it."""
        with self._lock:
            self._stopping = True
            thread = self._thread
        self._awake.set()
        if thread is not None:
            thread.join(timeout=_FAREWELL_S)

    def _work(self) -> None:
        while not self._stopping:
            self._awake.clear()
            started_s = time.perf_counter()
            if self._viewers:
                self._draw_for(self._viewers, started_s)
                took_s = time.perf_counter() - started_s
                self._awake.wait(max(_FRAME_S - took_s, (_LEAST_PAUSE - 1) * took_s))
            else:
                self._awake.wait()
        if self._hall is not None:
            self._hall.stop()

    def _draw_for(self, viewers: Sequence[Viewer], now_s: float) -> None:
        try:
            hall = self._hall_of_now(now_s)
        except Exception as error:
            # The runs go on, and the next round may find them as they should be.
            if self._is_news(now_s):
                log.exception(_UNSEEN)
                _tell(viewers, error)
            return
        for viewer in viewers:
            try:
                viewer.draw(hall, now_s)
            except Exception as error:
                # Whatever is wrong with one, the others are to see theirs.
                if self._is_news(now_s):
                    log.exception(_UNSEEN)
                    _tell((viewer,), error)

    def _hall_of_now(self, now_s: float) -> Hall | None:
        """The runs as they stand; None if there are none."""
        race = self._session.race
        if self._hall is not None and self._hall.race is not race:
            self._hall.stop()
            self._hall = None
        if race is not None and self._hall is None:
            self._hall = Hall(race)
        if self._hall is not None:
            self._hall.look_again(now_s)
        return self._hall

    def _is_news(self, now_s: float) -> bool:
        """Whether what went wrong is to be told: now and then, as it may last."""
        is_news = now_s - self._failed_s > _QUIET_S
        if is_news:
            self._failed_s = now_s
        return is_news


def _tell(viewers: Sequence[Viewer], error: Exception) -> None:
    """Say what went wrong to those who see nothing new for it."""
    for viewer in viewers:
        viewer.say(f"{_UNSEEN.capitalize()}: {type(error).__name__}: {error}")
