"""Experiments: from a file to all the runs it asks for, or to all that is wrong with it.

An experiment names presets and says what is varied in them (:mod:`app.documents.experiment_spec`).
A *variant* is one preset with one choice of values (:mod:`app.documents.variants`); each variant is
run once for each seed.
"""

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from app.documents.experiment_spec import ExperimentSpec
from app.documents.faults import faults_of, may_be_left_out, without_nulls
from app.documents.sources import STDIN, Shipped, called
from app.documents.tree import (
    Node,
    PresetError,
    PresetProblem,
    UnusableError,
    document_of,
    in_order,
    plain,
    without,
)
from app.documents.variants import Expansion, Variant
from app.util.texts import as_text, folder_name

_SHIPPED: Final = Shipped(
    "experiment",
    "presets/experiments",
    files("presets") / "experiments",
    ("figure_4_1", "figure_4_2", "figure_4_3"),
)


class ExperimentError(PresetError):
    """An experiment that cannot be run; carries everything that is wrong with it."""


class Experiment(ExperimentSpec):
    """Everything that is asked for and all the runs that it comes to. Equal to itself alone.

    It is made of values that have been looked at, without looking again: ``model_construct``.
    """

    name: str
    text: bytes
    """The file as it was given."""
    variants: tuple[Variant, ...]
    source: str = ""
    """How it was named where it can be named again; empty if it was given as a text."""
    own_seeds: Mapping[str, Sequence[int]] = {}
    """Of each variant by its label, where starts are not shared."""

    def __eq__(self, other: object) -> bool:
        return self is other

    def __hash__(self) -> int:
        return id(self)

    @property
    def n_runs(self) -> int:
        """Runs in all."""
        return len(self.variants) * len(self.seeds)

    @property
    def n_drawn(self) -> int:
        """Variants of which some values were drawn at random."""
        return sum(variant.is_draw for variant in self.variants)

    def seeds_of(self, variant: Variant) -> Sequence[int]:
        """The seeds of a variant: its own ones unless starts are shared."""
        return self.seeds if self.common_starts else self.own_seeds[variant.label]

    def trials_of(self, variant: Variant) -> int:
        """Trials after which a run of a variant ends, whatever else may end it."""
        return self.last_trial(variant.spec)

    def runs(self) -> Iterator[tuple[Variant, int]]:
        """Every run as its variant and seed: first all variants with the first seed."""
        for index in range(len(self.seeds)):
            for variant in self.variants:
                yield variant, self.seeds_of(variant)[index]


def own_seed(label: str, seed: int) -> int:
    """Seed of a variant's own: a function of its label and of the seed it stands for."""
    found = hashlib.sha256(f"{label}\0{seed}".encode()).digest()
    return int.from_bytes(found[:8], "big") >> 1


def shipped() -> dict[str, Traversable]:
    """The experiments that come with the lab, by name: first the thesis's own."""
    return _SHIPPED.files()


def load(name_or_path: str, n_seeds: int | None = None) -> Experiment:
    """Read a shipped experiment, a file or standard input.

    Args:
        name_or_path: ``-`` for standard input.
        n_seeds: takes the place of the file's seeds.

    Raises:
        ExperimentError: it cannot be run; with all that is wrong with it.
    """
    try:
        found = _SHIPPED.asked_for(name_or_path)
    except UnusableError as error:
        problem = PresetProblem(called(name_or_path), None, "", None, error.message)
        raise ExperimentError([problem]) from None
    experiment = parse(found.data, found.label, found.folder, n_seeds)
    name = as_text(name_or_path)
    can_be_named_again = name_or_path != STDIN and "\N{REPLACEMENT CHARACTER}" not in name
    return experiment.model_copy(update={"source": name if can_be_named_again else ""})


def parse(
    data: bytes | str, source: str, folder: Path | None = Path(), n_seeds: int | None = None
) -> Experiment:
    """Read an experiment from a text.

    Args:
        data: the text.
        source: what its problems call it; the experiment's name is the stem of it, or near to it
            where no folder could be called so.
        folder: where paths of presets start; None if only shipped presets may be named.
        n_seeds: seeds 0 to so many less one, in the place of those that it names.

    Raises:
        ExperimentError: it cannot be run; with all that is wrong with it.
    """
    problems: list[PresetProblem] = []
    root = document_of(data, source, problems)
    if root is None:
        raise ExperimentError(problems)
    asked, root = _asked(root, problems)
    expansion = Expansion(asked, root, folder, problems)
    plans = expansion.plans()
    seeds = asked.seeds if n_seeds is None else range(n_seeds)
    variants = expansion.variants(plans) if expansion.few_enough(plans, len(seeds)) else ()
    own_seeds = {} if asked.common_starts else _own_seeds(variants, seeds)
    if len({seed for own in own_seeds.values() for seed in own}) < len(own_seeds) * len(seeds):
        message = "leads to one seed for two runs; allowed: another label, or other seeds"
        problems.append(root.problem(message))
    if problems:
        raise ExperimentError(in_order(dict.fromkeys(problems)))
    found: dict[str, Any] = {
        **dict(asked),
        "name": folder_name(Path(source).stem),
        "text": data.encode() if isinstance(data, str) else data,
        "variants": variants,
        "seeds": seeds,
        "own_seeds": own_seeds,
    }
    return Experiment.model_construct(**found)


def _asked(tree: Node, problems: list[PresetProblem]) -> tuple[ExperimentSpec, Node]:
    """What a tree asks for, and the tree, both without what is wrong in it."""
    tree = without_nulls(tree, ExperimentSpec)
    if "presets" not in tree.value:
        problems.append(tree.problem("has no presets; allowed: a list of presets"))
    has_all = True
    while True:
        try:
            return ExperimentSpec.model_validate(plain(tree)), tree
        except ValidationError as error:
            faults = list(faults_of(error, ExperimentSpec))
            # What is missing from then on has been left out here.
            said = [f for f in faults if not f.is_noted and (has_all or not f.is_lacking)]
            problems += [fault.problem(tree) for fault in said]
            left_out = {may_be_left_out(fault.key, ExperimentSpec) for fault in faults}
            tree, former, has_all = without(tree, left_out), tree, False
            if plain(tree) == plain(former):
                raise ExperimentError(in_order(problems)) from None


def _own_seeds(variants: Iterable[Variant], seeds: Sequence[int]) -> dict[str, tuple[int, ...]]:
    return {v.label: tuple(own_seed(v.label, seed) for seed in seeds) for v in variants}
