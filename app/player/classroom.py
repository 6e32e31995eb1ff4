"""A class that answers what the presenter asks: the question, and what is done with it."""

from collections.abc import Mapping
from typing import Any, Final, Literal, NamedTuple, Protocol

from learners.names import MAX_TRIALS

QuestionKind = Literal["choice", "number", "direction", "sectors", "moment"]


class Question(NamedTuple):
    """What a class is asked, as its pages take it."""

    id: str
    """Of the card that asks."""
    kind: QuestionKind
    html: str
    """What is asked."""
    options: tuple[tuple[str, str], ...] = ()
    """What there is to choose from, each as its value and HTML; octants for sectors."""
    low: float = 0
    """Of a number; of a moment, its first trial."""
    high: float = MAX_TRIALS
    unit: str | None = None
    language: str = "en"


class Card(NamedTuple):
    """What the presenter's card of a lesson says, for the class to read."""

    id: str
    title: str
    """Of the lesson."""
    at: int
    """Which card it is, from 0."""
    n: int
    """How many there are."""
    html: str
    language: str = "en"


NOTHING_FOUND: Final[Mapping[str, Any]] = {"class": None, "before": None, "few": False}
"""Of a question that nobody has answered, or whose answers are not revealed."""


class Classroom(Protocol):
    """A class, for who presents. Methods may be called from any thread."""

    @property
    def n_seats(self) -> int:
        """How many seats have a page that is open."""
        ...

    def ask(self, question: Question) -> None:
        """Ask something; what was answered before is forgotten."""
        ...

    def vote_again(self) -> None:
        """Ask the same once more, if it was asked but once. What was answered first is hidden
        until both are shown."""
        ...

    def reveal(self) -> None:
        """Take no more answers, and show those that there are."""
        ...

    def come_out(self, card: str, outcome: Mapping[str, Any]) -> None:
        """Show what the run did, with the answers to a card's question, if those are revealed.

        Args:
            card: its id.
            outcome: ``{"run", "twenty"}`` as a card's ``reveal`` has them (``app/web/lesson``). It
                may be told again.
        """
        ...

    def end(self) -> None:
        """Forget everything: seats, question and answers."""
        ...

    def state(self, card: str | None, askable: bool) -> dict[str, Any]:
        """How things stand, for a card that is shown (``vote`` in ``app/web/lesson``).

        Args:
            card: its id.
            askable: whether it asks what a class can answer.
        """
        ...

    def found(self, card: str) -> Mapping[str, Any]:
        """What the class answered to a card's question once that is revealed: ``{"class",
        "before", "few"}``, of the last vote and of the one before; None of what is not revealed,
        and where too few have answered."""
        ...
