"""What a run's log and tables say: learning curve, success, behaviour, the spread of value."""

from typing import NamedTuple

import numpy as np

from learners.kernel.state import STEP, TRIAL, LearnerState
from sim import geometry
from sim.spec import WorldSpec
from sim.world import CAPTURE, FLIGHT, TIMEOUT

CURVE_WINDOW_STEPS = 100_000
CURVE_WINDOW_TRIALS = 500
RECENT_TRIALS = 500
FINAL_TRIALS = 2_000


class Curve(NamedTuple):
    """Mean reward per trial over windows of steps, or of trials."""

    steps: np.ndarray
    """(window,) int64: end of each window, or of the run where that comes first."""
    reward: np.ndarray
    """(window,) float64: mean over the trials that ended in it; NaN where none did."""


class Endings(NamedTuple):
    """How trials ended."""

    captures: int
    flights: int
    timeouts: int


class FoldedValue(NamedTuple):
    """Values of states in the prey's own frame, over its headings.

    Direction 0 is straight ahead of the prey, and directions count counter-clockwise.
    """

    distance: np.ndarray
    """(ring, direction) float64: mean equivalent distance to capture in steps, over the headings
    that have one; NaN where none has."""
    share: np.ndarray
    """(ring, direction) float64: share of the headings whose value is above 0."""


def trials_done(state: LearnerState) -> int:
    """Trials that have ended."""
    return int(state.tally[TRIAL])


def rewards(world: WorldSpec, outcomes: np.ndarray) -> np.ndarray:
    """Reward of each trial from how it ended, ``(trial,) float64``.

    Only for a run whose rewards never changed; what they were is in ``LearnerState.log_reward``.
    """
    by_outcome = np.zeros(4)
    by_outcome[CAPTURE] = world.capture_reward
    by_outcome[FLIGHT] = world.flight_reward
    return by_outcome[outcomes]


def curve(state: LearnerState, window_steps: int = CURVE_WINDOW_STEPS) -> Curve:
    """Learning curve of a run over windows of ``window_steps`` steps, as :func:`curve_of`."""
    done, n_steps = trials_done(state), int(state.tally[STEP])
    return curve_of(state.log_reward[:done], state.log_steps[:done], n_steps, window_steps)


def curve_of(
    reward: np.ndarray, steps: np.ndarray, n_steps: int, window_steps: int = CURVE_WINDOW_STEPS
) -> Curve:
    """Learning curve over windows of steps; the last may be a part of one.

    Args:
        reward: (trial,) of each trial.
        steps: (trial,) that each trial took.
        n_steps: of the run, with those of a trial that has not ended.
        window_steps: width of a window.
    """
    if reward.size == 0:
        return Curve(np.zeros(0, np.int64), np.zeros(0))
    ended_at = np.cumsum(steps, dtype=np.int64)
    window = (ended_at - 1) // window_steps
    n_windows = int(window[-1]) + 1
    count = np.bincount(window, minlength=n_windows)
    total = np.bincount(window, reward, minlength=n_windows)
    mean = np.divide(total, count, out=np.full(n_windows, np.nan), where=count > 0)
    return Curve(np.minimum((np.arange(n_windows) + 1) * window_steps, n_steps), mean)


def curve_over_trials(state: LearnerState, window_trials: int = CURVE_WINDOW_TRIALS) -> Curve:
    """Learning curve of a run over windows of trials, as :func:`curve_over_trials_of`."""
    done = trials_done(state)
    return curve_over_trials_of(state.log_reward[:done], state.log_steps[:done], window_trials)


def curve_over_trials_of(
    reward: np.ndarray, steps: np.ndarray, window_trials: int = CURVE_WINDOW_TRIALS
) -> Curve:
    """Learning curve over windows of consecutive trials, each at the step at which it ended.

    This is the thesis's measure (section 4.1.2). Where trials are short for a while, a window of
    steps holds very many of them, and what happened in that while is averaged away. Trials after
    the last whole window are left out, unless there is none.

    Args:
        reward: (trial,) of each trial.
        steps: (trial,) that each trial took.
        window_trials: width of a window.
    """
    if reward.size == 0:
        return Curve(np.zeros(0, np.int64), np.zeros(0))
    width = min(window_trials, reward.size)
    n_whole = reward.size // width
    whole = slice(n_whole * width)
    mean = reward[whole].reshape(n_whole, width).mean(axis=1, dtype=np.float64)
    ends = np.cumsum(steps[whole].reshape(n_whole, width).sum(axis=1, dtype=np.int64))
    return Curve(ends, mean)


def endings(state: LearnerState, recent: int | None = None) -> Endings:
    """How all trials, or the most recent ones, ended."""
    done = trials_done(state)
    first = 0 if recent is None else max(done - recent, 0)
    counts = np.bincount(state.log_outcome[first:done], minlength=4)
    return Endings(int(counts[CAPTURE]), int(counts[FLIGHT]), int(counts[TIMEOUT]))


def mean_reward(state: LearnerState, recent: int = FINAL_TRIALS) -> float:
    """Mean reward of the most recent trials; NaN before the first has ended."""
    done = trials_done(state)
    if done == 0:
        return float("nan")
    return float(state.log_reward[max(done - recent, 0) : done].mean())


def switches_per_step(state: LearnerState, recent: int = FINAL_TRIALS) -> float:
    """Share of the most recent trials' steps whose option differed from that of the step before.

    The first step of a trial has none before it and does not count. 0 before there is a second.
    """
    done = trials_done(state)
    first = max(done - recent, 0)
    window, trials = slice(first, done), done - first
    steps = int(state.log_steps[window].sum()) - trials
    # The log counts the first step of each trial.
    switches = int(state.log_switches[window].sum()) - trials
    return switches / max(steps, 1)


def equivalent_distance(value: np.ndarray, capture_reward: float, gamma: float) -> np.ndarray:
    """Steps from certain capture that a value is worth: n = ln(V / capture_reward) / ln(gamma).

    A state n steps from certain capture is worth ``capture_reward * gamma**n``. If gamma is 0,
    so that only the capture itself is worth something, every value above 0 is 0 steps away.

    Returns:
        Float64 of the shape of ``value``: below 0 where a value is above ``capture_reward``; NaN
        where it is not above 0, and everywhere if ``capture_reward`` is not above 0.
    """
    distance = np.full(value.shape, np.nan)
    if capture_reward > 0:
        positive = value > 0
        worth = value[positive].astype(np.float64) / capture_reward
        with np.errstate(divide="ignore"):
            distance[positive] = np.log(worth) / np.log(gamma)
    return distance


def folded_value(utility: np.ndarray, capture_reward: float, gamma: float) -> FoldedValue:
    """Values turned into the prey's own frame and averaged over its headings.

    Values fall over so many powers of ten that they are averaged as their equivalent distances to
    capture.

    Args:
        utility: (heading, ring, direction): value of each state, the largest over its present
            options; NaN where there is none.
        capture_reward: what a capture is worth.
        gamma: discount per step.

    Returns:
        Distances and shares. No state has a distance if ``capture_reward`` is not above 0.
    """
    distance = equivalent_distance(utility, capture_reward, gamma)
    n_directions = utility.shape[2]
    turned = geometry.fold(distance, n_directions)
    known = np.isfinite(turned)
    count = known.sum(axis=0)
    total = np.where(known, turned, 0).sum(axis=0)
    mean = np.divide(total, count, out=np.full(total.shape, np.nan), where=count > 0)
    return FoldedValue(mean, geometry.fold(utility > 0, n_directions).mean(axis=0))
