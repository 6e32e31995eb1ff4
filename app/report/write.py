"""A report of results: one page that stands for itself, and its pictures as files.

What a page shows follows from what was run. Runs of the thesis's learners in its worlds give its
figures and a verdict on each of its findings; settings that were swept give maps and points;
variants give curves, and unless they are of one such map they are set against the first of them.
"""

import os
import shlex
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from app.charts.paper.drawing import missing_note
from app.experiments.record import Record
from app.experiments.store import REPORT_PAGE, figures_of, remove_figures
from app.metrics import FINAL_REWARD, METRICS, shown_first, shown_means
from app.report.document import FIGURE_FILES, Page, document, table
from app.report.headline import lead_with_range
from app.report.overview import opening_of, title_of, write_again, write_what_was_run
from app.report.parts import MOST_ROWS, Shown
from app.report.sections.compare import write_comparison
from app.report.sections.readings import write_readings
from app.report.sections.runs import Row, runs_picture
from app.report.sections.schedules import write_schedules
from app.report.sections.standings import field_of, write_standings
from app.report.sections.stops import write_stops
from app.report.sections.sweeps import write_sweeps
from app.report.sections.thesis import write_thesis
from app.report.sections.variants import write_curves, write_passages, write_scalars, write_variants
from app.results import thesis
from app.results.horizon import Horizon
from app.results.read import (
    Folder,
    Group,
    Reader,
    ResultsError,
    folder_names,
    groups_of,
    read_folder,
    widths_of,
    with_short_names,
)
from app.results.readings import readings_of
from app.util import leftovers
from app.util.files import PASSING, write_whole
from app.util.html import element
from app.util.texts import as_path, as_text
from app.words.numbers import counted

_LONGEST_NAME = 120
"""In bytes, of the folder of a page on several folders; file systems take twice as much."""


class Written(NamedTuple):
    """A report that has been written."""

    page: Path
    warnings: Sequence[str]
    """What its reader has to know, and finds in it as well."""


def write_report(
    folders: Sequence[Path],
    out: Path | None,
    compare: bool,
    tell: Callable[[str], object] = lambda _: None,
) -> Written:
    """Write a page on folders of results, and its pictures into a folder beside it.

    Args:
        folders: of results; without ``compare`` they are taken together.
        out: the page; :func:`default_place` unless given.
        compare: set the second folder against the first.
        tell: told what is being done.

    Raises:
        ResultsError: nothing can be reported, or nothing be written.
    """
    if compare and len(folders) != 2:
        raise ResultsError(f"a comparison needs two folders, and there are {len(folders)}")
    tell("reading tables of results")
    read = [read_folder(folder) for folder in folders]
    place = default_place(folders, compare) if out is None else out
    commands = [*(folder.command for folder in read), _command(folders, out, compare)]
    warnings = [*_unfinished(read), *_damaged(read)]
    page = Page(commands, figures_of(place).name, warnings=warnings, tell=tell)
    several = folder_names(folder.path for folder in read) if len({*folders}) > 1 else {}
    reader = Reader(
        widths_of(run for folder in read for run in folder.rows),
        thesis.quantities_of,
        several,
        lambda n: tell(f"reading logs: {counted(n, 'run')}"),
    )
    read, horizon = _compared(reader, read)
    tables = [folder.rows for folder in read]
    rows = [row for table in (tables if compare else _without_copies(tables)) for row in table]
    if all(row.error for row in rows):
        shown = ", ".join(repr(str(folder)) for folder in folders)
        nothing = f"no run is over in {shown}: there is nothing to report yet"
        raise ResultsError(" ".join([nothing, *_damaged(read)]))
    # What both sides of a comparison hold is looked at twice, and was still run once.
    apart = [row for table in _without_copies(tables) for row in table]
    for run in (run for folder in read for run in folder.lost):
        reader.unreadable[reader.name_of(run)] = "its arrays are damaged or gone"
    title, opening = title_of(read, compare), opening_of(read, apart, compare)
    # Folders may differ in what they measure first; the page shows one thing all through.
    shown = _shown(read[0], rows, horizon)
    groups = groups_of(apart)
    if compare:
        first, second = read
        write_comparison(page, reader, first, second, shown)
    else:
        _everything(page, reader, groups, shown)
    write_what_was_run(page, read, groups, compare, horizon)
    _missing_runs(page, reader, rows)
    write_again(page, place, read)
    page.warnings = [*page.warnings, *_missing_characters(page)]
    tell("writing the page")
    _write_all(page, place, document(title, opening, page))
    return Written(place, page.warnings)


def default_place(folders: Sequence[Path], compare: bool) -> Path:
    """Where a page goes that was not told: into its folder, or beside the first of several."""
    apart = [*dict.fromkeys(folder.resolve() for folder in folders)]
    if len(apart) == 1:
        return folders[0] / REPORT_PAGE
    above = Path(os.path.commonpath(apart))
    # Folders of the same name are told apart by the ways to them.
    names = [folder.name for folder in apart]
    if len({*names}) < len(names):
        names = ["-".join(folder.relative_to(above).parts) or folder.name for folder in apart]
    word = "compare" if compare else "report"
    name = "_".join([word, *names])
    if len(os.fsencode(name)) > _LONGEST_NAME:
        # A character that would be cut in two is left out.
        first = os.fsencode("_".join([word, names[0]]))[:_LONGEST_NAME].decode(errors="ignore")
        name = as_path(f"{first}_and_{len(names) - 1}_more")
    beside = folders[0].parent if folders[0].name not in ("", "..") else apart[0].parent
    return beside / name / REPORT_PAGE


def _unfinished(read: Iterable[Folder]) -> list[str]:
    """Which experiments have runs that are not there yet."""
    folders = {folder.path: folder for folder in read}
    names = folder_names(folders)
    return [
        f"Unfinished: {len(folder.rows):,} of {counted(folder.planned, 'run')}"
        + (f" in {names[path]}." if len(folders) > 1 else ".")
        for path, folder in folders.items()
        if len(folder.rows) < folder.planned
    ]


def _damaged(read: Iterable[Folder]) -> list[str]:
    """Of which folders runs count as missing that were there once."""
    folders = {folder.path: folder for folder in read}
    return [
        f"Damaged: the arrays of {counted(len(folder.lost), 'run')} in {path} are damaged or gone,"
        f" so they count as missing; {folder.command} --resume makes them again."
        for path, folder in folders.items()
        if folder.lost
    ]


def _compared(reader: Reader, read: Iterable[Folder]) -> tuple[list[Folder], Horizon | None]:
    """Folders with the values of their runs at the horizon that all have in common."""
    folders = [*read]
    every, horizon = reader.at_horizon(run for folder in folders for run in folder.rows)
    left = iter(every)
    return [replace(folder, rows=[*islice(left, len(folder.rows))]) for folder in folders], horizon


def _shown(folder: Folder, rows: Iterable[Record], horizon: Horizon | None) -> Shown:
    """What is shown of runs that are compared at a horizon; the folder's are the first of them."""
    done = [row for row in rows if not row.error]
    lengths = [row.preset_trials for row in done]
    at = None if horizon is None else horizon.steps
    every = [m.of_runs(min(lengths), max(lengths)).at(at) for m in METRICS]
    by_column = {metric.column: metric for metric in every}
    is_stated = all(row.origin.states_horizon for row in done)
    first = by_column[shown_first(folder.metrics, is_stated).column]
    means = shown_means(folder.metrics, is_stated, at is not None)
    swept = [by_column[metric.column] for metric in means]
    if any(row.origin.stop is not None for row in folder.rows):
        # They end as good as one another, and in the midst of learning; what differs is how soon.
        first = by_column["steps"] if first.column == FINAL_REWARD.column else first
        swept = [first]
    return Shown(first, swept, every, at)


def _everything(page: Page, reader: Reader, found: Sequence[Group], shown: Shown) -> None:
    groups, naming = with_short_names(found)
    write_stops(page, reader, groups)
    read_otherwise = readings_of(found)
    if read_otherwise:
        write_readings(page, reader, read_otherwise)
    placed = {} if read_otherwise else thesis.placed_of(groups)
    # One of its four learners alone replicates nothing; it is a variant like any other, also
    # beside variants of itself that findings speak of.
    if len({learner for _, learner in placed if learner in thesis.LEARNER_TITLES}) < 2:
        placed = {}
    if placed:
        write_thesis(page, reader, placed, shown)
    field = field_of(found)
    if field is not None:
        write_standings(page, field, shown.every)
    write_schedules(page, groups)
    others = _not_in_figures(groups, placed)
    swept = write_sweeps(page, groups, shown)
    rest = [group for group in others if group.preset not in swept]
    if len(rest) > 1:
        write_variants(page, rest, shown, naming)
    if others:
        write_curves(page, reader, others, shown.first, naming)
        write_passages(page, others, shown.first, naming)
    if 0 < len(rest) <= MOST_ROWS:
        rows = [Row(group.label, group.runs) for group in rest]
        picture = runs_picture(page, "runs", "Every run", rows, shown.every)
        if picture:
            page.say("Every run", picture)
    write_scalars(page, groups, shown, naming)
    lead_with_range(page, groups, shown.first)


def _not_in_figures(groups: Sequence[Group], placed: thesis.Placed) -> Sequence[Group]:
    """Variants that the thesis's figures leave out, with all others of their experiments.

    A variant that happens to be a learner of the thesis still is what its experiment is about.
    """
    left = [group for group in groups if thesis.place_of(group.runs[0]) not in placed]
    folders = {run.origin.folder for group in left for run in group.runs}
    return [group for group in groups if any(run.origin.folder in folders for run in group.runs)]


def _without_copies(tables: Iterable[Sequence[Record]]) -> list[list[Record]]:
    """Tables of folders without the runs that a folder before them holds as well.

    Within a folder nothing is a copy: two of its variants may well come to the same settings.
    """
    seen: set[tuple[str, str]] = set()
    found: list[list[Record]] = []
    for rows in tables:
        keyed = [((row.identity, row.digest or row.key), row) for row in rows]
        found.append([row for key, row in keyed if key not in seen])
        seen.update(key for key, _ in keyed)
    return found


def _command(folders: Sequence[Path], out: Path | None, compare: bool) -> str:
    words = ["pounce", "report", *(["--compare"] if compare else []), *map(str, folders)]
    return as_text(shlex.join([*words, *([] if out is None else ["--out", str(out)])]))


def _missing_runs(page: Page, reader: Reader, rows: Iterable[Record]) -> None:
    failed = {reader.name_of(run): run.error for run in rows if run.error}
    missing = {**failed, **reader.unreadable}
    if missing:
        cells = [(name, element("span", why)) for name, why in missing.items()]
        page.say("Runs that are left out", table(("run", "why"), cells))


def _missing_characters(page: Page) -> list[str]:
    """Which characters no font had, to be said at the head of the page; nothing if all were had."""
    missing = "".join(dict.fromkeys("".join(d.missing for d in page.drawings.values())))
    if not missing:
        return []
    return [missing_note(missing)]


def _write_all(page: Page, place: Path, text: str) -> None:
    folder = place.with_name(page.figures)
    header = '<?xml version="1.0" encoding="utf-8"?>\n'
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for each in (place.parent, folder):
            leftovers.clear(each, PASSING)
        for name, drawing in page.drawings.items():
            contents = (
                (header + drawing.svg).encode(),
                drawing.png,
                drawing.csv.encode("utf-8", "replace"),
                drawing.spreadsheet.encode("utf-8", "replace"),
            )
            for ending, content in zip(FIGURE_FILES, contents, strict=True):
                write_whole(folder / f"{name}.{ending}", content)
        # The page comes last: where it is, its pictures are.
        write_whole(place, text.encode())
        # Those of an older one that it does not show.
        remove_figures(
            place, {Path(f"{name}.{end}").stem for name in page.drawings for end in FIGURE_FILES}
        )
    except OSError as error:
        raise ResultsError(
            f"{str(place)!r} cannot be written: {error.strerror or error};"
            " allowed: --out with a place that can"
        ) from error
