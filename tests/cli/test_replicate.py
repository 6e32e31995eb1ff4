"""The command ``pounce replicate``: what it runs and writes, and what it refuses."""

from collections.abc import Sequence
from pathlib import Path

import pytest

from app.cli import main
from app.documents import experiments
from app.replication import plan
from app.replication.page import HEADLINE_BEGINS, HEADLINE_ENDS

TEXT = """
presets:
  - {preset: timed, label: small, set: {world.size: 20}}
  - {preset: standard_q, label: other, set: {world.size: 20}}
trials: 3
steps: 100
seeds: 1
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the command runs; all of its experiments take no time."""

    def load(name: str, n_seeds: int | None = None) -> experiments.Experiment:
        return experiments.parse(TEXT, name, None, n_seeds)

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("app.replication.run.experiments.load", load)
    monkeypatch.setattr("app.replication.plan.EXPERIMENTS", ("one",))
    for module in ("plan", "write"):
        monkeypatch.setattr(f"app.replication.{module}.THESIS", ("one",))
    return tmp_path


def pages(here: Path) -> Path:
    """A folder of documentation with a page to be written anew, and its README."""
    docs = here / "docs"
    docs.mkdir()
    (docs / "replication.md").write_text("as it was", encoding="utf-8")
    (here / "README.md").write_text(f"{HEADLINE_BEGINS}\n{HEADLINE_ENDS}\n", encoding="utf-8")
    return docs


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--seeds", "2", "--docs", "docs"], "--seeds and --docs exclude each other"),
        (["--seeds", "0"], "--seeds"),
        (["--out", ""], "--out: '' is not allowed; allowed: a folder"),
        (["--docs", "nowhere"], "--docs: 'nowhere' is not allowed; allowed: a folder with a"),
        (["--beyond", "--docs", "docs"], "a folder with beyond.md and beyond/templates.md"),
        (["figure_4_1"], "'figure_4_1' is one word too many"),
    ],
)
def test_what_makes_no_sense_is_refused(
    words: Sequence[str], message: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pages(here)
    assert main.main(["replicate", *words]) == 2
    assert message in " ".join(capsys.readouterr().err.split())
    assert not (here / "results").exists()


def test_a_readme_without_a_place_for_the_headline_is_refused_before_anything_is_run(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pages(here)
    (here / "README.md").write_text("no place", encoding="utf-8")
    assert main.main(["replicate", "--docs", "docs"]) == 2
    assert "a README.md with a place for its headline" in " ".join(capsys.readouterr().err.split())
    assert not (here / "results").exists()


def test_all_is_run_and_reported_on(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["replicate", "--seeds", "2", "--workers", "1"]) == 0
    runs, page = capsys.readouterr().out.splitlines()
    assert runs.startswith("4 runs, ")
    assert page == "results/replication/report.html"
    assert (here / page).is_file()


def test_what_goes_beyond_the_thesis_is_run_by_itself(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.replication.plan.BEYOND", ("two",))
    assert main.main(["replicate", "--beyond", "--seeds", "2", "--workers", "1"]) == 0
    runs, page = capsys.readouterr().out.splitlines()
    assert runs.startswith("4 runs, ")
    assert page == "results/replication/two/report.html"
    assert (here / page).is_file()
    assert not (here / "results" / "replication" / "one").exists()


def test_a_folder_with_other_results_is_refused_and_kept(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = here / "results" / "replication" / "one"
    other.mkdir(parents=True)
    (other / "mine.txt").write_text("mine", encoding="utf-8")
    assert main.main(["replicate", "--workers", "1"]) == 2
    assert "--out" in capsys.readouterr().err
    assert (other / "mine.txt").read_text("utf-8") == "mine"


def test_pages_stay_as_they_are_where_something_did_not_come_out(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    docs = pages(here)
    monkeypatch.setattr("app.replication.write.write_reports", lambda *_: iter(()))
    monkeypatch.setattr("app.replication.numbers.EXPERIMENTS", (*plan.EXPERIMENTS, "another"))
    assert main.main(["replicate", "--docs", "docs", "--workers", "1"]) == 1
    assert "another" in capsys.readouterr().err
    assert (docs / "replication.md").read_text("utf-8") == "as it was"
