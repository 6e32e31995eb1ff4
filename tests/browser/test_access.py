"""The page for those who do not see it, see little or see no hues; and when it is zoomed."""

import re
from typing import Any

import pytest
from playwright.sync_api import expect

from learners.commands import Introduce
from tests.support.access import AXE, FINDINGS
from tests.support.live import small_experiment
from tests.support.screen import VIEWPORT, Screen, Shared

OF_VISER: tuple[tuple[str, str], ...] = ()
"""Rule and selector of what is viser's own and cannot be mended from outside: nothing so far."""
# Controls that are seen and have no name.
NAMELESS = """() => {
    const text = id => document.getElementById(id)?.textContent ?? "";
    const isNameless = node => {
        const by = (node.getAttribute("aria-labelledby") ?? "").split(" ").map(text).join("");
        const labels = Array.from(node.labels ?? [], label => label.textContent).join("");
        const own = node.matches("input") ? "" : node.textContent;
        return ![node.ariaLabel ?? "", by, labels, own].some(name => name.trim());
    };
    const kinds = "button, input, [role=slider], [role=tab], [role=button], a[href]";
    return [...document.querySelectorAll(kinds)]
        .filter(node => node.checkVisibility() && node.getClientRects().length && isNameless(node))
        .map(node => node.outerHTML);
}"""
# What is behind a frame is behind what is in it, which the checker takes to be white.
SHOW_BEHIND = """() => {
    const colour = node => getComputedStyle(node).backgroundColor;
    let behind = window.frameElement;
    while (behind.parentElement && /^(transparent|rgba.*, 0\\))$/.test(colour(behind)))
        behind = behind.parentElement;
    document.documentElement.style.backgroundColor = colour(behind);
}"""
IS_LARGER = "() => document.documentElement.style.getPropertyValue('--stage-scale') > 1.4"
BEHIND_TABS = [("Now", "Run"), ("Now", "Steer"), ("Inspect", "Experiments"), ("File", "Plan")]


def expect_no_findings(screen: Screen) -> None:
    """Have the checker look at the page, again as long as something fades in or out there.

    It looks into a frame where it is at home there, too, and waits in vain where it is not.
    """
    for page in (screen.page, screen.time_page):
        if not page.evaluate("() => 'axe' in window"):
            page.evaluate(f"{AXE};0")
    screen.time_page.evaluate(SHOW_BEHIND)
    found: list[Any] = []
    for _ in range(5):
        found = screen.page.evaluate(FINDINGS)
        found = [one for one in found if (one[0], one[1]) not in OF_VISER]
        if not found:
            screen.time_page.evaluate("document.documentElement.style.backgroundColor = ''")
            return
    pytest.fail(f"{len(found)} findings: {found[:8]}")


def turn_to(screen: Screen, left: str, right: str) -> None:
    """Turn both side panels."""
    screen.turn_to(left)
    screen.turn_to(right)


def dress(screen: Screen, dark: bool) -> None:
    """Make the page dark or light."""
    screen.turn_to_overlays()
    screen.check("Dark", dark)
    scheme = "dark" if dark else "light"
    expect(screen.page.locator("html")).to_have_attribute("data-mantine-color-scheme", scheme)


@pytest.mark.parametrize("dark", [False, True])
def test_a_checker_finds_nothing_serious_behind_any_tab(shared: Shared, dark: bool) -> None:
    screen = shared.screen
    dress(screen, dark)
    for left, right in BEHIND_TABS:
        turn_to(screen, left, right)
        if right == "Steer" and not dark:
            screen.unfold("Other skills", screen.button("Add my own skill now"))
        expect_no_findings(screen)
    dialog = screen.page.get_by_role("dialog")
    for opens in (lambda: screen.page.keyboard.press("h"), screen.button("Tour").click):
        opens()
        expect(dialog).to_be_visible()
        expect_no_findings(screen)
        screen.page.keyboard.press("Escape")
        expect(dialog).to_have_count(0)
    screen.page.keyboard.press("p")
    expect(screen.page.locator("html")).to_have_attribute("data-present", "")
    expect_no_findings(screen)
    screen.page.keyboard.press("Escape")


def test_a_checker_finds_nothing_serious_in_a_large_window_and_on_a_phone(shared: Shared) -> None:
    screen = shared.screen
    page, stage = screen.page, screen.page.locator("#pounce-stage")
    page.set_viewport_size({"width": 1920, "height": 1080})
    page.wait_for_function(IS_LARGER)
    expect_no_findings(screen)
    page.set_viewport_size({"width": 390, "height": 844})
    expect(stage).to_have_attribute("data-shape", "stack")
    expect_no_findings(screen)
    sheet = page.get_by_text("pounce", exact=True)
    sheet.click()
    expect(screen.button("One trial")).to_be_visible()
    expect_no_findings(screen)
    sheet.click()
    page.set_viewport_size(VIEWPORT)
    expect(stage).not_to_have_attribute("data-shape", "stack")


def test_a_checker_finds_nothing_serious_in_the_results(shared: Shared) -> None:
    live, screen = shared
    live.run_to_end(small_experiment(n_seeds=2))
    screen.show_results()
    for dark in (True, False):
        dress(screen, dark)
        expect_no_findings(screen)
    # As on a page that is zoomed by 200 %.
    screen.page.set_viewport_size({"width": 683, "height": 384})
    screen.close_results()
    screen.page.set_viewport_size(VIEWPORT)


def test_every_control_and_the_board_have_names(shared: Shared) -> None:
    screen = shared.screen
    for left, right in BEHIND_TABS:
        turn_to(screen, left, right)
        # What a tab shows has its names as soon as it is there for those who give them.
        screen.page.wait_for_function(f"() => ({NAMELESS})().length === 0")
    assert screen.time_page.evaluate(NAMELESS) == []
    screen.turn_to("Now")
    board = screen.page.get_by_role("img", name=re.compile("^The board, 40 by 40 cells"))
    expect(board).to_have_attribute("aria-label", re.compile(r"Layer: State value\. Paused\."))
    screen.choose("Layer", "Policy flow")
    expect(board).to_have_attribute("aria-label", re.compile(r"Layer: Policy flow\. "))
    expect(screen.time.get_by_role("img", name="Learning curve")).to_be_visible()


NAMES = """() => Object.entries(window.__viserSceneTree.getState())
    .filter(([name]) => name.startsWith("/board/names/"))
    .map(([_, node]) => node.message.props.text)"""


def test_skills_stand_written_where_they_are_chosen(shared: Shared) -> None:
    live, screen = shared
    live.ask(Introduce("circle_clockwise", 10))
    live.go_to_trial(2_000)
    screen.turn_to("Now")
    screen.choose("Layer", "Chosen skill")
    for name in ("approach", "circle clockwise"):
        screen.page.wait_for_function(f"name => ({NAMES})().includes(name)", arg=name)
