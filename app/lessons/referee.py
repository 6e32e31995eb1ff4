"""Follows the line that a lesson is about, and looks at the moments that checks and questions name.

A page draws when it can, and at full speed that is every few thousand trials. What a check comes to
must not hang on that: here a run of its own, made of the line's past, passes every moment that is
to be looked at, in their order, as the lesson's own player does without a page. So a verdict on the
page is the verdict of ``pounce lesson check``, whatever the speed. The line itself is never
touched, and what has been looked at is not looked at again.
"""

import logging
import threading
from collections.abc import Callable, Collection, Hashable
from dataclasses import dataclass
from typing import Final, NamedTuple, Protocol

from app.documents.lesson_grammar import Check
from app.documents.lesson_questions import Asked
from app.lessons.checks import Judge, Verdict
from app.lessons.measures import NO_DEEDS, Began, Deeds, View, view_of_run
from app.lessons.reveals import Answer, Watch
from app.live.past import Past
from app.util.machine import be_modest
from learners.run import Run

log = logging.getLogger(__name__)

_FAREWELL_S: Final = 2.0
_LOOKS: Final = 200
"""Made before it is asked again what is wanted."""


class Line(NamedTuple):
    """What is followed: a line as far as it is known, and what was done beside it."""

    number: int
    past: Past
    deeds: Deeds = NO_DEEDS


class _Looker(Protocol):
    """What looks at moments in their order."""

    @property
    def is_over(self) -> bool: ...
    def next_look(self, trial: int) -> int | None: ...
    def look(self, view: View) -> object: ...


@dataclass
class _Followed:
    """One thing that is looked for, and how far its line has been looked at for it."""

    of: Check | Asked
    began: Began
    until: int | None
    line: Line
    looker: _Looker
    run: Run | None = None
    """Where it has been looked at up to."""
    seen: tuple[int, int] = (-1, -1)
    """Step and number of events at the last look."""
    deeds: Deeds | None = None
    """What had been done by then."""


class Referee:
    """A thread that follows. Public methods may be called from any thread."""

    def __init__(self, told: Callable[[], object] = lambda: None) -> None:
        """Prepare; the thread begins with the first wish.

        Args:
            told: called in that thread when a verdict or an answer is another one.
        """
        self._told = told
        self._changed = threading.Condition()
        self._followed: dict[Hashable, _Followed] = {}
        self._news = False
        self._stopping = False
        self._thread: threading.Thread | None = None
        self._idle = True

    def want(
        self,
        key: Hashable,
        of: Check | Asked,
        began: Began,
        line: Line,
        until: int | None = None,
    ) -> None:
        """Follow a line for a check or a question; called again whenever more of it may be known.

        Args:
            key: by which it is asked for afterwards.
            of: what is looked for. Where it, its beginning or the line is another than before, it
                is looked for anew.
            began: where the card was entered; the line is known so far.
            line: what is followed. Deeds are taken for others if they are another object.
            until: trial at which a question is answered that names no moment itself.
        """
        with self._changed:
            former = self._followed.get(key)
            is_same = (
                former is not None
                and former.of is of
                and (former.began, former.until) == (began, until)
                and former.line.past is line.past
            )
            if is_same and former is not None:
                former.line = line
            else:
                self._followed[key] = _Followed(of, began, until, line, _looker(of, began, until))
            self._news = True
            self._begin()
            self._changed.notify_all()

    def verdict(self, key: Hashable) -> Verdict | None:
        """What a check has come to by now; None if nobody wants to know."""
        with self._changed:
            followed = self._followed.get(key)
            looker = None if followed is None else followed.looker
            return looker.verdict if isinstance(looker, Judge) else None

    def answer(self, key: Hashable) -> tuple[bool, Answer]:
        """Whether a question has been answered by now, and what."""
        with self._changed:
            followed = self._followed.get(key)
            looker = None if followed is None else followed.looker
            if not isinstance(looker, Watch):
                return False, None
            return looker.is_over, looker.answer

    def keep(self, keys: Collection[Hashable]) -> None:
        """Look for nothing else any more: what is followed holds a run, and all of its line."""
        with self._changed:
            for key in self._followed.keys() - set(keys):
                del self._followed[key]

    def settle(self, timeout_s: float) -> bool:
        """Wait until all that is known has been looked at; returns whether it has been."""
        with self._changed:
            return self._changed.wait_for(lambda: self._idle and not self._news, timeout_s)

    def stop(self) -> None:
        """End the thread, and wait for that."""
        with self._changed:
            self._stopping = True
            self._followed.clear()
            self._changed.notify_all()
            thread = self._thread
        if thread is not None:
            thread.join(_FAREWELL_S)

    # The thread

    def _begin(self) -> None:
        if self._thread is None and not self._stopping:
            self._thread = threading.Thread(target=self._work, name="lesson", daemon=True)
            self._thread.start()

    def _work(self) -> None:
        be_modest()
        while True:
            with self._changed:
                self._idle = True
                self._changed.notify_all()
                self._changed.wait_for(lambda: self._news or self._stopping)
                if self._stopping:
                    return
                self._news, self._idle = False, False
                followed = dict(self._followed)
            for key, one in followed.items():
                self._follow(key, one)

    def _follow(self, key: Hashable, one: _Followed) -> None:
        """Look at all that is known of its line and has not been looked at."""
        if one.looker.is_over and self._still_is(one):
            return
        before = self.verdict(key), self.answer(key)
        try:
            while self._looks_on(key, one):
                pass
        except Exception:
            # It is found out by whoever looks on the page: nothing is said there of a check.
            log.exception("a lesson's check cannot be looked at")
            with self._changed:
                self._followed.pop(key, None)
        if (self.verdict(key), self.answer(key)) != before:
            self._told()

    def _looks_on(self, key: Hashable, one: _Followed) -> bool:
        """Look at some moments more; returns whether there may be others that are known."""
        line = one.line
        past = line.past
        if one.run is None:
            one.run = past.run_at(one.began.step, quietly=True)
            assert one.run is not None
            self._look(key, one, line)
        for _ in range(_LOOKS):
            run, looker = one.run, one.looker
            assert run is not None
            if looker.is_over or self._is_left(key, one):
                return False
            wanted = looker.next_look(run.trial)
            end = past.end_trial
            at_end = wanted is None or wanted > end
            step = past.end_step if at_end else past.step_of_trial(wanted or 0)
            # A copy, since a line that went another way leaves its run half way.
            if not past.take_on(run, step):
                self._anew(one)
                return True
            self._look(key, one, line)
            if at_end:
                return False
        return True

    def _still_is(self, one: _Followed) -> bool:
        """Whether what has been looked at is on the line, or that has gone another way since."""
        run = one.run
        if run is None or one.line.past.take_on(run, run.step):
            return True
        self._anew(one)
        return False

    def _anew(self, one: _Followed) -> None:
        """The line has gone another way: what was seen of the old one may never have been."""
        with self._changed:
            one.run, one.seen = None, (-1, -1)
            one.looker = _looker(one.of, one.began, one.until)

    def _look(self, key: Hashable, one: _Followed, line: Line) -> None:
        run = one.run
        assert run is not None
        seen = run.step, len(run.control.history)
        if seen == one.seen and line.deeds is one.deeds:
            return
        one.seen, one.deeds = seen, line.deeds
        view = view_of_run(run, line.deeds, one.began)
        with self._changed:
            one.looker.look(view)

    def _is_left(self, key: Hashable, one: _Followed) -> bool:
        with self._changed:
            return self._followed.get(key) is not one


def _looker(of: Check | Asked, began: Began, until: int | None) -> Judge | Watch:
    return Judge(of, began) if isinstance(of, Check) else Watch(of, began, until)
