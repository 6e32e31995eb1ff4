"""The real page in a real browser: what a person does has its effect, and shows."""

import contextlib
import math
import os
import queue
import re
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import viser
from playwright.sync_api import BrowserContext, Page, expect

from app.live.requests import Play, StartAgain
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.live.worker import FULL_SPEED
from app.page import lab as lab_module
from app.page.lab import Browser
from app.page.panels.controls import Controls
from app.picture.frames import rim
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from app.picture.outlines import BOARD_UNITS, on_picture
from app.picture.raster import on_raster, raster
from app.picture.shading import SHOWN_FROM, known_of, nearness
from app.picture.theme import LIGHT
from app.player.hunts import way_of
from learners.commands import SetSchedule
from learners.control import Episode
from learners.run import Run
from learners.schedule_spec import SkillTimer
from sim import geometry
from sim.rng import MAX_SEED
from tests.support.live import PATIENCE_S, LiveLab, preset_of
from tests.support.screen import Begin, StartLab, colours_in, picture
from tests.support.server import CAMERA
from tests.support.server import Page as Visitor

ROOT = Path(__file__).resolve().parents[2]
LEARNED = 2_000
"""Trials after which there is a cone in the small world."""

DIFFERS_FROM = """colour => {
    const { colors } = window.__viserSceneTree.getState()["/board/cells"].message.props;
    return colors.some((part, i) => part !== colour[i % 3]);
}"""


def clear_cells(snapshot: Snapshot) -> np.ndarray:
    """Cells of the round board with nothing drawn over them."""
    size = snapshot.spec.world.size
    east, north = np.meshgrid(np.arange(size) - size // 2, np.arange(size) - size // 2)
    away = np.hypot(east, north)
    clear = (away < rim(snapshot.spec.world) - 1) & (away > 4)
    # Lines run along every tenth cell, across the prey, and round what it sees.
    clear &= (east % 10 != 0) & (north % 10 != 0)
    clear &= (east < 0) | (abs(away - 9) > 1.5)
    # The way of the trial that is shown, how the last ones ended, and a word at the predator.
    way, ends = way_of(snapshot, rests=True), snapshot.ends
    path = on_picture(snapshot.world, way.cells, way.heading, shown=0)
    cells, headings = (
        np.array([getattr(end, part) for end in ends]) for part in ("cell", "heading")
    )
    dots = on_picture(snapshot.world, cells, headings, shown=0) if ends else path
    for places, cells_apart in ((path, 1.5), (dots, 3), (path[-1:], 8)):
        x, y = (places.T * size / BOARD_UNITS)[..., None, None]
        clear &= (np.hypot(east - x, north - y) > cells_apart).all(axis=0)
    # And along the edge of value, and where it is equal.
    for contour in LAYERS["value"].paint(snapshot, Look(), Extras()).over().contours:
        ends = contour.segments.transpose(1, 2, 0)[..., None, None]
        for share in (0.0, 0.25, 0.5, 0.75, 1.0):
            x, y = ends[0] * (1 - share) + ends[1] * share
            clear &= (np.hypot(east - x, north - y) > 1.5).all(axis=0)
    return np.flatnonzero(clear)


# Loading


def test_the_page_loads_with_all_there_is_to_read(begin: Begin) -> None:
    live, screen = begin()
    asked_for: list[str] = []
    screen.page.goto("about:blank")
    screen.page.on("request", lambda request: asked_for.append(request.url))
    screen.open(live)
    expect(screen.page.locator('[data-slot-of="task"]')).to_contain_text("from behind")
    expect(screen.headline).to_contain_text(
        "Paused. One skill: approach. It is practised until trial 300"
    )
    expect(screen.reading("Trial")).to_have_text("0")
    expect(screen.reading("Steps")).to_have_text("0")
    expect(screen.reading("Success")).to_have_text("\N{EN DASH}")
    expect(screen.reading("States of value")).to_have_text("0")
    expect(screen.page.get_by_title("States worth more than 0, of 3,456")).to_be_visible()
    expect(screen.legend).to_contain_text("Value of a place, as steps to capture")
    assert (screen.cell_colours() == LIGHT.unknown).all()
    assert asked_for
    assert [url for url in asked_for if not url.startswith((live.lab.url, "data:", "blob:"))] == []


# The picture


def test_the_heat_map_changes_while_the_predator_learns(begin: Begin) -> None:
    live, screen = begin()
    screen.turn_to_overlays()
    screen.check("Trail", False)
    unknown = screen.cell_colours()
    assert (unknown == LIGHT.unknown).all()
    screen.click("Play")
    screen.page.wait_for_function(DIFFERS_FROM, arg=unknown[0].tolist())
    assert live.session.status.playing
    screen.click("Pause")
    status = live.wait_for(lambda status: not status.playing)
    colours = live.colours()
    screen.expect_cell_colours(colours)
    clear = clear_cells(status.snapshot)
    cell = int(clear[np.abs(colours[clear].astype(int) - LIGHT.unknown).sum(axis=1).argmax()])
    assert colours[cell].tolist() != list(LIGHT.unknown)
    screen.expect_pixel(screen.place_of(cell), colours[cell])


def test_colours_on_the_screen_are_the_servers_and_the_legends(begin: Begin) -> None:
    live, screen = begin(trial=LEARNED)
    colours = live.colours()
    screen.expect_cell_colours(colours)
    snapshot = live.session.status.snapshot
    world = snapshot.spec.world
    values, pixels = geometry.fold(snapshot.value, world.n_directions), raster(world)
    known = known_of(values, world.capture_reward, snapshot.spec.learner.gamma)
    share = on_raster(known.positive_share, pixels)
    steps = on_raster(known.steps, pixels)
    clear = clear_cells(snapshot)
    of_board = (colours == LIGHT.unknown).all(axis=1)

    cell = int(clear[share[clear] >= SHOWN_FROM][0])
    screen.expect_pixel(screen.place_of(cell), colours[cell])
    bar = screen.legend.locator("div[style*=gradient]").first
    seen = picture(bar.screenshot())
    level = float(nearness(steps[cell]))
    on_bar = seen[seen.shape[0] // 2, round(level * (seen.shape[1] - 1))]
    assert np.abs(on_bar.astype(int) - colours[cell]).max() <= 6

    swatch = screen.legend.locator("span[style*=background]", has_not_text=re.compile("."))
    styles = [swatch.nth(i).get_attribute("style") or "" for i in range(swatch.count())]
    assert list(LIGHT.unknown) in [colour for style in styles for colour in colours_in(style)]
    # From the middle, where nothing of the stage casts a shadow.
    empty = clear[of_board[clear]]
    nowhere = int(empty[len(empty) // 2])
    screen.expect_pixel(screen.place_of(nowhere), np.array(LIGHT.unknown))


def test_a_reload_shows_the_present(begin: Begin) -> None:
    live, screen = begin()
    screen.checkbox("Freeze skills").click()
    live.wait_for(lambda status: status.snapshot.control.skills_frozen)
    status = live.go_to_trial(LEARNED)
    screen.page.reload()
    screen.settle(live)
    expect(screen.reading("Trial")).to_have_text(f"{LEARNED:,}")
    expect(screen.reading("Steps")).to_have_text(f"{status.snapshot.step:,}")
    expect(screen.headline).to_contain_text("as a cone")
    expect(screen.checkbox("Freeze skills")).to_be_checked()
    screen.expect_cell_colours(live.colours())
    assert (live.colours() != LIGHT.unknown).any()


def test_a_browser_that_leaves_before_it_is_welcomed_is_forgotten(
    start_lab: StartLab, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: queue.SimpleQueue[int] = queue.SimpleQueue()

    class Watched(Browser):
        def update(self, *moment: Any) -> None:
            drawn.put(self.client.client_id)

    monkeypatch.setattr(lab_module, "Browser", Watched)
    live = start_lab()
    port = live.lab.server.get_port()
    busy, go_on = threading.Event(), threading.Event()
    live.lab.inbox.put(lambda: (busy.set(), go_on.wait(PATIENCE_S)))
    assert busy.wait(PATIENCE_S)
    hasty, patient = Visitor(port), Visitor(port)
    hasty.send(CAMERA)
    hasty.close()
    patient.send(CAMERA)
    # Both are there for viser, and the first has gone, before the lab comes to its welcome.
    while [*live.lab.server.get_clients()] != [1]:
        live.gone.wait(0.005)
    go_on.set()
    assert [drawn.get(timeout=PATIENCE_S) for _ in range(4)] == [1, 1, 1, 1]
    assert [browser.client.client_id for browser in live.lab.browsers] == [1]
    patient.close()


# Play and pause


def test_pause_play_and_single_steps(begin: Begin) -> None:
    live, screen = begin(trial=10)
    start = live.session.status.snapshot.step
    for made in (1, 2):
        screen.click("One step")
        status = live.wait_for(lambda status, made=made: status.snapshot.step >= start + made)
        assert (status.snapshot.step, status.playing) == (start + made, False)
    screen.click("One trial")
    status = live.wait_for(lambda status: status.snapshot.trial == 11)
    assert status.snapshot.trial_step == 0
    expect(screen.reading("Trial")).to_have_text("11")

    screen.click("Play")
    live.wait_for(lambda status: status.playing and status.snapshot.trial > 30)
    expect(screen.headline).not_to_contain_text("Paused")
    screen.click("Pause")
    paused = live.wait_for(lambda status: not status.playing).snapshot.step
    expect(screen.headline).to_contain_text("Paused")
    expect(screen.reading("Steps")).to_have_text(f"{paused:,}")
    assert live.session.status.snapshot.step == paused


def test_space_pauses_and_plays_even_after_a_click(begin: Begin) -> None:
    live, screen = begin(speed=10.0)
    # The clicked button keeps the focus, and space would press it as well.
    screen.click("Play")
    answered = live.wait_for(lambda status: status.playing).answered
    screen.page.keyboard.press("Space")
    live.wait_for(lambda status: not status.playing)
    screen.click("One step")
    status = live.wait_for(lambda status: status.answered >= answered + 2)
    assert (status.answered, status.playing) == (answered + 2, False)
    screen.page.keyboard.press("Space")
    assert live.wait_for(lambda status: status.answered > answered + 2).playing


def test_the_speed_is_set_by_its_slider(begin: Begin) -> None:
    live, screen = begin(speed=1_000.0)
    slider = screen.page.get_by_role("slider").first
    slider.press("Home")
    live.wait_for(lambda status: status.speed == 1.0)
    assert screen.reads("1 step/s")
    # Nothing to type a speed into: what stands on the slider is no number of steps.
    expect(slider.locator("xpath=../..").locator("input[inputmode=decimal]:visible")).to_have_count(
        0
    )
    slider.press("ArrowRight")
    live.wait_for(lambda status: status.speed == 1.25)
    slider.press("End")
    live.wait_for(lambda status: status.speed == FULL_SPEED)
    assert screen.reads("Full speed")
    assert live.session.status.snapshot.step == 0


def test_it_runs_to_a_trial_and_stands_still_there(begin: Begin) -> None:
    live, screen = begin("timed", "schedule.skills.circle_clockwise.at=150", trial=5, speed=10.0)
    field, button = screen.field("Run to trial"), screen.button("Run to it, and pause")
    screen.fill("Run to trial", "150")
    button.click()
    # At full speed, whatever the speed is.
    status = live.wait_for(lambda s: s.snapshot.trial == 150 and not s.playing)
    assert (status.snapshot.trial_step, status.snapshot.present) == (0, ("approach",))
    expect(screen.reading("Trial")).to_have_text("150")
    assert live.session.status.speed == 10.0
    # Where it has been nobody can go, so another trial is offered.
    expect(field).not_to_have_value("150")
    screen.fill("Run to trial", "300")
    button.click()
    status = live.wait_for(lambda s: s.snapshot.trial == 300 and not s.playing)
    assert status.snapshot.present == ("approach", "circle_clockwise")
    expect(screen.reading("Trial")).to_have_text("300")
    # Nobody can go where it has been; where the next one joins is offered again.
    screen.fill("Run to trial", "7")
    expect(field).to_have_value("14,500")


def test_it_stands_still_where_a_skill_joins_if_that_is_wished(begin: Begin) -> None:
    live, screen = begin("timed", "schedule.skills.circle_clockwise.at=150", trial=5)
    screen.check("Pause when a skill joins")
    live.wait_for(lambda status: status.pauses_at_joins)
    screen.click("Play")
    status = live.wait_for(lambda s: s.snapshot.trial == 150 and not s.playing)
    assert (status.snapshot.trial_step, status.snapshot.present) == (0, ("approach",))
    expect(screen.headline).to_contain_text("Paused")
    screen.check("Pause when a skill joins", False)
    live.wait_for(lambda status: not status.pauses_at_joins)


def test_a_run_that_is_over_offers_to_go_on(begin: Begin) -> None:
    live, screen = begin("timed", "trials=400", speed=FULL_SPEED)
    live.ask(Play())
    live.wait_for(lambda status: status.finished)
    expect(screen.headline).to_contain_text("The 400 trials are over.")
    screen.click("One step")
    assert screen.reads("the 400 trials are over; under Run it can go on for more, or start again")
    expect(screen.button("The 400 trials are over")).to_be_disabled()
    # Whoever wants to pause just then gets no more trials.
    screen.page.keyboard.press("Space")
    assert screen.reads("the 400 trials are over; under Run the learner can go on for 400 trials")
    assert live.ask().snapshot.trial == 400
    screen.click("Go on for 400 trials more")
    live.wait_for(lambda status: status.snapshot.trial == 800 and status.finished)
    expect(screen.headline).to_contain_text("The 800 trials are over.")


# Skills


def test_a_skill_is_added_and_explored_and_the_predator_obeys(begin: Begin) -> None:
    live, screen = begin(trial=LEARNED)
    assert screen.reads("circle clockwise: joins at trial 12,000")
    screen.click("Add circle clockwise now")
    control = live.wait_for(lambda s: len(s.snapshot.present) == 2).snapshot.control
    added = control.introductions[-1]
    assert (added.skill, added.trial) == ("circle_clockwise", LEARNED)
    assert control.frozen_until == LEARNED + 300
    assert screen.reads("circle clockwise: new, practised until trial 2,300")
    expect(screen.button("Add circle clockwise now")).to_have_count(0)
    expect(screen.button("Add avoid now")).to_be_visible()
    expect(screen.headline).to_contain_text("Two skills")

    chance = screen.page.get_by_role("slider").nth(1)
    chance.press("End")
    expect(chance).to_have_attribute("aria-valuenow", "1")
    screen.fill("Trials", "40")
    screen.choose("Skill", "circle clockwise")
    screen.click("Start exploring")
    wanted = Episode("circle_clockwise", 1.0, LEARNED + 40)
    before = live.wait_for(lambda s: s.snapshot.control.episodes == (wanted,)).snapshot
    assert screen.reads("circle clockwise at 100%: 40 trials left")
    screen.click("One trial")
    after = live.wait_for(lambda status: status.snapshot.trial == LEARNED + 1).snapshot
    taken = after.option_visits - before.option_visits
    assert taken[1] > 0
    assert taken.tolist() == [0, after.step - before.step, 0]
    assert screen.reads("circle clockwise at 100%: 39 trials left")

    screen.click("Stop exploring circle clockwise")
    live.wait_for(lambda status: status.snapshot.control.episodes == ())
    expect(screen.page.get_by_role("button", name="Stop exploring")).to_have_count(0)


# Freezing


def tables_after(live: LiveLab, steps: int) -> tuple[Snapshot, Snapshot]:
    """Two moments of a playing session that lie at least so many steps apart."""
    first = live.session.status.snapshot
    return first, live.wait_for(lambda s: s.snapshot.step >= first.step + steps).snapshot


def test_freezing_stops_learning_while_steps_go_on(begin: Begin) -> None:
    # Without a schedule, which would freeze the selection too as a skill joins.
    live, screen = begin("hierarchical_2", trial=LEARNED)
    screen.click("Play")
    live.wait_for(lambda status: status.playing)

    screen.checkbox("Freeze selection").click()
    live.wait_for(lambda status: status.snapshot.control.selection_frozen)
    first, later = tables_after(live, 5_000)
    np.testing.assert_array_equal(first.selection_q, later.selection_q)
    assert not np.array_equal(first.skill_q, later.skill_q)
    expect(screen.headline).to_contain_text("Frozen by hand: the selection.")

    screen.checkbox("Freeze skills").click()
    live.wait_for(lambda status: status.snapshot.control.skills_frozen)
    first, later = tables_after(live, 5_000)
    np.testing.assert_array_equal(first.selection_q, later.selection_q)
    np.testing.assert_array_equal(first.skill_q, later.skill_q)

    screen.checkbox("Freeze selection").click()
    live.wait_for(lambda status: not status.snapshot.control.selection_frozen)
    first, later = tables_after(live, 5_000)
    assert not np.array_equal(first.selection_q, later.selection_q)
    np.testing.assert_array_equal(first.skill_q, later.skill_q)
    expect(screen.checkbox("Freeze selection")).not_to_be_checked()
    expect(screen.checkbox("Freeze skills")).to_be_checked()


def test_the_schedule_can_be_left(begin: Begin) -> None:
    live, screen = begin("timed", "schedule.skills.circle_clockwise.at=60", trial=50)
    assert screen.reads("circle clockwise: joins at trial 60")
    screen.checkbox("Follow schedule").click()
    live.wait_for(lambda status: not status.snapshot.control.schedule_on)
    expect(screen.text("circle clockwise: joins")).to_have_count(0)
    assert screen.reads("circle clockwise: not yet")
    status = live.go_to_trial(70)
    assert status.snapshot.present == ("approach",)
    expect(screen.button("Add circle clockwise now")).to_be_visible()


class LateExecutor(ThreadPoolExecutor):
    """Runs what it is given only once the page has been drawn three times more."""

    def __init__(self, frames: threading.Semaphore) -> None:
        super().__init__()
        self._frames = frames

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        def late() -> Any:
            for _ in range(3):
                self._frames.acquire(timeout=PATIENCE_S)
            return fn(*args, **kwargs)

        while self._frames.acquire(blocking=False):
            pass
        return super().submit(late)


def test_a_click_is_not_lost_on_a_machine_that_is_slow_to_handle_it(
    begin: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    frames = threading.Semaphore(0)
    draw = Controls.update

    def counted(self: Controls, status: Status, elsewhere: int) -> None:
        draw(self, status, elsewhere)
        frames.release()

    monkeypatch.setattr(Controls, "update", counted)
    live, screen = begin()
    monkeypatch.setattr(live.lab.server.gui, "_thread_executor", LateExecutor(frames))
    answered = live.session.status.answered
    screen.checkbox("Freeze skills").click()
    status = live.wait_for(lambda status: status.answered > answered)
    assert status.snapshot.control.skills_frozen
    expect(screen.checkbox("Freeze skills")).to_be_checked()


# Starting again, and errors


def test_start_again_with_another_preset_and_seed(begin: Begin) -> None:
    live, screen = begin(trial=LEARNED)
    former = live.session.status.snapshot.generation
    screen.choose("Preset", "standard_q")
    screen.fill("Seed", "12")
    assert live.session.status.snapshot.generation == former
    screen.click("Start again")
    taken = live.wait_for(lambda status: status.snapshot.generation == former + 1).snapshot
    assert (taken.preset, taken.seed, taken.step) == ("standard_q", 12, 0)
    assert taken.spec == preset_of("standard_q")
    expect(screen.headline).to_contain_text("Nine moves, no skills")
    expect(screen.reading("Trial")).to_have_text("0")
    expect(screen.button("Add avoid now")).to_have_count(0)
    expect(screen.button("Start exploring")).to_have_count(0)
    expect(screen.checkbox("Freeze skills")).to_be_disabled()
    screen.expect_cell_colours(np.full((1600, 3), LIGHT.unknown, np.uint8))

    screen.choose("Preset", "hierarchical_2")
    screen.click("Start again")
    taken = live.wait_for(lambda status: status.snapshot.generation == former + 2).snapshot
    assert (taken.preset, taken.seed) == ("hierarchical_2", 12)
    assert screen.reads("circle clockwise: active")
    expect(screen.button("Start exploring")).to_be_enabled()


def test_starting_again_keeps_the_drawn_schedule_and_is_undone(
    begin: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    # However slow the page is, there is time to get to the button.
    monkeypatch.setattr("app.page.panels.said.SHOWN_S", math.inf)
    live, screen = begin(trial=LEARNED)
    former = live.session.status.snapshot
    schedule = former.spec.schedule
    circle = {"circle_clockwise": SkillTimer(at=6_000, freeze=300)}
    drawn = schedule.model_copy(update={"skills": schedule.skills | circle})
    live.ask(SetSchedule(drawn))
    expect(screen.said).to_contain_text(f"Schedule edited at trial {LEARNED:,}")
    expect(screen.checkbox("Keep the drawn schedule")).to_be_checked()

    # Nobody else is looking, so nobody is asked.
    screen.click("Start again")
    taken = live.wait_for(lambda status: status.snapshot.step == 0).snapshot
    assert (taken.spec.schedule, taken.preset_spec.schedule) == (drawn, schedule)
    assert not live.session.status.playing
    expect(screen.said).to_contain_text("Started again: timed, seed 3")
    screen.said.get_by_role("button", name=f"Back to timed, trial {LEARNED:,}").click()
    live.wait_for(lambda status: status.snapshot.generation == former.generation)
    expect(screen.reading("Trial")).to_have_text(f"{LEARNED:,}")
    screen.expect_cell_colours(live.colours())


def test_every_seed_can_be_typed_and_what_is_none_is_refused_and_said(begin: Begin) -> None:
    live, screen = begin()
    former = live.session.status.snapshot.generation
    expect(screen.field("Seed")).to_have_value(str(live.session.status.snapshot.seed))
    for wrong in ("seven", str(MAX_SEED + 1)):
        # Once as it is typed, and once for the button; each is gone again after a while.
        refusal = f"Seed: '{wrong}' is not taken: "
        screen.fill("Seed", wrong)
        expect(screen.notice("Not taken").filter(has_text=refusal)).to_be_visible()
        screen.click("Start again")
        expect(screen.notice("That cannot be done now").filter(has_text=refusal)).to_be_visible()
    assert live.session.status.snapshot.generation == former
    screen.fill("Seed", str(MAX_SEED))
    screen.click("Start again")
    taken = live.wait_for(lambda status: status.snapshot.generation == former + 1).snapshot
    assert taken.seed == MAX_SEED
    live.ask(StartAgain(taken.spec, taken.preset, MAX_SEED - 1))
    expect(screen.field("Seed")).to_have_value(str(MAX_SEED - 1))


def test_an_error_is_shown_the_state_kept_and_a_new_run_recovers(
    begin: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    live, screen = begin(trial=50)
    former = live.session.status.snapshot.generation
    before = live.session.status.snapshot

    def broken(self: Run, *limits: Any, **more: Any) -> int:
        raise ArithmeticError("<b>no</b> such number")

    with monkeypatch.context() as patched:
        patched.setattr(Run, "advance", broken)
        screen.click("Play")
        status = live.wait_for(lambda status: status.error is not None)
        expect(screen.headline).to_contain_text(
            "An error stopped the learner at trial 50; what it has learned is kept."
        )
        expect(screen.headline).to_contain_text("ArithmeticError: <b>no</b> such number")
        expect(screen.button("Stopped by an error: start again")).to_be_disabled()
    assert (status.snapshot.step, status.snapshot.trial) == (before.step, 50)
    np.testing.assert_array_equal(status.snapshot.skill_q, before.skill_q)

    screen.click("Start again")
    status = live.wait_for(lambda status: status.snapshot.generation == former + 1)
    assert status.error is None
    expect(screen.headline).not_to_contain_text("ArithmeticError")
    screen.click("Play")
    live.wait_for(lambda status: status.snapshot.trial > 20)


# Strangers


def test_a_value_that_no_widget_allows_is_refused_and_said(begin: Begin) -> None:
    live, screen = begin(speed=1_000.0)
    chance = live.widget("Probability").value
    screen.fill("Trials", "2,000")
    label = screen.page.locator("label").get_by_text("Probability", exact=True)
    screen.page.evaluate(
        """uuid => window.__viserMutable.sendMessage(
            { type: "GuiUpdateMessage", uuid, updates: { value: -5 } })""",
        label.get_attribute("for"),
    )
    assert screen.reads("Probability must be at least 0.0.")
    screen.click("Start exploring")
    episode = live.wait_for(lambda status: bool(status.snapshot.control.episodes))
    assert episode.snapshot.control.episodes == (Episode("approach", chance, 2_000),)


@contextlib.contextmanager
def foreign_site() -> Iterator[str]:
    """A page of another server; yields its address."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<title>elsewhere</title>")

        def log_message(self, format: str, *args: Any) -> None:
            """Say nothing."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()
            thread.join()


def knock(page: Page, live: LiveLab) -> str:
    """What becomes of a websocket that a page opens to the lab."""
    return page.evaluate(
        """([url, protocol]) => new Promise(resolve => {
            const socket = new WebSocket(url, [protocol]);
            socket.onopen = () => { socket.close(); resolve("open"); };
            socket.onerror = () => resolve("refused");
        })""",
        [live.lab.url.replace("http", "ws"), f"viser-v{viser.__version__}"],
    )


def test_a_page_of_another_origin_is_refused(
    begin: Begin, new_context: Callable[..., BrowserContext]
) -> None:
    live, screen = begin(trial=5)
    before = live.session.status
    page = new_context().new_page()
    with foreign_site() as site:
        page.goto(site)
        assert knock(page, live) == "refused"
        page.goto(site.replace("127.0.0.1", "localhost"))
        assert knock(page, live) == "refused"
    page.goto("about:blank")
    assert knock(page, live) == "refused"
    assert live.session.status is before
    # The same is welcome from the lab's own page.
    assert knock(screen.page, live) == "open"


# The program


@contextlib.contextmanager
def pounce_lab(port: int) -> Iterator[subprocess.Popen[str]]:
    """The lab as a program of its own, as if started on a terminal."""
    process = subprocess.Popen(
        [sys.executable, "-m", "app.cli.main", "lab", "--no-browser", "--port", str(port)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # What a shell starts in the background ignores Ctrl-C; a test may be run like that.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def said_until_ready(process: subprocess.Popen[str]) -> tuple[str, str]:
    """What a program said until it named its address, and the address."""
    assert process.stdout is not None
    said = ""
    # What loads and compiles as it starts takes many times as long on a machine under load.
    watchdog = threading.Timer(3 * PATIENCE_S, process.kill)
    watchdog.start()
    try:
        for line in process.stdout:
            said += line
            found = re.search(r"pounce is at (http://\S+)", line)
            if found:
                return said, found[1]
    finally:
        watchdog.cancel()
    pytest.fail(f"it ended before it named an address: {said}")


@contextlib.contextmanager
def taken_port() -> Iterator[int]:
    """A port that somebody else listens on."""
    with socket.create_server(("127.0.0.1", 0)) as other:
        yield other.getsockname()[1]


def test_a_busy_port_is_said_and_ctrl_c_ends_the_program_at_once_and_cleanly(
    new_context: Callable[..., BrowserContext],
) -> None:
    with taken_port() as busy, pounce_lab(busy) as process:
        said, url = said_until_ready(process)
        port = int(url.rpartition(":")[2])
        assert port > busy
        assert f"Port {busy} is busy, so this uses {port}." in said
        page = new_context().new_page()
        # What loads takes many times as long on a machine under load as what is there already.
        page.goto(f"{url}/?fixedDpr=1", timeout=3 * PATIENCE_S * 1000)
        expect(page.get_by_text("One skill: approach")).to_be_visible(timeout=3 * PATIENCE_S * 1000)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=PATIENCE_S)
    assert process.returncode in (os.EX_OK, 130)
    assert errors == ""
