"""The command ``pounce replicate``: everything that the pages on the replication say, from nothing.

Like the command line, it imports what takes long only once it is needed.
"""

import contextlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import arg

from app.cli import terminal
from app.cli.answers import (
    EXIT_FAILED,
    EXIT_OK,
    RESULTS,
    Flag,
    UsageError,
    complain,
    say,
    shown,
    whole_number,
    workers_of,
)
from app.util import interrupts
from app.util.interrupts import ended_by
from app.words.numbers import counted, duration, in_short

if TYPE_CHECKING:
    from app.experiments.runner import Progress
    from app.replication.run import Made

EXAMPLES = (
    "pounce replicate",
    "pounce replicate --docs docs",
    "pounce replicate --seeds 2 --out a-try",
    "pounce replicate --beyond --docs docs",
)

_OUT = f"{RESULTS}/replication"


@dataclass(frozen=True)
class Replicate:
    """Run every experiment of the replication, and report on each."""

    out: Annotated[str, arg(metavar="DIR")] = _OUT
    """Folder that gets a folder of results for each experiment; what is there is gone on with."""
    seeds: Annotated[
        str | None, arg(metavar="N", help_behavior_hint="(default: the experiments')")
    ] = None
    """Run so many seeds of every variant, for a try."""
    workers: Annotated[str | None, arg(metavar="N", help_behavior_hint="(default: all cores)")] = (
        None
    )
    """Runs at a time; makes no difference to their results."""
    force: Flag = False
    """Begin every experiment again; results that are there are lost."""
    beyond: Flag = False
    """Run instead what goes beyond the thesis, and report on that; with --docs its page is
    beyond.md, of which the part that is from the results is written anew."""
    docs: Annotated[str | None, arg(metavar="DIR", help_behavior_hint="(default: none)")] = None
    """Folder of the documentation, in which replication.md with its numbers and figures is written
    anew, and the headline of the README.md beside it."""


def obey(command: Replicate) -> int:
    """Run it all, and say how that ended; returns the exit code.

    Raises:
        UsageError: the words make no sense.
    """
    workers = workers_of(command.workers)
    n_seeds = _n_seeds(command)
    docs = _docs_of(command)
    from app.experiments.crews import CrewError, Threads
    from app.experiments.store import FolderError
    from app.replication import plan
    from app.replication.beyond import write_beyond
    from app.replication.run import make_all
    from app.replication.write import write_docs, write_reports
    from app.results.read import ResultsError

    out, names = Path(command.out), plan.BEYOND if command.beyond else plan.EXPERIMENTS
    try:
        with interrupts.undoing():
            with _progress(names) as tell:
                made = make_all(names, out, lambda: Threads(workers), n_seeds, command.force, tell)
            _say_made(made)
            if made.failed:
                complain("some runs failed, so nothing is reported")
                return EXIT_FAILED
            with terminal.status() as tell_status:
                tell_status("writing reports")
                for page in write_reports(out, workers, names):
                    say(str(page))
                if docs is not None:
                    write = write_beyond if command.beyond else write_docs
                    say(str(write(out, docs, tell_status)))
    except FolderError as error:
        raise UsageError(f"--out: {shown(command.out)} {error}") from error
    except (CrewError, ResultsError, OSError) as error:
        complain(str(error))
        return EXIT_FAILED
    except KeyboardInterrupt as ending:
        said, code = ended_by(ending)
        # Where it was the terminal that went, there is nobody to tell.
        with contextlib.suppress(OSError):
            complain(f"{said}; what is finished is in {command.out}, and the same command goes on")
        return code
    return EXIT_OK


def _n_seeds(command: Replicate) -> int | None:
    from app.documents.experiment_spec import MAX_RUNS

    if command.seeds is None:
        return None
    if command.docs is not None:
        raise UsageError("--seeds and --docs exclude each other; allowed: one of them")
    return whole_number("--seeds", command.seeds, 1, MAX_RUNS)


def _docs_of(command: Replicate) -> Path | None:
    if not command.out or "\0" in command.out:
        raise UsageError(f"--out: {shown(command.out)} is not allowed; allowed: a folder")
    if command.docs is None:
        return None
    from app.replication.page import has_place

    docs = Path(command.docs)
    if command.beyond:
        from app.replication.beyond import PAGES

        pages = [docs / page for page in PAGES]
        if not all(p.is_file() and has_place(p.read_text("utf-8", "replace")) for p in pages):
            raise UsageError(
                f"--docs: {shown(command.docs)} is not allowed; allowed: a folder with"
                f" {' and '.join(PAGES)} in it that have a place for what came out"
            )
        return docs
    readme = docs.parent / "README.md"
    is_docs = (docs / "replication.md").is_file() and readme.is_file()
    if not is_docs or not has_place(readme.read_text("utf-8", "replace")):
        raise UsageError(
            f"--docs: {shown(command.docs)} is not allowed; allowed: a folder with a replication.md"
            " in it, and beside it a README.md with a place for its headline"
        )
    return docs


@contextlib.contextmanager
def _progress(names: Sequence[str]) -> "Iterator[Callable[[str, Progress], None]]":
    """What shows the progress on a terminal; nothing where there is none."""
    with terminal.progress_bar(len(names), len(names)) as show:

        def tell(name: str, progress: "Progress") -> None:
            before = names.index(name)
            show(
                before + progress.share,
                f"{name} ({before + 1}/{len(names)}): {progress.done}/{progress.total} runs",
                f"{progress.steps_per_s / 1e6:.1f} M steps/s",
            )

        yield tell


def _say_made(made: "Made") -> None:
    runs, failed = counted(made.runs, "run"), f", {made.failed:,} failed" if made.failed else ""
    say(f"{runs}{failed}, {in_short(made.steps)} steps in {duration(made.seconds)}")
