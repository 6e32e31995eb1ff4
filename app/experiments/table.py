"""The table of results: what it holds, how it is written, and how damage is found as it is read.

Each row holds a checksum of all its other values, that of the run's arrays among them; what the
table says about the experiment holds one too, and says how many rows there are. So a table that is
damaged is never read as another one: it is refused, and the rows that are whole can be saved.
"""

import contextlib
import fcntl
import hashlib
import json
import math
import os
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

from app.experiments.claims import takes_locks
from app.metrics import NAMES, of_kind

SCHEMA_VERSION: Final = 5

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
    **{
        metric.column: "INTEGER" if metric.whole else "REAL"
        for metric in of_kind("endings", "performance", "passage", "behaviour")
    },
}
"""Of a new table ``runs``. ``overrides`` and ``settings`` are JSON, ``ended_at`` is UTC. An older
table has no column for a metric that came later."""

_ALL: Final = {**COLUMNS, "arrays": "TEXT", "seal": "TEXT NOT NULL"}
"""With the checksums of the archive of a run and of its row."""
_SEAL: Final = "seal"
_LATER: Final = {*NAMES} - {"trials", "steps"}
"""Columns that may be missing."""
_RUNS: Final = "runs"
"""Key of ``meta``: how many rows there are."""
_PATIENCE_S: Final = 30.0
"""A reader, such as the page, may hold the table for a moment."""
_ELSEWHERE: Final = {
    sqlite3.SQLITE_BUSY,
    sqlite3.SQLITE_LOCKED,
    sqlite3.SQLITE_IOERR,
    sqlite3.SQLITE_CANTOPEN,
    sqlite3.SQLITE_READONLY,
    sqlite3.SQLITE_PERM,
    sqlite3.SQLITE_FULL,
    sqlite3.SQLITE_NOMEM,
    sqlite3.SQLITE_PROTOCOL,
}
"""Errors for which the table is not to blame."""


class VersionError(Exception):
    """A table of results is of another schema; the message is its version."""


class UnreadableError(Exception):
    """A table cannot be read, for which it is not to blame; the message says why."""


class DamageError(Exception):
    """A table of results is damaged; the message says how, and how much of it is whole."""

    def __init__(self, why: str, whole: int, total: int | None) -> None:
        """From what is wrong, and how many rows are whole of those that there should be."""
        of = "" if total is None else f" of {total:,}"
        super().__init__(f"{' '.join(why.split())}; {whole:,}{of} rows are whole")
        self.whole = whole


class Table(NamedTuple):
    """A table of results as it was written."""

    about: dict[str, str]
    """What it says about the experiment."""
    rows: list[dict[str, Any]]
    """By column, in the order in which the runs ended."""


# --- Opening it ----------------------------------------------------------------------------------


def connect(path: Path) -> sqlite3.Connection:
    """The results table of a folder, to write to."""
    return _readable(sqlite3.connect(_table(path), timeout=_PATIENCE_S))


def reader(path: Path) -> sqlite3.Connection:
    """The results table of a folder, to read from, while somebody else may be writing to it."""
    file = _table(path)
    # What was killed in the middle of a row left a journal behind, which is to be rolled back.
    mode = "rw" if os.access(file, os.W_OK) and os.access(path, os.W_OK) else "ro"
    # Where a disk has no locks nobody can write to results, so there is nothing to wait for.
    lock = "" if has_locks(path) else "&nolock=1"
    uri = f"{file.resolve().as_uri()}?mode={mode}{lock}"
    return _readable(sqlite3.connect(uri, uri=True, timeout=_PATIENCE_S))


def has_table(path: Path) -> bool:
    """Whether the table of results in a folder is there and not empty.

    Raises:
        OSError: it cannot be looked into.
    """
    file = _table(path)
    if not file.is_file() or not file.stat().st_size:
        # A journal beside an empty table is that of its first lines, which are to be written again.
        return False
    if not file.with_name(f"{file.name}-journal").exists():
        return True
    # What it holds may be the half of its first lines, and nothing once they are rolled back.
    try:
        with contextlib.closing(reader(path)) as database:
            return bool(database.execute("PRAGMA page_count").fetchone()[0])
    except sqlite3.Error:
        # Whoever reads it will say what is the matter.
        return True


def has_locks(path: Path) -> bool:
    """Whether the disk of a folder of results can lock files, as far as that can be found out."""
    try:
        # Never the table itself: closing it here would give up the locks that SQLite has on it.
        file = os.open(path / "experiment.yaml", os.O_RDONLY | os.O_NONBLOCK)
    except OSError:
        return True
    try:
        return takes_locks(file, fcntl.LOCK_SH)
    finally:
        os.close(file)


def is_damage(error: sqlite3.Error) -> bool:
    """Whether an error is of the table itself, and not of the disk or of others who use it."""
    code = getattr(error, "sqlite_errorcode", None)
    return code is None or code & 0xFF not in _ELSEWHERE


def _table(path: Path) -> Path:
    return path / "results.sqlite"


def _readable(database: sqlite3.Connection) -> sqlite3.Connection:
    # Text that is none is damage like any other, and a seal tells.
    database.text_factory = lambda data: data.decode(errors="backslashreplace")
    return database


# --- Writing it ----------------------------------------------------------------------------------


def new(about: Mapping[str, str], rows: Iterable[Mapping[str, Any]] = ()) -> bytes:
    """The file of a new table.

    Args:
        about: what it is to say about the experiment.
        rows: as :func:`write` takes them.
    """
    columns = ", ".join(f"{name} {kind}" for name, kind in _ALL.items())
    with contextlib.closing(sqlite3.connect(":memory:")) as database:
        database.execute("CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT)")
        database.execute(f"CREATE TABLE runs ({columns})")
        note(database, schema_version=str(SCHEMA_VERSION), **about)
        write(database, *rows)
        return database.serialize()


def write(database: sqlite3.Connection, *rows: Mapping[str, Any]) -> None:
    """Add runs, or replace those that are there; all of them, or none.

    What an older table has no column for is left out.

    Args:
        database: the table.
        rows: by column, with the checksum of the run's archive as ``arrays`` if it has one.
    """
    columns = _columns(database)
    names, places = ", ".join(columns), ", ".join("?" * len(columns))
    sealed = [_sealed(row, columns) for row in rows]
    with database:
        database.executemany(f"INSERT OR REPLACE INTO runs ({names}) VALUES ({places})", sealed)
        (count,) = database.execute("SELECT COUNT(*) FROM runs").fetchone()
        _note(database, {_RUNS: str(count)})


def note(database: sqlite3.Connection, **about: str) -> None:
    """Change what the table says about the experiment."""
    with database:
        _note(database, about)


def _note(database: sqlite3.Connection, about: Mapping[str, str]) -> None:
    known = {**_about(database), **about}
    known[_SEAL] = _seal_of_about(known)
    changed = {**about, _SEAL: known[_SEAL]}
    database.executemany("INSERT OR REPLACE INTO meta VALUES (?, ?)", changed.items())


def _sealed(row: Mapping[str, Any], columns: Iterable[str]) -> list[Any]:
    sealed = {name: _as_stored(_ALL[name], row.get(name)) for name in columns if name != _SEAL}
    return [*sealed.values(), _seal_of([*sealed.values()])]


def _as_stored(kind: str, value: Any) -> str | int | float | None:
    """A value as SQLite gives it back."""
    if value is None:
        return None
    if kind.startswith("TEXT"):
        return str(value).encode(errors="backslashreplace").decode()
    if kind.startswith("INTEGER"):
        return int(value)
    number = float(value)
    # Of zeros it knows one.
    return None if math.isnan(number) else number + 0.0


def _seal_of(values: object) -> str:
    return hashlib.sha256(json.dumps(values, default=repr).encode()).hexdigest()


def _seal_of_about(about: Mapping[str, object]) -> str:
    return _seal_of(sorted((key, value) for key, value in about.items() if key != _SEAL))


# --- Reading it ----------------------------------------------------------------------------------


def load(path: Path) -> Table:
    """The table of results in a folder, as it was written.

    Raises:
        VersionError: it is of another schema.
        DamageError: it does not hold any more what was written to it.
        UnreadableError: it cannot be read.
    """
    try:
        with contextlib.closing(reader(path)) as database:
            version = schema_version(database)
            if version != str(SCHEMA_VERSION):
                raise VersionError(version)
            return read(database)
    except (sqlite3.Error, OSError) as error:
        raise UnreadableError(f"{error}{_remedy(error)}") from error


def _remedy(error: Exception) -> str:
    """What can be done where a killed pounce has left a row half written, and the disk is fixed."""
    if getattr(error, "sqlite_errorcode", 0) & 0xFF == sqlite3.SQLITE_READONLY:
        return "; a killed pounce left it half written: allowed: a copy that can be written to"
    return ""


def schema_version(database: sqlite3.Connection) -> str | None:
    """Version of the schema of a results table, None if it has none.

    Raises:
        DamageError, sqlite3.Error: as of :func:`read`.
    """
    with _blaming(database):
        query = "SELECT name FROM sqlite_master WHERE name = 'meta'"
        if not database.execute(query).fetchall():
            return None
        query = "SELECT value FROM meta WHERE key = 'schema_version'"
        row = database.execute(query).fetchone()
        return None if row is None else str(row[0])


def read(database: sqlite3.Connection) -> Table:
    """What a table of this schema holds, as it was written.

    Raises:
        DamageError: it does not hold that any more.
        sqlite3.Error: it cannot be read, for which it is not to blame.
    """
    with _blaming(database), _at_one_moment(database):
        (fault,) = database.execute("PRAGMA quick_check(1)").fetchone()
        found = _sealed_table(database) if fault == "ok" else None
    if found is None:
        unlike = "it does not hold what was written to it"
        raise _damage(database, unlike if fault == "ok" else fault)
    return found


@contextlib.contextmanager
def _blaming(database: sqlite3.Connection) -> Iterator[None]:
    """An error for which a table is to blame is a `DamageError`."""
    try:
        yield
    except sqlite3.Error as error:
        if not is_damage(error):
            raise
        raise _damage(database, str(error)) from error


def _damage(database: sqlite3.Connection, why: str) -> DamageError:
    return DamageError(why, len(whole_rows(database)), _noted_count(database))


def _sealed_table(database: sqlite3.Connection) -> Table | None:
    """All that the table holds; None where something of it is not as it was written."""
    about = _about(database)
    rows = [row for row in _rows(database, "ASC") if _is_whole(row)]
    (count,) = database.execute("SELECT COUNT(*) FROM runs").fetchone()
    is_whole = about.get(_SEAL) == _seal_of_about(about)
    is_whole = is_whole and about.get(_RUNS) == str(len(rows)) == str(count)
    return Table(about, rows) if is_whole else None


def whole_rows(database: sqlite3.Connection) -> list[dict[str, Any]]:
    """The rows that are as they were written, whatever else is damaged, in their order."""
    found: dict[int, dict[str, Any]] = {}
    # What cannot be got at from one end may be got at from the other.
    for order in ("ASC", "DESC"):
        with contextlib.suppress(sqlite3.Error):
            found.update((row["rowid"], row) for row in _rows(database, order) if _is_whole(row))
    # Of a run that was made again, the later row is there.
    return [*{found[rowid]["key"]: found[rowid] for rowid in sorted(found)}.values()]


@contextlib.contextmanager
def _at_one_moment(database: sqlite3.Connection) -> Iterator[None]:
    """Let nobody change what is read in between."""
    database.execute("BEGIN")
    try:
        yield
    finally:
        database.rollback()


def _about(database: sqlite3.Connection) -> dict[str, Any]:
    return dict(database.execute("SELECT key, value FROM meta"))


def _columns(database: sqlite3.Connection) -> list[str]:
    """The columns that the table has, in its own order but for the seal, which comes last.

    Raises:
        sqlite3.DatabaseError: they are not those of a table of results.
    """
    found = [name for _, name, *_ in database.execute("PRAGMA table_info(runs)")]
    strange = sorted({*found} - {*_ALL} | {*_ALL} - _LATER - {*found})
    if strange:
        raise sqlite3.DatabaseError(f"its columns are not those of this pounce: {strange}")
    return [*(name for name in found if name != _SEAL), _SEAL]


def _rows(database: sqlite3.Connection, order: str) -> Iterator[dict[str, Any]]:
    names = ["rowid", *_columns(database)]
    for row in database.execute(f"SELECT {', '.join(names)} FROM runs ORDER BY rowid {order}"):
        yield dict(zip(names, row, strict=True))


def _is_whole(row: Mapping[str, Any]) -> bool:
    sealed = [value for name, value in row.items() if name not in ("rowid", _SEAL)]
    return row[_SEAL] == _seal_of(sealed)


def _noted_count(database: sqlite3.Connection) -> int | None:
    """How many rows there are to be, if the table can say."""
    with contextlib.suppress(sqlite3.Error, KeyError, TypeError, ValueError):
        about = _about(database)
        if about[_SEAL] == _seal_of_about(about):
            return int(about[_RUNS])
    return None
