"""Runs that go on until a horizon, and what looks at them on their way."""

from itertools import groupby
from typing import Any

import numpy as np
import pytest

from app.documents import experiments
from app.experiments import task
from app.experiments.archive import Arrays, unpacked
from app.experiments.probes import Probe
from app.experiments.task import Finished, Limits, Task, made_run, perform, tasks_of
from app.metrics import area_at, reward_at
from app.metrics.course import COHERENCE_HUNTS, GREEDY_SEED, greedy_of
from learners import measures
from learners.hunts import hunt, policy_of
from learners.kernel.state import digest
from learners.names import MAX_TRIALS
from learners.run import Run
from sim import rng
from sim.world import start_of_trial

SMALL = """
presets: [{preset: standard_q, set: {world.size: 30, world.step_limit: 80}}]
trials: 300
"""


def task_of(**keys: Any) -> Task:
    lines = "".join(f"{key}: {value}\n" for key, value in keys.items())
    ((_, found),) = tasks_of(experiments.parse(SMALL + lines, "small.yaml"))
    return found


def performed(wanted: Task) -> tuple[Finished, Arrays]:
    found = perform(wanted)
    assert found is not None
    assert not found.error
    trials, steps = (found.values[name] for name in ("trials", "steps"))
    return found, unpacked(found.arrays, int(trials or 0), int(steps or 0))


def spec_of(wanted: Task) -> Any:
    return task.RunSpec.model_validate_json(wanted.settings)


@pytest.fixture(scope="module")
def bare() -> Finished:
    """A run without a horizon."""
    return performed(task_of())[0]


def test_a_run_goes_on_until_its_horizon(bare: Finished) -> None:
    n_steps = int(bare.values["steps"] or 0)
    beyond, arrays = performed(task_of(horizon=n_steps + 5_000))
    assert beyond.values["steps"] == n_steps + 5_000
    assert int(beyond.values["trials"] or 0) > 300
    # What is of its preset's trials is what it would be without.
    for name in ("final_reward", "final_greedy", "final_success", "area", "mean_hunt_length"):
        assert beyond.values[name] == bare.values[name]
    reward = measures.rewards(spec_of(task_of()).world, arrays.outcome)
    assert beyond.values["horizon_reward"] == reward_at(reward, arrays.steps, n_steps + 5_000)
    assert beyond.values["horizon_area"] == area_at(reward, arrays.steps, n_steps + 5_000)


def test_a_run_is_not_cut_at_its_horizon(bare: Finished) -> None:
    before, arrays = performed(task_of(horizon=5_000))
    assert before.digest == bare.digest
    reward = measures.rewards(spec_of(task_of()).world, arrays.outcome)
    n_ended = int((np.cumsum(arrays.steps) <= 5_000).sum())
    assert before.values["horizon_reward"] == pytest.approx(reward[:n_ended].mean())
    assert before.values["horizon_reward"] != before.values["final_reward"]


def test_without_a_horizon_nothing_is_measured_at_one(bare: Finished) -> None:
    assert bare.values["horizon_reward"] is bare.values["horizon_greedy"] is None
    assert bare.values["horizon_area"] is None


def test_greedy_reward_is_of_the_run_as_it_was_at_each_moment() -> None:
    found, arrays = performed(task_of(horizon=5_000, greedy_every=120))
    wanted = task_of()
    at_horizon = Run(spec_of(wanted), 0)
    at_horizon.advance(max_steps=5_000, until_trial=MAX_TRIALS)
    assert found.values["horizon_greedy"] == greedy_of(at_horizon).reward
    at_end = Run(spec_of(wanted), 0)
    points = {}
    for trial in (120, 240, 300):
        at_end.advance(until_trial=trial)
        points[trial] = at_end.step, np.float32(greedy_of(at_end, 200).reward)
    assert found.values["final_greedy"] == greedy_of(at_end).reward
    assert found.values["greedy_success"] == greedy_of(at_end).success
    assert found.digest == digest(at_end.state)
    curve = zip(arrays.greedy.trial, arrays.greedy.step, arrays.greedy.reward, strict=True)
    assert {int(trial): (step, reward) for trial, step, reward in curve} == points


def test_coherence_is_of_the_first_greedy_hunts_of_a_run_that_is_over() -> None:
    found, _ = performed(task_of(metrics="[mean_choice, without_progress]"))
    run = Run(spec_of(task_of()), 0)
    run.advance()
    starts = run.world, rng.streams(GREEDY_SEED)[rng.STARTS]
    policy = policy_of(run.spec, run.state)
    n_steps = n_runs = 0
    shares: list[float] = []
    for seed in range(COHERENCE_HUNTS):
        cell, heading = start_of_trial(*starts, seed)
        way = hunt(run.world, policy, int(cell), int(heading), seed)
        n_steps += way.steps
        n_runs += sum(1 for _ in groupby(way.options.tolist()))
        been, again = {int(way.cells[0])}, 0
        for cell in map(int, way.cells[1:]):
            again += cell in been
            been.add(cell)
        shares.append(again / way.steps)
    assert found.values["mean_choice"] == n_steps / n_runs
    assert found.values["without_progress"] == pytest.approx(sum(shares) / len(shares))
    assert found.digest == digest(run.state)


@pytest.mark.parametrize("keys", [{"greedy_every": 0}, {"metrics": "[final_reward]"}])
def test_where_no_greedy_curve_is_asked_for_there_is_none(keys: dict[str, Any]) -> None:
    _, arrays = performed(task_of(**keys))
    assert arrays.greedy.trial.size == 0


def test_a_probe_looks_at_its_trials_and_steps_whatever_the_slices(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    spec = spec_of(task_of())

    def seen() -> list[tuple[int, int]]:
        moments: list[tuple[int, int]] = []

        def look(run: Run) -> None:
            moments.append((run.trial, run.step))

        assert made_run(spec, 3, Limits(30), [Probe(look, [0, 7, 20], [50, 777])]) is not None
        return moments

    found = seen()
    assert len(found) == 5
    assert found[0] == (0, 0)
    assert {step for _, step in found} >= {50, 777}
    assert {trial for trial, _ in found} >= {7, 20}
    monkeypatch.setattr(task, "_SLICE_STEPS", 13)
    assert seen() == found


def test_a_probe_may_look_at_the_end_of_a_run_that_is_over_before_its_moments() -> None:
    spec, seen = spec_of(task_of()), list[int]()

    def look(run: Run) -> None:
        seen.append(run.trial)

    made_run(spec, 3, Limits(20), [Probe(look, [100], or_end=True), Probe(look, [10], or_end=True)])
    assert seen == [10, 20]
