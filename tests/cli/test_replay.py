"""The command ``pounce replay``: what it says of a session, and which it refuses."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from app.cli import main
from app.live.records import Began, Branched, Gave, Record, Stood, WentLive
from app.live.written import Header, read, whole
from learners.commands import FreezeSkills, SetParameter, Undo
from learners.kernel.state import digest
from learners.run import replay
from tests.support.schedules import small_spec

pytestmark = pytest.mark.usefixtures("here")

SPEC, SEED = small_spec(), 5
HEADER = Header("1.2.3", "timed", SEED, "2026-11-29T15:00:00+00:00")
FREEZE, EPSILON = FreezeSkills(True), SetParameter("learner.epsilon", 0.3)
ENDED = replay(SPEC, SEED, [(300, FREEZE)], 900)
STOOD = Stood(0, 900, ENDED.trial, digest(ENDED.state), 500)
RECORDS: tuple[Record, ...] = (
    Began(0, "timed", SPEC, SEED),
    Gave(0, 300, FREEZE),
    STOOD,
    Branched(1, 0, 500, (EPSILON,)),
    WentLive(1, 600),
)


def written(path: Path, *records: Record) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(whole(HEADER, records or RECORDS))
    return path


def document(capsys: pytest.CaptureFixture[str], *words: str, code: int = 0) -> dict[str, Any]:
    assert main.main(["replay", *words, "--json"]) == code
    out, err = capsys.readouterr()
    assert err == ""
    return json.loads(out)


def test_it_says_of_every_line_where_it_stands_and_whether_that_was_recorded(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(here / "one.pounce")
    found = document(capsys, "one.pounce")
    own = replay(SPEC, SEED, [(300, FREEZE), (500, EPSILON)], 600)
    assert found == {
        "session": "one.pounce",
        "version": "1.2.3",
        "preset": "timed",
        "seed": SEED,
        "began": "2026-11-29T15:00:00+00:00",
        "records": 5,
        "torn": False,
        "until": None,
        "same": True,
        "live": 1,
        "lines": [
            {
                "line": 0,
                "name": "first run",
                "deleted": False,
                "preset": "timed",
                "seed": SEED,
                "parent": None,
                "fork_step": 0,
                "step": 900,
                "trial": ENDED.trial,
                "digest": digest(ENDED.state),
                "commands": 1,
                "compared": 1,
                "same": True,
                "difference": None,
            },
            {
                "line": 1,
                "name": "ε 0.3",
                "deleted": False,
                "preset": "timed",
                "seed": SEED,
                "parent": 0,
                "fork_step": 500,
                "step": 600,
                "trial": own.trial,
                "digest": digest(own.state),
                "commands": 2,
                "compared": 0,
                "same": None,
                "difference": None,
            },
        ],
    }
    assert main.main(["replay", str(path)]) == 0
    out, _ = capsys.readouterr()
    assert max(map(len, out.splitlines())) <= max(80, len(str(path)) + 2)
    rows = [" ".join(line.split()) for line in out.splitlines()]
    assert "line began step trial digest as recorded" in rows
    assert f"0 first run 900 {ENDED.trial} {digest(ENDED.state)[:12]} yes" in rows
    assert (
        f"1 ε 0.3 (live) line 0, step 500 600 {own.trial} {digest(own.state)[:12]} none was" in rows
    )


def test_it_stops_where_it_is_told_to(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written(here / "one.pounce")
    found = document(capsys, "one.pounce", "--until", "400")
    (line,) = found["lines"]
    assert (found["until"], line["step"], line["same"]) == (400, 400, None)
    assert line["digest"] == digest(replay(SPEC, SEED, [(300, FREEZE)], 400).state)


@pytest.mark.parametrize("word", ["latest", "two", "two.pounce"])
def test_a_session_is_found_in_its_folder(
    here: Path, capsys: pytest.CaptureFixture[str], word: str
) -> None:
    path = written(here / "pounce" / "sessions" / "two.pounce")
    assert document(capsys, word)["session"] == str(path)
    other = written(here / "lecture" / "two.pounce")
    assert (
        document(capsys, word, "--sessions", "lecture")["session"]
        == str(other)[len(str(here)) + 1 :]
    )


def test_a_difference_names_the_command_and_is_a_failure(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    earlier = replay(SPEC, SEED, [], 200)
    same = Stood(0, 200, earlier.trial, digest(earlier.state), 500)
    wrong = replace(STOOD, digest="ab" * 32)
    written(here / "one.pounce", RECORDS[0], same, RECORDS[1], wrong)
    found = document(capsys, "one.pounce", code=1)
    (line,) = found["lines"]
    assert (found["same"], line["same"]) == (False, False)
    assert line["difference"] == {
        "same_step": 200,
        "step": 900,
        "trial": ENDED.trial,
        "digest": digest(ENDED.state),
        "recorded_trial": ENDED.trial,
        "recorded_digest": "ab" * 32,
        "given": [{"step": 300, "command": {"do": "FreezeSkills", "frozen": True}}],
    }
    assert main.main(["replay", "one.pounce"]) == 1
    out = " ".join(capsys.readouterr().out.split())
    assert f"0 first run (live) 900 {ENDED.trial} {digest(ENDED.state)[:12]} NO" in out
    assert "Line 0 is not as recorded. At step 200 it still was. At step 900" in out
    assert out.endswith("It came after this command: skills frozen (step 300).")
    written(here / "one.pounce", RECORDS[0], replace(same, digest="ab" * 32))
    assert main.main(["replay", "one.pounce"]) == 1
    assert "No command was given in between: this pounce learns otherwise." in " ".join(
        capsys.readouterr().out.split()
    )


def test_a_torn_record_is_said(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(here / "one.pounce")
    path.write_bytes(path.read_bytes()[:-9])
    assert main.main(["replay", "one.pounce"]) == 0
    _, err = capsys.readouterr()
    assert " ".join(err.split()) == (
        "Warning: one.pounce: its last record was torn when the lab was killed, and is dropped:"
        " nobody had been told that it was done."
    )


def test_a_damaged_session_is_refused_with_what_could_be_saved(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(here / "one.pounce")
    data = bytearray(path.read_bytes())
    data[len(whole(HEADER, RECORDS[:2])) + 50] ^= 1
    path.write_bytes(data)
    assert main.main(["replay", "one.pounce"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert " ".join(err.split()) == (
        "SESSION: one.pounce: line 4 does not have the checksum that it states; the 2 records"
        " before it are saved in one-saved.pounce; allowed: that one"
    )
    assert read(here / "one-saved.pounce").records == RECORDS[:2]
    assert document(capsys, "one-saved.pounce")["records"] == 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "SESSION is missing; allowed: a session's file or name, or latest"),
        (["none"], "SESSION: none: is no file; allowed: a session that there is"),
        (["a\0b"], "SESSION: a\\x00b: is no file; allowed: a session that there is"),
        (
            ["text.pounce"],
            "SESSION: text.pounce: is no session of pounce; allowed: a file .pounce of a lab",
        ),
        (["latest"], "SESSION: pounce/sessions: no session is kept there; allowed: the file of"),
        (["latest", "--sessions", ""], "--sessions: '' is not allowed; allowed: a folder"),
        (["x", "--sessions", "text.pounce"], "--sessions: 'text.pounce' is not allowed"),
        (["x", "--sessions", "a\0b"], "--sessions: 'a\\x00b' is not allowed; allowed: a folder"),
        (["one", "--until", "-1"], "--until: '-1' is not allowed; allowed: a whole number, 0 to"),
    ],
)
def test_what_makes_no_sense_is_refused(
    words: Sequence[str],
    message: str,
    here: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (here / "text.pounce").write_text("nothing of ours\n")
    assert main.main(["replay", *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    # A path that is longer than a line is broken.
    told = "".join(err.split()).replace(f"{here}/", "")
    assert told.startswith("".join(message.split()))


def test_records_that_do_not_go_together_are_a_failure(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    written(here / "one.pounce", RECORDS[0], Gave(0, 10, Undo(3)))
    assert main.main(["replay", "one.pounce"]) == 1
    assert " ".join(capsys.readouterr().err.split()) == (
        "one.pounce: record 2: the command is refused now: nothing was done by hand under the"
        " number 3"
    )
