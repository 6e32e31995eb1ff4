"""The folder of results: what an accident leaves behind, and who may write to it."""

import contextlib
import json
import os
import shutil
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from app import cli, readout, results
from app.experiments import Experiment, parse
from app.laboratory import Switch, Threads, run_experiment
from app.results import Folder, FolderError, finished_in, goes_on
from app.workbench import folder_for

TEXT = "presets: [timed]\nset: {world.size: 30, world.step_limit: 80}\ntrials: 600\n"

KILLED_IN_A_COMMIT = """
import os, signal, sqlite3, sys
database = sqlite3.connect(sys.argv[1])
database.execute("PRAGMA cache_size=1")
database.execute("BEGIN")
database.executemany(
    "INSERT INTO runs (key, variant, preset, overrides, settings, seed, status, version)"
    " VALUES (?, 'v', 'p', '{}', ?, 0, 'done', '0')",
    [(f"half {number}", "x" * 3000) for number in range(200)],
)
os.kill(os.getpid(), signal.SIGKILL)
"""


def small(n_seeds: int = 2) -> Experiment:
    return parse(TEXT, "small.yaml", None, n_seeds)


def carried_out(path: Path, n_seeds: int = 2, resume: bool = False, force: bool = False) -> None:
    with Folder(path, small(n_seeds), resume, force) as folder:
        run_experiment(small(n_seeds), folder, Threads(2))


def changed(path: Path, query: str, *values: Any) -> None:
    with contextlib.closing(sqlite3.connect(path / "results.sqlite")) as database, database:
        database.execute(query, values)


def meta(path: Path) -> dict[str, str]:
    with contextlib.closing(sqlite3.connect(path / "results.sqlite")) as database:
        return dict(database.execute("SELECT key, value FROM meta"))


def test_a_kill_in_the_middle_of_a_row_loses_that_row_alone(
    tmp_path: Path, counted: list[str]
) -> None:
    whole = tmp_path / "small"
    carried_out(whole)
    subprocess.run(
        [sys.executable, "-c", KILLED_IN_A_COMMIT, str(whole / "results.sqlite")], check=False
    )
    assert (whole / "results.sqlite-journal").exists()
    readers = {
        "goes on": lambda path: goes_on(path, small()),
        "finished": lambda path: len(finished_in(path)) == 2,
        "report": lambda path: len(readout.read_folder(path).rows) == 2,
        "page": lambda path: folder_for(path.parent, small()) == path,
    }
    for name, read in readers.items():
        copy = tmp_path / name / "small"
        shutil.copytree(whole, copy)
        assert read(copy), name
    counted.clear()
    carried_out(whole, resume=True)
    assert counted == []


def test_a_folder_has_one_writer(tmp_path: Path) -> None:
    path = tmp_path / "a"
    carried_out(path)
    with Folder(path, small(), True, False):
        before = (path / "results.sqlite").read_bytes()
        for resume, force in ((True, False), (False, True)):
            with pytest.raises(FolderError, match="written to by another pounce"):
                Folder(path, small(), resume, force)
        assert (path / "results.sqlite").read_bytes() == before
    carried_out(path, resume=True)


def test_a_writer_that_was_killed_keeps_nobody_out(tmp_path: Path) -> None:
    path = tmp_path / "a"
    carried_out(path)
    code = (
        "import os, signal, sys\nfrom pathlib import Path\nfrom tests.test_results import *\n"
        "folder = Folder(Path(sys.argv[1]), small(), True, False)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    root = Path(__file__).resolve().parent.parent
    subprocess.run([sys.executable, "-c", code, str(path)], cwd=root, check=False)
    carried_out(path, resume=True)


def test_runs_of_other_code_are_not_gone_on_with(tmp_path: Path) -> None:
    path = tmp_path / "small"
    carried_out(path)
    changed(path, "UPDATE runs SET version = '0.0.9+deadbeef' WHERE seed = 1")
    with pytest.raises(FolderError, match=r"made by pounce 0\.0\.9\+deadbeef, and this is"):
        Folder(path, small(), True, False)
    assert folder_for(tmp_path, small()) == tmp_path / "small-2"


@pytest.mark.parametrize("damage", ["missing", "empty"])
def test_a_run_without_its_arrays_is_made_again(
    tmp_path: Path, counted: list[str], damage: str
) -> None:
    carried_out(tmp_path)
    first, _ = sorted((tmp_path / "arrays").glob("*.npz"))
    sound = first.read_bytes()
    if damage == "missing":
        first.unlink()
    else:
        first.write_bytes(b"")
    counted.clear()
    carried_out(tmp_path, resume=True)
    assert counted == [first.stem]
    assert first.read_bytes() == sound


def test_seeds_that_are_there_stay_in_the_record(tmp_path: Path) -> None:
    carried_out(tmp_path, 4)
    carried_out(tmp_path, 2, resume=True)
    assert json.loads(meta(tmp_path)["seeds"]) == [0, 1, 2, 3]
    carried_out(tmp_path, 6, resume=True)
    assert json.loads(meta(tmp_path)["seeds"]) == [0, 1, 2, 3, 4, 5]


def test_force_spares_an_experiment_of_ones_own(tmp_path: Path) -> None:
    (tmp_path / "experiment.yaml").write_text("mine")
    with pytest.raises(FolderError, match="something else than results"):
        Folder(tmp_path, small(), False, True)
    assert [path.name for path in tmp_path.iterdir()] == ["experiment.yaml"]
    assert (tmp_path / "experiment.yaml").read_text() == "mine"


def test_the_record_says_what_ends_a_run_and_where_it_came_from(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = f"{TEXT}steps: 5000\nstop: {{success: 0.7, trials: 200}}\n"
    monkeypatch.chdir(tmp_path)
    Path("my experiment.yaml").write_text(text)
    assert cli.main(["experiment", "my experiment.yaml", "--out", "out"]) == 0
    found = meta(tmp_path / "out")
    assert found["source"] == "my experiment.yaml"
    assert json.loads(found["steps"]) == 5000
    assert json.loads(found["stop"]) == {"success": 0.7, "trials": 200, "every": 100}


def test_results_that_may_only_be_read_are_read(tmp_path: Path) -> None:
    carried_out(tmp_path)
    os.chmod(tmp_path / "results.sqlite", 0o444)
    os.chmod(tmp_path, 0o555)
    try:
        assert len(finished_in(tmp_path)) == 2
        assert results.table_csv(tmp_path).count("\n") == 3
    finally:
        os.chmod(tmp_path, 0o755)


def test_what_ended_stays_ended() -> None:
    switch = Switch()
    switch.end()
    switch.pause()
    assert not switch.paused
    assert not switch.wanted()
