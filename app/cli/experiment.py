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

from app.cli import terminal
from app.cli.answers import (
    EXIT_FAILED,
    EXIT_OK,
    HIDDEN_HINT,
    RESULTS,
    Flag,
    UsageError,
    WrongPresetError,
    complain,
    say,
    shown,
    whole_number,
    workers_of,
)
from app.util import interrupts
from app.util.interrupts import ended_by
from app.util.texts import as_path, as_text
from app.words.numbers import counted, duration, in_short, megabytes

if TYPE_CHECKING:
    from app.documents import experiments
    from app.experiments.crews import Crew
    from app.experiments.runner import Outcome, Progress
    from app.experiments.store import Folder

EXAMPLES = (
    "pounce experiment figure_4_1",
    "pounce experiment timing_plane --seeds 3 --dry-run",
    "pounce experiment my-experiment.yaml --out results --resume",
    "pounce experiment figure_4_2 --cluster tcp://HOST:8786",
)

_SCHEMES = ("tcp", "tls")


@dataclass(frozen=True)
class Experiment:
    """Make all runs of an experiment on all cores, into a folder of results."""

    experiment: Annotated[
        Positional[str], arg(metavar="EXPERIMENT", help_behavior_hint=HIDDEN_HINT)
    ] = ""
    """A shipped experiment, or a file; - is standard input."""
    seeds: Annotated[
        str | None, arg(metavar="N", help_behavior_hint="(default: the experiment's)")
    ] = None
    """Run N seeds, counting up from the experiment's first."""
    workers: Annotated[str | None, arg(metavar="N", help_behavior_hint="(default: all cores)")] = (
        None
    )
    """Runs at a time; makes no difference to their results."""
    cluster: Annotated[
        str | None, arg(metavar="ADDRESS", help_behavior_hint="(default: this machine)")
    ] = None
    """Make the runs on the Dask cluster at tcp://HOST:PORT; the same results."""
    out: Annotated[
        str | None, arg(metavar="DIR", help_behavior_hint=f"(default: {RESULTS}/NAME)")
    ] = None
    """Folder of the results."""
    resume: Flag = False
    """Go on where an earlier call ended; no run is made twice, and a report on fewer runs goes."""
    salvage: Flag = False
    """Go on where results.sqlite is damaged, with those of its rows that are whole; the damaged one
    stays as damaged.sqlite."""
    force: Flag = False
    """Begin again in a folder that holds results, which are lost, as is a report on them."""
    dry_run: Flag = False
    """Print what it would take, and run nothing; refuses what would be refused."""
    json: Flag = False
    """Print one JSON object and nothing else; what is wrong goes to stderr, with exit code 2."""


def obey(command: Experiment) -> int:
    """Make the runs and say how that ended; returns the exit code.

    Raises:
        UsageError: the words make no sense.
    """
    workers = workers_of(command.workers)
    _check(command)
    experiment = _wanted(command)
    # The crew before the folder, of which --force clears what is there.
    with _crew_of(command.cluster, workers) as crew:
        if command.dry_run:
            say(_planned(command, experiment, crew.size))
            return EXIT_OK
        if command.cluster is None:
            _prepare(experiment)
        with interrupts.undoing():
            return _carry_out(command, experiment, crew)


def _check(command: Experiment) -> None:
    """Refuse words that make no sense, whatever the experiment is."""
    if command.cluster is not None and command.workers is not None:
        raise UsageError("--cluster and --workers exclude each other; allowed: one of them")
    if command.out is not None and not command.out:
        raise UsageError("--out: '' is not allowed; allowed: a folder")
    ways = [f"--{way}" for way in ("resume", "salvage", "force") if getattr(command, way)]
    if len(ways) > 1:
        raise UsageError(f"{' and '.join(ways)} exclude each other; allowed: one of them")
    if command.cluster is not None and not _is_address(command.cluster):
        raise UsageError(
            f"--cluster: {shown(command.cluster)} is not allowed; allowed: tcp://HOST:PORT of a"
            " running Dask scheduler, or tls://HOST:PORT"
        )


def _wanted(command: Experiment) -> "experiments.Experiment":
    """The experiment that is asked for."""
    from app.documents import experiments
    from app.documents.experiment_spec import MAX_RUNS

    n_seeds = None
    if command.seeds is not None:
        n_seeds = whole_number("--seeds", command.seeds, 1, MAX_RUNS)
    if not command.experiment:
        names = ", ".join(experiments.shipped())
        raise UsageError(f"EXPERIMENT is missing; allowed: {names}, or a file")
    try:
        return experiments.load(command.experiment, n_seeds)
    except experiments.ExperimentError as error:
        raise WrongPresetError(str(error)) from error


def _prepare(experiment: "experiments.Experiment") -> None:
    from app.experiments.task import prepare

    prepare(experiment.metrics)


def _carry_out(command: Experiment, experiment: "experiments.Experiment", crew: "Crew") -> int:
    """Make all runs, showing the progress on a terminal; returns the exit code."""
    from app.experiments.crews import CrewError
    from app.experiments.runner import run_experiment
    from app.experiments.store import FolderError

    with _folder_of(command, experiment) as folder:
        try:
            _say_lost(folder)
            with _progress(experiment.n_runs) as on_progress:
                outcome = run_experiment(experiment, folder, crew, on_progress)
            said = _report(command, experiment, folder, outcome)
        except FolderError as error:
            complain(f"{shown(as_text(folder.path))} {error}")
            return EXIT_FAILED
        except CrewError as error:
            complain(f"{shown(command.cluster)} {error}" if command.cluster else str(error))
            return EXIT_FAILED
        except KeyboardInterrupt as ending:
            said, code = ended_by(ending)
            # Where it was the terminal that went, there is nobody to tell.
            with contextlib.suppress(OSError):
                where = as_text(folder.path)
                complain(f"{said}; what is finished is in {where}, and --resume goes on")
            return code
    say(said)
    return EXIT_FAILED if outcome.failed else EXIT_OK


def _say_lost(folder: "Folder") -> None:
    """Say which runs are to be made again, if any are."""
    lost = folder.lost()
    if lost:
        runs = counted(len(lost), "run")
        complain(f"the arrays of {runs} in {as_text(folder.path)} are damaged or gone: made again")


def _is_address(text: str) -> bool:
    """Whether a text can be the address of a Dask scheduler: ``tcp://HOST:PORT``, or ``tls://``."""
    try:
        found = urlsplit(text)
        is_whole = found.hostname and found.port and found.username is None
    except ValueError:
        return False
    return (
        bool(is_whole) and text == f"{found.scheme}://{found.netloc}" and found.scheme in _SCHEMES
    )


def _crew_of(address: str | None, workers: int) -> "Crew":
    """Those who make the runs: so many threads of this machine, or the cluster at an address."""
    from app.experiments.crews import ClusterError, Threads

    if address is None:
        return Threads(workers)
    if importlib.util.find_spec("distributed") is None:
        raise UsageError(
            f"--cluster: {shown(address)} needs a package that is missing:"
            " pip install 'pounce-lab[cluster]'"
        )
    from app.experiments.cluster import Cluster

    try:
        return Cluster(address)
    except ClusterError as error:
        raise UsageError(f"--cluster: {shown(address)} {error}") from error


def _path_of(command: Experiment, experiment: "experiments.Experiment") -> Path:
    """Where the results go."""
    if command.out is None:
        return Path(RESULTS, as_path(experiment.name))
    return Path(command.out)


def _folder_of(command: Experiment, experiment: "experiments.Experiment") -> "Folder":
    """The folder of the results, claimed."""
    from app.experiments.store import Folder, FolderError

    path = _path_of(command, experiment)
    try:
        return Folder(path, experiment, command.resume, command.force, command.salvage)
    except FolderError as error:
        raise UsageError(f"--out: {str(path)!r} {error}") from error


def _planned(command: Experiment, experiment: "experiments.Experiment", workers: int) -> str:
    """What an experiment would take, in words or as JSON."""
    from app.experiments.cost import plan
    from app.experiments.store import FolderError, finished_if_claimed

    path = _path_of(command, experiment)
    try:
        ways = command.resume, command.force, command.salvage
        finished = finished_if_claimed(path, experiment, *ways)
    except FolderError as error:
        raise UsageError(f"--out: {str(path)!r} {error}") from error
    found = plan(experiment, workers, finished)
    if command.json:
        document = {"experiment": experiment.name, **found._asdict(), "workers": workers}
        return json.dumps(document)
    about = "at most about" if found.at_most else "about"
    there = f"; {found.done:,} are done" if found.done else ""
    drawn = f", {found.drawn:,} drawn at random" if found.drawn else ""
    return (
        f"{experiment.name}: {found.runs:,} runs ({found.variants:,} variants{drawn},"
        f" {experiment.seeds_in_words}{there})\n"
        f"  steps  {about} {in_short(found.steps)}\n"
        f"  time   {_lasting(found.seconds, about)} with {workers} at a time\n"
        f"  disk   {about} {megabytes(found.disk_bytes)}"
    )


def _lasting(seconds: float, about: str = "") -> str:
    """A time in words; nothing takes none."""
    return "less than a second" if seconds < 1 else f"{about} {duration(seconds)}".strip()


def _report(
    command: Experiment,
    experiment: "experiments.Experiment",
    folder: "Folder",
    outcome: "Outcome",
) -> str:
    """How an experiment ended, in words or as JSON."""
    if command.json:
        document = {
            "experiment": experiment.name,
            "folder": as_text(folder.path),
            "runs": outcome.total,
            "done": outcome.done,
            "failed": outcome.failed,
            "steps": outcome.steps,
            "seconds": round(outcome.seconds, 3),
        }
        return json.dumps(document)
    lines = [
        f"{experiment.name}: {outcome.done:,} of {outcome.total:,} runs done,"
        f" {in_short(outcome.steps)} steps in {_lasting(outcome.seconds)}",
        f"results in {as_text(folder.path)}",
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
