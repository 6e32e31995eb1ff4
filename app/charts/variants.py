"""What sets the variants of an experiment apart: what was swept in them, and short names."""

import math
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Final

from app.analysis.sweeps import BETWEEN, Sweep, own_place, short_names, sweep_of
from app.documents import presets
from app.documents.experiments import Experiment
from app.results.reference import Setting, reference_of

MOST_CELLS: Final = 300
"""Cells of a plane, or points of a line, that can be told apart and clicked."""


@lru_cache(maxsize=2)
def swept(experiment: Experiment) -> Sweep | None:
    """What was swept, if all variants belong to one preset and fit into a plane or on a line."""
    variants = experiment.variants
    one_preset = len({variant.preset for variant in variants}) == 1
    if not one_preset or len(variants) > MOST_CELLS or experiment.n_drawn:
        return None
    found = sweep_of([v.overrides for v in variants], variants[0].spec.model_dump())
    if found is None or math.prod(len(axle.values) for axle in found.axles) > MOST_CELLS:
        return None
    return found


@lru_cache(maxsize=2)
def own_setting(experiment: Experiment) -> int | None:
    """Place of the variant with the shipped preset's own values of what was swept, if any."""
    sweep, variants = swept(experiment), experiment.variants
    shipped = presets.shipped_settings(variants[0].preset)
    if sweep is None or shipped is None:
        return None
    found = own_place(
        {at: variants[place].overrides for at, place in sweep.places.items()},
        {at: variants[place].spec.model_dump(mode="json") for at, place in sweep.places.items()},
        shipped,
    )
    return None if found is None else sweep.places[found]


@lru_cache(maxsize=2)
def reference(experiment: Experiment) -> int:
    """Place of the variant that the others are set against, as in a report.

    Of what was swept it is the preset's own setting, if that was run.
    """
    own = own_setting(experiment) if swept(experiment) is not None else None
    if own is not None:
        return own
    return reference_of(
        Setting(
            Path(v.preset).stem, v.overrides, {} if v.overrides else v.spec.model_dump(mode="json")
        )
        for v in experiment.variants
    )


@lru_cache(maxsize=2)
def with_short_names(experiment: Experiment) -> tuple[Experiment, str]:
    """An experiment whose variants have short labels, and what these are made of.

    Variants that set the same keys are told apart by the values of those that differ; the preset
    stays before them where there are several. Others keep their labels, and nothing is said.
    """
    variants = experiment.variants
    found = short_names(
        [variant.label for variant in variants],
        [variant.preset for variant in variants],
        [variant.overrides for variant in variants],
        variants[0].spec.model_dump(mode="json"),
    )
    if found is None:
        return experiment, ""
    named = tuple(
        replace(variant, label=name) for variant, name in zip(variants, found.of, strict=True)
    )
    return experiment.model_copy(update={"variants": named}), BETWEEN.join(found.what)
