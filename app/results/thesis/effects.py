"""What comes out of a finding: the sum that it speaks of, or why there is none."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from app.analysis import estimates
from app.analysis.estimates import Contrast
from app.results.findings import Finding, Place, Term
from app.results.read import Reader
from app.results.thesis.places import Placed, title_of


class _Part(NamedTuple):
    """A quantity of the runs of a place."""

    values: dict[int, float]
    """By seed."""
    absent: str
    """Why it cannot be used, in words; empty if it can."""


def effect_of(
    finding: Finding, reader: Reader, placed: Placed, rng: np.random.Generator
) -> Contrast | None:
    """The sum that a finding speaks of; None where :func:`untestable` says why there is none."""
    return sum_of(finding.terms, reader, placed, rng)


def sum_of(
    terms: Sequence[Term], reader: Reader, placed: Placed, rng: np.random.Generator
) -> Contrast | None:
    """A weighted sum of quantities; None where any run lacks one of them."""
    parts = [_part(reader, placed, (t.world, t.learner), t.quantity) for t in terms]
    if any(part.absent for part in parts):
        return None
    weighted = zip(terms, parts, strict=True)
    return estimates.contrast([(term.weight, part.values) for term, part in weighted], rng)


def untestable(finding: Finding, reader: Reader, placed: Placed) -> str:
    """Why a finding cannot be tested with these runs, in words; empty if it can.

    A quantity that only some runs of a place have is not taken over those: which runs have it may
    depend on how well they did.
    """
    parts = [_part(reader, placed, (t.world, t.learner), t.quantity) for t in finding.terms]
    return "; ".join(dict.fromkeys(part.absent for part in parts if part.absent))


def _part(reader: Reader, placed: Placed, place: Place, quantity: str) -> _Part:
    traces = reader.traces(placed.get(place, ()))
    if not traces:
        return _Part({}, f"{title_of(place)}: was not run")
    found = {trace.seed: trace.quantities.get(quantity, math.nan) for trace in traces}
    n_without = sum(math.isnan(value) for value in found.values())
    if n_without:
        which = "no run" if n_without == len(found) else f"{n_without} of {len(found)} runs"
        verb = "has" if n_without == len(found) else "lack"
        return _Part({}, f"{title_of(place)}: {which} {verb} “{quantity}”")
    return _Part(found, "")
