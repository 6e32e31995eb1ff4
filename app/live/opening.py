"""Hunts slow enough to be seen: how fast each step of one is shown, and the first ones of a run.

A learner that knows nothing needs one step for a hunt, or hundreds. Whatever it needs, a hunt takes
seconds: what comes before its last steps is hurried through, and the end is what there is to see.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from learners.kernel.state import TRIAL_STEP
from learners.run import Run

HUNTS: Final = 3
"""Hunts of a run that are slow, if any are."""

_STEPS_PER_S: Final = 20.0
"""Of the last steps of a hunt, each of which can be seen."""
_LAST_STEPS: Final = 30
_BEFORE_S: Final = 2.2
"""What all steps before the last ones take at most."""
_LEAST_S: Final = 1.2
"""What the steps of a hunt take at least."""
_START_S: Final = 0.8
"""Rest at the start of a hunt, so that it is found on the board, and what is around it."""
END_S: Final = 1.4
"""Rest at the end of a hunt, so that what it came to can be read."""

_RISE_S: Final = 5.0
"""From the speed of the last slow step to the one that is set."""
_FASTEST: Final = 1e6
"""Steps per second after which nobody sees whether it is faster."""


def seen_speed(length: int, made: int) -> float:
    """Steps per second of a hunt so long, once so many steps of it are made."""
    left = length - made
    if left > _LAST_STEPS:
        return max((length - _LAST_STEPS) / _BEFORE_S, _STEPS_PER_S)
    return min(_STEPS_PER_S, length / _LEAST_S)


def seen_at(length: int) -> np.ndarray:
    """Seconds after which each step of a hunt so long is seen, from its start; ``(step,)``."""
    pauses_s = np.full(length, 1 / seen_speed(length, length))
    pauses_s[: max(length - _LAST_STEPS, 0)] = 1 / seen_speed(length, 0)
    return _START_S + np.cumsum(pauses_s)


@dataclass(frozen=True)
class Opening:
    """How far a session is with the hunts that it begins with."""

    hunt: int
    """The one that is shown, from 1; of one that has just ended, that one."""
    of: int
    rising: bool
    """Whether they are over, and the speed rises to the one that is set."""


class SlowStart:
    """The pace of a run's first hunts. What is learned in them is what is learned at any speed."""

    def __init__(self) -> None:
        self._rising_from_s: float | None = None
        """On the clock of ``time.perf_counter``; None before the last of them is over."""
        self._length = 0
        self._of: tuple[int, object] | None = None
        """The trial that is so long, and what was asked for by then."""

    def speed(self, run: Run, set_speed: float, now_s: float) -> float:
        """Steps per second now."""
        made = int(run.state.tally[TRIAL_STEP])
        if made == 0 and run.trial <= HUNTS:
            return 1 / (END_S if run.trial else _START_S)
        if run.trial < HUNTS:
            return seen_speed(self._length_of_trial(run), made)
        since_s = 0.0 if self._rising_from_s is None else now_s - self._rising_from_s
        top = min(set_speed, _FASTEST)
        return min(_STEPS_PER_S * (top / _STEPS_PER_S) ** min(since_s / _RISE_S, 1.0), set_speed)

    def most_steps(self, run: Run) -> int | None:
        """Steps that may be made at once, so that no hunt runs into the next; None for any."""
        made = int(run.state.tally[TRIAL_STEP])
        if made == 0 and run.trial <= HUNTS:
            return 1
        return self._length_of_trial(run) - made if run.trial < HUNTS else None

    def is_over(self, run: Run, now_s: float) -> bool:
        """Whether the speed has risen; to be asked after each advance."""
        if run.trial < HUNTS or (run.trial == HUNTS and run.state.tally[TRIAL_STEP] == 0):
            return False
        if self._rising_from_s is None:
            self._rising_from_s = now_s
        return now_s - self._rising_from_s >= _RISE_S

    def stand(self, run: Run) -> Opening:
        """How far it is."""
        at_start = run.state.tally[TRIAL_STEP] == 0 and run.trial > 0
        hunt = run.trial if at_start else run.trial + 1
        return Opening(min(hunt, HUNTS), HUNTS, rising=hunt > HUNTS)

    def _length_of_trial(self, run: Run) -> int:
        """Steps of the running trial, which a copy tells: of it, too, all is determined."""
        of = run.trial, run.control.history
        if self._of is None or self._of[0] != of[0] or self._of[1] is not of[1]:
            ahead = run.copy()
            made = int(run.state.tally[TRIAL_STEP])
            self._of, self._length = of, made + ahead.advance(until_trial=run.trial + 1)
        return self._length
