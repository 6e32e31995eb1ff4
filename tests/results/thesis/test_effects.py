"""What comes out of a finding, and what makes it one that cannot be tested."""

import math
from collections.abc import Iterable, Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from app.experiments.record import Record
from app.results import thesis
from app.results.findings import MORE, Finding, Term
from app.results.read import Reader, Trace, Widths
from app.results.thesis import Placed
from tests.support.places import run_of

TIMED, STANDARD = ("120", "timed"), ("120", "standard_q")
LEAD = Finding("", "", "", "", (Term(1, *TIMED, "reward"), Term(-1, *STANDARD, "reward")), MORE)
PART = Finding("", "", "", "", (Term(1, *TIMED, "reward"), Term(-0.25, *STANDARD, "reward")), MORE)
N = 12


def trace_of(seed: int, quantities: Mapping[str, float]) -> Any:
    """All that is asked of a trace."""
    return SimpleNamespace(seed=seed, quantities=quantities)


def made_up(
    monkeypatch: pytest.MonkeyPatch, timed: Mapping[int, float], standard: Mapping[int, float]
) -> tuple[Reader, Placed]:
    """Runs of two learners whose reward is known by seed; NaN for one that has none."""
    known: dict[str, Any] = {}
    placed: dict[tuple[str, str], list[Record]] = {}
    for place, values in ((TIMED, timed), (STANDARD, standard)):
        runs = [run_of(place, seed) for seed in values]
        if runs:
            placed[place] = runs
        for run, value in zip(runs, values.values(), strict=True):
            found = {} if math.isnan(value) else {"reward": value}
            known[run.key] = trace_of(run.seed, found)
    reader = Reader(Widths(1, 1), thesis.quantities_of)

    def traces(runs: Iterable[Record]) -> list[Trace]:
        return [known[run.key] for run in runs]

    monkeypatch.setattr(reader, "traces", traces)
    return reader, placed


def test_an_effect_is_the_weighted_sum_of_means(monkeypatch: pytest.MonkeyPatch) -> None:
    timed = {seed: 50.0 + seed for seed in range(N)}
    made = made_up(monkeypatch, timed, dict.fromkeys(range(N), 20.0))
    for finding, value in ((LEAD, 35.5), (PART, 50.5)):
        effect = thesis.effect_of(finding, *made, np.random.default_rng(0))
        assert effect is not None
        assert effect.estimate.value == pytest.approx(value)
        assert effect.estimate.n == N
        assert effect.paired
        assert thesis.untestable(finding, *made) == ""


def test_learners_that_were_not_run_leave_nothing_to_test(monkeypatch: pytest.MonkeyPatch) -> None:
    made = made_up(monkeypatch, dict.fromkeys(range(N), 1.0), {})
    assert thesis.effect_of(LEAD, *made, np.random.default_rng(0)) is None
    assert thesis.untestable(LEAD, *made) == (
        "standard Q, grid 120 × 120, sensors 24 × 18: was not run"
    )


def test_a_quantity_that_some_runs_lack_is_not_taken_over_the_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    timed = dict.fromkeys(range(N), 1.0)
    standard = {seed: math.nan if seed < 3 else 1.0 for seed in range(N)}
    made = made_up(monkeypatch, timed, standard)
    assert thesis.effect_of(LEAD, *made, np.random.default_rng(0)) is None
    assert thesis.untestable(LEAD, *made) == (
        "standard Q, grid 120 × 120, sensors 24 × 18: 3 of 12 runs lack “reward”"
    )
    made = made_up(monkeypatch, timed, dict.fromkeys(range(N), math.nan))
    assert thesis.untestable(LEAD, *made) == (
        "standard Q, grid 120 × 120, sensors 24 × 18: no run has “reward”"
    )


def test_an_undefined_quantity_is_one_that_the_run_lacks(monkeypatch: pytest.MonkeyPatch) -> None:
    reader, placed = made_up(monkeypatch, {1: 1.0, 2: 2.0}, {1: 1.0, 2: 1.0})
    undefined = trace_of(2, {"reward": math.nan})
    kept = reader.traces

    def with_undefined(runs: list[Record]) -> list[Trace]:
        return [undefined if trace.seed == 2 else trace for trace in kept(runs)]

    monkeypatch.setattr(reader, "traces", with_undefined)
    assert "1 of 2 runs lack" in thesis.untestable(LEAD, reader, placed)
