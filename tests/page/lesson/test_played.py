"""Lessons that come with the lab are played to their ends, by what their cards are told and say.

In a browser some are played as well (``tests/browser/test_lessons_played.py``).
"""

import itertools
from collections.abc import Iterator
from typing import Any

import pytest
import viser

from app.documents import lessons
from app.lessons.kept import default_folder
from app.lessons.markup import html_of
from app.lessons.story import question_of
from app.live.requests import SetSpeed
from app.live.worker import FULL_SPEED
from app.page.lesson import messages
from tests.support.answering import found_for, right_answer, wrong_answer
from tests.support.lessons import Room, Sitter, small_session

NEED_A_PAGE = frozenset(("all_at_once", "no_evidence"))
"""Those that have runs race or an experiment run, which are parts of the page by themselves."""
CONFIDENCE = (50, 70, 90)


@pytest.fixture
def room(gui: viser.GuiApi) -> Iterator[Room]:
    """A lab that offers what comes with it, and finds what others have found of lessons."""
    gui.reset()
    session = small_session()
    session.start()
    room = Room(session, gui, folder=default_folder())
    yield room
    room.close()


def do_it(room: Room, sitter: Sitter) -> None:
    """Do what the card asks for with its control, or by the last hint where there is none."""
    while not pressable(sitter) and sitter.card["next_hint"] is not None:
        sitter.do(messages.Hint())
    while not sitter.lesson["next"]:
        for control in pressable(sitter):
            sitter.do(messages.Use(control))
        room.until(lambda: sitter.lesson["next"] or bool(pressable(sitter)))


def pressable(sitter: Sitter) -> list[str]:
    """Buttons that do what the card asks for."""
    controls = sitter.lesson["controls"]
    return [one["control"] for one in controls if one["main"] and one["on"]]


@pytest.mark.parametrize("name", sorted(lessons.shipped().keys() - NEED_A_PAGE))
def test_a_lesson_is_played_to_its_end_with_right_answers_and_wrong_ones(
    room: Room, name: str
) -> None:
    lesson = lessons.load(name)
    spec, found, turns = lesson.spec, found_for(lesson), itertools.count()
    sitter = room.sitters[0]
    sitter.start(name)
    room.submit(SetSpeed(FULL_SPEED))
    names, given = set(spec.show), dict[str, Any]()
    for place, card in enumerate(spec.steps):
        assert (sitter.lesson["at"], sitter.card["kind"]) == (place, card.kind)
        assert sitter.card["html"] == str(html_of(card.words))
        if card.kind == "free":
            break
        names |= set(card.unlock)
        assert set(sitter.lesson["show"]) <= names
        question, asked = question_of(card), spec.question_of(card)
        if question is not None and asked is not None:
            guessed = card.see.same_as if card.see is not None else card.id
            value = right_answer(asked, found.own.get(guessed))
            if next(turns) % 2:
                value = wrong_answer(asked, value)
            given[question] = value
            sure = CONFIDENCE[place % 3] if asked.confidence else None
            sitter.do(messages.Answer(question, value), messages.Commit(question, sure))
            assert sitter.card["ask"]["locked"]
            assert sitter.card["ask"]["answer"] == value
            if card.see is not None or card.transfer is not None:
                room.until(lambda: bool(sitter.card["reveal"] and sitter.card["reveal"]["ready"]))
                told = sitter.card["reveal"]
                assert told["guess"] is not None
                assert told["run"] is not None
                assert asked.key is not None or told["twenty"] is not None
        if card.do is not None:
            do_it(room, sitter)
        assert sitter.state["fault"] is None
        room.until(lambda: sitter.lesson["next"])
        sitter.do(messages.Next())
        room.until(lambda at=place + 1: sitter.lesson["at"] == at and sitter.card["busy"] is None)
    assert set(given) == {card.id for card in spec.steps if question_of(card) is not None}
    assert sitter.lesson["last"]
    sitter.do(messages.Leave())
    assert sitter.state["lesson"] is None
