"""What several runs answer to one question: how they differ by nothing but luck."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, cast

import numpy as np

from app.lessons.reveals import Answer


class Band(NamedTuple):
    """Numbers of several runs."""

    low: float
    median: float
    high: float


class CurveBand(NamedTuple):
    """Curves of several runs, at trials that all of them know; tuples are of the same length."""

    at: tuple[float, ...]
    low: tuple[float, ...]
    median: tuple[float, ...]
    high: tuple[float, ...]


@dataclass(frozen=True)
class Spread:
    """What runs answered, one for each seed; None where a run has no answer."""

    answers: tuple[Answer, ...]

    @property
    def n(self) -> int:
        """How many runs there are."""
        return len(self.answers)

    @property
    def n_answered(self) -> int:
        """How many of them have an answer."""
        return sum(answer is not None for answer in self.answers)

    @cached_property
    def counts(self) -> Mapping[str, int]:
        """In how many runs each option is the answer, or each octant among those of it."""
        names: list[str] = []
        for answer in self.answers:
            if isinstance(answer, str):
                names.append(answer)
            elif isinstance(answer, tuple):
                names.extend(item for item in answer if isinstance(item, str))
        return Counter(names)

    @cached_property
    def numbers(self) -> tuple[float, ...]:
        """Of the runs whose answer is a number or a trial, in the order of their seeds."""
        return tuple(float(a) for a in self.answers if isinstance(a, int | float))

    @property
    def band(self) -> Band | None:
        """From the least of these numbers to the largest; None if there are none."""
        if not self.numbers:
            return None
        found = np.array(self.numbers)
        return Band(float(found.min()), float(np.median(found)), float(found.max()))

    @cached_property
    def curve(self) -> CurveBand | None:
        """From the lowest of the curves to the highest; None if there are none."""
        curves = [dict(curve) for curve in map(points_of, self.answers) if curve]
        if not curves:
            return None
        at = [trial for trial in curves[0] if all(trial in curve for curve in curves)]
        found = np.array([[curve[trial] for trial in at] for curve in curves])
        if not at:
            return None
        return CurveBand(
            tuple(at),
            tuple(map(float, found.min(axis=0))),
            tuple(map(float, np.median(found, axis=0))),
            tuple(map(float, found.max(axis=0))),
        )

    def share_before(self, one: str, other: str) -> float:
        """In which share of the orders one option comes before another."""
        orders = [a for a in self.answers if isinstance(a, tuple) and one in a and other in a]
        ahead = sum(order.index(one) < order.index(other) for order in orders)
        return ahead / len(orders) if orders else 0.5


def points_of(answer: Answer) -> tuple[tuple[float, float], ...]:
    """The points of a curve that was sketched or learned; none if it is something else."""
    if not isinstance(answer, tuple) or any(isinstance(point, str) for point in answer):
        return ()
    return cast("tuple[tuple[float, float], ...]", answer)
