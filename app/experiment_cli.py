"""The command ``pounce experiment``: its words, its progress and its answers.

Like the command line, it imports what takes long only once it is needed.
"""

import contextlib
import importlib.util
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated
from urllib.parse import urlsplit

from tyro.conf import Positional, arg

from app import terminal
from app.machine import duration

if TYPE_CHECKING:
    from app import experiments
    from app.laboratory import Crew, Outcome, Progress
    from app.results import Folder

RESULTS = "results"
"""Folder of the results of experiments that are not told where to put them."""

_SCHEMES = ("tcp", "tls")
_HIDDEN_HINT = ""
_Flag = Annotated[bool, arg(help_behavior_hint=_HIDDEN_HINT)]


@dataclass(frozen=True)
class Experiment:
    """Make all runs of an experiment on all cores, into a folder of results."""

    experiment: Annotated[
        Positional[str], arg(metavar="EXPERIMENT", help_behavior_hint=_HIDDEN_HINT)
    ] = ""
    """A shipped experiment, or a file."""
    seeds: Annotated[
        str | None, arg(metavar="N", help_behavior_hint="(default: the experiment's)")
    ] = None
    """Run seeds 0 to N-1."""
    workers: Annotated[str | None, arg(metavar="N", help_behavior_hint="(default: all cores)")] = (
        None
    )
    """Runs at a time; makes no difference to their results."""
    cluster: Annotated[
        str | None, arg(metavar="ADDRESS", help_behavior_hint="(default: this machine)")
    ] = None
    """Make the runs on the Dask cluster at tcp://HOST:PORT; the same results."""
    out: Annotated[str | None, arg(metavar="DIR", help_behavior_hint="(default: results/NAME)")] = (
        None
    )
    """Folder of the results."""
    resume: _Flag = False
    """Go on where an earlier call ended; no run is made twice."""
    force: _Flag = False
    """Begin again in a folder that holds results, which are lost."""
    dry_run: _Flag = False
    """Print what it would take, and run nothing."""
    json: _Flag = False
    """Print one JSON object and nothing else."""


def wanted(command: Experiment, n_seeds: int | None) -> "experiments.Experiment":
    """The experiment that is asked for.

    Raises:
        ExperimentError: it cannot be run.
    """
    from app import experiments

    return experiments.load(command.experiment, n_seeds)


def is_address(text: str) -> bool:
    """Whether a text can be the address of a Dask scheduler: ``tcp://HOST:PORT``, or ``tls://``."""
    try:
        found = urlsplit(text)
        is_whole = found.hostname and found.port and found.username is None
    except ValueError:
        return False
    return (
        bool(is_whole) and text == f"{found.scheme}://{found.netloc}" and found.scheme in _SCHEMES
    )


def crew_of(address: str | None, workers: int) -> "Crew":
    """Those who make the runs: so many threads of this machine, or the cluster at an address.

    Raises:
        ClusterError: the cluster cannot be used.
    """
    from app.laboratory import ClusterError, Threads

    if address is None:
        return Threads(workers)
    if importlib.util.find_spec("distributed") is None:
        raise ClusterError("needs a package that is missing: pip install 'pounce-lab[cluster]'")
    from app.cluster import Cluster

    return Cluster(address)


def path_of(command: Experiment, experiment: "experiments.Experiment") -> Path:
    """Where the results go."""
    return Path(RESULTS, experiment.name) if command.out is None else Path(command.out)


def folder_of(command: Experiment, experiment: "experiments.Experiment") -> "Folder":
    """The folder of the results, claimed.

    Raises:
        FolderError: it cannot be used; the message names it.
    """
    from app.results import Folder, FolderError

    path = path_of(command, experiment)
    try:
        return Folder(path, experiment, command.resume, command.force)
    except FolderError as error:
        raise FolderError(f"--out: {str(path)!r} {error}") from error


def planned(command: Experiment, experiment: "experiments.Experiment", workers: int) -> str:
    """What an experiment would take, in words or as JSON.

    Raises:
        FolderError: what is done cannot be read.
    """
    from app.cost import plan
    from app.results import finished_in

    finished = finished_in(path_of(command, experiment)) if command.resume else set()
    found = plan(experiment, workers, finished)
    if command.json:
        document = {"experiment": experiment.name, **found._asdict(), "workers": workers}
        return json.dumps(document)
    there = f"; {found.done:,} are done" if found.done else ""
    return (
        f"{experiment.name}: {found.runs:,} runs ({found.variants:,} variants,"
        f" {len(experiment.seeds):,} seeds{there})\n"
        f"  steps  about {found.steps / 1e6:,.0f} M\n"
        f"  time   about {duration(found.seconds)} with {workers} at a time\n"
        f"  disk   about {found.disk_bytes / 1e6:,.1f} MB"
    )


def carried_out(experiment: "experiments.Experiment", folder: "Folder", crew: "Crew") -> "Outcome":
    """Make all runs, showing the progress on a terminal.

    Raises:
        FolderError: results could no longer be written.
        ClusterError: the cluster was lost.
    """
    from app.laboratory import run_experiment

    with _progress(experiment.n_runs) as on_progress:
        return run_experiment(experiment, folder, crew, on_progress)


def report(
    command: Experiment,
    experiment: "experiments.Experiment",
    folder: "Folder",
    outcome: "Outcome",
) -> str:
    """How an experiment ended, in words or as JSON."""
    if command.json:
        document = {
            "experiment": experiment.name,
            "folder": str(folder.path),
            "runs": outcome.total,
            "done": outcome.done,
            "failed": outcome.failed,
            "steps": outcome.steps,
            "seconds": round(outcome.seconds, 3),
        }
        return json.dumps(document)
    lines = [
        f"{experiment.name}: {outcome.done:,} of {outcome.total:,} runs done,"
        f" {outcome.steps / 1e6:,.0f} M steps in {duration(outcome.seconds)}",
        f"results in {folder.path}",
    ]
    if outcome.failed:
        lines.append(f"{outcome.failed:,} runs failed; the first: {folder.first_error()}")
    return "\n".join(lines)


@contextlib.contextmanager
def _progress(n_runs: int) -> "Iterator[Callable[[Progress], None]]":
    """What shows the progress on a terminal; nothing where there is none."""
    with terminal.progress_bar(1.0, n_runs) as show:

        def tell(progress: "Progress") -> None:
            failed = f", {progress.failed} failed" if progress.failed else ""
            left = progress.seconds_left
            ending = "" if left is None else f", {duration(left)} left"
            show(
                progress.share,
                f"{progress.done}/{n_runs} runs, {progress.running} running{failed}",
                f"{progress.steps_per_s / 1e6:.1f} M steps/s{ending}",
            )

        yield tell
