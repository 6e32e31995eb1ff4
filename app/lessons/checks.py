"""Whether what a card asks for has come true: *yes*, *not yet*, or *it can no longer*.

A check is looked at in moments of the run, in their order. What it comes to must not hang on how
often a page happens to draw, so these moments are fixed (:meth:`Judge.next_look`): of the first
100 trials from where the card was entered every start, up to 5,000 trials from there every start
of a 25th trial, then of a 100th, and each deadline. Whoever looks more often, as a page does where
the run stands still, may do so.

What is so at one moment:

- a measure holds where it is what it is held against; where there is nothing to measure yet, not;
- ``all``, ``any`` and ``not`` are of what holds at that moment;
- with ``by`` or ``for`` it is about what has happened, and what has happened stays so: ``by`` holds
  from when it was so in time, ``for`` from when it had been so for so many trials in a row.

A verdict is never taken back. *Yes* is said once, at the first moment at which the whole of it
holds. *Never* is said only if no later moment of this run can make it so, whatever is done there: a
deadline has passed, or what only grows is beyond what was asked for. Whether somebody goes back to
before that is another matter: then it is another run, and it is judged anew.
"""

from collections.abc import Iterable
from typing import Any, Final, Literal, NamedTuple

from app.documents.lesson_grammar import Check, Moment, Reading
from app.lessons.measures import MEASURES, Began, Found, View, is_settled, measured
from app.lessons.words import Words
from sim.world import CAPTURE

CLOSE_LOOKS: Final = 100
"""Trials from where a card was entered of which every start is looked at."""
LOOKS_EVERY: Final = 25
"""Trials from one look to the next after these, ..."""
FAR: Final = 5_000
"""... up to so many trials from where it was entered."""
FAR_LOOKS_EVERY: Final = 100
"""Trials from one look to the next from there on."""

State = Literal["yes", "not yet", "never"]


class Verdict(NamedTuple):
    """What a check has come to."""

    state: State
    trial: int | None = None
    """In which it came true, or in which it became impossible; None while it is neither."""
    until: int | None = None
    """Trial by whose start it has to come true; None if there is no such, or it is not known."""

    def in_words(self, words: Words) -> str:
        """In a sentence, which gives nothing away of what is asked for."""
        match self.state:
            case "yes":
                return words.say("check.yes", trial=self.trial)
            case "never":
                return words.say("check.never")
            case _ if self.until is not None:
                return words.say("check.until", until=self.until)
            case _:
                return words.say("check.not_yet")


class Judge:
    """One check, and what it has come to; looked at in the order of moments."""

    def __init__(self, check: Check, began: Began) -> None:
        """Begin to judge where a card was entered; nothing has been looked at yet."""
        self._node = _Node(check, began)
        self._began = began
        self.verdict = Verdict("not yet", None, self._node.last_deadline)

    @property
    def is_over(self) -> bool:
        """Whether nothing can change the verdict any more."""
        return self.verdict.state != "not yet"

    def look(self, view: View) -> Verdict:
        """Take in a moment, which is later than those before or the same; returns the verdict."""
        if not self.is_over:
            stand = self._node.look(view)
            if stand.holds:
                self.verdict = Verdict("yes", view.trial)
            elif stand.is_settled:
                self.verdict = Verdict("never", view.trial)
        return self.verdict

    def next_look(self, trial: int) -> int:
        """The trial after one whose start has to be looked at."""
        since = trial - self._began.trial
        every = LOOKS_EVERY if since < FAR else FAR_LOOKS_EVERY
        grid = trial + 1 if since < CLOSE_LOOKS else (trial // every + 1) * every
        deadlines = (deadline for deadline in self._node.deadlines if deadline > trial)
        return min([grid, *deadlines])


def judge(check: Check, views: Iterable[View], began: Began) -> Verdict:
    """The verdict on a check after some moments, in their order, from where a card was entered."""
    judging = Judge(check, began)
    for view in views:
        judging.look(view)
    return judging.verdict


# --- One check and what it is made of ------------------------------------------------------------


class _Stand(NamedTuple):
    """What is so at a moment."""

    holds: bool
    is_settled: bool
    """Whether that stays so at every later moment."""


_SO: Final = _Stand(holds=True, is_settled=True)
_NEVER: Final = _Stand(holds=False, is_settled=True)


class _Node:
    """A check or a part of one, with what it remembers of the moments so far."""

    def __init__(self, check: Check, began: Began) -> None:
        self._check = check
        parts = check.all_of or check.any_of or ((check.not_so,) if check.not_so else ())
        self._parts = [_Node(part, began) for part in parts]
        self._deadline = Deadline(check.by, began) if check.by else None
        self._for = check.holds_for or 0
        self._latches = bool(check.by or check.holds_for)
        self._held_since: int | None = None
        self._has_been = False

    @property
    def deadlines(self) -> list[int]:
        """Trials by whose start something of it has to be so."""
        own = self._deadline.trial if self._deadline else None
        found = [deadline for part in self._parts for deadline in part.deadlines]
        return found if own is None else [own, *found]

    @property
    def last_deadline(self) -> int | None:
        """The latest of these, where there are any."""
        return max(self.deadlines, default=None)

    def look(self, view: View) -> _Stand:
        now = self._now(view)
        if not self._latches:
            return now
        if self._has_been:
            return _SO
        in_time = self._deadline is None or self._deadline.is_ahead(view)
        self._has_been = in_time and self._is_held(now.holds, view.trial)
        if self._has_been:
            return _SO
        is_over = self._deadline is not None and self._deadline.is_due(view)
        is_hopeless = now == _NEVER or self._is_too_late(view.trial)
        return _Stand(holds=False, is_settled=is_over or is_hopeless)

    def _now(self, view: View) -> _Stand:
        """What is so, whatever was so before."""
        stands = [part.look(view) for part in self._parts]
        check = self._check
        if check.all_of:
            return _all(stands)
        if check.any_of:
            return _not(_all([_not(stand) for stand in stands]))
        if check.not_so:
            return _not(stands[0])
        reading = check.reading
        assert reading is not None
        return _compared(check, reading, view)

    def _is_held(self, holds: bool, trial: int) -> bool:
        """Whether it has been so for as many trials as it has to be."""
        if not holds:
            self._held_since = None
            return False
        if self._held_since is None:
            self._held_since = trial
        return trial - self._held_since >= self._for

    def _is_too_late(self, trial: int) -> bool:
        """Whether it cannot be so for as many trials any more by when it has to be."""
        if self._deadline is None or self._deadline.trial is None:
            return False
        since = trial if self._held_since is None else self._held_since
        return since + self._for > self._deadline.trial


class Deadline:
    """When something has to be so: by the start of a trial, or by so many catches."""

    def __init__(self, moment: Moment, began: Began) -> None:
        """A moment that a card names, which was entered somewhere."""
        self._captures = moment.captures
        self.trial = None if moment.captures is not None else moment.after(began.trial)
        """At whose start; None if it hangs on catches."""

    def is_ahead(self, view: View) -> bool:
        """Whether it has not passed: its own moment is in time."""
        if self.trial is not None:
            return (view.trial, view.trial_step) <= (self.trial, 0)
        return self._caught(view) <= (self._captures or 0)

    def is_due(self, view: View) -> bool:
        """Whether no later moment is in time."""
        if self.trial is not None:
            return view.trial >= self.trial
        return self._caught(view) > (self._captures or 0)

    def has_come(self, view: View) -> bool:
        """Whether its own moment is there or past."""
        if self.trial is not None:
            return view.trial >= self.trial
        return self._caught(view) >= (self._captures or 0)

    def _caught(self, view: View) -> int:
        return int((view.outcome[view.since :] == CAPTURE).sum())


def _all(stands: list[_Stand]) -> _Stand:
    if any(stand == _NEVER for stand in stands):
        return _NEVER
    return _Stand(all(s.holds for s in stands), all(s == _SO for s in stands))


def _not(stand: _Stand) -> _Stand:
    return _Stand(not stand.holds, stand.is_settled)


# --- A measure, held against something -----------------------------------------------------------


def _compared(check: Check, reading: Reading, view: View) -> _Stand:
    found = measured(reading, view)
    if not check.operators:
        return _Stand(found is True, is_settled(reading, view))
    stands = [_held_against(found, name, value) for name, value in check.operators.items()]
    if is_settled(reading, view):
        return _Stand(all(stand.holds for stand in stands), is_settled=True)
    if MEASURES[reading.name].grows:
        return _all(stands)
    return _Stand(all(stand.holds for stand in stands), is_settled=False)


def holds(found: Found, operators: dict[str, Any]) -> bool:
    """Whether what was found is what it is held against; nothing found is not."""
    return all(_held_against(found, name, value).holds for name, value in operators.items())


def _held_against(found: Found, operator: str, bound: Any) -> _Stand:
    """Whether it is so, and would stay so if what is measured could only grow."""
    if found is None or isinstance(found, dict):
        return _Stand(holds=False, is_settled=False)
    if operator == "is":
        is_beyond = isinstance(found, int | float) and not isinstance(bound, str) and found > bound
        return _Stand(found == bound, is_beyond)
    assert isinstance(found, int | float)
    match operator:
        case "above":
            return _Stand(found > bound, found > bound)
        case "below":
            return _Stand(found < bound, found >= bound)
        case _:
            low, high = bound
            return _Stand(low <= found <= high, found > high)
