"""The files that ``pounce run`` leaves: all of them whole, or none."""

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Self

from app.util import leftovers
from app.util.files import make_folders, remove_folders

_STAGING = leftovers.NAME + "[a-z0-9_]" * 8
"""What folders are called that Python makes up a name for, after the same beginning."""


class OutputError(Exception):
    """Results cannot be written there; the message says why."""


class Output:
    """The result files of the runs of a preset, each of them whole, ``NAME.json`` last.

    They are written to a hidden folder beside their final places first, and moved there one after
    the other when everything is complete: where ``NAME.json`` is, the others are. Used as a
    context, which removes that folder, and the folders that had to be made if nothing came to lie
    in them. What was killed before it could do so is cleared away by the next one.
    """

    def __init__(self, folder: Path, name: str, seeds: Iterable[int], overwrite: bool) -> None:
        """Claim the place before any work is done.

        Raises:
            OutputError: the folder cannot be written to, or holds results of that name already.
        """
        self._folder = folder
        self._name = name
        self._tables = {seed: f"{name}-seed{seed}.npz" for seed in seeds}
        try:
            made = make_folders(folder)
        except OSError as error:
            raise _unwritable(error) from error
        with contextlib.ExitStack() as stack:
            stack.callback(remove_folders, made)
            try:
                self._refuse_taken(overwrite)
                leftovers.clear(folder, _STAGING)
                self._staging = stack.enter_context(_staging_in(folder))
            except OSError as error:
                raise _unwritable(error) from error
            self._stack = stack.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self._stack.close()

    @property
    def files(self) -> tuple[Path, ...]:
        """All result files, in the order in which they are moved into place."""
        names = [*self._tables.values(), f"{self._name}.csv", f"{self._name}.json"]
        return tuple(self._folder / name for name in names)

    def save_tables(self, seed: int, tables: bytes) -> None:
        """Put the archive of the final tables of a run by.

        Raises:
            OutputError: it could not be written.
        """
        try:
            (self._staging / self._tables[seed]).write_bytes(tables)
        except OSError as error:
            raise _unwritable(error) from error

    def commit(self, document: str, curves: str) -> None:
        """Write the rest and move everything into place.

        Args:
            document: all there is to say of the runs, as JSON.
            curves: their learning curves as comma-separated values.

        Raises:
            OutputError: it could not be written.
        """
        try:
            (self._staging / f"{self._name}.csv").write_bytes(curves.encode())
            json_file = self._staging / f"{self._name}.json"
            json_file.write_text(document + "\n", encoding="utf-8")
            for target in self.files:
                os.replace(self._staging / target.name, target)
        except OSError as error:
            raise _unwritable(error) from error

    def _refuse_taken(self, overwrite: bool) -> None:
        taken = [path for path in self.files if _exists(path)]
        if not overwrite and taken:
            others = f" and {len(taken) - 1} more" if len(taken) > 1 else ""
            raise OutputError(
                f"has results of that name already: {taken[0].name}{others};"
                " allowed: another folder, or --force to replace them"
            )
        for path in taken:
            if path.is_dir():
                raise OutputError(
                    f"holds a folder where a result belongs: {path.name}; allowed: another folder"
                )


@contextlib.contextmanager
def _staging_in(folder: Path) -> Iterator[Path]:
    """A hidden folder that is removed in the end, and that nobody else takes for a left one.

    Raises:
        OSError: it cannot be made.
    """
    while True:
        staging = Path(tempfile.mkdtemp(prefix=leftovers.NAME, dir=folder))
        try:
            file = os.open(staging, os.O_RDONLY)
        except FileNotFoundError:
            continue
        try:
            if leftovers.hold(file, staging):
                yield staging
                return
        finally:
            shutil.rmtree(staging, ignore_errors=True)
            os.close(file)


def _unwritable(error: OSError) -> OutputError:
    return OutputError(
        f"cannot be written to: {error.strerror or error}; allowed: a folder that can"
    )


def _exists(path: Path) -> bool:
    # Unlike Path.exists, this does not take a name that is too long for one that is free.
    try:
        path.lstat()
    except FileNotFoundError:
        return False
    return True
