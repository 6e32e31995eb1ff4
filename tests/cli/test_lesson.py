"""The command ``pounce lesson``: which there are, whether they hold, and their files."""

import json
from pathlib import Path

import pytest

from app.cli import main
from app.cli.lesson import template
from app.documents import lessons

pytestmark = pytest.mark.usefixtures("here")

NEVER = "{measure: success, above: 0.99, by: 1000}"
"""A check that does not come true."""


def begun(here: Path, name: str) -> str:
    """A new lesson, in a file; returns what it says."""
    (here / name).write_text(template(), "utf-8")
    return template()


def test_lessons_are_listed_in_the_order_in_which_they_are_taken(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main.main(["lesson"]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert rows[0].split() == ["lesson", "takes", "title", "in"]
    assert [row.split()[0] for row in rows[1:]] == list(lessons.shipped())
    assert all(row.endswith("en de") for row in rows[1:])


def test_what_is_listed_for_programs_is_what_the_files_say(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main.main(["lesson", "list", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["lessons"]
    assert [row["name"] for row in listed] == list(lessons.shipped())
    for row in listed:
        spec = lessons.load(row["name"]).spec
        assert (row["title"], row["minutes"]) == (spec.title, spec.minutes)
        assert (row["cards"], row["languages"]) == (len(spec.steps), ["en", "de"])
        assert set(row["needs"]) <= set(lessons.shipped())


def test_a_new_lesson_is_one_that_can_be_taught_as_it_is(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["lesson", "new", "--out", "mine.yaml"]) == 0
    assert capsys.readouterr().out == "mine.yaml\n"
    mine = lessons.load("./mine.yaml")
    kinds = {card.kind for card in mine.spec.steps}
    assert kinds == {"say", "ask", "do", "see", "why", "free"}
    # Each key that it has is explained on a line of its own, or goes without saying.
    text = (here / "mine.yaml").read_text("utf-8")
    assert text.count("\n  # ") >= len(mine.spec.steps)
    assert main.main(["lesson", "new"]) == 0
    assert capsys.readouterr().out == text


def test_a_lesson_that_holds_is_told_with_its_trials_and_its_file_gets_the_evidence(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = begun(here, "mine.yaml")
    assert main.main(["lesson", "check", "mine.yaml", "--seeds", "3", "--write"]) == 0
    said = capsys.readouterr().out
    assert "its check comes true   3/3    2,000  2,000  2,000" in said
    assert said.endswith("mine holds: 3 of 3 seeds pass.\n")
    after = (here / "mine.yaml").read_text("utf-8")
    assert after == before + "evidence: {seeds: 3, pass: 3}\n"
    assert main.main(["lesson", "check", "./mine.yaml", "--seeds", "2", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["lessons"]
    assert (found["lesson"], found["seeds"], found["pass"]) == ("mine", 2, 2)
    assert (here / "mine.yaml").read_text("utf-8") == after


def test_a_lesson_that_does_not_hold_ends_with_1_and_its_file_stays(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = begun(here, "mine.yaml").replace("{measure: trial, above: 1999}", NEVER)
    (here / "mine.yaml").write_text(text, "utf-8")
    assert main.main(["lesson", "check", "mine.yaml", "--seeds", "2", "--write"]) == 1
    out, err = capsys.readouterr()
    assert "learn: its check comes true with 0 of 2 seeds only, not with seed 0" in out
    assert "mine does not hold: 0 of 2 seeds pass." in out
    assert "nothing was written into its file" in err
    assert (here / "mine.yaml").read_text("utf-8") == text


def test_all_that_is_wrong_with_a_lesson_is_said_at_once_and_ends_with_2(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = begun(here, "mine.yaml").replace("minutes: 3", "minutes: 300")
    (here / "mine.yaml").write_text(text.replace("preset: timed", "preset: timd"), "utf-8")
    for words in (["check", "mine.yaml"], ["sheet", "mine.yaml", "--out", "a.html"]):
        assert main.main(["lesson", *words]) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert "mine.yaml:7: minutes: value 300" in err
        assert "did you mean timed?" in err
    assert not (here / "a.html").exists()


def test_a_sheet_is_written_in_the_language_that_is_asked_for(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    begun(here, "mine.yaml")
    words = ["--out", "a.html", "--language", "de", "--seeds", "1"]
    assert main.main(["lesson", "sheet", "mine.yaml", *words]) == 0
    assert capsys.readouterr().out == "a.html\n"
    page = (here / "a.html").read_text("utf-8")
    assert '<html lang="de">' in page
    assert "Was bringt Annähern allein?" in page
    # Nothing is left of what was being written.
    assert sorted(path.name for path in here.iterdir()) == ["a.html", "mine.yaml"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["chek"], "ACTION: 'chek' is not allowed; allowed: list, "),
        (["list", "--out", "a.yaml"], "--out is of new"),
        (["new", "--json"], "--json is of list and check, not of new"),
        (["check"], "LESSON is missing; allowed: a shipped lesson, a file, or --all"),
        (["check", "the_cone", "--all"], "LESSON is missing"),
        (["check", "the_con"], "is neither a shipped lesson nor a file (did you mean the_cone?"),
        (["check", "the_cone", "--seeds", "0"], "--seeds: '0' is not allowed"),
        (["check", "-", "--write"], "--write has no file to write into"),
        (["sheet", "--out", "a.html"], "LESSON is missing"),
        (["sheet", "the_cone"], "--out is missing; allowed: a file that ends in .html"),
        (["sheet", "the_cone", "--out", "a.pdf"], "--out: 'a.pdf' is not allowed"),
        (["sheet", "the_cone", "--out", "a.html", "--language", "fr"], "allowed: en, de"),
        (["new", "--out", "a.txt"], "--out: 'a.txt' is not allowed; allowed: a file that ends in"),
        (["new", "--out", "no/a.yaml"], "--out: 'no/a.yaml' is in no folder"),
        (["new", "--out", "there.yaml"], "--out: 'there.yaml' is there already"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_sentence(
    here: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    (here / "there.yaml").write_text("mine", "utf-8")
    assert main.main(["lesson", *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in " ".join(err.split())
    assert (here / "there.yaml").read_text("utf-8") == "mine"
    assert [path.name for path in here.iterdir()] == ["there.yaml"]
