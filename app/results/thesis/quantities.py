"""Quantities of a run that the thesis's findings speak of, by name."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from app.analysis.estimates import PHASE_STEPS, PHASES, average
from app.experiments.record import Record
from app.results import spread
from app.results.findings import FINAL
from app.results.read import Log
from learners import measures
from learners.measures import FINAL_TRIALS
from sim.world import CAPTURE

HORIZON = 5_500_000
"""Steps at which learners are compared on the same footing, whatever trials their presets have."""
AT_HORIZON = "at 5.5 M steps"
"""The quantity that is the mean reward of the 2,000 trials before that."""
LEVEL = 50.0
"""Reward per trial that is passed and kept."""
PASSAGE = "M steps to 50"
"""Steps until it is, in millions: those of the horizon at most, however long a run may go on."""
EARLY_CAPTURES = "early captures"
"""In 100,000 steps, on average over the first 0.5 M."""
EARLY_LENGTH = "steps of an early trial"
"""That the trials take which end in these, on average."""
CAUGHT = "share caught"
"""Of the 2,000 trials before the preset's trials are over."""
CAUGHT_SOON = "share caught from 1.5 to 2 M steps"
CAUGHT_WITH_AVOID = "share caught right after avoid"
"""Of the first trials after the exploration of avoid."""
_RIGHT_AFTER_TRIALS = 1_000

TABLE_WINDOWS = (*PHASES, FINAL, AT_HORIZON)
"""Quantities that are tabulated for every learner in every world."""

_WINDOWS: Mapping[str, tuple[int, int]] = {
    **{name: (place * PHASE_STEPS, (place + 1) * PHASE_STEPS) for name, place in PHASES.items()},
    "0–1 M": (0, 1_000_000),
    "1–2 M": (1_000_000, 2_000_000),
    "0–2 M": (0, 2_000_000),
}
"""Windows by name, each with the steps before which and with which it ends."""


def quantities_of(run: Record, log: Log) -> dict[str, float]:
    """What the findings speak of, by name; what the run did not get to is not there.

    All but what a horizon is in the name of is of the run's beginning, so that a run that goes on
    for longer has the same.
    """
    return {
        **_by_steps(run.steps, log),
        **_by_trials(run.settings, log),
        **spread.quantities_of(run.settings, log.pictures),
        **log.facts,
    }


def _by_steps(n_steps: int, log: Log) -> dict[str, float]:
    reward, ends = log.reward, np.cumsum(log.steps, dtype=np.int64)
    caught = log.outcome == CAPTURE
    # A run may be over in the midst of a trial, which has no reward yet and is in no window.
    found = {
        name: average(reward[_within(ends, window)])
        for name, window in _WINDOWS.items()
        if n_steps >= window[1]
    }
    first, soon = _WINDOWS["0–0.5 M"], _WINDOWS["1.5–2 M"]
    if n_steps >= first[1]:
        early = _within(ends, first)
        found[EARLY_CAPTURES] = float(caught[early].sum()) * 100_000 / first[1]
        found[EARLY_LENGTH] = average(log.steps[early])
    if n_steps >= soon[1]:
        found[CAUGHT_SOON] = average(caught[_within(ends, soon)])
    if n_steps >= HORIZON:
        before = reward[: int(np.searchsorted(ends, HORIZON, side="right"))]
        found[AT_HORIZON] = average(before[-FINAL_TRIALS:])
        passed = measures.kept_passage(reward, log.steps, LEVEL)
        found[PASSAGE] = min(HORIZON if passed is None else passed, HORIZON) / 1e6
    return found


def _within(ends: np.ndarray, window: tuple[int, int]) -> slice:
    """Trials that end after the first step of a window and by its last."""
    first, last = np.searchsorted(ends, window, side="right")
    return slice(int(first), int(last))


def _by_trials(settings: Mapping[str, Any], log: Log) -> dict[str, float]:
    reward, caught, trials = log.reward, log.outcome == CAPTURE, int(settings["trials"])
    found: dict[str, float] = {}
    if reward.size >= trials >= FINAL_TRIALS:
        found[FINAL] = average(reward[trials - FINAL_TRIALS : trials])
        found[CAUGHT] = average(caught[trials - FINAL_TRIALS : trials])
    phases = _phases(settings)
    for name, (first, last) in phases.items():
        if reward.size >= last > first:
            found[name] = average(reward[first:last])
    if phases:
        first, _ = phases["avoid mastered"]
        if reward.size >= first + _RIGHT_AFTER_TRIALS:
            found[CAUGHT_WITH_AVOID] = average(caught[first : first + _RIGHT_AFTER_TRIALS])
    return found


def _phases(settings: Mapping[str, Any]) -> dict[str, tuple[int, int]]:
    """Phases of the timed schedule by name, each with its first trial and the one after it."""
    joins = spread.joins(settings)
    length = {e["skill"]: e["duration"] for e in settings.get("schedule", {}).get("episodes", ())}
    if joins is None or not {"circle_clockwise", "avoid"} <= set(length):
        return {}
    circle, avoid = joins
    circled, avoided = circle + length["circle_clockwise"], avoid + length["avoid"]
    return {
        "before circle": (max(circle - 2_000, 0), circle),
        "circle explored": (circle, circled),
        "circle mastered": (circled, avoid),
        "avoid explored": (avoid, avoided),
        "avoid mastered": (avoided, avoided + 3_500),
    }
