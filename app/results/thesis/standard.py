"""Findings on the standard world (section 4.3.1), but for the spread of value."""

from collections.abc import Sequence

from app.experiments import facts
from app.results.findings import (
    CELLS,
    CELLS_A_STEP,
    CLOSE,
    FINAL,
    MILLION_STEPS,
    MORE,
    MUCH_MORE,
    REACHED,
    SPREADS,
    Finding,
    Term,
    ahead,
    named,
    share_of,
    term,
)
from app.results.thesis.quantities import AT_HORIZON, CAUGHT_WITH_AVOID, PASSAGE

_STANDARD = ("Standard world", "4.3.1")
"""Topic and section."""
OTHERS = {"standard_q": "standard Q", "hierarchical_3": "three skills from the start"}
"""The thesis's other learners with a full repertoire."""
FOOTINGS = {"ends": FINAL, "at 5.5 M steps is": AT_HORIZON}
"""Both ends of a comparison: when each learner's trials are over, and after the same steps."""

_OUTPERFORMS = "Timed learning does significantly better than both others."
FAR_SOONER = "It converges a good deal faster than both of them."
_TWO_SKILLS = (
    "Two skills converge very quickly, but at a lower level, since the predator cannot back away"
    " when it starts in the prey's view or strays into it."
)
_WALK = (
    "Learners with all actions from the start depend on a random walk at first, while two skills"
    " bring the predator closer on average."
)
_CONSISTENT = "So two skills get reward much more consistently early on, and learn much faster."
_DIPS = (
    "Timed learning dips significantly twice, while it explores the skill that has just come in,"
    " and recovers."
)
_THROUGHOUT = (
    "By trying mostly approach and then circle, it spreads value rapidly throughout the state"
    " space."
)
_WELL = "When the exploration of avoid is over, it is rapidly doing quite well."
_PERIPHERY = (
    "Avoid is explored with a lower probability, lest the predator drift away and spend most of its"
    " time at the periphery."
)


def _timed(quantity: str = FINAL) -> Term:
    return term("120", "timed", quantity)


def _other(learner: str, quantity: str = FINAL) -> Term:
    return term("120", learner, quantity)


_COMPARED: Sequence[Finding] = (
    *(
        ahead(
            *_STANDARD,
            _OUTPERFORMS,
            f"timed {when} above {name} by a wide margin",
            _timed(quantity),
            _other(other, quantity),
            MUCH_MORE,
        )
        for when, quantity in FOOTINGS.items()
        for other, name in OTHERS.items()
    ),
    *(
        ahead(
            *_STANDARD,
            FAR_SOONER,
            f"timed learns a good deal faster than {name}: from 1.5 to 2 M steps",
            _timed("1.5–2 M"),
            _other(other, "1.5–2 M"),
            MUCH_MORE,
        )
        for other, name in OTHERS.items()
    ),
    *(
        ahead(
            *_STANDARD,
            FAR_SOONER,
            f"timed comes to 50 for good more than 0.55 M steps before {name}, who counts"
            " as there at 5.5 M at the latest",
            _other(other, PASSAGE),
            _timed(PASSAGE),
            named("above", 0.55, MILLION_STEPS),
        )
        for other, name in OTHERS.items()
    ),
)

_SHARE_LOST, _SHARE_SEEN, _SHARE_FLIGHTS = (share_of(n) for n in ("losses", "starts", "flights"))

_OF_TWO_SKILLS: Sequence[Finding] = (
    *(
        ahead(
            *_STANDARD,
            _CONSISTENT,
            f"two skills get much more reward than {name} early: from 0 to 0.5 M steps",
            _other("hierarchical_2", "0–0.5 M"),
            _other(other, "0–0.5 M"),
            MUCH_MORE,
        )
        for other, name in OTHERS.items()
    ),
    *(
        ahead(
            *_STANDARD,
            _TWO_SKILLS,
            f"two skills are very fast: ahead of {name} from 0.5 to 1 M steps",
            _other("hierarchical_2", "0.5–1 M"),
            _other(other, "0.5–1 M"),
            MUCH_MORE,
        )
        for other, name in OTHERS.items()
    ),
    ahead(
        *_STANDARD,
        _TWO_SKILLS,
        "two skills stop: they end close to where they are from 0.5 to 1 M steps",
        _other("hierarchical_2"),
        _other("hierarchical_2", "0.5–1 M"),
        CLOSE,
    ),
    *(
        ahead(
            *_STANDARD,
            _TWO_SKILLS,
            f"timed {when} above two skills",
            _timed(quantity),
            _other("hierarchical_2", quantity),
        )
        for when, quantity in FOOTINGS.items()
    ),
    *(
        Finding(
            *_STANDARD,
            _TWO_SKILLS,
            f"once two skills have stopped, more than {bound:g} of {claim}",
            (_other("hierarchical_2", quantity),),
            named("above", bound, unit),
        )
        for claim, quantity, bound, unit in (
            ("the trials that they lose end in flight", facts.LOST_TO_FLIGHT, 0.5, _SHARE_LOST),
            ("the trials that start in view end in flight", facts.SEEN_FLEE, 0.5, _SHARE_SEEN),
        )
    ),
    # Both shares make up one, so each is above a quarter where they differ by less than a half.
    Finding(
        *_STANDARD,
        _TWO_SKILLS,
        "once two skills have stopped, they flee from starts in view and from others alike: the"
        " shares of their flights differ by less than 0.5",
        (
            _other("hierarchical_2", facts.FLIGHTS_SEEN),
            _other("hierarchical_2", facts.FLIGHTS_UNSEEN)._replace(weight=-1),
        ),
        named("within", 0.5, _SHARE_FLIGHTS),
    ),
    *(
        Finding(
            *_STANDARD,
            _WALK,
            f"the early steps of {name} bring the predator neither closer nor farther:"
            " within 0.1 cells a step",
            (_other(other, facts.GAINED),),
            named("within", 0.1, CELLS_A_STEP),
        )
        for other, name in OTHERS.items()
    ),
    Finding(
        *_STANDARD,
        _WALK,
        "the early steps of two skills bring the predator closer: by more than 0.1 cells a step",
        (_other("hierarchical_2", facts.GAINED),),
        named("above", 0.1, CELLS_A_STEP),
    ),
)

_OF_TIMED: Sequence[Finding] = (
    *(
        ahead(*_STANDARD, _DIPS, claim, _timed(larger), _timed(smaller), margin)
        for claim, larger, smaller, margin in (
            (
                "timed dips significantly when circle comes in",
                "before circle",
                "circle explored",
                MUCH_MORE,
            ),
            (
                "timed recovers from circle: it is above what it was while exploring it",
                "circle mastered",
                "circle explored",
                MORE,
            ),
            (
                "timed dips significantly when avoid comes in",
                "circle mastered",
                "avoid explored",
                MUCH_MORE,
            ),
            (
                "timed recovers from avoid: it is above what it was while exploring it",
                "avoid mastered",
                "avoid explored",
                MORE,
            ),
        )
    ),
    Finding(
        *_STANDARD,
        _WELL,
        "timed catches the prey in more than 0.5 of the first 1,000 trials after it has explored"
        " avoid",
        (_timed(CAUGHT_WITH_AVOID),),
        named("above", 0.5, share_of("trials")),
    ),
    *(
        ahead(
            *_STANDARD,
            _THROUGHOUT,
            f"after 1 M steps value has spread to more states in timed than in {name}",
            _timed(facts.VALUED_SOON),
            _other(other, facts.VALUED_SOON),
            SPREADS,
        )
        for other, name in OTHERS.items()
    ),
    Finding(
        *_STANDARD,
        _THROUGHOUT,
        "after 1 M steps, as avoid comes in, value has reached most states in timed",
        (_timed(facts.VALUED_SOON),),
        REACHED,
    ),
    ahead(
        *_STANDARD,
        _PERIPHERY,
        "explored with probability 0.95, avoid has the predator more than 20 cells farther off than"
        " with 0.3",
        _other("timed, avoid at 0.95", facts.distance("avoid")),
        _timed(facts.distance("avoid")),
        named("above", 20, CELLS),
    ),
    Finding(
        *_STANDARD,
        _PERIPHERY,
        "explored with probability 0.95, avoid has it farther off than any start in more than 0.5"
        " of the steps",
        (_other("timed, avoid at 0.95", facts.far("avoid")),),
        named("above", 0.5, share_of("steps")),
    ),
    Finding(
        *_STANDARD,
        _PERIPHERY,
        "explored with probability 0.3, avoid has it farther off than any start in less than 0.25"
        " of the steps",
        (_timed(facts.far("avoid")),),
        named("below", 0.25, share_of("steps")),
    ),
)

FINDINGS: Sequence[Finding] = (*_COMPARED, *_OF_TWO_SKILLS, *_OF_TIMED)
