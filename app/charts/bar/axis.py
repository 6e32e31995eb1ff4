"""The one axis of the bar: from trials and steps of a run to places along it."""

import math
from typing import Final, NamedTuple

import numpy as np

from app.analysis.estimates import Axis
from app.live.snapshot import Snapshot
from app.words.numbers import in_short, ticks
from learners.measures import Progress

_MOST_TICKS: Final = 6
"""Numbered places after 0."""
_MEANWHILE_TRIALS: Final = 2_000
"""Trials that have ended lately, by which is judged how long those ahead will take."""
_FIRST_PACE: Final = 100.0
"""Steps of a trial as long as none has ended."""
_LEAST_STEPS: Final = 10_000.0
_ROOM_AHEAD: Final = 1.04
_ROUND: Final = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
"""Where an axis of steps may end, times a power of ten."""


class Tick(NamedTuple):
    """A numbered place."""

    at: float
    text: str


class TimeAxis(NamedTuple):
    """Trials or steps, from 0 on as a rule. Places are shares of its length, none beyond an end."""

    unit: Axis
    end: float
    """What the place 1 stands for, in trials or steps."""
    progress: Progress
    """How trials and steps went together so far."""
    pace: float
    """Steps that a trial ahead is taken to have."""
    trial: int
    """The running one."""
    step: int
    """So many have been made."""
    start: float = 0.0
    """What the place 0 stands for: a part of a run may be looked at more closely."""

    def of_trial(self, trial: int) -> float:
        """The place of the beginning of a trial, be it ahead."""
        if self.unit == "trials":
            return self._place(trial)
        known = self.progress
        ahead = max(trial - int(known.trials[-1]), 0) * self.pace
        return self._place(float(np.interp(trial, known.trials, known.steps)) + ahead)

    def of_steps(self, steps: np.ndarray) -> np.ndarray:
        """The places of steps that have been made, ``(step,) float64``."""
        return np.clip(self.along(steps), 0.0, 1.0)

    def along(self, steps: np.ndarray) -> np.ndarray:
        """The same; what lies before its beginning is below 0, what lies beyond its end above 1."""
        known, along = self.progress, steps
        if self.unit == "trials":
            along = np.interp(steps, known.steps, known.trials)
        return (along - self.start) / (self.end - self.start)

    @property
    def now(self) -> float:
        """Where the run is."""
        return self._place(self.trial if self.unit == "trials" else self.step)

    @property
    def ticks(self) -> tuple[Tick, ...]:
        """Round numbers along it."""
        if self.unit == "trials":
            marks = ticks(self.start, self.end, _MOST_TICKS, least=1)
            return tuple(Tick(self._place(mark), in_short(mark, k_from=1e5)) for mark in marks)
        marks = ticks(self.start, self.end, _MOST_TICKS)
        return tuple(Tick(self._place(mark), _short(mark, self._steps_unit)) for mark in marks)

    @property
    def _steps_unit(self) -> tuple[float, str]:
        return (1e6, "M") if self.end >= 2e5 else (1e3, "k")

    def _place(self, along: float) -> float:
        return min(max((along - self.start) / (self.end - self.start), 0.0), 1.0)


def axis_of(snapshot: Snapshot, unit: Axis) -> TimeAxis:
    """The axis of a moment.

    One of trials ends with the run's last, or, once it goes on, with that of the next stretch; one
    of steps a little after what has been made, since nobody knows how long the trials ahead are.
    """
    progress = snapshot.progress
    end = float(last_trial(snapshot))
    if unit == "steps":
        end = _round_above(max(snapshot.step * _ROOM_AHEAD, _LEAST_STEPS))
    axis = TimeAxis(unit, end, progress, _pace(progress), snapshot.trial, snapshot.step)
    # What is known of steps and trials may be of a little while ago.
    now = (snapshot.trial, snapshot.step - snapshot.trial_step)
    if now[0] > progress.trials[-1]:
        trials, steps = np.append(progress.trials, now[0]), np.append(progress.steps, now[1])
        axis = axis._replace(progress=Progress(trials, steps))
    return axis


def last_trial(snapshot: Snapshot) -> int:
    """The trial up to which a run is to go, or, once it went on, to the end of the next stretch."""
    trials = snapshot.spec.trials
    return trials * max(math.ceil(snapshot.trial / trials), 1)


def _short(steps: float, unit: tuple[float, str]) -> str:
    factor, sign = unit
    return f"{steps / factor:.3g} {sign}" if steps else "0"


def _pace(progress: Progress) -> float:
    trials, steps = progress
    if trials[-1] == 0:
        return _FIRST_PACE
    lately = np.flatnonzero(trials <= max(int(trials[-1]) - _MEANWHILE_TRIALS, 0))
    since = int(lately[-1])
    return float((steps[-1] - steps[since]) / (trials[-1] - trials[since]))


def _round_above(number: float) -> float:
    power = 10.0 ** math.floor(math.log10(number))
    return next(factor * power for factor in _ROUND if factor * power >= number * (1 - 1e-9))
