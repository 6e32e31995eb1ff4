"""The command ``pounce report``: a page on results, from the words of a command line."""

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from app.experiment_cli import RESULTS

EXIT_OK = 0
EXIT_FAILED = 1
EXIT_USAGE = 2

_HIDDEN_HINT = ""


@dataclass(frozen=True)
class Report:
    """Write a page on the results of experiments, with figures and findings."""

    folders: Annotated[
        Positional[tuple[str, ...]], arg(metavar="[DIR ...]", help_behavior_hint=_HIDDEN_HINT)
    ] = ()
    """Folders that pounce experiment has written; several are taken together. Without any, the
    latest one in results."""
    compare: Annotated[bool, arg(help_behavior_hint=_HIDDEN_HINT)] = False
    """Set the second of two folders against the first."""
    out: Annotated[
        str | None, arg(metavar="FILE", help_behavior_hint="(default: DIR/report.html)")
    ] = None
    """The page; its figures go into a folder beside it."""


EXAMPLES = (
    "pounce report",
    "pounce report results/figure_4_1",
    "pounce report results-4-1 results-4-2 results-4-3 --out replication.html",
    "pounce report before after --compare",
)


def report(command: Report) -> int:
    """Write the page and say where it is; returns the exit code."""
    if not command.folders and not command.compare:
        latest = latest_results(Path(RESULTS))
        command = replace(command, folders=() if latest is None else (str(latest),))
    problem = _problem(command)
    if problem:
        return _refuse(problem, EXIT_USAGE)
    # Here, so that the lab starts without the libraries that draw.
    from app.readout import ResultsError
    from app.report import write_report

    out = None if command.out is None else Path(command.out)
    try:
        page = write_report([Path(folder) for folder in command.folders], out, command.compare)
    except ResultsError as error:
        return _refuse(str(error), EXIT_FAILED)
    sys.stdout.write(f"{page}\n")
    return EXIT_OK


def latest_results(root: Path) -> Path | None:
    """The folder of results below a folder that was written to last; None if there is none."""
    tables = [table for table in root.glob("*/results.sqlite") if table.is_file()]
    latest = max(tables, key=lambda table: table.stat().st_mtime_ns, default=None)
    return None if latest is None else latest.parent


def _problem(command: Report) -> str:
    """What makes no sense in the words; empty if they do."""
    if command.compare and len(command.folders) != 2:
        return f"--compare: {len(command.folders)} folders were given; allowed: two"
    if not command.folders:
        return (
            f"DIR is missing, and there are no results in {RESULTS!r}; allowed: a folder that"
            " pounce experiment has written"
        )
    if not all(command.folders):
        return "DIR: '' is not allowed; allowed: a folder that pounce experiment has written"
    if any("\0" in path for path in (*command.folders, command.out or "")):
        return "DIR and --out: a path contains a NUL character; allowed: paths"
    if command.out is not None:
        # A page that took the place of results, or of an experiment, would be a loss.
        if Path(command.out).suffix.lower() not in (".html", ".htm"):
            return f"--out: {command.out!r} is not allowed; allowed: a file that ends in .html"
        if Path(command.out).is_dir():
            return f"--out: {command.out!r} is a folder; allowed: a file that ends in .html"
    return ""


def _refuse(message: str, code: int) -> int:
    sys.stderr.write(message + "\n")
    return code
