"""What was swept in the variants of an experiment, one setting, the plane of two or more, and
whether it makes a difference.
"""

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from app.analysis import estimates
from app.analysis.axles import Axle, grouped, told_apart
from app.analysis.estimates import Contrast
from app.words.plain import plain

Overrides = Mapping[str, Any]
"""What an experiment sets in a preset, by dotted key."""

Place = tuple[int, ...]
"""Of a variant in a sweep: the index of its value along each axle."""
Values = Mapping[int, float]
"""A number of each run of a variant, by seed."""

BETWEEN = " / "
"""Stands between the values of a short name."""
_PRESET = "preset"
_FEWEST = 3
"""Variants that make a sweep; two are a comparison."""
_LEAST_COMBINED = 0.5
"""Share of all combinations of several settings that have to be there for a mean over the others
to be one over much the same others at each value."""
NOT_SET = "not set"
"""Stands for the value of a setting that is not there."""


class Sweep(NamedTuple):
    """Variants of one preset that differ in one or two settings."""

    axles: tuple[Axle, ...]
    places: Mapping[Place, int]
    """Where each variant stands among the others, by its place in the sweep."""


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
    if not 1 <= len(bundles) <= 2:
        return None
    columns = [column_of(bundle, variants) for bundle in bundles]
    axles = tuple(map(partial(axle_of, settings=settings), bundles, columns))
    along = (map(axle.values.index, column) for axle, column in zip(axles, columns, strict=True))
    places = {where: place for place, where in enumerate(zip(*along, strict=True))}
    return Sweep(axles, places) if len(places) == len(variants) else None


class Design(NamedTuple):
    """Variants of one preset that differ in more settings than a plane has."""

    axles: tuple[Axle, ...]
    having: tuple[tuple[tuple[int, ...], ...], ...]
    """Of each axle, and each of its values: the places of the variants that have it."""
    is_whole: bool
    """Whether all combinations of the values are there."""


def design_of(variants: Sequence[Overrides], settings: Mapping[str, Any]) -> Design | None:
    """How three or more settings were combined in the variants of a preset.

    None where there are fewer, or where too few of their combinations are there for a value to be
    seen apart from the others. Settings that move together count as one.

    Args:
        variants: what each of them sets.
        settings: all settings of one of them, to call an episode by its skill.
    """
    if any(set(overrides) != set(variants[0]) for overrides in variants):
        return None
    bundles = _bundles(variants)
    columns = [column_of(bundle, variants) for bundle in bundles]
    axles = tuple(map(partial(axle_of, settings=settings), bundles, columns))
    combinations = math.prod(len(axle.values) for axle in axles)
    there = {*zip(*columns, strict=True)}
    if len(axles) <= 2 or len(there) < max(len(variants), _LEAST_COMBINED * combinations):
        return None
    having = tuple(
        tuple(
            tuple(place for place, own in enumerate(column) if own == value)
            for value in axle.values
        )
        for axle, column in zip(axles, columns, strict=True)
    )
    return Design(axles, having, len(there) == combinations)


def _bundles(variants: Sequence[Overrides]) -> list[list[str]]:
    """Keys that vary, those together that always move together."""
    columns: dict[tuple[int, ...], list[str]] = {}
    for key in variants[0]:
        values = [json.dumps(overrides[key], sort_keys=True) for overrides in variants]
        first = {value: index for index, value in reversed(list(enumerate(values)))}
        if len(first) > 1:
            columns.setdefault(tuple(first[value] for value in values), []).append(key)
    return list(columns.values())


def axle_of(bundle: Sequence[str], column: Sequence[Any], settings: Mapping[str, Any]) -> Axle:
    """Keys that move together as one setting, its values in order.

    Args:
        bundle: the keys.
        column: what they are set to in each variant (:func:`column_of`).
        settings: all settings of a variant, to call an episode by its skill.
    """
    values = list(dict.fromkeys(column))
    axle = Axle(_name(bundle, settings), values, _words(bundle, settings))
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
    skill = _skill(episode[1], settings) if episode else ""
    return f"{bundle[0]} ({skill})" if skill else bundle[0]


_WORDS: Mapping[str, tuple[str, str]] = {
    r"schedule\.skills\.(\w+)\.at": (
        "trial at which {} joins",
        "trial at which {} join",
    ),
    r"schedule\.skills\.(\w+)\.freeze": (
        "freeze when {} joins (trials)",
        "freeze when {} join (trials)",
    ),
    r"schedule\.episodes\.(\d+)\.duration": (
        "exploration of {} (trials)",
        "explorations of {} (trials)",
    ),
    r"schedule\.episodes\.(\d+)\.probability": (
        "chance that {} is taken at each step of its exploration",
        "chance that {} are taken at each step of their explorations",
    ),
    r"schedule\.episodes\.(\d+)\.where\.value_at_most": (
        "largest value of others where {} is explored",
        "largest value of others where {} are explored",
    ),
}
"""What keys mean, for one skill and for several, by what a whole key looks like."""


def _words(bundle: Sequence[str], settings: Mapping[str, Any]) -> str:
    """What keys mean that are about skills, and about the same of each; else nothing."""
    for pattern, (of_one, of_several) in _WORDS.items():
        found = [re.fullmatch(pattern, key) for key in bundle]
        skills = [_skill(match[1], settings) for match in found if match is not None]
        if len(skills) == len(bundle) and all(skills):
            *others, last = map(plain, skills)
            listed = f"{', '.join(others)} and {last}" if others else last
            return (of_several if others else of_one).format(listed)
    return ""


def _skill(name_or_place: str, settings: Mapping[str, Any]) -> str:
    """A skill by its name or by the place of its episode; empty if there is no such episode."""
    if not name_or_place.isdigit():
        return name_or_place
    episodes = settings.get("schedule", {}).get("episodes", ())
    place = int(name_or_place)
    return episodes[place]["skill"] if place < len(episodes) else ""


def column_of(bundle: Sequence[str], variants: Sequence[Overrides]) -> list[Any]:
    """What keys that move together are set to in each variant: a number, or a text."""
    texts = [told_apart([overrides[key] for overrides in variants]) for key in bundle]
    column: list[Any] = []
    for overrides, shown in zip(variants, zip(*texts, strict=True), strict=True):
        first, *others = (overrides[key] for key in bundle)
        is_one_number = isinstance(first, int | float) and all(value == first for value in others)
        column.append(first if is_one_number else ", ".join(shown))
    return column


# --- Whether it makes a difference ---------------------------------------------------------------


class Names(NamedTuple):
    """Variants by what tells them apart."""

    what: tuple[str, ...]
    """The settings that differ, those that move together as one."""
    of: tuple[str, ...]
    """Their values in each variant."""


def names_of(variants: Sequence[Overrides], settings: Mapping[str, Any]) -> Names | None:
    """Short names of variants that set the same keys, however many; None where there are none.

    Args:
        variants: what each of them sets.
        settings: all settings of one of them, to call an episode by its skill.
    """
    keys = set(variants[0]) if variants else set()
    if any(set(overrides) != keys for overrides in variants):
        return None
    bundles = _bundles(variants)
    if not bundles:
        return None
    columns = [column_of(bundle, variants) for bundle in bundles]
    what = tuple(
        axle_of(bundle, column, settings).label
        for bundle, column in zip(bundles, columns, strict=True)
    )
    shown = (told_apart(column, grouped) for column in columns)
    of = tuple(map(BETWEEN.join, zip(*shown, strict=True)))
    return Names(what, of) if len(set(of)) == len(of) else None


def short_names(
    labels: Sequence[str],
    presets: Sequence[str],
    variants: Sequence[Overrides],
    settings: Mapping[str, Any],
) -> Names | None:
    """:func:`names_of` variants that nobody has named, the preset before them where it differs.

    Args:
        labels: of the variants; one without a "=" was given by somebody, and then all are kept.
        presets: of the variants.
        variants: what each of them sets.
        settings: all settings of one of them, to call an episode by its skill.
    """
    if not all("=" in label for label in labels):
        return None
    sets = [
        {_PRESET: preset, **overrides} for preset, overrides in zip(presets, variants, strict=True)
    ]
    found = names_of(sets, settings)
    return None if found is None or found.what == (_PRESET,) else found


def own_place(
    overrides: Mapping[Place, Overrides],
    settings: Mapping[Place, Mapping[str, Any]],
    preset: Mapping[str, Any],
) -> Place | None:
    """The place that has the preset's own values of what was swept; None where there is none.

    There is none either where the preset is not the one that was run, but one of the same name.

    Args:
        overrides: what the variant at each place sets.
        settings: all settings of the variant at each place.
        preset: all settings of the preset.
    """
    own = _leaves(preset)
    varied = [key for bundle in _bundles([*overrides.values()]) for key in bundle]
    for place, sets in overrides.items():
        if all(_below(own, [key]) == _leaves(sets[key], key) for key in varied):
            found = _leaves(settings[place])
            return place if _rest(found, sets) == _rest(own, sets) else None
    return None


def _leaves(settings: Any, key: str = "") -> dict[str, Any]:
    """Settings by dotted key, without the description, which changes nothing."""
    if isinstance(settings, Mapping):
        items = [(name, value) for name, value in settings.items() if key or name != "description"]
    elif isinstance(settings, list | tuple):
        items = list(enumerate(settings))
    else:
        return {key: settings}
    found: dict[str, Any] = {}
    for name, value in items:
        found |= _leaves(value, f"{key}.{name}" if key else str(name))
    return found


def differing(first: Mapping[str, Any], second: Mapping[str, Any]) -> list[tuple[str, Any, Any]]:
    """Settings that are not the same in both, by dotted key, with both their values."""
    mine, theirs = _leaves(first), _leaves(second)
    both = ((key, mine.get(key, NOT_SET), theirs.get(key, NOT_SET)) for key in {**mine, **theirs})
    return [(key, one, other) for key, one, other in both if one != other]


def _below(leaves: Mapping[str, Any], keys: Iterable[str]) -> dict[str, Any]:
    """Those of the settings that are one of the keys, or within one."""
    whole = set(keys)
    starts = tuple(f"{key}." for key in whole)
    return {key: leaves[key] for key in leaves if key in whole or key.startswith(starts)}


def _rest(leaves: Mapping[str, Any], keys: Iterable[str]) -> dict[str, Any]:
    """Those of the settings that are none of the keys, nor within one."""
    within = _below(leaves, keys)
    return {key: value for key, value in leaves.items() if key not in within}


def highest(values: Mapping[Place, Values]) -> Place:
    """The place with the highest mean of the runs that have a value."""

    def mean(place: Place) -> float:
        there = [value for value in values[place].values() if math.isfinite(value)]
        return sum(there) / len(there) if there else -math.inf

    return max(values, key=mean)


def highest_unseen(values: Mapping[Place, Values]) -> float:
    """Mean of the highest place as it would be in runs that have not chosen it.

    A place that came out highest of many did so by luck as well, and its own mean is too high.
    So for each seed the place is chosen by all other seeds and measured at this one. NaN where
    fewer than two seeds are shared by all places.
    """
    there = [
        {seed for seed, value in by_seed.items() if math.isfinite(value)}
        for by_seed in values.values()
    ]
    shared = set.intersection(*there)
    if len(shared) < 2:
        return math.nan
    seeds = sorted(shared)
    table = np.asarray([[by_seed[seed] for seed in seeds] for by_seed in values.values()])
    by_the_others = table.sum(axis=1, keepdims=True) - table
    return float(table[by_the_others.argmax(axis=0), np.arange(len(seeds))].mean())


def differences(values: Mapping[Place, Values], reference: Place) -> dict[Place, Contrast]:
    """How much higher each other place is than one of them.

    Args:
        values: of each place.
        reference: the one that the others are set against.
    """
    theirs = values[reference]
    return {
        place: estimates.contrast([(1.0, mine), (-1.0, theirs)], estimates.bootstrap_rng())
        for place, mine in values.items()
        if place != reference
    }
