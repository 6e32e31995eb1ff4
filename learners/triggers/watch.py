"""The rule by which a skill joins once learning on without it brings little (section 4.3.3).

Before each trial the rule asks for the mean of something over the last ``window`` trials, all of
them later than the freeze of the introduction before; once that is below a threshold, it is met:

========= ==================================================================
novelty   visits of main states that were not visited before with the current
          repertoire, per trial
reach     main states whose value rose above 0 for the first time, per trial
change    sum of \\|dQ\\| of the selection over the sum of steps: per step
========= ==================================================================

All three are functions of the logs. The loop keeps the sums of the window as trials end, and stops
before the trial in which the rule is met, so that the run can let the skill join; whether it is met
is asked of the logs again there. The sums are whole numbers, changes in units of 2**-20, so that
it makes no difference where in the window they begin to be kept.
"""

import math
from typing import Final, NamedTuple

import numpy as np

from learners.kernel.state import TRIAL, LearnerState
from learners.names import MAX_TRIALS
from learners.schedule_spec import TriggerSpec
from sim.compiled import loop, piece

NOVELTY, REACH, CHANGE = range(3)
"""What can be watched, as the loop knows it."""
_WATCHED: Final = {"novelty": NOVELTY, "reach": REACH, "change": CHANGE}

_UNITS: Final = 2.0**20
"""Parts into which a change is divided to be counted."""
_LARGEST: Final = 2.0**26
"""Change that counts of one trial at most: as many as a window may have add up to 63 bits."""
_WINDOWS: Final = 4
"""Of the latest windows, side by side, that many say where the mean is going."""


class Watch(NamedTuple):
    """What the loop is told to watch."""

    by: int
    """``NOVELTY``, ``REACH`` or ``CHANGE``."""
    window: int
    """Trials over which the mean is taken."""
    below: float
    """The rule is met once the mean is less than this."""
    first_trial: int
    """The first trial before which it may be met; the window then begins after the freeze."""
    limit: float
    """The mean is less than that if the sum is less than this, of changes for each step: no trial
    ends with a division, which would cost more than all the rest of it."""


class Statistic(NamedTuple):
    """What a rule watches, along a run."""

    trials: np.ndarray
    """(place,) int64: trials before which it is known."""
    values: np.ndarray
    """(place,) float64: its mean over the window that ends there."""


def watch_for(rule: TriggerSpec, since: int) -> Watch:
    """What to watch for a rule, of trials from ``since`` on."""
    by = _WATCHED[rule.by]
    limit = rule.below * _UNITS if by == CHANGE else _least_not_below(rule.below, rule.window)
    return Watch(by, rule.window, rule.below, since + rule.window, limit)


def _least_not_below(below: float, window: int) -> float:
    """The least whole number whose part for each trial of a window is not below a mean."""
    least = max(math.floor(below * window) - 1, 0)
    while least / window < below:
        least += 1
    return float(least)


@piece
def _noted(state: LearnerState, by: int, trial: int) -> int:
    """What a trial that has ended adds to the sum of a window."""
    if by == NOVELTY:
        return int(state.log_new_states[trial])
    if by == REACH:
        return int(state.log_reached[trial])
    return int(min(float(state.log_change[trial]), _LARGEST) * _UNITS)


@piece
def _size(state: LearnerState, by: int, trial: int) -> int:
    """What it adds to what the limit is for."""
    return int(state.log_steps[trial]) if by == CHANGE else 0


@piece
def sums_before(state: LearnerState, watch: Watch | None, trial: int) -> tuple[int, int]:
    """Sum over the window that ends before a trial, and how many times the limit is for it."""
    total = 0
    size = 0
    if watch is not None and watch.by != CHANGE:
        size = 1
    if watch is not None:
        for ended in range(max(watch.first_trial, trial) - watch.window, trial):
            total += _noted(state, watch.by, ended)
            size += _size(state, watch.by, ended)
    return total, size


@piece
def sums_after(
    state: LearnerState, watch: Watch | None, ended: int, total: int, size: int
) -> tuple[int, int]:
    """The same one trial later: after one that has just ended."""
    if watch is not None:
        since = watch.first_trial - watch.window
        if ended >= since:
            total += _noted(state, watch.by, ended)
            size += _size(state, watch.by, ended)
        if ended - watch.window >= since:
            total -= _noted(state, watch.by, ended - watch.window)
            size -= _size(state, watch.by, ended - watch.window)
    return total, size


@piece
def is_below(watch: Watch | None, trial: int, total: int, size: int) -> bool:
    """Whether a rule is met before a trial, by the sums of its window."""
    if watch is None:
        return False
    if trial < watch.first_trial:
        return False
    return total < watch.limit * size


@loop
def is_met(state: LearnerState, watch: Watch) -> bool:
    """Whether a rule is met before the running trial."""
    trial = int(state.tally[TRIAL])
    total, size = sums_before(state, watch, trial)
    return is_below(watch, trial, total, size)


def statistic(state: LearnerState, watch: Watch) -> Statistic:
    """What a rule watches, over each window of the trials that have ended and that it looks at.

    With a first trial of one window it is that of the whole run.
    """
    since, done = watch.first_trial - watch.window, int(state.tally[TRIAL])
    if done < watch.first_trial:
        return Statistic(np.zeros(0, np.int64), np.zeros(0))
    if watch.by == CHANGE:
        change = np.minimum(state.log_change[since:done].astype(np.float64), _LARGEST)
        sums = _over_windows((change * _UNITS).astype(np.int64), watch.window) / _UNITS
        means = sums / _over_windows(state.log_steps[since:done], watch.window)
    else:
        log = state.log_new_states if watch.by == NOVELTY else state.log_reached
        means = _over_windows(log[since:done], watch.window) / watch.window
    return Statistic(np.arange(watch.first_trial, done + 1), means)


def _over_windows(log: np.ndarray, window: int) -> np.ndarray:
    """Sums over all windows of a log of whole numbers, ``(place,) int64``."""
    sums = np.concatenate([[0], np.cumsum(log, dtype=np.int64)])
    return sums[window:] - sums[:-window]


def outlook(state: LearnerState, watch: Watch) -> int | None:
    """The trial before which a rule will be met if what it watches goes on to fall as it does.

    A straight line of least squares through the means of the latest windows, up to four side by
    side, says so.

    Returns:
        The running trial if the rule is met; None if there are no two windows yet, if the line
        does not fall, or if it comes there later than any run can.
    """
    return outlook_of(statistic(state, watch), watch)


def outlook_of(known: Statistic, watch: Watch) -> int | None:
    """The same, of what was known once the last of these windows had ended."""
    trials, means = (part[:: -watch.window][:_WINDOWS] for part in known)
    if not trials.size:
        return None
    now, mean = int(trials[0]), float(means[0])
    if mean < watch.below:
        return now
    if trials.size < 2:
        return None
    ahead, spread = trials - trials.mean(), means - means.mean()
    slope = float((ahead * spread).sum() / (ahead**2).sum())
    if slope >= 0:
        return None
    # Where the line itself is below already, the mean is about to follow.
    met = math.floor(trials.mean() + (watch.below - means.mean()) / slope) + 1
    return max(met, now + 1) if met <= MAX_TRIALS else None
