"""How far the variants of an experiment are from one of them, while its runs come in."""

from collections.abc import Sequence
from typing import Final, NamedTuple

from app.analysis.estimates import LEAST_RUNS, Contrast, Estimate
from app.charts import variants
from app.results.gather import Gatherer, Gathering
from app.words.numbers import counted

MOST_COMPARED: Final = 7
"""Variants that are set against another one without being chosen."""


class Compared(NamedTuple):
    """A variant beside the one that it is set against."""

    place: int
    """Of its variant in the experiment."""
    label: str
    mean: Estimate
    difference: Contrast | None
    """How much higher it is; None of the variant that others are set against."""

    @property
    def over(self) -> str:
        """What its difference is over, in words."""
        if self.difference is None or not self.difference.estimate.n:
            return ""
        n = counted(self.difference.estimate.n, "seed")
        return f"paired over {n}" if self.difference.paired else f"not paired, {n}"

    @property
    def verdict(self) -> str:
        """Whether it can be told from the other one, in words, by the rule that reports go by."""
        if self.difference is None or not self.difference.estimate.n:
            return ""
        estimate = self.difference.estimate
        if estimate.n < LEAST_RUNS:
            return "undecided: too few runs"
        if not estimate.excludes_zero:
            return "undecided"
        return "higher" if estimate.value > 0 else "lower"


class Differences(NamedTuple):
    """Variants beside one of them, as rows."""

    what: str
    """The name of the quantity."""
    rows: Sequence[Compared]
    """First the variant that the others are set against."""
    n_others: int
    """Variants that have no row, because they would be too many."""


def differences_of(
    gatherer: Gatherer, gathering: Gathering, chosen: int | None
) -> Differences | None:
    """How far variants are from the one that they are set against; None where there is but one.

    Args:
        gatherer: what knows averages.
        gathering: the runs that there are; their variants are called as they are here.
        chosen: place of the variant that somebody has chosen: of many it alone is told of.
    """
    every, metric = gathering.experiment.variants, gathering.metric
    if not 1 < len(every) <= variants.MOST_CELLS:
        return None
    base = variants.reference(gathering.experiment)
    others = [place for place in range(len(every)) if place != base]
    if len(others) > MOST_COMPARED:
        others = [place for place in others if place == chosen]
    rows = [Compared(base, every[base].label, gatherer.estimate(base, metric), None)]
    rows += [
        Compared(
            place,
            every[place].label,
            gatherer.estimate(place, metric),
            gatherer.difference(place, base, metric),
        )
        for place in others
    ]
    return Differences(metric.title, rows, len(every) - len(rows))
