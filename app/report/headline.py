"""What came out, in a sentence, by a rule: the same for whatever came out.

A difference is only spoken of as one where its whole interval lies on one side of 0, and none is
where there are fewer than ``LEAST_RUNS`` runs. Of several things that could be said of the
thesis's learners it is the one that speaks least for the timed one: how far it ends from whoever is
closest.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from app.analysis import estimates
from app.analysis.estimates import LEAST_RUNS, Estimate, bootstrap_rng
from app.charts.wording import shown_estimate
from app.experiments.record import Record
from app.metrics import BY_COLUMN, Metric, at_steps
from app.report.document import Count, Page
from app.results import thesis
from app.results.findings import FINAL, Place
from app.results.read import Group, Reader
from app.results.thesis import Placed
from app.words.numbers import counted

_TIMED = "timed"
_HORIZON_REWARD = BY_COLUMN["horizon_reward"].column
_STANDARD = "120"
_SIZES = ("60", "120", "150")
"""Worlds that are called by their size; the others go by their sensors."""
_MOST_CLAUSES = 3
"""Worlds of which a sentence says how far; of more it says that of the first alone."""


class Against(NamedTuple):
    """A variant, and how much higher it is than what all are set against."""

    name: str
    difference: Estimate


class _Closest(NamedTuple):
    """Who ends closest to the timed learner in a world, or above it."""

    name: str
    n_others: int
    difference: Estimate
    """Of the timed learner to it."""


def lead_with_thesis(page: Page, reader: Reader, placed: Placed, horizon: int | None) -> None:
    """Head a page with how far the timed learner ends from whoever is closest to it.

    Args:
        page: that is headed.
        reader: of the logs of the runs.
        placed: the runs.
        horizon: steps at which they were measured as well, if they were.
    """
    worlds = [w for w in sorted(thesis.WORLDS, key=_STANDARD.__ne__) if (w, _TIMED) in placed]
    values = {place: _finals(reader, runs) for place, runs in placed.items()}
    found = [(w, closest) for w in worlds if (closest := _closest(w, values)) is not None]
    if not found:
        return
    fewest = min(closest.difference.n for _, closest in found)
    seeds = counted(fewest, "seed")
    clauses = [_clause(world, closest) for world, closest in found]
    if len(clauses) > _MOST_CLAUSES:
        clauses[1:] = _elsewhere(found[1:])
    first, _ = found[0]
    at = _closest(first, {place: _at_horizon(runs) for place, runs in placed.items()})
    if at is not None and horizon is not None:
        clauses[0] += f", and {at_steps(horizon)} {_of_timed(at)}"
    few = f"Nothing is decided by {seeds}, but over these: " if fewest < LEAST_RUNS else ""
    title = thesis.LEARNER_TITLES[_TIMED]
    over = "" if few else f", over {seeds}"
    said = f"{title} {'; '.join(clauses)} (reward per trial{over})."
    page.lead(f"{few}{said if few else _capital(said)}")


def _clause(world: str, found: _Closest) -> str:
    """How the timed learner ends in a world."""
    return f"{_in(world)} ends {_of_timed(found)}"


def _elsewhere(found: Sequence[tuple[str, _Closest]]) -> list[str]:
    """Where the timed learner ends above all others, and where it does not."""
    apart = [(world, closest) for world, closest in found if closest.difference.excludes_zero]
    above = [_in(world) for world, closest in apart if closest.difference.value > 0]
    below = [f"{c.name} {_in(world)}" for world, c in apart if c.difference.value < 0]
    undecided = [f"{c.name} {_in(w)}" for w, c in found if not c.difference.excludes_zero]
    ways = ("ends above all others", above), ("below", below), ("undecided against", undecided)
    return [f"{way} {', '.join(which)}" for way, which in ways if which]


def _in(world: str) -> str:
    return f"at {world}" if world in _SIZES else f"with sensors {world}"


def _closest(world: str, values: Mapping[Place, Mapping[int, float]]) -> _Closest | None:
    """Who is closest to the timed learner by some values of runs, by seed."""
    mine = values.get((world, _TIMED))
    differences = {
        learner: estimates.compare(mine, theirs, bootstrap_rng()).difference
        for learner in thesis.LEARNER_TITLES
        if learner != _TIMED and mine and (theirs := values.get((world, learner)))
    }
    if not differences:
        return None
    closest = min(differences, key=lambda learner: differences[learner].value)
    return _Closest(thesis.LEARNER_TITLES[closest], len(differences), differences[closest])


def _finals(reader: Reader, runs: Iterable[Record]) -> dict[int, float]:
    traces = reader.traces(runs)
    return {t.seed: t.quantities[FINAL] for t in traces if FINAL in t.quantities}


def _at_horizon(runs: Iterable[Record]) -> dict[int, float]:
    found = {run.seed: run.values[_HORIZON_REWARD] for run in runs}
    return {seed: value for seed, value in found.items() if math.isfinite(value)}


def _of_timed(found: _Closest) -> str:
    """Where the timed learner is, as the end of a clause."""
    difference = found.difference
    by = shown_estimate(_size(difference), ".1f")
    if not difference.excludes_zero:
        differs = shown_estimate(difference, "+.1f")
        return f"undecided against {found.name} (difference {differs})"
    if difference.value < 0:
        return f"below {found.name} by {by}"
    if found.n_others == 1:
        return f"above {found.name} by {by}"
    return f"above all {found.n_others} others ({found.name}, the closest, by {by})"


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
    signed = f"differs from {base} by {shown_estimate(difference, '+.3g')} in {metric.title}"
    if not apart:
        fewest = min(one.difference.n for one in there)
        few = f" ({fewest} are too few)" if fewest < LEAST_RUNS else ""
        runs = counted(fewest, "run")
        if len(there) == 1:
            return f"Undecided over {runs}{few}: {farthest.name} {signed}."
        return (
            f"Undecided over {runs}{few}; the farthest of {len(there)} {of}, {farthest.name},"
            f" {signed}."
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
