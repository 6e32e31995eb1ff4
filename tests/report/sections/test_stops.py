"""Reports on runs that a stop condition ended: how soon, and that nothing else leads."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.documents.experiments import parse
from app.experiments.crews import Threads
from app.experiments.runner import run_experiment
from app.experiments.store import Folder
from app.report import write
from app.results import read
from sim.world import CAPTURE, FLIGHT
from tests.support.folders import N_TRIALS, add_arrays, add_run, new_folder, seal
from tests.support.reports import page_of, pictures_of, table_of, text_of

STOP = {"success": 0.5, "trials": 100, "every": 100}


def ends_with(folder: Path, seed: int, n_captures: int, n_trials: int, **more: Any) -> None:
    """A run of so many trials of ten steps, of which the last ones are captures."""
    outcome = np.full(n_trials, FLIGHT, np.int8)
    outcome[n_trials - n_captures :] = CAPTURE
    arrays = {"outcome": outcome, "steps": np.full(n_trials, 10, np.int32)}
    key = f"k{len(list((folder / 'arrays').iterdir()))}"
    add_run(folder, seed, trials=n_trials, steps=10 * n_trials, **more)
    kept = dict(np.load(folder / "arrays" / f"{key}.npz"))
    add_arrays(folder, key, **{**kept, **arrays})
    seal(folder)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two variants; of the second, one run is good enough at its very end and one never was."""
    folder = new_folder(tmp_path / "stopped", stop=json.dumps(STOP))
    for seed, n_trials in enumerate((100, 200, 200)):
        ends_with(folder, seed, 50, n_trials)
    for seed, n_captures in enumerate((50, 49, 80)):
        ends_with(folder, seed, n_captures, N_TRIALS, variant="slow", overrides={"x": 1})
    return folder


def test_steps_until_the_condition_was_met_lead(folder: Path) -> None:
    page = page_of(folder)
    text = text_of(page)
    assert "50 % of its last 100 trials were captures" in text
    rows = {row["variant"]: row for row in table_of(page, "steps until then")}
    steps, trials = "steps until then [95 %]", "trials until then [95 %]"
    assert rows["timed"][steps] == "2,000 [1,000, \N{INFINITY}] by 3 of 3 runs"
    assert rows["timed"][trials] == "200 [100, \N{INFINITY}] by 3 of 3 runs"
    assert rows["slow"][steps] == "3,000 [3,000, \N{INFINITY}] by 2 of 3 runs"
    assert page.index("Steps until the condition was met") < page.index("Variants beside")


def test_variants_are_compared_by_how_long_they_took(folder: Path) -> None:
    page = page_of(folder)
    rows = {row["variant"]: row for row in table_of(page, "n of the difference")}
    assert rows["timed"]["run length (steps) [95 %]"].startswith("1,667")
    assert not any("final reward" in head for head in rows["timed"])


def test_a_plane_of_runs_that_were_stopped_is_of_their_lengths(tmp_path: Path) -> None:
    folder = new_folder(tmp_path / "plane", stop=json.dumps(STOP))
    for x in (1, 2):
        for y in (1, 2):
            sets = {"at": x, "p": y}
            ends_with(folder, 0, 50, 100 * x, variant=f"{x} {y}", overrides=sets)
    page_of(folder)
    assert [name for name in pictures_of(folder) if "plane" in name] == ["plane_1_steps"]


def test_a_condition_that_was_met_between_two_looks_ended_nothing(tmp_path: Path) -> None:
    folder = new_folder(tmp_path / "stopped", stop=json.dumps(STOP))
    ends_with(folder, 0, 100, 250)
    (run,) = read.read_folder(folder).rows
    reader = read.Reader(read.widths_of([run]), lambda run, log: {})
    (trace,) = reader.traces([run])
    assert trace.met is None


def test_runs_with_other_stop_conditions_are_other_variants(tmp_path: Path) -> None:
    folders = [
        new_folder(tmp_path / name, stop=json.dumps({**STOP, "success": success}))
        for name, success in (("a", 0.5), ("b", 0.6))
    ]
    for seed, folder in enumerate(folders):
        ends_with(folder, seed, 60, 100)
    page = page_of(*folders)
    assert [row["variant"] for row in table_of(page, "steps until then")] == [
        "a: timed",
        "b: timed",
    ]


def test_both_sides_of_a_comparison_say_when_they_met_their_condition(tmp_path: Path) -> None:
    folders = [new_folder(tmp_path / name, stop=json.dumps(STOP)) for name in "ab"]
    for folder, n_trials in zip(folders, (100, 200), strict=True):
        for seed in range(2):
            ends_with(folder, seed, 50, n_trials)
    rows = table_of(page_of(*folders, compare=True), "steps until then")
    assert [(row["variant"], row["n"]) for row in rows] == [("A: timed", "2"), ("B: timed", "2")]


def test_an_experiment_may_ask_for_the_length_of_its_runs(tmp_path: Path) -> None:
    text = "presets: [timed]\nset: {world.size: 30}\ntrials: 200\nseeds: 2\nmetrics: [trials]\n"
    experiment = parse(text, "small.yaml")
    with Folder(tmp_path / "small", experiment, False, False) as folder:
        run_experiment(experiment, folder, Threads(1))
    rows = read.read_folder(tmp_path / "small").rows
    assert [row.trials for row in rows] == [200, 200]
    assert all(row.steps > 200 for row in rows)
    page = write.write_report([tmp_path / "small"], None, False).page
    (row,) = table_of(page.read_text(encoding="utf-8"), "run length (trials)")
    assert row["run length (trials)"] == "200 [200, 200]"
