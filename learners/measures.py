"""What a run's log and tables say: learning curve, success, behaviour, the spread of value."""

from typing import NamedTuple

import numpy as np

from learners import kernel
from learners.kernel import LearnerState
from sim import geometry
from sim.spec import WorldSpec
from sim.world import CAPTURE, FLIGHT, TIMEOUT

CURVE_WINDOW_STEPS = 100_000
RECENT_TRIALS = 500
FINAL_TRIALS = 2_000


class Curve(NamedTuple):
    """Mean reward per trial over windows of steps, the thesis's measure (section 4.1.2)."""

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
    return int(state.tally[kernel.TRIAL])


def rewards(world: WorldSpec, outcomes: np.ndarray) -> np.ndarray:
    """Reward of each trial from how it ended, ``(trial,) float64``."""
    by_outcome = np.zeros(4)
    by_outcome[CAPTURE] = world.capture_reward
    by_outcome[FLIGHT] = world.flight_reward
    return by_outcome[outcomes]


def curve(world: WorldSpec, state: LearnerState, window_steps: int = CURVE_WINDOW_STEPS) -> Curve:
    """Learning curve over windows of ``window_steps`` steps; the last may be a part of one."""
    done = trials_done(state)
    if done == 0:
        return Curve(np.zeros(0, np.int64), np.zeros(0))
    ended_at = np.cumsum(state.log_steps[:done], dtype=np.int64)
    window = (ended_at - 1) // window_steps
    n_windows = int(window[-1]) + 1
    count = np.bincount(window, minlength=n_windows)
    total = np.bincount(window, rewards(world, state.log_outcome[:done]), minlength=n_windows)
    mean = np.divide(total, count, out=np.full(n_windows, np.nan), where=count > 0)
    steps = np.minimum((np.arange(n_windows) + 1) * window_steps, int(state.tally[kernel.STEP]))
    return Curve(steps, mean)


def endings(state: LearnerState, recent: int | None = None) -> Endings:
    """How all trials, or the most recent ones, ended."""
    done = trials_done(state)
    first = 0 if recent is None else max(done - recent, 0)
    counts = np.bincount(state.log_outcome[first:done], minlength=4)
    return Endings(int(counts[CAPTURE]), int(counts[FLIGHT]), int(counts[TIMEOUT]))


def mean_reward(world: WorldSpec, state: LearnerState, recent: int = FINAL_TRIALS) -> float:
    """Mean reward of the most recent trials; NaN before the first has ended."""
    done = trials_done(state)
    if done == 0:
        return float("nan")
    return float(rewards(world, state.log_outcome[max(done - recent, 0) : done]).mean())


def switches_per_step(state: LearnerState, recent: int = FINAL_TRIALS) -> float:
    """Share of the most recent trials' steps whose option differed from that of the step before.

    0 before the first trial has ended.
    """
    done = trials_done(state)
    window = slice(max(done - recent, 0), done)
    return float(state.log_switches[window].sum()) / max(int(state.log_steps[window].sum()), 1)


def folded_value(utility: np.ndarray, capture_reward: float, gamma: float) -> FoldedValue:
    """Values turned into the prey's own frame and averaged over its headings.

    A state n steps from certain capture is worth ``capture_reward * gamma**n``, which falls over
    so many powers of ten that values are averaged as the n they stand for, their equivalent
    distance to capture.

    Args:
        utility: (heading, ring, direction): value of each state, the largest over its present
            options; NaN where there is none.
        capture_reward: what a capture is worth.
        gamma: discount per step.

    Returns:
        Distances and shares. No state has a distance if ``capture_reward`` or ``gamma`` is not
        above 0.
    """
    positive = utility > 0
    distance = np.full(utility.shape, np.nan)
    if capture_reward > 0 and gamma > 0:
        worth = utility[positive].astype(np.float64) / capture_reward
        distance[positive] = np.log(worth) / np.log(gamma)
    n_directions = utility.shape[2]
    turned = geometry.fold(distance, n_directions)
    known = np.isfinite(turned)
    count = known.sum(axis=0)
    total = np.where(known, turned, 0).sum(axis=0)
    mean = np.divide(total, count, out=np.full(total.shape, np.nan), where=count > 0)
    return FoldedValue(mean, geometry.fold(positive, n_directions).mean(axis=0))
