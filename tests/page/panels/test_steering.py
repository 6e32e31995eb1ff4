"""Steering while it learns, on a real server that nobody looks at."""

import math
from collections.abc import Iterator
from dataclasses import replace

import pytest
import viser

from app.documents import presets
from app.live import snapshot
from app.live.requests import Request
from app.live.session import Session
from app.page import widgets
from app.page.panels.steering import DEFAULT_FREEZE_TRIALS, SLIDERS, Steering, introduction_of
from app.server.server import close_server, open_server
from app.words.plain import PARAMETER_NAMES
from learners.commands import (
    Command,
    CommandError,
    DefineSkill,
    Explore,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Remove,
    SetParameter,
    StopTeaching,
    Teach,
    Undo,
)
from learners.names import MAX_TRIALS
from learners.run import Run
from learners.skill_spec import SkillWeights
from tests.support.person import Person

OWN = SkillWeights(approach=1.0)
ALPHA = PARAMETER_NAMES["learner.alpha"]


def run_of(*settings: str) -> Run:
    return Run(presets.load("timed", ["world.size=40", *settings]), seed=1)


class Desk:
    """The panel over a run, what it has asked for, and somebody before it."""

    def __init__(self, gui: viser.GuiApi, run: Run) -> None:
        session = Session(run.preset, "timed", 1, speed=100.0, playing=False)
        taken = snapshot.take(run, "timed", 0)
        self.status = replace(session.status, snapshot=taken)
        self.requests: list[Request] = []
        self.steering = Steering(gui, self.ask, lambda _: self.status, self.status)
        self.steering.update(self.status)
        self.person = Person(gui)

    def ask(self, client: object, request: Request) -> None:
        assert client is self.person
        self.requests.append(request)

    def define(self, name: str) -> None:
        self.person.send(self.person.widget("Own skill"), name)
        self.person.fill("\N{MULTIPLICATION SIGN} avoid as a number", 1)
        self.person.click("Add my own skill now")


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    server = open_server(port=0)
    yield server
    close_server(server)


def after(*commands: Command) -> Run:
    run = run_of()
    for command in commands:
        run.apply(command)
    return run


# Skills


def test_a_skill_of_ones_own_is_defined_and_joins(server: viser.ViserServer) -> None:
    desk = Desk(server.gui, after())
    desk.define("mine")
    assert desk.requests == [
        DefineSkill("mine", SkillWeights(avoid=1.0)),
        Introduce("mine", DEFAULT_FREEZE_TRIALS),
    ]


def test_an_own_skill_that_is_gone_does_not_join_in_the_place_of_another(
    server: viser.ViserServer,
) -> None:
    run = after(DefineSkill("mine", OWN), Introduce("mine", 300), Remove("mine"))
    desk = Desk(server.gui, run)
    desk.define("mine")
    assert desk.person.told == ["there is a skill named 'mine'; allowed: another name"]
    assert desk.requests == []


@pytest.mark.parametrize("name", ["", "Mine", "1st", "my skill", "a" * 33, "mine\n", "<b>"])
def test_what_is_no_name_is_refused_with_what_is_allowed(
    server: viser.ViserServer, name: str
) -> None:
    desk = Desk(server.gui, after())
    desk.define(name)
    assert "allowed: a name of up to 32 characters" in desk.person.told[0]
    assert desk.requests == []


def test_a_skill_joins_with_the_freeze_that_the_schedule_has_for_it() -> None:
    run = run_of("schedule.skills.avoid={at: 3000, freeze: 20}")
    assert introduction_of(snapshot.take(run, "timed", 0), "avoid") == Introduce("avoid", 20)


def test_a_skill_that_the_schedule_does_not_bring_is_frozen_as_in_the_thesis() -> None:
    run = after(DefineSkill("mine", OWN))
    new = introduction_of(snapshot.take(run, "timed", 0), "mine")
    assert new == Introduce("mine", DEFAULT_FREEZE_TRIALS)
    run.apply(new)
    run.apply(Remove("mine"))
    assert run.spec.schedule.skills["mine"].at == MAX_TRIALS
    assert introduction_of(snapshot.take(run, "timed", 0), "mine") == new


def test_another_skill_is_added_by_its_name_in_the_list(server: viser.ViserServer) -> None:
    run = run_of("schedule.skills.avoid={at: 3000, freeze: 20}")
    desk = Desk(server.gui, run)
    for skill in ("circle counterclockwise", "avoid"):
        desk.person.choose("Skill", skill)
        desk.person.click("Add this skill now")
    assert desk.requests == [
        Introduce("circle_counterclockwise", DEFAULT_FREEZE_TRIALS),
        Introduce("avoid", 20),
    ]


# Sliders


def test_a_slider_is_asked_for_once_it_has_come_to_rest(server: viser.ViserServer) -> None:
    desk = Desk(server.gui, after())
    desk.person.move(ALPHA, 0.3)
    desk.person.move(ALPHA, 0.4)
    desk.steering.settle(-math.inf)
    assert desk.requests == []
    desk.steering.settle(math.inf)
    desk.steering.settle(math.inf)
    assert desk.requests == [SetParameter("learner.alpha", 0.4)]


def test_a_number_that_is_finished_is_asked_for_without_a_rest(server: viser.ViserServer) -> None:
    desk = Desk(server.gui, after())
    desk.person.fill(f"{ALPHA} as a number", 0.4)
    desk.steering.settle(0.0)
    assert desk.requests == [SetParameter("learner.alpha", 0.4)]


def test_what_a_slider_is_set_to_while_it_is_asked_for_is_not_lost(
    server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk = Desk(server.gui, after())

    def ask(client: object, request: Request) -> None:
        if not desk.requests:
            desk.person.move(ALPHA, 0.7)
        desk.requests.append(request)

    monkeypatch.setattr(desk.steering, "_ask", ask)
    desk.person.move(ALPHA, 0.3)
    desk.steering.settle(math.inf)
    desk.steering.settle(math.inf)
    assert desk.requests == [
        SetParameter("learner.alpha", 0.3),
        SetParameter("learner.alpha", 0.7),
    ]


def test_what_is_true_is_not_shown_over_what_has_not_been_asked_for_yet(
    server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(widgets, "TOUCHED_S", -1.0)
    desk = Desk(server.gui, after())
    desk.person.move(ALPHA, 0.3)
    desk.steering.update(desk.status)
    assert desk.person.value(ALPHA) == 0.3
    desk.steering.settle(math.inf)
    desk.steering.update(desk.status)
    assert desk.person.value(ALPHA) == 0.1


def test_a_slider_and_its_number_show_what_is_true(server: viser.ViserServer) -> None:
    desk = Desk(server.gui, after(SetParameter("learner.alpha", 0.123)))
    assert desk.person.value(f"{ALPHA} as a number") == "0.123"
    assert desk.person.value(ALPHA) == pytest.approx(0.123, abs=0.01)
    assert {slider.key for slider in SLIDERS} == set(PARAMETER_NAMES)


# Changes by hand


def test_changes_by_hand_are_counted_from_one_whatever_the_schedule_did(
    server: viser.ViserServer,
) -> None:
    run = run_of("schedule.skills.circle_clockwise.at=5")
    run.apply(SetParameter("learner.skill_alpha", 0.3))
    run.advance(until_trial=10)
    run.apply(FreezeSkills(True))
    run.apply(Undo(run.control.history[-1].number))
    run.apply(Explore("approach", 100, 0.5))
    run.apply(FreezeSelection(True))
    desk = Desk(server.gui, run)
    assert desk.person.options("Take back") == [
        "4: selection frozen",
        "3: approach explored at 50%",
        "1: α of skills = 0.3",
    ]
    assert desk.person.reads("2: skills frozen, trial 10")
    desk.person.choose("Take back", "3: approach explored at 50%")
    desk.person.click("Undo")
    (undo,) = desk.requests
    assert isinstance(undo, Undo)
    assert run.control.history[undo.number].command == Explore("approach", 100, 0.5)


# Teaching


def test_a_script_is_asked_to_teach_and_to_stop(server: viser.ViserServer) -> None:
    desk = Desk(server.gui, after())
    assert not desk.person.sees("Stop teaching")
    desk.person.type("Taught trials", "120")
    desk.person.click("Teach now")
    assert desk.requests == [Teach("flank", 120)]


def test_while_a_script_teaches_it_says_until_when_and_can_be_stopped(
    server: viser.ViserServer,
) -> None:
    desk = Desk(server.gui, after(Teach("flank", 120)))
    assert desk.person.reads("A script chooses until trial 120.")
    desk.person.click("Stop teaching")
    assert desk.requests == [StopTeaching()]


def test_who_has_no_avoid_cannot_be_taught_and_says_why(server: viser.ViserServer) -> None:
    desk = Desk(server.gui, Run(presets.load("hierarchical_2", ["world.size=40"]), seed=1))
    assert not desk.person.can_use("Teach now")
    assert desk.person.reads("chooses avoid, not among the learner's options")


# Weights of a rule


def test_the_weight_of_a_skill_is_set_where_a_rule_selects(server: viser.ViserServer) -> None:
    run = Run(presets.load("static_appetite_fear", ["world.size=40"]), seed=1)
    desk = Desk(server.gui, run)
    desk.person.choose("Weight of", "fear")
    desk.steering.update(desk.status)
    desk.person.fill("Weight as a number", 2.5)
    desk.steering.settle(now_s=1e12)
    assert desk.requests == [SetParameter("learner.weights.fear", 2.5)]
    run.apply(SetParameter("learner.weights.fear", 2.5))
    assert run.control.spec.learner.weights == {"fear": 2.5}


def test_there_are_no_weights_where_a_table_selects(server: viser.ViserServer) -> None:
    desk = Desk(server.gui, after())
    with pytest.raises(AssertionError):
        desk.person.widget("Weight of")
    with pytest.raises(CommandError, match="cannot change while a run goes on"):
        after(SetParameter("learner.weights.approach", 2.0))


def test_a_skill_of_ones_own_may_see_where_the_prey_looks(server: viser.ViserServer) -> None:
    desk = Desk(server.gui, after())
    desk.person.fill("When the prey flees as a number", -50)
    desk.person.send(desk.person.widget("Sees where the prey looks"), True)
    desk.person.send(desk.person.widget("Own skill"), "wary")
    desk.person.click("Add my own skill now")
    wary = SkillWeights(flight=-50.0, sees="prey_heading")
    assert desk.requests[0] == DefineSkill("wary", wary)
    run = after(DefineSkill("wary", wary), Introduce("wary", 0))
    run.advance(max_steps=1_000)
    assert run.step == 1_000
