"""Reports on the experiments of the replication, and its pages in the documentation."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Final

from app.experiments.store import REPORT_PAGE, figures_of
from app.replication.numbers import found_in
from app.replication.page import page, with_headline
from app.replication.plan import DRAWN, THESIS
from app.report.write import write_report
from app.util.files import write_whole

PAGE: Final = "replication.md"
NUMBERS: Final = "replication.json"
"""What the page was made from, beside it."""
FIGURES: Final = "figures"


def write_reports(out: Path, n_processes: int, names: Sequence[str]) -> Iterator[Path]:
    """Write a report on the thesis's experiments together, and on each other; yields the pages.

    Drawing and resampling hold the interpreter's lock, so reports are written by processes.

    Args:
        out: the folder that holds a folder of results for each experiment.
        n_processes: how many are written at a time.
        names: of the experiments.

    Raises:
        ResultsError: an experiment was not run, or nothing can be written.
    """
    wanted: list[tuple[list[Path], Path | None]] = []
    if together := [out / name for name in names if name in THESIS]:
        wanted.append((together, out / REPORT_PAGE))
    wanted += [([out / name], None) for name in names if name not in THESIS]
    with ProcessPoolExecutor(n_processes, get_context("spawn")) as processes:
        yield from processes.map(_written, wanted)


def _written(wanted: tuple[list[Path], Path | None]) -> Path:
    folders, place = wanted
    return write_report(folders, place, compare=False).page


def write_docs(out: Path, docs: Path, tell: Callable[[str], object] = lambda _: None) -> Path:
    """Write the page on the replication anew, with its numbers and figures, and the headline.

    Args:
        out: the folder of all results, with the reports on them.
        docs: the folder of the documentation; the README is beside it.
        tell: told what is being done.

    Returns:
        The page.

    Raises:
        ResultsError: an experiment was not run.
        OSError: something cannot be read or written.
        ValueError: the README has no place for the headline.
    """
    found = found_in(out, tell)
    readme = docs.parent / "README.md"
    headline = with_headline(readme.read_text("utf-8"), found)
    text = page(found)
    for name, (experiment, figure) in DRAWN.items():
        report = out / experiment / REPORT_PAGE if experiment else out / REPORT_PAGE
        picture = (figures_of(report) / f"{figure}.png").read_bytes()
        write_whole(docs / FIGURES / f"{name}.png", picture)
    write_whole(docs / NUMBERS, found.to_json().encode())
    write_whole(docs / PAGE, text.encode())
    write_whole(readme, headline.encode())
    return docs / PAGE
