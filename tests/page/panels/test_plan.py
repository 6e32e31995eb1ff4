"""The tab in which the schedule is changed, as far as it needs no browser."""

from collections.abc import Callable, Iterator

import pytest
import viser

from app.documents import presets
from app.live import snapshot
from app.live.requests import Request, StartAgain, TrialOnce
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page.panels import plan
from app.page.panels.plan import PlanPanel
from app.schedule import blocks
from app.server.server import close_server, open_server
from learners.commands import FollowSchedule, FreezeSkills, SetSchedule
from learners.run import Run
from learners.spec import RunSpec
from tests.support.person import Person

SMALL = (
    "world.size=30",
    "world.n_directions=16",
    "world.n_distances=6",
    "world.step_limit=40",
    "trials=9000",
    "schedule.skills.circle_clockwise={at: 3000, freeze: 20}",
    "schedule.skills.avoid={at: 6000, freeze: 20}",
    "schedule.episodes=[{skill: circle_clockwise, duration: 500, probability: 0.95},"
    " {skill: circle_clockwise, at: 4000, duration: 100, probability: 0.5}]",
)


def small_spec(*settings: str) -> RunSpec:
    return presets.load("timed", [*SMALL, *settings])


# --- What the widgets are to show ----------------------------------------------------------------


def moment(trial: int, act: Callable[[Run], None] = lambda _: None) -> Snapshot:
    run = Run(small_spec(), 3)
    run.advance(until_trial=trial)
    act(run)
    return snapshot.take(run, "timed", 0)


def choices(shot: Snapshot) -> dict[str, str]:
    return plan.choices_of(blocks.blocks_of(shot), shot)


def form(chosen: str, shot: Snapshot) -> plan.Form:
    return plan.form_of(chosen, blocks.blocks_of(shot), shot)


CIRCLE = "introduction:circle_clockwise"


def test_only_what_lies_ahead_can_be_chosen_and_new_explorations() -> None:
    new = {
        "approach: new exploration": "new:approach",
        "circle clockwise: new exploration": "new:circle_clockwise",
        "avoid: new exploration": "new:avoid",
    }
    assert choices(moment(0)) == {
        "– nothing –": "",
        "circle clockwise: joins": CIRCLE,
        "circle clockwise: exploration 1": "episode:0:circle_clockwise",
        "circle clockwise: exploration 2": "episode:1:circle_clockwise",
        "avoid: joins": "introduction:avoid",
        **new,
    }
    assert choices(moment(3_100)) == {
        "– nothing –": "",
        "circle clockwise: exploration": "episode:1:circle_clockwise",
        "avoid: joins": "introduction:avoid",
        **new,
    }


def test_an_introduction_can_be_moved_and_not_deleted() -> None:
    shown = form(CIRCLE, moment(0))
    assert (shown.at, shown.trials, shown.trials_label) == (3_000, 20, "Freeze")
    assert (shown.movable, shown.editable) == (True, True)
    assert (shown.deletable, shown.explores) == (False, False)
    assert "not deleted" in shown.caption


def test_an_exploration_can_be_changed_and_deleted() -> None:
    shown = form("episode:1:circle_clockwise", moment(0))
    assert (shown.at, shown.trials, shown.probability) == (4_000, 100, 0.5)
    assert (shown.movable, shown.deletable, shown.explores) == (True, True, True)


def test_what_has_begun_can_not_be_chosen_any_more() -> None:
    shown = form(CIRCLE, moment(3_000))
    assert shown.chosen == ""
    assert {shown.movable, shown.editable, shown.deletable} == {False}
    assert "has begun" in shown.caption


def test_a_new_exploration_is_proposed_for_when_the_skill_is_there() -> None:
    assert form("new:approach", moment(0)).at == 1_000
    assert form("new:approach", moment(1_234)).at == 2_300
    avoid = form("new:avoid", moment(0))
    assert (avoid.at, avoid.is_new, avoid.editable, avoid.movable) == (6_000, True, True, False)


def test_a_skill_that_will_not_join_cannot_be_explored() -> None:
    shown = form("new:avoid", moment(0, lambda run: run.apply(FollowSchedule(False))))
    assert not shown.editable
    assert "not going to join" in shown.caption


def test_every_case_says_what_to_do_or_why_nothing_can_be_done() -> None:
    assert "Choose" in form("", moment(0)).caption
    assert "past" in form("", moment(6_001)).caption
    off = moment(0, lambda run: run.apply(FollowSchedule(False)))
    assert "not followed" in form("", off).caption
    moves = snapshot.take(Run(presets.load("standard_q", ["world.size=30"]), 1), "q", 0)
    assert "nothing to plan" in form("", moves).caption
    assert choices(moves) == {"– nothing –": ""}


# --- The panel, on a real server that nobody looks at --------------------------------------------


class Desk:
    """The panel of a paused session, and somebody before it."""

    def __init__(self, server: viser.ViserServer) -> None:
        self.requests: list[Request] = []
        self.session = Session(small_spec(), "timed", 3, speed=1.0, playing=False)
        self.session.start()
        self.person = Person(server.gui)
        self.panel = PlanPanel(
            server.gui, self.ask, lambda _: self.session.status, self.session.status
        )

    def ask(self, client: object, request: Request) -> None:
        assert client is self.person
        self.requests.append(request)
        self.session.submit(request, self.person.told.append)

    def settle(self) -> Status:
        """Wait until all has been answered, and show it."""
        ticket = self.session.submit(FreezeSkills(False))
        status = self.session.wait_for(lambda status: status.answered >= ticket, 60)
        self.panel.update(status)
        return status

    def choose(self, label: str) -> None:
        self.person.choose("Change", label)
        self.settle()

    def number(self, label: str) -> float:
        """What stands in a field."""
        return float(self.person.value(label).replace(",", ""))

    @property
    def at(self) -> int:
        """Trial in which circling is to join."""
        return self.settle().snapshot.spec.schedule.introduced_at("circle_clockwise")


@pytest.fixture
def desk() -> Iterator[Desk]:
    server = open_server(port=0)
    desk = Desk(server)
    yield desk
    desk.session.stop()
    close_server(server)


def test_two_clicks_move_a_block(desk: Desk) -> None:
    desk.choose("circle clockwise: joins")
    desk.person.click("\N{MINUS SIGN}500")
    assert desk.at == 2_500
    assert desk.number("At trial") == 2_500
    assert desk.person.told == []


def test_the_render_loop_does_not_undo_a_choice(desk: Desk) -> None:
    status = desk.settle()
    desk.person.choose("Change", "avoid: joins")
    desk.panel.update(status)
    assert desk.person.value("Change") == "avoid: joins"
    assert desk.number("At trial") == 6_000


def test_a_click_right_after_a_choice_is_about_what_was_chosen(desk: Desk) -> None:
    desk.choose("avoid: joins")
    desk.person.choose("Change", "circle clockwise: joins")
    desk.person.click("+100")
    assert desk.at == 3_100


def test_clicks_in_quick_succession_add_up(desk: Desk) -> None:
    desk.choose("circle clockwise: joins")
    for _ in range(3):
        desk.person.click("\N{MINUS SIGN}100")
    assert desk.at == 2_700


def test_a_refused_edit_is_told_and_changes_nothing(desk: Desk) -> None:
    desk.choose("circle clockwise: exploration 2")
    desk.person.type("At trial", "3100")
    desk.settle()
    desk.person.click("Apply")
    assert "overlap" in desk.person.told[0]
    assert desk.requests == []
    # What was typed stays, so that it can be mended.
    desk.settle()
    assert desk.number("At trial") == 3_100


def test_fields_are_applied_together(desk: Desk) -> None:
    desk.choose("circle clockwise: exploration 2")
    desk.settle()
    assert not desk.person.can_use("Apply")
    desk.person.type("At trial", "5000")
    desk.person.type("Lasts", "250")
    desk.person.type("Probability", "0.75")
    desk.settle()
    desk.person.click("Apply")
    episode = desk.settle().snapshot.spec.schedule.episodes[1]
    assert (episode.at, episode.duration, episode.probability) == (5_000, 250, 0.75)
    assert not desk.person.can_use("Apply")


def test_an_exploration_is_added_chosen_and_deleted(desk: Desk) -> None:
    desk.choose("approach: new exploration")
    desk.person.type("At trial", "7000")
    desk.person.click("Add")
    status = desk.settle()
    assert status.snapshot.spec.schedule.episodes[-1].at == 7_000
    assert desk.person.value("Change") == "approach: exploration"
    desk.person.click("Delete")
    status = desk.settle()
    assert len(status.snapshot.spec.schedule.episodes) == 2
    assert desk.person.value("Change") == "– nothing –"
    assert all(isinstance(request, SetSchedule) for request in desk.requests)


def test_what_cannot_be_done_is_not_offered(desk: Desk) -> None:
    person = desk.person
    desk.settle()
    for label in ("Earlier", "Later", "At trial", "Lasts", "Probability", "Apply", "Delete"):
        assert not person.sees(label)
    assert person.reads("The past is locked")
    desk.choose("avoid: joins")
    for label in ("Earlier", "Later", "At trial", "Freeze"):
        assert person.can_use(label)
    for label in ("Probability", "Delete"):
        assert not person.sees(label)


def test_a_block_that_begins_is_let_go(desk: Desk) -> None:
    desk.choose("circle clockwise: joins")
    desk.person.type("At trial", "1")
    desk.settle()
    desk.person.click("Apply")
    desk.session.submit(TrialOnce())
    desk.settle()
    assert desk.person.value("Change") == "– nothing –"
    assert desk.person.reads("has begun")


def test_a_block_is_chosen_by_a_click_on_the_bar_if_it_lies_ahead(desk: Desk) -> None:
    desk.panel.choose("introduction:avoid")
    desk.settle()
    assert desk.person.value("Change") == "avoid: joins"
    assert desk.number("At trial") == 6_000
    for nothing in ("event:0", "introduction:approach", "episode:9:avoid", "", "<b>"):
        desk.panel.choose(nothing)
        desk.settle()
        assert desk.panel.chosen == "introduction:avoid"


def test_a_trial_that_the_run_is_not_to_have_is_taken_with_a_word(desk: Desk) -> None:
    word = "Trial 60,000 is after the run's last, 9,000: it happens only if the run goes on."
    desk.choose("avoid: joins")
    desk.person.type("At trial", "60000")
    desk.settle()
    assert desk.person.reads(word)
    desk.person.click("Apply")
    assert desk.settle().snapshot.spec.schedule.introduced_at("avoid") == 60_000
    assert desk.person.reads(word)
    desk.choose("circle clockwise: joins")
    assert not desk.person.reads("after the run's last")


def test_another_run_starts_with_nothing_chosen(desk: Desk) -> None:
    desk.choose("avoid: joins")
    desk.session.submit(StartAgain(small_spec(), "timed", 4))
    desk.settle()
    assert desk.person.value("Change") == "– nothing –"
