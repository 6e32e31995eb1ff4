"""A session that the lab kept is taken up again in a real page, from its tab *File*."""

import re
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

from app.live.requests import AddMark, Branch
from app.live.status import Status
from learners.commands import FreezeSkills, SetParameter
from tests.support.live import LiveLab, preset_of
from tests.support.screen import OpenPage, StartLab

LEFT = 900
"""The trial at which the session was left."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "sessions"


def a_session_of(folder: Path, tmp_path: Path) -> Status:
    """Do something in a lab, and end it; what was last true there."""
    live = LiveLab(preset_of(), 20_000.0, tmp_path / "results", sessions=folder)
    try:
        live.go_to_trial(LEFT)
        place = live.place_of(500)
        branch = Branch(place, SetParameter("learner.epsilon", 0.3))
        live.ask(FreezeSkills(True), AddMark(place, "the cone closes"), branch)
        return live.wait_for(lambda status: len(status.lines) == 2)
    finally:
        live.close()


def test_an_earlier_session_goes_on_where_it_was_left(
    start_lab: StartLab, open_page: OpenPage, folder: Path, tmp_path: Path
) -> None:
    left = a_session_of(folder, tmp_path)
    live = start_lab(trial=40, sessions=folder)
    screen = open_page(live)
    expect(screen.reading("Trial")).to_have_text("40")

    screen.turn_to("File")
    choice = screen.field("Session")
    screen.unfold("Earlier sessions", choice)
    # That of this lab is in use, and so is not offered.
    expect(choice).to_have_value(re.compile(rf" · timed, seed 3 · trial {LEFT} · \d commands?$"))
    screen.click("Resume")
    status = live.wait_for(lambda status: status.snapshot.step == left.snapshot.step)
    np.testing.assert_array_equal(status.snapshot.value, left.snapshot.value)
    assert status.snapshot.control.skills_frozen
    assert [line.name for line in status.lines] == [line.name for line in left.lines]
    assert [mark.text for mark in status.marks] == ["the cone closes"]
    assert not status.playing
    # The one that was on the board is offered now, and this one is not.
    expect(choice).to_have_value(re.compile(" · timed, seed 3 · trial 40 · 0 commands$"))

    screen.turn_to("Now")
    expect(screen.reading("Trial")).to_have_text(f"{LEFT}")
    expect(screen.checkbox("Freeze skills")).to_be_checked()
    screen.expect_cell_colours(live.colours())
    expect(screen.time.locator(".tree .line")).to_have_count(2)
    expect(screen.time.locator(".mark.note")).to_have_text("the cone closes")
    # It is learned and kept on.
    screen.click("One trial")
    live.wait_for(lambda status: status.snapshot.trial == LEFT + 1)
    screen.checkbox("Freeze skills").click()
    live.wait_for(lambda status: not status.snapshot.control.skills_frozen)
    assert live.session.status.journal is None
