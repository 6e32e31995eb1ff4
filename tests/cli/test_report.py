"""The command ``pounce report``: which results it is about, what it says, and what it refuses."""

import contextlib
import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest

from app.cli import main
from tests.support.folders import add_run, new_folder
from tests.support.reports import without_pictures


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the command runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(autouse=True)
def pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    without_pictures(monkeypatch)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            [],
            "DIR is missing, and there are no results in 'results';"
            " allowed: a folder that pounce experiment has written",
        ),
        (["--compare"], "--compare: 0 folders were given; allowed: two"),
        (["a", "--compare"], "--compare: 1 folders were given; allowed: two"),
        (
            ["a", ""],
            "DIR: '' is not allowed; allowed: a folder that pounce experiment has written",
        ),
        (
            ["a", "--out", "experiment.yaml"],
            "--out: 'experiment.yaml' is not allowed; allowed: a file that ends in .html",
        ),
        (
            ["a", "--out", f"{'long ' * 20}.png"],
            "--out: 'long long long long long long long lo...' is not allowed;"
            " allowed: a file that ends in .html",
        ),
        (["a\0"], "DIR and --out: a path contains a NUL character; allowed: paths"),
    ],
)
def test_what_makes_no_sense_is_refused_in_lines_that_fit(
    words: Sequence[str], message: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["report", *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert " ".join(err.split()) == message
    assert max(map(len, err.splitlines())) <= 80
    assert list(here.iterdir()) == []


def test_a_folder_may_not_take_the_place_of_the_page(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "page.html").mkdir()
    assert main.main(["report", "a", "--out", "page.html"]) == 2
    assert capsys.readouterr().err == (
        "--out: 'page.html' is a folder; allowed: a file that ends in .html\n"
    )


def test_without_a_folder_it_is_the_latest_results(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = new_folder(here / "other")
    add_run(folder, 0)
    root = here / "results"
    for name, written_at in (("older", 1_000), ("newest", 3_000), ("old", 2_000)):
        shutil.copytree(folder, root / name)
        os.utime(root / name / "results.sqlite", (written_at, written_at))
    (root / "no results").mkdir()
    (root / "begun").mkdir()
    (root / "begun" / "results.sqlite").touch()
    assert main.main(["report"]) == 0
    page = Path("results", "newest", "report.html")
    assert capsys.readouterr().out == f"{page}\n"
    assert page.is_file()
    assert not (root / "old" / "report.html").exists()


def test_the_command_says_where_the_page_is(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = new_folder(here / "results with blanks, ünicode # and ?")
    add_run(folder, 0)
    out = here / "pages" / "of mine.html"
    assert main.main(["report", str(folder), "--out", str(out)]) == 0
    assert capsys.readouterr().out == f"{out}\n"
    assert out.is_file()
    assert (here / "pages" / "of mine_figures" / "curves.svg").is_file()


def test_of_an_unfinished_experiment_it_is_said_beside_the_answer(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = new_folder(here / "begun")
    add_run(folder, 0)
    assert main.main(["report", "begun"]) == 0
    out, err = capsys.readouterr()
    assert out == f"{Path('begun', 'report.html')}\n"
    assert err == "Unfinished: 1 of 3 runs.\n"


def test_what_is_being_done_is_shown_until_it_is_done(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[str] = []

    @contextlib.contextmanager
    def status() -> Iterator[Callable[[str], None]]:
        yield shown.append
        shown.append("gone")

    monkeypatch.setattr("app.cli.terminal.status", status)
    add_run(new_folder(here / "a"), 0)
    assert main.main(["report", "a"]) == 0
    assert "reading logs: 1 run" in shown
    assert shown[-2:] == ["writing the page", "gone"]


def test_two_folders_are_compared_beside_them(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("a", "b"):
        folder = new_folder(here / name)
        for seed in range(3):
            add_run(folder, seed)
    assert main.main(["report", "--compare", "a", "b"]) == 0
    assert capsys.readouterr().out == f"{Path('compare_a_b', 'report.html')}\n"
    assert not (here / "a" / "report.html").exists()


def test_a_folder_that_is_not_there_is_wrong_input(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["report", "missing"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err == "'missing' is no folder; allowed: one that pounce experiment has written\n"
