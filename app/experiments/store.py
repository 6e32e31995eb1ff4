"""The folder that the results of one experiment are written to, whatever happens.

It holds ``experiment.yaml`` as it was given, ``results.sqlite``, and for each finished run
``arrays/KEY.npz``. The arrays of a run are moved into place before its row is written: a row says
that everything is there, and whatever ends the program loses at most the runs in flight.
"""

import contextlib
import itertools
import json
import shutil
import sqlite3
from collections.abc import Container, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final, Self

from app import __version__
from app.documents.experiments import Experiment
from app.documents.sources import file_of
from app.documents.tree import UnusableError, is_same_text
from app.experiments import archive, table
from app.experiments.claims import (
    PASSING,
    FolderError,
    claiming,
    holds_results,
    is_free,
    is_new,
    locked,
    tried,
    unwritable,
)
from app.experiments.record import DONE, FAILED, Record, origin_of, records_of, row_of
from app.experiments.seed_lists import SeedLists
from app.experiments.table import (
    COLUMNS,
    SCHEMA_VERSION,
    DamageError,
    Table,
    UnreadableError,
    VersionError,
)
from app.experiments.task import identity_of, key_of, settings_of
from app.util import csv_texts, leftovers
from app.util.files import make_folders, remove_folders, write_whole
from sim.sources import SOURCE_DIGEST

REPORT_PAGE: Final = "report.html"
"""A report on the results of a folder, in it; its figures are beside it."""

_FIGURES: Final = (".svg", ".png", ".csv")
_TABLE_FILES: Final = ("results.sqlite-journal", "results.sqlite-wal", "results.sqlite-shm")
"""What SQLite keeps beside a table."""
_OF_OTHERS: Final = "allowed: another folder, or --force to begin again"


class Folder:
    """Where the results of one experiment are. Used as a context, by one thread."""

    def __init__(
        self,
        path: Path,
        experiment: Experiment,
        resume: bool,
        force: bool,
        salvage: bool = False,
    ) -> None:
        """Claim the folder before any work is done.

        Args:
            path: the folder.
            experiment: whose results it holds or will hold.
            resume: go on with what is there.
            force: begin again.
            salvage: go on with the rows that are whole of a table that is damaged.

        Raises:
            FolderError: it cannot be used; nothing in it has changed.
        """
        self.path = path
        self.origin = origin_of(experiment, path)
        self.arrays = path / "arrays"
        self._is_report_old = True
        with contextlib.ExitStack() as stack, claiming():
            new = is_new(path, resume or salvage, force)
            # Those that nothing comes to lie in are taken away again.
            stack.callback(remove_folders, make_folders(path))
            stack.enter_context(locked(path))
            if new and not is_free(path):
                raise FolderError(
                    "has just been written to by another pounce; allowed: another folder, or"
                    " --resume to go on"
                )
            if new or force:
                self._begin(experiment)
            elif salvage:
                self._salvage(experiment)
            else:
                self._go_on(experiment)
            stack.callback(self._database.close)
            self._stack = stack.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self._stack.close()

    @property
    def table(self) -> Path:
        """The results table."""
        return self.path / "results.sqlite"

    def finished(self) -> set[str]:
        """Keys of the runs that are done, and whose arrays are there and whole.

        Raises:
            FolderError: the table cannot be read.
        """
        return _with_arrays(self.path, self._read().rows)

    def lost(self) -> set[str]:
        """Keys of the runs that are done, and whose arrays are damaged or gone.

        Raises:
            FolderError: the table cannot be read.
        """
        rows = self._read().rows
        return {row["key"] for row in _done(rows)} - _with_arrays(self.path, rows)

    def disown(self, key: str, error: str) -> None:
        """Note that a run counts as failed, so that it is made again.

        Raises:
            FolderError: that could not be written.
        """
        row = next(row for row in self._read().rows if row["key"] == key)
        self._write({**row, "status": FAILED, "error": error, "arrays": None})

    def records(self) -> list[Record]:
        """The runs that are done, in the order in which they ended.

        Raises:
            FolderError: the table cannot be read.
        """
        return self._records(_done(self._read().rows))

    def arrays_of(self, record: Record) -> bytes:
        """The archive of the arrays of a run.

        Raises:
            ArchiveError: it cannot be read, or is not the one that the record is about.
        """
        return archive.read(self.path, record.key, record.arrays)

    def first_error(self) -> str:
        """What the first failed run said, on one line.

        Raises:
            FolderError: the table cannot be read.
        """
        rows = [row for row in self._read().rows if row["status"] == FAILED]
        found = self._records(rows[:1])
        return "".join(f"{one.variant}, seed {one.seed}: {one.gist}" for one in found)

    def write(self, record: Record) -> None:
        """Add a run, or replace one that failed. A report that did not know it is removed.

        Raises:
            FolderError: it could not be written.
        """
        self._write(row_of(record))

    def save(self, key: str, arrays: bytes) -> None:
        """Put the arrays of a run into place, whole.

        Raises:
            FolderError: they could not be written.
        """
        try:
            write_whole(archive.path_of(self.path, key), arrays)
        except OSError as error:
            raise unwritable(error) from error

    def _write(self, row: Mapping[str, Any]) -> None:
        try:
            # One that is written from now on says of how many runs it is.
            self._remove_old_report()
            table.write(self._database, row)
        except sqlite3.Error as error:
            raise FolderError(f"cannot be written to: {error}; --resume goes on later") from error
        except OSError as error:
            raise unwritable(error) from error

    def _records(self, rows: Iterable[Mapping[str, Any]]) -> list[Record]:
        try:
            return records_of(rows, self.origin)
        except (ValueError, TypeError, KeyError) as error:
            raise FolderError(f"holds a damaged results.sqlite: {error}; {_OF_OTHERS}") from error

    def _read(self) -> Table:
        try:
            with claiming():
                return table.read(self._database)
        except DamageError as error:
            raise _damaged(error) from error

    def _begin(self, experiment: Experiment) -> None:
        self._remove_old_report()
        self.table.unlink(missing_ok=True)
        for path in self.arrays.glob("*.npz"):
            if path.is_file():
                path.unlink()
        self._clear()
        # First of all: if the disk is full, a new folder is still free afterwards.
        write_whole(self.path / "experiment.yaml", experiment.text)
        self.arrays.mkdir(exist_ok=True)
        self._begin_table(_about(experiment))
        self._database = table.connect(self.path)

    def _clear(self) -> None:
        """Take away what a killed writer, or a killed report, has left."""
        for folder in (self.path, self.arrays):
            leftovers.clear(folder, PASSING)

    def _begin_table(
        self, about: Mapping[str, str], rows: Iterable[Mapping[str, Any]] = ()
    ) -> None:
        """Put a table into place, at one stroke: whatever comes in between, it is whole."""
        # What was to be rolled back in another one is not to be in this.
        for name in _TABLE_FILES:
            (self.path / name).unlink(missing_ok=True)
        write_whole(self.table, table.new(about, rows))

    def _go_on(self, experiment: Experiment) -> None:
        if _is_unbegun(self.path, experiment):
            self._begin_table(_about(experiment))
        self._database = table.connect(self.path)
        try:
            before = _usable(self._database, self.path, experiment)
            self._clear()
            self.arrays.mkdir(exist_ok=True)
            # Of other seeds, what is there stays.
            seeds = SeedLists.noted(before.about).and_of(SeedLists.of(experiment))
            table.note(self._database, **seeds.notes)
        except BaseException:
            self._database.close()
            raise

    def _salvage(self, experiment: Experiment) -> None:
        """Put a table of the rows that are whole into the place of one that is damaged."""
        if not goes_on(self.path, experiment):
            rows = _salvageable(self.path, experiment)
            runs = ((row["variant"], row["seed"]) for row in rows)
            seeds = SeedLists.of(experiment).and_of_runs(runs)
            shutil.copyfile(self.table, _free_name(self.path / "damaged.sqlite"))
            write_whole(self.path / "experiment.yaml", experiment.text)
            self._begin_table({**_about(experiment), **seeds.notes}, rows)
        self._go_on(experiment)

    def _remove_old_report(self) -> None:
        """Remove a report on what was there when the folder was claimed."""
        if not self._is_report_old:
            return
        page = self.path / REPORT_PAGE
        # The page comes first: where it is, its pictures are.
        page.unlink(missing_ok=True)
        remove_figures(page)
        self._is_report_old = False


def _about(experiment: Experiment) -> dict[str, str]:
    """What the table says about an experiment."""
    return {
        "name": experiment.name,
        "description": experiment.description,
        "common_starts": json.dumps(experiment.common_starts),
        "source": experiment.source,
        "steps": json.dumps(experiment.steps),
        "stop": json.dumps(None if experiment.stop is None else experiment.stop.model_dump()),
        "horizon": json.dumps(experiment.horizon_steps),
        "steps_alone": json.dumps(experiment.steps is not None and experiment.trials is None),
        "metrics": json.dumps(experiment.metrics),
        "version": version(),
        **SeedLists.of(experiment).notes,
        # Files of presets that the record names by their paths may not be found from here.
        "variants": json.dumps([variant.label for variant in experiment.variants]),
    }


def figures_of(page: Path) -> Path:
    """The folder of the figures of a report."""
    return page.with_name(f"{page.stem}_figures")


def remove_figures(page: Path, kept: Container[str] = ()) -> None:
    """Remove the figures of a report but for those of some names, and their folder if it is empty.

    Raises:
        OSError: one cannot be removed.
    """
    folder = figures_of(page)
    if folder.is_dir():
        for path in folder.iterdir():
            if path.suffix in _FIGURES and path.stem not in kept:
                path.unlink()
        remove_folders([folder])


def _is_unbegun(path: Path, experiment: Experiment) -> bool:
    """Whether a folder of this experiment was left before its table said anything.

    Raises:
        FolderError: its table says nothing, and it is not of this experiment.
    """
    if table.has_table(path):
        return False
    if not _is_of(path, experiment):
        raise FolderError("holds no results to go on with; allowed: --force to begin again")
    return True


def _is_of(path: Path, experiment: Experiment) -> bool:
    """Whether a folder's record is there, and holds the text of this experiment."""
    file = path / "experiment.yaml"
    if not file.is_file():
        return False
    try:
        return is_same_text(experiment.text, file_of(file))
    except UnusableError:  # It may have become anything.
        return False


def finished_if_claimed(
    path: Path, experiment: Experiment, resume: bool, force: bool, salvage: bool = False
) -> set[str]:
    """Keys of the runs that would be there already if a `Folder` were made of this.

    Nothing changes, but for a moment in which it is tried whether the folder can be used.

    Raises:
        FolderError: as a `Folder` would raise.
    """
    with claiming():
        if is_new(path, resume or salvage, force):
            made = make_folders(path)
            try:
                with tried(path):
                    return set()
            finally:
                remove_folders(made)
        with tried(path):
            if force or (not salvage and _is_unbegun(path, experiment)):
                return set()
            if salvage:
                return _with_arrays(path, _salvageable(path, experiment))
            with contextlib.closing(table.reader(path)) as database:
                return _with_arrays(path, _usable(database, path, experiment).rows)


def goes_on(path: Path, experiment: Experiment) -> bool:
    """Whether a folder holds results of this very experiment, which could be gone on with.

    Raises:
        FolderError: it cannot be looked into.
    """
    try:
        if not table.has_table(path):
            return holds_results(path) and _is_of(path, experiment)
        with contextlib.closing(table.reader(path)) as database:
            _usable(database, path, experiment)
    except FolderError:
        return False
    except (sqlite3.Error, OSError) as error:
        raise FolderError(f"{str(path)!r} cannot be read: {error}") from error
    return True


def _usable(database: sqlite3.Connection, path: Path, experiment: Experiment) -> Table:
    """The table of a folder, if it can be gone on with.

    Raises:
        FolderError: it cannot.
    """
    try:
        version = table.schema_version(database)
        if version != str(SCHEMA_VERSION):
            written = "without a version" if version is None else f"of version {version}"
            raise FolderError(
                f"holds results {written}, and this pounce reads version {SCHEMA_VERSION};"
                f" {_OF_OTHERS}"
            )
        if not (path / "experiment.yaml").is_file():
            raise FolderError(f"holds results whose experiment.yaml is missing; {_OF_OTHERS}")
        if not _is_of(path, experiment):
            raise FolderError(f"holds the results of another experiment; {_OF_OTHERS}")
        found = table.read(database)
    except DamageError as error:
        raise _damaged(error) from error
    _refuse_others(found.rows, experiment)
    return found


def _damaged(error: DamageError) -> FolderError:
    salvage = "--salvage to go on with these, " if error.whole else ""
    return FolderError(
        f"holds a damaged results.sqlite: {error}; allowed: {salvage}another folder, or --force to"
        " begin again"
    )


def _refuse_others(rows: Iterable[Mapping[str, Any]], experiment: Experiment) -> None:
    """Refuse to go on with runs of other code or of other settings."""
    specs = {variant.label: settings_of(variant) for variant in experiment.variants}
    for row in rows:
        if row["status"] == DONE and row["version"] != version():
            raise FolderError(
                f"holds runs made by pounce {row['version']}, and this is {version()}; {_OF_OTHERS}"
            )
        label = row["variant"]
        if specs.get(label, row["settings"]) != row["settings"]:
            raise FolderError(
                f"holds runs of {label!r} with other settings, of a preset that has changed since;"
                f" {_OF_OTHERS}"
            )


def _salvageable(path: Path, experiment: Experiment) -> list[dict[str, Any]]:
    """The rows of a folder that are whole; by their keys they are runs of this very experiment.

    Raises:
        FolderError: there are none, or others among them.
    """
    with contextlib.closing(table.reader(path)) as database:
        rows = table.whole_rows(database)
    identities = {v.label: identity_of(experiment, v) for v in experiment.variants}
    _refuse_others(rows, experiment)
    for row in rows:
        label = row["variant"]
        if row["key"] != key_of(label, identities.get(label, ""), row["seed"]):
            raise FolderError(f"holds the results of another experiment; {_OF_OTHERS}")
    if not rows:
        raise FolderError(f"holds no row that is whole; {_OF_OTHERS}")
    return rows


def _free_name(path: Path) -> Path:
    """A path, or one like it, where nothing is yet."""
    names = (path.with_stem(f"{path.stem}-{number}") for number in itertools.count(2))
    return next(name for name in itertools.chain([path], names) if not name.exists())


def finished_in(path: Path) -> set[str]:
    """Keys of the runs that are done in a folder, and whose arrays are whole; it may not be there.

    Raises:
        FolderError: it cannot be read.
    """
    return _with_arrays(path, _load(path).rows) if table.has_table(path) else set()


def _with_arrays(path: Path, rows: Iterable[Mapping[str, Any]]) -> set[str]:
    """Keys of the runs that are done, and whose arrays are there and whole."""
    done = _done(rows)
    return {row["key"] for row in done if archive.is_whole(path, row["key"], row["arrays"])}


def _done(rows: Iterable[Mapping[str, Any]]) -> Iterator[Mapping[str, Any]]:
    return (row for row in rows if row["status"] == DONE)


def table_csv(path: Path, spreadsheet: bool = False) -> str:
    """The results table of a folder as comma-separated values, for programs or for a spreadsheet.

    Raises:
        FolderError: it cannot be read.
    """
    write = csv_texts.for_spreadsheets if spreadsheet else csv_texts.for_programs
    rows = ([row.get(name) for name in COLUMNS] for row in _load(path).rows)
    return write([[*COLUMNS], *rows])


def _load(path: Path) -> Table:
    """The table of a folder; whatever is in the way of reading it is a `FolderError`."""
    try:
        return table.load(path)
    except VersionError as error:
        raise FolderError(f"{str(path)!r} holds results of version {error}") from error
    except (UnreadableError, DamageError) as error:
        raise FolderError(f"{str(path)!r} cannot be read: {error}") from error


def version() -> str:
    """Version of this package and of the code that decides what a run comes to.

    Two checkouts of one version may differ, and then their results may.
    """
    return f"{__version__}+{SOURCE_DIGEST[:8]}"
