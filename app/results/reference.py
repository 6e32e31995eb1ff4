"""Which variant the others are set against, and which stand for many, on the page as in reports"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from app.documents import presets


class Setting(NamedTuple):
    """What a variant is made of."""

    preset: str
    """Name of its preset."""
    overrides: Mapping[str, Any]
    """What an experiment sets in it."""
    settings: Mapping[str, Any]
    """All of its settings, as JSON has them."""


def reference_of(variants: Iterable[Setting]) -> int:
    """The place of the first variant that is a shipped preset as it is, or else of the first.

    So the sign of a difference is what a reader expects: what was changed, less what was there.
    """
    return next((place for place, variant in enumerate(variants) if _is_plain(variant)), 0)


def told_of(values: Sequence[float], reference: int, most: int) -> list[int]:
    """Places of variants that stand for all of them where not all can be drawn.

    These are the one that others are set against, the highest and the lowest, and between these as
    many more as there is room for, spread evenly by rank: so it can be seen how far they lie apart,
    and not only how well the luckiest did.

    Args:
        values: a number of each; NaN where there is none yet.
        reference: the place of the one that others are set against.
        most: that can be drawn.

    Returns:
        The places, in their order.
    """
    every = range(len(values))
    if len(values) <= most:
        return [*every]
    ranked = sorted(
        (place for place in every if place != reference and not math.isnan(values[place])),
        key=lambda place: values[place],
    )
    n = min(most - 1, len(ranked))
    chosen = {reference, *(ranked[round(k * (len(ranked) - 1) / max(n - 1, 1))] for k in range(n))}
    # Before all have values, the first ones fill up.
    for place in every:
        if len(chosen) < most:
            chosen.add(place)
    return sorted(chosen)


def _is_plain(variant: Setting) -> bool:
    """Whether a variant is a shipped preset, by its name or written out."""
    if variant.overrides:
        return False
    mine = {**variant.settings, "description": ""}
    return variant.preset in presets.shipped() or any(
        mine == {**(presets.shipped_settings(name) or {}), "description": ""}
        for name in presets.shipped()
    )
