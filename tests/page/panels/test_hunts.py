"""Hunts that one browser is shown slowly, with the widgets of a server that nobody looks at."""

import contextlib
import random
import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.documents import presets
from app.live import snapshot
from app.live.opening import Opening
from app.live.requests import SkipOpening
from app.live.session import Session
from app.live.status import Status
from app.page.panels.hunts import Hunts, hunt_from_anywhere
from app.picture.look import Look
from app.picture.theme import DARK
from app.server.calls import Calls
from app.server.server import close_server, open_server
from learners.kernel.state import digest
from learners.run import Run
from sim.world import TIMEOUT
from tests.support.person import AtOnce, Person, drawn, words

LOOK = Look()
BEFORE_S, LATER_S = 100.0, 200.0
"""When a hunt is begun, and when all of it has been seen."""


def status_of(trial: int = 300, size: int = 40, *settings: str) -> Status:
    """A session that stands at the start of a trial."""
    start = "world.start_radius=[20, 50]"
    spec = presets.load("timed", [f"world.size={size}", start, *settings])
    run = Run(spec, seed=1)
    run.advance(until_trial=trial)
    idle = Session(spec, "timed", seed=1, speed=100.0, playing=True).status
    return replace(idle, snapshot=snapshot.take(run, "timed", 0))


class Viewer(Person):
    """Somebody who looks at the board and clicks on what stands there."""

    def __init__(self, server: Any) -> None:
        super().__init__(server.gui)
        self.gui, self.scene = server.gui, server.scene
        self.asked: list[Any] = []
        self.calls = Calls()
        inbox: Any = AtOnce()
        self.hunts = Hunts(self, self.ask, self.calls, inbox, lambda: None)

    @contextlib.contextmanager
    def atomic(self) -> Iterator[None]:
        yield

    def ask(self, client: Any, request: Any) -> None:
        self.asked.append(request)

    @property
    def said(self) -> str:
        """What it says."""
        return words(self.html)

    def follow(self, label: str) -> None:
        """Follow a link."""
        found = re.search(rf'href="call/([^"]*)"[^>]*>{label}<', self.html)
        assert found is not None
        assert self.calls.take(found.group(1))

    def points(self, name: str) -> np.ndarray:
        """What is drawn of the hunt that is watched, without what is kept away."""
        points = drawn(self.scene, f"/watched/{name}").points.reshape(-1, 3)
        return points[points[:, 2] >= 0]


@pytest.fixture
def viewer() -> Iterator[Viewer]:
    random.seed(4)
    server = open_server(port=0)
    yield Viewer(server)
    close_server(server)


def test_the_first_hunts_are_counted_and_can_be_skipped(viewer: Viewer) -> None:
    opens = replace(status_of(), opening=Opening(hunt=2, of=3, rising=False))
    viewer.hunts.update(opens, LOOK, BEFORE_S)
    assert "first hunts" in viewer.said
    assert "2 of 3" in viewer.said
    viewer.follow("Skip")
    assert viewer.asked == [SkipOpening()]
    viewer.hunts.update(replace(opens, opening=Opening(3, 3, rising=True)), LOOK, BEFORE_S)
    assert "faster and faster" in viewer.said
    viewer.hunts.update(replace(opens, opening=None), LOOK, BEFORE_S)
    assert viewer.said == "Watch a hunt"


def test_a_hunt_is_watched_to_its_end_and_until_one_has_seen_enough(viewer: Viewer) -> None:
    status = status_of()
    viewer.hunts.update(status, LOOK, BEFORE_S)
    assert not viewer.hunts.is_watching
    viewer.follow("Watch a hunt")
    assert viewer.hunts.is_watching
    viewer.hunts.update(status, LOOK, BEFORE_S)
    assert "with what it knows at trial 300" in viewer.said
    assert len(viewer.points("trail")) == 0
    start = viewer.points("predator")
    viewer.hunts.update(status, LOOK, LATER_S)
    assert re.search(r"(Caught|Noticed|Out of time) after [\d,]+ steps?\.", viewer.said)
    assert len(viewer.points("trail")) > 0
    assert not np.array_equal(viewer.points("predator"), start)
    viewer.follow("Stop")
    viewer.hunts.update(status, LOOK, LATER_S)
    assert not viewer.hunts.is_watching
    assert viewer.said == "Watch a hunt"
    assert "/watched/predator" not in viewer.scene._handle_from_node_name


def test_what_is_watched_stays_what_it_is_while_the_learner_goes_on(viewer: Viewer) -> None:
    viewer.hunts.update(status_of(), LOOK, BEFORE_S)
    viewer.follow("Watch a hunt")
    viewer.hunts.update(status_of(300), LOOK, BEFORE_S)
    start = viewer.points("predator")
    viewer.hunts.update(status_of(310), LOOK, BEFORE_S)
    assert "at trial 300" in viewer.said
    assert np.array_equal(viewer.points("predator"), start)
    viewer.hunts.update(status_of(310), LOOK._replace(theme=DARK), BEFORE_S)
    assert np.array_equal(viewer.points("predator"), start)


def test_of_a_very_long_hunt_the_end_is_drawn(viewer: Viewer) -> None:
    # It knows nothing yet, and nothing is near where it starts.
    lost = status_of(0, 400, "world.step_limit=100000", "world.vision_radius=0")
    viewer.hunts.update(lost, LOOK, BEFORE_S)
    viewer.follow("Watch a hunt")
    viewer.hunts.update(lost, LOOK, BEFORE_S)
    viewer.hunts.update(lost, LOOK, LATER_S)
    steps = int(re.findall(r"after ([\d,]+) steps", viewer.said)[0].replace(",", ""))
    assert len(viewer.points("trail")) / 2 == 2_000 < steps
    assert np.allclose(viewer.points("trail")[-1, :2], viewer.points("predator")[0, :2])


def test_another_world_ends_it(viewer: Viewer) -> None:
    viewer.hunts.update(status_of(), LOOK, BEFORE_S)
    viewer.follow("Watch a hunt")
    viewer.hunts.update(status_of(), LOOK, BEFORE_S)
    viewer.hunts.update(status_of(10, size=20), LOOK, BEFORE_S)
    assert not viewer.hunts.is_watching


def test_whatever_else_is_called_changes_nothing(viewer: Viewer) -> None:
    viewer.hunts.update(status_of(), LOOK, BEFORE_S)
    found = re.search('call/([^/"]*)/', viewer.html)
    assert found is not None
    for nonsense in ("", "x", "skip/1", "WATCH"):
        assert viewer.calls.take(f"{found.group(1)}/{nonsense}")
    assert viewer.asked == []
    assert not viewer.hunts.is_watching
    viewer.hunts.leave()
    assert not viewer.calls.take(f"{found.group(1)}/watch")


def test_a_hunt_leaves_no_mark_on_the_learner_and_is_another_each_time() -> None:
    run = Run(presets.load("timed", ["world.size=40"]), seed=1)
    run.advance(max_steps=5_000)
    taken, before = snapshot.take(run, "timed", 0), digest(run.state)
    watched = [hunt_from_anywhere(taken, 0.0) for _ in range(8)]
    assert digest(run.state) == before
    assert len({(hunt.heading, int(hunt.hunt.cells[0])) for hunt in watched}) > 1
    for one in watched:
        assert one.way(0.0).outcome is None
        assert one.way(1e9).outcome == one.hunt.outcome
        assert one.seen_s[-1] <= 5.0
        assert one.hunt.steps < 500 or one.hunt.outcome == TIMEOUT
