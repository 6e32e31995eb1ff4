"""What a finding of the thesis is: a sum of quantities of runs and a margin, with a verdict.

A finding holds where the whole interval of its sum meets the margin. Of many findings some would do
so by chance, so each has a second verdict, by the p of a t test that is corrected for their number
as Holm proposes (1979). How large a margin has to be
follows from the words of the sentence that is tested, by one rule for all of them
(:data:`MARGINS`), which was fixed before the runs that are reported were made.
"""

import math
from collections.abc import Iterable, Sequence
from typing import Literal, NamedTuple

from app.analysis import significance
from app.analysis.estimates import CONFIDENCE, LEAST_RUNS, Contrast, Estimate

LEAST_SEEDS = LEAST_RUNS
"""Runs below which no finding is decided."""
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


# --- Margins -------------------------------------------------------------------------------------


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
MILLION_STEPS = Unit(" M steps", ".2f")
CELLS = Unit(" cells", ".1f")
CELLS_A_STEP = Unit(" cells a step", ".2f")
CAPTURES = Unit(" captures", ".0f")
STATES_A_TRIAL = Unit(" states a trial", ".2f")


def share_of(what: str) -> Unit:
    """Share of things that are no states, such as trials."""
    return Unit(f" of the {what}", ".2f")


Condition = Literal["above", "below", "within"]
"""Where a sum is to lie: above or below the bound, or between the bound and its negative."""

SMALL = 5.0
"""Reward per trial: a thirtieth of the range from flight to capture; less is no difference."""
WIDE = 15.0
"""Reward per trial: a tenth of that range."""


class Margin(NamedTuple):
    """A condition on a sum, and the words of a sentence that ask for it."""

    condition: Condition
    bound: float
    unit: Unit
    words: Sequence[str]
    """Of which a claim has one; empty where it names the number itself (:func:`named`)."""

    @property
    def wanted(self) -> str:
        """The condition in words."""
        shown = f"{self.bound:g}{self.unit.suffix}"
        return f"between ±{shown}" if self.condition == "within" else f"{self.condition} {shown}"


MORE = Margin(
    "above",
    SMALL,
    REWARD,
    (
        *("above", "below", "ahead", "better", "worse", "higher", "lower"),
        *("faster", "slower", "grow", "drop", "dip", "recover"),
    ),
)
"""Of words of order alone: which of two rewards is the larger one."""
MUCH_MORE = Margin(
    "above", WIDE, REWARD, ("significant", "wide margin", "good deal", "much", "well ", "very")
)
"""Of strong words, whether or not they stand with one of order."""
CLOSE = Margin("within", WIDE, REWARD, ("close", "minimal", "hardly"))
"""Of two rewards that are said not to differ, or not to matter."""
REACHED = Margin("above", 0.5, SHARE, ("reach", "closed", "there"))
"""Of a place that value has got to: most of its states have one."""
NOT_REACHED = Margin("below", 0.25, SHARE, ("not reached", "not there", "open"))
"""Of a place that it has not got to."""
SPREADS = Margin("above", 0.25, SHARE, ("more", "spread"))
"""Of two places, or two moments, of which value is said to have got further in one."""

MARGINS: Sequence[Margin] = (MORE, MUCH_MORE, CLOSE, REACHED, NOT_REACHED, SPREADS)
"""The rule: every claim that names no number has one of these, by its words."""


def named(condition: Condition, bound: float, unit: Unit) -> Margin:
    """The margin of a claim that names its own number, as for shares and counts of other things."""
    return Margin(condition, bound, unit, ())


# --- Findings ------------------------------------------------------------------------------------


class Finding(NamedTuple):
    """A statement of the thesis as a sum of quantities and a margin."""

    topic: str
    """What a group of findings is about."""
    section: str
    """Of the thesis, as in ``"4.3.1"``."""
    sentence: str
    """What the thesis says there, in our own words; several findings may test parts of it."""
    claim: str
    """What is tested: no other finding has the same."""
    terms: Sequence[Term]
    margin: Margin

    @property
    def unit(self) -> Unit:
        """What its sum is measured in."""
        return self.margin.unit

    @property
    def wanted(self) -> str:
        """Its condition in words."""
        return self.margin.wanted


def ahead(
    topic: str,
    section: str,
    sentence: str,
    claim: str,
    larger: Term,
    smaller: Term,
    margin: Margin = MORE,
) -> Finding:
    """How much larger one quantity is than another."""
    terms = (larger, smaller._replace(weight=-1))
    return Finding(topic, section, sentence, claim, terms, margin)


def term(world: str, learner: str, quantity: str = FINAL) -> Term:
    """A quantity as it is."""
    return Term(1, world, learner, quantity)


# --- Verdicts ------------------------------------------------------------------------------------

HOLDS, FAILS, UNDECIDED = "holds", "does not hold", "undecided"


def verdict(finding: Finding, effect: Estimate) -> str:
    """Whether an effect bears a finding out: only where the whole interval says the same."""
    if effect.n < LEAST_SEEDS:
        return UNDECIDED
    low, high, (condition, bound, *_) = effect.low, effect.high, finding.margin
    if condition == "within":
        holds, fails = -bound < low and high < bound, low > bound or high < -bound
    elif condition == "below":
        holds, fails = high < bound, low > bound
    else:
        holds, fails = low > bound, high < bound
    return HOLDS if holds else FAILS if fails else UNDECIDED


class Judged(NamedTuple):
    """A finding with what was measured, and what is to be thought of it."""

    finding: Finding
    effect: Contrast
    verdict: str
    """By the interval, as if this finding were the only one."""
    p: float
    """Of the t test that its verdict rests on, two-sided; NaN where nothing is decided."""
    corrected_p: float
    """The same after Holm's correction for all findings that are judged together."""
    corrected_verdict: str
    """By that, at a chance of 5 % that any of them all is wrong."""


def judged(effects: Iterable[tuple[Finding, Contrast]]) -> list[Judged]:
    """Findings with their verdicts, each on its own and corrected for their number.

    Args:
        effects: all findings that are judged together, with what was measured.
    """
    every = list(effects)
    tests = [_tested(finding, effect) for finding, effect in every]
    corrected = significance.holm([p for p, _ in tests])
    return [
        Judged(
            finding,
            effect,
            verdict(finding, effect.estimate),
            p,
            corrected_p,
            said if corrected_p < 1 - CONFIDENCE else UNDECIDED,
        )
        for (finding, effect), (p, said), corrected_p in zip(every, tests, corrected, strict=True)
    ]


def _tested(finding: Finding, effect: Contrast) -> tuple[float, str]:
    """The two-sided p of a finding, and the verdict that it speaks for.

    It is twice the smaller one of two: the chance of what was measured if the finding did not hold,
    and if it did. To lie within a bound is to lie below it and above its negative, so there the
    first is the larger one of two one-sided tests, and the second the smaller one.
    """
    if effect.estimate.n < LEAST_SEEDS:
        return math.nan, UNDECIDED
    condition, bound, *_ = finding.margin
    above, below = significance.one_sided(effect, bound)
    if condition == "within":
        above_negative, below_negative = significance.one_sided(effect, -bound)
        holds, fails = max(below, above_negative), min(above, below_negative)
    else:
        holds, fails = (above, below) if condition == "above" else (below, above)
    return min(1.0, 2 * min(holds, fails)), HOLDS if holds < fails else FAILS
