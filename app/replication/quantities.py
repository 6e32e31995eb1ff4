"""Quantities of the thesis's learners as they are, of which findings only say how they compare."""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

from app.analysis import estimates
from app.analysis.estimates import bootstrap_rng
from app.charts.wording import shown_estimate
from app.experiments import facts
from app.replication.page import Table
from app.replication.variants import Logs
from app.results import thesis
from app.results.findings import Place
from app.results.thesis.quantities import EARLY_CAPTURES


class Fact(NamedTuple):
    """A quantity that some findings set against another one, as it is."""

    what: str
    form: str
    places: Sequence[Place]
    quantity: str


_SIZES: Final = ("60", "120", "150")
_SENSORS: Final = ("120", "16×11", "8×6")
_FACTS: Final[Sequence[Fact]] = (
    *(
        Fact(
            f"captures in 100,000 early steps, {thesis.LEARNER_TITLES[learner]}",
            ".0f",
            [(world, learner) for world in _SIZES],
            EARLY_CAPTURES,
        )
        for learner in ("standard_q", "hierarchical_3", "timed")
    ),
    *(
        Fact(
            f"share of early steps that end in the state they began in,"
            f" {thesis.LEARNER_TITLES[learner]}",
            ".2f",
            [(world, learner) for world in _SENSORS],
            facts.STAYED,
        )
        for learner in ("standard_q", "hierarchical_3", "timed")
    ),
    *(
        Fact(
            f"share of its steps that make progress, {skill} after {step:,} steps",
            ".2f",
            [("120", learner)],
            facts.progress(skill, step),
        )
        for step in facts.PRACTICE_STEPS
        for learner, skill in (
            ("timed", "approach"),
            ("hierarchical_2", "approach"),
            ("hierarchical_2", "circle_clockwise"),
        )
    ),
    Fact(
        "cells from the prey as avoid is explored",
        ".0f",
        [("120", "timed"), ("120", "timed, avoid at 0.95")],
        facts.distance("avoid"),
    ),
)
"""What is shown beside the findings that compare it."""


def facts_table(logs: Logs) -> Table:
    """Quantities as they are, of which findings only say how they compare."""
    lines: list[Sequence[str]] = []
    for fact in _FACTS:
        for world, learner in fact.places:
            traces = logs.reader.traces(logs.placed[world, learner])
            values = [trace.quantities.get(fact.quantity, math.nan) for trace in traces]
            mean = estimates.mean(values, bootstrap_rng())
            place = f"{world}: {learner}"
            lines.append((fact.what, place, f"{mean.n}", shown_estimate(mean, fact.form)))
    return Table(("quantity", "world: learner", "runs", "mean [95 %]"), lines)
