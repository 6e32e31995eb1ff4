"""Learners in several worlds, as data: what a chart of them shows, and the numbers beside it."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from app.analysis.estimates import Estimate


class Standing(NamedTuple):
    """How a learner does in each of some worlds."""

    label: str
    estimates: Sequence[Estimate]
    """World by world."""
    is_new: bool = False
    """Whether it is told apart from those that it is set against."""


class Standings(NamedTuple):
    """Learners under one another in several worlds, one column for each quantity.

    Rows are shared by their order; the first of the worlds is the one that is seen first.
    """

    worlds: Sequence[str]
    columns: Mapping[str, Sequence[Standing]]
    """The rows of each quantity, by its name with unit."""
    against: str = ""
    """Label of the row whose value is marked throughout; empty for none."""

    @property
    def numbers(self) -> list[Sequence[Any]]:
        """All estimates."""
        rows: list[Sequence[Any]] = [["quantity", "row", "world", "value", "low", "high", "n"]]
        for what, standings in self.columns.items():
            for standing in standings:
                pairs = zip(self.worlds, standing.estimates, strict=True)
                rows += [[what, standing.label, world, *found] for world, found in pairs]
        return rows
