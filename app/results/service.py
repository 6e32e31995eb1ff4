"""Experiments that are run from the page: one at a time, beside the live learner.

A thread of its own hands out the runs and writes them down, as the command line does; whoever
wants to see how far it has come reads the latest :class:`Standing`.
"""

import logging
import threading
from collections.abc import Hashable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, NamedTuple

from app.documents.experiments import Experiment
from app.experiments.archive import ArchiveError
from app.experiments.claims import FolderError, is_free
from app.experiments.cost import Plan, longest_run, plan
from app.experiments.crews import Switch, Threads
from app.experiments.record import Record
from app.experiments.runner import Progress, run_experiment
from app.experiments.store import Folder, finished_in, goes_on
from app.experiments.task import Finished, tasks_of
from app.results.gather import Gatherer
from app.util.texts import as_path

log = logging.getLogger(__name__)

MOST_FOLDERS: Final = 1_000
"""Folders of one name that are looked at before one gives up."""


class BusyError(Exception):
    """An experiment is running already."""


@dataclass(frozen=True)
class Standing:
    """How an experiment stands."""

    experiment: Experiment
    folder: Path
    gatherer: Gatherer
    progress: Progress | None
    """None before the first run was handed out."""
    running: bool
    """Whether it goes on, or waits to; otherwise it is over, or was stopped."""
    paused: bool
    error: str
    """What stopped it; empty if nothing did."""
    damaged: int = 0
    """Runs whose arrays were found damaged or gone, so that they are made again."""


class Quote(NamedTuple):
    """What an experiment would take, and what is there already."""

    plan: Plan
    folder: Path
    is_beside_others: bool = False
    """Whether the folder of its name holds the results of another one, so that it has its own."""


class Service:
    """Runs experiments for the page. All methods may be called from any thread."""

    def __init__(self, root: Path) -> None:
        """Results go into folders below ``root``, which is made when it is needed."""
        self.root = root
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._switch = Switch()
        self._standing: Standing | None = None

    @property
    def standing(self) -> Standing | None:
        """How the latest experiment stands; None if there was none yet."""
        return self._standing

    def quote(self, experiment: Experiment, workers: int, beside: Hashable = None) -> Quote:
        """What an experiment would take; measures for a moment how fast this machine is.

        Args:
            experiment: what would be run.
            workers: runs at a time.
            beside: what goes on beside it; where that changes, it is measured anew.

        Raises:
            FolderError: no folder could be found for it.
        """
        path = folder_for(self.root, experiment)
        return Quote(
            plan(experiment, workers, finished_in(path), beside), path, path.name != experiment.name
        )

    def start(self, experiment: Experiment, workers: int) -> Path:
        """Begin an experiment, or go on with one whose results are there in part.

        Returns:
            The folder of its results.

        Raises:
            BusyError: another one is running.
            FolderError: no folder could be found for it.
        """
        # Of what has a quote it is known, and else takes a moment.
        longest = longest_run(experiment)
        with self._lock:
            # The thread of one that is over may still be ending; it has nothing more to say.
            if self._standing is not None and self._standing.running:
                raise BusyError("another experiment is running: stop it first, or wait")
            path = folder_for(self.root, experiment)
            gatherer = Gatherer(experiment, longest)
            standing = Standing(experiment, path, gatherer, None, True, False, "")
            switch = Switch()
            arguments = (standing, switch, workers)
            thread = threading.Thread(target=self._run, args=arguments, daemon=True)
            thread.start()
            self._standing, self._switch, self._thread = standing, switch, thread
        return path

    def pause(self) -> None:
        """Let all runs wait where they stand."""
        self._switch.pause()
        self._note(paused=self._switch.paused)

    def go_on(self) -> None:
        """Let them go on."""
        self._switch.go_on()
        self._note(paused=False)

    def stop(self) -> None:
        """End the experiment; what is finished is kept, and starting it again goes on there."""
        self._switch.end()

    def wait(self, timeout_s: float | None = None) -> None:
        """Wait until the latest experiment is over and its thread has ended; at once if none began.

        Args:
            timeout_s: the longest to wait, in seconds; None for as long as it takes.
        """
        thread = self._thread
        if thread is not None:
            thread.join(timeout_s)

    def close(self) -> None:
        """End the experiment and wait until it has."""
        self._switch.end()
        self.wait()

    def _note(self, **changes: Any) -> None:
        with self._lock:
            if self._standing is not None and self._standing.running:
                self._standing = replace(self._standing, **changes)

    def _run(self, standing: Standing, switch: Switch, workers: int) -> None:
        experiment, path, gatherer = standing.experiment, standing.folder, standing.gatherer

        def take(record: Record, finished: Finished) -> None:
            gatherer.add(record, finished.arrays)

        error = ""
        try:
            with Folder(path, experiment, goes_on(path, experiment), force=False) as folder:
                self._note(damaged=_take_finished(experiment, folder, gatherer, switch))
                crew = Threads(workers, switch)
                run_experiment(
                    experiment, folder, crew, lambda p: self._note(progress=p), on_over=take
                )
        except FolderError as problem:
            error = f"{path}: {problem}"
        except Exception as problem:
            # Whatever went wrong, the page must say so; what is finished is on disk.
            log.exception("the experiment stopped")
            error = f"{type(problem).__name__}: {problem}"
        self._note(running=False, paused=False, error=error)


def _take_finished(
    experiment: Experiment, folder: Folder, gatherer: Gatherer, switch: Switch
) -> int:
    """Take in the runs of the experiment that the folder holds; returns how many are damaged."""
    wanted = {task.key for _, task in tasks_of(experiment)}
    records = [record for record in folder.records() if record.key in wanted]
    finished = folder.finished()
    n_damaged = sum(record.key not in finished for record in records)
    for record in records:
        if not switch.wanted():
            break
        if record.key in finished:
            try:
                gatherer.add(record, folder.arrays_of(record))
            except ArchiveError as error:
                # A run is a function of its task: what is damaged is made again.
                folder.disown(record.key, str(error))
                n_damaged += 1
    return n_damaged


def folder_for(root: Path, experiment: Experiment) -> Path:
    """Where an experiment's results go: where they are already, or a folder that is free.

    Raises:
        FolderError: there are too many of its name.
    """
    for number in range(1, MOST_FOLDERS + 1):
        name = experiment.name if number == 1 else f"{experiment.name}-{number}"
        path = root / as_path(name)
        try:
            if is_free(path) or goes_on(path, experiment):
                return path
        except NotADirectoryError:
            continue
        except OSError as error:
            raise FolderError(f"{str(path)!r} cannot be used: {error.strerror or error}") from error
    raise FolderError(f"{str(root)!r} holds too many results of {experiment.name}")
