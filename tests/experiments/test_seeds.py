"""Many seeds of one preset: the same results however they are run."""

import csv
import errno
import json
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.analysis.estimates import PHASE_STEPS, PHASES
from app.documents import presets
from app.documents.experiments import parse
from app.experiments import task
from app.experiments.crews import Threads
from app.experiments.runner import Progress, run_experiment
from app.experiments.seeds import SeedFailedError, curves_csv, run_seeds, summary
from app.experiments.store import Folder
from app.results import thesis
from app.results.read import Reader, read_folder, widths_of
from learners import measures
from learners.kernel.state import digest
from learners.run import Run
from learners.spec import RunSpec

SEEDS = (5, 0, 12, 3, 8)


@pytest.fixture(scope="module")
def spec() -> RunSpec:
    return presets.load("hierarchical_3", ("world.size=30", "world.step_limit=80", "trials=150"))


def without_time(text: str) -> dict:
    document = json.loads(text)
    runs = [{key: run[key] for key in run if key != "seconds"} for run in document["runs"]]
    return {**document, "runs": runs}


# --- Running -------------------------------------------------------------------------------------


def test_a_result_says_what_the_run_says(spec: RunSpec) -> None:
    (result,) = run_seeds(spec, [4], Threads(1))
    record, values = result.record, result.record.values
    run = Run(spec, 4)
    run.advance()
    assert (record.seed, record.trials, record.steps) == (4, 150, run.step)
    endings = values["captures"], values["flights"], values["timeouts"]
    assert endings == measures.endings(run.state)
    assert sum(endings) == 150
    assert values["final_reward"] == pytest.approx((100 * endings[0] - 50 * endings[1]) / 150)
    assert record.digest == digest(run.state)
    assert record.seconds > 0
    for found, known in zip(result.curve, measures.curve(run.state), strict=True):
        np.testing.assert_array_equal(found, known)


def test_windows_are_of_a_hundred_thousand_and_of_half_a_million_steps() -> None:
    spec = presets.load("standard_q", ["trials=3500"])
    (result,) = run_seeds(spec, [1], Threads(1))
    assert result.record.steps > 1_000_000
    assert result.curve.steps[:3].tolist() == [100_000, 200_000, 300_000]
    assert result.curve.steps[-1] == result.record.steps
    assert result.phases.size == result.record.steps // 500_000


def test_phases_are_those_that_a_report_has(tmp_path: Path) -> None:
    """Of a phase that a run ended in, neither says anything."""
    experiment = parse(
        "presets: [{preset: standard_q, label: q}]\ntrials: 2500\n", "a.yaml", None, 1
    )
    with Folder(tmp_path / "a", experiment, False, False) as folder:
        run_experiment(experiment, folder, Threads(1))
    rows = read_folder(tmp_path / "a").rows
    (trace,) = Reader(widths_of(rows), thesis.quantities_of).traces(rows)
    (result,) = run_seeds(presets.load("standard_q", ["trials=2500"]), [0], Threads(1))
    assert result.record.steps % PHASE_STEPS
    found = {
        name: result.phases[place] for name, place in PHASES.items() if place < result.phases.size
    }
    assert found == pytest.approx({k: v for k, v in trace.quantities.items() if k in PHASES})


@pytest.mark.parametrize("workers", [2, 8])
def test_the_number_of_workers_makes_no_difference(spec: RunSpec, workers: int) -> None:
    alone = summary("mine", spec, run_seeds(spec, SEEDS, Threads(1)))
    together = summary("mine", spec, run_seeds(spec, SEEDS, Threads(workers)))
    assert without_time(together) == without_time(alone)
    runs = without_time(together)["runs"]
    assert [run["seed"] for run in runs] == list(SEEDS)
    assert len({run["digest"] for run in runs}) == len(SEEDS)


def test_workers_work_at_the_same_time(spec: RunSpec, monkeypatch: pytest.MonkeyPatch) -> None:
    # Each run waits for the other to end as well, so one worker alone would never come through.
    both, measured = threading.Barrier(2, timeout=60), task.measured

    def wait_for_the_other(*of: Any) -> Any:
        both.wait()
        return measured(*of)

    monkeypatch.setattr(task, "measured", wait_for_the_other)
    results = run_seeds(spec, [1, 2], Threads(2))
    assert [result.record.seed for result in results] == [1, 2]


def test_a_run_that_is_over_is_not_kept(spec: RunSpec, monkeypatch: pytest.MonkeyPatch) -> None:
    alive = 0
    most = 0

    class CountedRun(Run):
        def __init__(self, spec: RunSpec, seed: int) -> None:
            nonlocal alive, most
            alive += 1
            most = max(most, alive)
            super().__init__(spec, seed)

        def __del__(self) -> None:
            nonlocal alive
            alive -= 1

    monkeypatch.setattr(task, "Run", CountedRun)
    assert len(run_seeds(spec, range(12), Threads(1))) == 12
    assert most <= 2, "the next one may be made before the last one is let go"


def test_progress_counts_runs_and_steps(spec: RunSpec) -> None:
    seen: list[Progress] = []
    results = run_seeds(spec, SEEDS, Threads(2), on_progress=seen.append)
    last = seen[-1]
    steps = sum(result.record.steps for result in results)
    assert (last.total, last.done, last.steps, last.share) == (5, 5, steps, 1.0)
    assert [one.done for one in seen] == sorted(one.done for one in seen)
    assert [one.share for one in seen] == sorted(one.share for one in seen)


class Unlucky(Run):
    """A run that fails for one seed."""

    def advance(self, *args: Any, **kwargs: Any) -> int:
        if self.seed == 12:
            raise ZeroDivisionError("no luck")
        return super().advance(*args, **kwargs)


@pytest.mark.parametrize("workers", [1, 4])
def test_a_run_that_fails_is_named_by_its_seed(
    spec: RunSpec, workers: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(task, "Run", Unlucky)
    with pytest.raises(SeedFailedError, match=r"run of seed 12 failed: ZeroDivisionError: no luck"):
        run_seeds(spec, SEEDS, Threads(workers))


def test_a_failure_stops_the_others(spec: RunSpec, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[int] = []

    class Counted(Unlucky):
        def __init__(self, spec: RunSpec, seed: int) -> None:
            made.append(seed)
            super().__init__(spec, seed)

    monkeypatch.setattr(task, "Run", Counted)
    with pytest.raises(SeedFailedError, match="seed 12"):
        run_seeds(spec, range(12, 2_000), Threads(2))
    assert len(made) < 1_000


def test_a_failure_while_a_run_is_put_by_goes_to_who_asked(spec: RunSpec) -> None:
    def full(seed: int, tables: bytes) -> None:
        if seed == 3:
            raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(OSError, match="No space left"):
        run_seeds(spec, SEEDS, Threads(2), on_tables=full)


def test_an_interrupt_stops_the_workers() -> None:
    endless = presets.load("standard_q", ["trials=2000000"])
    made: list[Progress] = []

    def interrupt(progress: Progress) -> None:
        made.append(progress)
        raise KeyboardInterrupt

    before = set(threading.enumerate())
    with pytest.raises(KeyboardInterrupt):
        run_seeds(endless, range(100), Threads(2), on_progress=interrupt)
    assert len(made) == 1
    # Those of a lab that other tests share come and go.
    begun = set(threading.enumerate()) - before
    assert not [thread for thread in begun if thread.name.startswith("run")]


# --- Plain data ----------------------------------------------------------------------------------


def test_a_summary_has_the_promised_shape(spec: RunSpec) -> None:
    document = json.loads(summary("mine", spec, run_seeds(spec, [1, 2], Threads(2))))
    assert list(document) == ["preset", "settings", "runs"]
    assert document["preset"] == "mine"
    assert document["settings"]["world"]["size"] == 30
    assert document["settings"]["learner"]["epsilon"] == 0.1
    assert document["settings"]["trials"] == 150
    assert RunSpec.model_validate(document["settings"]) == spec
    for run, seed in zip(document["runs"], (1, 2), strict=True):
        assert list(run) == [
            "seed",
            "trials",
            "steps",
            "seconds",
            "captures",
            "flights",
            "timeouts",
            "mean_reward_last_2000",
            "curve",
            "digest",
        ]
        assert run["seed"] == seed
        assert list(run["curve"]) == ["steps", "reward"]
        assert len(run["curve"]["steps"]) == len(run["curve"]["reward"]) > 0
        assert run["curve"]["steps"][-1] == run["steps"]
        assert len(run["digest"]) == 64


def test_a_window_without_a_trial_has_no_reward() -> None:
    # Trials longer than a window leave windows in which none ends.
    settings = ["world.step_limit=250000", "world.vision_radius=0", "trials=3", "world.size=400"]
    spec = presets.load("standard_q", [*settings, "learner.alpha=0"])
    results = run_seeds(spec, [2], Threads(1))
    assert np.isnan(results[0].curve.reward).any()
    document = json.loads(summary("long", spec, results))
    rewards = document["runs"][0]["curve"]["reward"]
    assert [reward is None for reward in rewards] == np.isnan(results[0].curve.reward).tolist()
    rows = list(csv.reader(curves_csv(results).splitlines()))
    assert [row[2] == "" for row in rows[1:]] == np.isnan(results[0].curve.reward).tolist()
