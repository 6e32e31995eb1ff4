"""Many seeds of one preset on all cores, without a page, and what is written of them."""

import contextlib
import json
import math
import os
import shutil
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from app.analysis import estimates
from app.experiments.task import made_run
from app.util import csv_texts, leftovers
from app.util.folders import make_folders, remove_folders
from learners import measures
from learners.kernel.state import digest, tables
from learners.run import Run
from learners.spec import RunSpec

_POLL_S = 0.1
_STAGING = leftovers.NAME + "[a-z0-9_]" * 8
"""What folders are called that Python makes up a name for, after the same beginning."""


@dataclass(frozen=True)
class RunResult:
    """What is kept of a run once it is over."""

    seed: int
    trials: int
    steps: int
    seconds: float
    """Wall-clock time."""
    captures: int
    flights: int
    timeouts: int
    mean_reward_last_2000: float
    curve: measures.Curve
    """Over windows of 100,000 steps."""
    phases: np.ndarray
    """(window,) float64: mean reward in each window of ``PHASE_STEPS`` of
    :mod:`app.analysis.estimates` that it went through wholly; NaN where no trial ended."""
    digest: str

    def as_json(self) -> dict[str, Any]:
        """As plain data, for JSON: where no trial ended in a window its reward is None."""
        return {
            "seed": self.seed,
            "trials": self.trials,
            "steps": self.steps,
            "seconds": round(self.seconds, 3),
            "captures": self.captures,
            "flights": self.flights,
            "timeouts": self.timeouts,
            "mean_reward_last_2000": self.mean_reward_last_2000,
            "curve": {
                "steps": self.curve.steps.tolist(),
                "reward": [None if math.isnan(r) else r for r in self.curve.reward.tolist()],
            },
            "digest": self.digest,
        }


class Progress(NamedTuple):
    """How far all runs together have come."""

    runs: int
    """Runs that are over."""
    trials: int
    steps: int


class SeedFailedError(RuntimeError):
    """The run of a seed raised an exception, which is this one's cause."""

    def __init__(self, seed: int, cause: Exception) -> None:
        self.seed = seed
        super().__init__(f"the run of seed {seed} failed: {type(cause).__name__}: {cause}")


class OutputError(Exception):
    """Results cannot be written there; the message says why."""


def summary(preset: str, spec: RunSpec, results: Sequence[RunResult]) -> dict[str, Any]:
    """All there is to say about the runs of a preset, as plain data."""
    return {
        "preset": preset,
        "settings": spec.model_dump(mode="json"),
        "runs": [result.as_json() for result in results],
    }


def as_json(document: dict[str, Any]) -> str:
    """A summary as one JSON object on one line."""
    return json.dumps(document, allow_nan=False)


def run_seeds(
    spec: RunSpec,
    seeds: Sequence[int],
    workers: int,
    on_progress: Callable[[Progress], None] = lambda _: None,
    on_finished: Callable[[Run], object] = lambda _: None,
) -> list[RunResult]:
    """Run a preset once for each seed; results come in the order of the seeds.

    Nothing that is as large as a run outlives it, so the memory needed depends on the number of
    workers and not on that of seeds. An interrupt stops all runs within a moment and goes on to
    the caller.

    Args:
        spec: the preset.
        seeds: one for each run.
        workers: threads; the result does not depend on it.
        on_progress: called now and then in the calling thread, and once at the end.
        on_finished: called with each run as it ends, in the thread that ran it.

    Raises:
        SeedFailedError: a run failed, or what was to be done as it ended; the others were stopped.
    """
    pool = _Pool(spec, seeds, on_finished)
    n_threads = min(workers, len(seeds))
    with ThreadPoolExecutor(n_threads, thread_name_prefix="run") as executor:
        try:
            pending = {executor.submit(pool.work) for _ in range(n_threads)}
            while pending:
                done, pending = wait(pending, timeout=_POLL_S, return_when=FIRST_EXCEPTION)
                for worker in done:
                    worker.result()
                on_progress(pool.progress())
        finally:
            pool.stop.set()
    return pool.results()


class _Pool:
    """Seeds still to run, and what the workers have found; shared by all of them."""

    def __init__(
        self, spec: RunSpec, seeds: Sequence[int], on_finished: Callable[[Run], object]
    ) -> None:
        self.stop = threading.Event()
        self._spec = spec
        self._seeds = seeds
        self._on_finished = on_finished
        self._lock = threading.Lock()
        self._next = 0
        self._results: dict[int, RunResult] = {}
        self._trials = 0
        self._steps = 0

    def work(self) -> None:
        """Run one seed after another until there is none left."""
        while (index := self._take()) is not None:
            seed = self._seeds[index]
            try:
                result = self._result(seed)
            except Exception as error:
                raise SeedFailedError(seed, error) from error
            if result is not None:
                with self._lock:
                    self._results[index] = result

    def progress(self) -> Progress:
        with self._lock:
            return Progress(len(self._results), self._trials, self._steps)

    def results(self) -> list[RunResult]:
        return [self._results[index] for index in range(len(self._seeds))]

    def _take(self) -> int | None:
        with self._lock:
            if self.stop.is_set() or self._next == len(self._seeds):
                return None
            self._next += 1
            return self._next - 1

    def _result(self, seed: int) -> RunResult | None:
        """The result of one run, or None if it was stopped."""
        began = time.perf_counter()
        trials = steps = 0

        def note(run: Run) -> None:
            nonlocal trials, steps
            with self._lock:
                self._trials += run.trial - trials
                self._steps += run.step - steps
            trials, steps = run.trial, run.step

        run = made_run(
            self._spec,
            seed,
            self._spec.trials,
            on_progress=note,
            wanted=lambda: not self.stop.is_set(),
        )
        if run is None:
            return None
        result = _result(run, time.perf_counter() - began)
        self._on_finished(run)
        return result


def _result(run: Run, seconds: float) -> RunResult:
    state = run.state
    done = measures.trials_done(state)
    reward, steps = state.log_reward[:done], state.log_steps[:done]
    endings = measures.endings(state)
    return RunResult(
        seed=run.seed,
        trials=run.trial,
        steps=run.step,
        seconds=seconds,
        captures=endings.captures,
        flights=endings.flights,
        timeouts=endings.timeouts,
        mean_reward_last_2000=measures.mean_reward(state),
        curve=measures.curve(state),
        phases=estimates.windowed(reward, steps, estimates.PHASE_STEPS, "steps"),
        digest=digest(state),
    )


class Output:
    """The result files of the runs of a preset, each of them whole, ``NAME.json`` last.

    They are written to a hidden folder beside their final places first, and moved there one after
    the other when everything is complete: where ``NAME.json`` is, the others are. Used as a
    context, which removes that folder, and the folders that had to be made if nothing came to lie
    in them. What was killed before it could do so is cleared away by the next one.
    """

    def __init__(self, folder: Path, name: str, seeds: Iterable[int], overwrite: bool) -> None:
        """Claim the place before any work is done.

        Raises:
            OutputError: the folder cannot be written to, or holds results of that name already.
        """
        self._folder = folder
        self._name = name
        self._tables = {seed: f"{name}-seed{seed}.npz" for seed in seeds}
        try:
            made = make_folders(folder)
        except OSError as error:
            raise _unwritable(error) from error
        with contextlib.ExitStack() as stack:
            stack.callback(remove_folders, made)
            try:
                self._refuse_taken(overwrite)
                leftovers.clear(folder, _STAGING)
                self._staging = stack.enter_context(_staging_in(folder))
            except OSError as error:
                raise _unwritable(error) from error
            self._stack = stack.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self._stack.close()

    @property
    def files(self) -> tuple[Path, ...]:
        """All result files, in the order in which they are moved into place."""
        names = [*self._tables.values(), f"{self._name}.csv", f"{self._name}.json"]
        return tuple(self._folder / name for name in names)

    def save_tables(self, run: Run) -> None:
        """Put the final tables of a run by."""
        arrays: dict[str, Any] = tables(run.spec, run.state)
        np.savez_compressed(self._staging / self._tables[run.seed], **arrays)

    def commit(self, document: dict[str, Any], results: Iterable[RunResult]) -> None:
        """Write the rest and move everything into place.

        Raises:
            OutputError: it could not be written.
        """
        try:
            self._write_curves(results)
            json_file = self._staging / f"{self._name}.json"
            json_file.write_text(as_json(document) + "\n", encoding="utf-8")
            for target in self.files:
                os.replace(self._staging / target.name, target)
        except OSError as error:
            raise _unwritable(error) from error

    def _write_curves(self, results: Iterable[RunResult]) -> None:
        rows: list[Sequence[Any]] = [("seed", "steps", "reward")]
        for result in results:
            steps, reward = result.curve.steps.tolist(), result.curve.reward.tolist()
            rows += [(result.seed, *point) for point in zip(steps, reward, strict=True)]
        path = self._staging / f"{self._name}.csv"
        path.write_bytes(csv_texts.for_programs(rows).encode())

    def _refuse_taken(self, overwrite: bool) -> None:
        taken = [path for path in self.files if _exists(path)]
        if not overwrite and taken:
            others = f" and {len(taken) - 1} more" if len(taken) > 1 else ""
            raise OutputError(
                f"has results of that name already: {taken[0].name}{others};"
                " allowed: another folder, or --force to replace them"
            )
        for path in taken:
            if path.is_dir():
                raise OutputError(
                    f"holds a folder where a result belongs: {path.name}; allowed: another folder"
                )


@contextlib.contextmanager
def _staging_in(folder: Path) -> Iterator[Path]:
    """A hidden folder that is removed in the end, and that nobody else takes for a left one.

    Raises:
        OSError: it cannot be made.
    """
    while True:
        staging = Path(tempfile.mkdtemp(prefix=leftovers.NAME, dir=folder))
        try:
            file = os.open(staging, os.O_RDONLY)
        except FileNotFoundError:
            continue
        try:
            if leftovers.hold(file, staging):
                yield staging
                return
        finally:
            shutil.rmtree(staging, ignore_errors=True)
            os.close(file)


def _unwritable(error: OSError) -> OutputError:
    return OutputError(
        f"cannot be written to: {error.strerror or error}; allowed: a folder that can"
    )


def _exists(path: Path) -> bool:
    # Unlike Path.exists, this does not take a name that is too long for one that is free.
    try:
        path.lstat()
    except FileNotFoundError:
        return False
    return True
