"""The folder that the results of one experiment are written to, whatever happens.

It holds ``experiment.yaml`` as it was given, ``results.sqlite``, and for each finished run
``arrays/KEY.npz``. The arrays of a run are moved into place before its row is written: a row says
that everything is there, and whatever ends the program loses at most the runs in flight.
"""

import contextlib
import json
import os
import sqlite3
import tempfile
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final, Self

from app import __version__, csv_texts
from app.document import UnusableError, file_of, is_same_text
from app.experiments import Experiment
from app.files import write_whole
from app.folders import make_folders, remove_folders
from app.replicate import DONE, FAILED, gist, settings_of
from sim.sources import SOURCE_DIGEST

SCHEMA_VERSION: Final = 3

COLUMNS: Final = {
    "key": "TEXT PRIMARY KEY",
    "variant": "TEXT NOT NULL",
    "preset": "TEXT NOT NULL",
    "overrides": "TEXT NOT NULL",
    "settings": "TEXT NOT NULL",
    "seed": "INTEGER NOT NULL",
    "status": "TEXT NOT NULL",
    "error": "TEXT",
    "version": "TEXT NOT NULL",
    "digest": "TEXT",
    "seconds": "REAL",
    "ended_at": "TEXT",
    "trials": "INTEGER",
    "steps": "INTEGER",
    "captures": "INTEGER",
    "flights": "INTEGER",
    "timeouts": "INTEGER",
    "final_reward": "REAL",
    "final_success": "REAL",
    "greedy_success": "REAL",
    "area": "REAL",
    "steps_to_50": "INTEGER",
    "steps_to_70": "INTEGER",
    "mean_hunt_length": "REAL",
    "switches_per_step": "REAL",
}
"""Of the table ``runs``. ``overrides`` and ``settings`` are JSON, ``ended_at`` is UTC."""

REPORT_PAGE: Final = "report.html"
"""A report on the results of a folder, in it; its figures are beside it."""

_FIGURES: Final = (".svg", ".png", ".csv")
_LOCK: Final = ".lock"
_PASSING: Final = ".*.tmp"
"""What something that kills the program leaves of a file that was being written."""
_PATIENCE_S: Final = 30.0
"""A reader, such as the page, may hold the table for a moment."""


class FolderError(Exception):
    """Results cannot be kept in that folder; the message says why."""


class Folder:
    """Where the results of one experiment are. Used as a context, by one thread."""

    def __init__(self, path: Path, experiment: Experiment, resume: bool, force: bool) -> None:
        """Claim the folder before any work is done.

        Raises:
            FolderError: it cannot be used; nothing in it has changed.
        """
        self.path = path
        self.arrays = path / "arrays"
        self._is_report_old = True
        with contextlib.ExitStack() as stack, _claiming():
            is_new = _is_new(path, resume, force)
            path.mkdir(parents=True, exist_ok=True)
            stack.enter_context(_locked(path))
            if is_new and not is_free(path):
                raise FolderError(
                    "has just been written to by another pounce; allowed: another folder, or"
                    " --resume to go on"
                )
            if is_new or force:
                self._begin(experiment)
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
        """Keys of the runs that are done, and whose arrays are there."""
        return _finished(self._database, self.path)

    def disown(self, key: str, error: str) -> None:
        """Note that a run counts as failed, so that it is made again."""
        with self._database:
            self._database.execute(
                "UPDATE runs SET status = ?, error = ? WHERE key = ?", (FAILED, error, key)
            )

    def rows(self) -> list[dict[str, Any]]:
        """Rows of the runs that are done, in the order in which they ended."""
        names = ", ".join(COLUMNS)
        query = f"SELECT {names} FROM runs WHERE status = ? ORDER BY rowid"
        rows = self._database.execute(query, (DONE,)).fetchall()
        return [dict(zip(COLUMNS, row, strict=True)) for row in rows]

    def arrays_of(self, key: str) -> bytes:
        """The archive of the arrays of a run.

        Raises:
            OSError: it cannot be read.
        """
        return (self.arrays / f"{key}.npz").read_bytes()

    def first_error(self) -> str:
        """What the first failed run said, on one line."""
        query = "SELECT variant, seed, error FROM runs WHERE status = ? ORDER BY rowid LIMIT 1"
        row = self._database.execute(query, (FAILED,)).fetchone()
        if row is None:
            return ""
        variant, seed, error = row
        return f"{variant}, seed {seed}: {gist(error)}"

    def write(self, row: Mapping[str, Any]) -> None:
        """Add a run, or replace one that failed. A report that did not know it is removed.

        Raises:
            FolderError: the row could not be written.
        """
        names = ", ".join(COLUMNS)
        places = ", ".join("?" * len(COLUMNS))
        values = [row.get(name) for name in COLUMNS]
        try:
            # One that is written from now on says of how many runs it is.
            self._remove_old_report()
            with self._database:
                self._database.execute(
                    f"INSERT OR REPLACE INTO runs ({names}) VALUES ({places})", values
                )
        except sqlite3.Error as error:
            raise FolderError(f"cannot be written to: {error}; --resume goes on later") from error
        except OSError as error:
            raise _unwritable(error) from error

    def save(self, key: str, arrays: bytes) -> None:
        """Put the arrays of a run into place, whole.

        Raises:
            FolderError: they could not be written.
        """
        try:
            write_whole(self.arrays / f"{key}.npz", arrays)
        except OSError as error:
            raise _unwritable(error) from error

    def _begin(self, experiment: Experiment) -> None:
        self._remove_old_report()
        for name in ("", "-journal", "-wal", "-shm"):
            self.table.with_name(self.table.name + name).unlink(missing_ok=True)
        for pattern in ("*.npz", _PASSING):
            _clear(self.arrays, pattern)
        _clear(self.path, _PASSING)
        # First of all: if the disk is full, a new folder is still free afterwards.
        write_whole(self.path / "experiment.yaml", experiment.text)
        self.arrays.mkdir(exist_ok=True)
        self._begin_table(experiment)

    def _begin_table(self, experiment: Experiment) -> None:
        """Make the table, at one stroke: whatever comes in between, it is whole or empty."""
        about = {
            "schema_version": str(SCHEMA_VERSION),
            "name": experiment.name,
            "description": experiment.description,
            "common_starts": json.dumps(experiment.common_starts),
            "source": experiment.source,
            "steps": json.dumps(experiment.steps),
            "stop": json.dumps(None if experiment.stop is None else asdict(experiment.stop)),
            "metrics": json.dumps(experiment.metrics),
            "version": version(),
            "seeds": json.dumps(list(experiment.seeds)),
            # Files of presets that the record names by their paths may not be found from here.
            "variants": json.dumps([variant.label for variant in experiment.variants]),
        }
        columns = ", ".join(f"{name} {kind}" for name, kind in COLUMNS.items())
        self._database = self._opened()
        try:
            with self._database:
                # Otherwise each table would be there before the next.
                self._database.execute("BEGIN")
                self._database.execute("CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT)")
                self._database.execute(f"CREATE TABLE runs ({columns})")
                self._database.executemany("INSERT INTO meta VALUES (?, ?)", list(about.items()))
        except BaseException:
            self._database.close()
            raise

    def _go_on(self, experiment: Experiment) -> None:
        if _is_unbegun(self.path, experiment):
            self.arrays.mkdir(exist_ok=True)
            self._begin_table(experiment)
            return
        self._database = self._opened()
        try:
            _refuse_to_go_on(self._database, self.path, experiment)
            self.arrays.mkdir(exist_ok=True)
            _clear(self.arrays, _PASSING)
            (before,) = self._database.execute(
                "SELECT value FROM meta WHERE key = 'seeds'"
            ).fetchone()
            # Of other seeds, what is there stays.
            seeds = dict.fromkeys([*json.loads(before), *experiment.seeds])
            self._note_seeds([*seeds])
        except BaseException:
            self._database.close()
            raise

    def _opened(self) -> sqlite3.Connection:
        return sqlite3.connect(self.table, timeout=_PATIENCE_S)

    def _note_seeds(self, seeds: Sequence[int]) -> None:
        with self._database:
            self._database.execute(
                "UPDATE meta SET value = ? WHERE key = 'seeds'", (json.dumps(list(seeds)),)
            )

    def _remove_old_report(self) -> None:
        """Remove a report on what was there when the folder was claimed."""
        if not self._is_report_old:
            return
        page = self.path / REPORT_PAGE
        # The page comes first: where it is, its pictures are.
        page.unlink(missing_ok=True)
        remove_figures(page)
        self._is_report_old = False


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


def _clear(folder: Path, pattern: str) -> None:
    for path in folder.glob(pattern):
        if path.is_file():
            path.unlink()


@contextlib.contextmanager
def _claiming() -> Iterator[None]:
    """Whatever is in the way of using a folder is a `FolderError`."""
    try:
        yield
    except sqlite3.Error as error:
        raise FolderError(f"holds a results.sqlite that cannot be used: {error}") from error
    except OSError as error:
        raise _unwritable(error) from error


def _is_new(path: Path, resume: bool, force: bool) -> bool:
    """Whether nothing is there; if something is, it must be results that may be used so."""
    if is_free(path):
        return True
    if not (force or resume):
        raise FolderError(
            "is there already and not empty; allowed: another folder, --resume to go on, or"
            " --force to begin again"
        )
    # --force begins results again; it clears nothing that is not results.
    if not _holds_results(path):
        raise FolderError("holds something else than results; allowed: another folder")
    return False


def _holds_results(path: Path) -> bool:
    """Whether there are results in a folder, be they as good as not begun."""
    if (path / "results.sqlite").is_file():
        return True
    if not (path / "experiment.yaml").is_file():
        return False
    # A writer that was killed at once leaves its lock; an experiment of one's own has none.
    begun = (path / _LOCK).is_file() and _holds_only(path, "experiment.yaml")
    return begun or (path / "arrays").is_dir()


def has_table(path: Path) -> bool:
    """Whether the table of results in a folder is there and not empty.

    Raises:
        OSError: it cannot be looked into.
    """
    table = path / "results.sqlite"
    # A journal beside an empty table is that of its first lines, which are to be written again.
    return table.is_file() and table.stat().st_size > 0


def _is_unbegun(path: Path, experiment: Experiment) -> bool:
    """Whether a folder of this experiment was left before its table said anything.

    Raises:
        FolderError: its table says nothing, and it is not of this experiment.
    """
    if has_table(path):
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


def _refuse_to_go_on(database: sqlite3.Connection, path: Path, experiment: Experiment) -> None:
    objection = _objection(database, path, experiment)
    if objection:
        raise FolderError(f"{objection}; allowed: another folder, or --force to begin again")


def finished_if_claimed(path: Path, experiment: Experiment, resume: bool, force: bool) -> set[str]:
    """Keys of the runs that would be there already if a `Folder` were made of this.

    Nothing changes, but for a moment in which it is tried whether the folder can be used.

    Raises:
        FolderError: as a `Folder` would raise.
    """
    with _claiming():
        if _is_new(path, resume, force):
            made = make_folders(path)
            try:
                with _tried(path):
                    return set()
            finally:
                remove_folders(made)
        with _tried(path):
            if force or _is_unbegun(path, experiment):
                return set()
            with contextlib.closing(reader(path)) as database:
                _refuse_to_go_on(database, path, experiment)
                return _finished(database, path)


def goes_on(path: Path, experiment: Experiment) -> bool:
    """Whether a folder holds results of this very experiment, which could be gone on with.

    Raises:
        FolderError: it cannot be looked into.
    """
    try:
        if not has_table(path):
            return _holds_results(path) and _is_of(path, experiment)
        with contextlib.closing(reader(path)) as database:
            return not _objection(database, path, experiment)
    except (sqlite3.OperationalError, OSError) as error:
        raise FolderError(f"{str(path)!r} cannot be read: {error}") from error
    except sqlite3.DatabaseError:
        # It is damaged, or no table at all.
        return False


def _objection(database: sqlite3.Connection, path: Path, experiment: Experiment) -> str:
    """Why these results are not to be gone on with; empty if they are."""
    found = schema_version(database)
    if found != str(SCHEMA_VERSION):
        written = "without a version" if found is None else f"of version {found}"
        return f"holds results {written}, and this pounce reads version {SCHEMA_VERSION}"
    if not (path / "experiment.yaml").is_file():
        return "holds results whose experiment.yaml is missing"
    if not _is_of(path, experiment):
        return "holds the results of another experiment"
    others = database.execute(
        "SELECT DISTINCT version FROM runs WHERE status = ? AND version != ?", (DONE, version())
    ).fetchall()
    if others:
        return f"holds runs made by pounce {others[0][0]}, and this is {version()}"
    specs = {variant.label: settings_of(variant) for variant in experiment.variants}
    rows = database.execute("SELECT DISTINCT variant, settings FROM runs")
    for label, settings in rows:
        if specs.get(label, settings) != settings:
            return (
                f"holds runs of {label!r} with other settings, of a preset that has changed since"
            )
    return ""


def finished_in(path: Path) -> set[str]:
    """Keys of the runs that are done in a folder, and whose arrays are; it may not be there.

    Raises:
        FolderError: it cannot be read.
    """
    if not has_table(path):
        return set()
    with _reading(path) as database:
        return _finished(database, path)


def _finished(database: sqlite3.Connection, path: Path) -> set[str]:
    rows = database.execute("SELECT key FROM runs WHERE status = ?", (DONE,)).fetchall()
    there: set[str] = set()
    with contextlib.suppress(FileNotFoundError), os.scandir(path / "arrays") as entries:
        # After a loss of power a file may be there and empty.
        there = {e.name for e in entries if e.name.endswith(".npz") and e.stat().st_size}
    return {key for (key,) in rows if f"{key}.npz" in there}


def table_csv(path: Path, spreadsheet: bool = False) -> str:
    """The results table of a folder as comma-separated values, for programs or for a spreadsheet.

    Raises:
        FolderError: it cannot be read.
    """
    write = csv_texts.for_spreadsheets if spreadsheet else csv_texts.for_programs
    with _reading(path) as database:
        query = f"SELECT {', '.join(COLUMNS)} FROM runs ORDER BY rowid"
        return write([list(COLUMNS), *database.execute(query)])


@contextlib.contextmanager
def _reading(path: Path) -> Iterator[sqlite3.Connection]:
    """The results table of a folder; whatever is in the way of reading it is a `FolderError`."""
    try:
        with contextlib.closing(reader(path)) as database:
            yield database
    except (sqlite3.Error, OSError) as error:
        raise FolderError(f"{str(path)!r} cannot be read: {error}") from error


def reader(path: Path) -> sqlite3.Connection:
    """The results table of a folder, to read from, while somebody else may be writing to it."""
    file = path / "results.sqlite"
    # What was killed in the middle of a row left a journal behind, which is to be rolled back.
    mode = "rw" if os.access(file, os.W_OK) and os.access(path, os.W_OK) else "ro"
    return sqlite3.connect(f"{file.resolve().as_uri()}?mode={mode}", uri=True, timeout=_PATIENCE_S)


def is_free(path: Path) -> bool:
    """Whether there is no such folder, or nothing in it but what a killed writer leaves.

    Raises:
        OSError: it cannot be looked into.
    """
    return not path.exists() or _holds_only(path)


def _holds_only(path: Path, *names: str) -> bool:
    """Whether all that is in a folder is of these names, or a lock, or what a kill leaves."""
    # While it is locked, SQLite keeps a journal beside the lock.
    ours = {_LOCK, f"{_LOCK}-journal", *names}
    return all(
        entry.name in ours or (entry.match(_PASSING) and entry.is_file())
        for entry in path.iterdir()
    )


@contextlib.contextmanager
def _tried(path: Path) -> Iterator[None]:
    """Refuse a folder that others write into or that cannot be written to; it stays as it is."""
    # Where there is no lock, nobody holds it, and none is made.
    with _locked(path) if (path / _LOCK).exists() else tempfile.TemporaryFile(dir=path):
        yield


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Keep others from writing into a folder; whatever ends this program unlocks it."""
    with contextlib.ExitStack() as stack:
        try:
            # SQLite's locks are there on every system.
            lock = sqlite3.connect(path / _LOCK, timeout=0, isolation_level=None)
            stack.callback(lock.close)
            lock.execute("BEGIN EXCLUSIVE")
        except sqlite3.Error as error:
            if error.sqlite_errorcode & 0xFF == sqlite3.SQLITE_BUSY:
                raise FolderError(
                    "is being written to by another pounce; allowed: another folder, or later"
                ) from error
            raise FolderError(
                f"cannot be locked: {error}; allowed: a folder that can be written to"
            ) from error
        yield


def schema_version(database: sqlite3.Connection) -> str | None:
    """Version of the schema of a results table, None if it has none."""
    tables = database.execute("SELECT name FROM sqlite_master WHERE name = 'meta'").fetchall()
    if not tables:
        return None
    row = database.execute("SELECT value FROM meta WHERE key = 'schema_version'").fetchone()
    return None if row is None else str(row[0])


def version() -> str:
    """Version of this package and of the code that decides what a run comes to.

    Two checkouts of one version may differ, and then their results may.
    """
    return f"{__version__}+{SOURCE_DIGEST[:8]}"


def _unwritable(error: OSError) -> FolderError:
    return FolderError(
        f"cannot be written to: {error.strerror or error}; allowed: a folder that can"
    )
