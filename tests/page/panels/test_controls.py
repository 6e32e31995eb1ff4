"""The controls that all browsers share, on a real server that nobody looks at."""

import math
import re
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
import viser

from app.charts.bar.rule import outlook_in_words
from app.documents import presets
from app.live import snapshot
from app.live.held import Opened
from app.live.places import Behind, LineSeen
from app.live.requests import (
    GoBack,
    GoOn,
    MakeLive,
    Pause,
    PauseAtJoins,
    Play,
    Request,
    RunTo,
    SetSpeed,
    StartAgain,
)
from app.live.session import Session
from app.live.status import Status
from app.live.worker import FULL_SPEED
from app.page import number_field, widgets
from app.page.panels.controls import Controls, skill_state
from app.page.panels.start_again import MOST_LOADED
from app.page.panels.transport import slider_of, speed_label, speed_of
from app.server.server import close_server, open_server
from app.words.plain import plain
from learners.commands import (
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    SetParameter,
    SetSchedule,
    Undo,
)
from learners.run import Run
from learners.schedule_spec import ScheduleSpec, SkillTimer
from learners.spec import RunSpec
from sim.rng import MAX_SEED
from tests.support.person import Person
from tests.support.schedules import ruled_spec


def spec_of(name: str = "timed") -> RunSpec:
    """A preset in a small world."""
    return presets.load(name, ["world.size=40"])


ALL_SKILLS = ("approach", "circle clockwise", "avoid")
OFFERED = {name: spec_of(name) for name in ("timed", "hierarchical_2")}


class Desk:
    """The panel over what stands for a session, and somebody before it."""

    def __init__(self, gui: viser.GuiApi, seed: int = 3) -> None:
        status = Session(spec_of(), "timed", seed, speed=100.0, playing=False).status
        self.session: Any = SimpleNamespace(status=status)
        self.status: Status = status
        self.requests: list[Request] = []
        self.elsewhere: Status | None = None
        """What is true for the browser, if that looks at another moment than these controls."""
        self.controls = Controls(gui, OFFERED, self.ask, self.status_of, status)
        self.person = Person(gui)

    def ask(self, client: Any, request: Request) -> None:
        assert client is self.person
        self.requests.append(request)

    def status_of(self, client: Any) -> Status:
        assert client is self.person
        return self.elsewhere or self.session.status

    def show(self, run: Run, generation: int = 0, **changes: Any) -> None:
        """Show the moment at which a run stands."""
        taken = snapshot.take(run, "timed", generation)
        self.status = replace(self.status, snapshot=taken, **changes)
        self.session.status = self.status
        self.controls.update(self.status)

    def show_run(self, number: int, preset: str, seed: int = 3, **changes: Any) -> None:
        """Show the moment at which another run has begun."""
        self.session.status = replace(of_run(self.status, number, preset, seed), **changes)
        self.controls.update(self.session.status)


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
        (12.5, "12.5 steps/s"),
        (1_250.0, "1.25 k steps/s"),
        (2_000.0, "2 k steps/s"),
        (20_000.0, "20 k steps/s"),
        (1e6, "1 M steps/s"),
        (6.3e6, "6.3 M steps/s"),
        (FULL_SPEED, "Full speed"),
    ],
)
def test_a_speed_is_said_in_steps_per_second(speed: float, label: str) -> None:
    assert speed_label(speed) == label


def test_all_places_of_the_slider_are_round_speeds_and_found_again() -> None:
    places = [tenth / 10 for tenth in range(71)]
    assert [slider_of(speed_of(place)) for place in places] == places
    assert all(len(speed_label(speed_of(place))) <= len("1.25 k steps/s") for place in places)
    assert speed_of(4.3) == 20_000.0


# The way back from a run of an experiment


def test_what_was_opened_and_the_way_back_stand_there_as_long_as_there_is_one(desk: Desk) -> None:
    person = desk.person
    assert not person.reads("On the board")
    copy = Opened("figure_4_1: <b>, seed 7", 500, "f" * 64, same=True, found="f" * 64)
    desk.show_run(1, "figure_4_1: <b>", 7, aside="timed, trial 1,234", opened=copy, is_own=False)
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


def test_a_preset_that_was_saved_or_loaded_is_in_the_list_at_once(desk: Desk) -> None:
    desk.controls.offer_preset("mine", spec_of("hierarchical_2"))
    assert desk.person.value("Preset") == "timed"
    desk.person.choose("Preset", "mine")
    desk.person.click("Start again")
    assert desk.requests == [StartAgain(spec_of("hierarchical_2"), "mine", 3)]


# The schedule that was drawn


def edited(run: Run) -> ScheduleSpec:
    """The schedule of a run, with avoid at another trial."""
    avoid = {"avoid": SkillTimer(at=2_000, freeze=7)}
    return run.spec.schedule.model_copy(update={"skills": run.spec.schedule.skills | avoid})


def test_a_schedule_that_was_drawn_is_kept_unless_the_presets_own_is_wanted(desk: Desk) -> None:
    assert not desk.person.sees("Keep the drawn schedule")
    run = Run(spec_of(), 3)
    drawn = edited(run)
    run.apply(SetSchedule(drawn))
    desk.show(run)
    assert desk.person.value("Keep the drawn schedule")
    desk.person.click("Start again")
    desk.person.check("Keep the drawn schedule", False)
    desk.person.click("Start again")
    desk.person.choose("Preset", "hierarchical_2")
    desk.controls.update(desk.status)
    assert not desk.person.sees("Keep the drawn schedule")
    desk.person.click("Start again")
    assert desk.requests == [
        StartAgain(spec_of(), "timed", 3, drawn),
        StartAgain(spec_of(), "timed", 3),
        StartAgain(spec_of("hierarchical_2"), "hierarchical_2", 3),
    ]


def test_plans_for_a_skill_that_the_preset_does_not_have_stay_with_this_run(desk: Desk) -> None:
    run = Run(spec_of(), 3)
    run.apply(Introduce("circle_counterclockwise", 5))
    desk.show(run)
    assert not desk.person.sees("Keep the drawn schedule")
    drawn = edited(run)
    run.apply(SetSchedule(drawn))
    desk.show(run)
    desk.person.click("Start again")
    (request,) = desk.requests
    assert isinstance(request, StartAgain)
    assert request.schedule == edited(Run(spec_of(), 3))


# The end of a run


def test_space_at_the_end_does_nothing_but_say_so(desk: Desk) -> None:
    desk.show(Run(spec_of(), 3), finished=True)
    desk.person.press("Pause or play")
    assert desk.requests == []
    assert "trials are over" in desk.person.told[0]
    assert not desk.person.can_use("The 0 trials are over")
    desk.person.click(f"Go on for {spec_of().trials:,} trials more")
    assert desk.requests == [GoOn()]
    desk.show(Run(spec_of(), 3), finished=True, exhausted=True)
    assert not desk.person.reads("Go on for")


def test_space_plays_and_pauses(desk: Desk) -> None:
    desk.person.press("Pause or play")
    desk.show(Run(spec_of(), 3), playing=True)
    desk.person.press("Pause or play")
    assert desk.requests == [Play(), Pause()]


# What was just done


def said(desk: Desk) -> str:
    """What the board says of it, its button included."""
    slot = re.search(r'<template data-slot="said">(.*?)</template>', desk.person.html)
    assert slot is not None
    return " ".join(re.findall(r"[^<>]+(?=<)", slot[1]))


def test_what_was_done_by_hand_is_said_with_its_undo(desk: Desk) -> None:
    run = Run(spec_of(), 3)
    for command, words in [
        (Introduce("circle_clockwise", 5), "Circle clockwise added at trial 0 Undo"),
        (SetParameter("learner.alpha", 0.3), "α of selection = 0.3 at trial 0 Undo"),
        (FreezeSelection(True), "Selection frozen at trial 0 Undo"),
        (Explore("approach", 50, 0.5), "Approach explored at 50% at trial 0 Undo"),
    ]:
        run.apply(command)
        desk.show(run)
        assert said(desk) == words
        desk.person.press("Undo what was just done by hand")
        by_hand = [event for event in run.control.history if event.author == "hand"]
        assert desk.requests.pop() == Undo(by_hand[-1].number)


def test_undo_takes_back_what_was_done_since_the_last_frame(desk: Desk) -> None:
    run = Run(spec_of(), 3)
    run.apply(FreezeSelection(True))
    desk.show(run)
    run.apply(Explore("approach", 50, 0.5))
    newest = snapshot.take(run, "timed", 0)
    desk.session.status = replace(desk.status, snapshot=newest)
    desk.person.press("Undo what was just done by hand")
    assert desk.requests == [Undo(run.control.history[-1].number)]


def test_what_was_undone_offers_to_undo_the_change_before(desk: Desk) -> None:
    run = Run(spec_of(), 3)
    run.apply(FreezeSelection(True))
    run.apply(Explore("approach", 50, 0.5))
    run.apply(Undo(run.control.history[-1].number))
    desk.show(run)
    assert said(desk) == "Undone: approach explored at 50% Undo too: selection frozen"
    desk.person.press("Undo what was just done by hand")
    (before,) = desk.requests
    assert isinstance(before, Undo)
    run.apply(before)
    desk.show(run)
    assert said(desk) == "Undone: selection frozen"
    desk.requests.clear()
    desk.person.press("Undo what was just done by hand")
    assert desk.requests == []
    assert desk.person.told == ["there is nothing else to take back"]


def test_what_the_schedule_does_is_not_said(desk: Desk) -> None:
    run = Run(presets.load("timed", ["world.size=40", "schedule.skills.avoid.at=5"]), 3)
    desk.show(run, generation=0)
    run.advance(until_trial=6)
    desk.show(run, generation=0)
    assert "avoid" in run.present
    assert said(desk) == ""


def test_what_was_said_is_gone_after_a_while_and_can_no_longer_be_undone(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = Run(spec_of(), 3)
    run.apply(FreezeSelection(True))
    desk.show(run)
    monkeypatch.setattr(time, "monotonic", lambda: math.inf)
    desk.controls.update(desk.status)
    assert said(desk) == ""
    desk.person.press("Undo what was just done by hand")
    assert desk.requests == []
    assert desk.person.told == [
        "nothing was done just now; Steer lists all changes by hand, and Run has the way"
        " back to the run before"
    ]


def test_another_run_on_the_board_is_said_with_the_way_back(desk: Desk) -> None:
    desk.show_run(1, "timed", 4, aside="timed, trial 12")
    assert said(desk) == "Started again: timed, seed 4 Back to timed, trial 12"
    desk.person.press("Undo what was just done by hand")
    assert desk.requests == [GoBack()]
    desk.show_run(0, "timed", 3, aside="timed, trial 0")
    assert said(desk) == "Back to your run, timed, seed 3, trial 0"
    copy = Opened("figure_4_1: <b>, seed 7", 500, "f" * 64, same=None)
    desk.show_run(2, "figure_4_1: <b>", 7, aside="timed, trial 12", opened=copy, is_own=False)
    assert said(desk).startswith("Opened: figure_4_1: &lt;b&gt;, seed 7 Back to timed")
    desk.show_run(1_003, "timed", 5, aside="timed, trial 12", is_resumed=True)
    assert said(desk) == "Resumed: your run, timed, seed 5, trial 0 Back to timed, trial 12"


def test_of_a_run_that_is_back_and_changed_at_once_the_change_is_said(desk: Desk) -> None:
    desk.show_run(1, "timed", 4, aside="timed, trial 0")
    run = Run(spec_of(), 3)
    run.apply(FreezeSelection(True))
    desk.show(run, generation=0, aside="timed, trial 0")
    assert said(desk) == "Selection frozen at trial 0 Undo"


def line(number: int, name: str, parent: int | None, is_live: bool) -> LineSeen:
    """A line of a tree."""
    return LineSeen(number, parent, 0, 0, name, 10, 1, 0.0, "", is_live)


def test_a_branch_that_is_made_live_is_said_with_the_way_back(desk: Desk) -> None:
    lines = (line(0, "first run", None, False), line(4, "no <b>avoid</b>", 0, True))
    desk.show_run(4, "timed", lines=lines, aside="timed, trial 12")
    assert said(desk) == "Live now: no &lt;b&gt;avoid&lt;/b&gt;, trial 0 Make first run live again"
    desk.person.press("Undo what was just done by hand")
    assert desk.requests == [MakeLive(0)]


def test_what_is_shown_of_the_past_is_not_said_to_have_been_done_now(desk: Desk) -> None:
    run = Run(spec_of(), 3)
    run.apply(FreezeSelection(True))
    for behind in (Behind("", 3, 200), Behind("no avoid", -1, -60)):
        desk.show(run, generation=len(behind.branch), behind=behind)
        assert said(desk) == ""
    desk.show(run, behind=None)
    assert said(desk) == "Selection frozen at trial 0 Undo"


def test_undo_in_the_past_takes_back_what_was_done_at_that_very_moment(desk: Desk) -> None:
    run = Run(spec_of(), 3)
    run.advance(max_steps=100)
    run.apply(FreezeSelection(True))
    desk.show(run, behind=Behind("selection frozen", 3, 200))
    desk.person.press("Undo what was just done by hand")
    assert desk.requests == [Undo(run.control.history[-1].number)]
    run.advance(max_steps=1)
    desk.show(run)
    desk.person.press("Undo what was just done by hand")
    assert len(desk.requests) == 1
    assert desk.person.told[-1].startswith("nothing was done by hand at this moment")


# The past


def test_in_the_past_the_controls_say_so_and_play_it(desk: Desk) -> None:
    run = Run(spec_of(), 3)
    run.advance(until_trial=20)
    desk.show(run, behind=Behind("", 300, 20_000), playing=False)
    assert desk.person.reads("These controls show the past, trial 20. What is changed here makes a")
    assert desk.person.sees("Live run: 100 steps/s")
    desk.person.click("Play the past")
    desk.show(run, playing=True)
    desk.person.click("Pause the past")
    assert desk.requests == [Play(), Pause()]
    desk.show(run, behind=Behind("no <b>avoid</b>", 300, 20_000), playing=False)
    assert desk.person.sees("Play the branch")
    assert desk.person.reads("These controls show no <b>avoid</b>, trial 20.")
    desk.show(run, behind=None)
    assert desk.person.sees("Play")
    assert not desk.person.reads("These controls show")


def test_of_several_browsers_each_acts_at_the_moment_that_it_looks_at(desk: Desk) -> None:
    now, then = Run(spec_of(), 3), Run(spec_of(), 3)
    now.apply(Introduce("circle_clockwise", 0))
    now.apply(FreezeSelection(True))
    desk.show(now, playing=True)
    desk.controls.update(desk.status, elsewhere=1)
    assert desk.person.reads("These controls show the live run. 1 browser looks at another moment")
    desk.controls.update(desk.status, elsewhere=2)
    assert desk.person.reads("2 browsers look at another moment; there, Play plays what is looked")
    past = snapshot.take(then, "timed", 0)
    desk.elsewhere = replace(desk.status, snapshot=past, behind=Behind("", 9, 90), playing=False)
    for command in (
        "Add the next skill",
        "Freeze the selection, or let it learn",
        "Pause or play",
    ):
        desk.person.press(command)
    assert desk.requests == [Introduce("circle_clockwise", 300), FreezeSelection(True), Play()]
    desk.elsewhere = None
    desk.requests.clear()
    desk.person.press("Add the next skill")
    desk.person.press("Freeze the selection, or let it learn")
    assert desk.requests == [Introduce("avoid", 300), FreezeSelection(False)]


def test_a_look_at_a_branch_leaves_what_was_set_to_start_again_with(desk: Desk) -> None:
    desk.person.fill("Seed", 77)
    desk.show(Run(spec_of(), 3), generation=5, behind=Behind("no avoid", 3, 200))
    assert desk.person.value("Seed") == "77"
    desk.show(Run(spec_of(), 3), generation=5, behind=None)
    assert desk.person.value("Seed") == "3"


# Where it stands still


def test_it_can_be_sent_to_a_trial_the_next_join_unless_another_is_typed(desk: Desk) -> None:
    assert desk.person.value("Run to trial") == "12,000"
    desk.person.click("Run to it, and pause")
    desk.person.fill("Run to trial", "13 900")
    desk.person.click("Run to it, and pause")
    assert desk.requests == [RunTo(12_000), RunTo(13_900)]
    desk.person.type("Run to trial", "soon")
    desk.person.click("Run to it, and pause")
    assert len(desk.requests) == 2
    assert desk.person.told[-1].startswith("Run to trial: 'soon' is ")


def test_the_way_to_a_trial_is_told_and_one_that_is_past_is_not_offered(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(number_field, "TOUCHED_S", -1.0)
    run = Run(presets.load("timed", ["world.size=40", "schedule.skills.avoid.at=5"]), 3)
    desk.show(run)
    # What was offered first can still be had.
    assert desk.person.value("Run to trial") == "12,000"
    desk.person.fill("Run to trial", "5")
    desk.show(run, runs_to=5)
    assert desk.person.sees("On the way to trial 5 …")
    run.advance(until_trial=6)
    desk.show(run, runs_to=None)
    assert desk.person.sees("Run to it, and pause")
    assert desk.person.value("Run to trial") == "12,000"
    over = replace(desk.status.snapshot, trial=60_000)
    desk.controls.update(replace(desk.status, snapshot=over))
    assert desk.person.value("Run to trial") == "60,001"


def test_it_may_pause_where_skills_join(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    desk.person.check("Pause when a skill joins")
    assert desk.requests == [PauseAtJoins(True)]
    monkeypatch.setattr(widgets, "TOUCHED_S", -1.0)
    desk.controls.update(replace(desk.status, pauses_at_joins=True))
    assert desk.person.value("Pause when a skill joins")
    desk.controls.update(desk.status)
    assert not desk.person.value("Pause when a skill joins")


# What is true, and what somebody wants


def test_a_slider_and_a_box_are_asked_for_and_then_show_what_is_true(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk.person.move("100 steps/s", 3.0)
    desk.person.check("Freeze selection")
    assert desk.requests == [SetSpeed(1_000.0), FreezeSelection(True)]
    monkeypatch.setattr(widgets, "TOUCHED_S", math.inf)
    desk.controls.update(desk.status)
    assert desk.person.value("Freeze selection"), "a slider might still be in somebody's hand"
    monkeypatch.setattr(widgets, "TOUCHED_S", -1.0)
    desk.controls.update(desk.status)
    assert not desk.person.value("Freeze selection")
    assert desk.person.value("100 steps/s") == 2.0


# Skills


def test_a_skill_says_how_it_stands(desk: Desk) -> None:
    run = Run(presets.load("timed", ["world.size=40", "schedule.skills.avoid.at=500"]), 3)
    desk.show(run)
    state = skill_state
    assert state(desk.status, "avoid") == "joins at trial 500"
    assert state(desk.status, "approach") == "new, practised until trial 300"
    run.apply(FollowSchedule(False))
    run.apply(FreezeSelection(True))
    run.apply(FreezeSkills(True))
    desk.show(run)
    assert state(desk.status, "avoid") == "not yet: the schedule is not followed"
    assert state(desk.status, "approach") == "active, frozen by hand"


def test_a_skill_that_joins_by_a_rule_says_what_that_sees(desk: Desk) -> None:
    run = Run(ruled_spec("trials=2000"), 5)
    run.advance(until_trial=120)
    desk.show(run)
    outlook = outlook_in_words(desk.status.snapshot.watched[-1])
    assert skill_state(desk.status, "circle_clockwise") == (
        f"joins by its rule, below 0.2: {outlook}"
    )
    assert skill_state(desk.status, "avoid") == "joins by its rule, after circle clockwise"
    run.apply(FollowSchedule(False))
    desk.show(run)
    assert skill_state(desk.status, "avoid") == "not yet: the schedule is not followed"


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


def test_what_a_learner_does_not_have_cannot_be_frozen_or_followed(desk: Desk) -> None:
    boxes = "Freeze selection", "Freeze skills", "Follow schedule"
    for preset, enabled, said in (
        ("timed", [True, True, True], None),
        (
            "standard_q",
            [True, False, False],
            "The options are moves: there are no skills",
        ),
        # What obeys the commands has tables that can be frozen like those of skills.
        ("feudal", [True, True, False], "The options are commands: no skill joins"),
    ):
        desk.show(Run(spec_of(preset), 3))
        assert [desk.person.can_use(box) for box in boxes] == enabled
        for words in ("The options are moves", "The options are commands"):
            assert desk.person.reads(words) == bool(said and said.startswith(words))
        assert said is None or desk.person.reads(said)


def test_where_nothing_is_explored_nothing_can_be_stopped(desk: Desk) -> None:
    assert not desk.person.reads("Stop exploring")
