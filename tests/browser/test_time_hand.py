"""The time bar in a hand: by mouse, by touch and by key; what is asked is what the lab is told.

Places in pixels come from the axis; what is judged is the schedule of the run and the moment that
the browser looks at, as the lab has them.
"""

import itertools
import re
import threading
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import FrameLocator, Locator, Page, expect

from app.live.places import Place
from app.live.requests import SetSpeed
from app.live.status import Status
from app.page.time import messages
from learners.commands import SetSchedule
from learners.schedule_spec import EpisodeSpec, ScheduleSpec
from tests.support.live import PATIENCE_S, LiveLab, until
from tests.support.screen import HAS_HEARD, HEAR, Begin, Screen, Shared, box_of

TRIALS = 4_000
"""Of the whole run, which is the length of the axis."""
HERE = 800
"""The trial at which the live run stands."""
JOINS = 2_000
"""Trial in which circle clockwise joins, and its exploration begins."""
PLAN = (
    f"trials={TRIALS}",
    f"schedule.skills.circle_clockwise.at={JOINS}",
    "schedule.skills.avoid.at=3000",
    "schedule.episodes.0.duration=600",
    "schedule.episodes.1.duration=600",
)
HOLD = JOINS + 420
"""Where a hand takes that exploration, beside its ends, the end of the freeze and its number."""
JOIN, EXPLORATION = "introduction:circle_clockwise", "episode:0:circle_clockwise"


class Bar:
    """The time bar of a page, by what a hand does there."""

    def __init__(self, live: LiveLab, screen: Screen) -> None:
        self.live, self.page, self._screen = live, screen.page, screen
        self.taken: list[Any] = []
        """All messages that have come from the frame, and have been acted on."""
        self._more = threading.Condition()
        self.frame: FrameLocator = screen.page.frame_locator("iframe.pounce-time")
        self._reading = screen.reading("Trial")

    # Reading

    @property
    def handle(self) -> Locator:
        """The playhead, as far as it can have the focus."""
        return self.frame.get_by_role("slider", name="Moment that is shown")

    @property
    def said(self) -> Locator:
        """What is said of what a hand did."""
        return self.frame.locator(".told .said")

    def block(self, id: str) -> Locator:
        """A block of the schedule."""
        return self.frame.locator(f'.piece[data-id="{id}"]')

    def button(self, name: str) -> Locator:
        """A button of the row above the bar, or of a menu."""
        return self.frame.get_by_role("button", name=name, exact=True)

    @property
    def place(self) -> Place | None:
        """The moment that the browser looks at, as the lab knows it."""
        return self.live.lab.browsers[0].outlook.place

    def record(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Note what comes from the frame from now on."""
        panel = self.live.lab.browsers[0].time
        take = panel.take

        def noting(message: Any) -> None:
            take(message)
            with self._more:
                self.taken.append(message)
                self._more.notify_all()

        monkeypatch.setattr(panel, "take", noting)

    def goes_live(self) -> None:
        """Wait until the newest message from the frame is that it wants to be live."""
        with self._more:
            assert self._more.wait_for(
                lambda: self.taken and isinstance(self.taken[-1], messages.Live), PATIENCE_S
            )

    def says(self, words: str) -> None:
        """Wait until this has been said of what a hand did, be it gone by now."""
        self._screen.time_page.wait_for_function(HAS_HEARD, arg=words)

    def is_live(self) -> None:
        """Wait until the lab knows that the browser looks at what is live."""
        until(lambda: self.place is None)

    def looks_at(self, trial: int) -> None:
        """Wait until the page shows a moment, and the bar knows that."""
        expect(self._reading).to_have_text(f"{trial:,}")
        self._screen.expect_place("trial", trial)

    def comes_near(self, trial: int) -> int:
        """Wait until the page shows the moment that a hand at a trial comes to; return its trial.

        That is as round a trial as it can point at. What was shown before may be so until then.
        """
        shown = self._screen.expect_place("trial", trial, off=10)
        self.looks_at(shown)
        expect(self.handle).to_have_text(f"{shown:,}")
        return shown

    def at(self, trial: float, row: str = ".curve") -> tuple[float, float]:
        """The pixel of a trial in a row, ``(x, y)``."""
        # What has just got another height moves what is in it, and so does a frame that has it from
        # its page.
        self._screen.rest()
        plot = self.frame.locator(f"{row} > .plot").element_handle()
        plot.wait_for_element_state("stable")
        box = plot.bounding_box()
        assert box is not None
        return box["x"] + trial / TRIALS * box["width"], box["y"] + box["height"] / 2

    # Doing

    def take(self, at: tuple[float, float], *through: tuple[float, float]) -> None:
        """Press the mouse button at a place, and move through others."""
        self.page.mouse.move(*at)
        self.page.mouse.down()
        for place in through:
            self.page.mouse.move(*place, steps=4)

    def drag(self, at: tuple[float, float], *through: tuple[float, float]) -> None:
        """Drag from one place through others, and let go."""
        self.take(at, *through)
        self.page.mouse.up()


def lane(skill: str) -> str:
    """The row of a skill."""
    return f'.lane[data-skill="{skill}"]'


CIRCLE, APPROACH = lane("circle_clockwise"), lane("approach")


@pytest.fixture
def bar(begin: Begin, monkeypatch: pytest.MonkeyPatch) -> Bar:
    """The bar of a run that has a part of its schedule ahead."""
    live, screen = begin("timed", *PLAN, trial=HERE)
    bar = Bar(live, screen)
    bar.record(monkeypatch)
    # What acts on keys of time is in the frame, where blocks of the same ids may have stood
    # elsewhere in the run before this one.
    now = live.session.status.snapshot
    screen.expect_line(now.generation, now.step)
    screen.page.keyboard.press("End")
    bar.goes_live()
    bar.looks_at(HERE)
    expect(bar.handle).to_have_text(f"{HERE}")
    screen.time_page.evaluate(HEAR, ".told .said > span")
    for block in (JOIN, EXPLORATION):
        expect(bar.block(block)).to_have_attribute("aria-valuenow", f"{JOINS}")
    return bar


def plan_of(status: Status) -> ScheduleSpec:
    return status.snapshot.spec.schedule


def n_edits(status: Status) -> int:
    """So many times a schedule was edited."""
    history = status.snapshot.control.history
    return sum(isinstance(event.command, SetSchedule) for event in history)


def edited(bar: Bar, times: int = 1) -> ScheduleSpec:
    """The schedule once it was edited so many times, and no more often."""
    bar.live.wait_for(lambda status: n_edits(status) >= times)
    status = bar.live.ask()
    assert n_edits(status) == times
    return plan_of(status)


def circle_of(plan: ScheduleSpec) -> tuple[int, int, EpisodeSpec]:
    """When circle clockwise joins, the freeze after it, and its exploration."""
    timer = plan.skills["circle_clockwise"]
    return timer.at, timer.freeze, plan.episodes[0]


# --- The playhead --------------------------------------------------------------------------------


def test_a_drag_on_the_curve_shows_each_moment_and_end_goes_back_to_live(bar: Bar) -> None:
    before = bar.live.session.status.snapshot
    bar.take(bar.at(300), *[bar.at(trial) for trial in range(310, 500, 10)])
    bar.page.mouse.up()
    trial = bar.comes_near(490)
    assert bar.place == bar.live.place_of(trial)
    expect(bar.frame.locator(".transport .place")).to_contain_text(
        f"The past, trial {trial}, {HERE - trial} trials behind"
    )
    # Of all that a hand wished on the way, each is another, and the last was asked for.
    wishes = [message.trial for message in bar.taken if isinstance(message, messages.SeekTrial)]
    assert wishes[-1] == trial
    assert all(one != other for one, other in itertools.pairwise(wishes))
    assert bar.live.session.status.snapshot.step == before.step

    bar.page.keyboard.press("End")
    bar.looks_at(HERE)
    assert bar.place is None
    expect(bar.button("Live: this is what happens now")).to_be_visible()


@pytest.mark.parametrize("row", [".axis", CIRCLE])
def test_a_press_on_the_axis_or_where_a_lane_is_empty_goes_there(bar: Bar, row: str) -> None:
    bar.page.mouse.click(*bar.at(400, row))
    bar.comes_near(400)
    assert bar.place is not None
    bar.button("Back to live").click()
    bar.looks_at(HERE)


def test_a_drag_that_is_given_up_leaves_the_moment_as_it_was(bar: Bar) -> None:
    bar.take(bar.at(300), bar.at(500))
    expect(bar.button("Back to live")).to_be_visible()
    bar.taken.clear()
    bar.page.keyboard.press("Escape")
    bar.page.mouse.up()
    bar.goes_live()
    bar.looks_at(HERE)
    bar.is_live()


def test_past_the_end_of_what_is_known_is_live(bar: Bar) -> None:
    bar.taken.clear()
    bar.drag(bar.at(300), bar.at(500), bar.at(3_000))
    bar.goes_live()
    bar.looks_at(HERE)
    bar.is_live()
    # A press where nothing is known yet goes nowhere.
    bar.page.mouse.click(*bar.at(300))
    shown = bar.comes_near(300)
    bar.page.mouse.click(*bar.at(3_000))
    bar.looks_at(shown)
    bar.page.keyboard.press("End")
    bar.looks_at(HERE)


def test_the_playhead_goes_by_its_keys(bar: Bar) -> None:
    # A hand comes to as round a trial as it can point, and keys go to the hundreds.
    bar.page.mouse.click(*bar.at(437))
    expect(bar.button("Back to live")).to_be_visible()
    assert bar.comes_near(437) in (430, 440)
    bar.handle.focus()
    by_key = {"ArrowRight": 500, "Shift+Period": 501, "ArrowLeft": 500, "End": HERE}
    for key, trial in by_key.items():
        bar.page.keyboard.press(key)
        bar.looks_at(trial)
    for key, trial in [
        ("ArrowLeft", 700),
        ("ArrowLeft", 600),
        ("ArrowRight", 700),
        ("Home", 0),
        ("ArrowUp", 100),
    ]:
        bar.page.keyboard.press(key)
        bar.looks_at(trial)
    expect(bar.handle).to_have_attribute("aria-valuetext", re.compile(r"^trial 100, 700 trials"))
    bar.page.keyboard.press("End")
    bar.looks_at(HERE)


# --- Blocks by mouse -----------------------------------------------------------------------------


def test_a_block_is_moved_by_hundreds_and_with_alt_to_any_trial(bar: Bar) -> None:
    # Circle clockwise joins at a line; its exploration is right of that.
    x, y = bar.at(HOLD, CIRCLE)
    bar.drag((x, y), (bar.at(HOLD + 261, CIRCLE)[0], y))
    plan = edited(bar)
    joins, freeze, exploration = circle_of(plan)
    assert (joins, freeze) == (JOINS, 300)
    assert exploration == EpisodeSpec(
        skill="circle_clockwise", at=JOINS + 300, duration=600, probability=0.95
    )
    # It is there for good, and not as a draft that is given up after a while.
    expect(bar.block(EXPLORATION)).to_have_attribute("aria-valuenow", f"{JOINS + 300}")
    expect(bar.block(EXPLORATION)).not_to_have_class(re.compile("held"))

    x, y = bar.at(JOINS + 600, CIRCLE)
    bar.take((x, y))
    bar.page.keyboard.down("Alt")
    bar.page.mouse.move(x + 40, y, steps=4)
    bar.page.mouse.up()
    bar.page.keyboard.up("Alt")
    _, _, exploration = circle_of(edited(bar, 2))
    assert isinstance(exploration.at, int)
    assert exploration.at > JOINS + 400
    assert exploration.at % 100 != 0

    # It is undone as any other.
    bar.page.keyboard.press("u")
    bar.live.wait_for(lambda status: circle_of(plan_of(status))[2].at == JOINS + 300)


def test_when_a_skill_joins_is_moved_with_its_exploration(bar: Bar) -> None:
    bar.drag(bar.at(JOINS, CIRCLE), bar.at(JOINS - 503, CIRCLE))
    joins, freeze, exploration = circle_of(edited(bar))
    assert (joins, freeze, exploration.at) == (JOINS - 500, 300, "introduction")


def test_ends_of_explorations_and_freezes_are_moved(bar: Bar) -> None:
    bar.drag(bar.at(JOINS + 600, CIRCLE), bar.at(JOINS + 898, CIRCLE))
    assert circle_of(edited(bar))[2].duration == 900
    expect(bar.block(EXPLORATION)).not_to_have_class(re.compile("held"))
    # A freeze has its end where there is room for it.
    bar.drag(bar.at(JOINS + 300, CIRCLE), bar.at(JOINS + 500, CIRCLE))
    assert circle_of(edited(bar, 2))[1] == 500


def test_a_drag_that_is_given_up_asks_for_nothing(bar: Bar) -> None:
    at = bar.at(HOLD, CIRCLE)
    before = box_of(bar.block(EXPLORATION))
    bar.take(at, bar.at(JOINS + 900, CIRCLE))
    expect(bar.block(EXPLORATION)).to_have_class(re.compile("held"))
    bar.page.keyboard.press("Escape")
    bar.page.mouse.up()
    expect(bar.block(EXPLORATION)).not_to_have_class(re.compile("held"))
    assert box_of(bar.block(EXPLORATION)) == before
    assert n_edits(bar.live.ask()) == 0


def test_nothing_from_the_lab_moves_what_is_in_a_hand(bar: Bar) -> None:
    bar.take(bar.at(HOLD, CIRCLE), bar.at(HOLD + 400, CIRCLE))
    expect(bar.block(EXPLORATION)).to_have_class(re.compile("held"))
    held = box_of(bar.block(EXPLORATION))
    bar.live.go_to_trial(HERE + 40)
    bar.looks_at(HERE + 40)
    expect(bar.handle).to_have_text(f"{HERE + 40}")
    assert box_of(bar.block(EXPLORATION)) == held
    assert n_edits(bar.live.session.status) == 0
    bar.page.mouse.up()
    assert circle_of(edited(bar))[2].at == JOINS + 400


def test_what_is_past_is_locked_and_says_so(bar: Bar) -> None:
    bar.live.go_to_trial(JOINS + 700)
    bar.looks_at(JOINS + 700)
    block = bar.frame.locator(f"{CIRCLE} .piece.forced")
    expect(block).to_have_attribute("aria-disabled", "true")
    before = box_of(block)
    bar.drag(bar.at(JOINS + 400, CIRCLE), bar.at(JOINS + 900, CIRCLE))
    bar.says(f"What began at trial {JOINS:,} is past, and locked.")
    assert box_of(block) == before
    status = bar.live.ask()
    assert n_edits(status) == 0
    assert bar.place is None


def test_a_refusal_is_said_and_the_block_is_where_it_was(bar: Bar) -> None:
    bar.page.mouse.dblclick(*bar.at(3_500, CIRCLE))
    edited(bar)
    before = box_of(bar.block(EXPLORATION))
    # It would run into the one that was just added.
    bar.drag(bar.at(HOLD, CIRCLE), bar.at(HOLD + 1_200, CIRCLE))
    bar.says("would overlap")
    expect(bar.block(EXPLORATION)).not_to_have_class(re.compile("held"))
    assert box_of(bar.block(EXPLORATION)) == before
    assert n_edits(bar.live.ask()) == 1


def test_a_double_click_adds_and_delete_deletes(bar: Bar) -> None:
    bar.page.mouse.dblclick(*bar.at(1_203, APPROACH))
    added = edited(bar).episodes[-1]
    assert added == EpisodeSpec(skill="approach", at=1_200, duration=2_000, probability=0.5)
    bar.block("episode:2:approach").focus()
    bar.page.keyboard.press("Delete")
    assert len(edited(bar, 2).episodes) == 2
    # Where it is past nothing is added, and what was looked at is looked at again.
    bar.page.mouse.dblclick(*bar.at(400, APPROACH))
    bar.says("is past.")
    bar.looks_at(HERE)
    assert n_edits(bar.live.ask()) == 2


def test_a_probability_is_edited_where_it_stands(bar: Bar) -> None:
    bar.frame.locator(f'.chance[data-id="{EXPLORATION}"]').click()
    field = bar.frame.get_by_role("textbox", name="Probability: ")
    expect(field).to_be_focused()
    expect(field).to_have_value("95 %")
    bar.page.keyboard.press("ArrowDown")
    bar.page.keyboard.press("ArrowDown")
    expect(field).to_have_value("93 %")
    bar.page.keyboard.press("Enter")
    assert circle_of(edited(bar))[2].probability == pytest.approx(0.93)
    expect(bar.block(EXPLORATION)).to_be_focused()
    # Whoever has just edited it needs no hint, which would lie over the curve.
    expect(bar.frame.locator("#tip")).to_be_hidden()
    # What is typed is no key of the lab's, and Escape gives it up.
    bar.page.keyboard.press("Enter")
    bar.page.keyboard.type("n 5")
    expect(field).to_have_attribute("aria-invalid", "")
    bar.page.keyboard.press("Escape")
    expect(field).to_have_count(0)
    bar.page.keyboard.press("Enter")
    bar.page.keyboard.type("0,4")
    bar.page.keyboard.press("Enter")
    assert circle_of(edited(bar, 2))[2].probability == pytest.approx(0.4)
    assert bar.live.session.status.snapshot.present == ("approach",)


# --- By key, and by touch ------------------------------------------------------------------------


def test_what_the_mouse_can_do_the_keyboard_can(bar: Bar) -> None:
    bar.block(EXPLORATION).focus()
    bar.page.keyboard.press("ArrowRight")
    assert circle_of(edited(bar))[2].at == JOINS + 100
    bar.page.keyboard.press("Alt+ArrowRight")
    assert circle_of(edited(bar, 2))[2].duration == 700
    bar.block(JOIN).focus()
    bar.page.keyboard.press("Alt+ArrowLeft")
    assert circle_of(edited(bar, 3))[1] == 200
    bar.page.keyboard.press("Shift+ArrowLeft")
    assert circle_of(edited(bar, 4))[0] == JOINS - 1_000
    expect(bar.block(JOIN)).to_have_attribute("aria-valuenow", f"{JOINS - 1_000}")
    # A key that is held down asks once, when it is let go.
    for _ in range(3):
        bar.page.keyboard.down("ArrowRight")
    bar.page.keyboard.up("ArrowRight")
    assert circle_of(edited(bar, 5))[0] == JOINS - 700
    bar.page.keyboard.press("Delete")
    bar.says("can be moved, not deleted")
    bar.frame.get_by_role("button", name="Add an exploration of approach").focus()
    bar.page.keyboard.press("Enter")
    assert edited(bar, 6).episodes[-1].at == HERE + 1_100


def touch(page: Page, *places: tuple[float, float]) -> None:
    """A finger goes down at a place, through others, and up."""
    devtools = page.context.new_cdp_session(page)

    def send(kind: str, points: list[dict[str, float]]) -> None:
        about: dict[str, Any] = {"type": kind, "touchPoints": points}
        devtools.send("Input.dispatchTouchEvent", about)  # pyright: ignore[reportUnknownMemberType]

    for number, (x, y) in enumerate(places):
        send("touchMove" if number else "touchStart", [{"x": x, "y": y}])
    send("touchEnd", [])
    devtools.detach()


def between(one: tuple[float, float], other: tuple[float, float]) -> list[tuple[float, float]]:
    """Places on the way, as a finger takes them."""
    (x, y), (u, v) = one, other
    return [(x + (u - x) * part / 8, y + (v - y) * part / 8) for part in range(9)]


def test_a_finger_moves_blocks_and_the_playhead(bar: Bar) -> None:
    touch(bar.page, *between(bar.at(HOLD, CIRCLE), bar.at(HOLD + 400, CIRCLE)))
    assert circle_of(edited(bar))[2].at == JOINS + 400
    touch(bar.page, *between(bar.at(300), bar.at(500)))
    bar.comes_near(500)
    assert bar.place is not None
    # A tap goes there, as a press of the mouse does.
    touch(bar.page, bar.at(150))
    bar.comes_near(150)


# --- The row, and keys wherever the focus is -----------------------------------------------------


def walk_is(bar: Bar, name: str, button: str) -> Callable[[bool], None]:
    """Waits until a switch is so in the row, and judges that it is so in the lab."""

    def judge(on: bool) -> None:
        expect(bar.button(button)).to_have_attribute("aria-pressed", f"{on}".lower())
        assert getattr(bar.live.lab.browsers[0].outlook.walk, name) is on

    return judge


@pytest.mark.parametrize(
    ("name", "button"),
    [
        ("stops", "Stop at events"),
        ("holds", "The learner waits while I look at the past"),
    ],
)
def test_switches_of_the_row_show_what_is_true(bar: Bar, name: str, button: str) -> None:
    judge = walk_is(bar, name, button)
    former = getattr(bar.live.lab.browsers[0].outlook.walk, name)
    bar.button(button).click()
    judge(not former)
    bar.button(button).click()
    judge(former)


def test_the_past_is_played_at_a_rate_and_between_a_and_here(bar: Bar) -> None:
    walk = bar.live.lab.browsers[0].outlook.walk
    places: list[Place | None] = []
    for trial in (300, 500):
        bar.page.mouse.click(*bar.at(trial))
        bar.comes_near(trial)
        places.append(bar.place)
        if trial == 300:
            bar.page.keyboard.press("a")
            expect(bar.frame.locator('[data-act="a"][data-set]')).to_be_visible()
    rate = bar.frame.get_by_label("How fast the past is played")
    offered = [option.get_attribute("value") for option in rate.locator("option").all()]
    rate.select_option(offered[1])
    bar.page.keyboard.press("l")
    loop = bar.button("From A to here, again and again")
    expect(loop).to_have_attribute("aria-pressed", "true")
    assert f"{walk.rate:g}" == offered[1]
    assert walk.loop is not None
    assert [place and place.step for place in places] == [walk.loop.first, walk.loop.until]
    loop.click()
    expect(loop).to_have_attribute("aria-pressed", "false")
    bar.button("Play backwards").click()
    bar.looks_at(0)
    expect(bar.button("Play backwards")).to_be_visible()
    bar.page.keyboard.press("End")
    bar.looks_at(HERE)


def test_keys_of_time_act_in_the_page_and_in_the_frame(bar: Bar) -> None:
    page = bar.page
    for focus in (
        lambda: page.locator("body").click(position={"x": 600, "y": 5}),
        bar.handle.focus,
    ):
        focus()
        page.keyboard.press("End")
        bar.looks_at(HERE)
        page.keyboard.press("Shift+Comma")
        bar.looks_at(HERE - 1)
        page.keyboard.press("Shift+Comma")
        bar.looks_at(HERE - 2)
        page.keyboard.press("Shift+Period")
        bar.looks_at(HERE - 1)
        page.keyboard.press("a")
        expect(bar.button(f"A is trial {HERE - 1}; make it this moment")).to_be_visible()
        page.keyboard.press("Home")
        bar.looks_at(0)
        page.keyboard.press("a")
        expect(bar.button("A is trial 0; make it this moment")).to_be_visible()
    page.keyboard.press("End")
    bar.looks_at(HERE)


def test_a_moment_is_marked_with_a_line_of_text_and_the_mark_removed(bar: Bar) -> None:
    page = bar.page
    page.mouse.click(*bar.at(500))
    bar.comes_near(500)
    place = bar.place
    page.keyboard.press("b")
    expect(bar.frame.get_by_role("textbox")).to_be_focused()
    page.keyboard.type("a <b>cone</b>, n, e")
    page.keyboard.press("Enter")
    status = bar.live.wait_for(lambda status: len(status.marks) == 1)
    (mark,) = status.marks
    assert (mark.place, mark.text) == (place, "a <b>cone</b>, n, e")
    assert status.snapshot.present == ("approach",)
    note = bar.frame.locator(".mark.note > b")
    expect(note).to_contain_text("a <b>cone</b>")
    note.click()
    bar.frame.get_by_role("menuitem", name="Remove the mark").click()
    bar.live.wait_for(lambda status: not status.marks)
    page.keyboard.press("End")
    bar.looks_at(HERE)


def test_single_keys_that_are_off_are_off_in_the_frame(bar: Bar) -> None:
    bar.page.evaluate("localStorage.setItem('pounce-single-keys', 'off')")
    bar.handle.focus()
    bar.page.keyboard.press("Shift+Comma")
    bar.page.keyboard.press("ArrowLeft")
    bar.looks_at(HERE - 100)
    bar.page.evaluate("localStorage.removeItem('pounce-single-keys')")
    bar.page.keyboard.press("End")
    bar.looks_at(HERE)


# --- Branches ------------------------------------------------------------------------------------


def test_a_presentation_of_branches_is_seen_down_to_its_axis(bar: Bar) -> None:
    bar.live.go_to_trial(JOINS + 100)
    bar.looks_at(JOINS + 100)
    said = bar.frame.locator(f"{CIRCLE} .label").filter(has_text=f"{JOINS:,}")
    expect(said).to_contain_text("joined at")
    for trial, end in ((500, 2_700), (600, 2_800)):
        bar.page.keyboard.press("End")
        bar.looks_at(JOINS + 100)
        bar.page.mouse.click(*bar.at(trial))
        bar.comes_near(trial)
        expect(said).to_contain_text("joins at")
        # What can be changed there comes with a bar of its own.
        expect(bar.block(JOIN)).to_have_attribute("data-editable", "")
        n_lines = len(bar.live.session.status.lines)
        bar.drag(bar.at(JOINS + 300, CIRCLE), bar.at(end, CIRCLE))
        status = bar.live.wait_for(lambda status, n=n_lines: len(status.lines) == max(n + 1, 2))
        branch = max(line.number for line in status.lines)
        # Only then is the browser there: it would be taken away from where it goes next.
        row = bar.frame.locator(f'.line[data-line="{branch}"]')
        expect(row).to_have_attribute("aria-current", "true")
    bar.live.wait_for(lambda status: not any(line.is_growing for line in status.lines))
    # So slowly that it is not over before anybody looks.
    bar.live.ask(SetSpeed(100.0))
    bar.frame.get_by_label("How fast the past is played").select_option("1")
    bar.page.keyboard.press("p")
    try:
        legend = bar.page.locator("#pounce-stage .pounce-legend")
        expect(legend).to_be_in_viewport(ratio=0.99)
        expect(bar.frame.locator(".axis")).to_be_in_viewport(ratio=0.99)
        # Its button plays what is looked at.
        bar.page.locator("#pounce-stage .play").click()
        expect(bar.page.locator("#pounce-stage .play")).to_have_text("Pause")
        assert not bar.live.session.status.playing
    finally:
        bar.page.keyboard.press("p")


def test_a_block_moved_in_the_past_makes_a_branch_with_a_menu_of_its_own(bar: Bar) -> None:
    bar.page.mouse.click(*bar.at(500))
    bar.comes_near(500)
    bar.drag(bar.at(HOLD, CIRCLE), bar.at(HOLD + 400, CIRCLE))
    status = bar.live.wait_for(lambda status: len(status.lines) == 2)
    assert n_edits(status) == 0
    (branch,) = [line for line in status.lines if not line.is_live]
    row = bar.frame.locator(f'.line[data-line="{branch.number}"]')
    expect(row).to_have_attribute("aria-current", "true")
    expect(bar.frame.locator(".told .note")).to_be_visible()

    row.focus()
    bar.page.keyboard.press("F2")
    bar.page.keyboard.type("later")
    bar.page.keyboard.press("Enter")
    bar.live.wait_for(lambda status: "later" in [line.name for line in status.lines])
    expect(row).to_contain_text("later")

    row.focus()
    bar.page.keyboard.press("Enter")
    menu = bar.frame.get_by_role("menu", name="later")
    expect(menu.get_by_role("menuitem")).to_have_text(
        ["Look at it", "Rename", "Test over 30 seeds", "Make it live", "Delete"]
    )
    bar.page.keyboard.press("ArrowUp")
    bar.page.keyboard.press("Enter")
    bar.live.wait_for(lambda status: len(status.lines) == 1)
    bar.said.get_by_role("button", name="Undo").click()
    bar.live.wait_for(lambda status: len(status.lines) == 2)
    # What stands after a name stays there as a hand comes to it, or that would miss it.
    bar.page.keyboard.press("End")
    expect(row).not_to_have_attribute("aria-current", "true")
    more = row.get_by_role("button", name="What can be done with it")
    bar.handle.hover()
    place = box_of(more)
    row.hover(position={"x": 5, "y": 5})
    assert box_of(more) == place
    more.click()
    bar.frame.get_by_role("menuitem", name="Make it live").click()
    bar.live.wait_for(lambda status: status.snapshot.generation == branch.number)


def test_nothing_of_it_logs_an_error(shared: Shared) -> None:
    assert shared.screen.complaints == []
