"""Questions on the picture itself: each is answered by mouse, and each by the keyboard alone.

What is judged is what the lab has heard, and what the page then shows.
"""

import threading
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import FrameLocator, Locator, expect

from app.page.browser import Browser
from app.page.lesson.board import OctantsAsked
from app.page.time.asked import Band, MomentAsked, SketchAsked, handles_at
from app.picture.octants import OCTANTS
from tests.support.live import PATIENCE_S, LiveLab
from tests.support.screen import Begin, Screen, Shared

TRIALS, HERE = 4_000, 800
FIRST, LAST = 800, 2_800
AT = handles_at(FIRST, LAST)
MOMENT, SKETCH = MomentAsked("when"), SketchAsked("how", FIRST, LAST)
_HAS_DRAWN = """name => {
    const node = window.__viserSceneTree.getState()[name];
    return node !== undefined && node.message.props.points.length > 12;
}"""
_HAS_NOT = "name => window.__viserSceneTree.getState()[name] === undefined"


class Desk:
    """A page that is asked something, and all that was answered."""

    def __init__(self, live: LiveLab, screen: Screen) -> None:
        self.live, self.screen, self.page = live, screen, screen.page
        self.browser: Browser = live.lab.browsers[0]
        self.heard: list[Any] = []
        self._more = threading.Condition()
        self.bar: FrameLocator = screen.time
        self.handle = self.bar.get_by_role("slider", name="Moment that is shown")

    def hear(self, answer: Any) -> None:
        """Note an answer."""
        with self._more:
            self.heard.append(answer)
            self._more.notify_all()

    def until(self, is_so: Callable[[], bool]) -> None:
        """Wait until what was heard is so."""
        with self._more:
            assert self._more.wait_for(is_so, PATIENCE_S), self.heard

    def until_last(self, is_so: Callable[[Any], bool]) -> None:
        """Wait until the last that was heard is so."""
        self.until(lambda: bool(self.heard) and is_so(self.heard[-1]))

    def do(self, act: Any) -> None:
        """Have the lab do something, as all is done there: in the loop that draws."""
        self.live.lab.inbox.put(act)

    # On the board

    def ask_octants(self, asked: OctantsAsked | None) -> None:
        def toggled(guess: frozenset[str]) -> None:
            self.hear(guess)
            board = self.browser.octants
            assert board.asked is not None
            board.ask(board.asked._replace(guess=guess), toggled)

        self.do(lambda: self.browser.octants.ask(asked, toggled))

    def click_cell(self, east: int, north: int) -> None:
        """Click on a cell of the board, by its distance from the prey."""
        size = self.live.session.status.snapshot.spec.world.size
        middle = size // 2
        self.page.mouse.click(*self.screen.place_of((middle + north) * size + middle + east))

    # On the bar

    def ask(self, asked: MomentAsked | SketchAsked | None) -> None:
        """Ask on the bar, each answer taken as a lesson takes it; wait until it is there."""

        def answered(answer: Any) -> None:
            self.hear(answer)
            now = self.browser.time.asked
            if isinstance(now, MomentAsked):
                self.browser.time.ask(now._replace(guess=answer.trial), answered)
            elif now is not None:
                self.browser.time.ask(now._replace(handles=answer.points), answered)

        assert self.screen.time_page
        self.do(lambda: self.browser.time.ask(asked, answered))
        if asked is None:
            expect(self.bar.locator("p.asked")).to_be_hidden()
        elif isinstance(asked, MomentAsked):
            expect(self.bar.locator(".over.guess")).to_be_attached()
            expect(self.bar.locator("p.asked")).to_be_visible()
        else:
            expect(self.knots).to_have_count(6)
        self.screen.rest()

    @property
    def flag(self) -> Locator:
        return self.bar.get_by_role("slider", name="Your guess: at which trial")

    @property
    def knots(self) -> Locator:
        return self.bar.get_by_role("slider", name="Reward at trial")

    def at(self, trial: float, share: float = 0.5) -> tuple[float, float]:
        """The pixel of a trial over the curve, so high in it, of a bar of the whole run."""
        box = self.bar.locator(".curve > .plot").bounding_box()
        assert box is not None
        return box["x"] + trial / TRIALS * box["width"], box["y"] + (1 - share) * box["height"]

    def knot(self, number: int, share: float) -> tuple[float, float]:
        """The pixel at which a point of the curve would be so high."""
        plot, knot = self.bar.locator(".curve > .plot").bounding_box(), self.box(number)
        assert plot is not None
        return knot["x"] + knot["width"] / 2, plot["y"] + (1 - share) * plot["height"]

    def box(self, number: int) -> Any:
        box = self.knots.nth(number).bounding_box()
        assert box is not None
        return box

    def drag(self, *places: tuple[float, float]) -> None:
        self.page.mouse.move(*places[0])
        self.page.mouse.down()
        for place in places[1:]:
            self.page.mouse.move(*place, steps=4)
        self.page.mouse.up()


@pytest.fixture
def desk(begin: Begin, shared: Shared) -> Desk:
    live, screen = begin("timed", f"trials={TRIALS}", trial=HERE)
    return Desk(live, screen)


# --- Octants


def test_octants_are_chosen_by_clicks_and_gone_with_the_question(desk: Desk) -> None:
    desk.ask_octants(OctantsAsked())
    desk.page.wait_for_function(_HAS_DRAWN, arg="/asked/borders")
    desk.click_cell(-12, 0)
    desk.page.wait_for_function(_HAS_DRAWN, arg="/asked/guess")
    assert desk.heard == [{"w"}]
    # Taken back is what was clicked again; what comes last says all. A page that is held up sends
    # but the last of several clicks.
    for n_heard, cell in enumerate([(0, 12), (-10, 1), (9, -9)], start=2):
        desk.click_cell(*cell)
        desk.until(lambda n_heard=n_heard: len(desk.heard) == n_heard)
    assert desk.heard[-1] == {"n", "se"}
    desk.ask_octants(OctantsAsked(desk.heard[-1], True, frozenset({"n"}), {"n": 19}))
    desk.page.wait_for_function("() => window.__viserSceneTree.getState()['/asked/fills']")
    desk.ask_octants(None)
    desk.page.wait_for_function(_HAS_NOT, arg="/asked/guess")
    assert set(OCTANTS) >= desk.heard[-1]


# --- A moment


def test_a_moment_is_guessed_by_mouse_and_nobody_goes_through_time_meanwhile(desk: Desk) -> None:
    expect(desk.handle).to_be_visible()
    desk.ask(MOMENT)
    expect(desk.handle).to_be_hidden()
    expect(desk.bar.get_by_role("toolbar", name="Time")).to_be_hidden()
    expect(desk.flag).to_have_attribute("aria-valuetext", "no guess yet")
    desk.page.mouse.click(*desk.at(2_000))
    expect(desk.flag).to_have_attribute("aria-valuetext", "trial 2,000")
    desk.drag(desk.at(2_000), desk.at(2_600), desk.at(3_000))
    expect(desk.flag).to_have_attribute("aria-valuetext", "trial 3,000")
    expect(desk.flag).to_have_text("your guess: 3,000")
    desk.until_last(lambda guess: guess.trial == 3_000)
    assert desk.browser.outlook.place is None
    assert {type(answer).__name__ for answer in desk.heard} == {"Guess"}
    desk.page.keyboard.press("Home")
    expect(desk.flag).to_have_attribute("aria-valuetext", "trial 0")
    assert desk.browser.outlook.place is None
    desk.ask(None)


def test_a_moment_is_guessed_by_keys_alone_locked_and_revealed(desk: Desk) -> None:
    desk.ask(MOMENT)
    desk.flag.focus()
    for key, trial in [
        ("ArrowRight", 900),
        ("ArrowRight", 1_000),
        ("Shift+ArrowRight", 2_000),
        ("ArrowLeft", 1_900),
        ("PageUp", 2_000),
        ("End", 4_000),
        ("PageDown", 3_000),
    ]:
        desk.page.keyboard.press(key)
        expect(desk.flag).to_have_attribute("aria-valuetext", f"trial {trial:,}")
    desk.until_last(lambda guess: guess.trial == 3_000)
    n_heard = len(desk.heard)
    desk.ask(MomentAsked("when", 3_000, True, 2_400, (2_000, 2_200, 2_500), runs=4))
    told = desk.bar.locator("p.asked")
    expect(told).to_contain_text("Your guess: trial 3,000")
    expect(told).to_contain_text("This run: trial 2,400")
    expect(told).to_contain_text("3 of 4 runs: trial 2,000 to 2,500")
    expect(desk.bar.locator(".guess > .others > i")).to_have_count(3)
    # What it is for again is to go through time.
    expect(desk.flag).not_to_have_attribute("tabindex", "0")
    desk.page.mouse.click(*desk.at(400))
    desk.screen.time_page.wait_for_function(
        "() => document.querySelector('.handle').getAttribute('aria-valuenow') === '400'"
    )
    assert len(desk.heard) == n_heard
    desk.ask(None)
    expect(desk.bar.locator(".over.guess")).to_be_hidden()
    expect(desk.handle).to_be_visible()


# --- A curve


def test_a_curve_is_drawn_by_mouse_point_by_point_and_across(desk: Desk) -> None:
    desk.ask(SKETCH)
    low, high = (
        float(desk.knots.first.get_attribute(f"aria-value{end}") or 0) for end in ("min", "max")
    )
    desk.drag(desk.knot(2, 0.5), desk.knot(2, 0.99))
    expect(desk.knots.nth(2)).to_have_attribute("aria-valuenow", f"{high:.0f}")
    desk.drag(*(desk.knot(number, 0.01) for number in range(6)))
    for number in range(6):
        expect(desk.knots.nth(number)).to_have_attribute("aria-valuenow", f"{low:.0f}")
    desk.until_last(lambda guess: guess.points == tuple((trial, low) for trial in AT))
    assert desk.browser.outlook.place is None
    desk.ask(None)


def test_a_curve_is_drawn_by_keys_alone_locked_and_revealed(desk: Desk) -> None:
    desk.ask(SKETCH)
    first = desk.knots.first
    before = int(first.get_attribute("aria-valuenow") or 0)
    first.focus()
    desk.page.keyboard.press("ArrowUp")
    expect(first).to_have_attribute("aria-valuenow", f"{before + 1}")
    desk.page.keyboard.press("End")
    high = first.get_attribute("aria-valuemax")
    expect(first).to_have_attribute("aria-valuenow", f"{high}")
    for _ in range(5):
        desk.page.keyboard.press("Tab")
    desk.page.keyboard.press("Home")
    low = first.get_attribute("aria-valuemin")
    expect(desk.knots.last).to_have_attribute("aria-valuenow", f"{low}")
    expect(desk.knots.last).to_have_accessible_name(f"Reward at trial {LAST:,}")
    desk.until_last(lambda guess: guess.points[-1] == (LAST, float(low or 0)))
    points = desk.heard[-1].points
    run = tuple((trial, 10.0) for trial in AT)
    band = Band(AT, (0.0,) * 6, (20.0,) * 6)
    desk.ask(SketchAsked("how", FIRST, LAST, points, True, run, band))
    told = desk.bar.locator("p.asked")
    for words in ("Your guess", "This run", "Where twenty runs went"):
        expect(told).to_contain_text(words)
    for kind in ("mine", "run", "others"):
        expect(desk.bar.locator(f".sketch path.{kind}")).to_have_count(1)
    expect(first).not_to_have_attribute("tabindex", "0")
    desk.ask(None)


def test_a_run_that_went_on_is_hidden_from_who_draws_how_it_goes_on(desk: Desk) -> None:
    live = desk.live
    live.go_to_trial(2_000)
    desk.ask(SketchAsked("how", 500, 1_500))
    known = desk.screen.time_page.evaluate(
        """async () => {
            const { state } = await import(new URL("../../web/time/state.js", location.href));
            const { axis, learned, greedy, ghost, lines, happenings } = state.bar;
            const wide = axis.end - axis.start;
            const trials = [...learned.at, ...greedy.at].map(at => axis.start + at * wide);
            trials.push(...happenings.map(({ trial }) => trial));
            return [Math.max(...trials), ghost, lines];
        }"""
    )
    assert known[0] <= 500
    assert known[1:] == [None, []]
    desk.ask(None)
