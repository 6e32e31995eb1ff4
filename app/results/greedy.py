"""Greedy curves of several runs, averaged."""

from collections.abc import Sequence

import numpy as np

from app.analysis import estimates
from app.analysis.estimates import Axis, Band
from app.metrics import GreedyCurve


def greedy_band(curves: Sequence[GreedyCurve], every: int, axis: Axis) -> Band:
    """Mean greedy reward over runs, with its interval, at each multiple of so many trials.

    Points that runs have besides, at their ends, are each at another moment, and are left out.

    Args:
        curves: of each run.
        every: trials from one point to the next.
        axis: what it is drawn against; at a step, each point is at the mean one over runs.
    """
    rewards: list[np.ndarray] = []
    ends: list[np.ndarray] = []
    for curve in curves:
        n_whole = int(np.count_nonzero(curve.trial == every * np.arange(1, curve.trial.size + 1)))
        rewards.append(curve.reward[:n_whole].astype(np.float64))
        ends.append(curve.step[:n_whole])
    rng = estimates.bootstrap_rng()
    found = estimates.band(rewards, every, rng, ends if axis == "steps" else None)
    return found._replace(is_at_end=True)
