"""A question that one browser is asked on its time bar: at which moment, or how the curve will go.

As long as it is open the bar is for the answer alone: it stands still under it, and of a curve that
is to be drawn nothing is sent that would give it away. Once it is locked the bar is as it was, with
the guess on it, and with what came of it when that is known.
"""

from collections.abc import Callable
from typing import Any, Final, NamedTuple

from app.charts.bar.model import View
from app.documents.lesson_questions import HANDLES
from app.page.time.messages import Guess, Sketch

Points = tuple[tuple[int, float], ...]
"""Trials and rewards."""

_ROOM_BEFORE, _ROOM_AFTER = 0.3, 0.04
"""What is seen before and after the part that is drawn, as shares of its length."""


class MomentAsked(NamedTuple):
    """At which trial will it be?"""

    id: str
    """By which questions are told apart."""
    guess: int | None = None
    locked: bool = False
    """Whether the guess stands."""
    run: int | None = None
    """At which trial it was in this run; None as long as that is not to be seen, or if it never
    was."""
    twenty: tuple[int, ...] = ()
    """At which trials it was in others."""
    runs: int = 20
    """How many these are, with those in which it never was."""
    first: int = 0
    """No trial before this one can be guessed."""
    last: int | None = None
    """Nor one after this; None for the last of the bar."""
    language: str = "en"
    """In which it is asked."""

    @property
    def view(self) -> None:
        """All of the bar is seen."""

    @property
    def sent(self) -> dict[str, Any]:
        """As the frame takes it."""
        return {
            "kind": "moment",
            "id": self.id,
            "language": self.language,
            "from": self.first,
            "to": self.last,
            "guess": self.guess,
            "locked": self.locked,
            "run": self.run,
            "twenty": self.twenty,
            "runs": self.runs,
        }


class Band(NamedTuple):
    """Where the curves of other runs went."""

    at: tuple[int, ...]
    """Trials."""
    low: tuple[float, ...]
    high: tuple[float, ...]


class SketchAsked(NamedTuple):
    """How will reward go from one trial to another?"""

    id: str
    first: int
    last: int
    handles: Points | None = None
    """What was drawn, at the trials of :func:`handles_at`; None if nothing was."""
    locked: bool = False
    run: Points = ()
    """How it went in this run, once that is to be seen."""
    band: Band | None = None
    """How it went in others, once that is to be seen."""
    language: str = "en"
    """In which it is asked."""

    @property
    def view(self) -> View:
        """That part is seen, and nothing after its beginning as long as it can be drawn."""
        long = self.last - self.first
        first = max(self.first - round(_ROOM_BEFORE * long), 0)
        hides_after = None if self.locked else self.first
        return View(first, self.last + round(_ROOM_AFTER * long), hides_after)

    @property
    def sent(self) -> dict[str, Any]:
        """As the frame takes it."""
        return {
            "kind": "sketch",
            "id": self.id,
            "language": self.language,
            "from": self.first,
            "to": self.last,
            "at": handles_at(self.first, self.last),
            "handles": self.handles,
            "locked": self.locked,
            "run": self.run,
            "band": None if self.band is None else self.band._asdict(),
        }


Asked = MomentAsked | SketchAsked
Answered = Callable[[Guess | Sketch], object]
"""Called with what a hand made of the answer."""

_NOTHING: Final[dict[str, Any]] = {"ask": None}


def handles_at(first: int, last: int) -> tuple[int, ...]:
    """The trials at which a curve can be taken hold of."""
    return tuple(first + round(n * (last - first) / (HANDLES - 1)) for n in range(HANDLES))


class Asking:
    """What one browser is asked on its bar, and what its frame has been told of that."""

    def __init__(self) -> None:
        self.asked: Asked | None = None
        """None if nothing is."""
        self._answered: Answered = _nobody
        self._told = _NOTHING

    def ask(self, asked: Asked | None, answered: Answered | None) -> None:
        """Ask this from now on."""
        self.asked, self._answered = asked, answered or _nobody

    @property
    def view(self) -> View | None:
        """The part of a bar that is seen; None for all of it."""
        return None if self.asked is None else self.asked.view

    def news(self) -> dict[str, Any] | None:
        """What the frame is to be told; None if it knows."""
        now = _NOTHING if self.asked is None else {"ask": self.asked.sent}
        if now == self._told:
            return None
        self._told = now
        return now

    def forget(self) -> None:
        """The frame knows of nothing."""
        self._told = _NOTHING

    def take(self, answer: Guess | Sketch, last: int, rewards: tuple[float, float]) -> None:
        """Hand on an answer to what is asked; any other is dropped.

        Args:
            answer: what came from the network.
            last: the last trial of the bar.
            rewards: the least and the greatest reward that a trial can have.
        """
        asked = self.asked
        if asked is None or asked.locked:
            return
        if isinstance(asked, MomentAsked):
            last = last if asked.last is None else min(asked.last, last)
            if isinstance(answer, Guess) and asked.first <= answer.trial <= last:
                self._answered(answer)
        elif isinstance(answer, Sketch):
            trials = tuple(trial for trial, _ in answer.points)
            if trials == handles_at(asked.first, asked.last):
                low, high = rewards
                drawn = ((trial, min(max(reward, low), high)) for trial, reward in answer.points)
                self._answered(Sketch(tuple(drawn)))


def _nobody(_: Guess | Sketch) -> None:
    """Hears of what nobody waits for."""
