"""Many seeds of one preset: the same results however they are run, and files that are whole."""

import csv
import errno
import json
import os
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.analysis.estimates import PHASE_STEPS, PHASES
from app.documents import presets
from app.documents.experiments import parse
from app.experiments import headless, task
from app.experiments.headless import (
    Output,
    OutputError,
    Progress,
    SeedFailedError,
    run_seeds,
    summary,
)
from app.experiments.runner import Threads, run_experiment
from app.experiments.store import Folder
from app.results import thesis
from app.results.read import Reader, read_folder, widths_of
from learners import measures
from learners.kernel.state import digest, tables
from learners.run import Run
from learners.spec import RunSpec

SEEDS = (5, 0, 12, 3, 8)


@pytest.fixture(scope="module")
def spec() -> RunSpec:
    settings = ("world.size=30", "world.step_limit=80", "trials=150")
    return presets.load("hierarchical_3", settings)


def without_time(document: dict) -> dict:
    runs = [{key: run[key] for key in run if key != "seconds"} for run in document["runs"]]
    return {**document, "runs": runs}


# --- Running -------------------------------------------------------------------------------------


def test_a_result_says_what_the_run_says(spec: RunSpec) -> None:
    (result,) = run_seeds(spec, [4], 1)
    run = Run(spec, 4)
    run.advance()
    assert (result.seed, result.trials, result.steps) == (4, 150, run.step)
    assert (result.captures, result.flights, result.timeouts) == measures.endings(run.state)
    assert result.captures + result.flights + result.timeouts == 150
    assert result.mean_reward_last_2000 == pytest.approx(
        (100 * result.captures - 50 * result.flights) / 150
    )
    assert result.digest == digest(run.state)
    assert result.seconds > 0


def test_windows_are_of_a_hundred_thousand_and_of_half_a_million_steps() -> None:
    spec = presets.load("standard_q", ["trials=3500"])
    (result,) = run_seeds(spec, [1], 1)
    assert result.steps > 1_000_000
    assert result.curve.steps[:3].tolist() == [100_000, 200_000, 300_000]
    assert result.curve.steps[-1] == result.steps
    assert result.phases.size == result.steps // 500_000


def test_phases_are_those_that_a_report_has(tmp_path: Path) -> None:
    """Of a phase that a run ended in, neither says anything."""
    experiment = parse(
        "presets: [{preset: standard_q, label: q}]\ntrials: 2500\n", "a.yaml", None, 1
    )
    with Folder(tmp_path / "a", experiment, False, False) as folder:
        run_experiment(experiment, folder, Threads(1))
    rows = read_folder(tmp_path / "a").rows
    (trace,) = Reader(widths_of(rows), thesis.quantities_of).traces(rows)
    (result,) = run_seeds(presets.load("standard_q", ["trials=2500"]), [0], 1)
    assert result.steps % PHASE_STEPS
    found = {
        name: result.phases[place] for name, place in PHASES.items() if place < result.phases.size
    }
    assert found == pytest.approx({k: v for k, v in trace.quantities.items() if k in PHASES})


@pytest.mark.parametrize("workers", [2, 8])
def test_the_number_of_workers_makes_no_difference(spec: RunSpec, workers: int) -> None:
    alone = summary("mine", spec, run_seeds(spec, SEEDS, 1))
    together = summary("mine", spec, run_seeds(spec, SEEDS, workers))
    assert without_time(together) == without_time(alone)
    assert [run["seed"] for run in together["runs"]] == list(SEEDS)
    assert len({run["digest"] for run in together["runs"]}) == len(SEEDS)


def test_workers_work_at_the_same_time(spec: RunSpec) -> None:
    # Each run waits for the other to end as well, so one worker alone would never come through.
    both = threading.Barrier(2, timeout=60)
    results = run_seeds(spec, [1, 2], 2, on_finished=lambda _: both.wait())
    assert [result.seed for result in results] == [1, 2]


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
    assert len(run_seeds(spec, range(12), 1)) == 12
    assert most <= 2, "the next one may be made before the last one is let go"


def test_progress_counts_runs_trials_and_steps(spec: RunSpec) -> None:
    seen: list[Progress] = []
    results = run_seeds(spec, SEEDS, 2, on_progress=seen.append)
    assert seen[-1] == (5, 5 * 150, sum(result.steps for result in results))
    assert seen == sorted(seen)


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
        run_seeds(spec, SEEDS, workers)


def test_a_failure_while_a_run_is_put_by_is_named_too(spec: RunSpec) -> None:
    def full(run: Run) -> None:
        if run.seed == 3:
            raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(SeedFailedError, match=r"seed 3 failed: OSError: .*No space left"):
        run_seeds(spec, SEEDS, 2, on_finished=full)


def test_an_interrupt_stops_the_workers() -> None:
    endless = presets.load("standard_q", ["trials=2000000"])
    made: list[Progress] = []

    def interrupt(progress: Progress) -> None:
        made.append(progress)
        raise KeyboardInterrupt

    before = set(threading.enumerate())
    with pytest.raises(KeyboardInterrupt):
        run_seeds(endless, range(100), 2, on_progress=interrupt)
    assert len(made) == 1
    assert not set(threading.enumerate()) - before


# --- Plain data ----------------------------------------------------------------------------------


def test_a_summary_has_the_promised_shape(spec: RunSpec) -> None:
    document = json.loads(headless.as_json(summary("mine", spec, run_seeds(spec, [1, 2], 2))))
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


def test_a_window_without_a_trial_has_no_reward_in_json(tmp_path: Path) -> None:
    # Trials longer than a window leave windows in which none ends.
    settings = ["world.step_limit=250000", "world.vision_radius=0", "trials=3", "world.size=400"]
    spec = presets.load("standard_q", [*settings, "learner.alpha=0"])
    results = run_seeds(spec, [2], 1)
    assert np.isnan(results[0].curve.reward).any()
    document = summary("long", spec, results)
    rewards = json.loads(headless.as_json(document))["runs"][0]["curve"]["reward"]
    assert [reward is None for reward in rewards] == np.isnan(results[0].curve.reward).tolist()

    with Output(tmp_path, "long", [2], overwrite=False) as output:
        output.save_tables(Run(spec, 2))
        output.commit(document, results)
    rows = list(csv.reader((tmp_path / "long.csv").open(encoding="utf-8")))
    assert [row[2] == "" for row in rows[1:]] == np.isnan(results[0].curve.reward).tolist()


# --- Files ---------------------------------------------------------------------------------------


def write(spec: RunSpec, folder: Path, seeds: Sequence[int], overwrite: bool = False) -> dict:
    with Output(folder, "mine", seeds, overwrite) as output:
        results = run_seeds(spec, seeds, 2, on_finished=output.save_tables)
        document = summary("mine", spec, results)
        output.commit(document, results)
    return document


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


RESULTS = ["mine-seed3.npz", "mine-seed7.npz", "mine.csv", "mine.json"]


def test_results_are_written(spec: RunSpec, tmp_path: Path) -> None:
    folder = tmp_path / "with blanks" / "ünd Zeichen"
    document = write(spec, folder, [7, 3])
    assert names(folder) == RESULTS
    assert json.loads((folder / "mine.json").read_text(encoding="utf-8")) == document

    rows = list(csv.reader((folder / "mine.csv").open(encoding="utf-8", newline="")))
    assert rows[0] == ["seed", "steps", "reward"]
    expected = [
        [run["seed"], steps, reward]
        for run in document["runs"]
        for steps, reward in zip(run["curve"]["steps"], run["curve"]["reward"], strict=True)
    ]
    assert [[int(row[0]), int(row[1]), float(row[2])] for row in rows[1:]] == expected

    for seed in (7, 3):
        run = Run(spec, seed)
        run.advance()
        with np.load(folder / f"mine-seed{seed}.npz", allow_pickle=False) as kept:
            known = tables(spec, run.state)
            assert set(kept.files) == set(known)
            for name, table in known.items():
                np.testing.assert_array_equal(kept[name], table)


def test_results_are_not_overwritten_unless_told_to(spec: RunSpec, tmp_path: Path) -> None:
    write(spec, tmp_path, [3, 7])
    before = {name: (tmp_path / name).read_bytes() for name in RESULTS}
    for seeds in ([3, 7], [9]):
        with pytest.raises(OutputError, match="has results of that name already: mine"):
            Output(tmp_path, "mine", seeds, overwrite=False)
    assert {name: (tmp_path / name).read_bytes() for name in names(tmp_path)} == before

    write(presets.load("hierarchical_2", ["trials=20"]), tmp_path, [3, 7], overwrite=True)
    assert names(tmp_path) == RESULTS
    assert all((tmp_path / name).read_bytes() != before[name] for name in RESULTS)


def test_other_files_are_let_be(spec: RunSpec, tmp_path: Path) -> None:
    (tmp_path / "theirs.json").write_text("theirs", encoding="utf-8")
    write(spec, tmp_path, [3, 7])
    assert names(tmp_path) == [*RESULTS, "theirs.json"]
    assert (tmp_path / "theirs.json").read_text(encoding="utf-8") == "theirs"


def fail_to_write(output: Output, spec: RunSpec) -> None:
    output.save_tables(Run(spec, 3))
    assert output.files[0].parent.is_dir()
    raise KeyboardInterrupt


def test_what_was_interrupted_leaves_nothing(spec: RunSpec, tmp_path: Path) -> None:
    folder = tmp_path / "new" / "folder"
    with pytest.raises(KeyboardInterrupt), Output(folder, "mine", [3], False) as output:
        fail_to_write(output, spec)
    assert names(tmp_path) == []


def test_what_was_interrupted_leaves_what_was_there(spec: RunSpec, tmp_path: Path) -> None:
    write(spec, tmp_path, [3, 7])
    before = {name: (tmp_path / name).read_bytes() for name in RESULTS}
    with pytest.raises(KeyboardInterrupt), Output(tmp_path, "mine", [3], True) as output:
        fail_to_write(output, spec)
    assert {name: (tmp_path / name).read_bytes() for name in names(tmp_path)} == before


def test_a_file_appears_only_when_it_is_complete(
    spec: RunSpec, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    moved: list[str] = []
    replace = os.replace

    def watched(source: Path, target: Path) -> None:
        if not moved:
            assert [name for name in names(tmp_path) if not name.startswith(".")] == []
        assert source.stat().st_size > 0
        assert source.stat().st_dev == target.parent.stat().st_dev
        moved.append(target.name)
        replace(source, target)

    monkeypatch.setattr(os, "replace", watched)
    write(spec, tmp_path, [3, 7])
    assert sorted(moved) == RESULTS
    assert moved[-1] == "mine.json"


def a_file_in_the_way(folder: Path) -> None:
    folder.write_text("", encoding="utf-8")


def a_result_that_is_a_folder(folder: Path) -> None:
    (folder / "mine.json").mkdir(parents=True)


@pytest.mark.parametrize(
    ("prepare", "overwrite", "message"),
    [
        (a_file_in_the_way, False, "cannot be written to: File exists"),
        (a_result_that_is_a_folder, False, "has results of that name already: mine.json"),
        (a_result_that_is_a_folder, True, "holds a folder where a result belongs: mine.json"),
    ],
)
def test_a_folder_that_cannot_take_results_is_refused_before_any_work(
    prepare: Callable[[Path], None], overwrite: bool, message: str, tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    prepare(folder)
    with pytest.raises(OutputError, match=message):
        Output(folder, "mine", [3], overwrite)


def test_an_unwritable_folder_is_refused_and_not_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def denied(*args: object, **kwargs: object) -> str:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(headless.tempfile, "mkdtemp", denied)
    with pytest.raises(OutputError, match="cannot be written to: Permission denied"):
        Output(tmp_path / "a" / "b", "mine", [3], overwrite=False)
    assert names(tmp_path) == []


def test_a_name_that_is_too_long_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="cannot be written to: File name too long"):
        Output(tmp_path / "new", "x" * 250, [3], overwrite=False)
    assert names(tmp_path) == []


def test_a_full_disk_is_reported_and_leaves_nothing(
    spec: RunSpec, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*args: object, **kwargs: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    results = run_seeds(spec, [3], 1)
    with Output(tmp_path / "new", "mine", [3], overwrite=False) as output:
        monkeypatch.setattr(Path, "write_text", full)
        with pytest.raises(OutputError, match="cannot be written to: No space left on device"):
            output.commit(summary("mine", spec, results), results)
    assert names(tmp_path) == []
