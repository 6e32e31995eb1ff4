"""Ways to read the thesis where it leaves something open, and which of its findings depend on them.

One of them is the lab's own; the others settle an open point, or two, in another way. A finding of
the standard world is *robust* if it holds under all of them, *fitted* if it holds as the lab reads
the thesis and does not under another, and *open* where neither can be said.
"""

import json
from collections.abc import Mapping, Sequence
from typing import Final, Literal, NamedTuple

from app.analysis import estimates
from app.analysis.estimates import Estimate
from app.experiments.record import Record
from app.results import findings, thesis
from app.results.findings import FAILS, HOLDS, REACHED, Finding, Term, term
from app.results.read import Group, Reader

WORLD: Final = "120"
"""The standard world, by the name that the thesis's findings have for it."""
OPEN_POINTS: Final[Mapping[str, str]] = {
    "learner.spiral_penalty": "what a circle is charged for coming nearer (c)",
    "learner.skills_that_learn": "which skills learn at a step",
    "learner.local_rewards": "whether local rewards have a size or only a sign",
    "world.ring_exponent": "how the rings of the distance sensor lie",
    "world.skill_n_directions": "how finely skills see",
    "world.skill_n_distances": "how finely skills see",
}
"""What the thesis leaves open and a setting says, by its key."""
OWN: Final = "as read here"

_LEARNERS: Final = ("timed", "hierarchical_3", "standard_q")
_FEWEST: Final = 3
"""Readings that make it worth asking."""

Standing = Literal["robust", "fitted", "open"]


class Reading(NamedTuple):
    """A way to read the thesis, and the runs that were made so."""

    label: str
    point: str
    """What it settles otherwise, in words; empty for the lab's own."""
    placed: Mapping[tuple[str, str], Sequence[Record]]
    """The runs by learner, as findings ask for them. A learner that an open point does not concern,
    and that was not run with it, has those of the lab's own reading."""


class Quantity(NamedTuple):
    """Something of which it is shown how much it depends on the reading."""

    title: str
    terms: Sequence[Term]
    form: str
    """How a number of it is written."""


_TIMED, _THREE = term(WORLD, "timed"), term(WORLD, "hierarchical_3")
QUANTITIES: Final[Sequence[Quantity]] = (
    Quantity("end of timed (reward)", (_TIMED,), ".1f"),
    Quantity("its lead over three skills (reward)", (_TIMED, _THREE._replace(weight=-1)), ".1f"),
    Quantity(
        "depth of its second dip (reward)",
        (
            term(WORLD, "timed", "circle mastered"),
            term(WORLD, "timed", "avoid explored")._replace(weight=-1),
        ),
        ".1f",
    ),
    Quantity(
        "share of the ring's thinnest sector with a value, in the end",
        (term(WORLD, "timed", "thinnest, the end"),),
        ".2f",
    ),
)
"""What is shown of every reading. The ring is closed where the last is above the bound by which
value has reached a place."""
RING_CLOSED: Final = REACHED.bound


class Dependence(NamedTuple):
    """A finding, and what comes out of it under each reading."""

    finding: Finding
    verdicts: Mapping[str, str]
    """By the label of the reading; those under which it could not be tested are not there."""

    @property
    def standing(self) -> Standing:
        """Whether it depends on the reading."""
        if all(verdict == HOLDS for verdict in self.verdicts.values()):
            return "robust"
        return "fitted" if self.verdicts[OWN] == HOLDS and self.failing else "open"

    @property
    def failing(self) -> Sequence[str]:
        """The readings under which it does not hold."""
        return [label for label, verdict in self.verdicts.items() if verdict == FAILS]

    @property
    def undecided(self) -> Sequence[str]:
        """The readings under which it is undecided."""
        return [label for label, found in self.verdicts.items() if found not in (HOLDS, FAILS)]


def readings_of(groups: Sequence[Group]) -> list[Reading]:
    """The readings among variants, the lab's own first; none unless the variants are just that."""
    if any(group.preset not in _LEARNERS or not _is_reading(group) for group in groups):
        return []
    by_choice: dict[str, dict[str, Group]] = {}
    for group in groups:
        choice = json.dumps(group.overrides, sort_keys=True)
        by_choice.setdefault(choice, {})[group.preset] = group
    own = by_choice.pop("{}", {})
    if "timed" not in own or len(by_choice) < _FEWEST - 1:
        return []
    readings = [Reading(OWN, "", _placed(own))]
    for of_learner in by_choice.values():
        first = next(iter(of_learner.values()))
        points = dict.fromkeys(OPEN_POINTS[key] for key in first.overrides)
        label = first.label.removeprefix(f"{first.preset}, ")
        readings.append(Reading(label, "; ".join(points), _placed({**own, **of_learner})))
    return readings


def _is_reading(group: Group) -> bool:
    return group.overrides.keys() <= OPEN_POINTS.keys()


def _placed(of_learner: Mapping[str, Group]) -> Mapping[tuple[str, str], Sequence[Record]]:
    return {(WORLD, learner): group.runs for learner, group in of_learner.items()}


def quantity_of(quantity: Quantity, reader: Reader, reading: Reading) -> Estimate | None:
    """A quantity under a reading; None where a part of it was not run or measured."""
    rng = estimates.bootstrap_rng()
    found = thesis.sum_of(quantity.terms, reader, reading.placed, rng)
    return None if found is None else found.estimate


def dependences(reader: Reader, readings: Sequence[Reading]) -> list[Dependence]:
    """Findings of the standard world that could be tested as the lab reads the thesis."""
    found: list[Dependence] = []
    for finding in thesis.FINDINGS:
        if any(t.world != WORLD or t.learner not in _LEARNERS for t in finding.terms):
            continue
        verdicts: dict[str, str] = {}
        for reading in readings:
            effect = thesis.effect_of(finding, reader, reading.placed, estimates.bootstrap_rng())
            if effect is not None:
                verdicts[reading.label] = findings.verdict(finding, effect.estimate)
        if OWN in verdicts:
            found.append(Dependence(finding, verdicts))
    return found
