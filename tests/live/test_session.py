"""The worker without a page: requests, pacing, and a run that no pace can change."""

import dataclasses
import queue
import threading
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from app.documents import presets
from app.live import held as held_module
from app.live import session as session_module
from app.live import snapshot
from app.live import worker as worker_module
from app.live.held import Opened
from app.live.requests import (
    GoBack,
    GoOn,
    OpenRun,
    Pause,
    PauseAtJoins,
    Play,
    Request,
    RunTo,
    SetSpeed,
    StartAgain,
    StepOnce,
    TrialOnce,
)
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.live.worker import FULL_SPEED
from app.schedule import carried
from learners import run as run_module
from learners.commands import (
    Explore,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    SetSchedule,
    StopExploring,
)
from learners.kernel.state import digest
from learners.names import MAX_TRIALS
from learners.run import Run, replay
from learners.schedule_spec import SkillTimer
from learners.spec import RunSpec
from tests.support.endless import WORLD

PATIENCE_S = 60.0
"""How long to wait for what must happen; reaching it is a failure."""
HARMLESS = StopExploring("avoid")
"""A request that is answered, and refused, since nothing of the kind is going on."""
SEED = 7

SessionOf = Callable[..., Session]


def spec_of(*settings: str, preset: str = "timed") -> RunSpec:
    """A preset in a small world."""
    return presets.load(preset, ["world.size=40", *settings])


LONG = spec_of("trials=1000000")
"""At full speed it is over in less than a second, before a thread that stood still looks again."""
BRISK = 200_000.0
"""A speed at which it takes a minute, whatever the machine does meanwhile."""


@pytest.fixture
def session_of() -> Iterator[SessionOf]:
    """Starts sessions, paused unless told otherwise, and ends them after the test."""
    started: list[Session] = []

    def start(
        spec: RunSpec | None = None, speed: float = FULL_SPEED, playing: bool = False
    ) -> Session:
        session = Session(spec or spec_of(), "timed", SEED, speed, playing)
        session.start()
        started.append(session)
        return session

    yield start
    for session in started:
        session.stop()


@pytest.fixture
def unhurried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a session that hurries take its time, so that it is still on its way when it is asked."""
    # What it aims at then is no full speed to the worker, which has the name for itself.
    monkeypatch.setattr("app.live.session.FULL_SPEED", 500_000.0)


def ask(session: Session, *requests: Request) -> Status:
    """The status in which all these requests have been answered."""
    ticket = max(session.submit(request) for request in requests)
    return session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)


def complaint(session: Session, request: Request) -> str | None:
    """Why a request was not carried out, None if it was."""
    complaints: list[str] = []
    ticket = session.submit(request, complaints.append)
    session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)
    return complaints[0] if complaints else None


def same(one: Snapshot, other: Snapshot) -> bool:
    """Whether two snapshots show the same moment of the same run."""
    tables = ("selection_q", "skill_q", "visits", "first_reach", "trail")
    numbers = ("step", "trial", "trial_step", "cell", "heading", "control", "ends", "recent")
    return all(np.array_equal(getattr(one, t), getattr(other, t)) for t in tables) and all(
        getattr(one, n) == getattr(other, n) for n in numbers
    )


def shows(status: Status, run: Run) -> bool:
    """Whether a session has come exactly to where a run stands."""
    return same(status.snapshot, snapshot.take(run, "timed", 0))


# Play, pause, one step, one trial


def test_a_paused_session_stands_still(session_of: SessionOf) -> None:
    status = ask(session_of(), HARMLESS, HARMLESS)
    assert not status.playing
    assert shows(status, Run(spec_of(), SEED))


def test_one_step_is_exactly_one(session_of: SessionOf) -> None:
    session, run = session_of(), Run(spec_of(), SEED)
    for _ in range(30):
        run.advance(max_steps=1)
        assert shows(ask(session, StepOnce()), run)


def test_one_trial_goes_to_the_start_of_the_next(session_of: SessionOf) -> None:
    session = session_of()
    ask(session, StepOnce(), StepOnce())
    for trial in (1, 2, 3):
        taken = ask(session, TrialOnce()).snapshot
        assert (taken.trial, taken.trial_step) == (trial, 0)


@pytest.mark.parametrize("request_", [StepOnce(), TrialOnce(), Pause()])
def test_stepping_and_pausing_stop_a_session_that_plays(
    session_of: SessionOf, request_: Request
) -> None:
    session = session_of(LONG, speed=BRISK, playing=True)
    session.wait_for(lambda status: status.snapshot.step > 1_000, PATIENCE_S)
    status = ask(session, request_)
    assert not status.playing
    assert status.steps_per_s == 0
    assert ask(session, HARMLESS).snapshot.step == status.snapshot.step


def test_play_goes_on_and_says_so(session_of: SessionOf) -> None:
    session = session_of(speed=20_000.0)
    assert ask(session, Play()).playing
    session.wait_for(lambda status: status.snapshot.trial >= 100, PATIENCE_S)


# The end of a run


def test_a_run_ends_after_its_trials_and_goes_on_for_as_many_again(session_of: SessionOf) -> None:
    session = session_of(spec_of("trials=150"), playing=True)
    for total in (150, 300, 450):
        status = session.wait_for(
            lambda status, total=total: status.snapshot.trial == total, PATIENCE_S
        )
        status = ask(session, HARMLESS)
        assert (status.finished, status.playing, status.exhausted) == (True, False, False)
        assert (status.snapshot.trial, status.snapshot.trial_step) == (total, 0)
        session.submit(GoOn())


def test_at_the_end_play_and_steps_are_refused_and_nothing_is_done(session_of: SessionOf) -> None:
    session = session_of(spec_of("trials=150"), playing=True)
    session.wait_for(lambda status: status.finished, PATIENCE_S)
    for request in (Play(), StepOnce(), TrialOnce()):
        assert complaint(session, request) == (
            "the 150 trials are over; under Run it can go on for more, or start again"
        )
    status = ask(session, HARMLESS)
    assert (status.snapshot.trial, status.playing, status.finished) == (150, False, True)


def test_after_all_the_trials_there_can_be_going_on_is_refused(
    session_of: SessionOf, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (session_module, held_module, run_module):
        monkeypatch.setattr(module, "MAX_TRIALS", 800)
    session = session_of(spec_of("trials=500"), playing=True)
    session.wait_for(lambda status: status.finished, PATIENCE_S)
    session.submit(GoOn())
    status = session.wait_for(lambda status: status.exhausted, PATIENCE_S)
    assert (status.snapshot.trial, status.finished, status.playing) == (800, True, False)
    for request in (Play(), GoOn(), StepOnce()):
        assert complaint(session, request) == "a run ends after 800 trials"


# Tickets and replies


def test_tickets_count_requests_from_all_threads(session_of: SessionOf) -> None:
    session = session_of(LONG, speed=BRISK, playing=True)
    tickets: list[int] = []

    def knock() -> None:
        for _ in range(50):
            tickets.append(session.submit(HARMLESS))

    knockers = [threading.Thread(target=knock) for _ in range(8)]
    for knocker in knockers:
        knocker.start()
    for knocker in knockers:
        knocker.join()
    assert sorted(tickets) == list(range(1, 401))
    assert session.wait_for(lambda s: s.answered >= 400, PATIENCE_S).answered == 400


def test_a_request_is_answered_only_once_it_is_done(session_of: SessionOf) -> None:
    session = session_of(LONG, speed=BRISK, playing=True)
    for number in range(30):
        frozen = number % 2 == 0
        assert ask(session, FreezeSelection(frozen)).snapshot.control.selection_frozen == frozen


def test_what_cannot_be_done_is_replied_and_changes_nothing(session_of: SessionOf) -> None:
    session = session_of()
    before = ask(session, TrialOnce())
    why = complaint(session, Explore("avoid", 100, 0.5))
    assert why == "'avoid' has not joined, so it cannot be explored"
    assert complaint(session, Introduce("approach", 5)) == "approach has joined already"
    after = ask(session, HARMLESS)
    assert same(before.snapshot, after.snapshot)
    assert after.error is None


def test_what_could_be_done_gets_no_complaint(session_of: SessionOf) -> None:
    assert complaint(session_of(), Introduce("avoid", 5)) is None


def test_a_complaint_without_a_listener_is_dropped(session_of: SessionOf) -> None:
    assert ask(session_of(), Explore("avoid", 100, 0.5)).error is None


def test_a_listener_that_fails_does_not_stop_the_learner(session_of: SessionOf) -> None:
    session = session_of()

    def gone(reason: str) -> None:
        raise ConnectionError("the browser is gone")

    ticket = session.submit(Explore("avoid", 100, 0.5), gone)
    status = session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)
    assert status.error is None
    assert ask(session, StepOnce()).snapshot.step == status.snapshot.step + 1


def test_waiting_for_what_does_not_happen_ends(session_of: SessionOf) -> None:
    with pytest.raises(TimeoutError):
        session_of().wait_for(lambda status: status.playing, timeout_s=0.01)


@pytest.mark.parametrize("step_s", [1e-7, 1e-5, 1e-3])
def test_on_any_machine_the_worker_is_deaf_only_for_moments(
    monkeypatch: pytest.MonkeyPatch, step_s: float
) -> None:
    now_s = 0.0

    class Machine(Run):
        def advance(
            self,
            max_steps: int = 2**62,
            until_trial: int | None = None,
            stops_at_rules: bool = False,
        ) -> int:
            nonlocal now_s
            now_s += max_steps * step_s
            return max_steps

    monkeypatch.setattr(session_module, "Run", Machine)
    clocks = SimpleNamespace(perf_counter=lambda: now_s, thread_time=lambda: now_s)
    monkeypatch.setattr(worker_module, "time", clocks)
    session = Session(LONG, "timed", SEED, FULL_SPEED, playing=True)
    for _ in range(30):
        session._learn()
    began_s = now_s
    session._learn()
    assert now_s - began_s == pytest.approx(worker_module.SLICE_S, rel=0.3)


# Start again


def test_start_again_is_a_new_run(session_of: SessionOf) -> None:
    session = session_of()
    ask(session, *[TrialOnce()] * 40, FreezeSelection(True))
    other = spec_of(preset="hierarchical_2")
    status = ask(session, StartAgain(other, "hierarchical_2", 11))
    assert shows(status, Run(other, 11))
    taken = status.snapshot
    assert (taken.preset, taken.seed, taken.generation) == ("hierarchical_2", 11, 1)
    assert len(taken.curve.steps) == 0
    assert not taken.learning_now.any()


def test_start_again_goes_on_playing(session_of: SessionOf) -> None:
    session = session_of(LONG, speed=BRISK, playing=True)
    session.wait_for(lambda status: status.snapshot.trial > 1_000, PATIENCE_S)
    assert ask(session, StartAgain(LONG, "timed", 1)).playing
    taken = session.wait_for(lambda status: status.snapshot.step > 100, PATIENCE_S).snapshot
    assert (taken.generation, taken.seed) == (1, 1)


def test_start_again_has_its_own_number_of_trials(session_of: SessionOf) -> None:
    session = session_of(spec_of("trials=100"))
    ask(session, StartAgain(spec_of("trials=60"), "timed", 1), Play())
    assert session.wait_for(lambda status: status.finished, PATIENCE_S).snapshot.trial == 60


# A run of an experiment, made again


NAME = "figure_4_1: timed, seed 3"
REFUSED = Introduce("approach", 5)
"""A request that is refused at any trial."""
FAR = 10**12
"""A step that no run gets to while a test lasts."""


def ended(spec: RunSpec, step: int | None = None, seed: int = 3) -> Run:
    """A plain run at a step, or after its preset's trials."""
    run = Run(spec, seed)
    if step is None:
        run.advance()
    else:
        run.advance(max_steps=step, until_trial=MAX_TRIALS)
    return run


def opening(run: Run) -> OpenRun:
    """The request for a run that ended like this one."""
    return OpenRun(run.preset, "timed", run.seed, run.step, digest(run.state), NAME)


def arrived(session: Session) -> Status:
    """The status in which a run has been made again."""
    return session.wait_for(
        lambda status: status.opened is not None and status.opened.same is not None, PATIENCE_S
    )


def on_the_way(session: Session, spec: RunSpec = LONG) -> Status:
    """The status in which a run is being made again, its end far away."""
    session.submit(OpenRun(spec, "timed", 3, FAR, "0" * 64, NAME))
    beyond = min(spec.trials, 1_000) + 10
    status = session.wait_for(
        lambda status: status.opened is not None and status.snapshot.trial > beyond, PATIENCE_S
    )
    assert status.opened == Opened(NAME, FAR, "0" * 64, same=None)
    assert status.playing
    return status


@pytest.mark.parametrize("preset", ["timed", "hierarchical_2", "standard_q"])
def test_a_run_is_made_again_up_to_its_end(session_of: SessionOf, preset: str) -> None:
    session = session_of()
    run = ended(spec_of("trials=300", preset=preset))
    session.submit(opening(run))
    status = arrived(session)
    assert shows(status, run)
    recorded = digest(run.state)
    assert status.opened == Opened(NAME, run.step, recorded, same=True, found=recorded)
    assert (status.playing, status.finished, status.error) == (False, True, None)
    taken = status.snapshot
    assert (taken.preset, taken.seed, taken.generation) == ("timed", 3, 1)
    assert taken.preset_spec == run.preset


@pytest.mark.parametrize("step", [1_000, 1_001, 4_321])
def test_a_run_is_made_again_up_to_the_very_step(session_of: SessionOf, step: int) -> None:
    session, run = session_of(), ended(spec_of("trials=300"), step)
    session.submit(opening(run))
    status = arrived(session)
    assert status.snapshot.trial_step > 0
    assert shows(status, run)
    assert status.opened is not None
    assert status.opened.same
    assert (status.playing, status.finished) == (False, False)


@pytest.mark.parametrize("step", [0, 1])
def test_a_run_that_ended_as_it_began_is_made_again(session_of: SessionOf, step: int) -> None:
    session = session_of()
    session.submit(opening(ended(LONG, step)))
    status = arrived(session)
    assert (status.snapshot.step, status.playing, status.preparing) == (step, False, False)
    assert status.opened is not None
    assert status.opened.same


def test_a_run_of_more_trials_than_its_preset_has_is_made_again(session_of: SessionOf) -> None:
    session, spec = session_of(), spec_of("trials=50")
    run = ended(spec, 20_000)
    assert run.trial > 60
    session.submit(opening(run))
    status = arrived(session)
    assert shows(status, run)
    assert status.finished
    assert ask(session, GoOn()).opened is None
    status = session.wait_for(lambda status: status.finished, PATIENCE_S)
    assert status.snapshot.trial == run.trial + 50


def test_another_digest_is_told_and_the_state_is_kept(session_of: SessionOf) -> None:
    session, run = session_of(), ended(spec_of("trials=300"))
    session.submit(dataclasses.replace(opening(run), digest="f" * 64))
    status = arrived(session)
    found = digest(run.state)
    assert status.opened == Opened(NAME, run.step, "f" * 64, same=False, found=found)
    assert shows(status, run)
    assert status.error is None


def test_a_run_that_never_gets_to_its_step_is_not_the_same(
    session_of: SessionOf, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (session_module, held_module, run_module):
        monkeypatch.setattr(module, "MAX_TRIALS", 800)
    session = session_of()
    session.submit(OpenRun(spec_of("trials=500"), "timed", 3, FAR, "0" * 64, NAME))
    status = arrived(session)
    assert status.opened is not None
    assert not status.opened.same
    assert (status.snapshot.trial, status.playing, status.exhausted) == (800, False, True)


@pytest.mark.usefixtures("unhurried")
@pytest.mark.parametrize("request_", [Pause(), StepOnce(), TrialOnce()])
def test_a_person_may_stop_it_on_the_way(session_of: SessionOf, request_: Request) -> None:
    session = session_of()
    on_the_way(session)
    status = ask(session, request_)
    assert (status.playing, status.opened, status.finished) == (False, None, False)
    assert shows(status, ended(LONG, status.snapshot.step))
    assert ask(session, HARMLESS).snapshot.step == status.snapshot.step
    assert ask(session, Play()).opened is None
    session.wait_for(lambda later: later.snapshot.step > status.snapshot.step, PATIENCE_S)


@pytest.mark.usefixtures("unhurried")
@pytest.mark.parametrize("request_", [Pause(), StepOnce(), TrialOnce(), FreezeSelection(True)])
def test_given_up_beyond_the_trials_of_its_preset_they_are_over(
    session_of: SessionOf, request_: Request
) -> None:
    session, spec = session_of(), spec_of("trials=50")
    on_the_way(session, spec)
    status = ask(session, request_)
    assert (status.playing, status.opened, status.finished) == (False, None, True)
    session.submit(GoOn())
    later = session.wait_for(lambda later: later.snapshot.step > status.snapshot.step, PATIENCE_S)
    later = session.wait_for(lambda later: later.finished, PATIENCE_S)
    assert later.snapshot.trial == status.snapshot.trial + 50


@pytest.mark.usefixtures("unhurried")
def test_a_command_on_the_way_makes_it_a_run_like_any_other(session_of: SessionOf) -> None:
    session = session_of(speed=BRISK)
    on_the_way(session, spec_of("trials=1000000", f"schedule.skills.avoid.at={MAX_TRIALS}"))
    status = ask(session, Introduce("avoid", 5))
    assert (status.playing, status.opened) == (True, None)


@pytest.mark.usefixtures("unhurried")
@pytest.mark.parametrize("request_", [Play(), SetSpeed(5.0), REFUSED])
def test_what_changes_nothing_on_the_way_does_not_stop_it(
    session_of: SessionOf, request_: Request
) -> None:
    session = session_of()
    step = on_the_way(session).snapshot.step
    status = ask(session, request_)
    assert status.playing
    assert status.opened is not None
    session.wait_for(lambda later: later.snapshot.step > step + 10_000, PATIENCE_S)


@pytest.mark.usefixtures("unhurried")
def test_another_run_takes_the_place_of_one_on_the_way(session_of: SessionOf) -> None:
    session = session_of(speed=BRISK)
    on_the_way(session)
    run = ended(spec_of("trials=300"))
    session.submit(opening(run))
    status = arrived(session)
    assert shows(status, run)
    assert status.snapshot.generation == 2
    on_the_way(session)
    status = ask(session, StartAgain(LONG, "timed", 1))
    assert (status.opened, status.playing) == (None, True)


@pytest.mark.usefixtures("unhurried")
def test_an_error_on_the_way_gives_it_up(
    session_of: SessionOf, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = session_of()
    on_the_way(session)
    break_learner(monkeypatch)
    status = session.wait_for(lambda status: status.error is not None, PATIENCE_S)
    assert (status.opened, status.playing) == (None, False)


def test_a_run_that_cannot_be_made_again_keeps_what_is_there(session_of: SessionOf) -> None:
    session, request_ = session_of(), opening(ended(spec_of("trials=300")))
    session.submit(request_)
    before = arrived(session)
    session.submit(dataclasses.replace(request_, seed=-1))
    status = session.wait_for(lambda status: status.error is not None, PATIENCE_S)
    assert same(status.snapshot, before.snapshot)
    assert status.opened == before.opened


@pytest.mark.parametrize(
    "request_", [Introduce("avoid", 5), FreezeSelection(True), StepOnce(), TrialOnce()]
)
def test_what_is_done_after_its_end_is_no_longer_of_the_experiment(
    session_of: SessionOf, request_: Request
) -> None:
    session = session_of()
    session.submit(opening(ended(LONG, 5_000)))
    arrived(session)
    status = ask(session, HARMLESS, Pause())
    assert status.opened is not None
    assert status.opened.same
    status = ask(session, request_)
    assert (status.opened, status.playing) == (None, False)


def test_after_its_end_it_plays_on(session_of: SessionOf) -> None:
    session, run = session_of(), ended(spec_of("trials=300"))
    session.submit(opening(run))
    arrived(session)
    session.submit(GoOn())
    status = session.wait_for(lambda status: status.snapshot.trial == 600, PATIENCE_S)
    run.advance(until_trial=600)
    assert shows(status, run)
    assert status.opened is None


def test_start_again_after_its_end_begins_paused(session_of: SessionOf) -> None:
    session = session_of()
    session.submit(opening(ended(LONG, 5_000)))
    arrived(session)
    status = ask(session, StartAgain(LONG, "timed", 1))
    assert (status.opened, status.playing, status.snapshot.generation) == (None, False, 2)


# A run is the same at any speed


@pytest.mark.parametrize("speed", [FULL_SPEED, 20_000.0, 5_000.0])
def test_a_run_is_the_same_at_any_speed(session_of: SessionOf, speed: float) -> None:
    spec = spec_of("trials=60", "schedule.skills.circle_clockwise.at=30")
    alone = Run(spec, SEED)
    alone.advance()
    session = session_of(spec, speed=speed, playing=True)
    status = session.wait_for(lambda status: status.finished, PATIENCE_S)
    assert alone.control.introductions[-1].trial == 30
    assert shows(status, alone)


def test_a_run_is_the_same_with_its_speed_changed_all_the_time(session_of: SessionOf) -> None:
    spec = spec_of("trials=400")
    alone = Run(spec, SEED)
    alone.advance()
    session = session_of(spec, speed=2_000.0, playing=True)
    for number in range(20):
        ask(session, SetSpeed(3_000.0 + 100 * number), StepOnce(), Play())
    ask(session, SetSpeed(FULL_SPEED))
    assert shows(session.wait_for(lambda status: status.finished, PATIENCE_S), alone)


def test_commands_given_live_are_in_the_journal_and_replay(session_of: SessionOf) -> None:
    session = session_of(speed=30_000.0, playing=True)
    commands = [
        Introduce("avoid", 20),
        Explore("avoid", 50, 0.6),
        FreezeSkills(True),
        FreezeSkills(False),
        FreezeSelection(True),
        FreezeSelection(False),
    ]
    for command in commands:
        step = session.status.snapshot.step
        session.wait_for(lambda status, step=step: status.snapshot.step > step, PATIENCE_S)
        assert complaint(session, command) is None
    status = ask(session, Pause())
    session.stop()
    run = session._held().run
    assert [command for _, command in run.journal] == commands
    steps = [step for step, _ in run.journal]
    assert steps[0] > 0
    assert steps == sorted(set(steps))
    again = replay(spec_of(), SEED, run.journal, run.step)
    assert digest(again.state) == digest(run.state)
    assert shows(status, again)


# Snapshots


def test_a_published_snapshot_never_changes(session_of: SessionOf) -> None:
    session = session_of(LONG, speed=BRISK, playing=True)
    taken = session.wait_for(lambda status: status.snapshot.trial > 1_000, PATIENCE_S).snapshot
    arrays = {
        field.name: value
        for field in dataclasses.fields(taken)
        if isinstance(value := getattr(taken, field.name), np.ndarray)
    }
    copies = {name: array.copy() for name, array in arrays.items()}
    session.wait_for(
        lambda status: status.snapshot.trial > taken.trial + 1_000 and status.playing, PATIENCE_S
    )
    assert {"selection_q", "value", "visits", "trail"} <= copies.keys()
    for name, array in arrays.items():
        np.testing.assert_array_equal(array, copies[name], err_msg=name)


def test_the_curve_is_made_anew_now_and_then_while_it_plays(session_of: SessionOf) -> None:
    session = session_of(speed=20_000.0, playing=True)
    first = session.wait_for(lambda s: len(s.snapshot.curve.steps) > 0, PATIENCE_S).snapshot
    session.wait_for(lambda s: s.snapshot.curve.steps.size > first.curve.steps.size, PATIENCE_S)


def test_a_pause_shows_the_newest_curve(session_of: SessionOf) -> None:
    session = session_of(LONG, speed=BRISK, playing=True)
    session.wait_for(lambda status: status.snapshot.trial > 500, PATIENCE_S)
    taken = ask(session, Pause()).snapshot
    assert taken.curve.steps[-1] >= taken.step - taken.trial_step


# Errors


class BrokenError(Exception):
    """What a broken learner raises."""


def break_learner(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let learning fail from now on."""

    def broken(self: Run, *limits: Any, **more: Any) -> int:
        raise BrokenError("the learner is broken")

    monkeypatch.setattr(Run, "advance", broken)


def test_an_error_while_playing_is_told_and_keeps_the_state(
    session_of: SessionOf, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = session_of()
    before = ask(session, *[TrialOnce()] * 30)
    break_learner(monkeypatch)
    session.submit(Play())
    status = session.wait_for(lambda status: status.error is not None, PATIENCE_S)
    assert status.error == "BrokenError: the learner is broken"
    assert not status.playing
    assert same(status.snapshot, before.snapshot)


def test_after_an_error_nothing_goes_on_until_the_next_run(
    session_of: SessionOf, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = session_of()
    with monkeypatch.context() as patched:
        break_learner(patched)
        session.submit(Play())
        session.wait_for(lambda status: status.error is not None, PATIENCE_S)
    for request in (Play(), StepOnce(), TrialOnce()):
        assert complaint(session, request) == (
            "the learner has stopped: BrokenError: the learner is broken"
        )
    asked = threading.Event()
    # Until this one has been told, the worker takes no other: both wait when it goes on.
    session.submit(Play(), lambda _: asked.wait(PATIENCE_S))
    session.submit(StartAgain(spec_of(), "timed", SEED))
    ticket = session.submit(StepOnce())
    asked.set()
    status = session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)
    assert (status.error, status.snapshot.step, status.snapshot.generation) == (None, 1, 1)


def test_a_run_that_cannot_be_made_is_an_error_and_keeps_the_old_one(
    session_of: SessionOf,
) -> None:
    session = session_of()
    before = ask(session, StepOnce())
    session.submit(StartAgain(spec_of(), "timed", -1))
    status = session.wait_for(lambda status: status.error is not None, PATIENCE_S)
    assert status.error is not None
    assert status.error.startswith("ValueError: seed: -1 is not allowed")
    assert same(status.snapshot, before.snapshot)
    assert status.snapshot.generation == 0


def test_a_request_that_fails_is_answered_all_the_same(
    session_of: SessionOf, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = session_of()
    break_learner(monkeypatch)
    ticket = session.submit(StepOnce())
    status = session.wait_for(lambda status: status.error is not None, PATIENCE_S)
    assert status.answered == ticket


def test_a_seed_that_is_not_allowed_is_refused_at_once() -> None:
    with pytest.raises(ValueError, match="seed: -3 is not allowed"):
        Session(spec_of(), "timed", -3, FULL_SPEED, playing=False)


# The end of the worker


@pytest.mark.parametrize("playing", [True, False])
@pytest.mark.parametrize("speed", [1.0, FULL_SPEED])
def test_stop_ends_the_worker(speed: float, playing: bool) -> None:
    # Those of a lab that other tests share go on.
    others = threading.enumerate()
    session = Session(LONG, "timed", SEED, speed, playing)
    session.start()
    ask(session, HARMLESS)
    started = [thread for thread in threading.enumerate() if thread not in others]
    workers = [thread for thread in started if thread.name == "learner"]
    assert workers
    session.stop()
    assert not any(worker.is_alive() for worker in workers)


def test_what_was_asked_before_the_stop_is_still_done() -> None:
    session = Session(spec_of(), "timed", SEED, FULL_SPEED, playing=False)
    session.start()
    session.submit(TrialOnce())
    session.stop()
    assert session.status.snapshot.trial == 1


def test_whoever_wants_to_know_is_called_once_a_status_tells_of_the_answer() -> None:
    session = Session(spec_of(), "timed", SEED, FULL_SPEED, playing=False)
    told = queue.SimpleQueue[int]()
    session.call_when_answered(lambda: told.put(session.status.answered))
    session.start()
    try:
        ticket = session.submit(TrialOnce())
        assert told.get(timeout=PATIENCE_S) >= ticket
    finally:
        session.stop()


# Pace


class Clock:
    """A clock that goes when it is told."""

    def __init__(self) -> None:
        self.now = 1_000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """The clock that paces sessions; all its readings here are exact as binary numbers."""
    clock = Clock()
    monkeypatch.setattr(
        worker_module, "time", SimpleNamespace(perf_counter=clock, thread_time=clock)
    )
    return clock


TICK_S = 3 / 32
"""Long enough to be published, short enough to be no stall."""
SPEED = 1024.0


def paced(session_of: SessionOf, speed: float) -> Session:
    """A session that plays at a speed and has made one step; the clock stands still."""
    session = session_of(speed=speed)
    assert ask(session, StepOnce(), Play()).snapshot.step == 1
    return session


def after(session: Session, clock: Clock, seconds: float) -> Status:
    """The status when the clock has gone on, and the worker has caught up with it."""
    clock.now += seconds
    return ask(session, REFUSED)


def test_a_speed_is_kept_to_the_step(session_of: SessionOf, clock: Clock) -> None:
    session = paced(session_of, SPEED)
    for tick in range(1, 21):
        status = after(session, clock, TICK_S)
        assert status.snapshot.step == 1 + tick * 96
    assert status.steps_per_s == SPEED


def test_no_time_no_step(session_of: SessionOf, clock: Clock) -> None:
    session = paced(session_of, SPEED)
    assert ask(session, HARMLESS, HARMLESS).snapshot.step == 1


def test_one_step_a_second(session_of: SessionOf, clock: Clock) -> None:
    session = paced(session_of, 1.0)
    steps = [after(session, clock, 0.25).snapshot.step for _ in range(12)]
    assert steps == [1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4]


def test_a_stall_is_forgiven_and_not_made_up_for(session_of: SessionOf, clock: Clock) -> None:
    session = paced(session_of, SPEED)
    assert after(session, clock, 3_600.0).snapshot.step == 1 + 102  # A tenth of a second.
    assert after(session, clock, TICK_S).snapshot.step - 103 in (96, 97)


def test_a_pause_is_not_made_up_for(session_of: SessionOf, clock: Clock) -> None:
    session = paced(session_of, SPEED)
    assert ask(session, Pause()).snapshot.step == 1
    assert after(session, clock, 60.0).snapshot.step == 1
    assert ask(session, Play()).snapshot.step == 1
    assert after(session, clock, TICK_S).snapshot.step == 1 + 96


def test_a_new_speed_counts_from_when_it_was_set(session_of: SessionOf, clock: Clock) -> None:
    session = paced(session_of, SPEED)
    clock.now += TICK_S / 3
    slowed = ask(session, SetSpeed(1.0))
    assert slowed.speed == 1.0
    assert slowed.snapshot.step <= 1 + 32
    assert after(session, clock, 0.75).snapshot.step == slowed.snapshot.step
    assert after(session, clock, 0.25).snapshot.step == slowed.snapshot.step + 1


def test_the_rate_shown_after_a_pause_is_that_since_the_pause(
    session_of: SessionOf, clock: Clock
) -> None:
    session = paced(session_of, SPEED)
    for _ in range(5):
        after(session, clock, TICK_S)
    ask(session, Pause())
    clock.now += 60.0
    ask(session, Play())
    after(session, clock, TICK_S)
    assert after(session, clock, TICK_S).steps_per_s == pytest.approx(SPEED, rel=0.01)


def test_requests_are_answered_in_order(session_of: SessionOf, clock: Clock) -> None:
    session = paced(session_of, 1.0)
    status = ask(session, Play(), StepOnce(), Pause(), TrialOnce(), StepOnce(), SetSpeed(5.0))
    run = Run(spec_of(), SEED)
    run.advance(until_trial=1)
    run.advance(max_steps=1)
    assert shows(status, run)
    assert (status.playing, status.speed) == (False, 5.0)


def test_a_set_speed_holds_again_once_a_run_has_been_made_again(
    session_of: SessionOf, clock: Clock
) -> None:
    session, run = session_of(speed=1.0), ended(LONG, 20_000)
    session.submit(opening(run))
    # The clock stands still, so at any set speed there would be no step.
    status = arrived(session)
    assert (status.snapshot.step, status.speed) == (run.step, 1.0)
    assert ask(session, Play()).opened == status.opened
    made = [after(session, clock, 0.25).snapshot.step - run.step for _ in range(8)]
    assert made == [0, 0, 0, 1, 1, 1, 1, 2]
    assert session.status.opened is None


def test_a_set_speed_holds_again_once_a_run_is_given_up(
    session_of: SessionOf, clock: Clock
) -> None:
    session = paced(session_of, 1.0)
    # While the clock stands still a hurry is at full speed: only a slow run is still on its way.
    slow = spec_of("trials=1000000", *(f"{name}={value}" for name, value in WORLD.items()))
    ask(session, OpenRun(slow, "timed", 3, FAR, "0" * 64, NAME))
    assert after(session, clock, 0.25).steps_per_s > 1_000
    status = ask(session, FreezeSkills(True))
    assert (status.playing, status.opened, status.steps_per_s) == (True, None, 0.0)
    made = [after(session, clock, 0.25).snapshot.step - status.snapshot.step for _ in range(8)]
    assert made == [0, 0, 0, 1, 1, 1, 1, 2]


def test_the_run_that_was_set_aside_is_taken_up_where_it_was(session_of: SessionOf) -> None:
    session = session_of()
    ask(session, *[TrialOnce()] * 5, FreezeSelection(True))
    before = ask(session, HARMLESS)
    assert before.aside is None
    for seed in (8, 9):
        session.submit(opening(ended(spec_of("trials=300"), seed=seed)))
        status = session.wait_for(
            lambda status, seed=seed: (
                status.opened is not None
                and status.opened.same is not None
                and status.snapshot.seed == seed
            ),
            PATIENCE_S,
        )
        assert status.aside == f"{before.snapshot.preset}, trial 5"
    back = ask(session, GoBack())
    assert (back.aside, back.opened, back.playing) == (None, None, False)
    # Whoever kept something of that run knows it again.
    assert back.snapshot.generation == before.snapshot.generation
    assert (back.snapshot.step, back.snapshot.seed) == (before.snapshot.step, before.snapshot.seed)
    assert back.snapshot.control == before.snapshot.control
    assert np.array_equal(back.snapshot.selection_q, before.snapshot.selection_q)
    refusals: list[str] = []
    ticket = session.submit(GoBack(), refusals.append)
    session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)
    assert refusals == ["no run was set aside"]


def test_what_was_playing_plays_on(session_of: SessionOf) -> None:
    session = session_of(speed=20_000.0)
    ask(session, Play())
    session.submit(opening(ended(spec_of("trials=300"))))
    assert not arrived(session).playing
    assert ask(session, GoBack()).playing


def test_start_again_from_a_run_of_an_experiment_keeps_the_lesson_that_came_before(
    session_of: SessionOf,
) -> None:
    session = session_of()
    lesson = ask(session, *[TrialOnce()] * 5).snapshot
    session.submit(opening(ended(spec_of("trials=300"))))
    arrived(session)
    assert ask(session, StartAgain(spec_of(), "timed", SEED)).aside == "timed, trial 5"
    assert same(ask(session, GoBack()).snapshot, lesson)


# What was set aside


def test_starting_again_can_be_undone_and_that_too(session_of: SessionOf) -> None:
    session = session_of()
    former = ask(session, *[TrialOnce()] * 40, FreezeSelection(True))
    begun = ask(session, StartAgain(spec_of(preset="hierarchical_2"), "hierarchical_2", 11))
    assert (begun.aside, begun.playing) == ("timed, trial 40", False)
    later = ask(session, *[TrialOnce()] * 3)
    back = ask(session, GoBack())
    assert same(back.snapshot, former.snapshot)
    assert back.snapshot.generation == former.snapshot.generation
    assert back.aside == "hierarchical_2, trial 3"
    assert same(ask(session, GoBack()).snapshot, later.snapshot)


def test_one_run_is_set_aside_and_none_in_which_nothing_was_done(session_of: SessionOf) -> None:
    session = session_of()
    assert ask(session, StartAgain(spec_of(), "timed", 1)).aside is None
    ask(session, *[TrialOnce()] * 2)
    for seed in (2, 3, 4):
        assert ask(session, StartAgain(spec_of(), "timed", seed)).aside == "timed, trial 2"
    ask(session, FreezeSkills(True))
    assert ask(session, StartAgain(spec_of(), "timed", 5)).aside == "timed, trial 0"
    assert ask(session, GoBack()).snapshot.seed == 4
    # Of the one that was gone back from, there is nothing to keep.
    assert session.status.aside is None


def test_what_played_as_it_was_set_aside_plays_on_when_it_is_back(session_of: SessionOf) -> None:
    session = session_of(LONG, speed=BRISK, playing=True)
    session.wait_for(lambda status: status.snapshot.trial > 100, PATIENCE_S)
    status = ask(session, StartAgain(LONG, "timed", 1), Pause(), GoBack())
    assert (status.playing, status.snapshot.seed) == (True, SEED)


@pytest.mark.parametrize("trials", [100, 1_000_000])
def test_start_again_plays_on_but_not_after_the_end(session_of: SessionOf, trials: int) -> None:
    session = session_of(spec_of(f"trials={trials}"), speed=BRISK, playing=True)
    session.wait_for(lambda status: status.snapshot.trial >= 100, PATIENCE_S)
    assert ask(session, StartAgain(LONG, "timed", 1)).playing == (trials > 100)


def test_start_again_stands_still_where_that_is_asked_for(session_of: SessionOf) -> None:
    session = session_of(LONG, speed=BRISK, playing=True)
    session.wait_for(lambda status: status.snapshot.trial > 100, PATIENCE_S)
    status = ask(session, StartAgain(LONG, "timed", 1, paused=True), HARMLESS)
    assert (status.playing, status.snapshot.step, status.speed) == (False, 0, BRISK)


# Starting again with a schedule that was drawn


def test_a_drawn_schedule_is_kept_by_a_command_before_the_first_step(
    session_of: SessionOf,
) -> None:
    spec = spec_of("trials=400")
    early = {"circle_clockwise": SkillTimer(at=30, freeze=10), "avoid": SkillTimer(at=90)}
    drawn = spec.schedule.model_copy(update={"skills": {**spec.schedule.skills, **early}})
    session = session_of(spec)
    status = ask(session, StartAgain(spec, "timed", 5, drawn))
    taken = status.snapshot
    assert (taken.preset_spec, taken.spec.schedule) == (spec, drawn)
    ask(session, Play())
    status = session.wait_for(lambda status: status.finished, PATIENCE_S)
    again = replay(spec, 5, [(0, SetSchedule(drawn))], status.snapshot.step)
    assert shows(status, again)
    # Saved as a preset and loaded again, it is the same run.
    saved = presets.parse(presets.dump(carried.preset_of(status.snapshot).spec).encode(), "x.yaml")
    loaded = Run(saved, 5)
    loaded.advance()
    assert digest(loaded.state) == digest(again.state)


def test_a_schedule_that_does_not_fit_is_refused_and_nothing_has_changed(
    session_of: SessionOf,
) -> None:
    session, spec = session_of(), spec_of(preset="hierarchical_2")
    before = ask(session, TrialOnce())
    why = complaint(session, StartAgain(spec, "hierarchical_2", 5, spec_of().schedule))
    assert why is not None
    assert "schedule" in why
    after = ask(session, HARMLESS)
    assert same(after.snapshot, before.snapshot)
    assert after.aside is None


# Which run is meant


def refusal(session: Session, request: Request, run: int) -> str | None:
    """Why a request of a run was not carried out, None if it was."""
    complaints: list[str] = []
    ticket = session.submit(request, complaints.append, run)
    session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)
    return complaints[0] if complaints else None


def test_what_is_asked_of_a_run_is_done_with_that_run(session_of: SessionOf) -> None:
    session = session_of()
    own = ask(session, TrialOnce()).snapshot.generation
    session.submit(opening(ended(spec_of("trials=300"))))
    made_again = arrived(session).snapshot.generation
    assert refusal(session, FreezeSelection(True), own) is None
    assert not session.status.snapshot.control.selection_frozen
    assert refusal(session, FreezeSkills(True), made_again) is None
    assert session.status.snapshot.control.skills_frozen
    control = ask(session, GoBack()).snapshot.control
    assert (control.selection_frozen, control.skills_frozen) == (True, False)


def test_what_is_asked_of_a_run_that_is_gone_is_refused(session_of: SessionOf) -> None:
    session = session_of()
    session.submit(opening(ended(spec_of("trials=300"))))
    gone = arrived(session).snapshot.generation
    ask(session, GoBack())
    said = "the run that this was meant for is not here any more"
    for request in (FreezeSelection(True), Play(), StepOnce()):
        assert refusal(session, request, gone) == said
    status = ask(session, HARMLESS)
    assert (status.playing, status.snapshot.step) == (False, 0)
    # These are of the session.
    assert refusal(session, SetSpeed(5.0), gone) is None
    assert refusal(session, StartAgain(LONG, "timed", 1), gone) is None


# Run to a trial, and pause at joins


TWO_JOINS = (
    "trials=400",
    "schedule.skills.avoid.at=120",
    "schedule.skills.circle_clockwise.at=180",
)


def stood(session: Session, trial: int) -> Status:
    """The status in which a session stands still at the start of a trial."""
    return session.wait_for(lambda s: s.snapshot.trial >= trial and not s.playing, PATIENCE_S)


@pytest.mark.parametrize("speed", [FULL_SPEED, 5.0])
def test_it_runs_to_the_start_of_a_trial_at_full_speed(session_of: SessionOf, speed: float) -> None:
    session, alone = session_of(speed=speed), Run(spec_of(), SEED)
    session.submit(RunTo(250))
    status = stood(session, 250)
    assert (status.runs_to, status.speed, status.finished) == (None, speed, False)
    alone.advance(until_trial=250)
    assert shows(status, alone)


def test_it_runs_to_a_trial_beyond_those_that_it_was_to_have(session_of: SessionOf) -> None:
    session = session_of(spec_of("trials=100"))
    ask(session, RunTo(130))
    status = stood(session, 130)
    assert (status.snapshot.trial, status.snapshot.trial_step, status.finished) == (130, 0, True)
    assert complaint(session, RunTo(MAX_TRIALS + 1)) == f"a run ends after {MAX_TRIALS:,} trials"
    assert "trial 130 has begun already" in (complaint(session, RunTo(130)) or "")


@pytest.mark.usefixtures("unhurried")
@pytest.mark.parametrize("request_", [Pause(), Play(), StepOnce(), TrialOnce()])
def test_whoever_says_otherwise_on_the_way_to_a_trial_is_heeded(
    session_of: SessionOf, request_: Request
) -> None:
    session = session_of(LONG, speed=BRISK)
    assert ask(session, RunTo(900_000), FreezeSkills(True)).runs_to == 900_000
    status = ask(session, request_)
    assert (status.runs_to, status.playing) == (None, isinstance(request_, Play))


def test_it_pauses_where_the_schedule_is_about_to_add_a_skill(session_of: SessionOf) -> None:
    spec = spec_of(*TWO_JOINS)
    session, alone = session_of(spec), Run(spec, SEED)
    assert ask(session, PauseAtJoins(True), Play()).pauses_at_joins
    for trial in (120, 180):
        status = stood(session, trial)
        alone.advance(until_trial=trial)
        assert shows(status, alone)
        ask(session, Play())
    assert stood(session, 400).finished


def test_a_join_pauses_what_runs_to_a_trial_and_one_that_will_not_be_does_not(
    session_of: SessionOf,
) -> None:
    session = session_of(spec_of(*TWO_JOINS))
    ask(session, PauseAtJoins(True), RunTo(300))
    assert stood(session, 120).runs_to is None
    ask(session, Introduce("circle_clockwise", 5), RunTo(300))
    assert stood(session, 300).snapshot.trial == 300
