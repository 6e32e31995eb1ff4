"""What a run is compared with: the preset's own run, or the one before."""

from dataclasses import replace

import numpy as np

from app.live.held import Opened
from app.live.places import LineSeen
from app.live.session import Session
from app.live.status import Status
from app.page import ghost
from app.page.ghost import (
    FORMER_NAME,
    OWN_NAME,
    GhostWatch,
    ghost_of_line,
    ghost_run,
    is_changed_by_hand,
)
from learners.commands import FreezeSelection, Introduce, SetParameter, Undo
from learners.run import Run
from tests.support.schedules import seen, small_run, small_spec, to


def status_of(run: Run, generation: int = 0, opened: Opened | None = None) -> Status:
    """A session that shows a run."""

    idle = Session(small_spec(), "timed", seed=5, speed=100.0, playing=False).status
    return replace(idle, snapshot=replace(seen(run), generation=generation), opened=opened)


def followed(watch: GhostWatch, status: Status) -> ghost.Ghost | None:
    """What stands behind a run once it has been made."""
    watch.follow(status)
    thread = watch._made._thread
    if thread is not None:
        thread.join()
    return watch.follow(status)


def test_nothing_stands_behind_a_run_in_which_nothing_differs() -> None:
    watch = GhostWatch()
    assert followed(watch, status_of(to(small_run(), 120))) is None
    watch.stop()


def test_behind_a_run_that_was_changed_stands_that_of_the_preset_and_the_seed() -> None:
    watch, own = GhostWatch(), to(small_run(), 500)
    run = to(small_run(), 50)
    run.apply(Introduce("avoid", 0))
    found = followed(watch, status_of(run))
    assert found is not None
    assert found.name == OWN_NAME
    np.testing.assert_array_equal(found.trial_curve.reward, seen(own).trial_curve.reward)
    np.testing.assert_array_equal(found.curve.steps, seen(own).curve.steps)
    # It is made once for a run, whatever else is done with that.
    to(run, 80).apply(SetParameter("learner.epsilon", 0.3))
    assert followed(watch, status_of(run)) is found
    watch.stop()


def test_what_was_taken_back_at_once_has_changed_nothing() -> None:
    run = to(small_run(), 50)
    run.apply(FreezeSelection(True))
    assert is_changed_by_hand(run.control.history)
    run.apply(Undo(run.control.history[-1].number))
    assert not is_changed_by_hand(run.control.history)
    run.apply(FreezeSelection(True))
    run.advance(max_steps=1)
    run.apply(Undo(run.control.history[-1].number))
    assert is_changed_by_hand(run.control.history)


def test_behind_a_run_that_was_started_again_stands_the_one_before() -> None:
    watch = GhostWatch()
    first = to(small_run(), 120)
    assert watch.follow(status_of(first, 0)) is None
    found = watch.follow(status_of(small_run(), 1))
    assert found is not None
    assert (found.name, found.hint) == (
        FORMER_NAME,
        "timed, seed 5, as far as it had come: trial 120",
    )
    np.testing.assert_array_equal(found.curve.reward, seen(first).curve.reward)
    # Who goes back to the first has none behind it, and the other's is still there.
    assert watch.follow(status_of(first, 0)) is None
    assert watch.follow(status_of(small_run(), 1)) is found
    # One that hardly began before it was started again does not take the place of that.
    assert watch.follow(status_of(small_run(), 2)) is found
    watch.stop()


def test_behind_a_run_of_an_experiment_stands_none() -> None:
    watch = GhostWatch()
    watch.follow(status_of(to(small_run(), 120), 0))
    opened = Opened("figure: timed, seed 3", 1_000, "3f", same=None)
    assert watch.follow(status_of(small_run(), 1, opened)) is None
    watch.stop()


def test_a_run_that_nobody_waits_for_any_more_is_given_up() -> None:
    asked: list[int] = []

    def is_wanted() -> bool:
        asked.append(1)
        return len(asked) < 3

    spec = small_spec("trials=1000000")
    assert ghost_run(spec, 5, 1_000_000, is_wanted) is None
    assert len(asked) == 3


def test_behind_a_branch_stands_the_line_that_it_left() -> None:
    end = seen(to(small_run(), 120))
    line = LineSeen(0, None, 0, 0, "first run", end.step, end.trial, 0.0, "", is_live=True)
    found = ghost_of_line(line, end)
    assert found.name == "the live run"
    assert found.trial_curve is end.trial_curve
    assert "trial 120" in found.hint
    assert ghost_of_line(replace(line, is_live=False), end).name == "first run"
