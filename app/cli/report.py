"""The command ``pounce report``: a page on results, from the words of a command line."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from app.cli import terminal
from app.cli.answers import (
    EXIT_OK,
    HIDDEN_HINT,
    RESULTS,
    Flag,
    UsageError,
    complain,
    say,
    shown,
)
from app.util import interrupts

EXAMPLES = (
    "pounce report",
    "pounce report results/figure_4_1",
    "pounce report results-4-1 results-4-2 results-4-3 --out replication.html",
    "pounce report before after --compare",
)


@dataclass(frozen=True)
class Report:
    """Write a page on the results of experiments, with figures and findings."""

    folders: Annotated[
        Positional[tuple[str, ...]], arg(metavar="[DIR ...]", help_behavior_hint=HIDDEN_HINT)
    ] = ()
    """Folders that pounce experiment has written; several are taken together. Without any, the
    latest one in results."""
    compare: Flag = False
    """Set the second of two folders against the first."""
    out: Annotated[
        str | None, arg(metavar="FILE", help_behavior_hint="(default: DIR/report.html)")
    ] = None
    """The page; its figures go into a folder beside it. Of several folders A and B the default is
    report_A_B/report.html beside A, with --compare compare_A_B/report.html."""


def obey(command: Report) -> int:
    """Write the page and say where it is; returns the exit code.

    Raises:
        UsageError: the words make no sense.
    """
    if not command.folders and not command.compare:
        latest = latest_results(Path(RESULTS))
        command = replace(command, folders=() if latest is None else (str(latest),))
    _check(command)
    # Here, so that the lab starts without the libraries that draw.
    from app.report.write import write_report
    from app.results.read import ResultsError

    out = None if command.out is None else Path(command.out)
    folders = [Path(folder) for folder in command.folders]
    try:
        with interrupts.undoing(), terminal.status() as tell:
            written = write_report(folders, out, command.compare, tell)
    except ResultsError as error:
        raise UsageError(str(error)) from error
    for warning in written.warnings:
        complain(warning)
    say(str(written.page))
    return EXIT_OK


def latest_results(root: Path) -> Path | None:
    """The folder of results below a folder that was written to last; None if there is none."""
    tables = [table for table in root.glob("*/results.sqlite") if table.is_file()]
    # An empty one was begun and has nothing to report.
    begun = [table for table in tables if table.stat().st_size]
    latest = max(begun, key=lambda table: table.stat().st_mtime_ns, default=None)
    return None if latest is None else latest.parent


def _check(command: Report) -> None:
    """Refuse words that make no sense."""
    if command.compare and len(command.folders) != 2:
        raise UsageError(f"--compare: {len(command.folders)} folders were given; allowed: two")
    if not command.folders:
        raise UsageError(
            f"DIR is missing, and there are no results in {RESULTS!r}; allowed: a folder that"
            " pounce experiment has written"
        )
    if not all(command.folders):
        raise UsageError(
            "DIR: '' is not allowed; allowed: a folder that pounce experiment has written"
        )
    if any("\0" in path for path in (*command.folders, command.out or "")):
        raise UsageError("DIR and --out: a path contains a NUL character; allowed: paths")
    if command.out is not None:
        # A page that took the place of results, or of an experiment, would be a loss.
        out = shown(command.out)
        if Path(command.out).suffix.lower() not in (".html", ".htm"):
            raise UsageError(f"--out: {out} is not allowed; allowed: a file that ends in .html")
        if Path(command.out).is_dir():
            raise UsageError(f"--out: {out} is a folder; allowed: a file that ends in .html")
