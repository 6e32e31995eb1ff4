"""The chart as a file shows what the browser looks at: the same names, the same runs."""

import csv
import io
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pytest

from app.charts import downloads
from app.charts.downloads import drawing_of, numbers_of
from app.charts.paper.drawing import Drawing
from app.charts.view import View
from app.documents.experiments import Experiment
from app.results.gather import PlacedRun
from app.util import csv_texts
from tests.support.runs import PLANE, THESIS, experiment_of, filled, reward, some_runs


def rows_of(experiment: Experiment, runs: Sequence[PlacedRun], view: View) -> list[dict[str, str]]:
    """The numbers of the chart, which are those of its drawing."""
    gatherer = filled(experiment, runs)
    drawing = drawing_of(gatherer, gatherer.gathering(), view)
    assert drawing.png.startswith(b"\x89PNG")
    assert drawing.csv == csv_texts.for_programs(numbers_of(gatherer, gatherer.gathering(), view))
    return list(csv.DictReader(io.StringIO(drawing.csv)))


class Asked(NamedTuple):
    """What is asked to be drawn."""

    chart: Any
    small: str


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Asked]:
    """What is asked to be drawn, in order."""
    found: list[Asked] = []
    draw = downloads.drawn

    def kept(name: str, chart: Any, small: str) -> Drawing:
        found.append(Asked(chart, small))
        return draw(name, chart, small)

    monkeypatch.setattr(downloads, "drawn", kept)
    return found


def test_every_run_is_a_dot_beside_its_mean(asked: list[Asked]) -> None:
    experiment = experiment_of(THESIS)
    runs = some_runs(experiment, 3)
    rows_of(experiment, runs, View("runs"))
    (dots,) = asked[0].chart.columns.values()
    assert [dot.label for dot in dots] == [v.label for v in experiment.variants]
    assert [[run.value for run in dot.runs] for dot in dots] == [
        [reward(run) for run in runs if run[0] == place] for place in range(4)
    ]


def test_variants_have_the_short_names_of_the_page(asked: list[Asked]) -> None:
    experiment = experiment_of(PLANE)
    rows = rows_of(experiment, some_runs(experiment, 2), View("runs"))
    assert rows[1]["row"] == "0.1 / 0.6"
    assert "Variants are named by learner.alpha / learner.gamma." in asked[0].small


@pytest.mark.parametrize("chosen", [None, 3])
def test_curves_have_the_short_names_of_the_page(chosen: int | None) -> None:
    experiment = experiment_of(PLANE)
    rows = rows_of(experiment, some_runs(experiment, 2), View("curves", variant=chosen))
    assert "0.1 / 0.9" in {row["line"] for row in rows}


@pytest.mark.parametrize(
    ("text", "framed"),
    [
        ("{learner.alpha: [0.3, 0.1, 0.2], learner.gamma: [0.7, 0.8, 0.9]}", (0, 2)),
        ("{learner.alpha: [0.3, 0.4, 0.2], learner.gamma: [0.7, 0.8, 0.9]}", None),
    ],
)
def test_the_presets_own_setting_is_framed_in_a_plane(
    text: str, framed: tuple[int, int] | None, asked: list[Asked]
) -> None:
    experiment = experiment_of(f"presets: [timed]\ngrid: {text}")
    rows = rows_of(experiment, some_runs(experiment, 2), View("plane"))
    assert len(rows) == 9
    assert asked[0].chart.framed == framed
    assert ("frame" in asked[0].small) == (framed is not None)


@pytest.mark.parametrize("n_seeds", [1, 3])
def test_the_small_print_promises_no_interval_of_single_runs(
    n_seeds: int, asked: list[Asked]
) -> None:
    experiment = experiment_of(THESIS)
    rows_of(experiment, some_runs(experiment, n_seeds), View("runs"))
    small = asked[0].small
    assert ("95 % bootstrap intervals" in small) == (n_seeds > 1)
    assert ("one run (seed) each" in small) == (n_seeds == 1)


def test_of_very_many_variants_the_first_have_their_intervals() -> None:
    experiment = experiment_of(
        "presets: [timed]\ngrid: {learner.alpha: {start: 0.001, stop: 0.31, step: 0.001}}"
    )
    gatherer = filled(experiment, some_runs(experiment, 3)[: 2 * 310 + 5])
    numbers = numbers_of(gatherer, gatherer.gathering(), View("runs"))
    lows = [row[3] for row in numbers[1:]]
    assert len(lows) == 60
    assert not np.isnan(lows).any()
