"""The folder of results: what an accident leaves behind, and who may write to it."""

import contextlib
import errno
import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

from app.cli import main
from app.documents.experiments import Experiment, parse
from app.experiments import claims, store, table
from app.experiments.crews import Switch, Threads
from app.experiments.runner import run_experiment
from app.experiments.store import Folder, FolderError, finished_if_claimed, finished_in, goes_on
from app.report.write import default_place, write_report
from app.results.read import read_folder
from app.results.service import folder_for
from app.util.files import write_whole
from tests.support.copies import in_a_process_of_its_own
from tests.support.folders import KILLED_IN_A_COMMIT, seal
from tests.support.reports import without_pictures

TEXT = "presets: [timed]\nset: {world.size: 30, world.step_limit: 80}\ntrials: 600\n"


def small(n_seeds: int = 2) -> Experiment:
    return parse(TEXT, "small.yaml", None, n_seeds)


def carried_out(path: Path, n_seeds: int = 2, resume: bool = False, force: bool = False) -> None:
    with Folder(path, small(n_seeds), resume, force) as folder:
        run_experiment(small(n_seeds), folder, Threads(2))


def changed(path: Path, query: str, *values: Any) -> None:
    with contextlib.closing(sqlite3.connect(path / "results.sqlite")) as database, database:
        database.execute(query, values)


def kill(*_: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


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
        "report": lambda path: len(read_folder(path).rows) == 2,
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


@pytest.mark.parametrize("force", [False, True])
def test_what_another_writer_has_just_written_is_not_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, force: bool
) -> None:
    locked = claims.locked

    def late(path: Path) -> AbstractContextManager[None]:
        """Somebody else begins and ends after the folder was looked into."""
        monkeypatch.setattr(store, "locked", locked)
        carried_out(path)
        return locked(path)

    monkeypatch.setattr(store, "locked", late)
    with pytest.raises(FolderError, match="just been written to by another pounce"):
        Folder(tmp_path / "a", small(), False, force)
    assert len(finished_in(tmp_path / "a")) == 2


@pytest.mark.parametrize("damage", ["a folder", "no lock"])
def test_a_lock_that_cannot_be_used_is_named(tmp_path: Path, damage: str) -> None:
    carried_out(tmp_path)
    lock = tmp_path / ".lock"
    lock.unlink(missing_ok=True)
    if damage == "a folder":
        lock.mkdir()
    else:
        lock.write_bytes(b"something else" * 100)
    with pytest.raises(FolderError, match="cannot be locked"):
        Folder(tmp_path, small(), True, False)
    assert len(finished_in(tmp_path)) == 2


def test_a_writer_that_was_killed_keeps_nobody_out(tmp_path: Path) -> None:
    path = tmp_path / "a"
    carried_out(path)

    def write() -> None:
        folder = Folder(path, small(), True, False)
        kill(folder)

    assert in_a_process_of_its_own(write) == -signal.SIGKILL
    carried_out(path, resume=True)


def test_runs_of_other_code_are_not_gone_on_with(tmp_path: Path) -> None:
    path = tmp_path / "small"
    carried_out(path)
    changed(path, "UPDATE runs SET version = '0.0.9+deadbeef' WHERE seed = 1")
    seal(path)
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
    assert len(finished_in(tmp_path)) == 1
    counted.clear()
    carried_out(tmp_path, resume=True)
    assert counted == [first.stem]
    assert first.read_bytes() == sound


def test_without_the_folder_of_arrays_all_runs_are_made_again(
    tmp_path: Path, counted: list[str]
) -> None:
    carried_out(tmp_path)
    shutil.rmtree(tmp_path / "arrays")
    assert finished_in(tmp_path) == set()
    counted.clear()
    carried_out(tmp_path, resume=True)
    assert len(counted) == len(finished_in(tmp_path)) == 2


def test_a_record_that_has_become_large_is_not_read(tmp_path: Path) -> None:
    carried_out(tmp_path)
    with (tmp_path / "experiment.yaml").open("r+b") as file:
        file.truncate(1 << 40)
    assert not goes_on(tmp_path, small())
    with pytest.raises(FolderError, match="results of another experiment"):
        Folder(tmp_path, small(), True, False)


@pytest.mark.parametrize(
    "data",
    [
        TEXT.replace("\n", "\r\n").encode(),
        TEXT.replace("\n", "\r").encode(),
        TEXT.encode("utf-8-sig"),
        TEXT.rstrip("\n").encode(),
        TEXT.encode() + b"\r\n\r\n",
    ],
    ids=["CRLF", "CR", "byte order mark", "no end of the last line", "empty lines at the end"],
)
def test_an_experiment_stays_what_it_is_however_its_file_is_saved(
    tmp_path: Path, counted: list[str], data: bytes
) -> None:
    path = tmp_path / "small"
    carried_out(path)
    saved = parse(data, "small.yaml", None, 2)
    assert folder_for(tmp_path, saved) == path
    counted.clear()
    with Folder(path, saved, True, False) as folder:
        run_experiment(saved, folder, Threads(1))
    assert counted == []


def test_an_experiment_that_says_something_else_is_another_one(tmp_path: Path) -> None:
    path = tmp_path / "small"
    carried_out(path)
    for other in (TEXT.replace("600", "601"), f"# Once more.\n{TEXT}"):
        experiment = parse(other, "small.yaml", None, 2)
        assert folder_for(tmp_path, experiment) == tmp_path / "small-2"
        with pytest.raises(FolderError, match="results of another experiment"):
            Folder(path, experiment, True, False)
    (path / "experiment.yaml").write_bytes(b"\xff" + TEXT.encode())
    assert not goes_on(path, small())


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
    assert main.main(["experiment", "my experiment.yaml", "--out", "out"]) == 0
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
        assert store.table_csv(tmp_path).count("\n") == 3
    finally:
        os.chmod(tmp_path, 0o755)


def test_what_ended_stays_ended() -> None:
    switch = Switch()
    switch.end()
    switch.pause()
    assert not switch.paused
    assert not switch.wanted()


# --- Beginning and going on ----------------------------------------------------------------------


@pytest.mark.parametrize("resume", [True, False])
def test_a_folder_that_was_left_before_its_table_said_anything_is_begun(
    tmp_path: Path, resume: bool
) -> None:
    path = tmp_path / "small"
    (path / "arrays").mkdir(parents=True)
    (path / "experiment.yaml").write_text(TEXT)
    (path / "results.sqlite").touch()
    assert finished_in(path) == set()
    assert goes_on(path, small())
    assert folder_for(tmp_path, small()) == path
    carried_out(path, resume=resume, force=not resume)
    assert len(finished_in(path)) == 2


KILLS: dict[str, tuple[object, str, Callable[..., object]]] = {
    "while the record is written": (os, "replace", kill),
    "when the record is there": (store, "write_whole", lambda *it: (write_whole(*it), kill())),
    "when the arrays can come": (Folder, "_begin_table", kill),
}
"""Where in the code, and what is there then."""


def killed_at_its_beginning(path: Path, when: str) -> None:
    def begin() -> None:
        setattr(*KILLS[when])
        Folder(path, small(), False, False)

    assert in_a_process_of_its_own(begin) == -signal.SIGKILL
    assert (path / ".lock").is_file()
    assert not (path / "results.sqlite").exists()


@pytest.mark.parametrize("resume", [True, False])
@pytest.mark.parametrize("when", KILLS)
def test_a_folder_that_was_killed_at_its_beginning_can_be_used(
    tmp_path: Path, when: str, resume: bool
) -> None:
    path = tmp_path / "small"
    killed_at_its_beginning(path, when)
    assert folder_for(tmp_path, small()) == path
    if when != "while the record is written":
        with pytest.raises(FolderError, match="--resume to go on, or --force to begin again"):
            carried_out(path)
    assert finished_if_claimed(path, small(), resume, not resume) == set()
    carried_out(path, resume=resume, force=not resume)
    assert len(finished_in(path)) == 2
    assert not list(path.glob(".*.tmp"))


def test_what_was_killed_at_its_beginning_is_free_if_it_left_no_record(tmp_path: Path) -> None:
    killed_at_its_beginning(tmp_path, "while the record is written")
    assert list(tmp_path.glob(".*.tmp"))
    carried_out(tmp_path)
    assert not list(tmp_path.glob(".*.tmp"))


def test_what_was_killed_at_its_beginning_is_not_gone_on_with_by_another_experiment(
    tmp_path: Path,
) -> None:
    killed_at_its_beginning(tmp_path, "when the record is there")
    other = parse(f"{TEXT}# another", "small.yaml")
    assert not goes_on(tmp_path, other)
    with pytest.raises(FolderError, match="no results to go on with; allowed: --force"):
        Folder(tmp_path, other, True, False)
    with Folder(tmp_path, other, False, True):
        assert goes_on(tmp_path, other)


def test_a_folder_of_ones_own_is_spared_though_it_holds_a_lock(tmp_path: Path) -> None:
    for name in ("experiment.yaml", ".lock", "thesis.txt"):
        (tmp_path / name).write_text(TEXT if name == "experiment.yaml" else "")
    assert not goes_on(tmp_path, parse(TEXT, "small.yaml"))
    for resume in (True, False):
        with pytest.raises(FolderError, match="something else than results"):
            carried_out(tmp_path, resume=resume, force=not resume)
    assert (tmp_path / "experiment.yaml").read_text() == TEXT


def test_results_without_their_record_are_not_gone_on_with(tmp_path: Path) -> None:
    carried_out(tmp_path)
    (tmp_path / "experiment.yaml").unlink()
    assert not goes_on(tmp_path, small())
    with pytest.raises(FolderError, match=r"whose experiment\.yaml is missing; allowed: .*--force"):
        carried_out(tmp_path, resume=True)
    carried_out(tmp_path, force=True)


def test_an_empty_table_of_another_experiment_is_not_gone_on_with(tmp_path: Path) -> None:
    (tmp_path / "experiment.yaml").write_text(f"{TEXT}# another\n")
    (tmp_path / "results.sqlite").touch()
    assert not goes_on(tmp_path, small())
    with pytest.raises(FolderError, match="no results to go on with; allowed: --force"):
        carried_out(tmp_path, resume=True)


def test_a_table_is_begun_wholly_or_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(table, "_ALL", {"key": "TEXT ("})
    with pytest.raises(FolderError):
        carried_out(tmp_path)
    monkeypatch.undo()
    carried_out(tmp_path, resume=True)
    assert len(finished_in(tmp_path)) == 2


def test_where_the_disk_is_full_at_once_the_folder_stays_free(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(path: Path, data: bytes) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(store, "write_whole", full)
    with pytest.raises(FolderError, match="No space left"):
        carried_out(tmp_path / "a")
    monkeypatch.undo()
    carried_out(tmp_path / "a")
    assert len(finished_in(tmp_path / "a")) == 2


def with_a_report(path: Path) -> Path:
    with pytest.MonkeyPatch.context() as patch:
        without_pictures(patch)
        write_report([path], None, False)
    page = path / "report.html"
    assert page.is_file()
    assert list((path / "report_figures").iterdir())
    return page


def test_beginning_again_takes_the_report_away(tmp_path: Path) -> None:
    carried_out(tmp_path)
    page = with_a_report(tmp_path)
    with Folder(tmp_path, small(), False, True):
        assert not page.exists()
        assert not (tmp_path / "report_figures").exists()


def test_a_report_on_fewer_runs_goes_when_there_are_more(tmp_path: Path) -> None:
    carried_out(tmp_path)
    page = with_a_report(tmp_path)
    mine = tmp_path / "report_figures" / "notes.txt"
    mine.write_text("mine")
    carried_out(tmp_path, resume=True)
    assert page.exists()
    carried_out(tmp_path, 3, resume=True)
    assert not page.exists()
    assert [*mine.parent.iterdir()] == [mine]


def test_a_report_over_an_older_one_leaves_its_own_pictures_alone(tmp_path: Path) -> None:
    carried_out(tmp_path)
    figures = with_a_report(tmp_path).parent / "report_figures"
    ours = {path.name for path in figures.iterdir()}
    for name in ("older.svg", "older.png", "older.csv", "notes.txt"):
        (figures / name).write_text("older")
    with_a_report(tmp_path)
    assert {path.name for path in figures.iterdir()} == {*ours, "notes.txt"}


@pytest.mark.parametrize("letter", ["a", "ü", "猫"])
def test_the_name_of_a_page_on_folders_of_long_names_is_one_that_file_systems_take(
    tmp_path: Path, letter: str
) -> None:
    folders = [tmp_path / f"{number}{letter * (240 // len(letter.encode()))}" for number in "12"]
    place = default_place(folders, False)
    assert place.parent.name.endswith(f"{letter}_and_1_more")
    place.parent.mkdir()


def test_a_report_that_is_written_while_runs_are_made_stays(tmp_path: Path) -> None:
    pages: list[Path] = []

    def report_once(*_: object) -> None:
        if not pages:
            pages.append(with_a_report(tmp_path))

    with Folder(tmp_path, small(4), False, False) as folder:
        run_experiment(small(4), folder, Threads(1), on_over=report_once)
    assert pages[0].exists()


# --- A plan refuses what the experiment would refuse ---------------------------------------------


def as_it_is(folder: Path) -> dict[str, bytes | None]:
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }


@pytest.mark.parametrize(
    ("out", "words"),
    [
        ("done", []),
        ("foreign", []),
        ("foreign", ["--resume"]),
        ("foreign", ["--force"]),
        ("another", ["--resume"]),
        ("no table", ["--resume"]),
        ("damaged", ["--resume"]),
        ("a file", []),
        ("a file/below", []),
        ("x" * 300, []),
    ],
)
def test_a_dry_run_refuses_what_would_be_refused(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    out: str,
    words: list[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("small.yaml").write_text(TEXT)
    Path("a file").write_text("mine")
    Path("foreign").mkdir()
    Path("foreign", "thesis.txt").write_text("mine")
    for name in ("done", "no table", "damaged"):
        carried_out(Path(name))
    Path("no table", "results.sqlite").unlink()
    Path("no table", "experiment.yaml").write_text(f"{TEXT}# another")
    Path("damaged", "results.sqlite").write_text("no table, but a longer text" * 100)
    with Folder(Path("another"), parse(f"{TEXT}# another", "small.yaml"), False, False):
        pass
    before = as_it_is(tmp_path)
    command = ["experiment", "small.yaml", "--seeds", "2", "--out", out, *words]
    assert main.main([*command, "--dry-run"]) == 2
    planned = capsys.readouterr()
    assert as_it_is(tmp_path) == before
    assert main.main(command) == 2
    assert capsys.readouterr() == planned
    assert planned.out == ""


def test_a_dry_run_leaves_nothing_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("small.yaml").write_text(TEXT)
    Path("there").mkdir()
    carried_out(Path("done"))
    page = with_a_report(Path("done"))
    # As results are that were copied without it.
    Path("done", ".lock").unlink()
    before = as_it_is(tmp_path)
    for words in (["new/deep"], ["there"], ["done", "--resume"], ["done", "--force"]):
        assert main.main(["experiment", "small.yaml", "--dry-run", "--out", *words]) == 0
    assert as_it_is(tmp_path) == before
    assert page.exists()


@pytest.mark.parametrize("begun", [True, False])
def test_a_dry_run_knows_of_another_pounce_at_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], begun: bool
) -> None:
    (tmp_path / "small.yaml").write_text(TEXT)
    command = ["experiment", str(tmp_path / "small.yaml"), "--dry-run", "--resume"]
    if begun:
        carried_out(tmp_path / "a")
    else:
        (tmp_path / "a").mkdir()
    with claims.locked(tmp_path / "a"):
        assert main.main([*command, "--out", str(tmp_path / "a")]) == 2
    assert "is being written to by another pounce" in " ".join(capsys.readouterr().err.split())


def test_a_wrong_file_is_said_on_standard_error_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "small.yaml").write_text("presets: [nothing]\n")
    assert main.main(["experiment", str(tmp_path / "small.yaml"), "--json"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "small.yaml:1" in err


OWN = """
presets: [{preset: standard_q, seeds: {start: 8, stop: 9}}, {preset: timed, label: other}]
set: {world.size: 20, world.step_limit: 20}
trials: 20
seeds: {start: 41001, stop: 41003}
"""


def test_a_folder_says_how_many_runs_its_presets_seeds_come_to(tmp_path: Path) -> None:
    experiment = parse(OWN, "own.yaml")
    with Folder(tmp_path / "a", experiment, False, False) as folder:
        run_experiment(experiment, folder, Threads(2))
    found = read_folder(tmp_path / "a")
    assert found.planned == len(found.rows) == experiment.n_runs == 5
    assert "--seeds" not in found.command
    fewer = parse(OWN, "own.yaml", None, 1)
    with Folder(tmp_path / "b", fewer, False, False) as folder:
        run_experiment(fewer, folder, Threads(2))
    found = read_folder(tmp_path / "b")
    assert {run.seed for run in found.rows} == {8, 41_001}
    assert "--seeds 1" in found.command
    with Folder(tmp_path / "b", experiment, True, False) as folder:
        run_experiment(experiment, folder, Threads(2))
    assert read_folder(tmp_path / "b").planned == 5
