"""What one browser asks for, by where it looks: of the session, of its walk, or as a branch."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from app.live.places import Place
from app.live.requests import Branch, Pause, Play, Request, SetSpeed, StepOnce, TrialOnce
from app.live.status import Status
from app.live.worker import Reply
from app.page.time.asks import Asks
from app.page.time.outlook import Outlook
from app.page.time.walk import WalkError
from learners.commands import FreezeSelection, SetParameter
from learners.run import Run
from tests.page.time.walks import BRANCH, LIVE, Even, Makes, ground, status_at
from tests.support.schedules import small_run, to

ANNA, BERT = 1, 2
FREEZE, EPSILON = FreezeSelection(True), SetParameter("learner.epsilon", 0.3)


class Desk:
    """A browser whose requests are kept, on a session whose lines are made up."""

    def __init__(self, run: Run) -> None:
        self.live = status_at(run)
        self.lines = {LIVE: Even(run.step)}
        self.makes = Makes()
        self.outlook = Outlook(ANNA, self.makes)
        self.asked: list[Request] = []
        self.replies: list[Reply] = []
        self.later: list[Callable[[], object]] = []
        self.told: list[str] = []
        self.asks = Asks(self.outlook, self.submit, self.later.append)

    def submit(self, request: Request, reply: Reply) -> None:
        self.asked.append(request)
        self.replies.append(reply)

    def look(self, line: int, step: int) -> None:
        known = ground(self.lines)
        self.outlook.walk.look(line, step, 0.0, known)
        self.outlook.status(self.live, 0.0, known)
        run = small_run()
        run.advance(max_steps=step)
        self.makes.make(ANNA, run)

    def seen(self) -> Status:
        return self.outlook.status(self.live, 0.0, ground(self.lines))

    def ask(self, *requests: Request) -> None:
        for request in requests:
            known = ground(self.lines)
            self.asks.take(request, self.told.append, self.seen(), known, 0.0)

    def branch_off(self, line: int, step: int, viewer: int = ANNA) -> None:
        """The session has made a branch for somebody."""
        self.lines[line] = Even(self.lines[LIVE].end_step)
        branched = (*self.live.branched, (viewer, Place(line, step)))
        self.live = replace(self.live, branched=branched)
        self.asks.follow(self.live, ground(self.lines), 0.0)


@pytest.fixture
def desk() -> Desk:
    return Desk(to(small_run(), 150))


def test_what_is_live_is_asked_of_the_session(desk: Desk) -> None:
    requests = (Play(), Pause(), StepOnce(), TrialOnce(), FREEZE, SetSpeed(3.0))
    desk.ask(*requests)
    assert desk.asked == list(requests)


def test_in_the_past_the_walk_plays_and_steps(desk: Desk) -> None:
    desk.look(LIVE, 500)
    walk = desk.outlook.walk
    desk.ask(Play())
    assert walk.direction == 1
    desk.ask(Pause())
    assert walk.direction == 0
    desk.ask(StepOnce())
    assert walk.at(0.0, ground(desk.lines)) == Place(LIVE, 501)
    desk.ask(TrialOnce())
    assert walk.at(0.0, ground(desk.lines)) == Place(LIVE, 600)
    assert desk.asked == []


def test_on_past_the_end_of_a_branch_there_is_nothing(desk: Desk) -> None:
    desk.lines[BRANCH] = Even(500)
    desk.look(BRANCH, 500)
    with pytest.raises(WalkError, match="Nothing more"):
        desk.ask(Play())


def test_what_is_of_the_whole_session_is_asked_of_it_from_anywhere(desk: Desk) -> None:
    desk.look(LIVE, 500)
    desk.ask(SetSpeed(3.0))
    assert desk.asked == [SetSpeed(3.0)]


def test_a_command_in_the_past_makes_a_branch_to_which_this_browser_goes(desk: Desk) -> None:
    desk.look(LIVE, 500)
    desk.ask(FREEZE)
    assert desk.asked == [Branch(Place(LIVE, 500), FREEZE, ANNA)]
    assert desk.asks.is_branching
    assert desk.asks.note == ""
    desk.branch_off(3, 900, viewer=BERT)
    assert desk.asks.is_branching
    desk.branch_off(BRANCH, 500)
    assert not desk.asks.is_branching
    desk.seen()
    assert desk.outlook.place == Place(BRANCH, 500)
    assert "selection" in desk.asks.note
    assert "End goes back to the live run" in desk.asks.note
    desk.outlook.walk.go_live()
    desk.seen()
    assert desk.asks.note == ""


def test_what_plays_stands_where_it_is_branched_off(desk: Desk) -> None:
    desk.look(LIVE, 500)
    desk.ask(Play(), FREEZE)
    assert desk.outlook.walk.direction == 0


def test_what_is_asked_meanwhile_is_done_on_the_branch(desk: Desk) -> None:
    desk.look(LIVE, 500)
    desk.ask(FREEZE, EPSILON)
    assert len(desk.asked) == 1
    desk.branch_off(BRANCH, 500)
    assert desk.asked[1:] == [Branch(Place(BRANCH, 500), EPSILON, ANNA)]
    # The branch with both commands takes the place of that with one.
    del desk.lines[BRANCH]
    desk.branch_off(BRANCH + 1, 500)
    desk.seen()
    assert desk.outlook.place == Place(BRANCH + 1, 500)
    assert "selection" in desk.asks.note
    assert "0.3" in desk.asks.note


def test_a_refusal_is_told_and_what_waited_for_the_branch_is_given_up(desk: Desk) -> None:
    desk.look(LIVE, 500)
    desk.ask(FREEZE, EPSILON)
    desk.replies[0]("there are 8 branches; delete one first")
    assert desk.told == ["there are 8 branches; delete one first"]
    for act in desk.later:
        act()
    assert not desk.asks.is_branching
    desk.ask(EPSILON)
    assert desk.asked[1:] == [Branch(Place(LIVE, 500), EPSILON, ANNA)]


def test_a_branch_that_is_gone_before_one_comes_to_it_takes_nobody_along(desk: Desk) -> None:
    desk.look(LIVE, 500)
    desk.ask(FREEZE, EPSILON)
    desk.live = replace(desk.live, branched=((ANNA, Place(BRANCH, 500)),))
    desk.asks.follow(desk.live, ground(desk.lines), 0.0)
    assert not desk.asks.is_branching
    assert desk.told == ["That line is not there any more."] * 2
    desk.seen()
    assert desk.outlook.place == Place(LIVE, 500)
    assert len(desk.asked) == 1


def test_what_stops_the_learner_while_a_branch_is_made_is_told(desk: Desk) -> None:
    desk.look(LIVE, 500)
    desk.ask(FREEZE, EPSILON)
    desk.live = replace(desk.live, error="MemoryError: no room")
    desk.asks.follow(desk.live, ground(desk.lines), 0.0)
    assert not desk.asks.is_branching
    assert desk.told == ["the learner has stopped: MemoryError: no room"] * 2
    # One that had stopped before can be branched all the same.
    desk.ask(EPSILON)
    desk.asks.follow(desk.live, ground(desk.lines), 0.0)
    assert desk.asks.is_branching


def test_a_branch_that_somebody_else_makes_takes_nobody_along(desk: Desk) -> None:
    desk.look(LIVE, 500)
    desk.branch_off(BRANCH, 500, viewer=BERT)
    desk.seen()
    assert desk.outlook.place == Place(LIVE, 500)
