"""What ``pounce lab`` is told of sessions: which it keeps, which it takes up, which it refuses."""

import contextlib
import socket
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from app.audience.audience import Audience
from app.cli import main
from app.cli.answers import UsageError
from app.live.journal import Journal
from app.live.kept import begun
from app.live.records import Began, Branched, Gave, NamedLine, Record, Stood
from app.live.session import Session
from app.live.written import Header, read, whole
from learners.commands import FreezeSkills, SetParameter, Undo
from learners.kernel.state import digest
from learners.run import replay
from tests.support.schedules import small_spec

pytestmark = pytest.mark.usefixtures("here")

SPEC, SEED = small_spec(), 5
HEADER = Header("1.2.3", "mine", SEED, "2026-11-29T15:00:00+00:00")
FREEZE, EPSILON = FreezeSkills(True), SetParameter("learner.epsilon", 0.3)
ENDED = replay(SPEC, SEED, [(300, FREEZE)], 900)
STOOD = Stood(0, 900, ENDED.trial, digest(ENDED.state), 500)
RECORDS: tuple[Record, ...] = (
    Began(0, "mine", SPEC, SEED),
    Gave(0, 300, FREEZE),
    Branched(1, 0, 500, (EPSILON,)),
    NamedLine(1, "looser"),
    STOOD,
)


@pytest.fixture
def folder(here: Path) -> Path:
    """The user's own sessions, of which there is one."""
    folder = here / "pounce" / "sessions"
    folder.mkdir(parents=True)
    (folder / "a.pounce").write_bytes(whole(HEADER, RECORDS))
    return folder


def told(capsys: pytest.CaptureFixture[str]) -> str:
    """What was said on standard error; a path that is longer than a line is broken there."""
    out, err = capsys.readouterr()
    assert out == ""
    return "".join(err.split())


def said(text: str) -> str:
    return "".join(text.split())


def test_a_session_is_kept_in_the_users_own_folder(
    here: Path, opened: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["lab", "hierarchical_2", "--seed", "3"]) == 0
    (call,) = opened
    assert told(capsys) == ""
    assert call["sessions"] == here / "pounce" / "sessions"
    assert call["journal"].path.parent == call["sessions"]
    assert call["journal"].path.name.endswith("-hierarchical_2-seed3.pounce")
    assert (call["made_again"], call["budget"].most_bytes) == (None, 64_000_000)
    # Nothing is made before there is something to keep.
    assert list(here.iterdir()) == []


def test_a_session_is_kept_elsewhere_or_not_at_all(
    here: Path, opened: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["lab", "--sessions", "lecture", "--past-memory", "200"]) == 0
    assert main.main(["lab", "--no-journal"]) == 0
    assert told(capsys) == ""
    assert opened[0]["journal"].path.parent == Path("lecture")
    assert opened[0]["budget"].most_bytes == 200_000_000
    assert opened[1]["journal"] is None
    assert list((here / "lecture").iterdir()) == []


@pytest.mark.parametrize(
    "words",
    [
        ["--resume"],
        ["lab", "--resume"],
        ["lab", "--resume", "--no-browser"],
        ["lab", "--resume", "a"],
        ["lab", "--resume=a.pounce"],
        ["lab", "--no-browser", "--resume", "latest", "--port", "0"],
        ["lab", "--resume", "--no-journal"],
    ],
)
def test_a_session_is_taken_up_where_it_ended(
    folder: Path,
    opened: list[dict[str, Any]],
    capsys: pytest.CaptureFixture[str],
    words: Sequence[str],
) -> None:
    assert main.main(words) == 0
    assert told(capsys) == ""
    (call,) = opened
    assert (call["spec"], call["preset"], call["seed"]) == (SPEC, "mine", SEED)
    assert call["opening"] is False
    family = call["made_again"].family
    assert digest(family.held.run.state) == STOOD.digest
    assert [line.name for line in family.lines.values()] == ["first run", "looser"]
    if "--no-journal" in words:
        assert call["journal"] is None
    else:
        assert call["journal"].path == folder / "a.pounce"


def test_a_torn_record_is_said_and_cut_off(
    folder: Path, opened: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    path = folder / "a.pounce"
    path.write_bytes(path.read_bytes()[:-1])
    assert main.main(["lab", "--resume"]) == 0
    assert said("its last record was torn when the lab was killed, and is dropped") in told(capsys)
    assert opened[0]["made_again"].family.held.run.step == 500


def test_tables_that_are_not_those_recorded_are_said(
    folder: Path, opened: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = replace(STOOD, digest="ab" * 32)
    (folder / "a.pounce").write_bytes(whole(HEADER, (*RECORDS[:-1], wrong)))
    assert main.main(["lab", "--resume"]) == 0
    assert told(capsys) == said(
        "Warning: first run is not what was recorded: this pounce learns otherwise than 1.2.3."
        " pounce replay says from where on."
    )
    assert len(opened) == 1


def damaged(folder: Path) -> None:
    path = folder / "a.pounce"
    data = bytearray(path.read_bytes())
    data[len(whole(HEADER, RECORDS[:3])) + 50] ^= 1
    path.write_bytes(data)


def inconsistent(folder: Path) -> None:
    (folder / "a.pounce").write_bytes(whole(HEADER, (*RECORDS[:3], Gave(0, 600, Undo(9)))))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (damaged, "line 5 does not have the checksum that it states"),
        (inconsistent, "line 5: nothing was done by hand under the number 9"),
    ],
)
def test_a_damaged_session_is_refused_with_what_could_be_saved(
    folder: Path,
    opened: list[dict[str, Any]],
    capsys: pytest.CaptureFixture[str],
    change: Callable[[Path], None],
    reason: str,
) -> None:
    change(folder)
    assert main.main(["lab", "--resume"]) == 2
    assert told(capsys) == said(
        f"--resume: {folder}/a.pounce: {reason}; the 3 records before it are saved in"
        f" {folder}/a-saved.pounce; allowed: that one"
    )
    assert opened == []
    assert read(folder / "a-saved.pounce").records == RECORDS[:3]
    assert main.main(["lab", "--resume", "a-saved"]) == 0
    assert opened[0]["made_again"].family.held.run.step == 500


def test_a_session_in_use_is_refused(
    folder: Path, opened: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    with contextlib.closing(Journal.going_on(read(folder / "a.pounce"))):
        assert main.main(["lab", "--resume"]) == 2
    assert told(capsys) == said(
        f"--resume: {folder}/a.pounce: another lab is at work on it; allowed: a session that is"
        " over"
    )
    assert opened == []


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--resume"], "--resume: {}/pounce/sessions: no session is kept there; allowed: the file"),
        (["--resume", "none"], "--resume: none: is no file; allowed: a session that there is"),
        (["--resume", "text"], "--resume: text: is no session of pounce; allowed: a file .pounce"),
        (["--resume", "a", "--seed", "3"], "--resume goes on with a session's own preset and"),
        (["standard_q", "--resume"], "--resume goes on with a session's own preset and seed;"),
        (["--sessions", "text"], "--sessions: 'text' is not allowed; allowed: a folder"),
        (["--sessions", "a", "--no-journal"], "--sessions and --no-journal exclude each other;"),
        (["--past-memory", "0"], "--past-memory: '0' is not allowed; allowed: a whole number, 1"),
        (["--audience", "8090"], "--audience: '8090' is not allowed; allowed: an address of this"),
        (["--audience", ":8090"], "--audience: ':8090' is not allowed; allowed: an address of"),
        (["--audience", "0.0.0.0:x"], "--audience: 'x' is not allowed; allowed: a whole number"),
        (["--no-code"], "--no-code is about the code of --audience; allowed: with that"),
        (["--own"], "--own is about those who look with --audience; allowed: with that"),
        (["--class"], "--class is about those who look with --audience; allowed: with that"),
        (["--sessions", "text/in"], "--sessions: 'text/in' cannot be written to: Not a directory"),
    ],
)
def test_what_makes_no_sense_is_refused(
    here: Path,
    opened: list[dict[str, Any]],
    capsys: pytest.CaptureFixture[str],
    words: Sequence[str],
    message: str,
) -> None:
    (here / "text").write_text("nothing of ours\n")
    assert main.main(["lab", *words]) == 2
    assert told(capsys).startswith(said(message.format(here)))
    assert opened == []


def test_a_user_without_a_folder_is_told_that_nothing_is_kept(
    opened: list[dict[str, Any]],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def nowhere() -> Path:
        raise RuntimeError

    monkeypatch.setattr("app.live.kept.default_folder", nowhere)
    assert main.main(["lab"]) == 0
    assert said("this session is not kept, as there is no telling") in told(capsys)
    assert (opened[0]["journal"], opened[0]["sessions"]) == (None, None)


def test_a_lab_that_cannot_be_opened_leaves_no_file(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["lab", "--host", "192.0.2.1", "--sessions", "lecture"]) == 2
    assert "cannot be listened on" in capsys.readouterr().err
    assert list((here / "lecture").iterdir()) == []


def test_a_session_in_which_nothing_was_done_leaves_no_file(tmp_path: Path) -> None:
    journal = begun(tmp_path / "new", "timed", 0)
    journal.note(RECORDS[0])
    journal.stood(Stood(0, 0, 0, "", 500), at_rest=True)
    assert journal.path.exists()
    journal.close()
    assert not journal.path.exists()


# --- A file that somebody shared -----------------------------------------------------------------


@pytest.fixture
def theirs(here: Path) -> Path:
    """A session that somebody shared."""
    path = here / "theirs.pounce"
    path.write_bytes(whole(HEADER, RECORDS))
    return path


@pytest.mark.parametrize("words", [[], ["--no-journal"]])
def test_a_shared_session_is_opened_as_one_of_its_own(
    here: Path,
    theirs: Path,
    opened: list[dict[str, Any]],
    capsys: pytest.CaptureFixture[str],
    words: Sequence[str],
) -> None:
    assert main.main(["lab", "theirs.pounce", *words]) == 0
    out, err = capsys.readouterr()
    assert said(out) == said(
        "theirs.pounce: mine, seed 5; 2 commands; 2 lines, the live one up to trial"
        f" {ENDED.trial}; written by pounce 1.2.3. Digest as recorded: same."
    )
    assert err == ""
    (call,) = opened
    assert (call["spec"], call["preset"], call["seed"]) == (SPEC, "mine", SEED)
    family = call["made_again"].family
    assert digest(family.held.run.state) == STOOD.digest
    assert theirs.read_bytes() == whole(HEADER, RECORDS)
    kept = [*here.glob("pounce/sessions/*-mine-seed5.pounce")]
    if words:
        assert (call["journal"], kept) == (None, [])
    else:
        assert kept == [call["journal"].path]
        assert read(kept[0]).records == RECORDS
        assert main.main(["lab", "--resume"]) == 0


def test_a_shared_session_that_is_not_as_recorded_is_opened_with_a_word(
    here: Path, theirs: Path, opened: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    theirs.write_bytes(whole(HEADER, (*RECORDS[:-1], replace(STOOD, digest="ab" * 32))))
    assert main.main(["lab", "theirs.pounce"]) == 0
    assert said("Warning: Digest as recorded: differs (first run). Pounce") in said(
        capsys.readouterr().err
    )
    # What is kept of it is true here.
    (kept,) = here.glob("pounce/sessions/*.pounce")
    assert read(kept).records == RECORDS


@pytest.mark.parametrize(
    ("data", "words", "message"),
    [
        (b"", [], "PRESET: theirs.pounce: is no session of pounce; allowed: a file .pounce"),
        (whole(HEADER, RECORDS[1:]), [], "PRESET: theirs.pounce: line 2: run 0 is not live"),
        (bytes(300_000), [], "PRESET: theirs.pounce: is too large; allowed: up to 256 KiB"),
        (None, [], "PRESET: theirs.pounce: is no file; allowed: a session that there is"),
        (b"", ["--seed", "3"], "--seed: a session has a seed of its own; allowed: the file alone"),
        (b"", ["--resume"], "--resume goes on with a session's own preset and seed;"),
    ],
)
def test_what_cannot_be_opened_is_refused(
    here: Path,
    opened: list[dict[str, Any]],
    capsys: pytest.CaptureFixture[str],
    data: bytes | None,
    words: Sequence[str],
    message: str,
) -> None:
    if data is not None:
        (here / "theirs.pounce").write_bytes(data)
    assert main.main(["lab", "theirs.pounce", *words]) == 2
    assert told(capsys).startswith(said(message))
    assert opened == []
    assert [*here.glob("pounce/sessions/*")] == []


# --- Its audience --------------------------------------------------------------------------------


def opened_stand(call: dict[str, Any]) -> Audience:
    """The port for an audience, as the lab would open it."""
    stand = call["opens_stand"](Session(SPEC, "mine", SEED, 1_000.0, False))
    assert isinstance(stand, Audience)
    return stand


@pytest.mark.parametrize(
    ("words", "host", "has_code"),
    [
        (["--audience", "127.0.0.1:0"], "127.0.0.1", False),
        (["--audience", "localhost:0"], "127.0.0.1", False),
        (["--audience", "0.0.0.0:0"], "0.0.0.0", True),
        (["--audience", "0.0.0.0:0", "--no-code"], "0.0.0.0", False),
        (["--audience", "127.0.0.1:0", "--class"], "127.0.0.1", True),
        (["--audience", "127.0.0.1:0", "--own"], "127.0.0.1", False),
        (["--audience", "127.0.0.1:0", "--class", "--own"], "127.0.0.1", True),
        (["--audience", "127.0.0.1:0", "--class", "--no-code"], "127.0.0.1", False),
    ],
)
def test_an_audience_that_others_can_reach_is_asked_for_a_code(
    opened: list[dict[str, Any]],
    capsys: pytest.CaptureFixture[str],
    words: Sequence[str],
    host: str,
    has_code: bool,
) -> None:
    assert main.main(["lab", "--no-journal", *words]) == 0
    warned = told(capsys)
    assert bool(warned) == (host == "0.0.0.0" and "--no-code" in words)
    stand = opened_stand(opened[0])
    try:
        assert (stand.code is not None) == has_code
        assert (stand.classroom is not None) == ("--class" in words)
        assert (stand.own is not None) == ("--own" in words)
        if stand.code is not None:
            assert len(stand.code) == (6 if "--class" in words else 9)
        assert stand.addresses[0] == f"http://127.0.0.1:{stand.watchers.port}"
        assert (opened[0]["host"], opened[0]["token"]) == ("127.0.0.1", None)
    finally:
        stand.close()


def test_an_audience_whose_port_is_busy_is_told(opened: list[dict[str, Any]]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as busy:
        place = f"127.0.0.1:{busy.getsockname()[1]}"
        assert main.main(["lab", "--no-journal", "--audience", place]) == 0
        with pytest.raises(UsageError, match="cannot be listened on"):
            opened_stand(opened[0])


def test_a_lesson_is_begun_with_or_all_is_said_that_is_wrong_with_it(
    here: Path, opened: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["lab", "--lesson", "the_cone"]) == 0
    (call,) = opened
    assert call["lesson"].name == "the_cone"
    assert told(capsys) == ""
    (here / "bad.yaml").write_text("title: [1]\n", encoding="utf-8")
    assert main.main(["lab", "--lesson", "bad.yaml"]) == 2
    message = told(capsys)
    assert "title" in message
    assert "steps" in message
    assert main.main(["lab", "--lesson", "the_coen"]) == 2
    assert "the_cone" in told(capsys)
