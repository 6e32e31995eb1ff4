"""Seeds that an experiment has been run with so far, as its table of results holds them."""

import json
from collections.abc import Iterable, Mapping
from typing import NamedTuple, Self

from app.documents.experiments import Experiment


class SeedLists(NamedTuple):
    """Seeds as they are stated: where starts are not shared, each stands for one of a run's own."""

    every: list[int]
    own: dict[str, list[int]]
    """Of the variants whose presets have their own, by label."""

    @classmethod
    def of(cls, experiment: Experiment) -> Self:
        """Those that an experiment asks for."""
        own = {v.label: list(v.seeds) for v in experiment.variants if v.seeds is not None}
        return cls(list(experiment.seeds), own)

    @classmethod
    def noted(cls, about: Mapping[str, str]) -> Self:
        """Those that a table says; raises `ValueError` or `KeyError` if it says none."""
        return cls(json.loads(about["seeds"]), json.loads(about["own_seeds"]))

    @property
    def notes(self) -> dict[str, str]:
        """What a table says of them."""
        return {"seeds": json.dumps(self.every), "own_seeds": json.dumps(self.own)}

    def and_of(self, other: Self) -> Self:
        """These, and then what others there are of the same variants."""
        own = {label: _together(seeds, other.own[label]) for label, seeds in self.own.items()}
        return self._replace(every=_together(self.every, other.every), own=own)

    def and_of_runs(self, runs: Iterable[tuple[str, int]]) -> Self:
        """These, and then those of runs, each with the label of its variant."""
        seeds: dict[str, list[int]] = {label: [] for label in self.own}
        others: list[int] = []
        for label, seed in runs:
            seeds.get(label, others).append(seed)
        return self.and_of(self._replace(every=others, own=seeds))

    def n_of(self, label: str) -> int:
        """How many a variant has."""
        return len(self.own.get(label, self.every))

    @property
    def n_counting_up(self) -> int | None:
        """As many as each has, if they count up from a first one, as ``--seeds`` has it."""
        n = len(self.every)
        lists = (self.every, *self.own.values())
        return n if all(each == [*range(each[0], each[0] + n)] for each in lists) else None


def _together(first: Iterable[int], others: Iterable[int]) -> list[int]:
    return [*dict.fromkeys([*first, *others])]
