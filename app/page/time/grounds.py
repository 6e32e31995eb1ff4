"""What is known of a session's lines by those who walk on them, found once for all of them."""

import math
from typing import Final, NamedTuple

from app.explain.happenings import Happening, first_capture_in, happenings_of
from app.live.places import Mark
from app.live.session import Session
from app.live.status import Status
from app.page.time.walk import Ground
from learners.commands import Event

PLAIN_PACE: Final = 20_000.0
"""Steps a second at which what is past plays where the live run is as fast as it can be."""


class _Happened(NamedTuple):
    """What happened in a line, and all that it depends on."""

    history: tuple[Event, ...]
    trial: int
    marks: tuple[Mark, ...]
    found: tuple[Happening, ...]

    def is_of(self, history: tuple[Event, ...], trial: int, marks: tuple[Mark, ...]) -> bool:
        # Histories can be long to compare, and are the same object until there is more.
        return self.history is history and (self.trial, self.marks) == (trial, marks)


class Grounds:
    """Of one session. The render loop alone has to do with it."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._happened: dict[int, _Happened] = {}
        """Of each line."""
        self._marks: tuple[Mark, ...] = ()

    def of(self, live: Status) -> Ground:
        """What is known when the live run stands so."""
        self._marks = live.marks
        there = {line.number for line in live.lines}
        for line in self._happened.keys() - there:
            del self._happened[line]
        pace = live.speed if math.isfinite(live.speed) else PLAIN_PACE
        return Ground(
            live.snapshot.generation, self._session.past_of, self.events_of, max(pace, 1.0)
        )

    def happened(self, line: int) -> tuple[Happening, ...]:
        """What happened in a line as far as it is known; it is the same object until it is another.

        Empty of a line that is not there.
        """
        past = self._session.past_of(line)
        if past is None:
            self._happened.pop(line, None)
            return ()
        history, trial = past.control.history, past.end_trial
        marks = tuple(mark for mark in self._marks if mark.place.line == line)
        known = self._happened.get(line)
        if known is not None and known.is_of(history, trial, marks):
            return known.found
        capture = first_capture_in(past.outcomes)
        found = happenings_of(past.control, trial, past.step_of_trial, capture, marks)
        if known is not None and known.found == found:
            found = known.found
        self._happened[line] = _Happened(history, trial, marks, found)
        return found

    def events_of(self, line: int) -> tuple[int, ...]:
        """Steps of what happened in a line as far as it is known, in order."""
        return tuple(happening.step for happening in self.happened(line))
