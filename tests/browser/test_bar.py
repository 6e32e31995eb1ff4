"""The bar below the board in a real browser, and the tab in which the plan is changed."""

import re
from collections.abc import Callable
from typing import Any

from playwright.sync_api import expect

from app.live.session import Status
from learners.commands import Introduce
from tests.support.screen import Begin

NOTHING = "\N{EN DASH} nothing \N{EN DASH}"


def schedule_is(test: Callable[[Any], bool]) -> Callable[[Status], bool]:
    """Whether a status has a schedule like that."""
    return lambda status: test(status.snapshot.spec.schedule)


def test_a_block_is_chosen_by_a_click_and_moved_and_the_past_is_not_offered(begin: Begin) -> None:
    live, screen = begin(trial=100)
    timer = live.session.status.snapshot.spec.schedule.skills["circle_clockwise"]
    screen.page.get_by_role("link", name=re.compile("^circle clockwise joins at")).click()
    # Where it is changed is shown at once.
    expect(screen.field("Change")).to_have_value("circle clockwise: joins")
    screen.field("Change").click()
    expect(screen.page.get_by_role("option")).to_have_text(
        [
            NOTHING,
            "circle clockwise: joins",
            "circle clockwise: exploration",
            "avoid: joins",
            "avoid: exploration",
            "approach: new exploration",
            "circle clockwise: new exploration",
            "avoid: new exploration",
        ]
    )
    screen.page.keyboard.press("Escape")
    screen.click("+500")
    moved = schedule_is(lambda plan: plan.skills["circle_clockwise"].at == timer.at + 500)
    status = live.wait_for(moved)
    assert status.snapshot.spec.schedule.freeze_of("circle_clockwise") == timer.freeze
    expect(screen.field("At trial")).to_have_value(f"{timer.at + 500:,}")
    assert screen.reads(f"joins at {timer.at + 500:,}")

    # What has the focus keeps it while the bar goes on.
    avoid = screen.page.get_by_role("link", name=re.compile("^avoid joins at"))
    avoid.focus()
    live.go_to_trial(110)
    expect(screen.page.locator(".pounce-bar .here")).to_have_text("110")
    expect(avoid).to_be_focused()

    # Near enough, and its time comes.
    screen.fill("At trial", "150")
    screen.click("Apply")
    live.wait_for(schedule_is(lambda plan: plan.skills["circle_clockwise"].at == 150))
    status = live.go_to_trial(160)
    assert status.snapshot.present == ("approach", "circle_clockwise")
    expect(screen.field("Change")).to_have_value(NOTHING)
    expect(screen.page.get_by_role("link", name=re.compile("^circle clockwise"))).to_have_count(0)


def test_curves_and_lanes_share_an_axis(begin: Begin) -> None:
    live, screen = begin("timed", "trials=1000", trial=500)
    live.ask(Introduce("circle_clockwise", 100))
    live.go_to_trial(1_000)
    bar = screen.page.locator(".pounce-bar")
    # A dot at the end of the run, and only there, since it has fewer than 2,000 trials.
    dots = bar.locator("path.dots")
    expect(dots).to_have_attribute("d", re.compile(r"^M1000\.0 [\d.]+h0$"))
    # Two windows of trials, the first of them level.
    line = bar.locator("path.learned")
    expect(line).to_have_attribute("d", re.compile(r"^M0\.0 [\d.]+L500\.0 [\d.]+L1000\.0 "))
    assert screen.reads("joined at 500")
    expect(bar.locator("path.ghost")).to_be_attached()
    assert screen.reads("the preset's own run")
    link = bar.locator(".axis").get_by_role("link")
    expect(link).to_have_text("steps")
    link.click()
    expect(link).to_have_text("trial")
    assert len(screen.page.context.pages) == 1
    link.click()
    expect(link).to_have_text("steps")
