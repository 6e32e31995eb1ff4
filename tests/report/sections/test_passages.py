"""How soon variants got somewhere, in a report."""

import csv
from pathlib import Path
from typing import Any

import pytest

from app.metrics import PASSAGES
from tests.support.folders import add_run, new_folder
from tests.support.reports import page_of, pictures_of, text_of


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return new_folder(tmp_path / "results")


def numbers_of(folder: Path, title: str) -> list[dict[str, str]]:
    """The numbers of a panel of the picture."""
    with (folder / "report_figures" / "passages.csv").open(encoding="utf-8") as file:
        return [row for row in csv.DictReader(file) if row["panel"] == title]


def test_runs_that_have_got_there_are_drawn_by_steps(folder: Path) -> None:
    first, second = (*PASSAGES,)[:2]
    for seed in range(4):
        measured: dict[str, Any] = dict.fromkeys(PASSAGES)
        measured[first] = 500 * (seed + 1) if seed < 3 else None
        add_run(folder, seed, **measured)
        add_run(folder, seed, variant="b", overrides={"x": 0}, **measured)
    text = text_of(page_of(folder))
    assert "How soon it is reached" in text
    assert "Kaplan-Meier" in text
    rows = numbers_of(folder, PASSAGES[first])
    shares = [(row["line"], float(row["steps"]), row["share"]) for row in rows]
    assert shares[:3] == [("timed", 500, "0.25"), ("timed", 1000, "0.5"), ("timed", 1500, "0.75")]
    assert shares[3] == ("timed: ended before", 3000, None)
    assert {row["line"] for row in numbers_of(folder, PASSAGES[second])} == {
        "timed: ended before",
        "b: ended before",
    }


def test_the_thesis_learners_have_a_picture_for_each_of_its_worlds(folder: Path) -> None:
    for seed in range(2):
        add_run(folder, seed)
        add_run(folder, seed, preset="standard_q")
    text = text_of(page_of(folder))
    assert "Share of runs that have got there: grid 120 × 120, sensors 24 × 18" in text
    assert [name for name in pictures_of(folder) if "passages" in name] == ["passages_world_1"]


def test_without_a_milestone_there_is_no_picture(tmp_path: Path) -> None:
    folder = new_folder(tmp_path / "narrow", metrics=["mean_hunt_length"])
    for seed in range(2):
        add_run(folder, seed, steps_to_50=None)
    assert "How soon it is reached" not in text_of(page_of(folder))
