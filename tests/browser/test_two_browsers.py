"""Several people at one session: each sees it in a way of their own, and stops no other."""

import math

import pytest
from playwright.sync_api import expect

from app.picture.look import Look
from app.picture.theme import DARK, LIGHT
from tests.support.live import PATIENCE_S
from tests.support.moments import expect_moment
from tests.support.screen import BeginTwo

LEARNED = 2_000
"""Trials after which there is a cone in the small world."""


def test_two_browsers_see_one_session_each_in_its_own_way(begin_two: BeginTwo) -> None:
    live, one, other = begin_two(trial=LEARNED)
    other.turn_to_overlays()
    other.check("Dark")
    other.choose("Value as", "Its size")
    one.choose("Layer", "Visits")
    dark, visits = Look(theme=DARK, scale="linear"), Look(layer="visits")
    other.expect_cell_colours(live.colours(dark))
    one.expect_cell_colours(live.colours(visits))
    expect(other.legend).not_to_contain_text("as steps to capture")
    expect(one.legend).to_contain_text("visit")
    scheme = "() => document.documentElement.dataset.mantineColorScheme"
    assert (one.page.evaluate(scheme), other.page.evaluate(scheme)) == ("light", "dark")

    other.checkbox("Freeze skills").click()
    expect(one.checkbox("Freeze skills")).to_be_checked()
    one.click("One trial")
    live.wait_for(lambda status: status.snapshot.trial == LEARNED + 1)
    for screen in (one, other):
        expect(screen.reading("Trial")).to_have_text(f"{LEARNED + 1:,}")
    other.expect_cell_colours(live.colours(dark))
    one.choose("Layer", "State value")
    one.expect_cell_colours(live.colours())
    expect(one.legend).to_contain_text("as steps to capture")
    assert (live.colours()[0] == LIGHT.unknown).all()
    assert (live.colours(dark)[0] == DARK.unknown).all()

    units = [screen.time.get_by_role("button", name="steps", exact=True) for screen in (one, other)]
    units[0].click()
    expect(units[0]).to_have_attribute("aria-pressed", "true")
    expect(units[1]).to_have_attribute("aria-pressed", "false")
    one.time.get_by_role("button", name="trial", exact=True).click()
    other.choose("Value as", "Steps to capture")
    other.check("Dark", False)


def test_starting_again_asks_where_others_look_and_everybody_can_undo(
    begin_two: BeginTwo, monkeypatch: pytest.MonkeyPatch
) -> None:
    # However slow the pages are, there is time to get to what was just said.
    monkeypatch.setattr("app.page.panels.said.SHOWN_S", math.inf)
    live, one, other = begin_two(trial=LEARNED)
    former = live.session.status.snapshot.generation
    other.click("Start again")
    dialog = other.page.get_by_role("dialog")
    expect(dialog).to_contain_text("1 other browser looks at this run.")
    dialog.get_by_role("button", name="No", exact=True).click()
    expect(dialog).to_have_count(0)
    assert live.ask().snapshot.generation == former
    other.click("Start again")
    dialog.get_by_role("button", name="Start again for all", exact=True).click()
    live.wait_for(lambda status: status.snapshot.step == 0)
    for screen in (one, other):
        expect(screen.said).to_contain_text("Started again: timed, seed 3")
    # The key does what the button does, and a change of the learner is undone by it as well.
    one.page.keyboard.press("u")
    live.wait_for(lambda status: status.snapshot.generation == former)
    one.page.keyboard.press("f")
    expect(other.said).to_contain_text(f"Selection frozen at trial {LEARNED:,}")
    other.said.get_by_role("button", name="Undo").click()
    live.wait_for(lambda status: not status.snapshot.control.selection_frozen)
    expect(one.said).to_contain_text("Undone: selection frozen")


def test_two_pages_look_at_two_moments_and_a_reload_is_live(begin_two: BeginTwo) -> None:
    live, one, other = begin_two(trial=LEARNED)
    now = live.session.status.snapshot
    first, second = live.stopped_at(now.step // 4), live.stopped_at(now.step // 2)
    one.tell("seek", step=first.step)
    other.tell("seek", step=second.step)
    expect_moment(live, one, first)
    expect_moment(live, other, second)
    other.tell("by", unit="trials", n=1)
    expect(other.reading("Trial")).to_have_text(f"{second.trial + 1:,}")
    expect_moment(live, one, first)
    one.page.reload()
    one.settle(live)
    expect_moment(live, one, now)
    expect(other.reading("Trial")).to_have_text(f"{second.trial + 1:,}")


def test_a_closed_browser_stops_nothing(begin_two: BeginTwo) -> None:
    live, one, other = begin_two()
    live.gone.clear()
    one.turn_to("File")
    assert one.reads("2 viewers of this session.")
    other.click("Play")
    live.wait_for(lambda status: status.snapshot.step > 1_000)
    other.page.close()
    assert live.gone.wait(PATIENCE_S)
    gone_at = live.session.status.snapshot.step
    live.wait_for(lambda status: status.snapshot.step > gone_at + 10_000)
    one.click("Pause")
    status = live.wait_for(lambda status: not status.playing)
    assert one.reads("1 viewer of this session.")
    one.turn_to("Now")
    expect(one.reading("Steps")).to_have_text(f"{status.snapshot.step:,}")
    one.expect_cell_colours(live.colours())
    assert status.error is None
