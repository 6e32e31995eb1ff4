"""The text of all code that decides what a run comes to, read once, and run as it was read.

Results name the version of the code that made them. What lies on disk may be another: it is edited
while the program runs, or a ``.pyc`` is older than it looks, since Python tells by the second and
the size. So the texts of a package are read together, ahead of all its modules, and the modules are
compiled from what was read, whenever they are imported.
"""

import contextlib
import hashlib
import importlib.util
import marshal
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType
from typing import Final, NamedTuple

_CHECKED_BY_HASH = (0b11).to_bytes(4, "little")
"""Flags of a ``.pyc`` that belongs to a source of a certain hash (PEP 552)."""


class Source(NamedTuple):
    """A module's file, as it was when it was read."""

    path: Path
    data: bytes


_sources: dict[str, dict[str, Source]] = {}
"""By package, and then by the whole name of the module."""


def adopt(package: str) -> None:
    """Read a package's modules, and those of packages in it, and import them as they were read.

    Raises:
        ImportError: there is no such package.
    """
    spec = importlib.util.find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        raise ImportError(f"the package {package} is missing", name=package)
    root = Path(spec.submodule_search_locations[0])
    # Editors and file systems leave other files, of names that no module has.
    modules = {
        path: parts
        for path in root.rglob("*.py")
        for parts in [path.relative_to(root).with_suffix("").parts]
        if all(part.isidentifier() for part in parts)
    }
    # Where a module and a package have one name, Python imports the package.
    in_order = sorted(modules, key=lambda path: (path.stem == "__init__", path))
    _sources[package] = {
        ".".join((package, *_without_init(modules[path]))): Source(path, path.read_bytes())
        for path in in_order
    }


def _without_init(parts: tuple[str, ...]) -> tuple[str, ...]:
    """A module's name below its package; a package within it is named by its folder."""
    return parts[:-1] if parts[1:] and parts[-1] == "__init__" else parts


def _digest_of(*packages: str) -> str:
    """Of what their modules say, whatever the line endings and the byte order mark."""
    about = hashlib.sha256()
    for package in packages:
        for name, source in _sources[package].items():
            text = importlib.util.decode_source(source.data)
            about.update(f"{name} {hashlib.sha256(text.encode()).hexdigest()}\n".encode())
    return about.hexdigest()


def digest_with(package: str) -> str | None:
    """Of all sources that decide what code of a package does; None if they were not read."""
    if not _sources.get(package):
        return None
    return SOURCE_DIGEST if package in DECIDING else _digest_of(*DECIDING, package)


class _Loader(SourceFileLoader):
    """Compiles what was read, and not what lies there now."""

    def __init__(self, fullname: str, source: Source) -> None:
        super().__init__(fullname, str(source.path))
        self._data = source.data

    def get_code(self, fullname: str) -> CodeType:
        header = b"".join(
            [
                importlib.util.MAGIC_NUMBER,
                _CHECKED_BY_HASH,
                importlib.util.source_hash(self._data),
            ]
        )
        cached = importlib.util.cache_from_source(self.path)
        with contextlib.suppress(OSError, EOFError, ValueError, TypeError):
            there = self.get_data(cached)
            if there.startswith(header):
                return marshal.loads(there[len(header) :])
        code = self.source_to_code(self._data, self.path)
        if not sys.dont_write_bytecode:
            # Where that cannot be written, it does nothing.
            self.set_data(cached, header + marshal.dumps(code))
        return code


class _Finder(MetaPathFinder):
    """Finds the modules that were read."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        source = _sources.get(fullname.partition(".")[0], {}).get(fullname)
        if source is None:
            return None
        return importlib.util.spec_from_file_location(
            fullname, source.path, loader=_Loader(fullname, source)
        )


sys.meta_path.insert(0, _Finder())

DECIDING: Final = ("sim", "learners")
"""Packages that decide what a run comes to."""

for _package in DECIDING:
    adopt(_package)

SOURCE_DIGEST: Final = _digest_of(*DECIDING)
"""Of all sources that decide what a run comes to, as this process runs them."""
