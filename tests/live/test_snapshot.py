"""A snapshot tells the truth about the moment, and nobody changes it any more."""

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from app.documents import presets
from app.live import snapshot
from app.live.snapshot import RECENT_ENDS, RECENT_PATHS, TRAIL_STEPS, Snapshot
from learners import measures
from learners.commands import Explore, Introduce
from learners.kernel.state import tables
from learners.run import Run
from learners.spec import RunSpec
from sim.world import CAPTURE, TIMEOUT, board_xy

STEPS = (0, 1, 2, 119, 120, 121, 122, 299, 300)


def spec_of(*settings: str, preset: str = "hierarchical_2") -> RunSpec:
    """A preset in a small world."""
    return presets.load(preset, ["world.size=40", *settings])


def lonely_run(step_limit: int = 300) -> Run:
    """A run whose trials are cut off: the start is far, and the prey is blind."""
    settings = ["world.vision_radius=0", "world.start_radius=[60, 60]", "learner.epsilon=1"]
    spec = presets.load("standard_q", [*settings, f"world.step_limit={step_limit}"])
    return Run(spec, seed=1)


def take(run: Run) -> Snapshot:
    """The moment a run is at."""
    return snapshot.take(run, "a preset", generation=4)


def arrays_of(value: Any) -> Iterator[np.ndarray]:
    """All arrays in a snapshot, whatever they lie in."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, tuple):
        for part in value:
            yield from arrays_of(part)
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from arrays_of(getattr(value, field.name))


# Tables and numbers


def test_a_snapshot_agrees_with_the_run() -> None:
    run = Run(spec_of(), seed=2)
    run.advance(max_steps=50_001)
    run.apply(Explore("approach", 100, 0.5))
    taken = take(run)
    kept = tables(run.spec, run.state)
    np.testing.assert_array_equal(taken.selection_q, kept["selection_q"])
    np.testing.assert_array_equal(taken.value, kept["selection_q"].max(axis=-1))
    np.testing.assert_array_equal(taken.first_reach, kept["first_reach"])
    np.testing.assert_array_equal(taken.option_visits, kept["visits"].sum(axis=(0, 1, 2)))
    assert taken.option_visits.sum() == taken.step == run.step == 50_001
    assert (taken.preset, taken.generation, taken.seed) == ("a preset", 4, 2)
    assert (taken.trial, taken.present) == (run.trial, ("approach", "circle_clockwise"))
    assert [episode.skill for episode in taken.control.episodes] == ["approach"]
    assert taken.recent == measures.endings(run.state, measures.RECENT_TRIALS)
    assert (taken.value > 0).any()


def test_what_has_not_joined_is_worth_minus_infinity_and_is_never_the_best() -> None:
    run = Run(spec_of(preset="timed"), seed=1)
    run.advance(until_trial=500)
    taken = take(run)
    assert taken.present == ("approach",)
    assert np.isneginf(taken.selection_q[..., 1:]).all()
    np.testing.assert_array_equal(taken.value, taken.selection_q[..., 0])


def test_a_snapshot_never_changes() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(max_steps=20_000)
    taken = take(run)
    before = [array.copy() for array in arrays_of(taken)]
    assert len(before) > 10
    run.advance(max_steps=20_000)
    for then, now in zip(before, arrays_of(taken), strict=True):
        np.testing.assert_array_equal(then, now)


def test_writing_to_a_snapshot_does_not_reach_the_run() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(max_steps=20_000)
    before = [array.copy() for array in run.state]
    taken = take(run)
    for array in arrays_of((taken.value, taken.selection_q, taken.skill_q, taken.visits)):
        array.fill(7)
    for array in (taken.first_reach, taken.trail, taken.option_visits):
        array.fill(7)
    for then, now in zip(before, run.state, strict=True):
        np.testing.assert_array_equal(then, now)


# What changed lately


def test_a_first_snapshot_knows_of_no_change() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(max_steps=20_000)
    assert not take(run).learning_now.any()


def test_changes_since_the_snapshot_before_flash_and_fade() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(max_steps=20_000)
    first = take(run)
    run.advance(max_steps=2_000)
    second = snapshot.take(run, "a preset", 4, first)
    change = np.abs(second.selection_q - first.selection_q).max(axis=-1)
    assert 0 < np.count_nonzero(change) < change.size
    np.testing.assert_array_equal(second.learning_now, change)
    third = snapshot.take(run, "a preset", 4, second)
    np.testing.assert_allclose(third.learning_now, snapshot.FADE * change, rtol=1e-6)


def test_a_skill_that_joins_is_no_change_of_a_value() -> None:
    run = Run(spec_of(preset="timed"), seed=1)
    run.advance(until_trial=2_000)
    first = take(run)
    run.apply(Introduce("avoid", 10))
    assert not snapshot.take(run, "a preset", 4, first).learning_now.any()


# The trail


@pytest.mark.parametrize("steps", STEPS)
def test_a_trail_goes_from_neighbour_to_neighbour_and_ends_at_the_predator(steps: int) -> None:
    run = lonely_run()
    run.advance(max_steps=600 + steps)
    taken = take(run)
    places = np.array([board_xy(taken.world, cell) for cell in taken.trail])
    assert (np.abs(np.diff(places, axis=0)) <= 1).all()
    assert taken.trail[-1] == taken.cell


@pytest.mark.parametrize("steps", STEPS[:-1])
def test_a_trail_begins_at_the_start_of_the_trial_while_that_is_recent(steps: int) -> None:
    run = lonely_run()
    run.advance(until_trial=2)
    start, heading = run.start_of(2)
    run.advance(max_steps=steps)
    taken = take(run)
    assert (taken.trial, taken.trial_step, taken.heading) == (2, steps, heading)
    if steps <= TRAIL_STEPS:
        assert taken.trail[0] == start
        assert len(taken.trail) == steps + 1
    else:
        assert len(taken.trail) == TRAIL_STEPS


def test_a_trail_shows_the_cells_that_the_predator_was_in() -> None:
    run = lonely_run()
    run.advance(max_steps=250)
    cells = []
    for _ in range(TRAIL_STEPS):
        run.advance(max_steps=1)
        cells.append(take(run).cell)
        if take(run).trial_step == 0:
            cells = []
    assert len(set(cells)) > 10
    np.testing.assert_array_equal(take(run).trail[-len(cells) :], cells)


# Ends of trials


def test_before_the_first_trial_has_ended_there_are_no_ends() -> None:
    taken = take(Run(spec_of(), seed=1))
    assert taken.ends == ()
    assert len(taken.curve.steps) == 0
    assert sum(taken.recent) == 0


def test_ends_say_where_and_how_the_last_trials_ended() -> None:
    run = Run(spec_of(), seed=1)
    seen = {}
    for trial in range(2_000, 2_000 + RECENT_ENDS):
        run.advance(until_trial=trial)
        heading = take(run).heading
        caught = measures.endings(run.state).captures
        run.advance(until_trial=trial + 1)
        last = take(run).ends[-1]
        assert (last.trial, last.heading) == (trial, heading)
        assert (measures.endings(run.state).captures > caught) == (last.outcome == CAPTURE)
        if last.outcome == CAPTURE:
            assert last.cell == int(run.world.prey_cell)
        seen[trial] = last
    assert len({end.outcome for end in seen.values()}) > 1
    assert take(run).ends == tuple(seen.values())


def test_a_trial_that_was_cut_off_ended_where_it_stood() -> None:
    run = lonely_run(step_limit=1)
    run.advance(max_steps=1)
    first = take(run).ends[0]
    assert (first.trial, first.outcome) == (0, TIMEOUT)
    start, heading = run.start_of(0)
    gone = np.subtract(board_xy(run.world, first.cell), board_xy(run.world, start))
    assert np.abs(gone).max() <= 1
    assert first.heading == heading


# The curve


def test_windows_of_the_curve_grow_by_1_2_5() -> None:
    assert [snapshot.curve_window(steps) for steps in (0, 250_000, 250_001, 500_000)] == [
        1_000,
        1_000,
        2_000,
        2_000,
    ]
    widths = {snapshot.curve_window(int(steps)) for steps in np.geomspace(1, 9e8, 400)}
    assert sorted(widths) == [k * 10**n for n in range(3, 7) for k in (1, 2, 5)][: len(widths)]
    assert len(widths) >= 11


def test_a_curve_has_between_100_and_250_windows_once_it_is_long() -> None:
    for steps in np.geomspace(250_000, 1e9, 500):
        windows = -(-int(steps) // snapshot.curve_window(int(steps)))
        assert 100 <= windows <= 250


def test_the_curve_of_a_snapshot_is_the_mean_reward_by_step() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(max_steps=300_000)
    curve = take(run).curve
    assert len(curve.steps) <= 250
    assert curve.steps[:2].tolist() == [2_000, 4_000]
    ended = np.cumsum(run.state.log_steps[: run.trial])
    first = measures.rewards(run.spec.world, run.state.log_outcome[: run.trial])[ended <= 2_000]
    assert curve.reward[0] == first.mean()


def test_a_curve_that_is_recent_enough_is_taken_over() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(max_steps=5_000)
    former = take(run)
    run.advance(max_steps=5_000)
    hasty = snapshot.take(run, "a preset", 4, former, new_curve=False)
    assert hasty.curve is former.curve
    assert hasty.step == former.step + 5_000
    assert len(snapshot.take(run, "a preset", 4, former).curve.steps) > len(former.curve.steps)


# Paths


def test_paths_are_the_ways_of_the_last_trials() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(until_trial=2_000)
    walked = []
    for trial in range(2_000, 2_003):
        cells = [run.start_of(trial)[0]]
        while run.trial == trial:
            run.advance(max_steps=1)
            cells.append(int(run.state.trail[run.step % len(run.state.trail)]))
        walked.append(cells)
    run.advance(max_steps=1)
    taken = take(run)
    assert [path.cells.tolist() for path in taken.paths[-3:]] == walked
    for path, end in zip(taken.paths[-3:], taken.ends[-3:], strict=True):
        assert (path.heading, path.outcome, path.cells[-1]) == (end.heading, end.outcome, end.cell)


def test_only_whole_paths_are_shown_when_trials_are_long() -> None:
    run = lonely_run(step_limit=1_500)
    run.advance(max_steps=60_000)
    taken = take(run)
    assert 1 <= len(taken.paths) < RECENT_PATHS
    for path in taken.paths:
        places = np.array([board_xy(taken.world, cell) for cell in path.cells])
        assert (np.abs(np.diff(places, axis=0)) <= 1).all()
    for path, trial in zip(reversed(taken.paths), range(run.trial - 1, 0, -1), strict=False):
        assert path.cells[0] == run.start_of(trial)[0]
        assert len(path.cells) == run.state.log_steps[trial] + 1


def test_the_curve_over_trials_is_the_mean_reward_of_so_many_in_a_row() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(until_trial=1_200)
    curve = take(run).trial_curve
    ended = np.cumsum(run.state.log_steps[:1_200])
    reward = measures.rewards(run.spec.world, run.state.log_outcome[:1_200])
    assert curve.steps.tolist() == ended[[499, 999]].tolist()
    assert curve.reward.tolist() == [reward[:500].mean(), reward[500:1_000].mean()]


def test_windows_of_trials_hold_500_of_them_until_there_are_very_many() -> None:
    trials = (0, 125_000, 125_001, 250_001, 500_001, 1_250_001)
    widths = [snapshot.curve_window_trials(each) for each in trials]
    assert widths == [500, 500, 1_000, 2_000, 5_000, 10_000]


def test_the_recent_reward_is_that_of_the_last_500_trials() -> None:
    run = Run(spec_of(), seed=1)
    assert np.isnan(take(run).recent_reward)
    run.advance(until_trial=700)
    assert take(run).recent_reward == run.state.log_reward[200:700].mean()
