"""The thesis's experiments: its worlds and learners, what is measured of them, and its findings."""

from collections.abc import Sequence

from app.results.findings import Finding
from app.results.thesis import method, resolution, size, spreading, standard
from app.results.thesis.effects import effect_of, sum_of, untestable
from app.results.thesis.places import (
    FIGURES,
    LEARNER_TITLES,
    LEARNERS,
    WORLD_TITLES,
    WORLDS,
    Placed,
    place_of,
    placed_of,
    settings_of,
)
from app.results.thesis.quantities import TABLE_WINDOWS, quantities_of

FINDINGS: Sequence[Finding] = (
    *method.FINDINGS,
    *standard.FINDINGS,
    *spreading.FINDINGS,
    *size.FINDINGS,
    *resolution.FINDINGS,
    *method.TIMING_FINDINGS,
)
"""All sentences of chapters 3 and 4 that can be tested, in the order of the sections."""

__all__ = [
    "FIGURES",
    "FINDINGS",
    "LEARNERS",
    "LEARNER_TITLES",
    "TABLE_WINDOWS",
    "WORLDS",
    "WORLD_TITLES",
    "Placed",
    "effect_of",
    "place_of",
    "placed_of",
    "quantities_of",
    "settings_of",
    "sum_of",
    "untestable",
]
