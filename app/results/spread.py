"""How far value has spread in the timed learner: its moments, its regions, what is measured.

Value is looked at in the prey's own frame, in the standard world, at the moments in which skills
join and after them; a quantity is the share of the states of a region that have a value, or the
distance to capture that their values stand for.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from app.analysis.estimates import average
from app.results.findings import Place
from app.results.read import Pictures
from learners.measures import FoldedValue
from sim import geometry
from sim.spec import WorldSpec

TIMED: Place = ("120", "timed")
"""The learner whose value is looked at as it spreads."""


# --- Moments -------------------------------------------------------------------------------------


def joins(settings: Mapping[str, Any]) -> tuple[int, int] | None:
    """Trials at which circle and avoid come in, if they do after the start and in this order.

    None as well where a rule says when, since each run then has trials of its own.
    """
    timers = settings.get("schedule", {}).get("skills", {})
    circle, avoid = (timers.get(skill, {}).get("at") for skill in ("circle_clockwise", "avoid"))
    if circle is None or avoid is None:
        return None
    return (circle, avoid) if 0 < circle < avoid else None


def moments_of(settings: Mapping[str, Any]) -> dict[str, int]:
    """Moments of the timed schedule at which value is looked at, with the trials they precede."""
    joined = joins(settings)
    if joined is None:
        return {}
    circle, avoid = joined
    trials = settings["trials"]
    return {"approach only": circle, "circling": avoid, "half way": trials // 2, "the end": trials}


# --- Regions -------------------------------------------------------------------------------------


class Region(NamedTuple):
    """States at some distances from the prey and in some directions, in the standard world."""

    rings: slice
    directions: Sequence[int]
    """Of 24, counter-clockwise from straight ahead of the prey, 15 degrees each."""

    def of(self, values: np.ndarray) -> np.ndarray:
        """Its part of a map ``(ring, direction)``."""
        return values[self.rings][:, list(self.directions)]

    @property
    def cells(self) -> str:
        """Its distances in words."""
        first, last = self.rings.start, self.rings.stop
        return f"{_EDGES[first - 1]:.0f} to {_EDGES[last - 1]:.0f} cells"


_SHAPE = (WorldSpec().n_distances, WorldSpec().n_directions)
_EDGES = geometry.ring_edges(WorldSpec())
_RING = slice(10, 14)
_BEHIND = tuple(range(7, 18))
_FRONT = (*range(19, 24), *range(6))
RIGHT_FLANK = Region(_RING, (17, 18))
LEFT_FLANK = Region(_RING, (6, 7))
AHEAD_RIGHT = Region(_RING, (20, 21, 22, 23))
INNER_RIGHT = Region(slice(9, 11), AHEAD_RIGHT.directions)
"""Just outside of the visual field."""
SEEN = Region(slice(1, 8), _FRONT)
"""In the visual field."""
NEAR_BEHIND = Region(slice(3, 6), (12,))
FAR_BEHIND = Region(slice(9, 12), (12,))


# --- Quantities ----------------------------------------------------------------------------------


def averaged(values: Sequence[FoldedValue]) -> FoldedValue:
    """Mean over runs: of the shares, and of the distances over all headings that have one."""
    share = np.stack([value.share for value in values]).astype(np.float64)
    distance = np.stack([value.distance for value in values]).astype(np.float64)
    weight = np.where(np.isfinite(distance), share, 0)
    total = (weight * np.nan_to_num(distance)).sum(axis=0)
    count = weight.sum(axis=0)
    mean = np.divide(total, count, out=np.full(total.shape, np.nan), where=count > 0)
    return FoldedValue(mean, share.mean(axis=0))


def quantities_of(settings: Mapping[str, Any], pictures: Pictures) -> dict[str, float]:
    """What the findings speak of, by name; what the run did not get to is not there."""
    # The regions that are measured are made of the standard world's states.
    world = WorldSpec.model_validate(settings["world"])
    if pictures.share.shape[1:] != _SHAPE or world.ring_exponent != WorldSpec().ring_exponent:
        return {}
    found = {}
    for moment, trial in moments_of(settings).items():
        value = pictures.at(trial)
        if value is not None:
            found |= {name: of(value) for name, (at, of) in _QUANTITIES.items() if at == moment}
    return found


def _reach(region: Region) -> Callable[[FoldedValue], float]:
    """Share of the states of a region with a value above 0."""
    return lambda value: average(region.of(value.share))


def _steps(region: Region) -> Callable[[FoldedValue], float]:
    """Mean equivalent distance to capture in a region, in steps; NaN where none has a value."""

    def mean(value: FoldedValue) -> float:
        found = region.of(value.distance)
        return average(found[np.isfinite(found)])

    return mean


def _behind(value: FoldedValue) -> float:
    """Share that lies behind the prey of all states with a value above 0; NaN where none has."""
    total = float(value.share.sum())
    return float(value.share[:, list(_BEHIND)].sum()) / total if total else math.nan


def _thinnest(value: FoldedValue) -> float:
    """Share of states with a value above 0 in the direction of the ring that has fewest."""
    return float(value.share[_RING].mean(axis=0).min())


_QUANTITIES: Mapping[str, tuple[str, Callable[[FoldedValue], float]]] = {
    "behind, approach only": ("approach only", _behind),
    "near behind, approach only": ("approach only", _steps(NEAR_BEHIND)),
    "far behind, approach only": ("approach only", _steps(FAR_BEHIND)),
    "right flank, approach only": ("approach only", _reach(RIGHT_FLANK)),
    "seen, approach only": ("approach only", _reach(SEEN)),
    "right flank, circling": ("circling", _reach(RIGHT_FLANK)),
    "left flank, circling": ("circling", _reach(LEFT_FLANK)),
    "ahead to the right, circling": ("circling", _reach(AHEAD_RIGHT)),
    "ahead to the right, half way": ("half way", _reach(AHEAD_RIGHT)),
    "inner right, half way": ("half way", _reach(INNER_RIGHT)),
    "thinnest, half way": ("half way", _thinnest),
    "thinnest, the end": ("the end", _thinnest),
    "inner right, the end": ("the end", _reach(INNER_RIGHT)),
    "seen, the end": ("the end", _reach(SEEN)),
}
"""By name of the quantity: the moment it is of, and how it is measured."""
