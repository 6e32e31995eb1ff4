"""The bar of one browser: what its frame is sent, and what comes of what a hand does there."""

import json
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest
import viser

from app.charts.bar.axis import last_trial
from app.charts.bar.model import rewards_of
from app.live import requests
from app.live.places import Mark, Place
from app.live.requests import Branch, Request
from app.live.status import Status
from app.page.time import messages
from app.page.time.asked import MomentAsked, SketchAsked, handles_at
from app.page.time.asks import Asks
from app.page.time.outlook import Outlook
from app.page.time.panel import Deeds, TimePanel
from learners.commands import SetSchedule
from learners.run import Run
from tests.page.time.walks import BRANCH, LIVE, Even, Makes, ground, status_at
from tests.support.person import AtOnce, Person
from tests.support.schedules import APPROACHING, AVOID, small_run, to

NOT_DONE = "What you did while the branch was being made is not done."


class Frames:
    """Frames that keep what they are sent."""

    def __init__(self) -> None:
        self.sent: list[tuple[str, dict[str, Any]]] = []
        self.has_left = False
        self.opened: Callable[[], object] = lambda: None

    def enter(self, kind: Any, take: Any, opened: Callable[[], object]) -> "Frames":
        self.opened = opened
        return self

    def frame_html(self, title: str) -> str:
        return "<iframe></iframe>"

    def send(self, kind: str, content: dict[str, Any]) -> None:
        self.sent.append((kind, content))

    def leave(self) -> None:
        self.has_left = True

    def last(self, kind: str) -> dict[str, Any]:
        return [content for sort, content in self.sent if sort == kind][-1]


class Desk:
    """The bar of one browser, on a session whose lines are made up."""

    def __init__(self, gui: viser.GuiApi, run: Run) -> None:
        self.live = status_at(run)
        self.lines = {LIVE: Even(run.step)}
        self.makes, self.frames = Makes(), Frames()
        self.asked: list[Request] = []
        self.chosen: list[str] = []
        self.tested: list[int] = []
        self.bar = msgspec.Raw(b"{}")
        self.of: tuple[object, ...] = ()
        """What the bar was wished of."""
        self.outlook = Outlook(1, self.makes)
        self.asks = Asks(self.outlook, lambda request, _: self.asked.append(request), print)
        bars: Any = SimpleNamespace(sent=self.sent)
        inbox: Any = AtOnce()
        client: Any = SimpleNamespace(gui=gui)
        frames: Any = self.frames
        deeds = Deeds(self.chosen.append, self.test)
        self.panel = TimePanel(
            client, self.outlook, self.asks, frames, bars, inbox, deeds, lambda: None
        )

    def sent(self, *of: object) -> msgspec.Raw:
        self.of = of
        return self.bar

    def test(self, client: object, line: int) -> None:
        self.tested.append(line)

    def show(self, is_answered: bool = True) -> Status:
        known = ground(self.lines, events=(300, 900))
        seen = self.outlook.status(self.live, 0.0, known)
        self.panel.update(seen, self.live, known, "", is_answered, 0.0)
        return seen

    def take(self, *many: Any) -> None:
        for message in many:
            self.show()
            self.panel.take(message)
        self.show()

    def arrive(self) -> None:
        """The moment that is wished is there."""
        run = small_run()
        run.advance(max_steps=self.makes.wishes[1].step)
        self.makes.make(1, run)
        self.show()

    @property
    def moment(self) -> dict[str, Any]:
        return self.frames.last("moment")

    @property
    def refused(self) -> str:
        said = self.frames.last("said")
        assert said["refused"]
        return str(said["text"])


@pytest.fixture
def desk(gui: viser.GuiApi, person: Person) -> Desk:
    return Desk(gui, to(small_run(), 150))


# --- What is sent


def test_the_frame_is_sent_bar_and_moment_once_and_all_anew_when_it_is_opened(desk: Desk) -> None:
    desk.show()
    desk.show()
    assert [kind for kind, _ in desk.frames.sent] == ["bar", "moment"]
    assert desk.frames.last("bar")["bar"] is desk.bar
    desk.frames.opened()
    desk.show()
    assert [kind for kind, _ in desk.frames.sent[2:]] == ["bar", "moment"]


def test_what_is_sent_can_be_written_as_json(desk: Desk) -> None:
    desk.take(messages.Seek(500), messages.SetA(), messages.Seek(900), messages.SetLoop(True))
    sent = json.loads(msgspec.json.encode(desk.moment))
    assert sent["loop"] == {"a": {"step": 500, "trial": 5}, "b": {"step": 900, "trial": 9}}
    assert sent["a"] == {"line": LIVE, "step": 500, "trial": 5}
    assert sent["rates"][0] == [1.0, "1 \N{MULTIPLICATION SIGN}"]


def test_live_and_past_are_told_apart(desk: Desk) -> None:
    desk.show()
    now = desk.live.snapshot
    moment = desk.moment
    assert (moment["live"], moment["step"], moment["trial"]) == (True, now.step, now.trial)
    assert (moment["behind_steps"], moment["playing"]) == (0, True)
    desk.take(messages.Seek(500))
    moment = desk.moment
    # The playhead is where the hand is, whether or not that moment has been made.
    assert (moment["live"], moment["step"], moment["trial"]) == (False, 500, 5)
    assert (moment["behind_steps"], moment["playing"]) == (now.step - 500, False)
    assert moment["behind_trials"] == now.trial - 5


def test_what_it_looked_at_is_gone_and_that_is_said(desk: Desk) -> None:
    desk.lines[BRANCH] = Even(900)
    desk.take(messages.Look(BRANCH))
    assert desk.moment["line"] == BRANCH
    del desk.lines[BRANCH]
    desk.show()
    assert desk.moment["live"]
    assert "not there any more" in desk.frames.last("said")["text"]


def test_what_is_asked_is_sent_and_what_a_hand_answers_is_handed_on(desk: Desk) -> None:
    heard: list[Any] = []
    desk.panel.ask(MomentAsked("when"), heard.append)
    desk.show()
    desk.show()
    assert [kind for kind, _ in desk.frames.sent] == ["bar", "ask", "moment"]
    last = last_trial(desk.live.snapshot)
    desk.take(messages.Guess(7), messages.Guess(last + 1))
    assert heard == [messages.Guess(7)]
    desk.panel.ask(MomentAsked("when", 7, locked=True), heard.append)
    desk.take(messages.Guess(8))
    assert desk.frames.last("ask")["ask"]["guess"] == 7
    assert heard == [messages.Guess(7)]
    desk.frames.opened()
    desk.show()
    assert [kind for kind, _ in desk.frames.sent[-3:]] == ["bar", "ask", "moment"]
    desk.panel.ask(None)
    desk.show()
    assert desk.frames.last("ask") == {"ask": None}


def test_a_curve_that_is_drawn_is_seen_against_trials_and_by_itself(desk: Desk) -> None:
    desk.take(messages.SetUnit("steps"))
    assert ("steps" in desk.of, desk.of[-1]) == (True, None)
    asked = SketchAsked("how", 100, 400)
    heard: list[Any] = []
    desk.panel.ask(asked, heard.append)
    points = tuple((trial, 1000.0) for trial in handles_at(100, 400))
    desk.take(messages.Sketch(points))
    assert ("trials" in desk.of, desk.of[-1]) == (True, asked.view)
    _, most = rewards_of(desk.live.snapshot)
    assert [{reward for _, reward in sketch.points} for sketch in heard] == [{most}]
    desk.panel.ask(None)
    desk.show()
    assert ("steps" in desk.of, desk.of[-1]) == (True, None)


def test_who_leaves_is_sent_nothing(desk: Desk) -> None:
    desk.panel.leave()
    assert desk.frames.has_left


# --- Walking


def test_a_hand_goes_through_the_past(desk: Desk) -> None:
    steps = [
        (messages.Seek(500), 500),
        (messages.GoBy("steps", 1), 501),
        (messages.GoBy("trials", -1), 400),
        (messages.GoBy("events", 1), 900),
        (messages.SeekTrial(2), 200),
        (messages.Seek(0), 0),
    ]
    for message, step in steps:
        desk.take(message)
        assert desk.moment["step"] == step
    desk.take(messages.Live())
    assert desk.moment["live"]
    assert desk.asked == []


def test_playing_is_of_what_is_looked_at(desk: Desk) -> None:
    desk.take(messages.Pause(), messages.Play(1))
    assert desk.asked == [requests.Pause(), requests.Play()]
    desk.take(messages.Seek(500), messages.Play(1))
    assert desk.moment["playing"]
    desk.take(messages.SetRate(5.0), messages.SetStops(True), messages.SetHolds(True))
    assert (desk.moment["rate"], desk.moment["stops"], desk.moment["holds"]) == (5.0, True, True)
    desk.take(messages.Pause(), messages.Play(-1))
    assert (desk.moment["playing"], desk.moment["direction"]) == (True, -1)
    assert len(desk.asked) == 2


def test_what_cannot_be_done_is_said_in_the_frame(desk: Desk) -> None:
    desk.take(messages.SetLoop(True))
    assert "Set A first" in desk.refused
    desk.take(messages.Look(99))
    assert "not there" in desk.refused
    desk.take(messages.Seek(0), messages.Play(-1))
    assert "beginning" in desk.refused


def test_another_line_is_looked_at_at_the_same_step_and_from_live_at_its_end(desk: Desk) -> None:
    desk.lines[BRANCH] = Even(900)
    desk.take(messages.Look(BRANCH))
    assert (desk.moment["line"], desk.moment["step"]) == (BRANCH, 900)
    desk.take(messages.Seek(700), messages.Look(LIVE))
    assert desk.moment["live"]
    desk.take(messages.Seek(700), messages.Look(BRANCH))
    assert (desk.moment["line"], desk.moment["step"]) == (BRANCH, 700)


# --- The schedule


def test_a_block_is_changed_by_the_command_of_the_plan(desk: Desk) -> None:
    desk.take(messages.EditBlock(AVOID, at=250))
    (asked,) = desk.asked
    assert isinstance(asked, SetSchedule)
    assert asked.schedule.introduced_at("avoid") == 250


def test_edits_in_quick_succession_add_up(desk: Desk) -> None:
    desk.show()
    desk.panel.take(messages.EditBlock(AVOID, at=250))
    desk.show(is_answered=False)
    desk.panel.take(messages.EditBlock(APPROACHING, trials=77, probability=0.25))
    *_, asked = desk.asked
    assert isinstance(asked, SetSchedule)
    assert asked.schedule.introduced_at("avoid") == 250
    assert (asked.schedule.episodes[2].duration, asked.schedule.episodes[2].probability) == (
        77,
        0.25,
    )
    desk.panel.take(messages.DeleteBlock(APPROACHING))
    desk.panel.take(messages.AddExploration("approach", 400, 30, 0.5))
    *_, asked = desk.asked
    assert isinstance(asked, SetSchedule)
    assert [episode.at for episode in asked.schedule.episodes][-1] == 400


def test_an_edit_that_cannot_be_had_is_said_and_asks_nothing(desk: Desk) -> None:
    desk.take(messages.EditBlock("introduction:circle_clockwise", at=250))
    assert "past" in desk.refused
    desk.take(messages.DeleteBlock("nonsense"), messages.AddExploration("nobody", 400, 3, 0.5))
    assert desk.asked == []


def test_an_edit_in_the_past_is_one_of_the_plan_there_and_makes_a_branch(desk: Desk) -> None:
    desk.take(messages.Seek(500))
    desk.arrive()
    desk.take(messages.EditBlock("introduction:circle_clockwise", at=120))
    (asked,) = desk.asked
    assert isinstance(asked, Branch)
    assert asked.place == Place(LIVE, 500)
    assert isinstance(asked.command, SetSchedule)
    assert asked.command.schedule.introduced_at("circle_clockwise") == 120


def test_an_edit_while_a_branch_is_made_is_one_of_the_plan_of_that(desk: Desk) -> None:
    desk.take(messages.Seek(500))
    desk.arrive()
    desk.take(messages.EditBlock(AVOID, at=250), messages.EditBlock(AVOID, trials=33))
    assert len(desk.asked) == 1
    desk.lines[BRANCH] = Even(900)
    desk.live = replace(desk.live, branched=((1, Place(BRANCH, 500)),))
    desk.asks.follow(desk.live, ground(desk.lines), 0.0)
    desk.show()
    desk.makes.made.clear()
    run = small_run()
    run.advance(max_steps=500)
    first = desk.asked[0]
    assert isinstance(first, Branch)
    run.apply(first.command)
    desk.makes.make(1, run)
    desk.show()
    *_, asked = desk.asked
    assert isinstance(asked, Branch)
    assert asked.place == Place(BRANCH, 500)
    assert isinstance(asked.command, SetSchedule)
    timer = asked.command.schedule.skills["avoid"]
    assert (timer.at, timer.freeze) == (250, 33)


@pytest.mark.parametrize("goes_back", [True, False])
def test_an_edit_that_was_meant_for_a_branch_is_done_to_no_other_line(
    desk: Desk, goes_back: bool
) -> None:
    desk.take(messages.Seek(500))
    desk.arrive()
    desk.take(messages.EditBlock(AVOID, at=250), messages.EditBlock(AVOID, trials=33))
    desk.live = replace(desk.live, branched=((1, Place(BRANCH, 500)),))
    # Somebody has deleted it meanwhile.
    desk.asks.follow(desk.live, ground(desk.lines), 0.0)
    if goes_back:
        desk.outlook.walk.go_live()
    desk.show()
    assert len(desk.asked) == 1
    assert desk.refused == (NOT_DONE if goes_back else "That line is not there any more.")


# --- Lines and marks


def test_what_is_done_to_lines_and_marks_is_asked_of_the_session(desk: Desk) -> None:
    desk.take(messages.Seek(500))
    desk.take(
        messages.AddMark("here", LIVE, 500),
        messages.RemoveMark(4),
        messages.NameLine(BRANCH, "mine"),
        messages.DeleteLine(BRANCH),
        messages.BringBack(BRANCH),
        messages.MakeLive(BRANCH),
    )
    assert desk.asked == [
        requests.AddMark(Place(LIVE, 500), "here"),
        requests.RemoveMark(4),
        requests.NameLine(BRANCH, "mine"),
        requests.DeleteLine(BRANCH),
        requests.BringBack(BRANCH),
        requests.MakeLive(BRANCH),
    ]
    desk.take(messages.ChooseBlock(AVOID), messages.TryOverSeeds(BRANCH))
    assert (desk.chosen, desk.tested) == ([AVOID], [BRANCH])


def test_a_mark_is_of_the_moment_at_which_somebody_began_to_write(desk: Desk) -> None:
    desk.take(messages.AddMark("here", LIVE, 700))
    assert desk.asked == [requests.AddMark(Place(LIVE, 700), "here")]


def test_at_a_the_loop_goes_to_the_newest_mark(desk: Desk) -> None:
    marks = (Mark(1, Place(LIVE, 700), 7, "one"), Mark(2, Place(BRANCH, 800), 8, "other"))
    desk.live = replace(desk.live, marks=marks)
    desk.take(messages.Seek(500), messages.SetA(), messages.SetLoop(True))
    assert desk.moment["loop"]["b"]["step"] == 700


def test_a_loop_is_shown_on_its_own_line_alone(desk: Desk) -> None:
    desk.lines[BRANCH] = Even(900)
    desk.take(messages.Seek(300), messages.SetA(), messages.Seek(700), messages.SetLoop(True))
    desk.take(messages.Look(BRANCH))
    elsewhere = desk.moment
    desk.take(messages.Look(LIVE), messages.Seek(400))
    assert (elsewhere["loop"], desk.moment["loop"]["b"]["step"]) == (None, 700)


def test_nothing_of_what_comes_before_a_bar_was_shown_is_done(desk: Desk) -> None:
    desk.panel.take(messages.Pause())
    assert desk.asked == []
