"""Experiments: from a file to all the runs it asks for, or to all that is wrong with it.

An experiment names presets and says what is varied in them (:mod:`app.documents.experiment_spec`).
A *variant* is one preset with one choice of values (:mod:`app.documents.variants`); each variant is
run once for each seed.
"""

import hashlib
import re
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
from app.words.numbers import counted
from sim.rng import MAX_SEED

_SHIPPED: Final = Shipped(
    "experiment",
    "presets/experiments",
    files("presets") / "experiments",
    ("figure_4_1", "figure_4_2", "figure_4_3"),
)


class ExperimentError(PresetError):
    """An experiment that cannot be run; carries everything that is wrong with it."""


def titled(name: str) -> str:
    """The name of an experiment in words; numbers that only an underscore parts have a point."""
    words = re.sub(r"(?<=\d)_(?=\d)", ".", name).replace("_", " ").strip() or name
    return words[:1].upper() + words[1:]


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
    """Of variants by their labels, of those that do not have the experiment's."""

    def __eq__(self, other: object) -> bool:
        return self is other

    def __hash__(self) -> int:
        return id(self)

    @property
    def title(self) -> str:
        """Its name in words, as ``figure_4_1`` is "Figure 4.1"."""
        return titled(self.name)

    @property
    def n_runs(self) -> int:
        """Runs in all."""
        return sum(len(self.seeds_of(variant)) for variant in self.variants)

    @property
    def n_drawn(self) -> int:
        """Variants of which some values were drawn at random."""
        return sum(variant.is_draw for variant in self.variants)

    def seeds_of(self, variant: Variant) -> Sequence[int]:
        """The seeds of a variant: those of all, unless it has its own or starts are not shared."""
        return self.own_seeds.get(variant.label, self.seeds)

    @property
    def seeds_in_words(self) -> str:
        """How many seeds the variants have."""
        counts = sorted({len(self.seeds_of(variant)) for variant in self.variants})
        if len(counts) == 1:
            return counted(counts[0], "seed")
        return f"{counts[0]:,} to {counts[-1]:,} seeds"

    def trials_of(self, variant: Variant) -> int:
        """Trials after which a run of a variant ends, whatever else may end it."""
        return self.last_trial(variant.spec)

    def runs(self) -> Iterator[tuple[Variant, int]]:
        """Every run as its variant and seed: first all variants with the first seed."""
        seeds = [self.seeds_of(variant) for variant in self.variants]
        for index in range(max(map(len, seeds), default=0)):
            for variant, own in zip(self.variants, seeds, strict=True):
                if index < len(own):
                    yield variant, own[index]


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
        n_seeds: so many seeds, counting up from the file's first, take the place of its own.

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
        n_seeds: so many seeds, counting up from the first that it names, in the place of these; of
            a preset that has seeds of its own, from the first of them.

    Raises:
        ExperimentError: it cannot be run; with all that is wrong with it.
    """
    problems: list[PresetProblem] = []
    root = document_of(data, source, problems)
    if root is None:
        raise ExperimentError(problems)
    asked, root = _asked(root, problems)
    if n_seeds is not None:
        asked = _with_seeds(asked, n_seeds, root, problems)
    expansion = Expansion(asked, root, folder, problems)
    plans = expansion.plans()
    variants = expansion.variants(plans) if expansion.few_enough(plans) else ()
    own_seeds = _own_seeds(variants, asked)
    n_own = sum(map(len, own_seeds.values()))
    if not asked.common_starts and len({s for own in own_seeds.values() for s in own}) < n_own:
        message = "leads to one seed for two runs; allowed: another label, or other seeds"
        problems.append(root.problem(message))
    if problems:
        raise ExperimentError(in_order(dict.fromkeys(problems)))
    found: dict[str, Any] = {
        **dict(asked),
        "name": folder_name(Path(source).stem),
        "text": data.encode() if isinstance(data, str) else data,
        "variants": variants,
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


def _with_seeds(
    asked: ExperimentSpec, n_seeds: int, root: Node, problems: list[PresetProblem]
) -> ExperimentSpec:
    """What is asked for with so many seeds, from the first of all and from each preset's own."""

    def counted_up(seeds: Sequence[int]) -> Sequence[int]:
        if seeds[0] + n_seeds - 1 > MAX_SEED:
            message = f"has no {n_seeds} seeds from {seeds[0]} on; allowed: up to {MAX_SEED}"
            problems.append(root.problem(message))
            return seeds
        return range(seeds[0], seeds[0] + n_seeds)

    presets = tuple(
        item if item.seeds is None else item.model_copy(update={"seeds": counted_up(item.seeds)})
        for item in asked.presets
    )
    return asked.model_copy(update={"seeds": counted_up(asked.seeds), "presets": presets})


def _own_seeds(variants: Iterable[Variant], asked: ExperimentSpec) -> dict[str, Sequence[int]]:
    """Seeds of the variants that do not simply have those of the experiment."""
    if asked.common_starts:
        return {v.label: v.seeds for v in variants if v.seeds is not None}
    return {
        v.label: tuple(own_seed(v.label, seed) for seed in v.seeds or asked.seeds) for v in variants
    }
