"""Steering while it learns, on a real server that nobody looks at."""

import math
from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
import viser

from app.documents import presets
from app.live import snapshot
from app.live.session import Request, Session, Status
from app.page.panels.steering import DEFAULT_FREEZE_TRIALS, SLIDERS, Steering, introduction_of
from app.server.callbacks import RefusedError
from app.server.server import close_server, open_server
from app.words.plain import PARAMETER_NAMES
from learners.commands import (
    Command,
    DefineSkill,
    Explore,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Remove,
    SetParameter,
    Undo,
)
from learners.run import Run
from learners.spec import MAX_TRIALS, SkillWeights

NOBODY: Any = SimpleNamespace(client=None)
"""An event of no browser."""
OWN = SkillWeights(approach=1.0)


def run_of(*settings: str) -> Run:
    return Run(presets.load("timed", ["world.size=40", *settings]), seed=1)


class Desk:
    """The panel over a run, and what it has asked for."""

    def __init__(self, gui: viser.GuiApi, run: Run) -> None:
        session = Session(run.preset, "timed", 1, speed=100.0, playing=False)
        taken = snapshot.take(run, "timed", 0)
        status = replace(session.status, snapshot=taken)
        self.requests: list[Request] = []
        seen: Any = SimpleNamespace(status=status)
        self.steering = Steering(gui, seen, self.ask)
        self.status: Status = status
        self.steering.update(status)

    def ask(self, event: object, request: Request) -> int:
        self.requests.append(request)
        return len(self.requests)

    def define(self, name: str) -> None:
        self.steering._name.value = name
        self.steering._weights["avoid"].field.put(1.0)
        self.steering._define_clicked(NOBODY)


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
    with pytest.raises(RefusedError, match="there is a skill named 'mine'"):
        desk.define("mine")
    assert desk.requests == []


@pytest.mark.parametrize("name", ["", "Mine", "1st", "my skill", "a" * 33, "mine\n", "<b>"])
def test_what_is_no_name_is_refused_with_what_is_allowed(
    server: viser.ViserServer, name: str
) -> None:
    desk = Desk(server.gui, after())
    with pytest.raises(RefusedError, match="allowed: a name of up to 32 characters"):
        desk.define(name)
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
    assert "circle counterclockwise" in desk.steering._other.options
    desk.steering._other.value = "circle counterclockwise"
    desk.steering._add_other_clicked(NOBODY)
    desk.steering._other.value = "avoid"
    desk.steering._add_other_clicked(NOBODY)
    assert desk.requests == [
        Introduce("circle_counterclockwise", DEFAULT_FREEZE_TRIALS),
        Introduce("avoid", 20),
    ]


# Sliders


def test_a_slider_is_asked_for_once_it_has_come_to_rest(server: viser.ViserServer) -> None:
    desk = Desk(server.gui, after())
    moved = desk.steering._mover("learner.alpha")
    moved(NOBODY, 0.3)
    moved(NOBODY, 0.4)
    desk.steering.settle(-math.inf)
    assert desk.requests == []
    desk.steering.settle(math.inf)
    desk.steering.settle(math.inf)
    assert desk.requests == [SetParameter("learner.alpha", 0.4)]


def test_what_a_slider_is_set_to_while_it_is_asked_for_is_not_lost(
    server: viser.ViserServer,
) -> None:
    desk = Desk(server.gui, after())
    moved = desk.steering._mover("learner.alpha")

    def ask(event: object, request: Request) -> int:
        if not desk.requests:
            moved(NOBODY, 0.7)
        return desk.ask(event, request)

    desk.steering._ask = ask
    moved(NOBODY, 0.3)
    desk.steering.settle(math.inf)
    desk.steering.settle(math.inf)
    assert desk.requests == [
        SetParameter("learner.alpha", 0.3),
        SetParameter("learner.alpha", 0.7),
    ]


def test_a_slider_and_its_number_show_what_is_true(server: viser.ViserServer) -> None:
    desk = Desk(server.gui, after(SetParameter("learner.alpha", 0.123)))
    dial = desk.steering._dials["learner.alpha"]
    assert dial.field.handle.value == "0.123"
    assert dial._slider.value == pytest.approx(0.123, abs=0.01)
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
    assert list(desk.steering._chosen.options) == [
        "4: selection frozen",
        "3: approach explored at 50%",
        "1: α of skills = 0.3",
    ]
    assert "2: skills frozen, trial 10" in desk.steering._changes.content
    desk.steering._chosen.value = "3: approach explored at 50%"
    desk.steering._undo_clicked(NOBODY)
    (undo,) = desk.requests
    assert isinstance(undo, Undo)
    assert run.control.history[undo.number].command == Explore("approach", 100, 0.5)
