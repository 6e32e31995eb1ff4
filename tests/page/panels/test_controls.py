"""The controls that all browsers share, on a real server that nobody looks at."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import pytest
import viser

from app.documents import presets
from app.live import snapshot
from app.live.session import Request, Session, SetSpeed, StartAgain, Status
from app.live.worker import FULL_SPEED
from app.page import widgets
from app.page.panels.controls import MOST_LOADED, Controls, speed_label
from app.server.server import close_server, open_server
from app.words.plain import plain
from learners.commands import FreezeSelection
from learners.run import Run
from learners.spec import RunSpec
from sim.rng import MAX_SEED
from tests.support.person import Person


def spec_of(name: str = "timed") -> RunSpec:
    """A preset in a small world."""
    return presets.load(name, ["world.size=40"])


ALL_SKILLS = ("approach", "circle clockwise", "avoid")
OFFERED = {name: spec_of(name) for name in ("timed", "hierarchical_2")}


class Desk:
    """The panel over a session whose worker has not been started, and somebody before it."""

    def __init__(self, gui: viser.GuiApi, seed: int = 3) -> None:
        session = Session(spec_of(), "timed", seed, speed=100.0, playing=False)
        self.status = session.status
        self.requests: list[Request] = []
        self.controls = Controls(gui, session, OFFERED, self.ask)
        self.person = Person(gui)

    def ask(self, client: Any, request: Request) -> None:
        assert client is self.person
        self.requests.append(request)

    def show_run(self, number: int, preset: str, seed: int = 3, **changes: Any) -> None:
        """Show the moment at which another run has begun."""
        self.controls.update(replace(of_run(self.status, number, preset, seed), **changes))


DeskOf = Callable[..., Desk]


@pytest.fixture
def desk_of() -> Iterator[DeskOf]:
    server = open_server(port=0)
    yield lambda seed=3: Desk(server.gui, seed)
    close_server(server)


@pytest.fixture
def desk(desk_of: DeskOf) -> Desk:
    return desk_of()


def of_run(status: Status, number: int, preset: str, seed: int = 3) -> Status:
    """The status once another run has begun."""
    parts = {"generation": number, "preset": preset, "seed": seed}
    return replace(status, snapshot=replace(status.snapshot, **parts))


# Seeds


@pytest.mark.parametrize("seed", [9_999_999_999, 2**53 + 1, MAX_SEED])
def test_large_seeds_are_shown_and_started_again(desk_of: DeskOf, seed: int) -> None:
    desk = desk_of(seed)
    desk.person.click("Start again")
    desk.show_run(1, "an experiment: a run", seed - 1)
    desk.person.click("Start again")
    assert desk.requests == [
        StartAgain(spec_of(), "timed", seed),
        StartAgain(spec_of(), "an experiment: a run", seed - 1),
    ]


def test_nothing_starts_again_with_a_wrong_seed(desk: Desk) -> None:
    desk.person.type("Seed", "seven")
    desk.person.click("Start again")
    assert desk.requests == []
    assert desk.person.told[0].startswith("Seed: 'seven' is not taken: ")


# Speed


@pytest.mark.parametrize(
    ("speed", "label"),
    [
        (1.0, "1 step/s"),
        (2.0, "2 steps/s"),
        (6_309.6, "6,310 steps/s"),
        (19_953.0, "20 k steps/s"),
        (1e6, "1 M steps/s"),
        (10**6.9, "7.94 M steps/s"),
        (FULL_SPEED, "Full speed"),
    ],
)
def test_a_speed_is_said_in_steps_per_second(speed: float, label: str) -> None:
    assert speed_label(speed) == label


# The way back from a run of an experiment


def test_what_was_opened_and_the_way_back_stand_there_as_long_as_there_is_one(desk: Desk) -> None:
    person = desk.person
    assert not person.reads("On the board")
    desk.show_run(1, "figure_4_1: <b>", 7, aside="timed, trial 1,234")
    assert person.sees("Back to timed, trial 1,234")
    assert person.reads("On the board: figure_4_1: <b>, seed 7, a run of an experiment.")
    desk.show_run(2, "timed")
    assert not person.reads("On the board")
    assert not person.reads("Back to")


# Presets


def test_the_list_of_presets_keeps_the_shipped_ones_and_the_latest_others(desk: Desk) -> None:
    for number in range(1, 3 * MOST_LOADED):
        desk.show_run(number, f"run {number}")
        assert desk.person.value("Preset") == f"run {number}"
    last = 3 * MOST_LOADED - 1
    latest = [f"run {number}" for number in range(last - MOST_LOADED + 1, last + 1)]
    assert desk.person.options("Preset") == [*OFFERED, *latest]


def test_a_preset_that_is_taken_up_again_stays_longest(desk: Desk) -> None:
    desk.show_run(1, "mine")
    for number in range(2, 3 * MOST_LOADED, 2):
        desk.show_run(number, f"run {number}")
        desk.show_run(number + 1, "mine")
    assert "mine" in desk.person.options("Preset")


# What is true, and what somebody wants


def test_a_slider_and_a_box_are_asked_for_and_then_show_what_is_true(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk.person.move("100 steps/s", 3.0)
    desk.person.check("Freeze selection")
    assert desk.requests == [SetSpeed(1_000.0), FreezeSelection(True)]
    desk.controls.update(desk.status)
    assert desk.person.value("Freeze selection"), "a slider might still be in somebody's hand"
    monkeypatch.setattr(widgets, "TOUCHED_S", -1.0)
    desk.controls.update(desk.status)
    assert not desk.person.value("Freeze selection")
    assert desk.person.value("100 steps/s") == 2.0


# Skills


def test_only_a_skill_that_has_joined_can_be_explored(desk: Desk) -> None:
    assert desk.person.options("Explore a skill > Skill") == ["approach"]
    absent = replace(desk.status, snapshot=replace(desk.status.snapshot, present=()))
    desk.controls.update(absent)
    assert not desk.person.can_use("Start exploring")
    desk.person.press("Explore the chosen skill")
    assert desk.requests == []
    assert desk.person.told == ["a skill must have joined before it can be explored"]


def test_rows_of_skills_follow_the_run_and_no_widget_is_removed(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A page that takes an update and a removal at once removes first, and misses what to update.
    sent: list[str] = []
    pages: Any = desk.person.gui._websock_interface
    queue = pages.queue_message

    def noted(message: Any) -> None:
        sent.append(type(message).__name__)
        queue(message)

    monkeypatch.setattr(pages, "queue_message", noted)
    for number, (preset, absent) in enumerate(
        [("standard_q", []), ("timed", ["circle clockwise", "avoid"]), ("hierarchical_2", [])], 1
    ):
        moment = snapshot.take(Run(spec_of(preset), 3), preset, number)
        desk.controls.update(replace(desk.status, snapshot=moment))
        skills = [plain(skill) for skill in moment.spec.learner.skills]
        offered = [skill for skill in ALL_SKILLS if desk.person.sees(f"Add {skill} now")]
        assert offered == absent
        assert [skill for skill in ALL_SKILLS if desk.person.reads(f"{skill}: ")] == skills
    assert "GuiUpdateMessage" in sent
    assert "GuiRemoveMessage" not in sent


def test_where_nothing_is_explored_nothing_can_be_stopped(desk: Desk) -> None:
    assert not desk.person.reads("Stop exploring")
    assert desk.person.reads("Nothing is being explored.")
