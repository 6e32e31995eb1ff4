"""Runs side by side in a real browser: four boards, one bar, and the way back."""

import re
from collections.abc import Iterator

import numpy as np
import pytest
from playwright.sync_api import Frame, FrameLocator, expect

from app.explain.cell import reading_at
from app.live.race import Race, RaceStatus
from app.live.requests import EndRace, Play
from app.live.snapshot import Snapshot
from app.page.side import panel
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from learners.kernel.state import digest
from learners.run import Run
from tests.support.live import PATIENCE_S, SEED, LiveLab, preset_of
from tests.support.races import snapshots_at
from tests.support.screen import Begin, BeginTwo, Screen, Shared, comes_to

FOUR = ("standard_q", "hierarchical_3", "timed", "hierarchical_2")
STEPS = 30_000
SIDE = "iframe.pounce-side"

_MOSTLY = 0.75
"""Share of a board's cells over which nothing is drawn, at least."""

_SHARE = """([board, size, cells, colours, least]) => {
    const canvas = document.querySelectorAll(".tile canvas")[board];
    const side = Math.floor(Math.min(canvas.width, canvas.height) * (1 - 2 * 0.006));
    const left = Math.round((canvas.width - side) / 2);
    const top = Math.round((canvas.height - side) / 2);
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const isAsWanted = (cell, at) => {
        const x = Math.floor(left + ((cell % size) + 0.5) * side / size);
        const y = Math.floor(top + (size - Math.floor(cell / size) - 0.5) * side / size);
        return colours[at].every((part, i) => data[4 * (y * canvas.width + x) + i] === part);
    };
    return cells.filter(isAsWanted).length >= least * cells.length;
}"""
"""Whether so many cells have a colour at their middle, as app/web/player/place.js places them."""


_SCRUBBED = """() => {
    const { moment, scrub } = state;
    return scrub === null && moment && !moment.live && moment.step;
}"""
"""The step that the lab shows once a hand has let go, and not what the hand pointed at."""


def side(screen: Screen) -> FrameLocator:
    """The page with runs side by side."""
    return screen.page.frame_locator(SIDE)


def page_of(screen: Screen) -> Frame:
    """The same as one in which scripts can be run."""
    frame = screen.page.locator(SIDE).element_handle().content_frame()
    assert frame is not None
    return frame


def race_of(live: LiveLab) -> Race:
    race = live.session.race
    assert race is not None
    return race


def race_to(live: LiveLab, step: int) -> RaceStatus:
    """How the race stands once all have made so many steps, and stand still."""
    race = race_of(live)
    race.run_to(step)
    return race.wait_for(lambda status: status.step == step and bool(status.digests), PATIENCE_S)


def start_four(live: LiveLab, screen: Screen) -> RaceStatus:
    """Have the thesis's four race for a while."""
    screen.page.keyboard.press("c")
    side(screen).locator(".choose").get_by_role("button", name="Race the thesis's four").click()
    expect(side(screen).locator(".tile")).to_have_count(4)
    status = race_to(live, STEPS)
    expect(side(screen).locator(".handle")).to_have_text(f"step {STEPS:,}")
    return status


def expect_boards(screen: Screen, shots: tuple[Snapshot, ...], look: Look | None = None) -> None:
    """Wait until each board shows a moment, but for what is drawn over its colours."""
    look = look or Look()
    size = shots[0].spec.world.size
    frame = page_of(screen)
    east, north = np.meshgrid(np.arange(size) - size // 2, np.arange(size) - size // 2)
    cells = np.flatnonzero(np.hypot(east, north) < size // 2 - 1)
    for board, shot in enumerate(shots):
        wanted = LAYERS[look.layer].paint(shot, look, Extras()).colours[cells]
        told = [board, size, cells.tolist(), wanted.tolist(), _MOSTLY]
        frame.wait_for_function(_SHARE, arg=told)


def leave(screen: Screen) -> None:
    """Look at one board, if this page looks at several."""
    if screen.page.locator(SIDE).count():
        screen.page.keyboard.press("c")
    expect(screen.page.locator(SIDE)).to_have_count(0)


@pytest.fixture(autouse=True)
def slow(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs come to where a test wants them when it says so."""
    monkeypatch.setattr(panel, "FIRST_SPEED", 1.0)


@pytest.fixture
def begun(shared: Shared, begin: Begin) -> Iterator[Shared]:
    """A lab in which nothing races, and a page that looks at one board, as it is left."""
    yield Shared(*begin(trial=100))
    leave(shared.screen)
    shared.live.ask(EndRace())


def test_the_thesiss_four_race_in_one_click_and_are_the_same_as_alone(begun: Shared) -> None:
    live, screen = begun
    live.ask(Play())
    status = start_four(live, screen)
    assert not live.session.status.playing
    frame = side(screen)
    for name in FOUR:
        expect(frame.locator(".tile .name", has_text=name)).to_be_visible()
    expect(frame.locator(".standing")).to_contain_text("Four runs, step for step, from the same")
    expect_boards(screen, status.snapshots)
    for board, name in enumerate(FOUR):
        run = Run(preset_of(name), SEED)
        run.advance(STEPS)
        own = digest(run.state)
        assert status.digests[board] == own
        expect(frame.locator(".tile .digest").nth(board)).to_have_text(f"digest {own[:8]}")
    lines = frame.locator(".curves .run-line")
    expect(lines).to_have_count(4)
    dashes = lines.evaluate_all("lines => lines.map(line => line.style.strokeDasharray)")
    widths = lines.evaluate_all("lines => lines.map(line => line.style.strokeWidth)")
    assert len(set(zip(dashes, widths, strict=True))) == 4


def test_scrubbing_shows_all_boards_at_one_step_and_back(begun: Shared) -> None:
    live, screen = begun
    now = start_four(live, screen)
    frame = side(screen)
    frame.locator(".handle").focus()
    screen.page.keyboard.press("Home")
    expect(frame.locator(".handle")).to_have_text("step 0")
    plot = frame.locator(".bar .plot").bounding_box()
    assert plot is not None
    screen.page.mouse.move(plot["x"] + plot["width"] / 4, plot["y"] + 20)
    screen.page.mouse.down()
    screen.page.mouse.move(plot["x"] + plot["width"] / 2, plot["y"] + 20)
    screen.page.mouse.up()
    # Half of the axis of 40,000 steps, and not a place on the way.
    expect(frame.locator(".handle")).to_have_text(re.compile(r"^step (19,[5-9]|20,[0-4])\d\d$"))
    step = comes_to(page_of(screen), "side", _SCRUBBED)
    expect(frame.locator(".handle")).to_have_text(f"step {step:,}")
    assert 0 < step < STEPS
    then = snapshots_at(race_of(live), step)
    assert {shot.step for shot in then} == {step}
    expect_boards(screen, then)
    for board, shot in enumerate(then):
        expect(frame.locator(".tile .trial b").nth(board)).to_have_text(f"{shot.trial:,}")
    frame.get_by_role("button", name="Back to now").click()
    expect(frame.locator(".handle")).to_have_text(f"step {STEPS:,}")
    expect_boards(screen, now.snapshots)


def test_keys_mean_the_runs_and_the_live_run_is_left_alone(begun: Shared) -> None:
    live, screen = begun
    start_four(live, screen)
    before = live.session.status.snapshot
    race = race_of(live)
    race.set_speed(2_000.0)
    keyboard = screen.page.keyboard
    keyboard.press("Space")
    expect(side(screen).get_by_role("button", name="Pause", exact=True)).to_be_visible()
    keyboard.press("Space")
    stood = race.wait_for(lambda status: not status.playing, PATIENCE_S)
    keyboard.press("s")
    race.wait_for(lambda status: status.step == stood.step + 1, PATIENCE_S)
    keyboard.press("k")
    race.wait_for(lambda status: status.speed > 2_000.0, PATIENCE_S)
    keyboard.press("Comma")
    expect(side(screen).locator(".handle")).to_have_text(f"step {stood.step:,}")
    keyboard.press("End")
    expect(side(screen).locator(".handle")).to_have_text(f"step {stood.step + 1:,}")
    # These would add a skill, freeze the selection, and explore.
    for key in ("n", "f", "e"):
        keyboard.press(key)
    status = live.ask()
    assert (status.snapshot.step, status.snapshot.control) == (before.step, before.control)
    keyboard.press("3")
    expect(screen.field("Layer")).to_have_value("Chosen skill")
    expect_boards(screen, race.status.snapshots, Look(layer="chosen"))
    keyboard.press("1")
    keyboard.press("Escape")
    expect(screen.page.locator(SIDE)).to_have_count(0)
    expect(screen.headline).to_be_visible()


def test_one_cell_is_read_in_all_and_two_runs_are_compared(begun: Shared) -> None:
    live, screen = begun
    status = start_four(live, screen)
    frame = side(screen)
    canvas = frame.locator(".tile canvas").nth(1)
    box = canvas.bounding_box()
    assert box is not None
    canvas.hover(position={"x": box["width"] / 4, "y": box["height"] / 2})
    heading = frame.locator(".cell h2")
    expect(heading).to_contain_text("west")
    east = -int(heading.inner_text().split()[2])
    middle = status.snapshots[0].world.size // 2
    visits = [
        sum(option.visits for option in reading_at(shot, middle + east, middle, 0).options)
        for shot in status.snapshots
    ]
    row = frame.locator(".cell tr", has=frame.get_by_text("visits", exact=True)).locator("td")
    if "north" not in heading.inner_text() and "south" not in heading.inner_text():
        assert row.all_inner_texts() == [f"{count:,}" for count in visits]
    frame.get_by_label("One of two runs").select_option(label="standard_q")
    # What the lab says of these two comes after all that it said of those before.
    expect(frame.locator(".apart .text")).to_contain_text("standard_q")
    difference = frame.get_by_label("Map of what is different")
    difference.click()
    expect(frame.locator(".tile")).to_have_count(5)
    expect(frame.locator(".difference .about")).to_contain_text("standard_q")
    expect(frame.locator(".apart .text")).to_contain_text("Different from the start")
    frame.get_by_role("button", name="Go there").click()
    expect(frame.locator(".handle")).to_have_text("step 0")
    # Whoever wants the map has it of the next runs, too.
    difference.click()
    expect(frame.locator(".tile")).to_have_count(4)


def test_the_live_run_stands_beside_a_preset_that_is_chosen(begun: Shared) -> None:
    live, screen = begun
    screen.page.get_by_role("button", name="Side by side", exact=True).click()
    frame = side(screen)
    expect(frame.get_by_label("Run 1", exact=True)).to_have_value(
        f"line {live.session.status.snapshot.generation}"
    )
    frame.get_by_label("Run 2", exact=True).select_option(label="timed")
    frame.get_by_label("Seed of run 2").fill(f"{SEED}")
    frame.get_by_role("button", name="Let them run").click()
    expect(frame.locator(".tile")).to_have_count(2)
    race_of(live).set_speed(float("inf"))
    end = live.session.status.snapshot.step
    race_of(live).wait_for(lambda status: status.step > end, PATIENCE_S)
    race_of(live).pause()
    # The same preset and seed: nothing parts them as far as both are known.
    expect(frame.locator(".apart .text")).to_contain_text("The same as far as both are known")
    expect(frame.locator(".tile .stand").first).to_have_text(f"Step {end:,}: no more is known")
    frame.get_by_role("button", name="Back to one board").click()
    expect(screen.page.locator(SIDE)).to_have_count(0)


def test_each_browser_decides_whether_it_looks(begin_two: BeginTwo) -> None:
    live, one, other = begin_two(trial=100)
    live.ask(EndRace())
    start_four(live, one)
    expect(other.page.locator(SIDE)).to_have_count(0)
    other.expect_cell_colours(live.colours())
    other.page.keyboard.press("c")
    expect(side(other).locator(".tile")).to_have_count(4)
    side(other).locator(".handle").focus()
    other.page.keyboard.press("Home")
    expect(side(other).locator(".handle")).to_have_text("step 0")
    expect(side(one).locator(".handle")).to_have_text(f"step {STEPS:,}")
    race_of(live).set_speed(1_000.0)
    race_of(live).play()
    one.page.keyboard.press("c")
    expect(one.page.locator(SIDE)).to_have_count(0)
    race_of(live).wait_for(lambda status: status.step > STEPS, PATIENCE_S)
    # Nobody looks any more.
    other.page.keyboard.press("c")
    race_of(live).wait_for(lambda status: not status.playing, PATIENCE_S)
    live.ask(EndRace())
