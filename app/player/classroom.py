"""A class that answers what the presenter asks: the question, and what is done with it."""

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple, Protocol

from learners.spec import MAX_TRIALS

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


class Classroom(Protocol):
    """A class, for who presents. Methods may be called from any thread."""

    def ask(self, question: Question) -> None:
        """Ask something; what was answered before is forgotten."""
        ...

    def vote_again(self) -> None:
        """Ask the same once more. What was answered first is shown with the second."""
        ...

    def reveal(self, outcome: Mapping[str, Any] | None) -> None:
        """Take no more answers, and show those that there are, with what the run did.

        Args:
            outcome: ``{"html", "run", "twenty"}`` as a card's ``reveal`` has them
                (``app/web/lesson``); None if there is none. It may be given again when it is other.
        """
        ...

    def end(self) -> None:
        """Forget everything: seats, question and answers."""
        ...

    def state(self, card: str | None) -> dict[str, Any]:
        """How things stand, for a card that is shown (``vote`` in ``app/web/lesson``)."""
        ...

    def found(self, card: str) -> dict[str, Any] | None:
        """What the class answered to a card's question, once that is revealed; None if it is not,
        or too few have answered."""
        ...
