"""Lessons that come with the lab are played to their ends, with right answers and wrong ones.

Each that needs no more than its card is without a browser (``tests/page/lesson/test_played.py``).
"""

import itertools
import re
from dataclasses import replace
from typing import Any

import pytest
from playwright.sync_api import expect

from app.documents import lessons
from app.lessons.markup import plain_of
from app.lessons.story import question_of
from app.live.requests import SetSpeed
from app.live.story import Stories
from app.live.worker import FULL_SPEED
from app.page.lesson import does
from tests.support.answering import found_for, right_answer, wrong_answer
from tests.support.live import LiveLab
from tests.support.pupil import STOPS, Pupil
from tests.support.screen import Shared

PLAYED = ("which_way_round", "worse_first", "all_at_once", "no_evidence")
"""Lessons that have, together, each kind of card, a skill to be added, a curve to be drawn, an
order to be made, runs side by side, a branch and an experiment."""
RELOADED = ("which_way_round", ("ask", "do", "transfer"))
"""A lesson, and kinds of its cards that are loaded anew: those on which something is done."""
SEEDS = 2
"""Of an experiment that a card has run: what it asks for is so with any seed."""
BLAME = re.compile(r"\b(wrong|incorrect|correct|mistakes?|fail\w*|score\w*)\b", re.IGNORECASE)
"""Words that nobody is to read who was only unlucky, or has guessed."""
ON_BAR = ("bar", "curve", "scrub", "plan", "marks")
"""Controls that have the time bar be there."""
LINES = """() => document.querySelector(".lesson main").innerText.split("\\n").sort()"""
"""What a card says."""
LABELS = {
    "play": r"Play|Pause",
    "step": r"One step",
    "trial": r"One trial",
    "speed": r"Speed",
    "headings": r"Headings",
    "add_skill": r"Add .+ now",
    "explore": r"(Explore|Stop exploring) .+",
    "freeze": r"Freeze (selection|skills)",
    "plan": r"Follow schedule",
    "undo": r"Take back the last change",
    "start_again": r"Start this run again",
    "side": r"Runs side by side",
    "watch": r"Watch a hunt",
    "experiments": r"Run the experiment .+",
    "layer.": r"Layer",
}
"""What is written on controls of a card."""


def expect_no_more_than(pupil: Pupil, names: set[str]) -> None:
    """Whatever the lesson does not show by now is gone."""
    for label in pupil.controls:
        known = [name for name, words in LABELS.items() if re.fullmatch(words, label)]
        assert len(known) == 1, label
        assert any(name.startswith(known[0]) for name in names), label
    page = pupil.page
    more = {"side": "Side by side", "experiments": "Show results"}
    on_page = {"Present", *(words for name, words in more.items() if name in names)}
    assert set(page.evaluate(STOPS)) <= on_page
    for part in page.locator("[data-dock-region], .rail, [data-slot-of=sentence]").all():
        expect(part).to_be_hidden()
    is_asked = page.locator("html[data-lesson-asks=moment], html[data-lesson-asks=sketch]").count()
    bar = page.locator("iframe.pounce-time")
    if names.intersection(ON_BAR) or is_asked:
        expect(bar).to_be_visible()
    else:
        expect(bar).to_be_hidden()


def expect_no_blame(pupil: Pupil) -> None:
    """Nobody is told that they have failed, and nothing has."""
    for part in (".reveal", ".check .verdict"):
        assert not BLAME.search(pupil.card.locator(part).inner_text())
    expect(pupil.card.locator(".lesson .fault")).to_be_empty()


def expect_same_after_reload(shared: Shared, pupil: Pupil, place: int) -> None:
    """A page that is loaded anew is at the same card, with the same answers."""
    lines = pupil.card_page.evaluate(LINES)
    stories = shared.live.session.status.stories
    pupil.page.reload()
    shared.screen.settle(shared.live)
    pupil.expect_card(place)
    # A control that has come later is the last of them until then.
    pupil.card_page.wait_for_function(f"lines => ({LINES})().join() === lines.join()", arg=lines)
    now = shared.live.session.status.stories
    assert now == _with_reveals_of(now, stories)


def _with_reveals_of(now: Stories, before: Stories) -> Stories:
    """As it was before, but for what the run has answered since then."""
    story, later = before.on, now.on
    assert story is not None
    assert later is not None
    answers = {
        question: replace(given, shown=found.shown, is_within=found.is_within)
        if given.shown is None and (found := later.answers.get(question)) is not None
        else given
        for question, given in story.answers.items()
    }
    return replace(before, kept=(*before.kept[:-1], replace(story, answers=answers)))


def answered(live: LiveLab, question: str) -> Any:
    """An answer that stands, and what the run answered."""
    story = live.session.status.story
    assert story is not None
    return story.answers[question]


@pytest.mark.parametrize("name", PLAYED)
def test_a_lesson_is_played_to_its_end_with_right_answers_and_wrong_ones(
    shared: Shared, pupil: Pupil, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(does, "_SEEDS", SEEDS)
    live, lesson = shared.live, lessons.load(name)
    spec, found = lesson.spec, found_for(lesson)
    names, turns = set(spec.show), itertools.count()
    given: dict[str, Any] = {}
    pupil.start(spec.title)
    live.ask(SetSpeed(FULL_SPEED))
    for place, card in enumerate(spec.steps):
        if place:
            pupil.go_on(place)
        assert pupil.kind == card.kind
        expect(pupil.card.locator(".text")).to_contain_text(plain_of(card.words)[:20])
        names |= set(card.unlock)
        if card.kind == "free":
            break
        expect_no_more_than(pupil, names)
        question, asked = question_of(card), spec.question_of(card)
        if question is not None and asked is not None:
            guessed = card.see.same_as if card.see is not None else card.id
            own = found.own.get(guessed)
            value = right_answer(asked, own)
            if next(turns) % 2:
                value = wrong_answer(asked, value)
            given[question] = value
            pupil.give(asked, value)
            pupil.commit(sure=place % 3)
            if card.see is not None or card.transfer is not None:
                said = pupil.expect_revealed().inner_text()
                assert "you expected" in said
                assert "this run" in said
                assert asked.key is not None or "20 runs" in said or "of 20" in said
        if card.do is not None and card.do.command == "race":
            pupil.race()
        elif card.do is not None:
            pupil.do_it()
        expect_no_blame(pupil)
        if name == RELOADED[0] and card.kind in RELOADED[1]:
            expect_same_after_reload(shared, pupil, place)
    expect(pupil.page.locator("html")).to_have_attribute("data-lesson", "open")
    expect(pupil.page.locator("#pounce-stage .play")).to_be_visible()
    assert set(given) == {card.id for card in spec.steps if question_of(card) is not None}
    expect(pupil.primary).to_have_text("Finish")
    pupil.primary.click()
    expect(pupil.card.get_by_role("heading", name="Lessons")).to_be_visible()
