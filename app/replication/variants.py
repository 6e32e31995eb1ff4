"""Variants of experiments as numbers and tables: where they end, and how fast they get there."""

import math
import statistics
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, NamedTuple

from app.analysis import estimates, passages
from app.analysis.estimates import Estimate, bootstrap_rng
from app.charts.wording import shown_estimate, shown_median
from app.documents.samples import is_draw
from app.metrics import BY_COLUMN
from app.replication.page import Found, Table
from app.results import read, thesis
from app.results.read import Folder, Group, Reader, groups_of, read_folder
from app.words.numbers import NONE, in_millions, shown_number

SHOWN: Final[Mapping[str, str]] = {
    "final_reward": "end of the trials",
    "final_greedy": "by greed",
    "horizon_reward": "at the horizon",
    "horizon_greedy": "by greed",
    "horizon_area": "area to the horizon",
}
"""Columns of tables of variants, with their headings."""
SEARCHED_FOR: Final = ("horizon_reward", "horizon_area")
"""What is searched for: the end, and speed."""
PASSAGES: Final = ("steps_to_70", "first_to_70")
"""The passage that tables of variants show, and what it is to be told apart from."""
ELSEWHERE: Final = ("size 60", "size 150", "sensors 16 x 11", "sensors 8 x 6")
"""The worlds in which what was tuned in the standard one is run as well."""
TUNED: Final = (
    ("standard Q, tuned for the end", "timed, tuned for the end"),
    ("standard Q, tuned for speed", "timed, tuned for speed"),
    ("standard Q, hopeful", "timed, tuned for the end"),
)
"""What is set against one another in all worlds."""

REWARDS: Final = ".1f"
"""How a reward is written."""


class Results(NamedTuple):
    """The results of one experiment."""

    folder: Folder
    groups: Sequence[Group]

    def group(self, label: str) -> Group:
        """The runs of a variant; raises KeyError where there is none."""
        for group in self.groups:
            if group.label == label:
                return group
        raise KeyError(f"{self.folder.path.name} has no variant {label!r}")


def results_in(path: Path) -> Results:
    folder = read_folder(path)
    return Results(folder, groups_of(folder.rows))


class Logs(NamedTuple):
    """Runs of several experiments by their place in the thesis, and who reads their logs once."""

    placed: thesis.Placed
    reader: Reader


def logs_of(results: Sequence[Results]) -> Logs:
    """The logs of the runs of several experiments; none is read yet."""
    rows = [run for each in results for run in each.folder.rows]
    reader = Reader(read.widths_of(rows), thesis.quantities_of)
    return Logs(thesis.placed_of(groups_of(rows)), reader)


def mean_of(group: Group, column: str) -> Estimate:
    """The mean of a column over the runs of a variant."""
    return estimates.mean(group.values(column), bootstrap_rng())


def difference(results: Results, first: str, second: str, column: str) -> Estimate:
    """How much more a variant has than another, by their labels."""
    terms = [(1.0, results.group(first)), (-1.0, results.group(second))]
    by_seed = [(weight, group.by_seed(column)) for weight, group in terms]
    return estimates.contrast(by_seed, bootstrap_rng()).estimate


def means_of(name: str, results: Results) -> dict[str, str]:
    """The means of all variants by ``EXPERIMENT: LABEL: COLUMN``, those of draws aside."""
    found = {
        f"{name}: {group.label}: {column}": shown_estimate(mean_of(group, column), REWARDS)
        for group in results.groups
        for column in BY_COLUMN
        if column in (*SHOWN, "area")
        and not is_draw(group.label)
        and read.measured([group], column)
    }
    reached = {
        f"{name}: {group.label}: {column}": passage_of(group, column)
        for group in results.groups
        for column in PASSAGES
        if not is_draw(group.label)
    }
    return found | reached


def passage_of(group: Group, column: str = PASSAGES[0]) -> str:
    """The median of the steps until a reward of 70 is kept, or first touched, in millions."""
    every = [*group.passages(column).values()]
    if not every:
        return NONE
    return shown_median(passages.arrivals(every), in_millions)


def _row(label: str, group: Group, shown: Sequence[str] = (*SHOWN,)) -> Sequence[str]:
    means = (shown_estimate(mean_of(group, column), REWARDS) for column in shown)
    return (label, f"{len(group.runs)}", *means, passage_of(group))


def variants_table(results: Results) -> Table:
    """Variants, a row each: where they end, by greed as well, and how fast they got there.

    Where runs end at the horizon, whatever their presets' trials, there is no other end. What is
    set against one another in all worlds has a table of its own.
    """
    is_cut = any(run.origin.steps_alone for run in results.folder.rows)
    shown = [column for column in SHOWN if not (is_cut and column.startswith("final_"))]
    tuned = {_in_world(label, where) for both in TUNED for label in both for where in ELSEWHERE}
    rows = [_row(g.label, g, shown) for g in results.groups if g.label not in tuned]
    return Table(("", "runs", *(SHOWN[column] for column in shown), "M steps to 70"), rows)


def elsewhere_table(results: Results) -> Table:
    """How what was tuned in the standard world does in it and in the others."""
    rows: list[Sequence[str]] = []
    for where in ("", *ELSEWHERE):
        for both in TUNED:
            theirs, mine = (_in_world(label, where) for label in both)
            cells: list[str] = []
            for column in SEARCHED_FOR:
                means = (mean_of(results.group(label), column) for label in (mine, theirs))
                lead = difference(results, mine, theirs, column)
                cells += [shown_estimate(e, REWARDS) for e in (*means, lead)]
            rows.append((where or "standard", " / ".join(reversed(both)), *cells))
    what = [f"{when}: {which}" for when in ("end", "area") for which in ("first", "second", "lead")]
    return Table(("world", "first / second", *what), rows)


def _in_world(label: str, where: str) -> str:
    """What a variant is called where it is run in another world."""
    return f"{label} elsewhere, {where}" if where else label


def add_standard_world(found: Found, results: Results) -> None:
    """Who ends where in the standard world, and how much runs of three skills differ."""
    for column in SHOWN:
        means = {group.label: mean_of(group, column).value for group in results.groups}
        order = sorted(means, key=lambda label: -means[label])
        found.texts[f"order: {column}"] = ", ".join(
            f"`{label}` {shown_number(means[label], REWARDS)}" for label in order
        )
    ends = results.group("hierarchical_3").values("final_reward")
    sd = statistics.stdev(ends) if len(ends) > 1 else math.nan
    spread = {"sd": sd, "lowest": min(ends), "highest": max(ends)}
    found.texts["three skills: runs"] = str(len(ends))
    for key, value in spread.items():
        found.texts[f"three skills: {key}"] = shown_number(value, REWARDS)


def add_learners(found: Found, placed: thesis.Placed) -> None:
    """The thesis's four learners in its worlds."""
    lines = [
        _row(f"{world}: {learner}", Group(learner, learner, {}, [*placed[world, learner]]))
        for world in thesis.WORLDS
        for learner in thesis.LEARNER_TITLES
        if (world, learner) in placed
    ]
    header = ("world: learner", "runs", *SHOWN.values(), "M steps to 70")
    found.tables["learners"] = Table(header, lines)
