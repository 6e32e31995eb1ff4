"""Quantities that findings speak of, against logs in which they can be counted."""

from collections.abc import Mapping

import numpy as np
import pytest

from app.experiments import facts
from app.metrics.course import GreedyCurve
from app.results import thesis
from app.results.findings import FINAL
from app.results.read import Log, Pictures
from app.results.thesis import quantities
from learners import measures
from sim.spec import WorldSpec
from sim.world import CAPTURE, FLIGHT, TIMEOUT
from tests.support.places import run_of

NO_CURVE = GreedyCurve(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.float32))
NO_PICTURES = Pictures(np.zeros(0, np.int64), np.zeros((0, 18, 24)), np.zeros((0, 18, 24)))


def log_of(outcome: np.ndarray, steps: np.ndarray, known: Mapping[str, float] = {}) -> Log:
    """A log of trials."""
    reward = measures.rewards(WorldSpec(), outcome)
    return Log(outcome, reward, steps.astype(np.int64), {}, NO_PICTURES, NO_CURVE, known)


def quantities_in(learner: str, log: Log) -> dict[str, float]:
    run = run_of(("120", learner), steps=int(log.steps.sum()))
    return thesis.quantities_of(run, log)


def flights_then_captures(n_flights: int, n_captures: int, steps: int = 100) -> Log:
    outcome = np.repeat([FLIGHT, CAPTURE], [n_flights, n_captures]).astype(np.int8)
    return log_of(outcome, np.full(outcome.size, steps))


def test_rewards_are_taken_after_the_presets_trials_and_at_the_horizon() -> None:
    # 24,000 trials and 2.4 M steps, then more until the horizon and beyond.
    outcome = np.full(60_000, TIMEOUT, np.int8)
    outcome[22_000:24_000] = CAPTURE
    outcome[53_000:55_000] = FLIGHT
    found = quantities_in("standard_q", log_of(outcome, np.full(60_000, 100)))
    assert found[FINAL] == 100
    assert found[quantities.CAUGHT] == 1
    assert found[quantities.AT_HORIZON] == -50


def test_what_comes_after_the_presets_trials_changes_nothing_before_the_horizon() -> None:
    short, long = flights_then_captures(40_000, 20_000), flights_then_captures(40_000, 70_000)
    assert quantities_in("standard_q", short) == quantities_in("standard_q", long)


def test_what_a_run_did_not_get_to_is_not_there() -> None:
    found = quantities_in("standard_q", flights_then_captures(0, 23_999, steps=50))
    assert {"0–0.5 M", "0.5–1 M", "0–1 M", quantities.EARLY_CAPTURES} <= set(found)
    late = {FINAL, quantities.CAUGHT, quantities.AT_HORIZON, quantities.PASSAGE}
    assert not (late | {"1–1.5 M", "0–2 M", quantities.CAUGHT_SOON}) & set(found)


def test_windows_take_the_trials_that_end_in_them() -> None:
    # The 5,000th trial ends with step 500,000.
    found = quantities_in("standard_q", flights_then_captures(5_000, 19_000))
    assert found["0–0.5 M"] == -50
    assert found["0.5–1 M"] == 100
    assert found["0–1 M"] == 25
    assert found["0–2 M"] == (-50 * 5_000 + 100 * 15_000) / 20_000


def test_what_is_early() -> None:
    outcome = np.repeat([CAPTURE, FLIGHT], [600, 2_400]).astype(np.int8)
    found = quantities_in("standard_q", log_of(outcome, np.full(3_000, 200)))
    # 500,000 steps are 2,500 trials, and five times 100,000.
    assert found[quantities.EARLY_CAPTURES] == 600 / 5
    assert found[quantities.EARLY_LENGTH] == 200


def test_a_passage_that_is_kept_counts_and_none_counts_as_the_horizon() -> None:
    # Of the last 1,000 trials two thirds are captures: (200 - 50) / 3 = 50.
    kept = quantities_in("standard_q", flights_then_captures(10_000, 50_000))
    assert kept[quantities.PASSAGE] == pytest.approx(1.06667, abs=2e-4)
    never = quantities_in("standard_q", flights_then_captures(60_000, 0))
    assert never[quantities.PASSAGE] == 5.5
    late = quantities_in("standard_q", flights_then_captures(56_000, 50_000))
    assert late[quantities.PASSAGE] == 5.5


def test_phases_are_those_of_the_schedule() -> None:
    outcome = np.full(48_000, FLIGHT, np.int8)
    outcome[10_000:12_000] = CAPTURE
    outcome[16_500:17_000] = CAPTURE
    found = quantities_in("timed", log_of(outcome, np.full(48_000, 10)))
    assert found["before circle"] == 100
    assert found["circle explored"] == found["avoid explored"] == -50
    assert found[quantities.CAUGHT_WITH_AVOID] == 0.5


def test_what_was_noted_of_a_run_is_there() -> None:
    log = log_of(np.zeros(0, np.int8), np.zeros(0), {facts.STAYED: 0.5})
    assert quantities_in("standard_q", log) == {facts.STAYED: 0.5}
