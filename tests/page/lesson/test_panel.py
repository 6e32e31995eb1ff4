"""A lesson in a browser: what its frame is sent, and what comes of what a hand does there."""

from collections.abc import Callable, Iterator

import pytest
import viser

from app.live.requests import GoBack, Request, RunTo, TrialOnce
from app.page.lesson import messages
from app.page.lesson.controls import Control
from app.page.lesson.learn import request_to_begin
from app.page.time.messages import Sketch
from learners.commands import Introduce
from tests.support.lessons import PATIENCE_S, SMALL, Room, Sitter, small_lesson, small_session
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
        "titles": {"en": "A small one", "de": "Eine kleine"},
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
    # What the run comes to is asked for before it goes on.
    assert sitter.lesson["controls"] == []
    assert "Space" not in sitter.lesson["keys"]


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
    # Not yet to play, nor to add another skill than is asked for.
    assert names == ["speed", "add_skill.avoid", "layer", "undo"]


def at_question(room: Room, sitter: Sitter) -> None:
    sitter.start()
    sitter.do(messages.Next())
    room.until(lambda: sitter.lesson["at"] == 1)


def test_an_answer_stays_on_the_card_until_the_session_has_it(
    room: Room, sitter: Sitter, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.page.lesson.sitter._SETTLED_S", 0.0)
    at_question(room, sitter)
    waiting: list[Request] = []

    def keep_waiting(request: Request, *_: object) -> int:
        waiting.append(request)
        return room.status.answered + 1

    submit = room.session.submit
    with monkeypatch.context() as patch:
        patch.setattr(room.session, "submit", keep_waiting)
        sitter.panel.take(messages.Answer("guess", "yes"))
        for _ in range(3):
            room.show()
            assert sitter.card["ask"]["answer"] == "yes"
    assert len(waiting) == 1
    room.ticket = submit(waiting[0])
    room.settle()
    assert sitter.card["ask"]["answer"] == "yes"
    # Committed later, from whichever browser, it is that.
    sitter.do(messages.Commit("guess", 90))
    assert sitter.card["ask"]["locked"]


def test_a_commit_without_an_answer_is_said_to_be_none(room: Room, sitter: Sitter) -> None:
    at_question(room, sitter)
    sitter.do(messages.Commit("guess", 90))
    assert not sitter.card["ask"]["locked"]
    assert "has not come" in sitter.state["fault"]


def at_deed(room: Room, sitter: Sitter) -> None:
    at_question(room, sitter)
    sitter.do(messages.Answer("guess", "yes"), messages.Commit("guess", 90), messages.Next())
    assert sitter.card["id"] == "add"


def test_what_is_asked_for_is_done_by_a_control_and_the_card_is_passed(
    room: Room, sitter: Sitter
) -> None:
    at_deed(room, sitter)
    assert sitter.card["check"]["verdict"] == "not yet"
    assert not sitter.lesson["next"]
    sitter.do(messages.Use("add_skill.avoid"))
    room.until(lambda: sitter.card["check"]["verdict"] == "yes")
    assert "avoid" in room.status.snapshot.present
    room.until(lambda: sitter.lesson["next"])


def test_a_control_that_is_not_shown_does_nothing(room: Room, sitter: Sitter) -> None:
    sitter.start()
    before = room.status.snapshot
    for control in ("add_skill.avoid", "step", "trial", "freeze.selection", "start_again", "x"):
        sitter.do(messages.Use(control), messages.Use(control, True))
    after = room.status.snapshot
    assert (after.step, after.control.history) == (before.step, before.control.history)


def test_hints_come_one_by_one_and_the_last_does_it(room: Room, sitter: Sitter) -> None:
    at_deed(room, sitter)
    assert (sitter.card["hints"], sitter.card["next_hint"]) == ([], "says")
    sitter.do(messages.Hint())
    assert sitter.card["hints"] == ["Look below the card."]
    sitter.do(messages.Hint())
    assert (len(sitter.card["hints"]), sitter.card["next_hint"]) == (2, "does")
    assert "avoid" not in room.status.snapshot.present
    sitter.do(messages.Hint())
    room.until(lambda: sitter.card["check"]["verdict"] == "yes")
    assert sitter.card["next_hint"] is None
    assert "avoid" in room.status.snapshot.present


def test_what_was_seen_is_asked_before_it_is_told_what_came_of_the_guess(
    room: Room, sitter: Sitter
) -> None:
    at_deed(room, sitter)
    sitter.do(messages.Use("add_skill.avoid"))
    room.until(lambda: sitter.lesson["next"])
    sitter.do(messages.Next())
    room.until(lambda: sitter.lesson["at"] == 3)
    # It has learned up to where it can be seen: 100 trials from the question on.
    assert room.status.snapshot.trial == 350
    assert sitter.card["ask"]["options"] == [["no", "no"], ["yes", "yes"]]
    assert sitter.card["reveal"] is None
    assert not sitter.card["ask"]["confidence"]
    sitter.do(messages.Answer("seen", "yes"), messages.Commit("seen", 90))
    room.until(lambda: bool(sitter.card["reveal"] and sitter.card["reveal"]["ready"]))
    reveal = sitter.card["reveal"]
    assert (reveal["guess"], reveal["run"]) == ("yes", "yes")
    assert reveal["twenty"]["n"] == 20
    assert sum(reveal["twenty"]["counts"].values()) == 20
    story = room.status.story
    assert story is not None
    assert story.answers["guess"].is_within is True
    assert story.answers["seen"].confidence is None


def test_why_looks_into_a_place_and_the_last_card_opens_all(room: Room, sitter: Sitter) -> None:
    at_deed(room, sitter)
    sitter.do(messages.Use("add_skill.avoid"))
    room.until(lambda: sitter.lesson["next"])
    sitter.do(messages.Next())
    room.until(lambda: sitter.lesson["at"] == 3)
    sitter.do(messages.Answer("seen", "yes"), messages.Commit("seen"), messages.Next())
    room.until(lambda: sitter.lesson["at"] == 4)
    assert sitter.card["kind"] == "why"
    assert sitter.cell is not None
    assert "<ol" in sitter.lesson["inspect"]
    sitter.do(messages.Next())
    assert sitter.lesson["inspect"] is None
    assert sitter.cell is None
    assert sitter.lesson["last"]
    assert not sitter.lesson["next"]
    assert "all" in sitter.lesson["show"]
    room.until(lambda: sitter.lesson["said"] != "")
    assert sitter.lesson["said"] == "When you said 90\u00a0%, you were right in 1 of 1."


def test_what_can_no_longer_come_true_can_be_done_at_the_moment_before(
    room: Room, sitter: Sitter
) -> None:
    at_deed(room, sitter)
    story = room.status.story
    assert story is not None
    began = story.began[2]
    room.submit(RunTo(460))
    room.until(lambda: sitter.card["check"]["verdict"] == "never")
    # A run in which what was asked for was not done is no answer to the guess before it.
    spoilt = room.status.story
    assert spoilt is not None
    assert spoilt.answers["guess"].shown is None
    sitter.do(messages.Rewind())
    room.until(lambda: sitter.outlook.place == began.place)
    assert sitter.card["busy"] is not None
    sitter.do(messages.Use("add_skill.avoid"))
    room.until(lambda: sitter.card["check"]["verdict"] == "yes")
    status = room.status
    assert (status.snapshot.trial, sitter.outlook.place) == (began.trial, None)
    assert len(status.lines) == 2
    assert sitter.card["busy"] is None
    room.until(lambda: sitter.lesson["next"])


def test_a_refused_command_is_told_in_the_card(room: Room, sitter: Sitter) -> None:
    at_deed(room, sitter)
    control = messages.Use("add_skill.avoid")
    sitter.do(control)
    room.until(lambda: sitter.card["check"]["verdict"] == "yes")
    # The button is not there any more, but a page may still have had it.
    sitter.panel._sitter.controls = (Control("a", "a", "button", {None: Introduce("avoid", 3)}),)
    sitter.panel.take(messages.Use("a"))
    room.settle()
    assert sitter.state["fault"] == "Avoid has joined already"


INTRODUCES = """  - do: {command: introduce, skill: avoid}
    id: add
    text: "Let it learn to avoid."
    unlock: [add_skill, layer.reach, undo]
    check: {present: avoid, by: +200}
"""
LEARNS = """  - do: {command: play}
    id: add
    text: "Let it learn to avoid."
    check: {measure: trial, above: 40000}
"""
LOOKS_INTO = """  - do: {command: inspect, region: behind}
    id: add
    text: "Let it learn to avoid."
    unlock: [inspect]
    check: {measure: trial, above: 40000}
"""


@pytest.fixture
def at_another(gui: viser.GuiApi, person: Person) -> Iterator[Callable[[str], Room]]:
    """Opens the small lesson at the card with something to do, for which another one stands."""
    rooms: list[Room] = []

    def open_room(card: str) -> Room:
        assert INTRODUCES in SMALL
        session = small_session()
        session.start()
        rooms.append(Room(session, gui, small_lesson(SMALL.replace(INTRODUCES, card))))
        at_deed(rooms[0], rooms[0].sitters[0])
        return rooms[0]

    yield open_room
    for room in rooms:
        room.close()


def test_a_press_that_comes_late_does_not_do_the_opposite_of_what_it_said(
    at_another: Callable[[str], Room],
) -> None:
    room = at_another(LEARNS)
    (sitter,) = room.sitters
    (play,) = [one for one in sitter.lesson["controls"] if one["control"] == "play"]
    assert (play["label"], play["value"]) == ("Play", "play")
    # It said "Pause" when it was pressed, and the run has come to a stop meanwhile.
    sitter.do(messages.Use("play", "pause"))
    assert not room.status.playing
    sitter.do(messages.Use("play", "play"))
    room.until(lambda: room.status.playing)


def test_a_place_is_looked_into_where_the_last_hint_does_that(
    at_another: Callable[[str], Room],
) -> None:
    room = at_another(LOOKS_INTO)
    (sitter,) = room.sitters
    assert sitter.cell is None
    for _ in range(3):
        sitter.do(messages.Hint())
    room.until(lambda: sitter.cell is not None)


def test_free_opens_all_in_this_browser_alone(room: Room, sitter: Sitter) -> None:
    sitter.start()
    sitter.do(messages.Free())
    assert sitter.state["free"]
    assert sitter.panel.told is None
    sitter.do(messages.BackToLesson())
    assert not sitter.state["free"]
    assert sitter.panel.told is not None
    sitter.do(messages.Leave())
    assert sitter.state["lesson"] is None
    assert next(one["at"] for one in sitter.state["list"] if one["name"] == "small") == 0


def test_another_run_on_the_board_is_said_and_the_lessons_own_can_be_had_back(
    room: Room, sitter: Sitter
) -> None:
    at_question(room, sitter)
    was = room.status.snapshot
    room.submit(GoBack())
    room.settle()
    assert sitter.card["busy"] == "Another run is on the board than this lesson's."
    (control,) = sitter.lesson["controls"]
    sitter.do(messages.Use(control["control"]))
    now = room.status.snapshot
    assert (now.generation, now.step) == (was.generation, was.step)
    assert (sitter.lesson["at"], sitter.card["busy"]) == (1, None)


def test_a_lesson_is_read_in_another_language_with_the_same_answers(
    room: Room, sitter: Sitter
) -> None:
    at_question(room, sitter)
    sitter.do(messages.Answer("guess", "no"), messages.SetLanguage("de"))
    assert sitter.lesson["title"] == "Eine kleine"
    assert sitter.card["ask"]["options"] == [["no", "nein"], ["yes", "ja"]]
    assert sitter.card["ask"]["answer"] == "no"
    sitter.do(messages.SetLanguage("fr"))
    assert sitter.lesson["language"] == "de"


def test_a_lesson_that_is_sent_is_in_the_list_or_all_is_said_that_is_wrong(
    sitter: Sitter,
) -> None:
    text = SMALL.replace("A small one", "Mine")
    parts = [text[at : at + 1_500] for at in range(0, len(text), 1_500)]
    for part, some in enumerate(parts):
        sitter.do(messages.Upload("mine.yaml", part, len(parts), some))
    assert sitter.state["fault"] == "“Mine” is in the list now."
    assert "mine" in {one["name"] for one in sitter.state["list"]}
    sitter.do(messages.Upload("bad.yaml", 0, 1, "title: [1]\nsteps: 3\n"))
    assert "title" in sitter.state["fault"]
    assert "steps" in sitter.state["fault"]
    sitter.do(messages.Upload("mine.yaml", 1, 2, "x"))
    assert sitter.state["fault"] == "The file has not come whole; choose it again"


@pytest.mark.parametrize(
    "message",
    [
        messages.Answer("guess", "perhaps"),
        messages.Answer("guess", [["no"]]),
        messages.Answer("guess", {"a": 1}),
        messages.Answer("add", "no"),
        messages.Answer("x" * 200, None),
        messages.Commit("guess", 70),
        messages.Commit("add"),
        messages.Next(),
        messages.Go(5),
        messages.Hint(),
        messages.Rewind(),
        messages.Start("nothing"),
        messages.Use("speed", 1e9),
        messages.Use("speed", True),
        messages.AskClass(),
        messages.EndClass(),
    ],
)
def test_what_no_hand_does_changes_nothing(room: Room, sitter: Sitter, message: object) -> None:
    at_question(room, sitter)
    before, stood = room.status.stories, room.status.snapshot
    sitter.do(message)
    assert room.status.stories == before
    assert (room.status.snapshot.step, room.status.speed) == (stood.step, 50_000)


def test_two_browsers_are_at_the_same_card(gui: viser.GuiApi, person: Person) -> None:
    session = small_session()
    session.start()
    room = Room(session, gui, small_lesson(), sitters=2)
    one, other = room.sitters
    # Nobody is asked where the lesson is begun at the beginning of the lab.
    room.submit(request_to_begin(small_lesson(), "", is_anew=False))
    room.until(lambda: other.state["lesson"] is not None and other.card["busy"] is None)
    one.do(messages.Next())
    room.until(lambda: other.lesson["at"] == 1)
    other.do(messages.Answer("guess", "yes"), messages.Commit("guess"))
    assert one.card["ask"]["locked"]
    other.do(messages.Free())
    assert (one.state["free"], other.state["free"]) == (False, True)
    room.close()


def test_a_curve_that_was_drawn_is_told_with_the_run_and_stays_on_the_bar(
    gui: viser.GuiApi, person: Person
) -> None:
    drawn = """  - ask: sketch
    id: curve
    text: "Draw the reward."
    from: 250
    to: 400
    low: -50
    high: 100
    reveal: {reward: 50, at: 400}
  - do: {command: run_to, at: 400}
    id: goes
    text: "Let it learn."
    check: {measure: trial, above: 399}
"""
    cards = '      - text: "Zeichne."\n      - text: "Lerne."\n'
    text = SMALL.replace("  - do: {command: introduce", f"{drawn}  - do: {{command: introduce")
    text = text.replace('      - {text: "Lass ihn', f'{cards}      - {{text: "Lass ihn')
    session = small_session()
    session.start()
    room = Room(session, gui, small_lesson(text))
    sitter = room.sitters[0]
    at_question(room, sitter)
    sitter.do(messages.Answer("guess", "yes"), messages.Commit("guess", 90), messages.Next())
    points = [(250 + 30 * place, 10.0) for place in range(6)]
    sitter.answered(Sketch(tuple(points)))
    sitter.do(messages.Commit("curve"), messages.Next())
    assert sitter.on_bar.locked
    assert sitter.on_bar.run == ()
    sitter.do(messages.Use("run_to"))
    room.until(lambda: sitter.card["check"]["verdict"] == "yes" and sitter.on_bar.run != ())
    assert sitter.on_bar.run[-1][0] == 400
    room.until(lambda: sitter.on_bar.band is not None)
    assert sitter.card["reveal"]["ready"]
    room.until(lambda: sitter.lesson["next"])
    sitter.do(messages.Next())
    assert sitter.on_bar is not None
    room.close()
