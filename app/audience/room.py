"""A class: its seats, what it is asked, and what each of its pages is sent of that."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from app.audience.pictures import Parts, part
from app.audience.poll import NOTHING_ASKED, Poll
from app.audience.seats import Seat, Seats
from app.audience.wishes import Answer
from app.player.classroom import Card, Question


class Room:
    """One class. Methods may be called from any thread."""

    def __init__(
        self,
        seats: Seats,
        here: Callable[[], Iterable[Seat]],
        changed: Callable[[], object],
        joined: Callable[[], Mapping[str, Any]],
    ) -> None:
        """Prepare.

        Args:
            seats: that there are.
            here: those of the pages that are open now.
            changed: called when there is something new for the class to see.
            joined: how to join, ``{"code", "address"}``, for who presents.
        """
        self.seats = seats
        self.poll = Poll(changed)
        self._here, self._joined = here, joined

    @property
    def n_seats(self) -> int:
        """How many seats have a page that is open."""
        return len(set(self._here()))

    # --- For who presents (``app.player.classroom``) ----------------------------------------------

    def ask(self, question: Question) -> None:
        """Ask something; what was answered before is forgotten."""
        self.poll.ask(question)

    def vote_again(self) -> None:
        """Ask the same once more. What was answered first is shown with the second."""
        self.poll.vote_again()

    def reveal(self) -> None:
        """Take no more answers, and show those that there are."""
        self.poll.reveal()

    def come_out(self, card: str, outcome: Mapping[str, Any]) -> None:
        """Show what the run did, with the answers to a card's question, if those are revealed."""
        self.poll.come_out(card, outcome)

    def end(self) -> None:
        """Forget everything: seats, question and answers."""
        self.seats.forget()
        self.poll.end()

    def state(self, card: str | None, askable: bool) -> dict[str, Any]:
        """How things stand, for a card that is shown."""
        return {**self._joined(), **self.poll.state(card, askable, set(self._here()))}

    def found(self, card: str) -> Mapping[str, Any]:
        """What the class answered to a card's question, once that is revealed."""
        return self.poll.found(card)

    # --- For its pages ----------------------------------------------------------------------------

    def answer(self, seat: Seat | None, answer: Answer) -> bool:
        """Take what a page answers; returns whether it counts. Without a seat it does not."""
        return seat is not None and self.poll.answer(seat, answer.ballot, answer.value)

    def lesson_part(self, card: Card | None) -> bytes:
        """What all of them read: the presenter's card, and what is asked."""
        return lesson_part(card, True, self.poll.sent())

    def parts_of(self, seat: Seat | None) -> Parts:
        """What only the pages of one seat are sent."""
        if seat is None:
            return {"seat": part("seat", {"seat": None, "answer": None})}
        who = {"number": seat.number, "shape": seat.shape}
        return {"seat": part("seat", {"seat": who, "answer": self.poll.answer_of(seat)})}


def lesson_part(
    card: Card | None, is_class: bool = False, asked: Mapping[str, Any] = NOTHING_ASKED
) -> bytes:
    """The presenter's card of a lesson, and what is asked."""
    told = None if card is None else card._asdict()
    return part("lesson", {"class": is_class, "card": told, **asked})
