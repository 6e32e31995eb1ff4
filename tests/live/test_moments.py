"""Moments are made in a thread of their own, each viewer's newest wish, and nothing wedges it."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from app.live import snapshot
from app.live.moments import LEARNING_STEPS, Moments, moment_at
from app.live.past import Budget, Past
from app.live.places import Place
from app.live.snapshot import Snapshot
from app.live.wishes import MOST_WAITING
from learners.commands import CommandError, FreezeSelection, SetParameter
from learners.kernel.state import selection_q_of
from learners.run import Run, replay
from tests.support.lines import SEED, SPEC, play, stands

PATIENCE_S = 60.0
LINE = 3


class Lines:
    """Some lines, and moments of them; it counts what was found."""

    def __init__(self) -> None:
        self.run = Run(SPEC, SEED)
        self.past = Past(self.run, Budget())
        play(self.run, self.past, [(900, FreezeSelection(True)), (300, FreezeSelection(False))])
        self.run.advance(max_steps=9_000, until_trial=10_000)
        self.past.note(self.run)
        self.pasts: dict[int, Past] = {LINE: self.past}
        self.moments = Moments(self.pasts.get, "preset {}".format)
        self.news = threading.Semaphore(0)
        self.moments.call_when_found(self.news.release)

    def wait(self) -> None:
        """Until something more is found, or could not be."""
        assert self.news.acquire(timeout=PATIENCE_S)

    def look(self, step: int, viewer: str = "me", line: int = LINE) -> Snapshot | None:
        """Wish for a moment, and wait for what comes of it."""
        self.moments.want(viewer, Place(line, step))
        self.wait()
        return self.moments.found(viewer)

    @contextmanager
    def held(self) -> Iterator[None]:
        """While the thread is busy with something else."""
        is_held, go_on = threading.Event(), threading.Event()
        self.moments.ask(is_held.set, lambda _: go_on.wait(PATIENCE_S))
        assert is_held.wait(PATIENCE_S)
        yield
        go_on.set()

    def done(self, do: Callable[[], Any]) -> Any:
        """What comes of something that is done in the thread."""
        came, over = [], threading.Event()

        def take(result: Any) -> None:
            came.append(result)
            over.set()

        self.moments.ask(do, take, take)
        assert over.wait(PATIENCE_S)
        return came[0]


@pytest.fixture
def lines() -> Iterator[Lines]:
    made = Lines()
    yield made
    made.moments.stop()


def is_same(one: Any, other: Any) -> bool:
    """Whether two snapshots, or parts of them, are equal in everything."""
    if isinstance(one, np.ndarray):
        return bool(one.dtype == other.dtype and np.array_equal(one, other, equal_nan=True))
    if isinstance(one, Snapshot):
        return all(is_same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(is_same, one, other))
    if hasattr(one, "cells"):
        return is_same(one.cells, other.cells) and one.outcome == other.outcome
    return bool(one == other or (one != one and other != other))


# What is made


@pytest.mark.parametrize("step", [0, 1, 899, 900, 1_200, 1_999, 5_000, 10_200])
def test_a_moment_is_a_snapshot_of_a_run_that_stopped_there(lines: Lines, step: int) -> None:
    stopped = replay(SPEC, SEED, lines.run.journal, step)
    made = lines.look(step)
    assert made is not None
    plain = snapshot.take(stopped, "preset 3", LINE)
    former = replay(SPEC, SEED, lines.run.journal, max(step - LEARNING_STEPS, 0))
    at_once = snapshot.take(stopped, "preset 3", LINE, snapshot.take(former, "preset 3", LINE))
    assert is_same(made.learning_now, at_once.learning_now)
    for field in fields(Snapshot):
        if field.name != "learning_now":
            assert is_same(getattr(made, field.name), getattr(plain, field.name)), field.name


def test_a_moment_is_the_same_whenever_it_is_made(lines: Lines) -> None:
    first = lines.look(7_000)
    for step in (300, 8_500, 6_999, 7_500):
        lines.look(step)
    assert is_same(lines.look(7_000), first)
    assert first is not None
    assert first.learning_now.any()


def test_beyond_the_end_is_the_end(lines: Lines) -> None:
    made = lines.look(10**9)
    assert made is not None
    assert made.step == lines.run.step
    play(lines.run, lines.past, [], rest=0)
    lines.run.advance(max_steps=500, until_trial=10_000)
    lines.past.note(lines.run)
    made = lines.look(10**9)
    assert made is not None
    assert made.step == lines.run.step


# Whose turn it is


def test_of_what_a_viewer_wishes_the_newest_counts(lines: Lines) -> None:
    with lines.held():
        for step in range(1_000, 9_000, 100):
            lines.moments.want("me", Place(LINE, step))
        lines.moments.want("you", Place(LINE, 500))
        lines.moments.want("me", Place(LINE, 4_321))
    lines.wait()
    lines.wait()
    assert not lines.news.acquire(blocking=False)
    mine, yours = lines.moments.found("me"), lines.moments.found("you")
    assert mine is not None
    assert yours is not None
    assert (mine.step, yours.step) == (4_321, 500)


def test_viewers_are_served_in_turn(lines: Lines) -> None:
    served: list[str] = []
    viewers = [f"viewer {n}" for n in range(5)]

    def note() -> None:
        served.extend(v for v in viewers if lines.moments.found(v) and v not in served)
        # Whoever is quick wishes again at once.
        lines.moments.want(viewers[0], Place(LINE, 2_000 + 10 * len(served)))
        lines.news.release()

    lines.moments.call_when_found(note)
    with lines.held():
        for place, viewer in enumerate(viewers):
            lines.moments.want(viewer, Place(LINE, 1_000 * place))
    while len(served) < len(viewers):
        lines.wait()
    assert served == viewers
    lines.moments.call_when_found(lines.news.release)


def test_what_is_there_already_is_not_made_again(lines: Lines) -> None:
    first = lines.look(5_000)
    lines.moments.want("me", Place(LINE, 5_000))
    assert lines.look(400, "you") is not None
    assert lines.moments.found("me") is first
    # At the end of the line something may still be done, which makes another moment of it.
    before = lines.look(lines.run.step)
    lines.run.apply(SetParameter("learner.epsilon", 0.4))
    lines.past.note(lines.run)
    after = lines.look(lines.run.step)
    assert before is not None
    assert after is not None
    assert before.spec.learner.epsilon != after.spec.learner.epsilon == 0.4


def test_who_goes_back_while_another_moment_is_made_is_shown_that_of_the_newest_wish(
    lines: Lines, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert lines.look(900) is not None
    is_made, go_on = threading.Event(), threading.Event()

    def slowly(past: Past, place: Place, *rest: Any) -> Snapshot | None:
        made = moment_at(past, place, *rest)
        is_made.set()
        assert go_on.wait(PATIENCE_S)
        return made

    monkeypatch.setattr("app.live.moments.moment_at", slowly)
    lines.moments.want("me", Place(LINE, 5_000))
    assert is_made.wait(PATIENCE_S)
    lines.moments.want("me", Place(LINE, 900))
    go_on.set()
    lines.wait()
    lines.wait()
    found = lines.moments.found("me")
    assert found is not None
    assert found.step == 900


def test_a_viewer_that_is_forgotten_gets_nothing(lines: Lines) -> None:
    lines.look(500)
    with lines.held():
        lines.moments.want("me", Place(LINE, 800))
        lines.moments.forget("me")
        assert lines.moments.found("me") is None
        lines.moments.want("you", Place(LINE, 900))
    lines.wait()
    assert not lines.news.acquire(blocking=False)
    assert lines.moments.found("me") is None


# Other things


def test_other_things_are_done_in_the_thread_and_told(lines: Lines) -> None:
    assert lines.done(lambda: threading.current_thread().name) == "moments"
    assert stands(lines.done(lambda: lines.past.run_at(800))) == stands(
        replay(SPEC, SEED, lines.run.journal, 800)
    )


def refuse() -> None:
    raise CommandError("not there")


def fail() -> None:
    raise ZeroDivisionError("how can that be")


def test_what_fails_is_told_and_the_thread_goes_on(
    lines: Lines, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert lines.done(refuse) == "not there"
    assert lines.done(fail) == "ZeroDivisionError: how can that be"
    found = lines.look(500)
    monkeypatch.setattr(lines.past, "run_at", lambda *args: fail())
    lines.look(900)
    assert lines.moments.found("me") is found
    assert lines.moments.fault("me") == "ZeroDivisionError: how can that be"
    monkeypatch.undo()
    made = lines.look(900)
    assert made is not None
    assert made.step == 900
    assert lines.moments.fault("me") is None


def test_whoever_is_told_may_fail(lines: Lines) -> None:
    lines.moments.ask(refuse, lambda _: None, lambda _: fail())
    lines.moments.ask(lambda: None, lambda _: fail())
    lines.moments.call_when_found(fail)
    lines.moments.want("me", Place(LINE, 300))
    assert lines.done(lambda: 7) == 7
    lines.moments.call_when_found(lines.news.release)
    assert lines.look(700) is not None


def test_a_line_that_is_gone_is_told_of(lines: Lines) -> None:
    assert lines.look(500, line=8) is None
    assert lines.moments.fault("me") == "that line is not here any more"
    assert lines.look(500) is not None
    assert lines.moments.fault("me") is None


def test_only_so_much_is_asked_for(lines: Lines) -> None:
    refused: list[str] = []
    done = threading.Semaphore(0)
    with lines.held():
        for _ in range(MOST_WAITING + 3):
            lines.moments.ask(lambda: 0, lambda _: done.release(), refused.append)
        assert len(refused) == 3
    assert all(done.acquire(timeout=PATIENCE_S) for _ in range(MOST_WAITING))
    assert lines.done(lambda: 7) == 7


def test_what_can_wait_is_done_meanwhile(lines: Lines) -> None:
    order: list[str] = []
    over = threading.Event()

    def little() -> bool:
        order.append("little")
        if len(order) >= 6:
            over.set()
        return not over.is_set()

    with lines.held():
        lines.moments.do_meanwhile(little)
        lines.moments.do_meanwhile(lambda: bool(fail()), order.append)
        lines.moments.want("me", Place(LINE, 1_000))
    assert over.wait(PATIENCE_S)
    lines.wait()
    assert order.count("ZeroDivisionError: how can that be") == 1
    assert order.count("little") == 5


def test_it_stops(lines: Lines) -> None:
    lines.moments.stop()
    lines.moments.want("me", Place(LINE, 500))
    refused: list[str] = []
    lines.moments.ask(lambda: 0, lambda _: None, refused.append)
    assert len(refused) == 1
    # Those of sessions that other tests have left may still be ending.
    before = threading.enumerate()
    other = Lines()
    other.look(600)
    begun = [thread for thread in threading.enumerate() if thread not in before]
    assert [thread.name for thread in begun] == ["moments"]
    other.moments.stop()
    assert not begun[0].is_alive()


# When values rose


def test_the_step_at_which_a_value_rose_is_found(lines: Lines) -> None:
    reached = lines.run.state.first_reach
    risen = np.flatnonzero(reached >= 0)
    assert risen.size > 20
    for state in risen[:: max(risen.size // 20, 1)].tolist():
        trial = int(reached[state])
        place = lines.moments.rise_of(LINE, state, trial)
        assert place is not None
        before = lines.past.run_at(place.step - 1)
        after = lines.past.run_at(place.step)
        assert before is not None
        assert after is not None
        assert before.state.first_reach[state] == -1
        assert after.state.first_reach[state] == trial == before.trial


def test_a_value_that_did_not_rise_then_has_no_such_step(lines: Lines) -> None:
    reached = lines.run.state.first_reach
    never = int(np.flatnonzero(reached < 0)[0])
    some = int(np.flatnonzero(reached >= 0)[0])
    trial = int(reached[some])
    assert lines.moments.rise_of(LINE, never, 3) is None
    for other in (trial - 1, trial + 1, -1, 10**9):
        assert lines.moments.rise_of(LINE, some, other) is None
    assert lines.moments.rise_of(LINE, 10**9, trial) is None
    assert lines.moments.rise_of(LINE, -1, trial) is None
    assert lines.moments.rise_of(99, some, trial) is None


# Beside a run that goes on


def test_moments_are_exact_while_the_line_goes_on(lines: Lines) -> None:
    stop = threading.Event()
    run, past = lines.run, lines.past

    def learn() -> None:
        epsilon = 0.1
        while not stop.is_set() and run.step < 3_000_000:
            run.advance(max_steps=997, until_trial=100_000)
            past.note(run)
            if run.step % 9_970 < 997:
                epsilon = 0.3 - epsilon
                run.apply(SetParameter("learner.epsilon", epsilon), replacing=True)
                past.note(run)

    learning = threading.Thread(target=learn)
    learning.start()
    rng = np.random.default_rng(1)
    found = []
    for _ in range(60):
        step = int(rng.integers(past.end_step + 1))
        made = lines.look(step)
        assert made is not None
        assert made.step == step
        found.append((step, made))
    stop.set()
    learning.join()
    rewards = run.state.log_reward[: run.trial]
    for step, made in found[::6]:
        stopped = replay(SPEC, SEED, run.journal, step)
        again = moment_at(past, Place(LINE, step), "preset 3")
        assert again is not None
        assert is_same(made, again)
        assert is_same(made.selection_q, selection_q_of(stopped.spec, stopped.state))
        assert np.array_equal(stopped.state.log_reward[: stopped.trial], rewards[: stopped.trial])
