"""The greedy reward beside a run that goes on: when it is measured, of what, and whose it is."""

from collections.abc import Iterator
from dataclasses import replace

import pytest

from app.documents import presets
from app.live import snapshot
from app.live.held import Opened
from app.live.places import LineSeen
from app.live.session import Session
from app.live.status import Status
from app.metrics.course import GREEDY_HUNTS, GreedyCurve, greedy_of
from app.page import greedy
from app.page.greedy import EVERY_TRIALS, GreedyWatch
from learners.run import Run
from learners.spec import RunSpec

EVERY = 20
"""Trials from one point to the next, in these tests."""


@pytest.fixture(scope="module")
def spec() -> RunSpec:
    return presets.load("timed", ["world.size=30", "world.step_limit=60", "trials=100"])


@pytest.fixture
def watch(monkeypatch: pytest.MonkeyPatch) -> Iterator[GreedyWatch]:
    monkeypatch.setattr(greedy, "EVERY_TRIALS", EVERY)
    monkeypatch.setattr(greedy, "_REST_RATIO", 0.0)
    watch = GreedyWatch()
    yield watch
    watch.stop()


def status_of(run: Run, generation: int = 0, **parts: object) -> Status:
    """A session at the moment that a run is at."""
    idle = Session(run.spec, "timed", seed=1, speed=100.0, playing=True).status
    taken = snapshot.take(run, "timed", generation)
    return replace(idle, snapshot=taken, finished=run.trial >= run.spec.trials, **parts)


def followed(watch: GreedyWatch, status: Status) -> GreedyCurve:
    """The curve once all that is to be measured at a moment has been."""
    watch.follow(status)
    thread = watch._measured._thread
    if thread is not None:
        thread.join()
    return watch.follow(status)


def points(curve: GreedyCurve) -> list[tuple[int, int]]:
    return list(zip(curve.trial.tolist(), curve.step.tolist(), strict=True))


def test_points_are_two_thousand_trials_apart() -> None:
    assert (EVERY_TRIALS, GREEDY_HUNTS) == (2_000, 2_000)


def test_a_run_is_measured_where_it_was_caught_and_as_an_experiment_measures_it(
    watch: GreedyWatch, spec: RunSpec
) -> None:
    run = Run(spec, seed=1)
    expected = []
    for trial in (0, 19, 23, 39, 41, 87):
        run.advance(until_trial=trial)
        curve = followed(watch, status_of(run))
        if trial in (23, 41, 87):
            # Of a fast learner many moments are missed, and the points are where it was seen.
            expected.append((trial, run.step))
            assert curve.reward[-1] == pytest.approx(greedy_of(run).reward, abs=1e-4)
        assert points(curve) == expected


def test_the_end_of_a_run_is_measured_too(watch: GreedyWatch, spec: RunSpec) -> None:
    run = Run(spec, seed=1)
    run.advance(until_trial=95)
    followed(watch, status_of(run))
    run.advance()
    status = status_of(run)
    assert [trial for trial, _ in points(followed(watch, status))] == [95, 100]
    assert followed(watch, status) is followed(watch, status)


def test_the_end_of_a_run_that_was_made_again_is_measured(
    watch: GreedyWatch, spec: RunSpec
) -> None:
    run = Run(spec, seed=1)
    run.advance(max_steps=100)
    on_the_way = Opened("figure: timed, seed 1", 100, "0" * 64, same=None)
    assert not points(followed(watch, status_of(run, opened=on_the_way)))
    there = replace(on_the_way, same=True)
    assert points(followed(watch, status_of(run, opened=there))) == [(run.trial, 100)]


def test_each_run_has_a_curve_of_its_own_that_is_there_again_when_one_goes_back(
    watch: GreedyWatch, spec: RunSpec
) -> None:
    first, other = Run(spec, seed=1), Run(spec, seed=2)
    first.advance(until_trial=30)
    other.advance(until_trial=50)
    mine = followed(watch, status_of(first, generation=0))
    opened = followed(watch, status_of(other, generation=1))
    assert points(opened) == [(50, other.step)]
    assert watch.follow(status_of(first, generation=0)) is mine
    # Of another that begins there is nothing yet.
    assert not points(watch.follow(status_of(Run(spec, seed=3), generation=2)))


def test_what_is_measured_of_one_run_is_not_shown_of_the_next(
    watch: GreedyWatch, spec: RunSpec
) -> None:
    run = Run(spec, seed=1)
    run.advance(until_trial=30)
    watch.follow(status_of(run, generation=0))
    again = status_of(Run(spec, seed=1), generation=1)
    assert not points(followed(watch, again))


def test_only_so_many_runs_are_remembered(
    watch: GreedyWatch, spec: RunSpec, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(greedy, "_MOST_RUNS", 2)
    run = Run(spec, seed=1)
    run.advance(until_trial=30)
    status = status_of(run)
    for generation in range(3):
        followed(watch, replace(status, snapshot=replace(status.snapshot, generation=generation)))
    assert list(watch._curves) == [1, 2]


def test_of_a_moment_and_of_a_branch_what_had_been_measured_by_then_is_known(
    watch: GreedyWatch, spec: RunSpec
) -> None:
    run = Run(spec, 1)
    for trial in (EVERY, 2 * EVERY, 3 * EVERY):
        run.advance(until_trial=trial)
        whole = followed(watch, status_of(run))
    now = snapshot.take(run, "timed", 0)
    assert watch.until(now, ()) is whole
    second = int(whole.step[1])
    assert points(watch.until(replace(now, step=second), ())) == points(whole)[:2]
    assert points(watch.until(replace(now, step=second - 1), ())) == points(whole)[:1]

    def line(number: int, parent: int | None, fork: int) -> LineSeen:
        return LineSeen(number, parent, fork, 0, "", now.step, now.trial, 0.0, "", is_live=False)

    lines = (line(0, None, 0), line(1, 0, second), line(2, 1, second - 1))
    assert points(watch.until(replace(now, generation=1), lines)) == points(whole)[:2]
    assert points(watch.until(replace(now, generation=2), lines)) == points(whole)[:1]
    assert points(watch.until(replace(now, generation=9), lines)) == []
    # Once it is live, what is measured of it comes after what it has of the line that it left.
    run.advance(until_trial=4 * EVERY)
    own = followed(watch, status_of(run, generation=1))
    both = watch.until(snapshot.take(run, "timed", 1), lines)
    assert points(both) == points(whole)[:2] + points(own)
