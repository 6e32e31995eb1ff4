"""What a class is asked, and what it answers: one answer a seat, and never whose it is.

A question is asked once, or twice (*Vote again*); each time is a ballot. As long as one is open the
newest answer of a seat counts; it is closed when the presenter goes on to another card. What was
answered is shown when the presenter reveals it, there or on a later card, of both ballots then, and
of neither if fewer than ``FEWEST`` have answered. All of it is in memory.
"""

import threading
from collections import Counter
from collections.abc import Callable, Collection, Mapping
from typing import Any, Final

from app.audience.seats import Seat
from app.audience.wishes import MOST_PICKED, Value
from app.player.classroom import NOTHING_FOUND, Question

FEWEST: Final = 5
"""Of fewer answers nothing is shown: one could tell whose they are."""

NOTHING_ASKED: Final[Mapping[str, Any]] = {"ask": None, "reveal": None}


class Ballot:
    """One time that something is asked."""

    def __init__(self, number: int) -> None:
        self.number = number
        """Answers say it, so that none is counted that came late."""
        self.answers: dict[Seat, Value] = {}


class Poll:
    """Of one class. Methods may be called from any thread."""

    def __init__(self, changed: Callable[[], object]) -> None:
        """``changed`` is called when there is something new for the whole class to see."""
        self._changed = changed
        self._lock = threading.Lock()
        self._n_ballots = 0
        self._question: Question | None = None
        self._ballots: list[Ballot] = []
        self._is_open = self._is_revealed = False
        self._outcome: Mapping[str, Any] | None = None
        self._card: str | None = None
        """That the presenter has before them."""
        self._revealed_on: str | None = None
        """The one on which the answers were revealed."""

    # --- What the presenter does ------------------------------------------------------------------

    def ask(self, question: Question) -> None:
        """Ask something; what was answered before is forgotten."""
        with self._lock:
            self._clear()
            self._question = question
            self._card = None if self._card is None else question.id
            self._open()
        self._changed()

    def vote_again(self) -> None:
        """Ask the same once more, if it was asked but once and nothing is revealed."""
        with self._lock:
            if len(self._ballots) != 1 or self._is_revealed:
                return
            self._open()
        self._changed()

    def reveal(self) -> None:
        """Take no more answers, and show those there are."""
        with self._lock:
            if self._question is None or self._is_revealed:
                return
            self._is_open, self._is_revealed, self._revealed_on = False, True, self._card
        self._changed()

    def come_out(self, card: str, outcome: Mapping[str, Any]) -> None:
        """Show what the run did, with the answers to the question of that card, if those are
        revealed."""
        with self._lock:
            is_its = self._question is not None and self._question.id == card
            if not is_its or not self._is_revealed or outcome == self._outcome:
                return
            self._outcome = outcome
        self._changed()

    def show(self, card: str | None) -> None:
        """Note which card the presenter has before them; None if they have none.

        Whoever has gone on may have seen what comes of it, so no more answers are taken then.
        """
        with self._lock:
            if card == self._card:
                return
            self._card = card
            if self._question is not None and card not in (None, self._question.id):
                self._is_open = False
        self._changed()

    def end(self) -> None:
        """Ask nothing any more, and forget what was answered."""
        with self._lock:
            self._clear()
        self._changed()

    def _open(self) -> None:
        self._n_ballots += 1
        self._ballots.append(Ballot(self._n_ballots))
        self._is_open = True

    def _clear(self) -> None:
        self._question, self._ballots, self._outcome = None, [], None
        self._is_open = self._is_revealed = False
        self._revealed_on = None

    # --- What a seat does -------------------------------------------------------------------------

    def answer(self, seat: Seat, ballot: int, value: Value) -> bool:
        """Count an answer in place of an earlier one; returns whether it was one.

        Args:
            seat: whose it is.
            ballot: which it is meant for.
            value: what is answered; no octants at all take back those of before.
        """
        with self._lock:
            question, is_open = self._question, self._is_open
            if not is_open or question is None or ballot != self._ballots[-1].number:
                return False
            found, answers = answer_to(question, value), self._ballots[-1].answers
            if not seat.is_taken:
                return False
            if found is not None:
                # Whose seat was given to somebody else counts no more: one answer a seat there is.
                for gone in [other for other in answers if not other.is_taken]:
                    del answers[gone]
                answers[seat] = found
            elif value != () or answers.pop(seat, None) is None:
                return False
        return True

    def answer_of(self, seat: Seat) -> Value | None:
        """What a seat has answered in this ballot."""
        with self._lock:
            return self._ballots[-1].answers.get(seat) if self._ballots else None

    # --- How it stands ----------------------------------------------------------------------------

    def state(self, card: str | None, askable: bool, present: Collection[Seat]) -> dict[str, Any]:
        """How it stands for who presents, who has a card before them.

        Args:
            card: its id.
            askable: whether it asks what a class can answer.
            present: seats that are here.
        """
        with self._lock:
            question, ballots = self._question, self._ballots
            is_mine = question is not None and card == question.id
            is_revealed_here = self._is_revealed and card in (self._revealed_on, None)
            is_on = question is not None and (is_mine or not self._is_revealed or is_revealed_here)
            answers = ballots[-1].answers if is_on else {}
            acts = {
                "ask": askable and not (is_mine and self._is_open),
                "again": is_mine and len(ballots) == 1 and not self._is_revealed,
                "reveal": is_on and not self._is_revealed,
                "end": question is not None or bool(present),
            }
            return {
                "seats": len({*present, *answers}),
                "answered": len(answers),
                "round": len(ballots) if is_on else 0,
                "asking": is_mine and self._is_open,
                "hidden": is_on and not self._is_revealed and len(ballots) > 1,
                **(self._shown() if is_on else NOTHING_FOUND),
                "can": [act for act, can in acts.items() if can],
            }

    def found(self, card: str) -> Mapping[str, Any]:
        """What was answered to a card's question, ``{"class", "before", "few"}``, once that is
        revealed."""
        with self._lock:
            is_its = self._question is not None and self._question.id == card
            return self._shown() if is_its else NOTHING_FOUND

    def sent(self) -> dict[str, Any]:
        """The question and what came of it, as the pages of a class take it: the same for all."""
        with self._lock:
            question = self._question
            if question is None or self._card not in (None, question.id, self._revealed_on):
                return dict(NOTHING_ASKED)
            reveal = None
            if self._is_revealed:
                came_out = self._outcome or {"run": None, "twenty": None}
                reveal = {**came_out, **self._shown()}
            return {
                "ask": {
                    **question._asdict(),
                    "ballot": self._ballots[-1].number,
                    "round": len(self._ballots),
                    "open": self._is_open,
                },
                "reveal": reveal,
            }

    def _shown(self) -> Mapping[str, Any]:
        """What the class answered, as far as that may be seen."""
        if not self._is_revealed or self._question is None:
            return NOTHING_FOUND
        *former, newest = [counts_of(self._question, one.answers) for one in self._ballots]
        return {"class": newest, "before": former[0] if former else None, "few": newest is None}


def answer_to(question: Question, value: Value) -> Value | None:
    """An answer as it is counted; None if it is none to that question."""
    values = [option for option, _ in question.options]
    match question.kind:
        case "choice" | "direction":
            return value if isinstance(value, str) and value in values else None
        case "sectors":
            if not isinstance(value, tuple) or not 0 < len(value) <= MOST_PICKED:
                return None
            return tuple(option for option in values if option in value) or None
        case "number" | "moment":
            if isinstance(value, str | tuple) or not question.low <= value <= question.high:
                return None
            return round(value) if question.kind == "moment" else value


def counts_of(question: Question, answers: Mapping[Seat, Value]) -> dict[str, Any] | None:
    """How often each was answered, or which numbers were; None of fewer than :data:`FEWEST`."""
    if len(answers) < FEWEST:
        return None
    if question.kind in ("number", "moment"):
        # In order of size, which says nothing of who answered what.
        return {"n": len(answers), "values": sorted(answers.values(), key=_as_number)}
    picked: Counter[str] = Counter()
    for answer in answers.values():
        picked.update([answer] if isinstance(answer, str) else _as_texts(answer))
    return {
        "n": len(answers),
        "counts": {option: picked[option] for option, _ in question.options},
    }


def _as_number(answer: Value) -> float:
    assert isinstance(answer, int | float)
    return answer


def _as_texts(answer: Value) -> tuple[str, ...]:
    assert isinstance(answer, tuple)
    return answer
