"""Browsers of one lab that look at moments, by what is drawn and read for each of them."""

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from viser import _messages as wire

from app.documents import presets
from app.live import snapshot
from app.live.requests import Pause, Play, Request, SetSpeed, StartAgain, TrialOnce
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page.browser import Browser
from app.page.lab import Lab
from app.page.scene.board import BoardView
from app.page.scene.gallery import Seen
from app.page.success import success_of
from app.page.time import messages
from app.page.time.messages import FromFrame
from app.picture.layer import Extras, Layer
from app.picture.layers import LAYERS
from learners.commands import Command, FreezeSelection, SetParameter
from learners.kernel.state import digest
from learners.run import Run, replay
from tests.support.live import PATIENCE_S
from tests.support.server import CAMERA, Page

CHANGE = LAYERS["change"]
SEED = 7
SPEC = presets.load(
    "timed",
    [
        "world.size=40",
        "trials=3000",
        "schedule.skills.circle_clockwise={at: 300, freeze: 50}",
        "schedule.skills.avoid={at: 900, freeze: 50}",
        "schedule.episodes=[{skill: circle_clockwise, duration: 200, probability: 0.95}]",
    ],
)
LEARNED = 600


class Theatre:
    """A lab with some pages, each a browser as far as the lab can tell."""

    def __init__(self, results: Path) -> None:
        self.session = Session(SPEC, "timed", SEED, 20_000.0, playing=False)
        self.session.start()
        self.lab = Lab(self.session, {"timed": SPEC}, "127.0.0.1", 0, results)
        self._loop = threading.Thread(target=self.lab.serve)
        self._loop.start()
        self.pages: list[Page] = []

    def enter(self) -> Browser:
        """One more browser."""
        page = Page(self.lab.server.get_port())
        self.pages.append(page)
        page.send(CAMERA)
        self.wait(lambda: len(self.lab.browsers) == len(self.pages))
        browser = self.lab.browsers[-1]
        self.wait(lambda: browser.time.is_shown)
        return browser

    def close(self) -> None:
        for page in self.pages:
            page.close()
        self.lab.close()
        self._loop.join()

    def wait(self, condition: Callable[[], bool]) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < deadline
            time.sleep(0.005)

    def ask(self, *many: Request) -> None:
        """Have the session do something, as nobody's browser."""
        ticket = max(self.session.submit(request) for request in many)
        self.session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)

    def learn(self, trial: int = LEARNED) -> None:
        while self.session.status.snapshot.trial < trial:
            self.ask(*[TrialOnce()] * 100)

    def do(self, act: Callable[[], object]) -> None:
        """Have something done in the render loop."""
        done = threading.Event()
        self.lab.inbox.put(lambda: (act(), done.set()))
        assert done.wait(PATIENCE_S)

    def tell(self, browser: Browser, *many: FromFrame) -> None:
        """A hand on the bar of a browser."""
        for message in many:
            self.do(lambda message=message: browser.time.take(message))

    def go(self, browser: Browser, step: int, line: int | None = None) -> Snapshot:
        """Look at a moment; returns what is shown once that is it."""
        if line is not None:
            self.tell(browser, messages.Look(line))
        self.tell(browser, messages.Seek(step))
        self.wait(lambda: self.shown(browser).step == step)
        return self.shown(browser)

    def branch(self, browser: Browser, command: Command) -> int:
        """Make a branch of the live run by a command; returns its number once that is shown."""
        live = self.session.status.snapshot.generation
        self.go(browser, 5_000)
        self.do(lambda: self.lab.ask(browser.client, command))
        self.wait(lambda: self.shown(browser).generation != live)
        return self.shown(browser).generation

    def status(self, browser: Browser) -> Status:
        """What is true for a browser, as the render loop has it."""
        found: list[Status] = []
        self.do(lambda: found.append(self.lab.status_of(browser.client)))
        return found[0]

    def shown(self, browser: Browser) -> Snapshot:
        return self.status(browser).snapshot

    def expect_board(self, browser: Browser, shot: Snapshot, extras: Extras | None = None) -> None:
        """Wait until the board of a browser is that of a moment."""
        layer = LAYERS[browser.look.layer]
        colours = layer.paint(shot, browser.look, extras or Extras()).colours

        def is_so() -> bool:
            exhibit = browser.exhibit
            return exhibit is not None and np.array_equal(colours_of(exhibit.board), colours)

        self.wait(is_so)


@pytest.fixture
def theatre(tmp_path: Path) -> Iterator[Theatre]:
    theatre = Theatre(tmp_path / "results")
    yield theatre
    theatre.close()


def colours_of(board: BoardView) -> np.ndarray:
    """What the cells of a board were given last."""
    return board._cells.colors  # pyright: ignore[reportPrivateUsage]


def choose(browser: Browser, layer: Layer) -> None:
    """Show a layer, as its key does."""
    browser.readings.view._choose_layer(layer)  # pyright: ignore[reportPrivateUsage]


def stopped_at(step: int) -> Run:
    return replay(SPEC, SEED, [], step)


def test_what_is_shown_is_a_run_that_was_stopped_there_while_the_learner_goes_on(
    theatre: Theatre,
) -> None:
    anna = theatre.enter()
    theatre.learn()
    end = theatre.session.status.snapshot.step
    theatre.ask(Play())
    for step in (end // 2, 17, end - 1, 0, end // 3):
        shot = theatre.go(anna, step)
        true = snapshot.take(stopped_at(step), "timed", shot.generation)
        for name in ("selection_q", "value", "first_reach", "visits", "skill_q", "trail"):
            np.testing.assert_array_equal(getattr(shot, name), getattr(true, name))
        assert (shot.trial, shot.cell, shot.heading) == (true.trial, true.cell, true.heading)
        assert shot.control == true.control
        theatre.expect_board(anna, true)
    theatre.session.wait_for(lambda status: status.snapshot.step > end + 1_000, PATIENCE_S)
    theatre.ask(Pause())
    now = theatre.session.status.snapshot
    theatre.tell(anna, messages.Live())
    theatre.expect_board(anna, now)
    assert theatre.status(anna).behind is None
    # Of the line as it is known, and so of the tables of the live run.
    (line,) = theatre.session.wait_for(
        lambda status: status.lines[0].digest != "", PATIENCE_S
    ).lines
    assert line.until_step == now.step
    assert line.digest == digest(stopped_at(now.step).state)


def test_two_browsers_in_two_moments_do_not_disturb_each_other_nor_a_third(
    theatre: Theatre,
) -> None:
    anna, bert, carl = theatre.enter(), theatre.enter(), theatre.enter()
    theatre.learn()
    first, second = theatre.go(anna, 5_000), theatre.go(bert, 20_000)
    live = theatre.session.status.snapshot
    for browser, shot in ((anna, first), (bert, second), (carl, live)):
        theatre.expect_board(browser, shot)
    theatre.tell(bert, messages.GoBy("trials", 1))
    theatre.wait(lambda: theatre.shown(bert).trial == second.trial + 1)
    assert theatre.shown(anna) is first
    theatre.expect_board(anna, first)
    theatre.expect_board(carl, live)
    theatre.tell(anna, messages.Live())
    theatre.expect_board(anna, live)
    assert theatre.shown(bert).trial == second.trial + 1


def test_a_click_counts_on_a_page_that_has_not_drawn_the_newest_frame(
    theatre: Theatre, monkeypatch: pytest.MonkeyPatch
) -> None:
    anna = theatre.enter()
    theatre.learn(2_500)
    theatre.do(lambda: choose(anna, LAYERS["reach"]))
    theatre.expect_board(anna, theatre.go(anna, 5_000))
    monkeypatch.setattr(anna.pulse, "is_ready", lambda now_s: False)
    theatre.tell(anna, messages.Live())
    theatre.wait(lambda: theatre.status(anna).behind is None)
    theatre.do(theatre.lab.wake)
    theatre.do(theatre.lab.wake)
    # Straight down, west of the prey, where value comes first.
    ray = wire.ScenePointerMessage("click", (-0.5, 0.0, 9.0), (0.0, 0.0, -1.0), ((0.5, 0.5),), None)
    theatre.pages[0].send(ray)
    theatre.wait(lambda: not anna.outlook.walk.is_live)


def test_a_moment_that_stays_is_drawn_once(
    theatre: Theatre, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.page.scene.gallery._SETTLED_S", 0.0)
    anna = theatre.enter()
    theatre.learn()
    shot = theatre.go(anna, 5_000)

    def is_there() -> bool:
        texts = None if anna.exhibit is None else anna.exhibit.texts
        return texts is not None and texts.status.snapshot.step == shot.step

    # Colours alone may be those of the board of what is live, when little had been learned.
    theatre.wait(is_there)
    theatre.expect_board(anna, shot)
    assert anna.exhibit is not None
    board = anna.exhibit.board
    stood = threading.Event()

    def update(*_: Any, **__: Any) -> None:
        stood.set()

    monkeypatch.setattr(board, "update", update)
    for _ in range(5):
        theatre.do(theatre.lab.wake)
    assert not stood.is_set()
    theatre.go(anna, 6_000)
    assert stood.wait(PATIENCE_S)


def test_a_command_in_the_past_makes_a_branch_where_only_its_browser_goes(
    theatre: Theatre,
) -> None:
    anna, bert = theatre.enter(), theatre.enter()
    theatre.learn()
    live = theatre.session.status.snapshot
    theatre.go(anna, 5_000)
    epsilon, freeze = SetParameter("learner.epsilon", 0.4), FreezeSelection(True)
    theatre.do(lambda: theatre.lab.ask(anna.client, epsilon))
    # The second before the first has been answered: both are of the branch.
    theatre.do(lambda: theatre.lab.ask(anna.client, freeze))
    theatre.wait(lambda: theatre.shown(anna).control.selection_frozen)
    there = theatre.shown(anna)
    assert there.generation != live.generation
    assert there.step == 5_000
    assert there.spec.learner.epsilon == 0.4
    assert len(theatre.session.status.lines) == 2
    assert "0.4" in anna.asks.note
    branch = there.generation
    # While it grows, each status has a snapshot of its own, even of what stands still.
    theatre.session.wait_for(lambda status: not status.lines[-1].is_growing, PATIENCE_S)
    theatre.wait(lambda: theatre.shown(bert) is theatre.session.status.snapshot)
    assert theatre.session.status.snapshot.control == live.control
    later = theatre.go(anna, 30_000)
    journal: list[tuple[int, Command]] = [(5_000, epsilon), (5_000, freeze)]
    true = snapshot.take(replay(SPEC, SEED, journal, 30_000), "timed", branch)
    np.testing.assert_array_equal(later.selection_q, true.selection_q)
    theatre.tell(anna, messages.Live())
    assert theatre.status(anna).behind is None
    # Everybody can look at it.
    theatre.go(bert, 30_000, branch)
    np.testing.assert_array_equal(theatre.shown(bert).selection_q, true.selection_q)


def test_a_branch_is_made_live_and_this_browser_goes_along(theatre: Theatre) -> None:
    anna, bert = theatre.enter(), theatre.enter()
    theatre.learn()
    branch = theatre.branch(anna, FreezeSelection(True))
    theatre.tell(anna, messages.MakeLive(branch))
    theatre.session.wait_for(lambda status: status.snapshot.generation == branch, PATIENCE_S)
    theatre.wait(lambda: theatre.status(anna).behind is None)
    for browser in (anna, bert):
        theatre.expect_board(browser, theatre.session.status.snapshot)


def test_who_makes_another_line_live_than_they_look_at_goes_there_too(theatre: Theatre) -> None:
    anna = theatre.enter()
    theatre.learn()
    former = theatre.session.status.snapshot.generation
    branch = theatre.branch(anna, FreezeSelection(True))
    theatre.go(anna, 3_000, former)
    theatre.tell(anna, messages.MakeLive(branch))
    theatre.session.wait_for(lambda status: status.snapshot.generation == branch, PATIENCE_S)
    theatre.wait(lambda: theatre.status(anna).behind is None)
    theatre.expect_board(anna, theatre.session.status.snapshot)


def test_starting_again_ends_what_was_looked_at(theatre: Theatre) -> None:
    anna = theatre.enter()
    theatre.learn()
    theatre.go(anna, 5_000)
    theatre.ask(StartAgain(SPEC, "timed", SEED, paused=True))
    theatre.wait(lambda: theatre.shown(anna).step == 0)
    assert theatre.status(anna).behind is None
    assert anna.outlook.walk.is_live


def test_a_page_that_is_loaded_anew_begins_live(theatre: Theatre) -> None:
    anna = theatre.enter()
    theatre.learn()
    theatre.go(anna, 5_000)
    theatre.pages.pop().close()
    theatre.wait(lambda: not theatre.lab.browsers)
    again = theatre.enter()
    assert theatre.status(again).behind is None
    kept = theatre.lab.gallery._exhibits  # pyright: ignore[reportPrivateUsage]
    assert Seen(anna.look, anna.client.client_id) not in kept


def test_the_learner_stands_still_while_somebody_looks_who_wants_that(theatre: Theatre) -> None:
    anna = theatre.enter()
    theatre.learn()
    theatre.ask(SetSpeed(2_000.0), Play())
    theatre.tell(anna, messages.SetHolds(True))
    assert theatre.session.status.playing
    theatre.go(anna, 5_000)
    theatre.session.wait_for(lambda status: not status.playing, PATIENCE_S)
    theatre.tell(anna, messages.Live())
    theatre.session.wait_for(lambda status: status.playing, PATIENCE_S)


def test_who_leaves_while_the_learner_stands_still_for_them_lets_it_go_on(
    theatre: Theatre,
) -> None:
    anna = theatre.enter()
    theatre.learn()
    theatre.ask(SetSpeed(2_000.0), Play())
    theatre.tell(anna, messages.SetHolds(True))
    theatre.go(anna, 5_000)
    theatre.session.wait_for(lambda status: not status.playing, PATIENCE_S)
    theatre.pages.pop().close()
    theatre.session.wait_for(lambda status: status.playing, PATIENCE_S)


def test_steps_and_trials_of_the_controls_are_those_of_what_is_looked_at(theatre: Theatre) -> None:
    anna = theatre.enter()
    theatre.learn()
    end = theatre.session.status.snapshot.step
    shot = theatre.go(anna, 5_000)
    theatre.do(lambda: theatre.lab.ask(anna.client, TrialOnce()))
    theatre.wait(lambda: theatre.shown(anna).trial == shot.trial + 1)
    theatre.do(lambda: theatre.lab.ask(anna.client, Play()))
    theatre.wait(lambda: theatre.shown(anna).trial > shot.trial + 20)
    theatre.do(lambda: theatre.lab.ask(anna.client, Pause()))
    assert theatre.session.status.snapshot.step == end


def test_an_experiment_of_a_line_repeats_what_was_done_on_it(theatre: Theatre) -> None:
    anna = theatre.enter()
    theatre.learn()
    branch = theatre.branch(anna, SetParameter("learner.epsilon", 0.4))
    theatre.tell(anna, messages.TryOverSeeds(branch))
    theatre.wait(lambda: theatre.lab.service.standing is not None)
    standing = theatre.lab.service.standing
    assert standing is not None
    theatre.lab.service.stop()
    assert len(standing.experiment.seeds) == 30


def test_a_frame_that_asks_for_experiments_without_end_is_refused(
    theatre: Theatre, monkeypatch: pytest.MonkeyPatch
) -> None:
    theatre.learn(50)
    anna = theatre.enter()
    theatre.go(anna, 100)
    said: list[str] = []
    monkeypatch.setattr(anna.time, "say", lambda text, refused: said.append(text))
    monkeypatch.setattr(theatre.lab.inbox, "is_free_for", lambda client_id: False)
    theatre.tell(anna, messages.TryOverSeeds(0))
    assert said == ["much is being made for this browser already; wait for that"]


def test_what_changed_since_a_is_drawn_for_who_set_it_and_for_nobody_else(theatre: Theatre) -> None:
    anna, bert = theatre.enter(), theatre.enter()
    # There is a cone by then.
    theatre.learn(2_500)
    for browser in (anna, bert):
        theatre.do(lambda browser=browser: choose(browser, CHANGE))
    a = theatre.go(anna, 5_000)
    theatre.tell(anna, messages.SetA(), messages.Live())
    theatre.wait(lambda: anna.outlook.since is not None)
    live, look = theatre.session.status.snapshot, anna.look
    theatre.expect_board(anna, live, Extras(since=a))
    theatre.expect_board(bert, live, Extras())
    assert not np.array_equal(
        CHANGE.paint(live, look, Extras(since=a)).colours,
        CHANGE.paint(live, look, Extras()).colours,
    )


def test_the_success_map_is_of_the_moment_that_is_looked_at(theatre: Theatre) -> None:
    anna = theatre.enter()
    theatre.learn()
    theatre.do(lambda: choose(anna, LAYERS["success"]))
    shot = theatre.go(anna, 20_000)
    found = success_of(shot, lambda: True)
    theatre.expect_board(anna, shot, Extras(success=found))
