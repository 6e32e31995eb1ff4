"""Findings on how learners scale with the size of the world (section 4.3.2)."""

from collections.abc import Sequence

from app.results.findings import (
    CAPTURES,
    CLOSE,
    FINAL,
    MUCH_MORE,
    Finding,
    Term,
    ahead,
    named,
    share_of,
    term,
)
from app.results.thesis.quantities import AT_HORIZON, CAUGHT_SOON, EARLY_CAPTURES
from app.results.thesis.standard import OTHERS

_SIZE = ("Size", "4.3.2")
"""Topic and section."""

_MINIMAL = "In the small world the differences between the three full learners are minimal."
_SLIGHTLY = "There timed learning converges slightly faster than three skills from the start."
_EARLY = "There standard Q is ahead of timed learning, at least early on."
_SLOWER = "All three learn more slowly in a larger world."
_STILL = "Timed learning still comes to a good strategy in relatively short time."
_GROWS = (
    "Differences are much more pronounced in the larger worlds, and the advantage of timed learning"
    " grows significantly from the middle one to the large one."
)
_FREQUENCY = (
    "In a larger world those who walk at random are rewarded less often early on, while constrained"
    " exploration goes on bringing reward."
)


def _lead(learner: str, wide: str, narrow: str, quantity: str = FINAL) -> tuple[Term, ...]:
    """How much timed's lead over a learner grows from one world to another."""
    return (
        Term(1, wide, "timed", quantity),
        Term(-1, wide, learner, quantity),
        Term(-1, narrow, "timed", quantity),
        Term(1, narrow, learner, quantity),
    )


_SMALL: Sequence[Finding] = (
    *(
        ahead(
            *_SIZE,
            _MINIMAL,
            f"at 60 the full learners {when}: {claim}",
            term("60", larger, quantity),
            term("60", smaller, quantity),
            CLOSE,
        )
        for when, quantity in (
            ("end close together", FINAL),
            ("are close from 1 to 1.5 M steps", "1–1.5 M"),
        )
        for claim, larger, smaller in (
            ("standard Q and timed", "standard_q", "timed"),
            ("timed and three skills from the start", "timed", "hierarchical_3"),
            ("standard Q and three skills from the start", "standard_q", "hierarchical_3"),
        )
    ),
    ahead(
        *_SIZE,
        _SLIGHTLY,
        "at 60 timed learns faster than three skills from the start: from 0 to 2 M steps",
        term("60", "timed", "0–2 M"),
        term("60", "hierarchical_3", "0–2 M"),
    ),
    ahead(
        *_SIZE,
        _SLIGHTLY,
        "at 60 timed is no more than slightly faster: the two are close from 0 to 2 M steps",
        term("60", "timed", "0–2 M"),
        term("60", "hierarchical_3", "0–2 M"),
        CLOSE,
    ),
    *(
        ahead(
            *_SIZE,
            _EARLY,
            f"at 60 standard Q is ahead of timed early: from {window.replace('–', ' to ')} steps",
            term("60", "standard_q", window),
            term("60", "timed", window),
        )
        for window in ("0–1 M", "1–2 M")
    ),
)

_LARGE: Sequence[Finding] = (
    *(
        ahead(
            *_SIZE,
            _SLOWER,
            f"{name}: slower at 150 than at 60, from 0 to 2 M steps",
            term("60", learner, "0–2 M"),
            term("150", learner, "0–2 M"),
        )
        for learner, name in {"timed": "timed", **OTHERS}.items()
    ),
    Finding(
        *_SIZE,
        _STILL,
        "at 150 timed catches the prey in more than 0.5 of the trials from 1.5 to 2 M steps",
        (term("150", "timed", CAUGHT_SOON),),
        named("above", 0.5, share_of("trials")),
    ),
    *(
        Finding(
            *_SIZE,
            _GROWS,
            f"timed's lead over {name} grows {how} from {narrow} to {wide}{when}",
            _lead(other, wide, narrow, quantity),
            MUCH_MORE,
        )
        for narrow, wide, how, when, quantity in (
            ("60", "120", "much", "", FINAL),
            ("120", "150", "significantly", "", FINAL),
            ("120", "150", "significantly", " at 5.5 M steps", AT_HORIZON),
        )
        for other, name in OTHERS.items()
    ),
    *(
        Finding(
            *_SIZE,
            _FREQUENCY,
            f"the early captures of {name} at 150 are less than 0.25 of those at 60",
            (Term(1, "150", other, EARLY_CAPTURES), Term(-0.25, "60", other, EARLY_CAPTURES)),
            named("below", 0, CAPTURES),
        )
        for other, name in OTHERS.items()
    ),
    Finding(
        *_SIZE,
        _FREQUENCY,
        "the early captures of timed at 150 are more than 0.75 of those at 60",
        (Term(1, "150", "timed", EARLY_CAPTURES), Term(-0.75, "60", "timed", EARLY_CAPTURES)),
        named("above", 0, CAPTURES),
    ),
)

FINDINGS: Sequence[Finding] = (*_SMALL, *_LARGE)
