"""A session's file: what is in it after anything that may happen to it."""

import contextlib
import errno
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.live import journal as journal_module
from app.live import written as written_module
from app.live.journal import InUseError, Journal, is_in_use
from app.live.records import Gave, Record, Stood, WentLive
from app.live.written import DamagedError, SessionError, read, save, whole
from learners.commands import FreezeSkills
from tests.support.journals import HEADER, RECORDS, records

FEW = (RECORDS[0], RECORDS[4], RECORDS[12], *RECORDS[-4:])
SHORT = (*RECORDS[4:6], *RECORDS[-4:])
"""Without those that are long, so that each of their bytes can be tried."""
GAVE = Gave(0, 10, FreezeSkills(True))


def stood(step: int, run: int = 0) -> Stood:
    return Stood(run, step, step // 10, "ab" * 32, 500)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "one.pounce"


@pytest.fixture
def journal(path: Path) -> Iterator[Journal]:
    with contextlib.closing(Journal(path, HEADER)) as found:
        yield found


def read_of(path: Path, data: bytes) -> tuple[Record, ...]:
    """The records in a file, or those that could be saved of it."""
    path.write_bytes(data)
    try:
        return read(path).records
    except DamagedError as error:
        return error.saved.records if error.saved else ()
    except SessionError:
        return ()


# --- What is written is read ---------------------------------------------------------------------


def test_a_record_is_in_the_file_once_it_has_been_noted(path: Path, journal: Journal) -> None:
    for count, record in enumerate(RECORDS, 1):
        journal.note(record)
        assert journal.fault is None
        assert read(path).records == RECORDS[:count]
    found = read(path)
    assert (found.header, found.is_torn, found.n_bytes) == (HEADER, False, path.stat().st_size)
    assert path.read_bytes() == whole(HEADER, RECORDS)
    assert path.stat().st_mode & 0o077 == 0


@given(st.lists(records(), max_size=5))
def test_any_records_are_read_as_they_were(
    tmp_path_factory: pytest.TempPathFactory, some: list[Record]
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.pounce"
    assert read_of(path, whole(HEADER, some)) == tuple(some)


def test_what_is_noted_is_on_the_disk(
    path: Path, journal: Journal, monkeypatch: pytest.MonkeyPatch
) -> None:
    synced: list[int] = []
    fsync = os.fsync

    def note(file: int) -> None:
        fsync(file)
        synced.append(os.fstat(file).st_size)

    monkeypatch.setattr(os, "fsync", note)
    journal.note(FEW[0])
    journal.note(FEW[1])
    assert synced[-1] == path.stat().st_size


def test_two_sessions_of_one_name_have_a_file_each(path: Path, journal: Journal) -> None:
    journal.note(FEW[0])
    with contextlib.closing(Journal(path, HEADER)) as other:
        other.note(FEW[0])
        other.note(GAVE)
        assert other.path == path.with_name("one-2.pounce")
        assert read(other.path).records == (FEW[0], GAVE)
    assert read(path).records == FEW[:1]


# --- Damage --------------------------------------------------------------------------------------


def test_a_file_cut_off_at_any_byte_has_the_first_of_its_records(path: Path) -> None:
    data, ends = whole(HEADER, SHORT), []
    for count in range(len(SHORT) + 1):
        ends.append(len(whole(HEADER, SHORT[:count])))
    for length in range(len(data)):
        n_whole = sum(end <= length for end in ends) - 1
        path.write_bytes(data[:length])
        if n_whole < 0:
            with pytest.raises(SessionError, match="is no session of pounce"):
                read(path)
            continue
        found = read(path)
        assert found.records == SHORT[:n_whole]
        assert found.is_torn == (length not in ends)
        assert found.n_bytes == ends[n_whole]


@given(st.integers(0, len(whole(HEADER, SHORT)) - 1), st.integers(1, 255))
def test_another_byte_is_damage_or_a_torn_end_and_never_another_record(
    tmp_path_factory: pytest.TempPathFactory, place: int, change: int
) -> None:
    path, data = tmp_path_factory.getbasetemp() / "flipped.pounce", bytearray(whole(HEADER, SHORT))
    data[place] ^= change
    found = read_of(path, bytes(data))
    assert found == SHORT[: len(found)]
    n_before = bytes(data[:place]).count(b"\n") - 1
    assert len(found) <= max(n_before, 0)


def test_every_byte_that_is_flipped_is_noticed(path: Path) -> None:
    original = whole(HEADER, SHORT)
    for place in range(len(original)):
        changed = bytearray(original)
        changed[place] ^= 1 << place % 8
        path.write_bytes(changed)
        try:
            found = read(path)
        except SessionError:
            continue
        # No line but one without an end is taken for torn.
        assert found.is_torn
        assert place == len(original) - 1
        assert found.records == SHORT[:-1]


@pytest.mark.parametrize(
    "change",
    [
        lambda lines: [*lines[:2], *lines[3:]],
        lambda lines: [*lines[:2], lines[3], lines[2], *lines[4:]],
        lambda lines: [*lines[:3], lines[2], *lines[3:]],
        lambda lines: [*lines[:2], b"\n", *lines[2:]],
        lambda lines: [*lines[:2], b"\x00" * 600 + b"\n", *lines[2:]],
    ],
    ids=["left out", "moved", "twice", "empty line", "zeros"],
)
def test_lines_cannot_be_moved(path: Path, change: Callable[[list[bytes]], list[bytes]]) -> None:
    lines = whole(HEADER, FEW).splitlines(keepends=True)
    path.write_bytes(b"".join(change(lines)))
    with pytest.raises(DamagedError) as refused:
        read(path)
    assert refused.value.saved is not None
    found = refused.value.saved.records
    assert found == FEW[: len(found)]
    assert len(found) in (1, 2)


def test_what_comes_before_damage_is_saved_and_can_be_gone_on_with(path: Path) -> None:
    data = bytearray(whole(HEADER, FEW))
    data[len(whole(HEADER, FEW[:3])) + 40] ^= 1
    path.write_bytes(data)
    with pytest.raises(DamagedError) as refused:
        read(path)
    assert str(refused.value) == f"{path}: line 5 does not have the checksum that it states"
    assert refused.value.saved is not None
    saved = save(refused.value.saved)
    assert saved == path.with_name("one-saved.pounce")
    assert read(saved).records == FEW[:3]
    assert path.read_bytes() == data
    with contextlib.closing(Journal.going_on(read(saved))) as journal:
        journal.note(GAVE)
    assert read(saved).records == (*FEW[:3], GAVE)
    # It is not lost when the damaged one is tried again.
    assert save(refused.value.saved) == saved
    assert read(saved).records == (*FEW[:3], GAVE)
    saved.write_bytes(b"another")
    assert save(refused.value.saved) == path.with_name("one-saved2.pounce")


def forged(path: Path, line: bytes, after: int = 2) -> None:
    """Write a session with a line of one's own that has the right checksum."""
    lines = whole(HEADER, FEW).splitlines(keepends=True)[:after]
    former = lines[-1][8:24].decode() if lines else ""
    total = written_module._sum_of(former, line)
    path.write_bytes(b"".join(lines) + b'{"sum":"%b",%b\n' % (total.encode(), line))


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (b'"kind":"gave","run":0,"step":-5,"command":{"do":"Undo","number":0}}', "step: -5 is not"),
        (b'"kind":"sang"}', 'kind: "sang" is not allowed; allowed: began, gave'),
        (b"[" * 500_000, " is not JSON"),
        (b'"kind":' + b"9" * 5_000 + b"}", " is not JSON"),
        (b" " * 2**20 + b"}", " is not a line of a session"),
        (b'"kind":"gave","run":0,"step":NaN}', "step: "),
        (b"\xff", " is not JSON"),
    ],
)
def test_a_record_that_is_none_is_refused_whatever_its_checksum(
    path: Path, line: bytes, message: str
) -> None:
    forged(path, line)
    with pytest.raises(DamagedError) as refused:
        read(path)
    assert f"{path}: line 3" in str(refused.value)
    assert message in str(refused.value)
    assert refused.value.saved is not None
    assert refused.value.saved.records == FEW[:1]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (b'"pounce_session":2}', "line 1 pounce_session: 2 is not allowed; allowed: 1"),
        (b'"pounce_session":"' + b"9" * 5_000 + b'"}', "line 1 pounce_session: '999"),
        (b'"pounce_session":1}', "line 1 is not the first line of a session"),
        (b'"pounce":1}', "is no session of pounce"),
        (b"}", "is no session of pounce"),
    ],
)
def test_a_first_line_that_is_none_is_refused(path: Path, line: bytes, message: str) -> None:
    forged(path, line, after=0)
    with pytest.raises(SessionError) as refused:
        read(path)
    assert message in str(refused.value)
    assert len(str(refused.value)) < 300


def test_what_is_no_session_is_refused_before_it_is_read(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(SessionError, match=r"one\.pounce: is no file; allowed: a session"):
        read(path)
    os.mkfifo(path)
    with pytest.raises(SessionError, match="is no file"):
        read(path)
    path.unlink()
    for data in (b"", b"\n", b"\x00" * 100 + b"\n", b"world: {size: 30}\n", b'{"a": 1}\n'):
        path.write_bytes(data)
        with pytest.raises(SessionError, match=r"no session of pounce; allowed: a file \.pounce"):
            read(path)
    monkeypatch.setattr(written_module, "MAX_BYTES", 1_000)
    path.write_bytes(whole(HEADER, FEW))
    with pytest.raises(SessionError, match="is too large; allowed: up to 1,000 bytes"):
        read(path)


# --- Going on ------------------------------------------------------------------------------------


def test_a_session_goes_on_where_it_ended(path: Path) -> None:
    path.write_bytes(whole(HEADER, FEW[:3]) + b'{"sum":"01')
    found = read(path)
    assert found.is_torn
    with contextlib.closing(Journal.going_on(found)) as journal:
        journal.note(GAVE)
        assert (journal.fault, journal.path) == (None, path)
    assert path.read_bytes() == whole(HEADER, (*FEW[:3], GAVE))


def test_a_session_in_use_is_not_gone_on_with(path: Path, journal: Journal) -> None:
    journal.note(FEW[0])
    assert is_in_use(path)
    with pytest.raises(InUseError, match="another lab is at work on it; allowed: a session that"):
        Journal.going_on(read(path))
    journal.note(GAVE)
    journal.close()
    assert not is_in_use(path)
    with contextlib.closing(Journal.going_on(read(path))):
        assert is_in_use(path)


@pytest.mark.parametrize("data", [whole(HEADER, FEW[:1]), whole(HEADER, FEW[:4]), b""])
def test_a_session_that_has_changed_since_it_was_read_is_not_gone_on_with(
    path: Path, data: bytes
) -> None:
    path.write_bytes(whole(HEADER, FEW[:3]))
    found = read(path)
    path.write_bytes(data)
    with pytest.raises(SessionError):
        Journal.going_on(found)
    assert path.read_bytes() == data
    assert not is_in_use(path)


# --- A disk that is full, or cannot be written to ------------------------------------------------


def test_what_cannot_be_written_is_written_later_without_a_gap(
    path: Path, journal: Journal, monkeypatch: pytest.MonkeyPatch
) -> None:
    journal.note(FEW[0])
    pwrite = os.pwrite

    def full(file: int, data: bytes, at: int) -> int:
        if len(data) <= 30:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return pwrite(file, data[:30], at)

    monkeypatch.setattr(os, "pwrite", full)
    for record in FEW[1:4]:
        journal.note(record)
        assert journal.fault == "This session is not kept: no space left on device."
        # Of a record that was written in part, nothing is taken for one.
        found = read(path).records
        assert found == FEW[: len(found)]
    monkeypatch.setattr(os, "pwrite", pwrite)
    journal.note(FEW[4])
    assert journal.fault is None
    assert path.read_bytes() == whole(HEADER, FEW[:5])


def test_a_disk_that_is_full_for_long_is_owed_one_moment_alone(
    path: Path, journal: Journal, monkeypatch: pytest.MonkeyPatch
) -> None:
    journal.note(FEW[0])
    fsync = os.fsync

    def fail(_: int) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(os, "fsync", fail)
    for step in range(100):
        journal.stood(stood(step), at_rest=True)
    journal.note(WentLive(1))
    for step in range(100):
        journal.stood(stood(step, run=1), at_rest=True)
    monkeypatch.setattr(os, "fsync", fsync)
    journal.close()
    assert read(path).records == (FEW[0], stood(99), WentLive(1), stood(99, run=1))


def test_a_folder_that_cannot_be_made_is_made_once_it_can(tmp_path: Path) -> None:
    there = tmp_path / "file"
    there.write_text("")
    with contextlib.closing(Journal(there / "sessions" / "one.pounce", HEADER)) as journal:
        journal.note(FEW[0])
        assert journal.fault is not None
        assert journal.fault.startswith("This session is not kept: ")
        assert str(there) not in journal.fault
        there.unlink()
        journal.note(FEW[1])
        assert journal.fault is None
        assert read(journal.path).records == FEW[:2]


def test_a_file_that_is_taken_away_is_said(path: Path, journal: Journal) -> None:
    journal.note(FEW[0])
    path.unlink()
    journal.note(FEW[1])
    assert journal.fault is not None
    assert "the file has been taken away" in journal.fault


def test_a_session_that_is_as_long_as_one_may_be_says_so(
    path: Path, journal: Journal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(journal_module, "MAX_BYTES", 2**20)
    monkeypatch.setattr(journal_module, "MAX_LINE", 2**19)
    journal.note(FEW[0])
    before = path.read_bytes()
    monkeypatch.setattr(journal_module, "MAX_BYTES", len(before) + 10)
    journal.note(GAVE)
    journal.note(Gave(0, 11, FreezeSkills(False)))
    assert journal.fault is not None
    assert journal.fault.endswith("what is done from here on is not kept.")
    assert path.read_bytes() == before


def test_where_it_stands_is_written_farther_apart_the_older_a_session_is(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    now_s = 0.0
    monkeypatch.setattr(journal_module.time, "monotonic", lambda: now_s)
    with contextlib.closing(Journal(path, HEADER)) as journal:
        for step in range(5):
            now_s += 1.0
            journal.stood(stood(step))
        now_s += 1e6
        for step in range(5, 105):
            now_s += 1.0
            journal.stood(stood(step))
        journal.stood(stood(200), at_rest=True)
    steps = [record.step for record in read(path).records if isinstance(record, Stood)]
    assert steps == [0, 1, 2, 3, 4, 5, 56, 200]
