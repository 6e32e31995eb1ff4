"""Experiments on a Dask cluster: the same results, whatever becomes of workers and scheduler."""

import asyncio
import contextlib
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from distributed import Client, Future

from app import __version__
from app.cli import main
from app.documents.experiments import Experiment, parse
from app.experiments import cluster, runner
from app.experiments.cluster import Cluster, perform_same
from app.experiments.crews import Switch, Threads
from app.experiments.record import Record
from app.experiments.runner import run_experiment
from app.experiments.store import Folder, version
from app.experiments.task import Finished, tasks_of
from tests.support.endless import ENDLESS
from tests.support.folders import rows

ROOT = Path(__file__).resolve().parents[2]
LONG_S = 60
"""More than anything here takes, on a machine that is busy."""
SMALL = """
presets: [timed, standard_q]
set: {world.size: 30, world.step_limit: 80, schedule: null}
trials: 40000
seeds: 5
"""
QUICK = SMALL.replace("40000", "300").replace("seeds: 5", "seeds: 2")


TIMES = {"seconds": None, "ended_at": None}
"""Columns that say how long a run took and when: all that may differ."""


def until(is_so: Callable[[], Any], what: str) -> Any:
    """Wait for a condition, which takes a moment to find out; returns what it found."""
    deadline = time.monotonic() + LONG_S
    while not (found := is_so()):
        assert time.monotonic() < deadline, f"never happened: {what}"
    return found


class Dask:
    """A scheduler and workers, as processes of this machine."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        told = folder / "scheduler.json"
        self._start("scheduler", "scheduler", "--port", "0", "--scheduler-file", str(told))

        def address() -> str | None:
            with contextlib.suppress(OSError, ValueError):
                return json.loads(told.read_text())["address"]
            return None

        def address_in_time() -> str | None:
            # Its end comes too soon, and is worth no more waiting.
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.processes["scheduler"].wait(0.02)
                pytest.fail((folder / "scheduler.log").read_text())
            return address()

        self.address: str = until(address_in_time, "the scheduler listens")

    def add_workers(self, *names: str, before: Sequence[Path] = ()) -> None:
        """Start workers of one thread; they look for packages in some folders first."""
        options = ("--no-nanny", "--nthreads", "1", "--memory-limit", "0")
        with self.eye() as eye:
            there = len(eye.nthreads())
            for name in names:
                self._start(
                    name,
                    *("worker", self.address, "--name", name, *options),
                    *("--local-directory", str(self.folder)),
                    path=[*before, ROOT],
                )
            eye.wait_for_workers(there + len(names), timeout=LONG_S)

    def kill(self, name: str) -> None:
        """End a process as a power failure would."""
        self.processes[name].send_signal(signal.SIGKILL)
        self.processes[name].wait(LONG_S)

    def eye(self) -> Client:
        """What sees the cluster from outside."""
        return Client(self.address, timeout=LONG_S, set_as_default=False)

    def end(self) -> None:
        for process in self.processes.values():
            process.kill()
        for process in self.processes.values():
            process.wait(LONG_S)

    def _start(self, name: str, *words: str, path: Sequence[Path] = (ROOT,)) -> None:
        quiet = ("--host", "127.0.0.1", "--no-dashboard", "--dashboard-address", "127.0.0.1:0")
        with (self.folder / f"{name}.log").open("wb") as log:
            self.processes[name] = subprocess.Popen(
                [sys.executable, "-m", "dask", *words, *quiet],
                env=os.environ | {"PYTHONPATH": os.pathsep.join(map(str, path))},
                stdout=log,
                stderr=log,
                cwd=self.folder,
            )


@contextlib.contextmanager
def started(folder: Path) -> Iterator[Dask]:
    found = Dask(folder)
    try:
        yield found
    finally:
        found.end()


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wait for a scheduler as long as for all else: it may just be standing still."""
    monkeypatch.setattr(cluster, "CONNECT_S", float(LONG_S))


@pytest.fixture
def dask(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Dask]:
    """A scheduler of one's own."""
    with started(tmp_path_factory.mktemp("dask")) as found:
        yield found


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Dask]:
    """A scheduler and a worker that all survive."""
    with started(tmp_path_factory.mktemp("shared")) as found:
        found.add_workers("one")
        yield found


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    Path("mine.yaml").write_text(QUICK)
    return "mine.yaml"


def complaint(capsys: pytest.CaptureFixture[str]) -> str:
    return " ".join(capsys.readouterr().err.split())


def arrays(path: Path) -> dict[str, dict[str, Any]]:
    found = {}
    for archive in sorted((path / "arrays").iterdir()):
        with np.load(archive) as kept:
            found[archive.name] = {name: kept[name] for name in kept.files}
    return found


def assert_same_results(one: Path, other: Path) -> None:
    """Digests, metrics and arrays are the same to the last bit."""
    found, expected = ([row | TIMES for row in rows(path)] for path in (one, other))
    assert found == expected
    ones, others = arrays(one), arrays(other)
    assert list(ones) == list(others)
    for key, kept in ones.items():
        assert list(kept) == list(others[key])
        for name, values in kept.items():
            np.testing.assert_array_equal(values, others[key][name])


def local(experiment: Experiment, path: Path) -> Path:
    with Folder(path, experiment, False, False) as folder:
        run_experiment(experiment, folder, Threads(2))
    return path


# --- The same results ----------------------------------------------------------------------------


def test_a_worker_that_dies_changes_no_result(dask: Dask, tmp_path: Path) -> None:
    dask.add_workers("survivor", "victim")
    experiment = parse(SMALL, "small.yaml")
    assert experiment.n_runs == 10
    written: Counter[str] = Counter()
    taken: set[str] = set()

    with (
        Folder(tmp_path / "a", experiment, False, False) as folder,
        dask.eye() as eye,
        Cluster(dask.address) as crew,
    ):
        there: Any = eye.scheduler_info()["workers"]
        (victim,) = (where for where, about in there.items() if about["name"] == "victim")
        assert crew.size == 2

        def note(record: Record, finished: Finished) -> None:
            assert finished.arrays
            written[record.key] += 1

        def look(progress: runner.Progress) -> None:
            if written and not taken:
                taken.update(eye.processing().get(victim, ()))
                if taken:
                    dask.kill("victim")

        outcome = run_experiment(experiment, folder, crew, look, note)

    assert taken
    assert (outcome.done, outcome.failed) == (10, 0)
    assert set(written.values()) == {1}
    assert {task.key for _, task in tasks_of(experiment)} == set(written)
    with dask.eye() as eye:
        # Nothing of what came back is still kept there.
        until(lambda: not any(eye.has_what().values()), "results are released")
    assert_same_results(tmp_path / "a", local(experiment, tmp_path / "b"))


def test_the_command_makes_its_runs_there(
    shared: Dask, file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["experiment", file, "--cluster", shared.address, "--json"]
    assert main.main([*words, "--dry-run"]) == 0
    assert json.loads(capsys.readouterr().out)["workers"] == 1
    assert not Path("results").exists()

    assert main.main(words) == 0
    out, err = capsys.readouterr()
    document = json.loads(out)
    assert (document["runs"], document["done"], document["failed"], err) == (4, 4, 0, "")
    assert_same_results(Path("results", "mine"), local(parse(QUICK, "mine.yaml"), tmp_path / "b"))


# --- What goes wrong -----------------------------------------------------------------------------


def test_a_scheduler_that_dies_ends_the_experiment_and_resume_goes_on(
    dask: Dask,
    file: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    dask.add_workers("one")
    write = Folder.write

    def write_and_kill(self: Folder, row: dict[str, Any]) -> None:
        write(self, row)
        dask.kill("scheduler")

    monkeypatch.setattr(Folder, "write", write_and_kill)
    Path(file).write_text(SMALL)
    assert main.main(["experiment", file, "--cluster", dask.address, "--out", "a"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines() == [
        f"'{dask.address}' was lost; what is finished is kept; --resume goes on"
    ]
    kept = rows(Path("a"))
    assert 1 <= len(kept) < 10
    assert {row["status"] for row in kept} == {"done"}

    monkeypatch.setattr(Folder, "write", write)
    assert main.main(["experiment", file, "--out", "a", "--resume"]) == 0
    assert_same_results(Path("a"), local(parse(SMALL, "mine.yaml"), tmp_path / "b"))


def test_a_cluster_that_cannot_give_the_same_results_is_refused(
    dask: Dask, file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["experiment", file, "--cluster", dask.address]
    assert main.main(words) == 2
    assert "has no workers; allowed: a scheduler that has some" in complaint(capsys)

    other = tmp_path / "other"
    shutil.copytree(ROOT / "sim", other / "sim", ignore=shutil.ignore_patterns("__pycache__"))
    with (other / "sim" / "rng.py").open("a") as file:
        file.write("# Another version.\n")
    dask.add_workers("stranger", before=[other])
    assert main.main(words) == 2
    said = complaint(capsys)
    assert f"--cluster: '{dask.address}' has another version of pounce than {version()}" in said
    (found,) = re.findall(r"tcp://\S+ has (\S+); allowed:", said)
    assert found.startswith(f"{__version__}+")
    assert found != version()
    assert not Path("results").exists()


def test_a_worker_with_another_version_that_joins_later_makes_no_run() -> None:
    _, task = next(tasks_of(parse(QUICK, "mine.yaml")))
    refused = perform_same(task, "99.0")
    assert refused is not None
    assert (refused.key, refused.digest, refused.arrays) == (task.key, "", b"")
    assert f"the worker has pounce {version()}, and 99.0 is wanted" in refused.error
    made = perform_same(task, version())
    assert made is not None
    assert not made.error
    assert made.digest


@pytest.mark.parametrize("is_listening", [True, False])
def test_an_address_where_nobody_answers(
    is_listening: bool,
    file: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(cluster, "CONNECT_S", 0.5)
    with socket.socket() as somebody:
        somebody.bind(("127.0.0.1", 0))
        if is_listening:
            somebody.listen()
        address = f"tcp://127.0.0.1:{somebody.getsockname()[1]}"
        assert main.main(["experiment", file, "--cluster", address]) == 2
    said = complaint(capsys)
    assert said.startswith(f"--cluster: '{address}' cannot be reached: ")
    assert said.endswith("; allowed: tcp://HOST:PORT of a running Dask scheduler")
    assert not Path("results").exists()


@pytest.mark.parametrize(
    "address",
    [
        "",
        "127.0.0.1:8786",
        "http://127.0.0.1:8786",
        "tcp://127.0.0.1",
        "tcp://:8786",
        "tcp://127.0.0.1:x",
        "tcp://127.0.0.1:99999",
        "tcp://me@127.0.0.1:8786",
        "tcp://127.0.0.1:8786/status",
        "tcp://[::1:8786",
    ],
)
def test_what_is_no_address(address: str, file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["experiment", file, "--cluster", address]) == 2
    said = complaint(capsys)
    assert said == (
        f"--cluster: {address!r} is not allowed; allowed: tcp://HOST:PORT of a running Dask"
        " scheduler, or tls://HOST:PORT"
    )


def test_a_cluster_has_its_own_workers(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--cluster", "tcp://127.0.0.1:8786", "--workers", "2"]
    assert main.main(["experiment", file, *words]) == 2
    assert complaint(capsys) == "--cluster and --workers exclude each other; allowed: one of them"


def test_without_dask_the_command_says_what_to_install(
    file: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert main.main(["experiment", file, "--cluster", "tcp://127.0.0.1:8786"]) == 2
    assert "pip install 'pounce-lab[cluster]'" in complaint(capsys)


def test_it_can_be_used_from_within_an_event_loop(shared: Dask) -> None:
    async def connected() -> int:
        with Cluster(shared.address) as crew:
            return crew.size

    # In a thread, since this one may be in the middle of a loop of the browser's.
    with ThreadPoolExecutor(1) as executor:
        assert executor.submit(asyncio.run, connected()).result() == 1


# --- Runs that nobody waits for ------------------------------------------------------------------
#
# These come last: what a worker has begun it goes on with, until it ends.


def test_stopping_gives_up_what_is_in_flight(shared: Dask, tmp_path: Path) -> None:
    experiment, switch = parse(ENDLESS, "small.yaml"), Switch()
    seen: list[int] = []

    def look(progress: runner.Progress) -> None:
        seen.append(progress.running)
        (switch.end if switch.paused else switch.pause)()

    with Folder(tmp_path / "a", experiment, False, False) as folder:
        outcome = run_experiment(experiment, folder, Cluster(shared.address, switch), look)
    assert seen == [1, 1, 0]
    assert outcome.done + outcome.failed < outcome.total
    assert (outcome.done, outcome.failed) == (0, 0)
    with shared.eye() as eye:
        until(lambda: not tasks_known(eye), "the scheduler forgets what nobody wants")


def test_a_run_that_dask_loses_is_noted(shared: Dask) -> None:
    with Cluster(shared.address) as crew, shared.eye() as eye:
        _, task = next(tasks_of(parse(ENDLESS, "mine.yaml")))
        crew.start(task)
        (key,) = until(lambda: tasks_known(eye), "the scheduler has the task")
        eye.cancel([Future(key, eye)], force=True)
        (found,) = until(lambda: crew.finished(0.1), "the run comes back")
        assert (found.key, found.digest, crew.busy) == (task.key, "", 0)
        assert "Cancelled" in found.error


def tasks_known(eye: Client) -> list[str]:
    """Keys of all that the scheduler knows of."""
    found: Any = eye.run_on_scheduler(lambda dask_scheduler: list(dask_scheduler.tasks))
    return found
