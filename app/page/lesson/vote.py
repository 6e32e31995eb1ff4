"""What the class of an audience reads of a lesson, and what it is asked, for one browser's card."""

from collections.abc import Mapping
from typing import Any, Final

from app.documents.lesson_questions import Asked
from app.lessons.markup import html_of
from app.lessons.story import asked_by, card_of, index_of
from app.live.story import Story
from app.page.lesson.desk import Sitting
from app.page.lesson.messages import AskClass, EndClass, OfClass, RevealClass, VoteAgain
from app.player.classroom import Card, Classroom, Question

KINDS: Final = ("choice", "direction", "number", "sectors", "moment")
"""Of the questions that a class can be asked: those that are answered on a phone at once."""


class Vote:
    """The class, as one browser's card has it. The render loop alone has to do with it."""

    def __init__(self, classroom: Classroom | None) -> None:
        """``classroom``: None if there is no class; then there is nothing to be asked."""
        self._classroom = classroom

    def state(self, sitting: Sitting) -> dict[str, Any] | None:
        """How it stands for the card that is shown (``vote`` in ``app/web/lesson/vote.js``)."""
        if self._classroom is None:
            return None
        state = self._classroom.state(key_of(sitting.story))
        if _question_of(sitting) is None:
            state["can"] = [act for act in state["can"] if act != "ask"]
        return state

    def found(self, sitting: Sitting) -> dict[str, Any]:
        """What the class answered to the card's question, ``{"class", "before"}``, if that is
        revealed."""
        if self._classroom is None:
            return {"class": None, "before": None}
        state = self._classroom.state(key_of(sitting.story))
        return {"class": state["class"], "before": state["before"]}

    def shares(self, sitting: Sitting) -> dict[str, float] | None:
        """How many of the class chose each octant, from 0 to 1, once that is revealed."""
        found = self.found(sitting)["class"]
        if found is None or "counts" not in found:
            return None
        return {octant: n / found["n"] for octant, n in found["counts"].items()}

    def take(self, act: OfClass, sitting: Sitting, reveal: Mapping[str, Any] | None) -> None:
        """Do what a hand did.

        Args:
            act: what that was.
            sitting: the lesson and where one is in it.
            reveal: what has come of the card's question (``reveal`` of a card's state).
        """
        classroom = self._classroom
        if classroom is None:
            return
        match act:
            case AskClass():
                question = _question_of(sitting)
                if question is not None:
                    classroom.ask(question)
            case VoteAgain():
                classroom.vote_again()
            case RevealClass():
                classroom.reveal(_outcome(reveal))
            case EndClass():
                classroom.end()

    def come_out(self, sitting: Sitting, reveal: Mapping[str, Any] | None) -> None:
        """Have the class see what has come of a question that is revealed to it already."""
        if self._classroom is None or reveal is None:
            return
        state = self._classroom.state(key_of(sitting.story))
        if state["round"] and not state["asking"]:
            self._classroom.reveal(_outcome(reveal))


def told_of(sitting: Sitting) -> Card:
    """What the class reads of the card that is shown."""
    story, spec = sitting.story, sitting.lesson.spec.in_language(sitting.story.language)
    card = card_of(story, spec)
    asked = asked_by(card, spec)
    words = card.words or (asked.text if asked is not None and asked.text else "")
    return Card(
        id=key_of(story),
        title=spec.title,
        at=index_of(story, spec),
        n=len(spec.steps),
        html=str(html_of(words)),
        language=story.language,
    )


def key_of(story: Story) -> str:
    """The card that is shown, among those of all lessons."""
    return f"{story.name}/{story.card}"


def _question_of(sitting: Sitting) -> Question | None:
    """What the card that is shown asks; None if it asks nothing that a class can answer."""
    story, spec = sitting.story, sitting.lesson.spec.in_language(sitting.story.language)
    card = card_of(story, spec)
    asked = asked_by(card, spec)
    if asked is None or asked.ask not in KINDS:
        return None
    low, high = _bounds(asked, sitting.lesson.run_spec.trials)
    return Question(
        id=key_of(story),
        kind=asked.ask,
        html=str(html_of(card.words or asked.text or "")),
        options=tuple((value, str(html_of(words))) for value, words in asked.choices),
        low=low,
        high=high,
        unit=asked.unit,
        language=story.language,
    )


def _bounds(asked: Asked, trials: int) -> tuple[float, float]:
    if asked.ask == "moment":
        return asked.first or 0, asked.end or trials
    return asked.low or 0, asked.high or 0


def _outcome(reveal: Mapping[str, Any] | None) -> dict[str, Any] | None:
    if reveal is None:
        return None
    return {name: reveal.get(name) for name in ("html", "run", "twenty")}
