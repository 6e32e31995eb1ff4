"""Where documents come from: those that come with the lab, files, and standard input."""

import os
import stat
import sys
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Final, NamedTuple

from app.documents.tree import MAX_BYTES, MAX_NAME, UnusableError, printable
from app.util.texts import as_path
from learners.names import did_you_mean

STDIN: Final = "-"
"""Given in the place of a file, standard input."""
STDIN_NAME: Final = "stdin"
"""What is read from there is called."""


class Source(NamedTuple):
    """Where the text of a document was found."""

    label: str
    """What its problems call it."""
    data: bytes | str
    identity: str
    """Equal for two names of one file."""
    folder: Path | None
    """Where the paths in it start; None if it may name shipped documents alone."""


class Shipped(NamedTuple):
    """The documents of one kind that come with the lab."""

    kind: str
    """As messages call one of them."""
    name: str
    """Of their folder."""
    folder: Traversable
    first: tuple[str, ...]
    """Names in the order of the thesis."""

    def files(self) -> dict[str, Traversable]:
        """The documents by name: first the thesis's own, then the others."""
        found = {
            entry.name.removesuffix(".yaml"): entry
            for entry in self.folder.iterdir()
            if entry.name.endswith(".yaml") and entry.is_file()
        }
        names = [name for name in self.first if name in found]
        return {name: found[name] for name in names + sorted(found.keys() - set(names))}

    def opened(self, name: str, folder: Path | None) -> Source:
        """A document that is shipped, or the file at a path from a folder.

        Without a folder, no file is looked at. Raises `UnusableError` alone.
        """
        own = self.files()
        names = ", ".join(own)
        if name in own:
            label = f"{self.name}/{name}.yaml"
            return Source(label, own[name].read_bytes(), f"shipped:{name}", None)
        if folder is None:
            hint = did_you_mean(name, own)
            raise UnusableError(f"is not a shipped {self.kind}{hint}; allowed: {names}")
        try:
            path = folder / as_path(name)
            data = file_of(path)
        except (FileNotFoundError, NotADirectoryError):
            hint = did_you_mean(name, own)
            raise UnusableError(
                f"is neither a shipped {self.kind} nor a file{hint}; allowed: {names}, or a path"
            ) from None
        except OSError as error:
            raise UnusableError(f"cannot be read: {error.strerror}") from None
        except ValueError:
            message = "is not a path: it contains a NUL character or half a character"
            raise UnusableError(message) from None
        return Source(printable(str(path), MAX_NAME), data, os.path.realpath(path), path.parent)

    def asked_for(self, name_or_path: str) -> Source:
        """A document as the command line names it; raises `UnusableError` alone.

        A name that is shipped is never taken for a path; ``./timed`` is one, and ``-`` is standard
        input.
        """
        if name_or_path == STDIN:
            return Source(STDIN_NAME, _standard_input(), STDIN, Path())
        return self.opened(name_or_path, Path())


def file_of(path: Path) -> bytes:
    """What a file holds, if it is one and small: both are seen before anything is read."""
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise UnusableError("is a directory; allowed: a file")
    if not stat.S_ISREG(status.st_mode):
        raise UnusableError("is not a regular file; allowed: a file")
    if status.st_size > MAX_BYTES:
        message = f"is too large, {status.st_size} bytes; allowed: at most {MAX_BYTES} bytes"
        raise UnusableError(message)
    with path.open("rb") as file:
        return file.read(MAX_BYTES + 1)


def _standard_input() -> bytes:
    """What standard input holds, as far as it may be a document; raises `UnusableError` alone."""
    if sys.stdin is None:
        raise UnusableError("is closed; allowed: a text, or a file instead of -")
    try:
        if sys.stdin.isatty():
            sys.stderr.write("reading from the terminal; Ctrl-D on a line of its own ends it\n")
        return sys.stdin.buffer.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:  # A closed one is a ValueError.
        raise UnusableError(f"cannot be read: {error}") from None


def called(name_or_path: str) -> str:
    """What a document is called that was named so on the command line."""
    if name_or_path == STDIN:
        return STDIN_NAME
    return printable(name_or_path, MAX_NAME) or "''"
