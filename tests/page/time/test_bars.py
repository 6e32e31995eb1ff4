"""Bars of lines, made once for all who see the same."""

import threading
from collections.abc import Iterator
from typing import Any

import msgspec
import pytest

from app.charts.bar.model import View
from app.live.places import Place
from app.live.requests import Branch, Play
from app.live.session import Session
from app.live.status import Status
from app.page.ghost import GhostWatch
from app.page.greedy import GreedyWatch
from app.page.time.bars import Bars
from app.page.time.grounds import Grounds
from app.page.time.outlook import Outlook
from learners.commands import SetParameter
from tests.support.schedules import small_spec
from tests.support.server import PATIENCE_S

ANNA, BERT = 1, 2
FORK = 3_000


class Desk:
    """A session that has come to its end, with a branch of it."""

    def __init__(self) -> None:
        self.session = Session(small_spec(), "timed", 5, float("inf"), playing=False)
        self.session.start()
        self.session.submit(Play())
        self.session.wait_for(lambda status: status.finished, PATIENCE_S)
        command = SetParameter("learner.epsilon", 0.5)
        self.session.submit(Branch(Place(0, FORK), command, ANNA))
        self.session.wait_for(
            lambda status: len(status.lines) == 2 and not status.lines[-1].is_growing, PATIENCE_S
        )
        self.grounds = Grounds(self.session)
        ghosts: Any = GhostWatch()
        self.bars = Bars(self.grounds, self.session.moments, GreedyWatch(), ghosts)
        self.now_s = 0.0

    @property
    def live(self) -> Status:
        return self.session.status

    def sent(self, outlook: Outlook, chosen: str = "", view: View | None = None) -> Any:
        """The bar of what a browser looks at, once that is made."""
        for _ in range(1_000):
            self.now_s += 1.0
            ground = self.grounds.of(self.live)
            seen = outlook.status(self.live, self.now_s, ground)
            is_there = outlook.is_there
            line = outlook.walk.line(ground)
            bar = self.bars.sent(
                outlook.viewer, line, seen, self.live, ground, "trials", chosen, self.now_s, view
            )
            self.bars.tidy(self.now_s)
            if bar is not None and is_there:
                return bar
            self.let_moments_be_made()
        pytest.fail("no bar was made")

    def let_moments_be_made(self) -> None:
        done = threading.Event()
        self.session.moments.ask(lambda: None, lambda _: done.set())
        assert done.wait(PATIENCE_S)

    def outlook(self, viewer: int, line: int | None = None, step: int | None = None) -> Outlook:
        outlook = Outlook(viewer, self.session.moments)
        if line is not None:
            outlook.walk.look(line, step, 0.0, self.grounds.of(self.live))
        return outlook


def read(bar: Any) -> Any:
    return msgspec.json.decode(bar)


@pytest.fixture(scope="module")
def desk() -> Iterator[Desk]:
    desk = Desk()
    yield desk
    desk.session.stop()


def test_all_who_are_live_have_one_bar_which_stays_while_nothing_changes(desk: Desk) -> None:
    first = desk.sent(desk.outlook(ANNA))
    assert desk.sent(desk.outlook(BERT)) is first
    bar = read(first)
    assert bar["line"] == 0
    assert [line["name"] for line in bar["lines"]] != []
    assert desk.sent(desk.outlook(ANNA), chosen="introduction:avoid") is first


def test_the_bar_of_a_moment_is_that_of_its_whole_line_with_the_plan_there(desk: Desk) -> None:
    live = read(desk.sent(desk.outlook(ANNA)))
    past = read(desk.sent(desk.outlook(ANNA, 0, 50)))
    assert past["learned"] == live["learned"]
    assert past["end"] == live["end"]

    def editable(bar: Any) -> set[str]:
        pieces = (piece for lane in bar["lanes"] for piece in lane["pieces"])
        return {piece["id"] for piece in pieces if piece["editable"]}

    assert "introduction:avoid" in editable(past)
    assert "introduction:avoid" not in editable(live)


def test_who_draws_how_the_curve_goes_on_is_not_sent_it_though_the_run_went_on(desk: Desk) -> None:
    whole = read(desk.sent(desk.outlook(ANNA)))
    last = whole["end"]["trial"]
    view = View(last // 5, last, hides_after=last // 2)

    def trials(of: Any) -> list[float]:
        start, end = view.first, view.end
        return [start + at * (end - start) for at in (*of["learned"]["at"], *of["greedy"]["at"])]

    for outlook in (desk.outlook(ANNA), desk.outlook(ANNA, desk.live.lines[-1].number)):
        part = read(desk.sent(outlook, view=view))
        assert part["learned"]["at"]
        assert max(trials(part)) <= last // 2
        assert (part["ghost"], part["lines"]) == (None, [])
        assert all(view.first <= one["trial"] <= last // 2 for one in part["happenings"])
        assert (part["axis"]["start"], part["axis"]["end"]) == (view.first, last)
    # Nobody else's is another for it, and it all comes back.
    assert read(desk.sent(desk.outlook(BERT))) == whole
    locked = read(desk.sent(desk.outlook(ANNA), view=view._replace(hides_after=None)))
    assert max(trials(locked)) > last // 2
    assert read(desk.sent(desk.outlook(ANNA))) == whole


def test_the_bar_of_a_branch_has_the_line_that_it_left_behind_it(desk: Desk) -> None:
    number = desk.live.lines[-1].number
    bar = read(desk.sent(desk.outlook(ANNA, number)))
    assert bar["line"] == number
    assert bar["ghost"] is not None
    live = read(desk.sent(desk.outlook(ANNA)))
    assert bar["learned"] != live["learned"]
    given = [one for one in bar["happenings"] if one["kind"] == "command"]
    assert [one["step"] for one in given] == [FORK]
    assert all(one["kind"] != "command" for one in live["happenings"])
