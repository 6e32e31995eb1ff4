"""What a lesson makes of where somebody is in it: which controls there are, what may be done.

Where somebody is stands in :mod:`app.live.story`, which a session keeps without knowing lessons.
All of this is pure.
"""

import json
from dataclasses import replace
from typing import Any, Final, NamedTuple

from app.documents.lesson_cards import CONTROLS, Card
from app.documents.lesson_questions import Asked
from app.documents.lesson_spec import LessonSpec
from app.lessons.kept import answer_from
from app.lessons.predictions import answer_of
from app.lessons.words import Words
from app.live.story import Given, Stories, Story

ALL: Final = "all"
"""The control that stands for all of them."""


def card_of(story: Story, spec: LessonSpec) -> Card:
    """The card that is shown; the last, if the lesson has no such card any more."""
    return spec.steps[index_of(story, spec)]


def index_of(story: Story, spec: LessonSpec) -> int:
    """Which card that is, from 0."""
    return min(story.card, len(spec.steps) - 1)


def began(story: Story) -> int:
    """The trial that ran when the card that is shown was entered."""
    found = story.began.get(story.card)
    return 0 if found is None else found.trial


def shown(story: Story, spec: LessonSpec) -> frozenset[str]:
    """The controls that there are: those shown from the beginning, and what cards up to the
    farthest have unlocked. What is unlocked stays when one goes back."""
    cards = spec.steps[: story.furthest + 1]
    names = {*spec.show, *(name for card in cards for name in card.unlock)}
    if any(card.kind == "free" for card in cards):
        names.add(ALL)
    return frozenset(names)


def has(names: frozenset[str], control: str) -> bool:
    """Whether a control is among those that there are."""
    return control in names or ALL in names


def layers_of(names: frozenset[str]) -> tuple[str, ...]:
    """Keys of the layers that there are, in the order of the list of controls."""
    keys = (name.removeprefix("layer.") for name in CONTROLS if name.startswith("layer."))
    return tuple(key for key in keys if has(names, f"layer.{key}"))


def sound(story: Story, spec: LessonSpec) -> Story:
    """The same without answers that are none to what the lesson asks: anybody may have written the
    session that it was kept in."""
    questions = {card.id: spec.question_of(card) for card in spec.steps}
    answers = {
        question: kept
        for question, given in story.answers.items()
        if (kept := _sound_answer(given, questions.get(question))) is not None
    }
    return story if answers == story.answers else replace(story, answers=answers)


def _sound_answer(given: Given, asked: Asked | None) -> Given | None:
    if asked is None:
        return None
    try:
        answer_of(asked, json.loads(given.value))
    except (ValueError, RecursionError):
        return None
    if given.shown is None:
        return given
    try:
        answer_from(json.loads(given.shown))
    except (ValueError, RecursionError):
        return replace(given, shown=None, is_within=None)
    return given


# --- Questions -----------------------------------------------------------------------------------


def question_of(card: Card) -> str | None:
    """The id under which a card's answer is kept; None where it asks nothing."""
    return card.id if card.question is not None or card.see is not None else None


def is_locked(story: Story, question: str | None) -> bool:
    """Whether the answer to a question stands."""
    given = None if question is None else story.answers.get(question)
    return given is not None and given.locked


class Guess(NamedTuple):
    """A card that asked what will come of something."""

    card: Card
    place: int
    """Which one that is, from 0."""


def revealed_on(place: int, story: Story, spec: LessonSpec) -> Guess | None:
    """Of which guess a card tells what came of it; None if of none, or not yet.

    On the card that asks what was seen, once that is answered, and from then on where it was
    guessed as well. Where no card asks that, on the card of the guess itself, and on those after it
    up to the next question.

    Args:
        place: of the card, from 0.
        story: where somebody is in the lesson.
        spec: the lesson.
    """
    card = spec.steps[place]
    if card.see is not None:
        seen = spec.index_of(card.see.same_as)
        return Guess(spec.steps[seen], seen) if is_locked(story, card.id) else None
    for at in range(place, -1, -1):
        guessed = spec.steps[at]
        if guessed.see is not None:
            return None
        if guessed.question is None:
            continue
        asks = [other.id for other in spec.steps if _sees(other, guessed)]
        is_told = all(is_locked(story, question) for question in (guessed.id, *asks))
        return Guess(guessed, at) if is_told and (at == place or not asks) else None
    return None


def guessed_before(place: int, spec: LessonSpec) -> Guess | None:
    """The last question before a card, or on it, of those that are not what was seen."""
    for at in range(place, -1, -1):
        if spec.steps[at].question is not None:
            return Guess(spec.steps[at], at)
    return None


def _sees(card: Card, guessed: Card) -> bool:
    return card.see is not None and card.see.same_as == guessed.id


def open_guesses(story: Story, spec: LessonSpec) -> tuple[Guess, ...]:
    """Guesses that stand, and of which it is not known yet what came of them."""
    return tuple(
        Guess(card, place)
        for place, card in enumerate(spec.steps)
        if card.question is not None
        and (given := story.answers.get(card.id)) is not None
        and given.locked
        and given.shown is None
    )


def value_of(given: Given | None) -> Any:
    """An answer as JSON has it; None if there is none."""
    return None if given is None else json.loads(given.value)


def run_value_of(given: Given | None) -> Any:
    """What the run answered, as JSON has it; None if that is not known yet."""
    return None if given is None or given.shown is None else json.loads(given.shown)


# --- Going on ------------------------------------------------------------------------------------


def may_go_on(story: Story, spec: LessonSpec) -> bool:
    """Whether all is done that the card which is shown asks for, and there is another."""
    index = index_of(story, spec)
    return index + 1 < len(spec.steps) and is_done(index, story, spec)


def is_done(index: int, story: Story, spec: LessonSpec) -> bool:
    """Whether all is done that a card asks for."""
    card = spec.steps[index]
    question = question_of(card)
    if question is not None:
        return is_locked(story, question)
    return card.kind != "do" or index in story.passed


# --- What people were sure of --------------------------------------------------------------------


class Sureness(NamedTuple):
    """How often those who said that they were so sure were right."""

    percent: int
    right: int
    n: int


def sureness(stories: Stories) -> tuple[Sureness, ...]:
    """Over all lessons of a session, for each confidence that was stated, the highest first."""
    told = [
        (given.confidence, given.is_within)
        for story in stories.kept
        for given in story.answers.values()
        if given.confidence is not None and given.is_within is not None
    ]
    return tuple(
        Sureness(
            percent,
            sum(bool(right) for said, right in told if said == percent),
            sum(said == percent for said, _ in told),
        )
        for percent in sorted({said for said, _ in told}, reverse=True)
    )


def sureness_in_words(stories: Stories, words: Words) -> str:
    """A sentence each for the end of a lesson; empty where nobody said how sure they were."""
    return " ".join(
        words.say("sure", percent=one.percent, k=one.right, n=one.n) for one in sureness(stories)
    )
