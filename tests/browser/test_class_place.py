"""A class answers on the picture itself: octants by a tap on the board, a moment on the bar."""

from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, ViewportSize, expect

from app.player.classroom import Classroom, Question
from tests.support.live import PATIENCE_S, LiveLab, preset_of
from tests.support.screen import VIEWPORT, Screen

PHONE: ViewportSize = {"width": 390, "height": 844}
TRIALS = 4_000


class Seat:
    """One of a class, with a phone."""

    def __init__(self, context: BrowserContext, address: str) -> None:
        self.context, self.page = context, context.new_page()
        self.page.goto(address)
        expect(self.page.locator("#board")).to_be_visible()

    @property
    def chosen(self) -> list[str]:
        """Names of the octants that its card says are chosen."""
        checked = self.page.get_by_role("checkbox", checked=True)
        return [str(part.get_attribute("aria-label")) for part in checked.all()]

    def tap_board(self, east: float, north: float) -> None:
        """Tap on the board, at a place in shares of its half."""
        box = self._box("#board")
        x = box["x"] + box["width"] / 2 * (1 + east)
        self.page.mouse.click(x, box["y"] + box["height"] / 2 * (1 - north))

    def _box(self, name: str) -> Any:
        """Where something is once it is in view and rests there."""
        part = self.page.locator(name).element_handle()
        part.evaluate("node => node.scrollIntoView({block: 'center'})")
        part.wait_for_element_state("stable")
        return part.bounding_box()

    @property
    def flag(self) -> Any:
        """Its guess on the bar."""
        return self.page.get_by_role("slider", name="Your guess: at which trial")

    def tap_bar(self, trial: int) -> None:
        """Tap on the bar at a trial."""
        box, curve = self._box(".axis > .plot"), self._box(".curve > .plot")
        self.page.mouse.click(box["x"] + trial / TRIALS * box["width"], curve["y"] + 9)


@pytest.fixture(scope="module")
def live(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveLab]:
    expect.set_options(timeout=PATIENCE_S * 1000)
    folder = tmp_path_factory.mktemp("lab")
    spec = preset_of("timed", f"trials={TRIALS}")
    live = LiveLab(spec, 20_000.0, folder / "results", classroom=True)
    try:
        live.go_to_trial(800)
        context = browser.new_context(viewport=VIEWPORT)
        presenter = Screen(context.new_page())
        presenter.open(live)
        yield live
        context.close()
    finally:
        live.close()


@pytest.fixture
def seat(live: LiveLab, browser: Browser) -> Iterator[Seat]:
    assert live.audience is not None
    context = browser.new_context(viewport=PHONE, has_touch=True)
    context.set_default_timeout(PATIENCE_S * 1000)
    yield Seat(context, live.audience.addresses[0])
    context.close()


@pytest.fixture
def room(live: LiveLab) -> Iterator[Classroom]:
    assert live.audience is not None
    room = live.audience.classroom
    assert room is not None
    yield room
    room.end()


def test_octants_are_chosen_by_taps_on_the_board_and_on_the_card_alike(
    seat: Seat, room: Classroom
) -> None:
    octants = tuple((octant, octant) for octant in ("e", "ne", "n", "nw", "w", "sw", "s", "se"))
    room.ask(Question("where", "sectors", "Which?", octants))
    boxes = seat.page.get_by_role("checkbox")
    expect(boxes).to_have_count(8)
    expect(seat.page.locator("#board[data-asked]")).to_be_attached()
    seat.tap_board(-0.6, 0.0)
    expect(seat.page.get_by_role("checkbox", checked=True)).to_have_count(1)
    assert seat.chosen == ["behind"]
    seat.tap_board(0.0, 0.6)
    expect(seat.page.get_by_role("checkbox", checked=True)).to_have_count(2)
    seat.tap_board(-0.6, 0.0)
    expect(seat.page.get_by_role("checkbox", checked=True)).to_have_count(1)
    expect(seat.page.locator("#answered")).to_contain_text("Your answer counts")
    room.end()
    expect(seat.page.locator("#board[data-asked]")).to_have_count(0)


def test_a_moment_is_chosen_by_a_tap_on_the_bar_within_what_is_asked(
    seat: Seat, room: Classroom
) -> None:
    room.ask(Question("when", "moment", "When?", low=1_000, high=3_000))
    expect(seat.flag).to_have_attribute("aria-valuetext", "no guess yet")
    seat.tap_bar(2_000)
    expect(seat.flag).to_have_attribute("aria-valuenow", "2000")
    expect(seat.page.locator("#answered")).to_contain_text("Your answer counts")
    seat.tap_bar(3_900)
    expect(seat.flag).to_have_attribute("aria-valuenow", "3000")
    seat.flag.focus()
    seat.page.keyboard.press("Shift+ArrowLeft")
    expect(seat.flag).to_have_attribute("aria-valuenow", "2000")
    room.end()
    expect(seat.flag).to_have_count(0)
