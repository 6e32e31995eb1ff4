"""A card of a lesson as its frame is told it: pure, of what is known of the lesson and its run."""

import json
from collections.abc import Mapping
from typing import Any, NamedTuple

from app.documents.lesson_cards import Card
from app.documents.lesson_grammar import Moment
from app.documents.lesson_questions import Asked
from app.documents.lesson_spec import LessonSpec
from app.lessons.checks import Verdict
from app.lessons.kept import answer_from
from app.lessons.markup import html_of
from app.lessons.predictions import answer_of, scored
from app.lessons.spread import Spread
from app.lessons.story import Guess, question_of, value_of
from app.lessons.words import Words
from app.live.story import Given, Story
from app.page.lesson.told import sent_spread
from app.util.html import escaped


class Shown(NamedTuple):
    """What came of a guess, as far as it is known."""

    guess: Guess
    asked: Asked
    """The question, in the language that is read."""
    given: Given
    """The answer that was given, and what the run answered."""
    spread: Spread
    """What twenty runs answer, as far as they are there."""
    has_come: bool
    """Whether the run has come to where it answers."""

    @property
    def is_ready(self) -> bool:
        """Whether it can be told."""
        return self.given.shown is not None

    @property
    def own(self) -> Any:
        """What the run answered, as JSON has it; None if that is nothing, or not known yet."""
        return None if self.given.shown is None else json.loads(self.given.shown)


def asked_sent(
    card: Card, spec: LessonSpec, story: Story, draft: str | None
) -> dict[str, Any] | None:
    """What a card asks, and what has been answered; None if it asks nothing.

    Args:
        card: the card, in the language that is read.
        spec: the lesson, likewise.
        story: where somebody is in it.
        draft: an answer that is being given, as JSON.
    """
    question, asked = question_of(card), spec.question_of(card)
    if question is None or asked is None:
        return None
    given = story.answers.get(question)
    value = value_of(given) if draft is None else json.loads(draft)
    return _question_sent(asked, given, value) | {
        "confidence": asked.confidence and card.see is None
    }


def _question_sent(asked: Asked, given: Given | None, value: Any) -> dict[str, Any]:
    """A question, and an answer to it."""
    return {
        "kind": asked.ask,
        "options": [[value, str(html_of(words))] for value, words in asked.choices],
        "low": asked.low,
        "high": asked.high,
        "unit": asked.unit,
        "from": asked.first,
        "to": asked.end,
        "confidence": asked.confidence,
        "answer": value,
        "said": None if given is None else given.confidence,
        "locked": given is not None and given.locked,
    }


def reveal_sent(shown: Shown, of_class: Mapping[str, Any], words: Words) -> dict[str, Any]:
    """What is told of a guess, and of what a class answered, ``{"class", "before"}``."""
    answered = {"class": of_class["class"], "before": of_class["before"]}
    guess = value_of(shown.given)
    asked = _question_sent(shown.asked, shown.given, guess)
    if not shown.is_ready:
        return {
            "ready": False,
            "asked": asked,
            "html": _waiting_in_words(shown, words),
            "guess": guess,
            "run": None,
            "twenty": None,
            **answered,
        }
    answer = answer_of(shown.asked, guess)
    said = [scored(shown.asked, answer, answer_from(shown.own), shown.spread, words).words]
    if shown.guess.card.transfer is not None:
        said.append(words.say("reveal.other_run"))
    return {
        "ready": True,
        "asked": asked,
        "html": str(escaped(" ".join(said))),
        "guess": guess,
        "run": shown.own,
        "twenty": sent_spread(shown.asked, shown.spread),
        **answered,
    }


def class_sent(of_class: Mapping[str, Any]) -> dict[str, Any] | None:
    """What a class answered, where nothing else is told yet; None if that is not revealed."""
    if of_class["class"] is None:
        return None
    return {
        "ready": True,
        "html": "",
        "guess": None,
        "run": None,
        "twenty": None,
        "class": of_class["class"],
        "before": of_class["before"],
    }


def _waiting_in_words(shown: Shown, words: Words) -> str:
    """What is waited for until it is told what came of a guess."""
    if not shown.has_come:
        return words.say("reveal.ahead")
    return words.say("reveal.twenty", n=shown.spread.n)


def check_sent(
    card: Card, is_passed: bool, verdict: Verdict | None, words: Words
) -> dict[str, Any] | None:
    """What has become of what a card asks to be done; None if it asks for nothing."""
    if card.check is None:
        return None
    if is_passed:
        return {"verdict": "yes", "html": words.say("check.done")}
    if verdict is None:
        return {"verdict": "not yet", "html": words.say("check.not_yet")}
    return {"verdict": verdict.state, "html": str(escaped(verdict.in_words(words)))}


def learning_in_words(until: Moment, trial: int, words: Words) -> str:
    """That the learner learns on before the next card."""
    if until.captures is not None:
        return words.counted("busy.catches", until.captures)
    return words.say("busy.learns", until=until.trials, trial=trial)
