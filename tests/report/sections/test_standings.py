"""Learners that were run in the same worlds, in a report."""

import csv
from pathlib import Path

import pytest

from app.report.sections.standings import field_of
from app.results.read import Group
from tests.support.folders import add_run, new_folder
from tests.support.reports import page_of, pictures_of, text_of

WORLDS = {"standard": {}, "size 60": {"world.size": 60}}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = new_folder(tmp_path / "results")
    for preset, share in (("standard_q", 0.0), ("timed", 0.5), ("feudal", 1.0)):
        for world, overrides in WORLDS.items():
            for seed in range(3):
                variant = f"{preset}, {world}"
                add_run(folder, seed, preset, variant, overrides, share if overrides else 1 - share)
    return folder


def test_learners_stand_below_one_another_by_their_area_in_the_first_world(folder: Path) -> None:
    text = text_of(page_of(folder))
    assert "Learners and worlds" in text
    assert "standings" in pictures_of(folder)
    with (folder / "report_figures" / "standings.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if "area" in row["quantity"]]
    by_learner = [(row["row"], row["world"]) for row in rows]
    assert by_learner[0] == ("standard_q", "standard")
    assert by_learner == [(p, w) for p in ("standard_q", "timed", "feudal") for w in WORLDS]
    assert float(rows[0]["value"]) == float(rows[-1]["value"]) == 100


def group(preset: str, world: str, **overrides: object) -> Group:
    return Group(f"{preset}, {world}", preset, overrides)


def test_variants_of_one_learner_are_no_field() -> None:
    worlds = [group("timed", str(size), **{"world.size": size}) for size in (60, 120)]
    assert field_of(worlds) is None


def test_a_world_that_a_learner_lacks_makes_it_no_field() -> None:
    presets = ("timed", "feudal", "q_lambda")
    every = [group(p, str(size), **{"world.size": size}) for p in presets for size in (60, 120)]
    assert field_of(every) is not None
    assert field_of(every[:-1]) is None


def test_settings_of_a_learner_are_no_world() -> None:
    presets = ("timed", "feudal", "q_lambda")
    every = [
        group(p, str(alpha), **{"learner.alpha": alpha}) for p in presets for alpha in (0.1, 0.2)
    ]
    assert field_of(every) is None
