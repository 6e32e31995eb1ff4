"""Sessions from elsewhere: a file that somebody sent, or a link that holds all that is in one.

They are files of sessions like those that are kept (:mod:`app.live.written`), read by the same
reader and made again by the same maker. But anybody may have written them. So their length is
bounded before they are read, unpacked or parsed; each number in them before anything is made of it;
and so is what it takes to make all of it again.
"""

import base64
import binascii
import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Final

from app.live.records import Began, Branched, Gave, Record, Stood, WentLive
from app.live.story import MOST_CARDS, TookLesson
from app.live.written import SessionError, Written, read_data, with_sums, without_sums
from learners.commands import SetSchedule
from learners.names import MAX_TRIALS
from learners.schedule_spec import ScheduleSpec

MOST_BYTES: Final = 256 * 2**10
"""Of a file; a whole session with some hundred commands has a tenth of it."""
MOST_CHARACTERS: Final = 6_000
"""Of what a link holds: servers and proxies take addresses of some 8,000."""
MOST_STEPS: Final = 300_000_000
"""That may be made for one, which takes about a minute."""

_MOST_RECORDS: Final = 2_000
_MOST_RUNS: Final = 10_000
"""Numbers of runs are lower, and so are those of marks."""
_MOST_EPISODES: Final = 200
"""Of a schedule: each is compared with the others whenever a number is set."""
_LONGEST_NAME: Final = 100
_CODE: Final = re.compile(rf"[A-Za-z0-9_-]{{1,{MOST_CHARACTERS}}}")
_DIGEST: Final = re.compile(r"[0-9a-f]{64}")
_MOST: Final = {
    "run": _MOST_RUNS,
    "parent": _MOST_RUNS,
    "instead_of": _MOST_RUNS,
    "number": _MOST_RUNS,
    "step": MOST_STEPS,
    "trial": MAX_TRIALS,
    "until_trial": MAX_TRIALS,
    "start": MAX_TRIALS,
    "card": MOST_CARDS,
    "confidence": 100,
}
"""What the numbers of a record may be at most."""


# --- Links ---------------------------------------------------------------------------------------


def code_of(data: bytes) -> str:
    """What a link holds of a session, given its file.

    Raises:
        SessionError: it is too much for one.
    """
    packed = zlib.compress(without_sums(data), level=9)
    code = base64.urlsafe_b64encode(packed).decode().rstrip("=")
    if len(code) > MOST_CHARACTERS:
        raise SessionError(
            f"too much is in it for a link, {len(code):,} characters; allowed: up to"
            f" {MOST_CHARACTERS:,}, or the file"
        )
    return code


def is_code(text: str) -> bool:
    """Whether a text may be what a link holds; nothing is unpacked for that."""
    return _CODE.fullmatch(text) is not None


def read_link(code: str) -> Written:
    """The session that a link holds.

    Raises:
        SessionError: it holds none, or more than may be.
    """
    path = Path("the link")
    if not is_code(code):
        raise SessionError(f"{path}: is not one of pounce; allowed: a whole link to a session")
    unpacker = zlib.decompressobj()
    try:
        packed = base64.b64decode(code + "=" * (-len(code) % 4), b"-_", validate=True)
        lines = unpacker.decompress(packed, MOST_BYTES + 1)
    except (binascii.Error, zlib.error):
        lines = b""
    if len(lines) > MOST_BYTES:
        raise _too_large(path)
    if not lines or not unpacker.eof or unpacker.unused_data:
        raise SessionError(f"{path}: is not whole, or not one of pounce; allowed: all of it")
    return read_shared(path, with_sums(lines))


# --- Files ---------------------------------------------------------------------------------------


def read_file(path: Path) -> Written:
    """A session in a file that may be from elsewhere.

    Raises:
        SessionError: it cannot be read, or is none that may be opened.
    """
    try:
        # What is no file, such as a pipe, might never end or never begin.
        if not path.is_file():
            raise SessionError(f"{path}: is no file; allowed: a session that there is")
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise SessionError(f"{path}: cannot be read: {error.strerror or error}") from None
    return read_shared(path, data)


def read_shared(path: Path, data: bytes) -> Written:
    """A session from elsewhere, given all bytes of its file and what that is called.

    Raises:
        SessionError: it is none that may be opened; the message says why.
    """
    if len(data) > MOST_BYTES:
        raise _too_large(path)
    written = read_data(path, data)
    if len(written.records) > _MOST_RECORDS:
        raise SessionError(
            f"{path}: has {len(written.records):,} records; allowed: up to {_MOST_RECORDS:,}"
        )
    for place, record in enumerate(written.records):
        fault = _fault(record)
        if fault is not None:
            raise SessionError(f"{path}: line {place + 2}, {fault}")
    return replace(written, records=tuple(map(_without_source, written.records)))


def _without_source(record: Record) -> Record:
    """A record that names no file: presets of a lesson are looked for beside its file, and nobody
    else is to say which files of this machine are read."""
    return replace(record, source="") if isinstance(record, TookLesson) else record


def _too_large(path: Path) -> SessionError:
    return SessionError(
        f"{path}: is too large; allowed: up to {MOST_BYTES // 2**10} KiB (a session of one's own"
        " may have more, and is taken up with --resume)"
    )


def _fault(record: Record) -> str | None:
    """What no session of this program says; None if there is nothing of that."""
    for field in fields(record):
        most, value = _MOST.get(field.name), getattr(record, field.name)
        if most is not None and value is not None and value > most:
            return f"{field.name}: {value:,} is not allowed; allowed: up to {most:,}"
    for schedule in _schedules_of(record):
        if len(schedule.episodes) > _MOST_EPISODES:
            return f"episodes: there are more than {_MOST_EPISODES:,}, as many as there may be"
    if isinstance(record, Began) and not _is_name(record.preset):
        return f"preset: is no name; allowed: up to {_LONGEST_NAME} characters that can be read"
    if isinstance(record, Stood) and _DIGEST.fullmatch(record.digest) is None:
        return "digest: is none; allowed: 64 hexadecimal digits"
    return None


def _schedules_of(record: Record) -> Iterator[ScheduleSpec]:
    match record:
        case Began(spec=spec):
            yield spec.schedule
        case Gave(command=SetSchedule(schedule=schedule)):
            yield schedule
        case Branched(commands=commands):
            yield from (part.schedule for part in commands if isinstance(part, SetSchedule))
        case _:
            pass


def _is_name(text: str) -> bool:
    return 0 < len(text) <= _LONGEST_NAME and text.isprintable()


# --- What is in one ------------------------------------------------------------------------------


@dataclass(frozen=True)
class Contents:
    """What a session is told from others by, before it is made again."""

    preset: str
    seed: int
    n_lines: int
    """Runs, and branches of them."""
    n_commands: int
    """Given by hand, those by which lines branched off among them."""
    trial: int
    """In which the line was, as written down, that was live."""
    version: str
    """Of the pounce that wrote it."""


def contents_of(written: Written) -> Contents:
    """Look at what is in a session."""
    records = written.records
    began = next((record for record in reversed(records) if isinstance(record, Began)), None)
    branches = [record for record in records if isinstance(record, Branched)]
    live = next((r.run for r in reversed(records) if isinstance(r, Began | WentLive)), 0)
    stood = (r.trial for r in reversed(records) if isinstance(r, Stood) and r.run == live)
    gave = sum(isinstance(record, Gave) for record in records)
    return Contents(
        preset=written.header.preset if began is None else began.preset,
        seed=written.header.seed if began is None else began.seed,
        n_lines=sum(isinstance(record, Began) for record in records) + len(branches),
        n_commands=gave + sum(len(branch.commands) for branch in branches),
        trial=next(stood, 0),
        version=written.header.version,
    )
