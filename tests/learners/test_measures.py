"""What a run's log and tables say stays true, whatever is changed on the way."""

import numpy as np
import pytest

from app.documents import presets
from learners import measures
from learners.commands import SetParameter
from learners.kernel.state import NO_OPTION, OPTION
from learners.run import Run
from sim.world import CAPTURE, FLIGHT

GAMMA = 0.9


def small_run() -> Run:
    settings = ["world.size=30", "world.n_directions=16", "world.n_distances=6"]
    return Run(presets.load("standard_q", settings), seed=3)


# --- Rewards -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "value", "outcome"),
    [("world.flight_reward", -200.0, FLIGHT), ("world.capture_reward", 7.5, CAPTURE)],
)
def test_a_trial_keeps_the_reward_with_which_it_ended(key: str, value: float, outcome: int) -> None:
    run = small_run()
    run.advance(max_steps=20_000)
    changed_at = run.trial
    before = measures.curve(run.state, 1_000)
    mean = measures.final_mean(run.state.log_reward[:changed_at])
    run.apply(SetParameter(key, value))
    assert measures.final_mean(run.state.log_reward[:changed_at]) == mean
    run.advance(max_steps=20_000)

    after = measures.curve(run.state, 1_000)
    np.testing.assert_array_equal(after.reward[: len(before.reward) - 1], before.reward[:-1])
    outcomes = run.state.log_outcome[changed_at : run.trial]
    new = measures.rewards(run.spec.world, outcomes)
    assert (outcomes == outcome).sum() > 10
    np.testing.assert_array_equal(run.state.log_reward[changed_at : run.trial], new)


def test_the_mean_of_very_many_rewards_is_exact() -> None:
    run = small_run()
    run.advance(until_trial=2_000)
    run.state.log_reward[:2_000] = np.float32(0.1)
    mean = measures.final_mean(run.state.log_reward[:2_000])
    assert mean == pytest.approx(np.float32(0.1), rel=1e-12)


# --- Switches ------------------------------------------------------------------------------------


def switches_per_step(run: Run) -> float:
    """Of the trials that have ended."""
    done = run.trial
    return measures.switches_per_step(run.state.log_steps[:done], run.state.log_switches[:done])


def stepwise_switches(run: Run, until_trial: int) -> tuple[int, int]:
    """Steps that have one before them in their trial, and those of them with another option."""
    steps = switches = 0
    while run.trial < until_trial:
        trial, previous = run.trial, run.state.place[OPTION]
        before = run.state.visits.copy()
        run.advance(max_steps=1, until_trial=until_trial)
        (taken,) = np.flatnonzero(run.state.visits != before) % 9
        if previous != NO_OPTION:
            steps += 1
            switches += bool(taken != previous)
        assert run.trial - trial in (0, 1)
    return steps, switches


def test_a_switch_is_a_step_with_another_option_than_the_step_before_it() -> None:
    run = small_run()
    steps, switches = stepwise_switches(run, 30)
    assert switches > 100
    assert switches_per_step(run) == switches / steps


def test_a_learner_with_one_skill_never_switches() -> None:
    settings = ["world.size=30", "learner.options=[approach]", "schedule={skills: {}}"]
    run = Run(presets.load("hierarchical_3", settings), seed=3)
    run.advance(until_trial=300)
    assert switches_per_step(run) == 0


def test_without_a_second_step_there_is_no_switch() -> None:
    run = Run(presets.load("standard_q", ["world.step_limit=1"]), seed=3)
    assert switches_per_step(run) == 0
    run.advance(until_trial=10)
    assert switches_per_step(run) == 0


# --- Equivalent distance -------------------------------------------------------------------------


def test_a_choice_that_is_made_again_goes_on_and_a_hunt_ends_it() -> None:
    straight = np.arange(5), np.array([3, 3, 3, 3])
    bent = np.arange(7), np.array([3, 3, 1, 3, 3, 3])
    assert measures.coherence([straight, bent]).mean_choice == 10 / 4


def test_steps_into_cells_of_the_same_hunt_are_without_progress() -> None:
    onwards = np.array([7, 8, 9])
    stays_then_goes_back = np.array([7, 7, 8, 7, 9])
    option = np.zeros(2, np.uint8), np.zeros(4, np.uint8)
    found = measures.coherence([(onwards, option[0]), (stays_then_goes_back, option[1])])
    assert found.without_progress == (0 / 2 + 2 / 4) / 2


def test_without_hunts_nothing_is_known_of_coherence() -> None:
    assert np.isnan(measures.coherence([])).all()


def test_the_worth_of_a_state_is_turned_into_its_steps_from_capture() -> None:
    steps = np.array([[0.0, 1.0, 40.5], [400.0, -3.0, 7.0]])
    distance = measures.equivalent_distance(100 * GAMMA**steps, 100, GAMMA)
    np.testing.assert_allclose(distance, steps, atol=1e-9)


def test_a_value_not_above_0_has_no_distance() -> None:
    value = np.array([0.0, -1.0, np.nan, -np.inf], np.float32)
    assert np.isnan(measures.equivalent_distance(value, 100, GAMMA)).all()


@pytest.mark.parametrize("capture_reward", [0.0, -5.0])
def test_there_is_no_distance_to_a_capture_that_is_worth_nothing(capture_reward: float) -> None:
    assert np.isnan(measures.equivalent_distance(np.ones(3), capture_reward, GAMMA)).all()


def test_without_a_future_all_value_is_at_capture() -> None:
    assert not measures.equivalent_distance(np.array([1.0, 100.0, 200.0]), 100, 0.0).any()


def test_windows_of_trials_end_where_their_last_trial_did() -> None:
    reward = np.array([100.0, -50.0, 0.0, 100.0, 100.0])
    steps = np.array([10, 20, 30, 40, 50], np.int32)
    steps_at, mean = measures.curve_over_trials_of(reward, steps, 2)
    assert steps_at.tolist() == [30, 100]
    assert mean.tolist() == [25.0, 50.0]


def test_of_fewer_trials_than_a_window_there_is_one_point() -> None:
    steps_at, mean = measures.curve_over_trials_of(np.array([100.0, -50.0]), np.array([7, 5]), 500)
    assert (steps_at.tolist(), mean.tolist()) == ([12], [25.0])
    empty = measures.curve_over_trials_of(np.zeros(0), np.zeros(0, np.int32), 500)
    assert (empty.steps.size, empty.reward.size) == (0, 0)


# --- Passages ------------------------------------------------------------------------------------

STEPS = np.full(20_000, 10)


def rewards(*parts: tuple[int, float]) -> np.ndarray:
    """Rewards of so many trials each."""
    return np.concatenate([np.full(n, reward) for n, reward in parts])


def test_a_passage_is_where_the_mean_of_the_last_thousand_trials_gets_to_a_level() -> None:
    reward = rewards((3_000, 0.0), (9_000, 100.0))
    # Half of a thousand trials are at 100 after 500 of them.
    assert measures.first_passage(reward, STEPS, 50) == 3_500 * 10
    assert measures.kept_passage(reward, STEPS, 50) == 3_500 * 10
    assert measures.first_passage(reward, STEPS, 100.5) is None
    assert measures.first_passage(reward[:999], STEPS, -50) is None


def test_a_spike_is_a_first_passage_and_none_that_is_kept() -> None:
    reward = rewards((2_000, 0.0), (800, 100.0), (2_000, 0.0), (7_000, 100.0))
    assert measures.first_passage(reward, STEPS, 70) == 2_700 * 10
    assert measures.kept_passage(reward, STEPS, 70) == (4_800 + 700) * 10


def test_a_passage_that_few_trials_follow_is_not_known_to_be_kept() -> None:
    reward = rewards((1_000, 0.0), (6_000, 100.0))
    assert measures.kept_passage(reward[:6_499], STEPS, 50) is None
    assert measures.kept_passage(reward[:6_500], STEPS, 50) == 1_500 * 10


@pytest.mark.parametrize(("low", "at"), [(66.0, 1_000), (64.0, 3_000)])
def test_a_kept_passage_may_fall_below_its_level_by_five(low: float, at: int) -> None:
    reward = rewards((1_000, 70.0), (1_000, low), (9_000, 70.0))
    assert measures.kept_passage(reward, STEPS, 70) == at * 10


def test_so_many_trials_have_ended_by_a_step() -> None:
    steps = np.array([10, 5, 20])
    assert [measures.ended_by(steps, step) for step in (9, 10, 15, 34, 35, 99)] == [
        0,
        1,
        2,
        2,
        3,
        3,
    ]


# --- Trials and steps ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("trials", "n_moments"), [(0, 1), (1, 2), (400, 401), (401, 202), (1_300, 261)]
)
def test_steps_are_told_at_the_ends_of_trials_that_are_equally_far_apart(
    trials: int, n_moments: int
) -> None:
    run = small_run()
    run.advance(until_trial=trials)
    found = measures.progress(run.state)
    made = np.concatenate([[0], np.cumsum(run.state.log_steps[:trials])])
    assert found.trials.size == n_moments
    assert found.trials[-1] == trials
    np.testing.assert_array_equal(found.steps, made[found.trials])
    # So that windows of trials end at one of them.
    ends = measures.curve_over_trials(run.state).steps
    assert set(ends.tolist()) <= set(found.steps.tolist())
