"""A lesson is where it was left: after a reload, in another browser, and after a restart."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import viser

from app.documents import lessons
from app.lessons.words import IN_ENGLISH
from app.live.journal import Journal
from app.live.made_again import made_again
from app.live.past import Budget
from app.live.records import Began, Record
from app.live.replayed import replayed
from app.live.session import Session
from app.live.story import (
    Answered,
    Committed,
    LongText,
    Revealed,
    TookLesson,
    WentToCard,
)
from app.live.written import Written, read
from app.page.lesson import messages
from app.page.lesson.learn import Library, request_to_begin
from learners.kernel.state import digest
from tests.support.journals import HEADER
from tests.support.lessons import SMALL, Room, Sitter, small_lesson, small_session
from tests.support.person import Person


def told(sitter: Sitter) -> tuple[Any, ...]:
    """What has to be there again of a card."""
    lesson, card = sitter.lesson, sitter.card
    return (
        *(lesson[name] for name in ("at", "furthest", "show", "language", "next", "last")),
        *(card[name] for name in ("kind", "id", "html", "ask", "hints", "next_hint", "reveal")),
        [control["control"] for control in lesson["controls"]],
        None if card["check"] is None else card["check"]["verdict"],
    )


def answer(room: Room, sitter: Sitter) -> None:
    sitter.do(messages.Answer("guess", "yes"), messages.Commit("guess", 90))


def add(room: Room, sitter: Sitter) -> None:
    sitter.do(messages.Hint(), messages.Use("add_skill.avoid"))
    room.until(lambda: sitter.lesson["next"])


def see(room: Room, sitter: Sitter) -> None:
    sitter.do(messages.Answer("seen", "no"), messages.Commit("seen"))
    room.until(lambda: bool(sitter.card["reveal"] and sitter.card["reveal"]["ready"]))


def nothing(room: Room, sitter: Sitter) -> None:
    pass


DONE: tuple[Callable[[Room, Sitter], None], ...] = (nothing, answer, add, see, nothing, nothing)
"""What is done on each card of the small lesson."""


def go_to(card: int, room: Room, sitter: Sitter) -> None:
    sitter.start()
    for number, done in enumerate(DONE[: card + 1]):
        done(room, sitter)
        if number < card:
            sitter.do(messages.Next())
            room.until(lambda at=number + 1: sitter.lesson["at"] == at)
            room.until(lambda: sitter.card["busy"] is None)


@pytest.mark.parametrize("card", range(len(DONE)))
def test_a_card_is_there_again_after_a_reload_and_a_restart(
    gui: viser.GuiApi, person: Person, tmp_path: Path, card: int
) -> None:
    path = tmp_path / "one.pounce"
    session = small_session(journal=Journal(path, HEADER))
    session.start()
    room = Room(session, gui, small_lesson())
    sitter = room.sitters[0]
    go_to(card, room, sitter)
    before, tables = told(sitter), digest(session._tree.family.held.run.state)
    # The page is loaded anew, and another browser comes.
    sitter.frame.opened()
    sitter.frame.sent = {}
    room.sitters.append(Sitter(room, gui, 2))
    room.show()
    assert [told(one) for one in room.sitters] == [before, before]
    room.close()
    found = read(path)
    assert replayed(found.records).is_same
    remade = made_again(found, Budget(), lambda *_: "branch")
    assert remade.differ == ()
    session = small_session(made_again=remade.made, journal=Journal.going_on(found))
    session.start()
    # The lesson's file is not there any more.
    room = Room(session, gui)
    sitter = room.sitters[0]
    room.until(lambda: sitter.card["check"] is None or told(sitter) == before)
    room.until(lambda: not sitter.card["reveal"] or sitter.card["reveal"]["twenty"] is not None)
    room.until(lambda: told(sitter) == before)
    assert digest(session._tree.family.held.run.state) == tables
    room.close()


def test_one_goes_on_where_a_lesson_was_left(gui: viser.GuiApi, person: Person) -> None:
    session = small_session()
    session.start()
    room = Room(session, gui, small_lesson())
    sitter = room.sitters[0]
    go_to(1, room, sitter)
    before, step = told(sitter), room.status.snapshot.step
    sitter.do(messages.Leave())
    sitter.start("which_way_round")
    assert room.status.snapshot.spec.world.size == 120
    sitter.start()
    assert told(sitter) == before
    assert room.status.snapshot.step == step
    sitter.start(again=True)
    assert (sitter.lesson["at"], sitter.lesson["furthest"]) == (0, 0)
    assert room.status.snapshot.trial == 200
    room.close()


@pytest.fixture
def session() -> Iterator[Session]:
    session = small_session()
    session.start()
    yield session
    session.stop()


def test_what_has_become_of_a_lessons_file_is_said(tmp_path: Path, session: Session) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(SMALL, encoding="utf-8")
    lesson = lessons.load(str(path))
    request = request_to_begin(lesson, "", is_anew=False)
    session.submit(request)
    session.wait_for(lambda status: status.story is not None, 60)
    story = session.status.story
    assert story is not None
    assert Library().news_of(story, IN_ENGLISH) == ""
    path.write_text(SMALL.replace("A small one", "Another one"), encoding="utf-8")
    assert "has changed" in Library().news_of(story, IN_ENGLISH)
    changed = Library()
    changed.offer(lessons.load(str(path)))
    assert "has changed" in changed.news_of(story, IN_ENGLISH)
    path.unlink()
    gone = Library()
    assert "is not there any more" in gone.news_of(story, IN_ENGLISH)
    assert gone.of(story) is not None


def test_a_file_that_is_called_as_a_shipped_lesson_takes_nothing_from_it(tmp_path: Path) -> None:
    path = tmp_path / "the_cone.yaml"
    path.write_text(SMALL, encoding="utf-8")
    library, shipped = Library(), lessons.load("the_cone")
    assert library.offer(shipped) is shipped
    mine = library.offer(lessons.load(str(path)))
    offered = library.offered
    assert (mine.name, offered[mine.name].spec.title) == ("the_cone_own", mine.spec.title)
    assert offered["the_cone"].digest == shipped.digest
    assert len(offered) == len(lessons.shipped()) + 1


_ANSWERS = ("perhaps", '"perhaps"', "[" * 900, '{"a": [1]}', "1e999", '"yes"')


@pytest.mark.parametrize(
    "text", [SMALL, "title: [", "x" * 2_000, SMALL.replace("+100", "+1 captures")]
)
def test_a_session_that_somebody_wrote_breaks_nothing(
    gui: viser.GuiApi, person: Person, text: str
) -> None:
    lesson = small_lesson()
    run = lesson.run_spec
    took = TookLesson(0, "small", "/dev/zero", lesson.digest, LongText(text), "xx", 0, False, True)
    records: list[Record] = [Began(0, "timed", run, 5), took, WentToCard(0, 7, 2**40, 9, 900)]
    records += [WentToCard(card, 0, 0, 0, 0) for card in range(1, 8)]
    for value in _ANSWERS:
        records += [Answered(one, value) for one in ("guess", "seen", "add", "?")]
    records += [
        Committed("guess", 90),
        Committed("seen", None),
        Revealed("guess", LongText("["), True),
    ]
    for card in range(8):
        written = Written(Path("one.pounce"), HEADER, (*records, WentToCard(card)), False, 0, "")
        remade = made_again(written, Budget(), lambda *_: "branch")
        session = small_session(made_again=remade.made)
        session.start()
        room = Room(session, gui)
        for _ in range(3):
            room.settle()
        room.sitters[0].do(messages.Next(), messages.Rewind(), messages.Hint())
        room.close()
