"""Running an experiment: which runs are still to be made, and how far it has come.

The thread that calls :func:`run_experiment` hands out tasks to a crew and alone writes what comes
back, so whatever the crew, results are the same.
"""

import json
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import numpy as np

from app.documents.experiments import Experiment
from app.documents.variants import Variant
from app.experiments.archive import checksum
from app.experiments.crews import Crew
from app.experiments.record import Origin, Record, all_values, origin_of
from app.experiments.store import Folder, version
from app.experiments.task import Finished, Kept, Task, tasks_of

_POLL_S = 0.1


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
    """Over the time in which it was not paused."""
    share: float
    """Of all the work, by its estimate, 0 to 1, with what was finished before."""
    seconds_left: float | None
    """None as long as nothing can be said."""


@dataclass(frozen=True)
class Outcome:
    """How an experiment ended."""

    total: int
    done: int
    failed: int
    steps: int
    seconds: float


def run_experiment(
    experiment: Experiment,
    folder: Folder | None,
    crew: Crew,
    on_progress: Callable[[Progress], object] = lambda _: None,
    on_over: Callable[[Record, Finished], object] | None = None,
    kept: Kept = "results",
) -> Outcome:
    """Make all runs of an experiment that its folder does not hold yet.

    Nothing that is as large as a run outlives it, so the memory needed depends on the size of the
    crew. A run that fails is noted and does not stop the others. An interrupt stops all runs
    within a moment and goes on to the caller; what is finished by then is kept.

    Args:
        experiment: what to run.
        folder: where its results are; None if they are written nowhere, and whoever is told of
            them keeps them.
        crew: who makes the runs; the results do not depend on it. Its switch pauses or ends it.
        on_progress: called now and then in the calling thread, and once at the end.
        on_over: called in the calling thread with each run that is over, once it is on disk: its
            record, and what came back of it.
        kept: what comes back of each run beside its numbers; less than results for no folder alone.

    Raises:
        FolderError: results could no longer be written; all runs were stopped.
        CrewError: those who make the runs are lost; what was over before is kept.
    """
    ledger, switch = _Ledger(experiment, folder, on_over, kept), crew.switch
    try:
        with crew:
            while True:
                while not (switch.paused or switch.ended) and crew.busy < 2 * crew.size:
                    task = ledger.next_task()
                    if task is None:
                        break
                    crew.start(task)
                for finished in crew.finished(_POLL_S):
                    ledger.enter(finished)
                ledger.tick(paused=switch.paused)
                if crew.busy == 0 and (ledger.all_handed_out or switch.ended):
                    break
                on_progress(ledger.progress(crew))
    finally:
        # What was over before an interrupt is kept.
        for finished in crew.finished(0.0):
            ledger.enter(finished)
    on_progress(ledger.progress(crew))
    return ledger.outcome()


def record_of(variant: Variant, task: Task, finished: Finished, origin: Origin) -> Record:
    """What is written down of a run that has just come back."""
    return Record(
        key=task.key,
        variant=variant.label,
        preset=variant.preset,
        overrides=variant.overrides,
        settings=json.loads(task.settings),
        seed=task.seed,
        error=finished.error,
        version=version(),
        digest=finished.digest,
        seconds=finished.seconds,
        ended_at=datetime.now(UTC).isoformat(timespec="seconds"),
        values=all_values(finished.values, () if finished.error else task.metrics),
        arrays=checksum(finished.arrays) if finished.arrays else "",
        origin=origin,
    )


class _InFlight(NamedTuple):
    variant: Variant
    task: Task


class _Done(NamedTuple):
    """How much of an experiment is done, in steps."""

    before: float
    """Finished before it was started or resumed."""
    since: float
    left: float


class _Work:
    """What an experiment takes, as far as its runs that are over tell."""

    def __init__(self, experiment: Experiment) -> None:
        variants = experiment.variants
        self._places = {variant.label: place for place, variant in enumerate(variants)}
        self._trials = np.array([experiment.trials_of(variant) for variant in variants], np.float64)
        # By variant: runs that were over before, that are over since then, that are not over; and
        # steps of how many that took any.
        self._before, self._since, self._measured = np.zeros((3, len(variants)), np.int64)
        self._left = np.array([len(experiment.seeds_of(variant)) for variant in variants])
        self._least = experiment.horizon_steps or 0
        self._steps = np.zeros(len(variants))

    def add(self, record: Record, before: bool = False) -> None:
        """Count a run that is over; one that failed has no steps to learn from."""
        place = self._places[record.variant]
        (self._before if before else self._since)[place] += 1
        self._left[place] -= 1
        self._measured[place] += record.steps > 0
        self._steps[place] += record.steps

    def done(self, begun: Iterable[tuple[str, float]]) -> _Done:
        """How far it is.

        Args:
            begun: the variants of runs that are under way, and how much of each is done.
        """
        # Where no run of a variant is over, its trials take what they take in the others.
        trials = self._trials @ self._measured
        means = self._trials * (self._steps.sum() / trials if trials else 1.0)
        means = np.maximum(means, self._least)
        np.divide(self._steps, self._measured, where=self._measured > 0, out=means)
        ahead = sum(share * float(means[self._places[label]]) for label, share in begun)
        before, since, left = (float(means @ n) for n in (self._before, self._since, self._left))
        return _Done(before, since + ahead, left - ahead)


class _Ledger:
    """Which runs are to be made, and what has become of the others."""

    def __init__(
        self,
        experiment: Experiment,
        folder: Folder | None,
        on_over: Callable[[Record, Finished], object] | None,
        kept: Kept,
    ) -> None:
        self.total = experiment.n_runs
        self._folder = folder
        self._origin = origin_of(experiment, Path()) if folder is None else folder.origin
        self._on_over = on_over
        self._kept: Kept = kept
        self._finished: set[str] = set() if folder is None else folder.finished()
        self._work, self._done_before = _Work(experiment), 0
        wanted = {task.key for _, task in tasks_of(experiment)} & self._finished
        for record in () if folder is None or not wanted else folder.records():
            if record.key in wanted:
                self._work.add(record, before=True)
                self._done_before += 1
        self._share = 0.0
        self._left = tasks_of(experiment)
        self._in_flight: dict[str, _InFlight] = {}
        self._handed_out = self._done_before
        self._done = self._failed = self._steps = 0
        self._seconds = 0.0
        self._ticked_at = time.monotonic()

    @property
    def all_handed_out(self) -> bool:
        """Whether there is nothing more to be started."""
        return self._handed_out == self.total

    def next_task(self) -> Task | None:
        """The next run that is to be made; None if there is none left."""
        for variant, task in self._left:
            if task.key not in self._finished:
                self._handed_out += 1
                self._in_flight[task.key] = _InFlight(variant, task)
                return replace(task, kept=self._kept)
        return None

    def enter(self, finished: Finished) -> None:
        """Write down a run that is over: first its arrays, then its row."""
        variant, task = self._in_flight.pop(finished.key)
        record = record_of(variant, task, finished, self._origin)
        if self._folder is not None:
            if finished.arrays:
                self._folder.save(task.key, finished.arrays)
            self._folder.write(record)
        self._done += not record.error
        self._failed += bool(record.error)
        self._steps += record.steps
        # A run that ended early, or failed, leaves no work behind.
        self._work.add(record)
        if self._on_over is not None:
            self._on_over(record, finished)

    def tick(self, paused: bool) -> None:
        """Let the clock go on, unless it stands."""
        now = time.monotonic()
        if not paused:
            self._seconds += now - self._ticked_at
        self._ticked_at = now

    def progress(self, crew: Crew) -> Progress:
        """How far it has come, with what the crew is at."""
        steps, begun = self._steps, list[tuple[str, float]]()
        for key, at in crew.under_way().items():
            if key in self._in_flight:
                variant, task = self._in_flight[key]
                share = min(at.trial / task.trials, 1.0)
                if task.horizon is not None:
                    share = min(share, at.step / task.horizon)
                if task.steps is not None:
                    share = max(share, at.step / task.steps)
                steps += at.step
                begun.append((variant.label, share))
        done, seconds = self._work.done(begun), self._seconds
        # What is known better may make less of what is done; a bar does not go back.
        everything = done.before + done.since + done.left
        self._share = max(self._share, 1 - done.left / everything if everything else 1.0)
        is_known = done.since > 0.001 * done.left
        return Progress(
            total=self.total,
            done=self._done_before + self._done,
            failed=self._failed,
            running=len(begun) or min(crew.busy, crew.size),
            steps=steps,
            steps_per_s=steps / max(seconds, 1e-3),
            share=self._share,
            seconds_left=seconds * done.left / done.since if is_known else None,
        )

    def outcome(self) -> Outcome:
        """How it ended."""
        return Outcome(
            total=self.total,
            done=self._done_before + self._done,
            failed=self._failed,
            steps=self._steps,
            seconds=self._seconds,
        )
