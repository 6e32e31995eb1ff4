"""Findings on how learners scale with the resolution of the sensors (section 4.3.3).

The thesis speaks of "the state space used by the main selection policy". In one reading the sensors
of both levels are coarse, in the other those of the selection alone; both are tested. A learner
without skills is the same in both.
"""

from collections.abc import Sequence

from app.experiments import facts
from app.results.findings import (
    CLOSE,
    MORE,
    MUCH_MORE,
    Finding,
    Term,
    ahead,
    named,
    share_of,
    term,
)
from app.results.thesis.standard import OTHERS

_RESOLUTION = ("Resolution", "4.3.3")
"""Topic and section."""

_BREAKS = "Standard Q no longer performs acceptably when sensors are coarse."
_NOT_ENOUGH = (
    "The reason is that coarse sensors do not tell enough for any flat policy to do well, while"
    " selection among skills still can."
)
_STAYS = (
    "The coarser the sensors, the more often a step ends in the state that it started in, which can"
    " slow learning down significantly."
)
_CONSTRAINED = (
    "Constrained exploration is useful with coarse sensors, since early on fewer steps stay within"
    " a state."
)
_HURTS = "Three skills from the start get significantly worse as sensors get coarser."
_LEAVES = "Timed learning goes on performing fairly well with coarse sensors."
_FAVORABLY = "It scales better than both others as sensors get coarser."
_OVERALL = "All in all timed learning is a useful extension, and does well everywhere."

_COARSE = {"16×11": "at 16×11", "8×6": "at 8×6"}
_READINGS = {
    **_COARSE,
    "16×11 selection": "with a selection at 16×11",
    "8×6 selection": "with a selection at 8×6",
}
"""Worlds with coarse sensors, and how claims have them."""
_STEPS = share_of("steps")


def _world_of(learner: str, world: str) -> str:
    """Where a learner was run: one without skills has no reading of its own."""
    return world.split()[0] if learner == "standard_q" else world


FINDINGS: Sequence[Finding] = (
    *(
        ahead(
            *_RESOLUTION,
            _STAYS,
            f"early steps of standard Q stay in their state more often at {coarse} than at {fine}:"
            " by more than 0.05 of the steps",
            term(coarse, "standard_q", facts.STAYED),
            term(world, "standard_q", facts.STAYED),
            named("above", 0.05, _STEPS),
        )
        for world, fine, coarse in (("120", "24×18", "16×11"), ("16×11", "16×11", "8×6"))
    ),
    *(
        ahead(
            *_RESOLUTION,
            _STAYS,
            f"standard Q learns significantly slower at {world} than at 24×18: from 0 to 2 M steps",
            term("120", "standard_q", "0–2 M"),
            term(world, "standard_q", "0–2 M"),
            MUCH_MORE,
        )
        for world in _COARSE
    ),
    ahead(
        *_RESOLUTION,
        _CONSTRAINED,
        "early steps of timed stay in their state less often than those of three skills from the"
        " start at 8×6: by more than 0.05 of the steps",
        term("8×6", "hierarchical_3", facts.STAYED),
        term("8×6", "timed", facts.STAYED),
        named("above", 0.05, _STEPS),
    ),
    *(
        ahead(
            *_RESOLUTION,
            _BREAKS,
            f"lower resolution breaks standard Q: it ends lower by a wide margin at {world}",
            term("120", "standard_q"),
            term(world, "standard_q"),
            MUCH_MORE,
        )
        for world in _COARSE
    ),
    *(
        ahead(
            *_RESOLUTION,
            _NOT_ENOUGH,
            "timed ends above a standard Q that starts from hope and tries nothing at random,"
            f" {where}",
            term(world, "timed"),
            term(world, "standard_q, hopeful"),
        )
        for world, where in _COARSE.items()
    ),
    *(
        ahead(
            *_RESOLUTION,
            _HURTS,
            f"three skills from the start end significantly lower {where}",
            term("120", "hierarchical_3"),
            term(world, "hierarchical_3"),
            MUCH_MORE,
        )
        for world, where in _READINGS.items()
    ),
    *(
        ahead(
            *_RESOLUTION,
            _LEAVES,
            f"lower resolution leaves timed working: it ends close to 24×18 {where}",
            term("120", "timed"),
            term(world, "timed"),
            CLOSE,
        )
        for world, where in _READINGS.items()
    ),
    *(
        Finding(
            *_RESOLUTION,
            _FAVORABLY,
            f"timed scales better than {name}: its lead in the end is higher {where} than at 24×18",
            (
                term(world, "timed"),
                Term(-1, _world_of(other, world), other),
                Term(-1, "120", "timed"),
                term("120", other),
            ),
            MORE,
        )
        for world, where in _READINGS.items()
        for other, name in OTHERS.items()
    ),
    *(
        ahead(
            *_RESOLUTION,
            _OVERALL,
            f"timed ends above {name} {where}",
            term(world, "timed"),
            term(_world_of(other, world), other),
        )
        for world, where in _READINGS.items()
        for other, name in OTHERS.items()
    ),
    *(
        ahead(
            *_RESOLUTION,
            _OVERALL,
            f"timed ends above two skills {where}",
            term(world, "timed"),
            term(world, "hierarchical_2"),
        )
        for world, where in _READINGS.items()
        if world.startswith("8×6")
    ),
)
