"""In a real browser: what a rule watches, at the moment that is looked at, under the curve."""

import re

import pytest
from playwright.sync_api import Locator, expect

from app.live.watched import Watched
from tests.support.live import LiveLab
from tests.support.schedules import ruled_spec
from tests.support.screen import OpenPage, Screen, StartLab, box_of

CIRCLE = "circle_clockwise"
LATE, EARLY = 600, 120
"""Trials: of the live run, in which circling has joined, and of a moment of the past."""


@pytest.fixture
def lab(start_lab: StartLab) -> LiveLab:
    return start_lab(ruled_spec("trials=2000"), trial=LATE)


def words(screen: Screen) -> Locator:
    return screen.time.locator(".rule .asks")


def watched(live: LiveLab, trial: int) -> Watched:
    """What is watched at a moment, as the run itself has it."""
    return live.session.snapshot_at(live.place_of(trial)).watched[-1]


def outlook(one: Watched, now: str, that: str) -> str:
    fires = int(one.fires[-1])
    rate = "not falling" if fires < 0 else f"at {that} rate at trial {fires:,}"
    return f"{float(f'{one.values[-1]:.2g}'):g} {now}; {rate}"


def test_it_is_said_of_the_moment_that_is_looked_at(lab: LiveLab, open_page: OpenPage) -> None:
    screen = open_page(lab)
    said = words(screen)
    now = outlook(watched(lab, LATE), "now", "this")
    expect(said).to_contain_text(f"Avoid joins below 0.2: {now}")
    # Both stretches are there, and that the first was met.
    expect(screen.time.locator(".rule .watched")).to_have_count(2)
    expect(screen.time.locator(".rule .met")).to_have_count(1)
    screen.tell("seek_trial", trial=EARLY)
    then = outlook(watched(lab, EARLY), "then", "that")
    expect(said).to_contain_text(f"Circle clockwise joins below 0.2: {then}")
    row = screen.time.locator(".rule")
    expect(row).to_have_attribute("title", re.compile("the last 50 trials visit fewer than 0.2"))
    screen.turn_to("Run")
    assert screen.reads(f"joins by its rule, below 0.2: {then}")
    screen.tell("seek_trial", trial=30)
    expect(said).to_contain_text("known from trial 60 on")
    # Just before the skill joins, and when it has.
    met = lab.session.status.snapshot.watched[0].until
    assert met is not None
    screen.tell("seek_trial", trial=met)
    expect(said).to_contain_text(f"then; at that rate at trial {met}")
    screen.tell("seek_trial", trial=met + 1)
    expect(said).to_contain_text(f"Avoid joins below 0.2: known from trial {met + 20 + 50} on")
    screen.tell("live")
    expect(said).to_contain_text(now)


def test_where_it_would_be_met_a_line_leads_to_the_lane(lab: LiveLab, open_page: OpenPage) -> None:
    screen = open_page(lab)
    screen.tell("seek_trial", trial=EARLY)
    then = outlook(watched(lab, EARLY), "then", "that")
    expect(words(screen)).to_contain_text(f"Circle clockwise joins below 0.2: {then}")
    line = screen.time.locator(".meets")
    expect(line).to_be_visible()
    screen.rest()
    fires = int(watched(lab, EARLY).fires[-1])
    axis = box_of(screen.time.locator(".axis > .plot"))
    lane = box_of(screen.time.locator(f'.lane[data-skill="{CIRCLE}"]'))
    box = box_of(line)
    assert box.left == pytest.approx(axis.left + axis.width * fires / 2_000, abs=2)
    assert box.top + box.height == pytest.approx(lane.top + lane.height, abs=2)


def test_by_hand_a_skill_joins_earlier_in_a_branch_and_its_rule_goes_on_from_there(
    lab: LiveLab, open_page: OpenPage
) -> None:
    screen = open_page(lab)
    screen.tell("seek_trial", trial=EARLY)
    screen.turn_to("Run")
    expect(words(screen)).to_contain_text("Circle clockwise joins")
    screen.click("Add circle clockwise now")
    since = EARLY + 20 + 50
    expect(words(screen)).to_contain_text(f"Avoid joins below 0.2: known from trial {since} on")
    # The live run has it as it was.
    screen.tell("live")
    expect(words(screen)).to_contain_text(outlook(watched(lab, LATE), "now", "this"))


def test_without_a_rule_there_is_nothing_of_it(start_lab: StartLab, open_page: OpenPage) -> None:
    screen = open_page(start_lab())
    expect(screen.time.locator(".curve")).to_be_visible()
    expect(screen.time.locator(".rule")).to_be_hidden()
    expect(screen.time.locator(".meets")).to_be_hidden()
