"""A section of a report on learners that were run in the same worlds, each in all of them."""

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

from app.analysis import estimates
from app.analysis.estimates import Estimate, bootstrap_rng
from app.charts.paper.drawing import drawn
from app.charts.standings import Standing, Standings
from app.charts.wording import shown_estimate
from app.metrics import Metric
from app.report.document import Page, table
from app.report.parts import GREED, bars_note
from app.results import thesis
from app.results.read import Group, measured
from app.util.html import element, joined

_SAYS: Final[Mapping[str, str]] = {
    "horizon_area": "speed",
    "horizon_reward": "end, as it learns",
    "horizon_greedy": "end, by greed",
}
COLUMNS: Final = (*_SAYS,)
"""What learners are set against one another by; in the order of the first are their rows."""
AGAINST: Final = "timed"
"""The learner whose values are marked."""
REWARDS: Final = ".1f"
_FEWEST_LEARNERS, _FEWEST_WORLDS = 3, 2


class Field(NamedTuple):
    """Learners in worlds."""

    worlds: Sequence[str]
    """The standard one first, if there is one."""
    groups: Mapping[tuple[str, str], Group]
    """By preset and world."""

    @property
    def presets(self) -> Sequence[str]:
        """The learners, in their order."""
        return [*dict.fromkeys(preset for preset, _ in self.groups)]

    def mean(self, preset: str, world: str, column: str) -> Estimate:
        """Over the runs of a learner in a world."""
        return estimates.mean(self.groups[preset, world].values(column), bootstrap_rng())


def field_of(groups: Sequence[Group]) -> Field | None:
    """The learners and worlds that variants are made of; None if they are not each of these once.

    A world is what follows the preset in a variant's name. What is set there is of the world, but
    for one setting at most of a learner that has to follow it.
    """
    found: dict[tuple[str, str], Group] = {}
    for group in groups:
        world = group.label.removeprefix(group.preset).removeprefix(", ")
        is_of_world = {key: key.startswith("world.") for key in group.overrides}
        is_a_world = any(is_of_world.values()) or not is_of_world
        n_others = sum(not of_world for of_world in is_of_world.values())
        if (group.preset, world) in found or not is_a_world or n_others > 1:
            return None
        found[group.preset, world] = group
    presets, worlds = ([*dict.fromkeys(part)] for part in zip(*found, strict=True))
    if len(presets) < _FEWEST_LEARNERS or len(worlds) < _FEWEST_WORLDS:
        return None
    return Field(worlds, found) if len(found) == len(presets) * len(worlds) else None


def write_standings(page: Page, field: Field, metrics: Sequence[Metric]) -> None:
    """Write the section.

    Args:
        page: to write on.
        field: learners and worlds.
        metrics: all that there are, with their words.
    """
    page.tell("setting learners against one another")
    by_column = {metric.column: metric for metric in metrics}
    groups = [*field.groups.values()]
    shown = [by_column[name] for name in COLUMNS if measured(groups, name)]
    if not shown:
        return
    order = in_order(field, shown[0].column)
    columns = {
        f"{_SAYS[metric.column]}: {metric.title}": [
            Standing(
                preset,
                [field.mean(preset, world, metric.column) for world in field.worlds],
                is_new=preset not in thesis.LEARNER_TITLES,
            )
            for preset in order
        ]
        for metric in shown
    }
    every = (e for rows in columns.values() for row in rows for e in row.estimates)
    marked = f" The dashed line is {AGAINST} there." if AGAINST in order else ""
    small = page.small_print(
        f"Mean reward over n runs (seeds). {bars_note(every)} Large: the world {field.worlds[0]};"
        f" empty if the learner is one of the thesis's four.{marked} Rows are in the order of the"
        f" first column there. {GREED}"
    )
    against = AGAINST if AGAINST in order else ""
    chart = Standings(field.worlds, columns, against)
    caption = "Learners against one another, in each world"
    tables = [
        joined([element("h3", metric.label), table(*_table(field, order, metric.column))])
        for metric in shown
    ]
    drawing = drawn("standings", chart, small)
    page.say("Learners and worlds", page.picture("standings", caption, drawing), *tables)


def in_order(field: Field, column: str) -> Sequence[str]:
    """The learners by what they come to in the first world, the highest first."""
    first = field.worlds[0]
    return sorted(field.presets, key=lambda preset: -field.mean(preset, first, column).value)


def _table(
    field: Field, order: Sequence[str], column: str
) -> tuple[Sequence[str], Sequence[Sequence[str]]]:
    rows = [
        (preset, *(shown_estimate(field.mean(preset, w, column), REWARDS) for w in field.worlds))
        for preset in order
    ]
    return ("learner", *field.worlds), rows
