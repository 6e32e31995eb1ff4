"""Findings on the spread of value in the standard world (section 4.3.1)."""

from collections.abc import Sequence

from app.results.findings import (
    NOT_REACHED,
    REACHED,
    SHARE,
    SPREADS,
    STEPS,
    Finding,
    Margin,
    ahead,
    named,
    term,
)
from app.results.spread import FAR_BEHIND, INNER_RIGHT, NEAR_BEHIND, RIGHT_FLANK, TIMED

_SPREADING = ("Spread of value", "4.3.1")


def _value(sentence: str, claim: str, quantity: str, margin: Margin) -> Finding:
    """On the share of states with a value, at one moment."""
    return Finding(*_SPREADING, sentence, claim, (term(*TIMED, quantity),), margin)


def _more(
    sentence: str, claim: str, larger: str, smaller: str, margin: Margin = SPREADS
) -> Finding:
    """On values in two places or at two moments."""
    terms = term(*TIMED, larger), term(*TIMED, smaller)
    return ahead(*_SPREADING, sentence, claim, *terms, margin)


_CONE = "While there is only approach, value spreads back from the prey in a cone behind it."
_CIRCLE = (
    "When the predator circles, value spreads from this cone counter-clockwise through a ring"
    " around the prey."
)
_INWARDS = "With avoid it spreads from the ring back towards the prey and into its visual field."

FINDINGS: Sequence[Finding] = (
    _value(
        _CONE,
        "with approach only, value is a cone: more than 0.9 of the states that have one lie behind"
        " the prey",
        "behind, approach only",
        named("above", 0.9, SHARE),
    ),
    _more(
        _CONE,
        "the cone falls off: straight behind, capture is more than 25 steps farther from"
        f" {FAR_BEHIND.cells} away than from {NEAR_BEHIND.cells}",
        "far behind, approach only",
        "near behind, approach only",
        named("above", 25, STEPS),
    ),
    _value(
        _CONE,
        f"with approach only, value has not reached the right flank, {RIGHT_FLANK.cells} away",
        "right flank, approach only",
        NOT_REACHED,
    ),
    _value(
        _CIRCLE,
        "circling makes value reach the right flank by the time avoid comes in",
        "right flank, circling",
        REACHED,
    ),
    _more(
        _CIRCLE,
        "circling spreads it counter-clockwise: there is more on the right flank than on the left",
        "right flank, circling",
        "left flank, circling",
    ),
    _value(
        _CIRCLE,
        "the ring goes no further before avoid: ahead to the right it is not there",
        "ahead to the right, circling",
        NOT_REACHED,
    ),
    _value(
        _CIRCLE,
        "with avoid the ring goes on: half way it is there ahead to the right",
        "ahead to the right, half way",
        REACHED,
    ),
    _value(
        _CIRCLE,
        "half way the ring is open: there is a sector of it that value has not reached",
        "thinnest, half way",
        NOT_REACHED,
    ),
    _value(
        _CIRCLE,
        "in the end the ring is closed: value has reached every sector of it",
        "thinnest, the end",
        REACHED,
    ),
    _more(
        _INWARDS,
        f"value spreads inwards: ahead to the right, {INNER_RIGHT.cells} away, there is more in"
        " the end than half way",
        "inner right, the end",
        "inner right, half way",
    ),
    _more(
        _INWARDS,
        "value spreads into the visual field: there is more in the end than with approach only",
        "seen, the end",
        "seen, approach only",
    ),
)
