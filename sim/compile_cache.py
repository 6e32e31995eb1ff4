"""Where compiled code is kept between two starts. It may be missing: then code is compiled anew.

Numba's own cache notices a change of the file that holds a function, but not of those whose pieces
were inlined into it; it takes any file as it lies there, and ends the program where there is none
to write. This one keeps Numba's files, in a folder named by all that decides what is in them, each
with a seal; and whatever is in the way of reading or writing them is said once and then passed by.
"""

import contextlib
import functools
import hashlib
import logging
import os
import pickle
import shutil
import stat
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import llvmlite
import numba
from numba.core import config
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.compiler import CompileResult
from numba.misc.appdirs import AppDirs

from sim import sources

KEPT_FOLDERS: Final = 8
"""Folders beside one another, one for each state of the code, of which the latest are kept."""

_OTHERS_MAY_WRITE = stat.S_IWGRP | stat.S_IWOTH
_SEAL_LENGTH = hashlib.sha256().digest_size

_log = logging.getLogger(__name__)


class _Unusable(Exception):
    """A file of the cache that is not to be read; the message says why."""


class _Folder:
    """One folder for compiled code, of one state of the code; it need not exist."""

    def __init__(self, parent: Path, code: str, made_by: str) -> None:
        self.path = parent / f"compiled-{code[:16]}-{made_by[:8]}"
        self.identity = f"{code} {made_by}"
        self.is_refusing = False
        """Whether something could not be written."""
        self._is_used = False

    def note_use(self) -> None:
        """Note that it is still of use, so that others are taken away before it."""
        if not self._is_used:
            self._is_used = True
            with contextlib.suppress(OSError):
                os.utime(self.path)

    def make(self) -> None:
        """Make the folder if it is not there, and take away those not used for the longest time.

        Another process that works with one of these only compiles anew.
        """
        if self.path.is_dir():
            return
        self.path.mkdir(parents=True, exist_ok=True)
        there = [path for path in self.path.parent.glob("compiled-*") if path != self.path]
        with contextlib.suppress(OSError):
            there.sort(key=lambda path: path.stat().st_mtime, reverse=True)
            for old in there[KEPT_FOLDERS - 1 :]:
                shutil.rmtree(old, ignore_errors=True)


class _SealedFiles(IndexDataCacheFile):
    """Numba's index and data of one function, each sealed with what it is to be read as."""

    def __init__(self, folder: _Folder, function: Callable[..., Any]) -> None:
        package, _, module = function.__module__.partition(".")
        self.folder = folder
        self.path = str(folder.path / package)
        super().__init__(
            cache_path=self.path,
            filename_base=f"{module}.{function.__qualname__}",
            source_stamp=f"{folder.identity} {package}",
        )

    def load(self, key: Any) -> Any:
        """What was saved under a key; None if nothing was.

        Raises:
            _Unusable: it is damaged, or may be of a stranger's making.
        """
        found = super().load(key)
        # Two processes that saved at once may have given one name to two things.
        return None if found is None or found[0] != key else found[1]

    def save(self, key: Any, data: Any) -> None:
        """Keep something under a key.

        Raises:
            OSError: it cannot be written.
        """
        self.folder.make()
        Path(self.path).mkdir(exist_ok=True)
        try:
            self._load_index()
        except Exception:  # noqa: BLE001 - it was said when it was to be read
            self.flush()
        super().save(key, (key, data))

    def _load_index(self) -> dict[Any, str]:
        with contextlib.suppress(FileNotFoundError, NotADirectoryError):
            return pickle.loads(self._unsealed(self._index_path))
        return {}

    def _save_index(self, overloads: dict[Any, str]) -> None:
        self._write(self._index_path, self._dump(overloads))

    def _load_data(self, name: str) -> Any:
        return pickle.loads(self._unsealed(self._data_path(name)))

    def _save_data(self, name: str, data: Any) -> None:
        self._write(self._data_path(name), self._dump(data))

    def _write(self, path: str, data: bytes) -> None:
        with self._open_for_write(path) as file:
            os.chmod(file.name, stat.S_IMODE(os.stat(file.name).st_mode) & ~_OTHERS_MAY_WRITE)
            file.write(self._seal_of(path, data) + data)

    def _unsealed(self, path: str) -> bytes:
        with open(path, "rb") as file:
            if not _is_as_safe_as_the_code(os.fstat(file.fileno())):
                raise _Unusable(f"{path} could have been written by others")
            data = file.read()
        seal, data = data[:_SEAL_LENGTH], data[_SEAL_LENGTH:]
        if seal != self._seal_of(path, data):
            raise _Unusable(f"{path} is damaged")
        return data

    def _seal_of(self, path: str, data: bytes) -> bytes:
        about = f"{self._source_stamp} {os.path.basename(path)}\n".encode()
        return hashlib.sha256(about + data).digest()


def places(package: str) -> list[Path]:
    """Where compiled code of a package is kept, as the code is now, the best place first.

    They need not exist; there is none where the code itself cannot be read.
    """
    return [folder.path for folder in _folders_for(package)]


class CompileCache(FunctionCache):
    """Keeps a function's compiled code between two starts; it never fails."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._py_func = function
        self._files = [
            _SealedFiles(folder, function)
            for folder in _folders_for(function.__module__.partition(".")[0])
        ]

    @property
    def cache_path(self) -> str | None:
        """The best place for it, if there is any."""
        return self._files[0].path if self._files else None

    def flush(self) -> None:
        """Forget what is kept."""
        for files in self._files:
            with contextlib.suppress(OSError):
                files.flush()

    def load_overload(self, sig: Any, target_context: Any) -> CompileResult | None:
        """Compiled code for a signature; None if there is none that can be used."""
        target_context.refresh()
        key = self._index_key(sig, target_context.codegen())
        for files in self._files:
            try:
                found = files.load(key)
                if found is not None:
                    made = CompileResult._rebuild(target_context, *found)
                    files.folder.note_use()
                    return made
            except Exception as error:  # noqa: BLE001 - whatever it is, it is compiled anew
                _say(f"{error or type(error).__name__}: it is compiled anew")
        return None

    def save_overload(self, sig: Any, data: CompileResult) -> None:
        """Keep what was compiled for a signature, in the first place that takes it."""
        if data.library.has_dynamic_globals:
            return  # it has addresses in it, which are others in the next process
        key = self._index_key(sig, data.library.codegen)
        obstacle = None
        for files in self._files:
            if files.folder.is_refusing:
                continue
            try:
                files.save(key, data._reduce())
                return
            except Exception as error:  # noqa: BLE001 - whatever it is, there may be another place
                files.folder.is_refusing = True
                reason = error.strerror if isinstance(error, OSError) else error
                obstacle = f"cannot be kept in {files.folder.path}: {reason}"
        if obstacle is not None:
            _say(f"{obstacle}; it is compiled at each start")


@functools.cache
def _folders_for(package: str) -> list[_Folder]:
    """Where compiled code of a package may be, the best place first."""
    code = sources.digest_with(package)
    if code is None:
        return []
    settings = [f"{k}={v}" for k, v in sorted(os.environ.items()) if k.startswith("NUMBA_")]
    compiler = [
        sys.implementation.cache_tag,
        getattr(sys, "abiflags", ""),
        numba.__version__,
        llvmlite.__version__,
        *(setting for setting in settings if not setting.startswith("NUMBA_CACHE_DIR=")),
    ]
    made_by = hashlib.sha256("\n".join(map(str, compiler)).encode()).hexdigest()
    return [_Folder(parent, code, made_by) for parent in _parents()]


def _parents() -> list[Path]:
    """Folders for the folders of compiled code."""
    settings: Any = config
    if settings.CACHE_DIR:
        return [Path(settings.CACHE_DIR).absolute() / "pounce"]
    # Where there is no home, this is no path from the root.
    of_user = Path(AppDirs("pounce", appauthor=False).user_cache_dir)
    return [Path(__file__).parent / "__pycache__", *([of_user] if of_user.is_absolute() else [])]


def _is_as_safe_as_the_code(file: os.stat_result) -> bool:
    """Whether nobody could have written a file who could not have written this program as well.

    What is read from it is run.
    """
    if not hasattr(os, "geteuid"):
        return True  # where there are other permissions than these, and folders are a user's own
    code = os.stat(__file__)
    return file.st_uid in (os.geteuid(), 0, code.st_uid) and not (
        file.st_mode & ~code.st_mode & _OTHERS_MAY_WRITE
    )


_has_spoken = False


def _say(what: str) -> None:
    """Say it in one line, once: what is in the way of one file is in that of others."""
    global _has_spoken
    if not _has_spoken:
        _has_spoken = True
        _log.warning("compiled code: %s", what)
