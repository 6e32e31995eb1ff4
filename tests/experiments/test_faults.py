"""Programs that are killed or told to end, and disks that are full, broken, or know no locks.

A library that stands before the C library sees every call that changes the disk, SQLite's too.
Where there is no compiler to make it, what remains are the kills by Python in test_results.py.
"""

import contextlib
import errno
import fcntl
import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from app.cli import main
from app.documents.experiments import parse
from app.experiments import output, store
from app.experiments.crews import CrewError, Threads
from app.experiments.output import Output
from app.experiments.runner import run_experiment
from app.experiments.store import Folder, FolderError, finished_in, goes_on
from app.experiments.table import read, reader
from app.report.document import Page
from app.report.write import _write_all
from app.results.read import ResultsError, read_folder
from app.util import interrupts, leftovers
from app.util.files import write_whole
from tests.support.endless import ENDLESS, WORLD
from tests.support.faults import built
from tests.support.folders import KILLED_IN_A_COMMIT

ROOT = Path(__file__).resolve().parents[2]
TEXT = "presets: [timed]\nset: {world.size: 30, world.step_limit: 80}\ntrials: 60\nseeds: 2\n"
PATIENCE_S = 60.0
POUNCE = (sys.executable, "-m", "app")
KILLED = 0
EVERY_FAULT = "POUNCE_EVERY_FAULT"
"""Of an environment variable: whether faults are tried at every call, which takes minutes."""
N_FAULTS = 16
"""At how many calls they are tried otherwise."""


def rows(path: Path) -> list[tuple[Any, ...]]:
    with contextlib.closing(reader(path)) as database:
        found = read(database).rows
    return sorted((row["key"], row["digest"], row["trials"], row["arrays"]) for row in found)


def hidden(path: Path) -> list[Path]:
    """What is hidden in a folder, but for the lock that every folder of results has."""
    return [found for found in path.rglob(".*") if found != path / ".lock"]


# --- Every call that changes the disk ------------------------------------------------------------


class Fault(NamedTuple):
    """What a command came to on a disk with a fault."""

    code: int | None
    """None if it was killed."""
    n_calls: int
    said: str


class Warm:
    """A program that carries out commands, and what they come to where nothing fails."""

    def __init__(self, folder: Path) -> None:
        library = built("writes", folder)
        (folder / "e.yaml").write_text(TEXT)
        first = ("experiment", "e.yaml", "--out", "first")
        self.folder = folder
        self._program = subprocess.Popen(
            [sys.executable, "-m", "tests.support.faults.warm", str(library), *first],
            cwd=folder,
            env=os.environ | {"LD_PRELOAD": str(library), "PYTHONPATH": str(ROOT)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._answer() == "ready\n"
        self.n_calls = self.carry_out("whole").n_calls
        self.names = sorted(path.name for path in (folder / "whole").iterdir())
        self.rows = rows(folder / "whole")
        assert len(self.rows) == 2

    def carry_out(self, out: str, *words: str, at: int = 0, error: int = KILLED) -> Fault:
        """Carry out the experiment where a call fails, or the program is killed at it."""
        assert self._program.stdin is not None
        command = ("experiment", "e.yaml", "--out", out, *words)
        self._program.stdin.write(f"{json.dumps([at, error, command])}\n")
        self._program.stdin.flush()
        found = json.loads(self._answer())
        return Fault(None, 0, "") if found is None else Fault(*found)

    def close(self) -> None:
        self._program.communicate(timeout=PATIENCE_S)

    def _answer(self) -> str:
        assert self._program.stdout is not None
        return self._program.stdout.readline()


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Warm]:
    found = Warm(tmp_path_factory.mktemp("warm"))
    yield found
    found.close()


def some_of(n_calls: int) -> range:
    """Calls at which something happens: all, or as many as the time of a test is enough for."""
    step = 1 if os.environ.get(EVERY_FAULT) else -(-n_calls // N_FAULTS)
    return range(1, n_calls + 1, step)


def test_whenever_it_is_killed_an_experiment_goes_on(warm: Warm) -> None:
    for at in some_of(warm.n_calls):
        path = warm.folder / f"killed-{at}"
        assert warm.carry_out(path.name, at=at).code is None, at
        ended = warm.carry_out(path.name, "--resume")
        assert (ended.code, ended.said) == (0, ""), at
        assert rows(path) == warm.rows, at
        assert sorted(found.name for found in path.iterdir()) == warm.names, at
        assert not hidden(path), at
        shutil.rmtree(path)


@pytest.mark.parametrize("call", ["rename:signal=SIGKILL:when=1", "unlink:signal=SIGKILL:when=5"])
def test_killed_by_the_system_itself_the_command_goes_on(tmp_path: Path, call: str) -> None:
    """As above, without a library in between: strace kills it in the call."""
    strace = shutil.which("strace")
    if strace is None or subprocess.run([strace, "true"], capture_output=True).returncode:
        pytest.skip("strace kills the command, and it is missing or not allowed to trace")
    (tmp_path / "e.yaml").write_text(TEXT)
    command = [*POUNCE, "experiment", "e.yaml", "--out", "out"]
    tracing = [strace, "-f", "-o", os.devnull, "-e", "trace=rename,unlink", "-e", f"inject={call}"]
    # What is renamed and taken away first is to be a result, and no compiled module.
    env = os.environ | {"PYTHONPATH": str(ROOT), "PYTHONDONTWRITEBYTECODE": "1"}
    ended = subprocess.run([*tracing, *command], cwd=tmp_path, env=env, capture_output=True)
    assert ended.returncode == -signal.SIGKILL
    assert hidden(tmp_path / "out")
    assert subprocess.run([*command, "--resume"], cwd=tmp_path, env=env).returncode == 0
    assert len(rows(tmp_path / "out")) == 2
    assert not hidden(tmp_path / "out")


@pytest.mark.parametrize("error", [errno.ENOSPC, errno.EDQUOT, errno.EIO])
def test_whenever_the_disk_fails_it_is_said_and_goes_on_later(warm: Warm, error: int) -> None:
    for at in some_of(warm.n_calls)[:: 1 if os.environ.get(EVERY_FAULT) else 3]:
        path = warm.folder / f"failed-{at}"
        failed = warm.carry_out(path.name, at=at, error=error)
        if failed.code == 0:
            # What was left to be done was taking things away.
            assert failed.n_calls < at
        else:
            assert failed.code in (1, 2), at
            assert "cannot be" in failed.said, at
        assert "Traceback" not in failed.said
        assert warm.carry_out(path.name, "--resume").code == 0, at
        assert rows(path) == warm.rows, at
        assert not hidden(path), at
        shutil.rmtree(path)


def test_what_was_killed_in_the_first_commit_begins_again(tmp_path: Path) -> None:
    """Its first lines are half there, and the journal of SQLite says that they are to go."""
    path, experiment = tmp_path / "small", parse(TEXT, "small.yaml")
    path.mkdir()
    (path / ".lock").touch()
    (path / "experiment.yaml").write_text(TEXT)
    (path / "arrays").mkdir()
    begun = "database.execute('CREATE TABLE runs (key, variant, preset, overrides, settings, seed,"
    begun += " status, version, seal)')\n"
    killed = KILLED_IN_A_COMMIT.replace('"BEGIN")\n', f'"BEGIN")\n{begun}')
    subprocess.run([sys.executable, "-c", killed, str(path / "results.sqlite")], check=False)
    assert (path / "results.sqlite").stat().st_size
    assert (path / "results.sqlite-journal").stat().st_size
    copy = shutil.copytree(path, tmp_path / "copy" / "small")
    with pytest.raises(ResultsError, match="no run is over"):
        read_folder(copy)
    copy = shutil.copytree(path, tmp_path / "another" / "small")
    assert goes_on(copy, experiment)
    assert finished_in(copy) == set()
    with Folder(path, experiment, True, False) as folder:
        assert run_experiment(experiment, folder, Threads(1)).done == 2
    assert not hidden(path)


# --- A disk without locks ------------------------------------------------------------------------


def test_on_a_disk_without_locks_results_are_read_and_not_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("e.yaml").write_text(TEXT)
    assert main.main(["experiment", "e.yaml", "--out", "there"]) == 0
    before = rows(Path("there"))
    program = (
        "import sys\nfrom app.cli import main\nfrom app.results.read import read_folder\n"
        "from pathlib import Path\n"
        "assert len(read_folder(Path('there')).rows) == 2\n"
        "for words in (['there', '--resume'], ['new'], ['new', '--dry-run']):\n"
        "    assert main.main(['experiment', 'e.yaml', '--out', *words]) == 2\n"
    )
    env = {"LD_PRELOAD": str(built("nolock", tmp_path)), "PYTHONPATH": str(ROOT)}
    ended = subprocess.run(
        [sys.executable, "-c", program],
        env=os.environ | env,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ended.returncode, ended.stdout) == (0, ""), ended.stderr
    said = " ".join(ended.stderr.split())
    assert said.count("is on a disk that cannot lock files") == 3
    assert "another pounce" not in said
    assert not Path("new").exists()
    assert rows(Path("there")) == before


def test_what_a_kill_left_on_a_disk_that_may_only_be_read_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "small"
    with Folder(path, parse(TEXT, "small.yaml"), False, False):
        pass
    table = path / "results.sqlite"
    subprocess.run([sys.executable, "-c", KILLED_IN_A_COMMIT, str(table)], check=False)
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(ResultsError, match="half written: allowed: a copy that can be written to"):
        read_folder(path)


# --- Being told to end ---------------------------------------------------------------------------


def is_held(folder: Path) -> bool:
    """Whether a living program has locked a folder; looking at it does not keep it locked."""
    file = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(file)
    return False


COMMANDS = {
    "run": (
        *("run", "standard_q", "--trials", "2000000", "--workers", "1", "--out", "out"),
        *(word for name, value in WORLD.items() for word in ("--set", f"{name}={value}")),
    ),
    "experiment": ("experiment", "long.yaml", "--workers", "1", "--out", "out"),
}
BEGUN: dict[str, Callable[[Path], object]] = {
    # Before it is held, whoever comes may take it away, and another is made.
    "run": lambda path: any(is_held(found) for found in path.glob("out/.pounce-*")),
    "experiment": lambda path: (path / "out" / "results.sqlite").exists(),
}


def begun(path: Path, command: str, ignored: int | None = None) -> "subprocess.Popen[str]":
    """A command in a process of its own, at work."""
    (path / "long.yaml").write_text(ENDLESS)

    def prepare() -> None:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_DFL)
        if ignored is not None:
            signal.signal(ignored, signal.SIG_IGN)

    program = subprocess.Popen(
        [*POUNCE, *COMMANDS[command]],
        cwd=path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=prepare,
    )
    deadline = time.monotonic() + PATIENCE_S
    while not BEGUN[command](path):
        assert time.monotonic() < deadline
        assert program.poll() is None
        time.sleep(0.01)
    return program


@pytest.mark.parametrize("command", COMMANDS)
def test_a_batch_job_whose_time_is_over_leaves_nothing(tmp_path: Path, command: str) -> None:
    program = begun(tmp_path, command)
    program.send_signal(signal.SIGTERM)
    _, said = program.communicate(timeout=PATIENCE_S)
    assert program.returncode == 143
    assert said.startswith("ended by SIGTERM")
    assert said.count("\n") == 1
    if command == "run":
        assert not (tmp_path / "out").exists()
    else:
        assert not hidden(tmp_path / "out")


def test_a_terminal_that_is_closed_ends_it_unless_it_was_told_not_to_mind(tmp_path: Path) -> None:
    program = begun(tmp_path, "run", ignored=signal.SIGHUP)
    program.send_signal(signal.SIGHUP)
    program.send_signal(signal.SIGTERM)
    program.communicate(timeout=PATIENCE_S)
    assert program.returncode == 143


def test_who_is_told_to_end_twice_ends_once() -> None:
    before = signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGHUP)
    cleared: list[str] = []

    def work() -> None:
        with interrupts.as_interrupts():
            try:
                signal.raise_signal(signal.SIGHUP)
            finally:
                signal.raise_signal(signal.SIGTERM)
                signal.raise_signal(signal.SIGHUP)
                cleared.append("all")

    with pytest.raises(interrupts.Ended) as ending:
        work()
    assert cleared == ["all"]
    assert interrupts.ended_by(ending.value) == ("ended by SIGHUP", 129)
    assert (signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGHUP)) == before


# --- What kills have left ------------------------------------------------------------------------


def test_what_a_kill_left_is_taken_away_by_the_next_run(tmp_path: Path) -> None:
    program = begun(tmp_path, "run")
    out = tmp_path / "out"
    (living,) = out.iterdir()
    (out / ".pounce-01234567").mkdir()
    (out / ".pounce-01234567" / "timed-seed0.npz").touch()
    mine = out / ".pounce-mine.txt"
    mine.mkdir()
    with Output(out, "other", [0], overwrite=False):
        # Of somebody who lives nothing is taken.
        assert living.is_dir()
        assert not (out / ".pounce-01234567").exists()
    program.send_signal(signal.SIGKILL)
    program.communicate(timeout=PATIENCE_S)
    assert {*out.iterdir()} == {living, mine}
    with Output(out, "other", [0], overwrite=False):
        assert not living.exists()
    assert [*out.iterdir()] == [mine]


def test_a_file_that_is_being_written_is_not_taken_for_one_that_was_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / ".pounce-left.tmp").write_bytes(b"half")
    replace = os.replace

    def clear_first(*paths: Path) -> None:
        leftovers.clear(tmp_path, ".pounce-*.tmp")
        assert len([*tmp_path.iterdir()]) == 1
        replace(*paths)

    monkeypatch.setattr(os, "replace", clear_first)
    write_whole(tmp_path / "file", b"whole")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_a_file_that_was_taken_away_at_its_beginning_is_begun_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hold = leftovers.hold

    def clear_first(file: int, path: Path) -> bool:
        monkeypatch.setattr(leftovers, "hold", hold)
        leftovers.clear(path.parent, ".pounce-*")
        return hold(file, path)

    monkeypatch.setattr(leftovers, "hold", clear_first)
    write_whole(tmp_path / "file", b"whole")
    assert (tmp_path / "file").read_bytes() == b"whole"
    monkeypatch.setattr(leftovers, "hold", clear_first)
    with Output(tmp_path, "other", [0], overwrite=False), output._staging_in(tmp_path) as staging:
        assert staging.is_dir()


def test_a_report_clears_what_a_killed_one_has_left_beside_it(tmp_path: Path) -> None:
    figures = tmp_path / "page_figures"
    figures.mkdir()
    for place in (tmp_path, figures):
        (place / ".pounce-left.tmp").write_text("half")
        (place / ".notes.tmp").write_text("somebody's own")
    _write_all(Page([], figures.name), tmp_path / "page.html", "a page")
    assert [path.name for path in tmp_path.rglob(".*")] == [".notes.tmp", ".notes.tmp"]


# --- While it is at work -------------------------------------------------------------------------


def test_a_folder_that_is_removed_while_runs_are_made_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("e.yaml").write_text(TEXT.replace("seeds: 2", "seeds: 4"))
    save, saved = Folder.save, []

    def remove(folder: Folder, key: str, arrays: bytes) -> None:
        save(folder, key, arrays)
        saved.append(key)
        if len(saved) == 2:
            shutil.rmtree(folder.path)

    monkeypatch.setattr(Folder, "save", remove)
    assert main.main(["experiment", "e.yaml", "--out", "out", "--workers", "1"]) == 1
    err = capsys.readouterr().err
    assert err.startswith("'out' cannot be written to: ")
    assert err.count("\n") == 1
    assert not Path("out").exists()


def test_whatever_ends_the_work_of_a_thread_the_run_is_noted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def end(*_: object) -> None:
        raise SystemExit("enough")

    monkeypatch.setattr("app.experiments.crews.perform", end)
    experiment = parse(TEXT, "a.yaml")
    with Folder(tmp_path / "a", experiment, False, False) as folder:
        outcome = run_experiment(experiment, folder, Threads(1))
        assert (outcome.done, outcome.failed) == (0, 2)
        assert folder.first_error().endswith("seed 0: SystemExit: enough")


def test_where_no_thread_can_be_had_it_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_: object) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr("threading.Thread.start", refuse)
    experiment = parse(TEXT, "a.yaml")
    with Folder(tmp_path / "a", experiment, False, False) as folder, pytest.raises(CrewError):
        run_experiment(experiment, folder, Threads(1))
    (tmp_path / "a.yaml").write_text(TEXT)
    words = [str(tmp_path / "a.yaml"), "--out", str(tmp_path / "b")]
    assert main.main(["experiment", *words]) == 1
    assert capsys.readouterr().err == "no thread can be had: can't start new thread\n"


def test_a_table_that_can_no_longer_be_read_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(_: object) -> None:
        raise sqlite3.OperationalError("disk I/O error")

    experiment = parse(TEXT, "a.yaml")
    with Folder(tmp_path / "a", experiment, False, False) as folder:
        monkeypatch.setattr(store.table, "read", fail)
        for ask in (folder.finished, folder.lost, folder.records, folder.first_error):
            with pytest.raises(FolderError, match="disk I/O error"):
                ask()


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is full")
def test_an_answer_that_has_no_room_is_said(tmp_path: Path) -> None:
    with open("/dev/full", "w") as full:
        ended = subprocess.run(
            [*POUNCE, "presets"],
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert ended.returncode == 1
    assert ended.stderr.startswith("cannot go on: ")
    assert ended.stderr.count("\n") == 1
