"""The first hunts of a session: seen, then over by themselves, and nothing learned otherwise."""

from types import SimpleNamespace

import numpy as np
import pytest

from app.documents import presets
from app.live import session as session_module
from app.live import worker as worker_module
from app.live.opening import END_S, HUNTS, Opening, seen_at
from app.live.requests import (
    Begin,
    OpenRun,
    Pause,
    Play,
    Request,
    SetSpeed,
    SkipOpening,
    StartAgain,
    TrialOnce,
)
from app.live.session import Session
from app.live.worker import FULL_SPEED
from learners.kernel.state import digest
from learners.run import Run
from learners.spec import RunSpec

SPEED = 20_000.0
SLOW_STEPS_PER_S = 20.0
PATIENCE_S = 60.0
"""How long to wait for what must happen; reaching it is a failure."""
MOST_S = 6.0
"""What a hunt takes at most, rests included."""


class Watched(Session):
    """A session on a clock of its own, in whose time nothing but waiting takes any."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, spec: RunSpec, seed: int = 0, speed: float = SPEED
    ) -> None:
        self.now_s = 0.0
        clocks = SimpleNamespace(
            perf_counter=lambda: self.now_s, thread_time=lambda: self.now_s + 1e-6
        )
        monkeypatch.setattr(session_module, "time", clocks)
        monkeypatch.setattr(worker_module, "time", clocks)
        super().__init__(spec, "timed", seed, speed, playing=True, opening=True)
        self.shown: list[tuple[int, int]] = []
        """Of each moment that was published, its trial and step of the trial."""

    @property
    def aim(self) -> float | None:
        """Steps per second that it makes now."""
        return self._aim()

    @property
    def opening(self) -> Opening | None:
        """What is said of it."""
        return self.status.opening

    @property
    def digest(self) -> str:
        """Of its tables."""
        return digest(self._held().run.state)

    def go_on(self) -> None:
        """Wait for the next step, and make it."""
        speed, before = self.aim, self.status
        assert speed is not None
        # No clock stands still.
        self.now_s += max(self._pace.wait_s(speed), 1e-6)
        self._learn()
        taken = self.status.snapshot
        if self.status is not before:
            self.shown.append((taken.trial, taken.trial_step))

    def go_to_trial(self, trial: int) -> None:
        """Go on until so many hunts are over."""
        while self.status.snapshot.trial < trial:
            self.go_on()

    def ask(self, request: Request) -> None:
        """Have something done."""
        self._carry_out(request, None)
        self._publish()


@pytest.mark.parametrize("preset", ["timed", "standard_q"])
@pytest.mark.parametrize("seed", range(4))
def test_the_first_hunts_take_seconds_whatever_they_need(
    monkeypatch: pytest.MonkeyPatch, preset: str, seed: int
) -> None:
    watched = Watched(monkeypatch, presets.load(preset), seed)
    began_s = 0.0
    for trial in range(1, HUNTS + 1):
        watched.go_to_trial(trial)
        last = watched.status.snapshot
        # Its end is published as it stands, and rests.
        assert (last.trial, last.trial_step) == (trial, 0)
        assert watched.opening == Opening(trial, HUNTS, rising=False)
        assert last.paths[-1].cells.size > 1
        ended_s = watched.now_s
        watched.go_on()
        assert watched.now_s - ended_s == pytest.approx(END_S, abs=0.01)
        # Less a first step, all is within the time.
        assert 1.0 <= watched.now_s - began_s <= MOST_S + 1.5
        began_s = watched.now_s


def test_the_last_steps_of_a_hunt_are_seen_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    watched = Watched(monkeypatch, presets.load("standard_q"), seed=2)
    watched.go_to_trial(2)
    steps = [step for trial, step in watched.shown if trial == 1]
    # Of 391, those before the last ones are hurried through.
    assert len(steps) < 100
    assert np.diff(steps[-15:]).max() <= 4


def test_the_speed_rises_to_the_one_that_is_set_and_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    watched = Watched(monkeypatch, presets.load("timed"))
    watched.go_to_trial(HUNTS)
    watched.go_on()
    began_s = watched.now_s
    speeds: list[float] = []
    while watched.opening is not None:
        speeds.append(watched.aim or 0.0)
        watched.go_on()
    assert watched.now_s - began_s == pytest.approx(5, abs=0.2)
    assert speeds[0] == pytest.approx(SLOW_STEPS_PER_S)
    assert speeds == sorted(speeds)
    assert watched.aim == watched.status.speed == SPEED


def test_full_speed_comes_after_it_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    watched = Watched(monkeypatch, presets.load("timed"), speed=FULL_SPEED)
    slow = watched.aim
    assert slow is not None
    assert slow < SLOW_STEPS_PER_S
    watched.ask(SkipOpening())
    assert watched.aim == FULL_SPEED


def again(spec: RunSpec) -> StartAgain:
    return StartAgain(spec, "timed", 1)


@pytest.mark.parametrize("trial", [0, 1])
@pytest.mark.parametrize("ending", ["skip", "speed", "again", "open"])
def test_who_skips_it_or_sets_a_speed_or_begins_another_run_has_seen_it(
    monkeypatch: pytest.MonkeyPatch, ending: str, trial: int
) -> None:
    spec = presets.load("timed")
    watched = Watched(monkeypatch, spec)
    watched.go_to_trial(trial)
    assert watched.opening is not None
    run = Run(spec, 3)
    run.advance(max_steps=100)
    requests: dict[str, Request] = {
        "skip": SkipOpening(),
        "speed": SetSpeed(500.0),
        "again": again(spec),
        "open": OpenRun(spec, "timed", 3, run.step, digest(run.state), "one"),
    }
    watched.ask(requests[ending])
    assert watched.opening is None
    expected = {"speed": 500.0, "open": FULL_SPEED}
    assert watched.aim == expected.get(ending, SPEED)


def test_a_pause_is_not_the_end_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    watched = Watched(monkeypatch, presets.load("timed"))
    watched.go_to_trial(1)
    watched.ask(Pause())
    assert watched.opening == Opening(1, HUNTS, rising=False)
    watched.ask(TrialOnce())
    assert watched.opening == Opening(2, HUNTS, rising=False)
    watched.ask(Play())
    watched.go_to_trial(HUNTS)
    assert watched.opening == Opening(HUNTS, HUNTS, rising=False)


def test_a_run_that_is_over_opens_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    watched = Watched(monkeypatch, presets.load("timed", ["trials=2"]))
    watched.go_to_trial(2)
    assert watched.aim is None
    assert watched.opening is None


def test_nobody_else_is_slowed() -> None:
    session = Session(presets.load("timed"), "timed", 0, FULL_SPEED, playing=False)
    session.start()
    session.submit(Begin())
    status = session.wait_for(lambda status: status.snapshot.trial > HUNTS, PATIENCE_S)
    session.stop()
    assert status.opening is None


def test_what_is_learned_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = presets.load("timed", ["world.size=40"])
    watched = Watched(monkeypatch, spec, seed=5)
    while watched.opening is not None:
        watched.go_on()
    watched.go_to_trial(watched.status.snapshot.trial + 100)
    watched.ask(Pause())
    run = Run(spec, 5)
    run.advance(max_steps=watched.status.snapshot.step)
    assert watched.digest == digest(run.state)


@pytest.mark.parametrize("length", [1, 2, 10, 30, 31, 200, 500, 10_000])
def test_a_hunt_that_is_watched_takes_as_long(length: int) -> None:
    seen_s = seen_at(length)
    assert len(seen_s) == length
    assert (np.diff(seen_s) > 0).all()
    assert 1.9 <= seen_s[-1] + 1e-9 <= MOST_S - END_S
