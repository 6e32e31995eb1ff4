"""Ways to read the thesis: which variants are such, and what depends on them."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.documents import experiments, presets
from app.results import readings, thesis
from app.results.findings import FAILS, HOLDS, UNDECIDED
from app.results.read import Group, Reader, groups_of, read_folder, widths_of
from app.results.readings import OWN, Dependence
from learners.spec import RunSpec
from sim.world import CAPTURE, FLIGHT
from tests.support.folders import add_run, new_folder
from tests.support.reports import page_of, table_of, text_of, without_pictures

PENALTY = "learner.spiral_penalty"
CHOICES: Mapping[str, Mapping[str, Any]] = {
    "as read here": {},
    "c = 0": {PENALTY: 0.0},
    "all learn": {"learner.skills_that_learn": "all"},
}


def groups_in(folder: Path) -> list[Group]:
    return groups_of(read_folder(folder).rows)


def add_readings(folder: Path, n_seeds: int = 2) -> None:
    """Timed under three readings, and three skills as read here alone."""
    for seed in range(n_seeds):
        for label, overrides in CHOICES.items():
            add_run(folder, seed, "timed", f"timed, {label}", overrides)
        add_run(folder, seed, "hierarchical_3", "hierarchical_3, as read here")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return new_folder(tmp_path / "reading")


def test_variants_of_open_points_are_readings_the_own_one_first(folder: Path) -> None:
    add_readings(folder)
    own, *others = readings.readings_of(groups_in(folder))
    assert (own.label, own.point) == (OWN, "")
    assert {reading.label: reading.point for reading in others} == {
        "c = 0": "what a circle is charged for coming nearer (c)",
        "all learn": "which skills learn at a step",
    }


def test_a_learner_that_was_run_once_is_the_same_under_all_readings(folder: Path) -> None:
    add_readings(folder)
    found = readings.readings_of(groups_in(folder))
    of_three = [reading.placed["120", "hierarchical_3"] for reading in found]
    assert all(list(runs) == list(of_three[0]) for runs in of_three)
    of_timed = [reading.placed["120", "timed"][0].variant for reading in found]
    assert len(set(of_timed)) == 3


@pytest.mark.parametrize(
    "other", [("timed", {"learner.alpha": 0.2}), ("hierarchical_2", {PENALTY: 0.1})]
)
def test_variants_of_anything_else_are_none(folder: Path, other: tuple[str, Any]) -> None:
    add_readings(folder)
    preset, overrides = other
    add_run(folder, 0, preset, f"{preset}, other", overrides)
    assert readings.readings_of(groups_in(folder)) == []


@pytest.mark.parametrize(
    ("verdicts", "standing"),
    [
        ({OWN: HOLDS, "a": HOLDS, "b": HOLDS}, "robust"),
        ({OWN: HOLDS, "a": HOLDS, "b": FAILS}, "fitted"),
        ({OWN: HOLDS, "a": UNDECIDED, "b": FAILS}, "fitted"),
        ({OWN: HOLDS, "a": UNDECIDED, "b": HOLDS}, "open"),
        ({OWN: FAILS, "a": HOLDS, "b": HOLDS}, "open"),
        ({OWN: UNDECIDED, "a": FAILS}, "open"),
    ],
)
def test_what_depends_on_the_reading(verdicts: Mapping[str, str], standing: str) -> None:
    found = Dependence(thesis.FINDINGS[0], verdicts)
    assert found.standing == standing
    assert list(found.failing) == [label for label, said in verdicts.items() if said == FAILS]


def test_the_shipped_experiment_is_of_open_points_alone() -> None:
    variants = experiments.load("reading").variants
    keys = {key for variant in variants for key in variant.overrides}
    assert keys == set(readings.OPEN_POINTS)
    of_timed = [variant.overrides for variant in variants if variant.preset == "timed"]
    of_three = [variant.overrides for variant in variants if variant.preset == "hierarchical_3"]
    assert of_timed == of_three
    assert {} in of_timed
    # Each other reading is another run: none of them is the lab's own in other words.
    specs: list[RunSpec] = [v.spec for v in variants if v.preset == "timed"]
    assert all(first != second for n, first in enumerate(specs) for second in specs[:n])


def test_a_report_tells_what_was_settled_and_what_comes_out(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    without_pictures(monkeypatch)
    n_trials = 2_500
    settings = {**presets.load("timed").model_dump(mode="json"), "trials": n_trials}
    for seed in range(2):
        for label, overrides in CHOICES.items():
            share = 0.2 if label == "c = 0" else 0.9
            outcome = np.where(
                np.random.default_rng(seed).random(n_trials) < share, CAPTURE, FLIGHT
            ).astype(np.int8)
            add_run(
                folder,
                seed,
                "timed",
                f"timed, {label}",
                overrides,
                arrays={"outcome": outcome, "steps": np.full(n_trials, 100, np.int32)},
                trials=n_trials,
                steps=100 * n_trials,
                settings=json.dumps({**settings, "label": label}),
            )
    page = page_of(folder)
    text = text_of(page)
    assert "How the thesis was read" in text
    rows = {row["reading"]: row for row in table_of(page, "what it settles otherwise")}
    assert next(iter(rows)) == OWN
    assert set(rows) == set(CHOICES)
    ends = {label: row["end of timed (reward) [95 %]"] for label, row in rows.items()}
    assert ends["as read here"] == ends["all learn"] != ends["c = 0"]
    assert float(ends["as read here"].split()[0]) == pytest.approx(85, abs=3)
    assert "Findings" not in text.splitlines()  # of the thesis's own figures


def test_a_quantity_without_its_runs_is_none(folder: Path) -> None:
    add_readings(folder)
    rows = read_folder(folder).rows
    reader = Reader(widths_of(rows), thesis.quantities_of)
    own, *_ = readings.readings_of(groups_of(rows))
    lead = readings.QUANTITIES[1]
    # Runs of three hundred trials have no last two thousand after 48,000.
    assert readings.quantity_of(lead, reader, own) is None
