"""Where runs are compared that had different lengths."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.documents.experiment_spec import Stop
from app.experiments.record import Origin, Record
from app.metrics import NAMES, area_at, reward_at
from app.results import horizon, thesis
from app.results.horizon import Horizon, common, up_to, with_values
from app.results.read import Reader, read_folder, widths_of
from tests.support.folders import add_run, new_folder
from tests.support.runs import fact


def run_of(steps: int, stated: int | None = None, stop: Stop | None = None) -> Record:
    _, run = fact(0, 0, 1.0, steps=steps)
    return replace(run, origin=Origin(Path(), NAMES, False, stop, stated))


@pytest.mark.parametrize(
    ("runs", "steps", "is_stated"),
    [
        ([(900_000, 500_000), (700_000, 500_000)], 500_000, True),
        ([(987_654, None), (1_200_000, None)], 900_000, False),
        ([(98_765, None), (1_200_000, None)], 98_765, False),
        ([(900_000, 500_000), (800_000, 600_000)], 500_000, False),
        ([(900_000, 500_000), (487_000, None)], 400_000, False),
    ],
)
def test_runs_are_compared_where_all_have_got_to(
    runs: list[tuple[int, int | None]], steps: int, is_stated: bool
) -> None:
    assert common(run_of(*run) for run in runs) == Horizon(steps, is_stated)


def test_runs_that_end_by_what_they_have_learned_have_no_horizon() -> None:
    assert common([run_of(900_000, stop=Stop(success=0.7)), run_of(800_000)]) is None
    assert common([]) is None


def test_what_a_run_came_to_by_a_horizon_is_what_its_log_says() -> None:
    draw = np.random.default_rng(5)
    steps = draw.integers(1, 500, 9_000)
    reward = draw.choice([100.0, -50.0, 0.0], 9_000)
    found = up_to(reward, steps, int(steps.sum()) + 3)
    for at in (1_234, 99_999, *range(100_000, int(steps.sum()), 100_000)):
        expected = reward_at(reward, steps, at), area_at(reward, steps, at)
        assert found.values(at) == pytest.approx(expected)


def test_before_the_first_trial_has_ended_there_is_nothing() -> None:
    found = up_to(np.zeros(0), np.zeros(0, np.int64), 250_000)
    assert all(math.isnan(value) for at in (7, 200_000) for value in found.values(at))


def test_only_what_an_experiment_asks_for_has_values_there() -> None:
    run = run_of(250_000)
    asked = replace(run, origin=run.origin._replace(metrics=("final_reward", "horizon_area")))
    known = up_to(np.full(25, 8.0), np.full(25, 10_000), 250_000)
    found = with_values(asked, Horizon(200_000, False), known).values
    assert found["horizon_area"] == 8.0
    assert math.isnan(found["horizon_reward"])
    assert math.isnan(found["horizon_greedy"])


def test_runs_that_are_read_have_values_at_the_shortest_of_them(tmp_path: Path) -> None:
    folder = new_folder(tmp_path / "a")
    add_run(folder, 0)
    add_run(folder, 1, steps=3_500)
    rows = read_folder(folder).rows
    reader = Reader(widths_of(rows), thesis.quantities_of)
    found, at = reader.at_horizon(rows)
    assert at == Horizon(3_000, is_stated=False)
    assert at is not None
    assert at.words == "at 3,000 steps"
    assert [run.values["horizon_reward"] for run in found] == pytest.approx(
        [run.values["final_reward"] for run in rows]
    )


def test_values_that_were_measured_at_a_stated_horizon_stay(tmp_path: Path) -> None:
    folder = new_folder(tmp_path / "a", horizon="2000")
    add_run(folder, 0, horizon_reward=7.0, horizon_greedy=9.0)
    rows = read_folder(folder).rows
    reader = Reader(widths_of(rows), thesis.quantities_of)
    (found,), at = reader.at_horizon(rows)
    assert at == horizon.Horizon(2_000, is_stated=True)
    assert (found.values["horizon_reward"], found.values["horizon_greedy"]) == (7.0, 9.0)
