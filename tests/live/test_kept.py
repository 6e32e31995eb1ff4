"""The folder of sessions: which there are, which is meant, and that they do not become too many."""

import contextlib
import os
from dataclasses import replace
from pathlib import Path

import pytest

from app import __version__
from app.live import kept
from app.live.journal import Journal
from app.live.kept import LATEST, begun, clear, default_folder, found, sessions_in
from app.live.records import Gave, Record, Stood
from app.live.written import SessionError, read, whole
from learners.commands import FreezeSkills
from tests.support.journals import COMMANDS, HEADER, RECORDS

STOOD = Stood(0, 700, 12, "ab" * 32, 500)
GAVE = Gave(0, 800, FreezeSkills(True))
BEGAN = RECORDS[0]


def written(folder: Path, name: str, at: float, *records: Record) -> Path:
    """A session that was last written at a time."""
    path = folder / name
    path.write_bytes(whole(HEADER, records))
    os.utime(path, (at, at))
    return path


def test_a_session_is_called_by_its_time_preset_and_seed(tmp_path: Path) -> None:
    with contextlib.closing(begun(tmp_path / "new", "../my üwn: preset" + "x" * 99, 7)) as journal:
        assert not journal.path.parent.exists()
        journal.note(BEGAN)
        journal.note(GAVE)
        name = journal.path.name
        assert name[17:] == "-my_wn_preset" + "x" * 28 + "-seed7.pounce"
        assert kept._NAMED_HERE.fullmatch(name)
        assert kept._NAMED_HERE.fullmatch(f"{name[:-7]}-2-saved3.pounce")
        (listed,) = sessions_in(tmp_path / "new")
        assert (listed.name, listed.in_use, listed.is_begun) == (name[:-7], True, True)
        assert listed.glance.header.version == __version__
        assert listed.glance.header.preset.startswith("../my üwn: preset")
    assert [listed.in_use for listed in sessions_in(tmp_path / "new")] == [False]


def test_sessions_are_listed_the_newest_first_with_what_was_done(tmp_path: Path) -> None:
    written(tmp_path, "a.pounce", 10, BEGAN, STOOD, GAVE, *RECORDS[-1:])
    written(tmp_path, "b.pounce", 30, *RECORDS)
    written(tmp_path, "c.pounce", 20, BEGAN)
    (tmp_path / "d.pounce").write_bytes(b"something else\n")
    (tmp_path / "e.pounce").mkdir()
    (tmp_path / "f.txt").write_bytes(whole(HEADER, RECORDS))
    listed = sessions_in(tmp_path)
    assert [session.name for session in listed] == ["b", "c", "a"]
    assert [(session.glance.trial, session.glance.n_commands) for session in listed] == [
        (12, len(COMMANDS) + 2),
        (0, 0),
        (12, 1),
    ]
    assert [session.is_begun for session in listed] == [True, False, True]
    assert sessions_in(tmp_path / "none") == []


def test_the_trial_is_that_of_the_live_run_whatever_was_written_of_branches(tmp_path: Path) -> None:
    of_branch = replace(STOOD, run=STOOD.run + 1, trial=STOOD.trial + 900)
    written(tmp_path, "a.pounce", 10, BEGAN, STOOD, of_branch)
    assert sessions_in(tmp_path)[0].glance.trial == STOOD.trial


def test_a_torn_or_damaged_session_is_listed_as_far_as_it_can_be(tmp_path: Path) -> None:
    path = written(tmp_path, "a.pounce", 10, BEGAN, STOOD)
    whole_data = path.read_bytes()
    path.write_bytes(whole_data + whole_data[-150:-1])
    assert sessions_in(tmp_path)[0].glance.trial == 12
    path.write_bytes(whole_data[:-20] + b"\n")
    assert sessions_in(tmp_path)[0].glance.trial == 0


def test_a_session_is_found_by_name_by_path_and_as_the_latest(tmp_path: Path) -> None:
    written(tmp_path, "a.pounce", 10, BEGAN, STOOD)
    latest = written(tmp_path, "b.pounce", 20, BEGAN, GAVE)
    written(tmp_path, "c.pounce", 30, BEGAN)
    assert found(LATEST, tmp_path) == latest
    for name in ("a", "a.pounce", str(tmp_path / "a.pounce")):
        assert found(name, tmp_path) == tmp_path / "a.pounce"
    assert found("none", tmp_path) == Path("none")
    with pytest.raises(SessionError, match="no session is kept there; allowed: the file of one"):
        found(LATEST, tmp_path / "none")
    with pytest.raises(SessionError, match="no folder has sessions here"):
        found(LATEST, None)


def test_the_oldest_are_deleted_but_for_those_in_use_or_renamed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = [f"2026-11-0{day}-120000-timed-seed0.pounce" for day in range(1, 8)]
    for at, name in enumerate(names, 1):
        written(tmp_path, name, at * 10, BEGAN)
    written(tmp_path, "for-the-lecture.pounce", 1, BEGAN)
    mine = f"{names[0].removesuffix('.pounce')}-lecture.pounce"
    written(tmp_path, mine, 2, BEGAN)
    clear(tmp_path)
    assert len(list(tmp_path.iterdir())) == 9
    monkeypatch.setattr(kept, "MOST_SESSIONS", 3)
    with contextlib.closing(Journal.going_on(read(tmp_path / names[1]))):
        clear(tmp_path)
        left = sorted(path.name for path in tmp_path.iterdir())
        assert left == [mine, names[1], *names[4:], "for-the-lecture.pounce"]
    monkeypatch.setattr(kept, "MOST_BYTES", 2 * len(whole(HEADER, [BEGAN])))
    clear(tmp_path)
    left = sorted(path.name for path in tmp_path.iterdir())
    assert left == [mine, *names[5:], "for-the-lecture.pounce"]


def test_the_folder_is_the_users_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", "/var/somewhere")
    assert default_folder() == Path("/var/somewhere/pounce/sessions")
    monkeypatch.setenv("HOME", "/home/somebody")
    for unusable in ("", "relative"):
        monkeypatch.setenv("XDG_STATE_HOME", unusable)
        assert default_folder() == Path("/home/somebody/.local/state/pounce/sessions")
