"""The thread that makes moments of the past, for all who look at one.

It has its own copies of everything, so a run that goes on has no business with it. Of what a viewer
wishes only the newest counts, and viewers are served in turn. What else is to be done with moments,
such as branching off at one, is done here too, and what can wait is done while nobody wishes
anything.
"""

import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Hashable
from dataclasses import replace
from typing import Final, NamedTuple, TypeVar

from app.live import snapshot
from app.live.past import Past
from app.live.places import Place
from app.live.snapshot import Snapshot
from learners.commands import CommandError
from learners.kernel.state import NOT_REACHED
from learners.run import Run

Made = TypeVar("Made")

log = logging.getLogger(__name__)

LEARNING_STEPS: Final = 2_000
"""Steps before a moment whose changes *Learning now* shows: some twenty trials."""
MOST_WAITING: Final = 100
"""Things to be done that may wait, besides the viewers' wishes."""

_GIVEN_UP_AFTER_S: Final = 0.15
"""A moment that takes longer is given up once its viewer wishes another one."""
_IDLE_EVERY_S: Final = 0.25
"""What can wait is done a little so often even if there is always something to do."""
_FAREWELL_S: Final = 2.0


def moment_at(
    past: Past,
    place: Place,
    preset: str,
    is_wanted: Callable[[], bool] = lambda: True,
    curve_steps: int | None = None,
    quietly: bool = False,
) -> Snapshot | None:
    """What a line looked like at a moment; the same whenever it is made.

    Args:
        past: of the line.
        place: the moment; beyond what is known of the line, where that ends.
        preset: name of its preset.
        is_wanted: asked every few milliseconds; once it says no, that is the end of it.
        curve_steps: as :func:`app.live.snapshot.take` has it.
        quietly: keep no checkpoints for it (:meth:`Past.run_at`).

    Returns:
        The snapshot; None if it was not wanted any more.
    """
    while True:
        step = min(max(place.step, 0), past.end_step)
        run = past.run_at(step - LEARNING_STEPS, is_wanted, quietly)
        if run is None:
            return None
        before = snapshot.selection_q_of(run)
        if past.take_on(run, step):
            break
        # The line has gone another way in between, which does not happen often.
    made = snapshot.take(run, preset, place.line, curve_steps=curve_steps)
    lately = snapshot.change_between(before, made.selection_q)
    return replace(made, learning_now=lately)


class _Job(NamedTuple):
    do: Callable[[], object]
    failed: Callable[[str], object]


class _Found(NamedTuple):
    place: Place
    """As it was wished."""
    snapshot: Snapshot


class Moments:
    """Makes moments in a thread of its own. All methods may be called from any thread."""

    def __init__(
        self, past_of: Callable[[int], Past | None], preset_of: Callable[[int], str]
    ) -> None:
        """Prepare; the thread begins with the first wish.

        Args:
            past_of: the past of a line by its number; None if that is not here any more.
            preset_of: name of a line's preset, as shown.
        """
        self._past_of = past_of
        self._preset_of = preset_of
        self._changed = threading.Condition()
        self._thread: threading.Thread | None = None
        self._stopping = False
        self._wishes: dict[Hashable, Place] = {}
        """The newest of each viewer; who waits longest comes first."""
        self._found: dict[Hashable, _Found] = {}
        self._faults: dict[Hashable, str] = {}
        self._viewers: set[Hashable] = set()
        self._asked: deque[_Job] = deque()
        self._idle: deque[_Job] = deque()
        self._idled_s = time.perf_counter()
        self._asked_last = False
        self._making: Hashable = None
        """Whose wish is being made; None if nobody's is."""
        self._on_found: Callable[[], object] = lambda: None

    # What viewers wish

    def want(self, viewer: Hashable, place: Place) -> None:
        """Have a moment made for a viewer, who wishes none of the earlier ones any more."""
        found = self._found.get(viewer)
        is_there = found is not None and found.place == place and self._is_still(found)
        with self._changed:
            # What is being made for the viewer would take its place.
            if is_there and self._making != viewer:
                self._wishes.pop(viewer, None)
                return
            self._viewers.add(viewer)
            self._wishes[viewer] = place
            self._wake()

    def found(self, viewer: Hashable) -> Snapshot | None:
        """The newest moment that was made for a viewer; None before the first."""
        found = self._found.get(viewer)
        return None if found is None else found.snapshot

    def fault(self, viewer: Hashable) -> str | None:
        """Why the last moment that a viewer wished could not be made; None if it was."""
        return self._faults.get(viewer)

    def forget(self, viewer: Hashable) -> None:
        """Make nothing any more for a viewer, who is gone or looks at what is live."""
        with self._changed:
            self._viewers.discard(viewer)
            for kept in (self._wishes, self._found, self._faults):
                kept.pop(viewer, None)

    def call_when_found(self, callback: Callable[[], object]) -> None:
        """Have this called, in the thread, when a moment was made or could not be."""
        self._on_found = callback

    # What else is done in this thread

    def ask(
        self,
        do: Callable[[], Made],
        then: Callable[[Made], object],
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

    def rise_of(self, line: int, state: int, trial: int) -> Place | None:
        """The moment at which the value of a state first rose above 0: the step that made it so.

        Takes some milliseconds, so it is to be called by something that is done in the thread.

        Args:
            line: number of the line.
            state: its index in the flat ``(heading, distance, direction)`` table.
            trial: in which it rose, as ``first_reach`` has it.

        Returns:
            The moment; None if the value did not rise in that trial, or the line is not here.
        """
        past = self._past_of(line)
        if past is None or not 0 <= trial <= past.end_trial:
            return None
        before, after = past.step_of_trial(trial), past.step_of_trial(trial + 1)
        run = past.run_at(before)
        if run is None or not 0 <= state < run.state.first_reach.size:
            return None
        if _has_risen(run, state):
            return Place(line, before) if run.state.first_reach[state] == trial else None
        ahead = run.copy()
        if not past.take_on(ahead, after) or not _has_risen(ahead, state):
            return None
        # It has not risen before the first of the two, and has risen after the second.
        while after - before > 1:
            middle = (before + after) // 2
            ahead = run.copy()
            if not past.take_on(ahead, middle):
                return None
            if _has_risen(ahead, state):
                after = middle
            else:
                before, run = middle, ahead
        return Place(line, after)

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
            self._thread = threading.Thread(target=self._work, name="moments", daemon=True)
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
        viewer, place = next(iter(self._wishes.items()))
        del self._wishes[viewer]
        self._making = viewer
        return lambda: self._make(viewer, place)

    def _do(self, job: _Job) -> object:
        """Do something; returns what came of it, None if it failed, which is told."""
        try:
            return job.do()
        except CommandError as error:
            reason = str(error)
        except Exception as error:
            # Whatever went wrong with one thing, all others are still to be done.
            log.exception("something could not be done in the past")
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

    def _make(self, viewer: Hashable, place: Place) -> None:
        started_s = time.perf_counter()

        def is_wanted() -> bool:
            if self._stopping or viewer not in self._viewers:
                return False
            is_late = time.perf_counter() - started_s >= _GIVEN_UP_AFTER_S
            return not (is_late and viewer in self._wishes)

        made, fault = None, None
        try:
            past = self._past_of(place.line)
            if past is None:
                fault = "that line is not here any more"
            else:
                made = moment_at(past, place, self._preset_of(place.line), is_wanted)
        except Exception as error:
            # The page must say so, and the next wish is made all the same.
            log.exception("a moment could not be made")
            fault = _reason_of(error)
        with self._changed:
            self._making = None
            if viewer not in self._viewers or (made is None and fault is None):
                return
            if made is not None:
                self._found[viewer] = _Found(place, made)
            self._faults.pop(viewer, None)
            if fault is not None:
                self._faults[viewer] = fault
        try:
            self._on_found()
        except Exception:
            log.exception("a moment could not be told of")

    def _is_still(self, found: _Found) -> bool:
        """Whether a moment that was made would be the same if it were made now."""
        past, made = self._past_of(found.place.line), found.snapshot
        return (
            past is not None
            and made.step == found.place.step
            and past.is_still(made.step, made.control)
        )


def _has_risen(run: Run, state: int) -> bool:
    return int(run.state.first_reach[state]) != NOT_REACHED


def _reason_of(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"
