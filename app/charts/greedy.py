"""Greedy curves of several runs, averaged into one."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from app.analysis import estimates
from app.analysis.estimates import Axis
from app.charts.model import Greedy
from app.metrics.course import GreedyCurve

_FAR: Final = 3.0
"""Points that are farther apart than so many times the usual are not joined."""


def joined_up(at: np.ndarray) -> list[slice]:
    """Stretches of a curve in which points are near each other, so that a line may join them.

    A straight line across half of the axis would say what nobody measured: while a skill is
    explored, trials take many steps, and their points are far apart.

    Args:
        at: (point,) where they are on the axis, in order.
    """
    gaps = np.diff(at)
    far = gaps > _FAR * np.median(gaps) if gaps.size else np.zeros(0, bool)
    ends: list[int] = [0, *(np.flatnonzero(far) + 1).tolist(), at.size]
    return [slice(start, end) for start, end in pairwise(ends)]


def averaged(curves: Sequence[GreedyCurve], axis: Axis) -> Greedy | None:
    """Greedy reward after as many trials, over the runs that came so far, if enough of them did.

    Args:
        curves: of each run.
        axis: what it is drawn against; a point's step is the mean of those of its runs.
    """
    points: dict[int, list[tuple[int, float]]] = {}
    for curve in curves:
        trials, steps, rewards = curve.trial.tolist(), curve.step.tolist(), curve.reward.tolist()
        for trial, step, reward in zip(trials, steps, rewards, strict=True):
            points.setdefault(trial, []).append((step, reward))
    fewest = estimates.LEAST_SHARE * len(curves)
    there = [trial for trial in sorted(points) if len(points[trial]) >= fewest]
    if len(there) < 2:
        return None
    means = np.asarray([np.mean(points[trial], axis=0) for trial in there])
    at = means[:, 0] if axis == "steps" else np.asarray(there, np.float64)
    return Greedy(at, means[:, 1])
