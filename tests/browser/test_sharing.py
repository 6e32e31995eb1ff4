"""A session is shared from one lab and opened in another, in real pages: by a file or a link."""

import base64
import re
import zlib
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest
from playwright.sync_api import expect

from app.live.branching import run_at
from app.live.requests import AddMark, Branch
from app.live.status import Status
from app.live.written import read
from learners.commands import FreezeSkills, SetParameter
from learners.kernel.state import digest
from tests.support.live import LiveLab
from tests.support.screen import Begin, OpenPage, Screen, Shared, StartLab

SHARED = 700
"""The trial at which something is shared."""
SHOWN = f"?fixedDpr={LiveLab.dpr}"
"""How a page is drawn, as any other of a lab in tests."""


@pytest.fixture
def theirs(begin: Begin) -> Shared:
    """A lab in which something was done, with a branch, and a page of it."""
    live, screen = begin(trial=300)
    live.ask(FreezeSkills(True))
    live.go_to_trial(SHARED)
    place = live.place_of(500)
    branch = Branch(place, SetParameter("learner.epsilon", 0.3))
    live.ask(AddMark(place, "the <b>cone</b> closes"), branch)
    live.wait_for(lambda status: len(status.lines) == 2)
    screen.turn_to("File")
    screen.check("All lines", False)
    return Shared(live, screen)


def tables(live: LiveLab) -> str:
    """Digest of the live run's tables."""
    past = live.session.past_of(live.session.status.snapshot.generation)
    assert past is not None
    return digest(run_at(past, past.end_step).state)


def downloaded(screen: Screen, folder: Path) -> Path:
    """The file that the page gives to keep."""
    with screen.page.expect_download() as download:
        screen.click("Download session")
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


def expect_opened(screen: Screen, live: LiveLab, theirs: LiveLab) -> Status:
    """Wait until a lab has the line that was shared, and says that it is the same."""
    expect(screen.notice("Opened")).to_contain_text("Digest as recorded: same.")
    status = live.session.status
    there = theirs.session.status.snapshot
    assert (status.snapshot.step, status.snapshot.seed) == (there.step, there.seed)
    assert tables(live) == tables(theirs)
    np.testing.assert_array_equal(status.snapshot.value, there.value)
    assert status.snapshot.control.skills_frozen
    assert [mark.text for mark in status.marks] == ["the <b>cone</b> closes"]
    assert not status.playing
    screen.expect_cell_colours(live.colours())
    return status


def test_a_file_from_one_lab_is_the_same_run_in_another(
    start_lab: StartLab, open_page: OpenPage, theirs: Shared, tmp_path: Path
) -> None:
    screen = theirs.screen
    path = downloaded(screen, tmp_path)
    assert screen.reads("Not in it: 1 other line.")
    assert path.stat().st_size < 4_000
    assert screen.reads(f"{path.name}, ")

    mine = start_lab(trial=40, sessions=tmp_path / "sessions")
    other = open_page(mine)
    other.turn_to("File")
    other.upload("Open session", path.name, path.read_text())
    status = expect_opened(other, mine, theirs.live)
    assert [line.name for line in status.lines] == ["first run"]
    expect(other.time.locator(".mark.note")).to_have_text("the <b>cone</b> closes")
    # It is learned and kept on, and the file stays as it was.
    other.turn_to("Now")
    other.click("One trial")
    mine.wait_for(lambda status: status.snapshot.trial == SHARED + 1)
    assert mine.session.status.journal is None
    files = sorted((tmp_path / "sessions").glob("*.pounce"))
    assert all("-timed-seed3" in file.name for file in files)
    assert len(files) == 2
    assert read(files[-1]).records[:2] == read(path).records[:2]


def test_a_link_opens_in_the_lab_that_is_reached(
    start_lab: StartLab, open_page: OpenPage, theirs: Shared, tmp_path: Path
) -> None:
    screen = theirs.screen
    screen.check("All lines")
    assert screen.reads("What is shared: all 2 lines, with names and marks.")
    screen.click("Copy link")
    expect(screen.text("Copied: the link to 2 lines")).to_be_visible()
    assert screen.reads("so for others the link leads to a lab of theirs at the same port")
    link: str = screen.page.evaluate("navigator.clipboard.readText()")
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/s/[A-Za-z0-9_-]{200,2500}", link)

    mine = start_lab(trial=40, sessions=tmp_path / "sessions")
    other = open_page(mine)
    there = urlsplit(mine.url)
    other.page.goto(f"{there.scheme}://{there.netloc}{urlsplit(link).path}{SHOWN}")
    other.settle(mine)
    # What came in the address is asked for once: the page that is loaded anew does not.
    expect(other.page).to_have_url(re.compile(re.escape(SHOWN) + "$"))
    dialog = other.page.get_by_role("dialog")
    expect(dialog).to_contain_text(
        "timed, seed 3; 2 commands; 2 lines, the live one up to trial 700"
    )
    assert mine.session.status.snapshot.trial == 40
    dialog.get_by_role("button", name="Open", exact=True).click()
    status = expect_opened(other, mine, theirs.live)
    assert [line.name for line in status.lines] == [
        line.name for line in theirs.live.session.status.lines
    ]
    expect(other.time.locator(".tree .line")).to_have_count(2)


def test_what_is_no_session_changes_nothing_and_is_said(begin: Begin) -> None:
    mine, screen = begin(trial=40)
    screen.turn_to("File")
    screen.upload("Open session", "<b>my.pounce", "no session")
    dialog = screen.page.get_by_role("dialog")
    expect(dialog).to_contain_text("<b>my.pounce: is no session of pounce")
    dialog.get_by_role("button", name="Close").first.click()
    # Of some thousand characters, and a thousand times as many once it is unpacked.
    bomb = base64.urlsafe_b64encode(zlib.compress(b"{" + b" " * 2**22)).decode().rstrip("=")
    screen.page.goto(f"{mine.lab.url}/s/{bomb}{SHOWN}")
    screen.settle(mine)
    expect(dialog).to_contain_text("the link: is too large; allowed: up to 256 KiB")
    assert mine.session.status.snapshot.trial == 40
