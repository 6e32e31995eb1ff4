"""The page of an audience on a phone and on a laptop, beside the lab that it looks at."""

import math
import re
from collections.abc import Iterator

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, ViewportSize, expect

from app.audience.audience import Audience
from app.live.requests import Pause, Play
from app.picture.look import Look
from app.picture.theme import DARK
from tests.support.access import AXE, FINDINGS
from tests.support.live import PATIENCE_S, LiveLab, preset_of
from tests.support.phones import PHONE, Phones
from tests.support.screen import VIEWPORT, Screen, picture

TRIAL = 120

HAS_COLOURS = """colours => {
    const canvas = document.getElementById("board");
    const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    const there = new Set();
    for (let at = 0; at < pixels.length; at += 4)
        there.add((pixels[at] << 16) | (pixels[at + 1] << 8) | pixels[at + 2]);
    return colours.every(colour => there.has(colour));
}"""
FITS = """() => document.documentElement.scrollWidth <= innerWidth"""


class Class:
    """A lab with a presenter's page, and pages that look."""

    def __init__(self, live: LiveLab, presenter: Screen, browser: Browser) -> None:
        self.live, self.presenter, self.browser = live, presenter, browser
        self.phones = Phones(browser, self.audience)

    @property
    def audience(self) -> Audience:
        assert self.live.audience is not None
        return self.live.audience


@pytest.fixture(scope="module")
def whole_class(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Class]:
    expect.set_options(timeout=PATIENCE_S * 1000)
    folder = tmp_path_factory.mktemp("lab")
    live = LiveLab(preset_of(), 20_000.0, folder / "results", audience=True)
    try:
        live.go_to_trial(TRIAL)
        context = browser.new_context(viewport=VIEWPORT)
        context.set_default_timeout(PATIENCE_S * 1000)
        presenter = Screen(context.new_page())
        presenter.open(live)
        yield Class(live, presenter, browser)
        context.close()
    finally:
        live.close()


@pytest.fixture
def lesson(whole_class: Class) -> Iterator[Class]:
    """The class, in which nobody looks yet; no page may log an error."""
    yield whole_class
    whole_class.phones.close()
    complaints = whole_class.phones.complaints.copy()
    whole_class.phones.complaints.clear()
    assert complaints == []


def expect_colours(page: Page, colours: np.ndarray) -> None:
    """Wait until the board has all of these colours."""
    packed = np.unique(colours.astype(np.int64) @ np.array([65_536, 256, 1]))
    page.wait_for_function(HAS_COLOURS, arg=packed.tolist())


def sees(lesson: Class, page: Page, look: Look) -> None:
    """Wait until a page shows the live moment as it is to be seen."""
    colours = lesson.live.colours(look)
    size = lesson.live.session.status.snapshot.spec.world.size
    # Nothing lies over the rows in the west, but for the corners of a round board.
    east = np.arange(size**2) % size
    expect_colours(page, colours[(east > size // 8) & (east < size // 3)][size:-size:7])


# --- With the presenter ---------------------------------------------------------------------------


@pytest.mark.parametrize("viewport", [PHONE, VIEWPORT])
def test_it_shows_what_the_presenter_sees(lesson: Class, viewport: ViewportSize) -> None:
    page = lesson.phones.open(viewport)
    expect(page.locator("#title")).to_have_text("State value")
    expect(page.locator("#readings")).to_contain_text(f"{TRIAL}")
    expect(page.locator(".time .lane")).not_to_have_count(0)
    sees(lesson, page, lesson.live.look_of())
    assert page.evaluate(FITS)
    lesson.presenter.choose("Layer", "First reach")
    try:
        expect(page.locator("#title")).to_have_text("First reach")
        sees(lesson, page, lesson.live.look_of())
    finally:
        lesson.presenter.choose("Layer", "State value")
    expect(page.locator("#title")).to_have_text("State value")


def test_it_goes_into_the_past_with_the_presenter(lesson: Class) -> None:
    page = lesson.phones.open()
    here = page.locator(".time .here")
    expect(here).to_have_text(f"{TRIAL}")
    lesson.presenter.tell("seek_trial", trial=70)
    try:
        expect(here).to_have_text("70")
        expect(page.locator("#sentence")).to_contain_text("The past, trial 70")
    finally:
        lesson.presenter.tell("live")
    expect(here).to_have_text(f"{TRIAL}")


def test_what_goes_on_goes_on_there(lesson: Class) -> None:
    page = lesson.phones.open()
    expect(page.locator("#readings")).to_contain_text("Trial")
    lesson.live.ask(Play())
    status = lesson.live.wait_for(lambda status: status.snapshot.trial >= TRIAL + 200)
    lesson.live.ask(Pause())
    trial = lesson.live.session.status.snapshot.trial
    assert trial >= status.snapshot.trial
    expect(page.locator("#readings")).to_contain_text(f"{trial:,}")


def test_a_dark_device_has_a_dark_board(lesson: Class) -> None:
    page = lesson.phones.open(dark=True)
    look = lesson.live.look_of()._replace(theme=DARK)
    sees(lesson, page, look)
    ground = picture(page.screenshot())[-1, 0]
    assert ground.max() < 60
    page.emulate_media(color_scheme="light")
    sees(lesson, page, lesson.live.look_of())


# --- On one's own ---------------------------------------------------------------------------------


def look_around(page: Page) -> None:
    expect(page.locator("#title")).not_to_be_empty()
    page.get_by_role("button", name="Look around").click()
    expect(page.get_by_role("button", name="Back to presenter")).to_be_visible()


@pytest.mark.parametrize("viewport", [PHONE, VIEWPORT])
def test_one_can_look_around_and_come_back(lesson: Class, viewport: ViewportSize) -> None:
    page, other = lesson.phones.open(viewport), lesson.phones.open(viewport)
    look_around(page)
    page.get_by_role("combobox", name="Layer").select_option(label="First reach")
    expect(page.locator("#title")).to_have_text("First reach")
    page.get_by_role("combobox", name="Headings").select_option(label="Prey faces north")
    sees(lesson, page, Look(layer="reach", frame=2))
    assert page.evaluate(FITS)
    expect(other.locator("#title")).to_have_text("State value")
    page.get_by_role("button", name="Back to presenter").click()
    expect(page.locator("#title")).to_have_text("State value")
    expect(page.get_by_role("combobox", name="Layer")).to_be_hidden()
    sees(lesson, page, lesson.live.look_of())


def test_one_begins_with_what_the_presenter_shows_and_has_it_in_view_with_the_buttons(
    lesson: Class,
) -> None:
    page = lesson.phones.open(PHONE)
    lesson.presenter.page.keyboard.press("3")
    try:
        expect(page.locator("#title")).to_have_text("Chosen skill")
        look_around(page)
        layer = page.get_by_role("combobox", name="Layer").locator("option:checked")
        expect(layer).to_have_text("Chosen skill")
        sees(lesson, page, Look(layer="chosen"))
        board, steps = page.locator("#board"), page.locator("#steps")
        expect(board).to_be_in_viewport(ratio=1)
        expect(steps).to_be_in_viewport(ratio=1)
    finally:
        lesson.presenter.page.keyboard.press("1")
    expect(lesson.presenter.field("Layer")).to_have_value("State value")


def test_a_finger_on_the_curve_goes_to_that_moment(lesson: Class) -> None:
    page = lesson.phones.open()
    here = page.locator(".time .here")
    expect(here).not_to_be_empty()
    now = here.text_content()
    box = page.locator(".time .axis > .plot").bounding_box()
    assert box is not None
    middle = (box["x"] + 2, box["y"] - 40)
    page.mouse.click(*middle)
    expect(here).to_have_text(now or "")
    look_around(page)
    page.locator(".steps").scroll_into_view_if_needed()
    box = page.locator(".time .axis > .plot").bounding_box()
    assert box is not None
    # The run has come but a few pixels far along the axis of its whole plan.
    page.mouse.click(box["x"] - 2, box["y"] - 40)
    expect(page.locator("#sentence")).to_contain_text("The past")
    expect(page.locator(".time.past")).to_have_count(1)
    page.get_by_role("button", name="Now").click()
    expect(page.locator(".time.past")).to_have_count(0)
    expect(here).to_have_text(now or "")


def test_all_of_it_can_be_done_by_keys(lesson: Class) -> None:
    page = lesson.phones.open(VIEWPORT)
    look_around(page)
    handle = page.get_by_role("slider", name="Moment that is shown")
    handle.focus()
    page.keyboard.press("Home")
    expect(page.locator(".time .here")).to_have_text("0")
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    expect(page.locator(".time .here")).not_to_have_text("0")
    page.keyboard.press("End")
    expect(page.locator(".time.past")).to_have_count(0)
    page.keyboard.press("Escape")
    expect(page.get_by_role("button", name="Presenter", exact=True)).to_be_visible()


# --- For everybody --------------------------------------------------------------------------------


@pytest.mark.parametrize("around", [False, True])
@pytest.mark.parametrize("dark", [False, True])
def test_the_checker_finds_nothing(lesson: Class, dark: bool, around: bool) -> None:
    page = lesson.phones.open(dark=dark)
    expect(page.locator(".time .lane")).not_to_have_count(0)
    if around:
        look_around(page)
    page.evaluate(f"{AXE};0")
    assert page.evaluate(FINDINGS) == []
    board = page.get_by_role("img", name=re.compile("^The board, "))
    expect(board).to_be_visible()
    expect(page.locator("#sentence")).not_to_be_empty()
    expect(page.locator("#told")).to_have_text(page.locator("#sentence").text_content() or "")


def test_what_one_touches_is_large_enough(lesson: Class) -> None:
    page = lesson.phones.open()
    look_around(page)
    for part in page.locator("button:visible, select:visible").all():
        if part.evaluate("node => !node.closest('.time')"):
            box = part.bounding_box()
            assert box is not None
            assert box["height"] >= 40


def test_words_are_explained(lesson: Class) -> None:
    page = lesson.phones.open()
    term = page.locator("#readings .term").first
    term.tap()
    expect(page.get_by_role("tooltip")).to_contain_text("hunt")


# --- Comings and goings ---------------------------------------------------------------------------


def test_the_presenter_reads_where_it_is_and_another_can_take_over(
    lesson: Class, monkeypatch: pytest.MonkeyPatch
) -> None:
    # However slow this is, nobody has the place of who has gone but who takes it.
    monkeypatch.setattr("app.page.presenting.RELOADED_S", math.inf)
    screen = lesson.presenter
    screen.turn_to("File")
    shown = screen.page.get_by_text(lesson.audience.addresses[-1])
    expect(shown).to_be_visible()
    expect(screen.button("Present from this browser")).to_be_disabled()
    context = lesson.browser.new_context(viewport=VIEWPORT)
    try:
        context.set_default_timeout(PATIENCE_S * 1000)
        second = Screen(context.new_page())
        second.open(lesson.live)
        second.choose("Layer", "Policy flow")
        page = lesson.phones.open()
        expect(page.locator("#title")).to_have_text("State value")
        second.turn_to("File")
        second.click("Present from this browser")
        expect(page.locator("#title")).to_have_text("Policy flow")
    finally:
        context.close()
    # Nobody has come since: the page that is still there may present again.
    screen.click("Present from this browser")
    expect(page.locator("#title")).to_have_text("State value")
    screen.turn_to("Now")


def test_it_waits_and_comes_again(lesson: Class) -> None:
    past_of = lesson.live.session.past_of
    first = Audience(past_of, "127.0.0.1", 0)
    port = first.watchers.port
    page = lesson.phones.open(address=first.addresses[0])
    expect(page.locator("#waiting")).to_have_text(re.compile("^The presenter has not begun"))
    first.close()
    expect(page.locator("#connection")).to_have_text(re.compile("^The lab cannot be reached"))
    loaded: list[str] = []
    page.on("framenavigated", lambda frame: loaded.append(frame.url))
    # It is connected before it knows that this is another lab, and loads anew.
    with page.expect_event("framenavigated"):
        again = Audience(past_of, "127.0.0.1", port)
    try:
        expect(page.locator("#waiting")).to_have_text(re.compile("^The presenter has not begun"))
        expect(page.locator("#connection")).to_be_hidden()
        assert len(loaded) == 1
    finally:
        again.close()
    # Browsers log what could not be loaded.
    lesson.phones.close()
    lesson.phones.complaints.clear()


def test_a_code_is_asked_for_and_typed(lesson: Class) -> None:
    guarded = Audience(lesson.live.session.past_of, "127.0.0.1", 0, code="abcd-efgh")
    try:
        page = lesson.phones.open(address=guarded.addresses[0])
        page.get_by_label("Code").fill("abcd-efgh")
        page.get_by_role("button", name="Enter").click()
        expect(page.locator("#waiting")).to_be_visible()
        assert "abcd" not in page.url
    finally:
        guarded.close()
    # Browsers log what could not be loaded.
    lesson.phones.close()
    lesson.phones.complaints.clear()
