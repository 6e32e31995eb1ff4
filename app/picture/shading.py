"""From values to numbers on a scale.

Arrays over states are ``(distance, direction)``.
"""

from typing import Literal, NamedTuple

import numpy as np

from learners.measures import equivalent_distance

FARTHEST_STEPS = 200.0
"""Upper end of the scale of equivalent distances: hardly a state of value is farther."""
SHOWN_FROM = 1 / 2
"""Share of the headings that must know of a place for it to be coloured: what fewer know is not yet
part of the cone, the arm or the ring that people see."""

Scale = Literal["steps", "linear"]


class Known(NamedTuple):
    """A value map over one or more headings: what they say together of each place."""

    steps: np.ndarray
    """(distance, direction) float64: mean equivalent distance to capture, NaN where none."""
    gain: np.ndarray
    """(distance, direction) float64: mean of the values above 0, 0 where none."""
    positive_share: np.ndarray
    """(distance, direction) float64: share of headings whose value is above 0."""
    negative_share: np.ndarray
    """(distance, direction) float64: share of headings whose value is below 0."""


def equivalent_steps(value: np.ndarray, capture_reward: float, gamma: float) -> np.ndarray:
    """Equivalent distances to capture, clipped to 0...``FARTHEST_STEPS``.

    NaN where there is none, see :func:`learners.measures.equivalent_distance`.
    """
    return np.clip(equivalent_distance(value, capture_reward, gamma), 0.0, FARTHEST_STEPS)


def known_of(values: np.ndarray, capture_reward: float, gamma: float) -> Known:
    """Sum up maps ``(heading, distance, direction)`` that are in one frame.

    Equivalent distances are averaged over the headings that have one.
    """
    steps = equivalent_steps(values, capture_reward, gamma)
    positive, negative = values > 0, values < 0
    n_positive, n_negative = positive.sum(axis=0), negative.sum(axis=0)
    return Known(
        steps=mean_of(np.nan_to_num(steps), n_positive, np.nan),
        gain=mean_of(np.where(positive, values, 0), n_positive, 0.0),
        positive_share=n_positive / len(values),
        negative_share=n_negative / len(values),
    )


def mean_of(parts: np.ndarray, count: np.ndarray, where_none: float) -> np.ndarray:
    """Sum over the first axis divided by how many took part."""
    mean = np.full(count.shape, where_none)
    np.divide(parts.sum(axis=0, dtype=np.float64), count, out=mean, where=count > 0)
    return mean


# Scales of colours --------------------------------------------------------------------------


class Ruler(NamedTuple):
    """How a quantity is laid along a bar: from 0 at ``low`` to 1 at ``high``."""

    low: float
    high: float
    kind: Literal["linear", "root", "log"] = "linear"
    """``root`` gives the lower end more room than ``linear``, ``log`` each decade the same."""

    def place(self, quantity: np.ndarray | float) -> np.ndarray:
        """Place of a quantity along the bar, clipped to 0...1; NaN where there is none.

        In the middle, if the bar has no length.
        """
        quantity = np.asarray(quantity, dtype=np.float64)
        if not self.high > self.low:
            return np.where(np.isnan(quantity), np.nan, 0.5)
        clipped = np.clip(quantity, self.low, self.high)
        if self.kind == "log":
            return np.log(clipped / self.low) / np.log(self.high / self.low)
        part = (clipped - self.low) / (self.high - self.low)
        return np.sqrt(part) if self.kind == "root" else part


STEPS = Ruler(0.0, FARTHEST_STEPS, "root")
"""Equivalent distances, by the square root: most of the board lies in the first quarter."""


def nearness(steps: np.ndarray, ruler: Ruler = STEPS) -> np.ndarray:
    """Place on the colour scale of an equivalent distance: 1 at the prey, 0 at the far end."""
    return 1.0 - ruler.place(steps)


class Shading(NamedTuple):
    """How a value map becomes colours."""

    scale: Scale
    gain: Ruler
    """Of equivalent distances where the scale is ``steps``, of values where it is linear."""

    def level(self, known: Known) -> np.ndarray:
        """Place of the gains on the colour scale, 0...1; NaN where there is none."""
        if self.scale == "steps":
            return nearness(known.steps, self.gain)
        return self.gain.place(np.where(known.positive_share > 0, known.gain, np.nan))


def fixed_shading(scale: Scale, reward: float) -> Shading:
    """The shading whose limits do not depend on what has been learned."""
    return Shading(scale, STEPS if scale == "steps" else Ruler(0.0, reward))


def fitted_shading(values: np.ndarray, gamma: float, fixed: Shading, reward: float) -> Shading:
    """A shading whose limits are the least and the most that is among values, if anything is."""
    gains = values[values > 0]
    gain = fixed.gain
    if len(gains):
        ends = np.array([gains.min(), gains.max()], dtype=np.float64)
        if fixed.scale == "steps":
            farthest, nearest = equivalent_steps(ends, reward, gamma)
            gain = Ruler(float(nearest), float(farthest), "root")
        else:
            gain = Ruler(float(ends[0]), float(ends[1]))
    return Shading(fixed.scale, gain)
