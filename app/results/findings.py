"""What a finding of the thesis is: a sum of quantities of runs and a condition, with a verdict.

A finding holds where the whole interval of its sum meets its condition.
"""

from collections.abc import Sequence
from typing import Literal, NamedTuple

from app.analysis.estimates import LEAST_RUNS, Estimate

LEAST_SEEDS = LEAST_RUNS
"""Runs below which no finding is decided."""
WIDE = 15.0
"""Reward per trial: a tenth of the range from flight to capture."""
FINAL = "last 2,000 trials"
"""The quantity that is the mean reward in the end."""

Place = tuple[str, str]
"""A world and a learner of the thesis."""


class Term(NamedTuple):
    """A quantity with a weight."""

    weight: float
    world: str
    learner: str
    quantity: str = FINAL


class Unit(NamedTuple):
    """What a quantity is measured in, and how it is written."""

    suffix: str
    """What follows a number in words."""
    form: str
    """How a number is formatted."""


REWARD = Unit("", ".1f")
"""Mean reward per trial."""
SHARE = Unit(" of the states", ".2f")
STEPS = Unit(" steps", ".1f")

Condition = Literal["above", "below", "within"]
"""Where a sum is to lie: above or below the bound, or between the bound and its negative."""


class Finding(NamedTuple):
    """A statement of the thesis as a sum of quantities and a bound."""

    topic: str
    claim: str
    terms: Sequence[Term]
    bound: float
    condition: Condition = "above"
    unit: Unit = REWARD

    @property
    def wanted(self) -> str:
        """The condition in words."""
        shown = f"{self.bound:g}{self.unit.suffix}"
        return f"between ±{shown}" if self.condition == "within" else f"{self.condition} {shown}"


def ahead(
    topic: str,
    claim: str,
    larger: Term,
    smaller: Term,
    bound: float = 0,
    condition: Condition = "above",
    unit: Unit = REWARD,
) -> Finding:
    """How much larger one quantity is than another."""
    terms = (larger, smaller._replace(weight=-1))
    return Finding(topic, claim, terms, bound, condition, unit)


def term(world: str, learner: str, quantity: str = FINAL) -> Term:
    """A quantity as it is."""
    return Term(1, world, learner, quantity)


HOLDS, FAILS, UNDECIDED = "holds", "does not hold", "undecided"


def verdict(finding: Finding, effect: Estimate) -> str:
    """Whether an effect bears a finding out: only where the whole interval says the same."""
    if effect.n < LEAST_SEEDS:
        return UNDECIDED
    low, high, bound = effect.low, effect.high, finding.bound
    if finding.condition == "within":
        holds, fails = -bound < low and high < bound, low > bound or high < -bound
    elif finding.condition == "below":
        holds, fails = high < bound, low > bound
    else:
        holds, fails = low > bound, high < bound
    return HOLDS if holds else FAILS if fails else UNDECIDED
