"""What twenty runs answered, kept on disk: it is computed once for each lesson and each code.

A file is named by all that decides what is in it, and carries a seal. One that is missing, damaged,
or of another shape than it should be is taken for not being there: then the runs are made again.
Nothing in it is ever run.
"""

import contextlib
import hashlib
import json
import logging
import os
import sys
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, Final, cast

from app.documents.lessons import Lesson
from app.lessons.reveals import Answer
from app.util.files import write_whole
from learners.spec import RunSpec
from sim.sources import SOURCE_DIGEST

log = logging.getLogger(__name__)

MOST_FILES: Final = 64
MOST_BYTES: Final = 2_000_000
"""Of one file."""
_SUFFIX: Final = ".answers.json"
_MOST_ITEMS: Final = 10_000
"""Of one answer."""

Answers = Mapping[str, tuple[Answer, ...]]
"""By card: what each run answers, one for each seed."""


def default_folder() -> Path | None:
    """The user's own, for what can be made again; None if there is no telling where that is."""
    stated = os.environ.get("NUMBA_CACHE_DIR", "") or os.environ.get("XDG_CACHE_HOME", "")
    if os.path.isabs(stated):
        return Path(stated) / "pounce" / "lessons"
    try:
        home = Path.home()
    except RuntimeError:
        return None
    of_platform = home / "Library" / "Caches" if sys.platform == "darwin" else home / ".cache"
    if sys.platform == "win32" and os.path.isabs(os.environ.get("LOCALAPPDATA", "")):
        of_platform = Path(os.environ["LOCALAPPDATA"])
    return of_platform / "pounce" / "lessons"


def digest_of(lesson: Lesson, specs: Iterable[RunSpec], seeds: Iterable[int]) -> str:
    """A name for what runs of a lesson answer: another one wherever that may be another.

    Args:
        lesson: its text and the run of its setup count.
        specs: of the runs that stand beside that.
        seeds: of the runs.
    """
    about = [lesson.digest, SOURCE_DIGEST, _code(), [*seeds]]
    about += [spec.model_dump_json() for spec in specs]
    return hashlib.sha256(json.dumps(about).encode()).hexdigest()


@lru_cache(maxsize=1)
def _code() -> str:
    """Of the code that measures, beside that of the runs, as it lies there."""
    total = hashlib.sha256()
    rooms = Path(__file__).parent.parent
    for room in ("lessons", "documents", "explain", "metrics"):
        for path in sorted((rooms / room).rglob("*.py")):
            with contextlib.suppress(OSError):
                total.update(f"{path.name} ".encode() + path.read_bytes())
    return total.hexdigest()


class Folder:
    """A folder of such files. It never fails: what cannot be read or written is not kept."""

    def __init__(self, path: Path) -> None:
        """Use a folder, which need not be there."""
        self._path = path

    def read(self, digest: str, n_runs: int) -> Answers | None:
        """What is kept under a name: so many answers for each card; None if nothing is."""
        path = self._path_of(digest)
        try:
            with path.open("rb") as file:
                data = file.read(MOST_BYTES + 1)
            found = _decoded(data, digest, n_runs)
        except (OSError, ValueError, RecursionError) as error:
            if not isinstance(error, FileNotFoundError):
                log.debug("%s is not to be read: %s", path, error)
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        return found

    def write(self, digest: str, answers: Answers) -> None:
        """Keep something under a name, in the place of what was longest not used."""
        payload = json.dumps(answers)
        seal = _seal_of(digest, payload)
        data = f"{seal}\n{payload}\n".encode()
        if len(data) > MOST_BYTES:
            return
        try:
            self._path.mkdir(parents=True, exist_ok=True)
            write_whole(self._path_of(digest), data)
            self._keep_few()
        except OSError as error:
            log.debug("%s cannot be written to: %s", self._path, error)

    def _path_of(self, digest: str) -> Path:
        return self._path / f"{digest[:32]}{_SUFFIX}"

    def _keep_few(self) -> None:
        paths = [*self._path.glob(f"*{_SUFFIX}")]
        paths.sort(key=lambda path: path.stat().st_mtime, reverse=True)
        for path in paths[MOST_FILES:]:
            path.unlink(missing_ok=True)


def _seal_of(digest: str, payload: str) -> str:
    return hashlib.sha256(f"{digest}\n{payload}".encode()).hexdigest()


def _decoded(data: bytes, digest: str, n_runs: int) -> Answers:
    """Raises `ValueError` if it is not what was written under that name."""
    if len(data) > MOST_BYTES:
        raise ValueError("it is too large")
    seal, _, payload = data.decode().partition("\n")
    payload = payload.removesuffix("\n")
    if seal != _seal_of(digest, payload):
        raise ValueError("it is damaged")
    found: Any = json.loads(payload)
    if not isinstance(found, dict):
        raise ValueError("it is of another shape")
    cards = cast("dict[str, Any]", found)
    return {card: _answers(value, n_runs) for card, value in cards.items()}


def _answers(value: Any, n_runs: int) -> tuple[Answer, ...]:
    items = cast("list[Any]", value) if isinstance(value, list) else []
    if len(items) != n_runs:
        raise ValueError("it is of another shape")
    return tuple(map(answer_from, items))


def answer_from(value: Any) -> Answer:
    """A run's answer from decoded JSON.

    Raises:
        ValueError: it is of no shape that an answer has.
    """
    if value is None or isinstance(value, str):
        return value
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    items = cast("list[Any]", value) if isinstance(value, list | tuple) else None
    if items is None or len(items) > _MOST_ITEMS:
        raise ValueError("it is of another shape")
    if all(isinstance(item, str) for item in items):
        return tuple(items)
    return tuple(map(_point, items))


def _point(item: Any) -> tuple[float, float]:
    pair = cast("list[Any]", item) if isinstance(item, list | tuple) else []
    is_number = [isinstance(x, int | float) and not isinstance(x, bool) for x in pair]
    if is_number != [True, True]:
        raise ValueError("it is of another shape")
    return float(pair[0]), float(pair[1])
