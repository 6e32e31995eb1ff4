"""A lesson in a browser: what its frame is sent, and what comes of what a hand does there."""

from collections.abc import Iterator

import pytest
import viser

from app.live.requests import TrialOnce
from app.page.lesson import messages
from tests.support.lessons import PATIENCE_S, Room, Sitter, small_lesson, small_session
from tests.support.person import Person


@pytest.fixture
def room(gui: viser.GuiApi, person: Person) -> Iterator[Room]:
    session = small_session()
    session.start()
    session.submit(TrialOnce())
    session.wait_for(lambda status: status.snapshot.trial == 1, PATIENCE_S)
    room = Room(session, gui, small_lesson())
    yield room
    room.close()


@pytest.fixture
def sitter(room: Room) -> Sitter:
    return room.sitters[0]


def test_all_lessons_are_listed_before_one_is_on(sitter: Sitter) -> None:
    assert sitter.state["lesson"] is None
    listed = {lesson["name"]: lesson for lesson in sitter.state["list"]}
    assert listed["small"] == {
        "name": "small",
        "title": "A small one",
        "minutes": 4,
        "needs": [],
        "languages": ["en", "de"],
        "at": None,
        "n": 6,
    }


def test_a_lesson_begins_with_its_run_at_the_trial_of_its_setup(room: Room, sitter: Sitter) -> None:
    sitter.start()
    assert room.status.snapshot.trial == 200
    assert room.status.snapshot.seed == 3
    assert not room.status.playing
    assert room.status.aside is not None
    assert sitter.lesson["at"] == 0
    assert sitter.card["html"] == "The predator learns to <b>hunt</b>."
    assert sitter.view.look.layer == "value"
    assert [control["control"] for control in sitter.lesson["controls"]] == ["play", "speed"]


def test_going_on_learns_first_what_the_card_says(room: Room, sitter: Sitter) -> None:
    sitter.start()
    sitter.do(messages.Next())
    room.until(lambda: sitter.lesson["at"] == 1)
    assert room.status.snapshot.trial == 250
    assert sitter.card["kind"] == "ask"
    assert sitter.card["ask"]["options"] == [["no", "no"], ["yes", "yes"]]
    assert not sitter.lesson["next"]
    sitter.do(messages.Answer("guess", "yes"), messages.Commit("guess", 90))
    assert sitter.card["ask"]["locked"]
    assert (sitter.card["ask"]["answer"], sitter.card["ask"]["said"]) == ("yes", 90)
    sitter.do(messages.Answer("guess", "no"), messages.Commit("guess", 50))
    assert (sitter.card["ask"]["answer"], sitter.card["ask"]["said"]) == ("yes", 90)
    assert sitter.lesson["next"]
    sitter.do(messages.Next())
    assert sitter.card["kind"] == "do"
    names = [control["control"] for control in sitter.lesson["controls"]]
    assert names == [
        "play",
        "speed",
        "add_skill.circle_clockwise",
        "add_skill.avoid",
        "layer",
        "undo",
    ]
