"""What a run's log and tables say: learning curve, success, behaviour, the spread of value."""

import math
from collections.abc import Iterable
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
PASSAGE_TRIALS = 1_000
"""Recent trials whose mean reward passes a level, or does not."""
KEPT_TRIALS = 5_000
"""Trials after a passage within which that mean must not fall."""
KEPT_WITHIN = 5.0
"""How far it may fall below the level all the same: reward per trial."""


class Curve(NamedTuple):
    """Mean reward per trial over windows of steps, or of trials."""

    steps: np.ndarray
    """(window,) int64: end of each window, or of the run where that comes first."""
    reward: np.ndarray
    """(window,) float64: mean over the trials that ended in it; NaN where none did."""


class Progress(NamedTuple):
    """How steps and trials of a run go together, known at some of its moments."""

    trials: np.ndarray
    """(moment,) int64: trials that had ended; from 0 on, each more than the one before."""
    steps: np.ndarray
    """(moment,) int64: steps that had been made when they had."""


class Endings(NamedTuple):
    """How trials ended."""

    captures: int
    flights: int
    timeouts: int


class Coherence(NamedTuple):
    """How steadily a learner goes about its hunts (section 2.3.3), over some ways that it went."""

    mean_choice: float
    """Steps for which it keeps to the same option, on average; of primitive moves, to a move."""
    without_progress: float
    """Share of a hunt's steps that lead to a cell in which the same hunt has been before, each hunt
    counting the same."""


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


def progress(state: LearnerState, most: int = 400) -> Progress:
    """Steps at the ends of trials that lie equally far apart, and of the last that has ended.

    They are 1, 2 or 5 times 10**k trials apart, so that ends of windows of trials are among them.

    Args:
        state: of a run.
        most: moments between the first and the last at most.
    """
    done = trials_done(state)
    width = 1
    while width * most < done:
        width = width * 5 // 2 if str(width)[0] == "2" else width * 2
    starts = np.arange(0, done, width, dtype=np.int64)
    steps = np.zeros(starts.size + 1, np.int64)
    if done:
        np.cumsum(np.add.reduceat(state.log_steps[:done], starts, dtype=np.int64), out=steps[1:])
    return Progress(np.minimum(np.append(starts, starts.size * width), done), steps)


def endings(state: LearnerState, recent: int | None = None) -> Endings:
    """How all trials, or the most recent ones, ended."""
    done = trials_done(state)
    first = 0 if recent is None else max(done - recent, 0)
    counts = np.bincount(state.log_outcome[first:done], minlength=4)
    return Endings(int(counts[CAPTURE]), int(counts[FLIGHT]), int(counts[TIMEOUT]))


def recent_reward(state: LearnerState) -> float:
    """Mean reward per trial over the last ``RECENT_TRIALS``; NaN before the first has ended."""
    done = trials_done(state)
    recent = state.log_reward[max(done - RECENT_TRIALS, 0) : done]
    return float(recent.mean()) if recent.size else float("nan")


def ended_by(steps: np.ndarray, step: int) -> int:
    """How many trials had ended when a step had been made.

    Args:
        steps: (trial,) that each trial took.
        step: so many had been made.
    """
    return int(np.searchsorted(np.cumsum(steps, dtype=np.int64), step, side="right"))


def final_mean(reward: np.ndarray) -> float:
    """Mean of the last 2,000 of some trials, or of all of fewer; NaN of none.

    Args:
        reward: (trial,) of each trial; it may be any other number of it.
    """
    return float(reward[-FINAL_TRIALS:].mean()) if reward.size else float("nan")


def area_under(found: Curve) -> float:
    """Mean of a learning curve over its steps: the area under it, on the scale of rewards.

    NaN where no trial ended in any of its windows.
    """
    widths = np.diff(found.steps, prepend=0)
    there = np.isfinite(found.reward)
    if not widths[there].sum():
        return float("nan")
    return float(np.average(found.reward[there], weights=widths[there]))


def first_passage(reward: np.ndarray, steps: np.ndarray, level: float) -> int | None:
    """Steps after which the mean reward of the last 1,000 trials first was at a level or above.

    Args:
        reward: (trial,) of each trial.
        steps: (trial,) that each trial took.
        level: reward per trial.

    Returns:
        None if it never was.
    """
    return _step_of(np.flatnonzero(_recent_totals(reward) >= level * PASSAGE_TRIALS), steps)


def kept_passage(reward: np.ndarray, steps: np.ndarray, level: float) -> int | None:
    """Steps after which that mean first was at a level or above, and then kept to it.

    For the next 5,000 trials it is never below the level by more than 5. Arguments are those of
    :func:`first_passage`.

    Returns:
        None if it never was, or if not so many trials have followed yet.
    """
    totals = _recent_totals(reward)
    is_low = totals < (level - KEPT_WITHIN) * PASSAGE_TRIALS
    n_low = np.concatenate([[0], np.cumsum(is_low)])
    # Those that have all the trials after them that it must be kept for.
    n_known = max(totals.size - KEPT_TRIALS, 0)
    is_kept = n_low[1 + KEPT_TRIALS :][:n_known] == n_low[1 : 1 + n_known]
    return _step_of(np.flatnonzero((totals[:n_known] >= level * PASSAGE_TRIALS) & is_kept), steps)


def _recent_totals(reward: np.ndarray) -> np.ndarray:
    """Rewards of the last 1,000 trials, after each trial that has so many, ``(place,) float64``."""
    totals = np.concatenate([[0.0], np.cumsum(reward, dtype=np.float64)])
    return totals[PASSAGE_TRIALS:] - totals[:-PASSAGE_TRIALS]


def _step_of(places: np.ndarray, steps: np.ndarray) -> int | None:
    """Steps that had been made at the first of some places among such totals."""
    if not places.size:
        return None
    return int(np.sum(steps[: places[0] + PASSAGE_TRIALS], dtype=np.int64))


def switches_per_step(steps: np.ndarray, switches: np.ndarray) -> float:
    """Share of the last 2,000 trials' steps whose option differed from that of the step before.

    The first step of a trial has none before it and does not count. 0 before there is a second.

    Args:
        steps: (trial,) that each trial took.
        switches: (trial,) of each, as ``LearnerState.log_switches`` has them.
    """
    steps, switches = steps[-FINAL_TRIALS:], switches[-FINAL_TRIALS:]
    # The log counts the first step of each trial.
    return (int(switches.sum()) - switches.size) / max(int(steps.sum()) - steps.size, 1)


def coherence(ways: Iterable[tuple[np.ndarray, np.ndarray]]) -> Coherence:
    """How steadily a learner goes about its hunts; NaN if there are none.

    *Mean run of a choice*: all steps over all runs of the same option, longest possible, within a
    hunt. A choice that is kept and then made again goes on. It says for how long one thing is done,
    and depends on what the options are: of primitive moves a run is a straight line.

    *Visits without progress*: steps that lead to a cell which the same hunt has been in before, to
    stay where one is among them. In a hunt the prey neither moves nor turns, so cell and heading
    are all there is to the situation: whoever is in the same one again has gone to and fro, or
    round, and all that was done since came to nothing. That holds for every learner, whatever it
    takes to be near or valuable: neither distance to the prey nor a learner's own value would do,
    since to flank is to go round and even away, and each learner has values of its own. It sees
    dithering (to and fro) and obsession (round until the step limit) alike. Each hunt counts the
    same, since those that get stuck would outweigh all others by their steps.

    Args:
        ways: of each hunt the cells, ``(step + 1,)`` from its start, and the options, ``(step,)``.
    """
    steps = runs = 0
    shares: list[float] = []
    for cells, options in ways:
        steps += options.size
        runs += 1 + int(np.count_nonzero(options[1:] != options[:-1]))
        shares.append((cells.size - np.unique(cells).size) / options.size)
    if not shares:
        return Coherence(math.nan, math.nan)
    return Coherence(steps / runs, sum(shares) / len(shares))


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
