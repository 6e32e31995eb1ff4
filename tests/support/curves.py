"""Curves of which a test says the points."""

from collections.abc import Sequence

import numpy as np

from app.metrics.course import GreedyCurve
from learners.measures import Curve


def learned(steps: Sequence[int], reward: Sequence[float]) -> Curve:
    """A learning curve."""
    return Curve(np.array(steps, np.int64), np.array(reward, np.float64))


def greedy_curve(*points: tuple[int, int, float]) -> GreedyCurve:
    """A greedy curve of points of trial, step and reward."""
    trial, step, reward = zip(*points, strict=True)
    return GreedyCurve(np.array(trial), np.array(step), np.array(reward, np.float32))
