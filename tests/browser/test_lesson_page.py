"""A lesson in the lab's page: the card beside the board, and nothing but what it names."""

import re
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from app.live.requests import Tell
from app.live.story import WentToCard
from tests.support.access import AXE, FINDINGS
from tests.support.live import LiveLab
from tests.support.pupil import STOPS, Pupil
from tests.support.screen import TWO_FRAMES, Shared

TITLE = "Which way round?"
SIZES = {
    "a laptop": (1366, 768),
    "a projector": (1024, 768),
    "full HD": (1920, 1080),
    "a phone": (390, 844),
}
# What is to be seen and is a stop of the keyboard, but for words that are explained and frames.
BOXES = """() => [".board", ".lesson"].map(part => {
    const box = document.querySelector(`#pounce-stage ${part}`).getBoundingClientRect();
    return [box.left, box.top, box.right, box.bottom];
})"""
FITS = """() => {
    const { camera, canvas } = window.__viserMutable;
    const slot = document.querySelector("#pounce-stage .board").getBoundingClientRect();
    const seen = canvas.getBoundingClientRect();
    return Math.abs(slot.width - seen.width) < 1 && Math.abs(slot.height - seen.height) < 1
        && Math.abs(camera.aspect - slot.width / slot.height) < 0.01;
}"""


def root(page: Page, state: str) -> None:
    """Wait until the page is in that state of a lesson."""
    expect(page.locator("html")).to_have_attribute("data-lesson", state)


def test_whatever_a_lesson_does_not_name_is_gone_and_comes_back(
    shared: Shared, pupil: Pupil
) -> None:
    live, page = shared.live, pupil.page
    pupil.start(TITLE)
    root(page, "card")
    assert page.evaluate(STOPS) == ["Present"]
    for part in ("[data-dock-region]", ".rail", ".runs", ".begin-tour", "[data-slot-of=sentence]"):
        for node in page.locator(part).all():
            expect(node).to_be_hidden()
    expect(page.locator("iframe.pounce-time")).to_be_hidden()
    before = live.ask().snapshot
    for key in ("n", "e", "f", "c", "h", "s", "u", "w", "b", "Home", "Control+k"):
        page.keyboard.press(key)
    expect(page.get_by_role("dialog")).to_have_count(0)
    assert live.ask().snapshot.control == before.control
    assert live.look_of().layer == "value"
    page.keyboard.press("2")
    assert live.look_of().layer == "value"
    # This one is named, and is there on a card with something to do.
    story = live.session.status.story
    assert story is not None
    live.session.submit(Tell(WentToCard(1), story.name))
    live.session.submit(Tell(WentToCard(2), story.name))
    pupil.expect_card(2)
    expect(page.locator("html")).to_have_attribute("data-lesson-keys", re.compile("Space"))
    page.keyboard.press("Space")
    live.wait_for(lambda status: status.playing)
    page.keyboard.press("Space")
    live.wait_for(lambda status: not status.playing)
    pupil.button("Open everything").click()
    expect(page.locator("[data-dock-region=right]")).to_be_visible()
    page.keyboard.press("2")
    expect(shared.screen.field("Layer")).not_to_have_value("State value")
    page.keyboard.press("1")
    expect(pupil.learn).to_have_text("Back to the lesson")
    pupil.learn.click()
    root(page, "card")
    expect(page.locator("[data-dock-region=right]")).to_be_hidden()
    pupil.expect_card(2)


@pytest.mark.parametrize("name", SIZES)
def test_the_card_stands_beside_the_board_or_below_it(pupil: Pupil, name: str) -> None:
    page = pupil.page
    pupil.start(TITLE)
    width, height = SIZES[name]
    page.set_viewport_size({"width": width, "height": height})
    page.wait_for_function("width => innerWidth === width", arg=width)
    # What fitted before fits until the stage is laid out anew, with the next frame.
    page.evaluate(TWO_FRAMES)
    for presents in (False, True) if name != "a phone" else (False,):
        if presents:
            page.keyboard.press("p")
        page.wait_for_function(FITS)
        board, card = page.evaluate(BOXES)
        if name == "a phone":
            assert board[3] <= card[1] + 1
            pupil.primary.scroll_into_view_if_needed()
            expect(pupil.primary).to_be_in_viewport()
        else:
            assert board[2] <= card[0] + 1
            assert [card[1], card[2], card[3]] == pytest.approx([0, width, height], abs=1)
            assert card[2] - card[0] <= (400 if width == 1366 and not presents else width * 0.4)
            expect(pupil.primary).to_be_in_viewport(ratio=1)
        assert min(board[2] - board[0], board[3] - board[1]) > 0.4 * min(width, height)
        if presents:
            page.keyboard.press("Escape")


def test_a_page_that_is_loaded_anew_is_at_the_same_card(shared: Shared, pupil: Pupil) -> None:
    live, page = shared.live, pupil.page
    pupil.start(TITLE)
    pupil.go_on(1)
    pupil.card.get_by_role("radio").first.check()
    live.wait_for(lambda status: status.stories.on is not None and bool(status.stories.on.answers))
    page.reload()
    shared.screen.settle(live)
    root(page, "card")
    pupil.expect_card(1)
    expect(pupil.card.get_by_role("radio").first).to_be_checked()
    # The list has it, too, and leads back here.
    pupil.button("Lessons").click()
    pupil.button("End the lesson").click()
    expect(page.locator("html:not([data-lesson=card])")).to_have_count(1)
    if pupil.learn.get_attribute("aria-pressed") != "true":
        pupil.learn.click()
    pupil.card.get_by_role("button", name=re.compile(f"^Go on at card 2: {TITLE[:5]}")).click()
    pupil.expect_card(1)


@pytest.mark.parametrize("dark", [False, True])
def test_a_checker_finds_nothing_serious_in_a_lesson(pupil: Pupil, dark: bool) -> None:
    page = pupil.page
    page.emulate_media(color_scheme="dark" if dark else "light")
    pupil.start(TITLE)
    pupil.go_on(1)
    for part in (page, pupil.card_page):
        part.evaluate(f"{AXE};0")
    found: list[Any] = []
    for _ in range(5):
        found = [*page.evaluate(FINDINGS), *pupil.card_page.evaluate(FINDINGS)]
        if not found:
            break
    assert found == []
    page.emulate_media(color_scheme="light")


def test_the_room_that_a_lesson_leaves_is_the_boards(shared: Shared, pupil: Pupil) -> None:
    live: LiveLab = shared.live
    pupil.start(TITLE)
    live.wait_for(lambda status: status.snapshot.trial >= 3_000)
    shared.screen.expect_cell_colours(live.colours())
