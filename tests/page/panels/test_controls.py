"""The controls that all browsers share, on a real server that nobody looks at."""

import threading
from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
import viser

from app.documents import presets
from app.live.session import FULL_SPEED, Pause, Reply, Request, Session, StartAgain, Status
from app.page.panels.controls import MOST_LOADED, Controls, speed_label
from app.server.callbacks import RefusedError
from app.server.server import close_server, open_server
from learners.spec import RunSpec
from sim.rng import MAX_SEED

PATIENCE_S = 30.0


def spec_of(name: str = "timed") -> RunSpec:
    """A preset in a small world."""
    return presets.load(name, ["world.size=40"])


OFFERED = {name: spec_of(name) for name in ("timed", "hierarchical_2")}
NOBODY: Any = SimpleNamespace(client=None)
"""An event of no browser."""


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    server = open_server(port=0)
    yield server
    close_server(server)


def idle(seed: int = 3) -> Session:
    """A session whose worker has not been started."""
    return Session(spec_of(), "timed", seed, speed=100.0, playing=False)


def of_run(status: Status, number: int, preset: str, seed: int = 3) -> Status:
    """The status once another run has begun."""
    parts = {"generation": number, "preset": preset, "seed": seed}
    return replace(status, snapshot=replace(status.snapshot, **parts))


# Seeds


@pytest.mark.parametrize("seed", [9_999_999_999, 2**53 + 1, MAX_SEED])
def test_large_seeds_are_shown_and_started_again(server: viser.ViserServer, seed: int) -> None:
    session = idle(seed)
    controls = Controls(server.gui, session, OFFERED)
    assert controls._start_again() == StartAgain(spec_of(), "timed", seed)
    controls.update(of_run(session.status, 1, "an experiment: a run", seed - 1))
    assert controls._start_again() == StartAgain(spec_of(), "an experiment: a run", seed - 1)


def test_nothing_starts_again_with_a_wrong_seed(server: viser.ViserServer) -> None:
    controls = Controls(server.gui, idle(), OFFERED)
    controls._seed.handle.value = "seven"
    with pytest.raises(RefusedError, match=r"^Seed: 'seven' is not taken: "):
        controls._start_again()


# Speed


@pytest.mark.parametrize(
    ("speed", "label"),
    [
        (1.0, "1 step/s"),
        (2.0, "2 steps/s"),
        (6_309.6, "6,310 steps/s"),
        (19_953.0, "20 k steps/s"),
        (1e6, "1 M steps/s"),
        (10**6.9, "7.94 M steps/s"),
        (FULL_SPEED, "Full speed"),
    ],
)
def test_a_speed_is_said_in_steps_per_second(speed: float, label: str) -> None:
    assert speed_label(speed) == label


# The way back from a run of an experiment


def test_what_was_opened_and_the_way_back_stand_there_as_long_as_there_is_one(
    server: viser.ViserServer,
) -> None:
    session = idle()
    controls = Controls(server.gui, session, OFFERED)
    assert (controls._whose.visible, controls._back.visible) == (False, False)
    opened = of_run(session.status, 1, "figure_4_1: <b>", 7)
    controls.update(replace(opened, aside="timed, trial 1,234"))
    assert (controls._whose.visible, controls._back.visible) == (True, True)
    assert controls._back.label == "Back to timed, trial 1,234"
    assert "figure_4_1: &lt;b&gt;, seed 7" in controls._whose.content
    controls.update(of_run(session.status, 2, "timed"))
    assert (controls._whose.visible, controls._back.visible) == (False, False)


# Presets


def test_the_list_of_presets_keeps_the_shipped_ones_and_the_latest_others(
    server: viser.ViserServer,
) -> None:
    session = idle()
    controls = Controls(server.gui, session, OFFERED)
    for number in range(1, 3 * MOST_LOADED):
        controls.update(of_run(session.status, number, f"run {number}"))
        assert controls._preset.value == f"run {number}"
    last = 3 * MOST_LOADED - 1
    latest = [f"run {number}" for number in range(last - MOST_LOADED + 1, last + 1)]
    assert list(controls._preset.options) == [*OFFERED, *latest]


def test_a_preset_that_is_taken_up_again_stays_longest(server: viser.ViserServer) -> None:
    session = idle()
    controls = Controls(server.gui, session, OFFERED)
    controls.update(of_run(session.status, 1, "mine"))
    for number in range(2, 3 * MOST_LOADED, 2):
        controls.update(of_run(session.status, number, f"run {number}"))
        controls.update(of_run(session.status, number + 1, "mine"))
    assert "mine" in controls._preset.options


# Requests of several threads


class Delayed(Session):
    """Lets the first request wait, once it has its ticket, until another has been made."""

    def __init__(self) -> None:
        super().__init__(spec_of(), "timed", 3, speed=100.0, playing=False)
        self.first_is_in, self.other_is_made = threading.Event(), threading.Event()

    def submit(self, request: Request, reply: Reply | None = None) -> int:
        ticket = super().submit(request, reply)
        if ticket == 1:
            self.first_is_in.set()
            assert self.other_is_made.wait(PATIENCE_S)
        return ticket


def test_nothing_is_shown_before_the_latest_of_all_requests_is_answered(
    server: viser.ViserServer,
) -> None:
    session = Delayed()
    controls = Controls(server.gui, session, OFFERED)
    first = threading.Thread(target=controls.ask_for, args=(None, Pause()))
    first.start()
    assert session.first_is_in.wait(PATIENCE_S)
    assert controls.ask_for(None, Pause()) == 2
    session.other_is_made.set()
    first.join()
    assert controls._play.label == "Play"
    controls.update(replace(session.status, playing=True, answered=1))
    assert controls._play.label == "Play"
    controls.update(replace(session.status, playing=True, answered=2))
    assert controls._play.label == "Pause"


# Skills


def test_only_a_skill_that_has_joined_can_be_explored(server: viser.ViserServer) -> None:
    controls = Controls(server.gui, idle(), OFFERED)
    assert controls._explored.options == ("approach",)
    controls._explored._impl.value = "(no skill yet)"
    with pytest.raises(RefusedError, match="must have joined"):
        controls._exploration()


def test_where_nothing_is_explored_nothing_can_be_stopped(server: viser.ViserServer) -> None:
    controls = Controls(server.gui, idle(), OFFERED)
    assert not controls._end.visible
    with pytest.raises(RefusedError, match="nothing is being explored"):
        controls._end_of_exploration()
