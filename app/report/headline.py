"""What came out, in a sentence, by a rule: the same for whatever came out.

A difference is only spoken of as one where its whole interval lies on one side of 0, and none is
where there are fewer than ``LEAST_RUNS`` runs. Of several things that could be said of the
thesis's learners it is the one that speaks least for the timed one: how far it ends from whoever is
closest.
"""

from collections.abc import Sequence
from typing import NamedTuple

from app.analysis import estimates
from app.analysis.estimates import LEAST_RUNS, Comparison, Estimate, bootstrap_rng
from app.charts.wording import shown_estimate
from app.metrics import Metric
from app.report.document import Count, Page
from app.results import thesis
from app.results.findings import FINAL
from app.results.read import Group, Reader
from app.results.thesis import Placed
from app.words.numbers import counted

_TIMED = "timed"


class Against(NamedTuple):
    """A variant, and how much higher it is than what all are set against."""

    name: str
    difference: Estimate


def lead_with_thesis(page: Page, reader: Reader, placed: Placed) -> None:
    """Head a page with how far the timed learner ends from whoever is closest to it."""
    worlds = [world for world in thesis.WORLDS if (world, _TIMED) in placed]
    for world in worlds:
        mine = _finals(reader, placed, world, _TIMED)
        found = {
            learner: estimates.compare(mine, theirs, bootstrap_rng())
            for learner in thesis.LEARNER_TITLES
            if learner != _TIMED and (theirs := _finals(reader, placed, world, learner))
        }
        found = {learner: c for learner, c in found.items() if c.difference.n}
        if not found:
            continue
        closest = min(found, key=lambda learner: found[learner].difference.value)
        page.lead(_of_timed(world, closest, found))
        return


def _finals(reader: Reader, placed: Placed, world: str, learner: str) -> dict[int, float]:
    traces = reader.traces(placed.get((world, learner), ()))
    return {t.seed: t.quantities[FINAL] for t in traces if FINAL in t.quantities}


def _of_timed(world: str, closest: str, found: dict[str, Comparison]) -> str:
    difference = found[closest].difference
    title, rival = thesis.LEARNER_TITLES[_TIMED], thesis.LEARNER_TITLES[closest]
    others = "the other learner" if len(found) == 1 else f"all {len(found)} other learners"
    where = f"({thesis.WORLD_TITLES[world]})"
    by = f"{shown_estimate(_size(difference))} reward per trial"
    of = f" {rival}, the closest, by {by}" if len(found) > 1 else f" {rival} by {by}"
    seeds = counted(difference.n, "seed")
    if difference.n < LEAST_RUNS:
        which = "above" if difference.value > 0 else "below"
        return (
            f"Nothing is decided by {seeds}: over these, {title} ends {which}{of} in the last"
            f" 2,000 trials {where}."
        )
    if not difference.excludes_zero:
        return (
            f"Undecided: whether {title} ends above {rival}, whose final rewards differ by"
            f" {shown_estimate(difference)} per trial {where}, cannot be told from {seeds}."
        )
    if difference.value > 0:
        return f"{_capital(title)} ends above {others} {where}: above{of} ({seeds})."
    return (
        f"{_capital(title)} does not end highest {where}: it ends below {rival} by {by} ({seeds})."
    )


def lead_with_differences(
    page: Page, base: str, found: Sequence[Against], metric: Metric, of: str = "variants"
) -> None:
    """Head a page with how many variants differ from one, and how far the farthest does.

    Args:
        page: that is headed.
        base: what variants are set against.
        found: the variants.
        metric: in which they are compared.
        of: what they are, in the plural.
    """
    there = [one for one in found if one.difference.n]
    if not there:
        return
    apart = [o for o in there if o.difference.excludes_zero and o.difference.n >= LEAST_RUNS]
    n_higher = sum(one.difference.value > 0 for one in apart)
    n_lower, n_open = len(apart) - n_higher, len(there) - len(apart)
    page.count(
        Count(n_higher, f"higher than {base}"),
        Count(n_lower, f"lower than {base}"),
        Count(n_open, "undecided"),
    )
    farthest = max(apart or there, key=lambda one: abs(one.difference.value))
    page.lead(_of_differences(base, there, apart, farthest, metric, of))


def _of_differences(
    base: str,
    there: Sequence[Against],
    apart: Sequence[Against],
    farthest: Against,
    metric: Metric,
    of: str,
) -> str:
    difference = farthest.difference
    way = "above" if difference.value > 0 else "below"
    by = f"{shown_estimate(_size(difference))} {way} {base} in {metric.title}"
    if not apart:
        fewest = min(one.difference.n for one in there)
        few = f" ({fewest} are too few)" if fewest < LEAST_RUNS else ""
        runs = counted(fewest, "run")
        if len(there) == 1:
            return f"Undecided over {runs}{few}: {farthest.name} lies {by}."
        return (
            f"Undecided over {runs}{few}; the farthest of {len(there)} {of}, {farthest.name}, lies"
            f" {by}."
        )
    if len(there) == 1:
        return f"{farthest.name} lies {by} (n = {difference.n})."
    return (
        f"Of {len(there)} {of}, {len(apart)} can be told from {base} in {metric.title}; the"
        f" farthest, {farthest.name}, lies {by} (n = {difference.n})."
    )


def lead_with_range(page: Page, groups: Sequence[Group], metric: Metric) -> None:
    """Head a page with the lowest and the highest of its variants."""
    means = [(g.label, estimates.mean(g.values(metric.column), bootstrap_rng())) for g in groups]
    means = [(label, mean) for label, mean in means if mean.n]
    if not means:
        return
    (low, least), (high, most) = (pick(means, key=lambda one: one[1].value) for pick in (min, max))
    if len(means) == 1:
        runs = counted(least.n, "run")
        page.lead(f"{low}: {metric.title} {shown_estimate(least)} over {runs}.")
        return
    page.lead(
        f"Over {len(means)} variants, {metric.title} runs from {shown_estimate(least)} ({low}) to"
        f" {shown_estimate(most)} ({high}); to be the highest of many is luck in part."
    )


def _size(difference: Estimate) -> Estimate:
    """How large a difference is, whichever way it goes."""
    if difference.value >= 0:
        return difference
    value, low, high, n = difference
    return Estimate(-value, -high, -low, n)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
