"""Running an experiment into a folder, so that what is finished stays, whatever happens.

A folder holds ``experiment.yaml`` as it was given, ``results.sqlite``, and for each finished run
``arrays/KEY.npz``. The arrays of a run are moved into place before its row is written: a row says
that everything is there, and whatever ends the program loses at most the runs in flight. Runs go
over threads, for the kernel holds no lock; the calling thread alone writes rows.

Success is a share, 0 to 1. What is *final* is of the last 2,000 trials.
"""

import contextlib
import hashlib
import importlib.metadata
import itertools
import json
import math
import os
import queue
import re
import sqlite3
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple, Self

import numpy as np

from app.experiments import Experiment, Stop, Variant
from learners import greedy, kernel, measures
from learners.run import Run
from learners.spec import MAX_TRIALS, RunSpec
from learners.state import digest, tables
from sim import rng
from sim.world import CAPTURE, start_of_trial

SCHEMA_VERSION: Final = 1

COLUMNS: Final = {
    "key": "TEXT PRIMARY KEY",
    "variant": "TEXT NOT NULL",
    "preset": "TEXT NOT NULL",
    "overrides": "TEXT NOT NULL",
    "settings": "TEXT NOT NULL",
    "seed": "INTEGER NOT NULL",
    "status": "TEXT NOT NULL",
    "error": "TEXT",
    "version": "TEXT NOT NULL",
    "digest": "TEXT",
    "seconds": "REAL",
    "trials": "INTEGER",
    "steps": "INTEGER",
    "captures": "INTEGER",
    "flights": "INTEGER",
    "timeouts": "INTEGER",
    "final_reward": "REAL",
    "final_success": "REAL",
    "greedy_success": "REAL",
    "area": "REAL",
    "steps_to_50": "INTEGER",
    "steps_to_70": "INTEGER",
    "mean_hunt_length": "REAL",
    "switches_per_step": "REAL",
}
"""Of the table ``runs``. ``overrides`` and ``settings`` are JSON."""

DONE: Final = "done"
FAILED: Final = "failed"

GREEDY_HUNTS: Final = 2_000
"""Hunts by which greedy success is measured: a share of 0.8 is known to within 0.01 by them."""
GREEDY_SEED: Final = 7_331_729
"""Of the starts of these hunts: the same ones for all runs in a world."""

_SLICE_STEPS = 2_000_000
"""Steps between two looks at whether to stop: a tenth of a second."""
_POLL_S = 0.1
_LONGEST_ERROR = 4_000
_BYTES_PER_RUN = 4_000
"""Of a row with its settings, and of what surrounds the arrays."""
_BYTES_PER_TRIAL = 2.0
"""Of the arrays, compressed."""
_S_PER_RUN = 0.05
"""Time that a run takes beside its steps."""
_PILOT_S = 0.04
"""Time for which the speed of a preset is measured."""
_MOST_PILOTS = 4


class FolderError(Exception):
    """Results cannot be kept in that folder; the message says why."""


class Progress(NamedTuple):
    """How far an experiment has come."""

    total: int
    done: int
    """With those that were finished before."""
    failed: int
    running: int
    steps: int
    """Made since it was started or resumed."""
    steps_per_s: float
    share: float
    """Of all the work, by its estimate, 0 to 1."""
    seconds_left: float | None
    """None as long as nothing can be said."""


class Plan(NamedTuple):
    """What an experiment would take."""

    variants: int
    runs: int
    steps: int
    """Estimated, as are the following."""
    seconds: float
    disk_bytes: int


@dataclass(frozen=True)
class Outcome:
    """How an experiment ended."""

    total: int
    done: int
    failed: int
    steps: int
    seconds: float
    stopped: bool
    """Whether it was stopped before all runs were over."""


# --- One run -------------------------------------------------------------------------------------


class _Planned(NamedTuple):
    key: str
    variant: Variant
    seed: int
    trials: int
    work: float
    """Estimated steps."""


def identity_of(experiment: Experiment, variant: Variant) -> str:
    """All that the runs of a variant are a function of, but for the seed, as a short text."""
    stop = experiment.stop
    about = [
        variant.label,
        variant.spec.model_dump(mode="json"),
        experiment.trials_of(variant),
        experiment.steps,
        None if stop is None else [stop.success, stop.trials, stop.every],
    ]
    return hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()


def key_of(label: str, identity: str, seed: int) -> str:
    """Name of a run's row and of its arrays: safe in any file system, and readable."""
    word = re.sub(r"[^a-z0-9]+", "-", label.lower()).strip("-")[:40].strip("-") or "run"
    found = hashlib.sha256(f"{identity} {seed}".encode()).hexdigest()
    return f"{word}-{seed}-{found[:16]}"


def made_run(
    spec: RunSpec,
    seed: int,
    trials: int,
    steps: int | None = None,
    stop: Stop | None = None,
    on_progress: Callable[[Run], object] = lambda _: None,
    wanted: Callable[[], bool] = lambda: True,
) -> Run | None:
    """Run a preset until its trials or steps are over, or it is good enough.

    Where it ends does not depend on how often it is looked at.

    Returns:
        The run; None if it was no longer wanted.
    """
    run = Run(spec, seed)
    while run.trial < trials and (steps is None or run.step < steps):
        if not wanted():
            return None
        left = _SLICE_STEPS if steps is None else min(_SLICE_STEPS, steps - run.step)
        until = trials
        if stop is not None:
            until = min(trials, (run.trial // stop.every + 1) * stop.every)
        run.advance(max_steps=left, until_trial=until)
        on_progress(run)
        if stop is not None and run.trial % stop.every == 0 and _is_good_enough(run, stop):
            break
    return run


def _is_good_enough(run: Run, stop: Stop) -> bool:
    is_between_trials = run.state.tally[kernel.TRIAL_STEP] == 0
    if run.trial < stop.trials or not is_between_trials:
        return False
    captures = measures.endings(run.state, stop.trials).captures
    return captures >= stop.success * stop.trials


def greedy_success(run: Run) -> float:
    """Share of captures of hunts of pure greed, over starts drawn as those of trials are."""
    found = tables(run.spec, run.state)
    selection_q = np.nan_to_num(found["selection_q"], nan=-np.inf)
    skill_q = found["skill_q"] if run.spec.learner.skills else None
    policy = greedy.greedy_moves(selection_q, skill_q)
    starts = rng.streams(GREEDY_SEED)[rng.STARTS]
    captures = 0
    for hunt in range(GREEDY_HUNTS):
        cell, heading = start_of_trial(run.world, starts, hunt)
        outcome = greedy.hunt(run.world, policy, int(cell), int(heading), seed=hunt).outcome
        captures += outcome == CAPTURE
    return captures / GREEDY_HUNTS


def steps_to(outcomes: np.ndarray, steps: np.ndarray, success: float) -> int | None:
    """Steps after which the share of captures in the last 500 trials first was so high.

    Args:
        outcomes: how trials ended, ``(trial,)``.
        steps: how long they took, ``(trial,)``.
        success: the share.
    """
    window = measures.RECENT_TRIALS
    if len(outcomes) < window:
        return None
    captures = np.concatenate([[0], np.cumsum(outcomes == CAPTURE)])
    there = np.flatnonzero(captures[window:] - captures[:-window] >= success * window)
    return int(np.sum(steps[: there[0] + window], dtype=np.int64)) if there.size else None


def area_under(curve: measures.Curve) -> float | None:
    """Mean of a learning curve over its steps: the area under it, on the scale of rewards."""
    widths = np.diff(curve.steps, prepend=0)
    there = np.isfinite(curve.reward)
    if not widths[there].sum():
        return None
    return float(np.average(curve.reward[there], weights=widths[there]))


def measured(run: Run) -> dict[str, Any]:
    """What a row says of how a run went; None where there is nothing to say."""
    world, state = run.spec.world, run.state
    done = measures.trials_done(state)
    outcomes, steps = state.log_outcome[:done], state.log_steps[:done]
    endings = measures.endings(state)
    final = measures.endings(state, measures.FINAL_TRIALS)
    return {
        "digest": digest(state),
        "trials": done,
        "steps": run.step,
        "captures": endings.captures,
        "flights": endings.flights,
        "timeouts": endings.timeouts,
        "final_reward": measures.mean_reward(world, state) if done else None,
        "final_success": final.captures / sum(final) if done else None,
        "greedy_success": greedy_success(run),
        "area": area_under(measures.curve(world, state)),
        "steps_to_50": steps_to(outcomes, steps, 0.5),
        "steps_to_70": steps_to(outcomes, steps, 0.7),
        "mean_hunt_length": float(steps[-measures.FINAL_TRIALS :].mean()) if done else None,
        "switches_per_step": measures.pace(state, measures.FINAL_TRIALS).switches_per_step,
    }


def arrays_of(run: Run) -> dict[str, np.ndarray]:
    """What is kept of a run beside its row.

    ``outcome (trial,) int8``, ``steps (trial,) int32``, ``introductions (skill, [trial, step])
    int64``, and the names of these skills, ``introduced (skill,)``.
    """
    done = measures.trials_done(run.state)
    joined = run.control.introductions
    moments = np.array([[entry.trial, entry.step] for entry in joined], np.int64)
    return {
        "outcome": run.state.log_outcome[:done],
        "steps": run.state.log_steps[:done],
        "introductions": moments.reshape(-1, 2),
        "introduced": np.array([entry.skill for entry in joined], "U32"),
    }


# --- The folder ----------------------------------------------------------------------------------


class Folder:
    """Where the results of one experiment are. Used as a context, by one thread."""

    def __init__(self, path: Path, experiment: Experiment, resume: bool, force: bool) -> None:
        """Claim the folder before any work is done.

        Raises:
            FolderError: it cannot be used; nothing in it has changed.
        """
        self.path = path
        self.arrays = path / "arrays"
        try:
            is_new = not path.exists() or not any(path.iterdir())
            if is_new or force:
                self._refuse_stranger(is_new)
                self._begin(experiment)
            elif resume:
                self._go_on(experiment)
            else:
                raise FolderError(
                    "is there already and not empty; allowed: another folder, --resume to go on,"
                    " or --force to begin again"
                )
        except sqlite3.Error as error:
            raise FolderError(f"holds a results.sqlite that cannot be used: {error}") from error
        except OSError as error:
            raise _unwritable(error) from error

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self._database.close()

    @property
    def table(self) -> Path:
        """The results table."""
        return self.path / "results.sqlite"

    def finished(self) -> set[str]:
        """Keys of the runs that are done."""
        rows = self._database.execute("SELECT key FROM runs WHERE status = ?", (DONE,))
        return {key for (key,) in rows}

    def first_error(self) -> str:
        """Last line of what the first failed run said."""
        query = "SELECT variant, seed, error FROM runs WHERE status = ? ORDER BY rowid LIMIT 1"
        row = self._database.execute(query, (FAILED,)).fetchone()
        if row is None:
            return ""
        variant, seed, error = row
        return f"{variant}, seed {seed}: {error.strip().splitlines()[-1]}"

    def write(self, row: Mapping[str, Any]) -> None:
        """Add a run, or replace one that failed.

        Raises:
            FolderError: the row could not be written.
        """
        names = ", ".join(COLUMNS)
        places = ", ".join("?" * len(COLUMNS))
        values = [row.get(name) for name in COLUMNS]
        try:
            with self._database:
                self._database.execute(
                    f"INSERT OR REPLACE INTO runs ({names}) VALUES ({places})", values
                )
        except sqlite3.Error as error:
            raise FolderError(f"cannot be written to: {error}; --resume goes on later") from error

    def save(self, key: str, run: Run) -> None:
        """Put the arrays of a run into place, whole. From any thread.

        Raises:
            FolderError: they could not be written.
        """
        arrays: dict[str, Any] = arrays_of(run)
        passing = self.arrays / f".{key}.tmp"
        try:
            with passing.open("wb") as file:
                np.savez_compressed(file, **arrays)
            os.replace(passing, self.arrays / f"{key}.npz")
        except OSError as error:
            with contextlib.suppress(OSError):
                passing.unlink(missing_ok=True)
            raise _unwritable(error) from error

    def _refuse_stranger(self, is_new: bool) -> None:
        """--force begins results again; it clears nothing that is not results."""
        if not is_new and not self.table.is_file() and not (self.path / "experiment.yaml").exists():
            raise FolderError("holds something else than results; allowed: another folder")

    def _begin(self, experiment: Experiment) -> None:
        self.arrays.mkdir(parents=True, exist_ok=True)
        for name in ("", "-journal", "-wal", "-shm"):
            self.table.with_name(self.table.name + name).unlink(missing_ok=True)
        self._clear("*.npz", ".*.tmp")
        _write(self.path / "experiment.yaml", experiment.text)
        self._database = self._opened()
        columns = ", ".join(f"{name} {kind}" for name, kind in COLUMNS.items())
        with self._database:
            self._database.execute("CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT)")
            self._database.execute(f"CREATE TABLE runs ({columns})")
        self._note(
            schema_version=str(SCHEMA_VERSION),
            name=experiment.name,
            description=experiment.description,
            common_starts=json.dumps(experiment.common_starts),
            version=version(),
        )
        self._note(seeds=json.dumps(_seeds(experiment)))

    def _go_on(self, experiment: Experiment) -> None:
        if not self.table.is_file():
            raise FolderError("holds no results to go on with; allowed: --force to begin again")
        self._database = self._opened()
        try:
            self._refuse_other(experiment)
            self._clear(".*.tmp")
            self._note(seeds=json.dumps(_seeds(experiment)))
        except BaseException:
            self._database.close()
            raise

    def _refuse_other(self, experiment: Experiment) -> None:
        again = "allowed: another folder, or --force to begin again"
        found = schema_version(self._database)
        if found != str(SCHEMA_VERSION):
            written = "without a version" if found is None else f"of version {found}"
            raise FolderError(
                f"holds results {written}, and this pounce reads version {SCHEMA_VERSION}; {again}"
            )
        if (self.path / "experiment.yaml").read_bytes() != experiment.text:
            raise FolderError(f"holds the results of another experiment; {again}")
        specs = {variant.label: _settings(variant) for variant in experiment.variants}
        rows = self._database.execute("SELECT DISTINCT variant, settings FROM runs")
        for label, settings in rows:
            if specs.get(label, settings) != settings:
                raise FolderError(
                    f"holds runs of {label!r} with other settings, of a preset that has changed"
                    f" since; {again}"
                )

    def _opened(self) -> sqlite3.Connection:
        # A reader, such as the page, may hold the table for a moment.
        return sqlite3.connect(self.table, timeout=30)

    def _note(self, **values: str) -> None:
        with self._database:
            self._database.executemany(
                "INSERT OR REPLACE INTO meta VALUES (?, ?)", list(values.items())
            )

    def _clear(self, *patterns: str) -> None:
        for pattern in patterns:
            for path in self.arrays.glob(pattern):
                path.unlink()


def schema_version(database: sqlite3.Connection) -> str | None:
    """Version of the schema of a results table, None if it has none."""
    with contextlib.suppress(sqlite3.OperationalError):
        row = database.execute("SELECT value FROM meta WHERE key = 'schema_version'").fetchone()
        return None if row is None else str(row[0])
    return None


def version() -> str:
    """Version of this package."""
    try:
        return importlib.metadata.version("pounce-lab")
    except importlib.metadata.PackageNotFoundError:
        return "(not installed)"


def _settings(variant: Variant) -> str:
    return json.dumps(variant.spec.model_dump(mode="json"))


def _seeds(experiment: Experiment) -> list[int]:
    return list(experiment.seeds)


def _write(path: Path, data: bytes) -> None:
    passing = path.with_name(f".{path.name}.tmp")
    passing.write_bytes(data)
    os.replace(passing, path)


def _unwritable(error: OSError) -> FolderError:
    return FolderError(
        f"cannot be written to: {error.strerror or error}; allowed: a folder that can"
    )


# --- All runs ------------------------------------------------------------------------------------


def run_experiment(
    experiment: Experiment,
    folder: Folder,
    workers: int,
    on_progress: Callable[[Progress], object] = lambda _: None,
    stop: threading.Event | None = None,
) -> Outcome:
    """Make all runs of an experiment that its folder does not hold yet.

    Nothing that is as large as a run outlives it, so the memory needed depends on the number of
    workers. A run that fails is noted and does not stop the others. An interrupt stops all runs
    within a moment and goes on to the caller; what is finished by then is kept.

    Args:
        experiment: what to run.
        folder: where its results are.
        workers: threads; the results do not depend on it.
        on_progress: called now and then in the calling thread, and once at the end.
        stop: set to stop all runs; those in flight are lost.

    Raises:
        FolderError: results could no longer be written; all runs were stopped.
    """
    pool = _Pool(experiment, folder, stop)
    n_threads = max(min(workers, pool.total - pool.done_before), 1)
    try:
        with ThreadPoolExecutor(n_threads, thread_name_prefix="run") as executor:
            try:
                threads = [executor.submit(pool.work) for _ in range(n_threads)]
                while not all(thread.done() for thread in threads):
                    pool.collect(_POLL_S)
                    on_progress(pool.progress())
            finally:
                pool.halt.set()
    finally:
        # What was over before an interrupt is kept.
        pool.collect()
    for thread in threads:
        thread.result()
    on_progress(pool.progress())
    return pool.outcome()


class _Pool:
    """Runs still to be made, and what has become of the others; shared by all workers."""

    def __init__(
        self, experiment: Experiment, folder: Folder, stop: threading.Event | None
    ) -> None:
        self.halt = threading.Event()
        self._stop = self.halt if stop is None else stop
        self.total = experiment.n_runs
        self.rows: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._experiment = experiment
        self._folder = folder
        self._finished = folder.finished()
        self._lock = threading.Lock()
        self._began = time.monotonic()
        self._done = self._failed = self._running = self._steps = 0
        self._version = version()
        self._identities = {v.label: identity_of(experiment, v) for v in experiment.variants}
        self._work_total = self._work_done = 0.0
        self.done_before = self.total
        for planned in self._planned():
            self._work_total += planned.work
            self.done_before -= 1
        self._left = self._planned()

    def work(self) -> None:
        """Make one run after another until there is none left."""
        while (planned := self._take()) is not None:
            row = self._row(planned)
            with self._lock:
                self._running -= 1
            if row is not None:
                self.rows.put(row)

    def collect(self, wait_s: float = 0.0) -> None:
        """Write the rows of runs that are over; waits a moment for the first."""
        with contextlib.suppress(queue.Empty):
            row = self.rows.get(timeout=wait_s)
            while True:
                self._folder.write(row)
                self._done += row["status"] == DONE
                self._failed += row["status"] == FAILED
                row = self.rows.get_nowait()

    def progress(self) -> Progress:
        elapsed = time.monotonic() - self._began
        with self._lock:
            share = self._work_done / self._work_total if self._work_total else 1.0
            return Progress(
                total=self.total,
                done=self.done_before + self._done,
                failed=self._failed,
                running=self._running,
                steps=self._steps,
                steps_per_s=self._steps / max(elapsed, 1e-3),
                share=share,
                seconds_left=elapsed * (1 - share) / share if share > 0.001 else None,
            )

    def outcome(self) -> Outcome:
        over = self.done_before + self._done + self._failed
        return Outcome(
            total=self.total,
            done=self.done_before + self._done,
            failed=self._failed,
            steps=self._steps,
            seconds=time.monotonic() - self._began,
            stopped=over < self.total,
        )

    def _goes_on(self) -> bool:
        return not (self.halt.is_set() or self._stop.is_set())

    def _planned(self) -> Iterator[_Planned]:
        for variant, seed in self._experiment.runs():
            key = key_of(variant.label, self._identities[variant.label], seed)
            if key not in self._finished:
                trials = self._experiment.trials_of(variant)
                work = estimated_steps(self._experiment, variant)
                yield _Planned(key, variant, seed, trials, work)

    def _take(self) -> _Planned | None:
        with self._lock:
            planned = next(self._left, None) if self._goes_on() else None
            self._running += planned is not None
            return planned

    def _row(self, planned: _Planned) -> dict[str, Any] | None:
        """The row of one run, its arrays in place; None if it was stopped."""
        variant = planned.variant
        row = {
            "key": planned.key,
            "variant": variant.label,
            "preset": variant.preset,
            "overrides": json.dumps(variant.overrides),
            "settings": _settings(variant),
            "seed": planned.seed,
            "version": self._version,
        }
        began = time.perf_counter()
        try:
            run = self._made(planned)
            if run is None:
                return None
            row |= measured(run)
            self._folder.save(planned.key, run)
            row |= {"status": DONE}
        except FolderError:
            self.halt.set()
            raise
        except Exception as error:  # noqa: BLE001 - whatever it is, it is noted, and others go on
            text = "".join(traceback.format_exception(error))
            row |= {"status": FAILED, "error": text[-_LONGEST_ERROR:]}
        return row | {"seconds": time.perf_counter() - began}

    def _made(self, planned: _Planned) -> Run | None:
        experiment = self._experiment
        before = (0, 0.0)

        def note(run: Run) -> None:
            nonlocal before
            share = run.trial / planned.trials
            if experiment.steps is not None:
                share = max(share, run.step / experiment.steps)
            now = (run.step, planned.work * share)
            with self._lock:
                self._steps += now[0] - before[0]
                self._work_done += now[1] - before[1]
            before = now

        try:
            return made_run(
                planned.variant.spec,
                planned.seed,
                planned.trials,
                experiment.steps,
                experiment.stop,
                note,
                self._goes_on,
            )
        finally:
            with self._lock:
                # A run that ended early, or failed, leaves no work behind.
                self._work_done += planned.work - before[1]


# --- What it would take --------------------------------------------------------------------------


def estimated_steps(experiment: Experiment, variant: Variant) -> int:
    """Steps that one run of a variant may take, roughly.

    By the mean lengths of trials in the standard world, which grow with the grid: long where the
    learner starts out on a random walk, and longest where it may back away from the first trial.
    """
    spec = variant.spec
    usual = 270 if not spec.learner.skills else 110
    if "avoid" in spec.learner.skills and spec.schedule.introduced_at("avoid") == 0:
        usual = 390
    usual *= spec.world.scale
    steps = experiment.trials_of(variant) * min(usual, spec.world.step_limit)
    return int(steps if experiment.steps is None else min(steps, experiment.steps))


def plan(experiment: Experiment, workers: int) -> Plan:
    """What an experiment would take; measures for a moment how fast this machine is."""
    n_seeds = len(experiment.seeds)
    steps = trials = 0
    for variant in experiment.variants:
        one = estimated_steps(experiment, variant)
        steps += one * n_seeds
        limit = experiment.trials_of(variant)
        trials += min(limit, one) * n_seeds
    n_threads = min(workers, experiment.n_runs)
    return Plan(
        variants=len(experiment.variants),
        runs=experiment.n_runs,
        steps=steps,
        seconds=(steps / _pilot(experiment) + experiment.n_runs * _S_PER_RUN) / n_threads,
        disk_bytes=int(experiment.n_runs * _BYTES_PER_RUN + trials * _BYTES_PER_TRIAL),
    )


def _pilot(experiment: Experiment) -> float:
    """Steps a second of one run, the mean over the first variant of each preset."""
    first = {variant.preset: variant for variant in reversed(experiment.variants)}
    rates = [_rate(variant.spec) for variant in itertools.islice(first.values(), _MOST_PILOTS)]
    return math.fsum(rates) / len(rates)


def _rate(spec: RunSpec) -> float:
    run = Run(spec, 0)
    run.advance(max_steps=1, until_trial=MAX_TRIALS)  # may compile
    began, made = time.perf_counter(), 0
    while (elapsed := time.perf_counter() - began) < _PILOT_S:
        made += run.advance(max_steps=50_000, until_trial=MAX_TRIALS)
    return made / elapsed
