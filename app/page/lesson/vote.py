"""What a class is told and asked of a lesson's card: pure, of what is known of the lesson."""

from collections.abc import Mapping
from typing import Any

from app.documents.lesson_questions import Asked
from app.lessons.markup import html_of
from app.page.lesson.desk import Sitting
from app.player.classroom import Card, Question


def key_of(sitting: Sitting, card: str) -> str:
    """The id of a card among those of all lessons."""
    return f"{sitting.story.name}/{card}"


def card_told(sitting: Sitting) -> Card:
    """What is read of the card that is shown."""
    language = sitting.story.language
    spec = sitting.lesson.spec.in_language(language)
    card = spec.steps[sitting.index]
    asked = spec.question_of(card)
    words = card.words or (asked.text if asked is not None else None) or ""
    return Card(
        id=key_of(sitting, card.id),
        title=spec.title,
        at=sitting.index,
        n=len(spec.steps),
        html=str(html_of(words)),
        language=language,
    )


def class_question(sitting: Sitting) -> Question | None:
    """What the card that is shown asks, if that can be answered on a phone; None if it cannot."""
    told = card_told(sitting)
    spec = sitting.lesson.spec.in_language(told.language)
    asked = spec.question_of(spec.steps[sitting.index])
    if asked is None or asked.ask in (None, "sketch", "order"):
        return None
    low, high = _bounds(asked, sitting.lesson.run_spec.trials)
    return Question(
        id=told.id,
        kind=asked.ask,
        html=told.html,
        options=tuple((value, str(html_of(words))) for value, words in asked.choices),
        low=low,
        high=high,
        unit=asked.unit,
        language=told.language,
    )


def outcome_of(reveal: Mapping[str, Any]) -> dict[str, Any]:
    """Of what a card reveals, what is for everybody: words are about the presenter's own guess."""
    return {name: reveal[name] for name in ("run", "twenty")}


def _bounds(asked: Asked, trials: int) -> tuple[float, float]:
    """Between which numbers, or which trials, an answer is."""
    if asked.ask == "moment":
        return asked.first or 0, asked.end or trials
    return asked.low or 0, asked.high or 0
