"""What was swept in the variants of an experiment: one setting, or the plane of two."""

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from app.figures import Axle, shown_value

Overrides = Mapping[str, Any]
"""What an experiment sets in a preset, by dotted key."""

_FEWEST = 3
"""Variants that make a sweep; two are a comparison."""


class Sweep(NamedTuple):
    """Variants of one preset that differ in one or two settings."""

    axles: tuple[Axle, ...]
    places: Mapping[tuple[int, ...], int]
    """Place of a variant by the index of its value along each axle."""


def sweep_of(variants: Sequence[Overrides], settings: Mapping[str, Any]) -> Sweep | None:
    """What was swept in the variants of a preset; None where it is nothing, or too much.

    Settings that move together count as one.

    Args:
        variants: what each of them sets.
        settings: all settings of one of them, to call an episode by its skill.
    """
    keys = set(variants[0]) if variants else set()
    if len(variants) < _FEWEST or any(set(overrides) != keys for overrides in variants):
        return None
    bundles = _bundles(variants)
    axles = tuple(_axle(bundle, variants, settings) for bundle in bundles)
    if not 1 <= len(axles) <= 2:
        return None
    places = {
        tuple(
            axle.values.index(_value(bundle, overrides))
            for axle, bundle in zip(axles, bundles, strict=True)
        ): place
        for place, overrides in enumerate(variants)
    }
    return Sweep(axles, places) if len(places) == len(variants) else None


def _bundles(variants: Sequence[Overrides]) -> list[list[str]]:
    """Keys that vary, those together that always move together."""
    columns: dict[tuple[int, ...], list[str]] = {}
    for key in variants[0]:
        values = [json.dumps(overrides[key], sort_keys=True) for overrides in variants]
        first = {value: index for index, value in reversed(list(enumerate(values)))}
        if len(first) > 1:
            columns.setdefault(tuple(first[value] for value in values), []).append(key)
    return list(columns.values())


def _axle(
    bundle: Sequence[str], variants: Sequence[Overrides], settings: Mapping[str, Any]
) -> Axle:
    values = list(dict.fromkeys(_value(bundle, overrides) for overrides in variants))
    axle = Axle(_name(bundle, settings), values)
    return axle._replace(values=sorted(values)) if axle.is_numeric else axle


def _name(bundle: Sequence[str], settings: Mapping[str, Any]) -> str:
    """Keys that move together, what they share said once; an episode with its skill."""
    if len(bundle) > 1:
        parts = [key.split(".") for key in bundle]
        differing = [k for k, column in enumerate(zip(*parts, strict=False)) if len({*column}) > 1]
        if len({len(part) for part in parts}) == 1 and len(differing) == 1:
            (place,) = differing
            inner = ", ".join(part[place] for part in parts)
            return ".".join([*parts[0][:place], f"{{{inner}}}", *parts[0][place + 1 :]])
        return ", ".join(bundle)
    episode = re.match(r"schedule\.episodes\.(\d+)\.", bundle[0])
    episodes = settings.get("schedule", {}).get("episodes", ())
    if episode and int(episode[1]) < len(episodes):
        return f"{bundle[0]} ({episodes[int(episode[1])]['skill']})"
    return bundle[0]


def _value(bundle: Sequence[str], overrides: Overrides) -> Any:
    values = [overrides[key] for key in bundle]
    if all(value == values[0] for value in values) and isinstance(values[0], int | float):
        return values[0]
    return ", ".join(shown_value(value) for value in values)
