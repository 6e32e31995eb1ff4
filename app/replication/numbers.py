"""What came out, as numbers and tables of the pages: read from the folders of all experiments."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, NamedTuple

from app.analysis import estimates
from app.analysis.estimates import Estimate, bootstrap_rng
from app.charts.wording import shown_estimate
from app.metrics import BY_COLUMN
from app.replication.page import Found, Table
from app.results.read import Folder, Group, groups_of
from app.words.numbers import in_short

SHOWN: Final[Mapping[str, str]] = {
    "final_reward": "final",
    "final_greedy": "greedy",
    "horizon_reward": "at the horizon",
    "horizon_greedy": "greedy",
    "horizon_area": "area",
}
"""Columns of tables of variants, with their headings."""
PASSAGE: Final = "steps_to_70"
"""The passage that tables of variants show."""

_REWARDS: Final = ".1f"


class Results(NamedTuple):
    """The results of one experiment."""

    folder: Folder
    groups: Sequence[Group]

    def group(self, label: str) -> Group:
        """The runs of a variant; raises KeyError where there is none."""
        found = [group for group in self.groups if group.label == label]
        if not found:
            raise KeyError(f"{self.folder.path.name} has no variant {label!r}")
        return found[0]


def results_of(folder: Folder) -> Results:
    """The results in a folder by variant."""
    return Results(folder, groups_of(folder.rows))


def mean_of(group: Group, column: str) -> Estimate:
    """The mean of a column over the runs of a variant."""
    return estimates.mean(group.values(column), bootstrap_rng())


def texts_of(name: str, results: Results) -> dict[str, str]:
    """The means of all variants, by ``EXPERIMENT: LABEL: COLUMN``."""
    columns = [column for column in BY_COLUMN if column in SHOWN]
    return {
        f"{name}: {group.label}: {column}": shown_estimate(mean_of(group, column), _REWARDS)
        for group in results.groups
        for column in columns
    }


def difference(results: Results, first: str, second: str, column: str) -> str:
    """How much more a variant has than another, in words."""
    terms = [(1.0, results.group(first)), (-1.0, results.group(second))]
    found = estimates.contrast(
        [(weight, group.by_seed(column)) for weight, group in terms], bootstrap_rng()
    )
    return shown_estimate(found.estimate, _REWARDS)


def variants_table(results: Results, labels: Sequence[str] | None = None) -> Table:
    """Variants, a row each: where they end, by greed as well, and how fast they got there."""
    groups = results.groups if labels is None else [results.group(label) for label in labels]
    rows = [
        (
            group.label,
            f"{len(group.runs)}",
            *(shown_estimate(mean_of(group, column), _REWARDS) for column in SHOWN),
            passage(group, PASSAGE),
        )
        for group in groups
    ]
    return Table(("", "runs", *SHOWN.values(), "M steps to 70"), rows)
