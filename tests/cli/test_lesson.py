"""The command ``pounce lesson``: which lessons there are, and the file that one begins with."""

import json
from pathlib import Path

import pytest

from app.cli import main
from app.documents import lessons

pytestmark = pytest.mark.usefixtures("here")


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


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["chek"], "ACTION: 'chek' is not allowed; allowed: list, "),
        (["list", "--out", "a.yaml"], "--out is of new"),
        (["new", "--json"], "--json is of list"),
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
