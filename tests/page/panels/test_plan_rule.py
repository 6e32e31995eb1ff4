"""In the plan a skill joins in a trial or by a rule, as somebody at the tab wants it."""

from collections.abc import Iterator

import pytest
import viser

from app.live.requests import Request
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.page.panels.plan import PlanPanel
from app.server.server import close_server, open_server
from learners.commands import FreezeSkills
from learners.schedule_spec import TriggerSpec
from tests.support.person import Person
from tests.support.schedules import RULE, ruled_spec

CIRCLE = "circle_clockwise"


class Desk:
    """The panel of a paused session, and somebody before it."""

    def __init__(self, server: viser.ViserServer) -> None:
        self.session = Session(ruled_spec(), "timed", 5, speed=1.0, playing=False)
        self.session.start()
        self.person = Person(server.gui)
        self.panel = PlanPanel(
            server.gui, self.ask, lambda _: self.session.status, self.session.status
        )

    def ask(self, _: object, request: Request) -> None:
        self.session.submit(request, self.person.told.append)

    def settle(self) -> Snapshot:
        """Wait until all has been answered, and show it."""
        ticket = self.session.submit(FreezeSkills(False))
        status = self.session.wait_for(lambda status: status.answered >= ticket, 60)
        self.panel.update(status)
        return status.snapshot

    def choose(self, label: str, what: str = "Change") -> None:
        self.person.choose(what, label)
        self.settle()

    def apply(self) -> Snapshot:
        self.settle()
        self.person.click("Apply")
        return self.settle()


@pytest.fixture
def desk() -> Iterator[Desk]:
    server = open_server(port=0)
    desk = Desk(server)
    desk.settle()
    yield desk
    desk.session.stop()
    close_server(server)


def test_a_rule_is_shown_and_its_skill_has_no_trial(desk: Desk) -> None:
    desk.choose("circle clockwise: joins")
    person = desk.person
    assert person.value("Joins") == "By a rule"
    assert person.value("Watches") == "New states visited"
    assert (person.value("Over"), person.value("Below")) == ("50", "0.2")
    assert not any(person.sees(label) for label in ("At trial", "Earlier", "Later"))
    assert person.reads("visit fewer than 0.2 new states a trial")
    assert not person.can_use("Apply")


def test_a_trial_takes_the_place_of_the_rule(desk: Desk) -> None:
    desk.choose("circle clockwise: joins")
    desk.choose("At a trial", "Joins")
    desk.person.type("At trial", "120")
    schedule = desk.apply().spec.schedule
    assert schedule.introduced_at(CIRCLE) == 120
    assert schedule.rule_of(CIRCLE) is None
    assert schedule.rule_of("avoid") == RULE
    assert desk.person.told == []
    assert desk.person.value("Joins") == "At a trial"
    assert desk.person.can_use("Later")


def test_a_rule_takes_the_place_of_a_trial_again(desk: Desk) -> None:
    desk.choose("circle clockwise: joins")
    desk.choose("At a trial", "Joins")
    desk.apply()
    desk.choose("By a rule", "Joins")
    desk.choose("Change of value", "Watches")
    desk.person.type("Over", "200")
    desk.person.type("Below", "0.05")
    timer = desk.apply().spec.schedule.skills[CIRCLE]
    assert timer.introduce == TriggerSpec(by="change", window=200, below=0.05)
    assert (timer.at, timer.freeze) == (None, 20)


def test_the_rule_of_the_schedule_is_not_said_twice(desk: Desk) -> None:
    desk.choose("circle clockwise: joins")
    desk.choose("At a trial", "Joins")
    desk.apply()
    desk.choose("By a rule", "Joins")
    desk.choose("New states visited", "Watches")
    desk.person.type("Over", "50")
    desk.person.type("Below", "0.2")
    timer = desk.apply().spec.schedule.skills[CIRCLE]
    assert (timer.at, timer.introduce) == (None, None)


def test_a_rule_that_cannot_be_is_refused(desk: Desk) -> None:
    desk.choose("circle clockwise: joins")
    desk.person.type("Over", "0")
    desk.settle()
    desk.person.click("Apply")
    assert "allowed" in desk.person.told[0]
    assert desk.settle().spec.schedule.rule_of(CIRCLE) == RULE


def test_an_exploration_that_comes_with_a_rule_is_not_moved(desk: Desk) -> None:
    desk.choose("circle clockwise: exploration")
    assert not any(desk.person.sees(label) for label in ("At trial", "Later", "Joins", "Below"))
    assert desk.person.reads("It begins when its skill joins, by a rule")
    desk.person.type("Lasts", "33")
    episode = desk.apply().spec.schedule.episodes[0]
    assert (episode.at, episode.duration) == ("introduction", 33)
