"""Charts as data: what they show and the numbers that stand in the files beside them.

A chart is built once, of live results (:mod:`app.charts.live`) or of those that a report reads, and
then drawn: by matplotlib on paper (:mod:`app.charts.paper`), and as HTML whose parts are links on
the page (:mod:`app.charts.page`).

There are two ways to draw because one was tried and does not hold. Matplotlib can draw what the
page needs: links, hints under the pointer, and colours that follow the theme. But each browser has
links of its own, the page draws anew each time that runs are over, and on a core of 2.6 GHz four
curves took matplotlib 92 ms instead of 0.8 (34 kB of SVG instead of 11), 240 dots 82 ms instead of
2.2, and a plane of 256 cells 360 ms instead of 3.5 (171 kB instead of 69). In a class of thirty
pages that is more than all of a core, and all of it holds the interpreter.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from app.analysis.axles import Axle
from app.analysis.effects import Analysis
from app.analysis.estimates import Axis, Band, Estimate
from app.analysis.passages import Arrivals
from app.analysis.sweeps import Place
from app.charts.standings import Standings
from app.charts.styles import Style
from learners.measures import FoldedValue

Rows = list[Sequence[Any]]
"""Numbers below the names of their columns."""

AXIS_UNITS: Final[Mapping[Axis, tuple[float, str]]] = {
    "steps": (1e-6, "simulation steps (millions)"),
    "trials": (1e-3, "trials (thousands)"),
}
"""What steps or trials are multiplied by to be drawn, and what an axis of them is called."""
NOTHING: Final = Estimate(math.nan, math.nan, math.nan, 0)
"""Of no run."""


# --- Learning curves -----------------------------------------------------------------------------


class Mark(NamedTuple):
    """A moment that the axis shows: the introduction of a skill."""

    at: float
    label: str


class Greedy(NamedTuple):
    """A curve of greedy reward, averaged over runs."""

    at: np.ndarray
    """(point,) float64: steps or trials."""
    reward: np.ndarray
    """(point,) float64: mean per hunt."""


class Line(NamedTuple):
    """A curve with its name."""

    label: str
    band: Band
    style: Style
    n: int
    """Runs it began with."""
    marks: Sequence[Mark] = ()
    place: int = 0
    """Of its variant in the experiment, which a click chooses."""
    greedy: Greedy | None = None
    """If it was measured on the way."""

    @property
    def n_whole(self) -> int:
        """Windows from the first on in which no run is missing.

        The runs that go on longest may not be typical: what they alone say is drawn faintly.
        """
        fewer = np.flatnonzero(self.band.n < self.n)
        return int(fewer[0]) if fewer.size else self.band.n.size


def clear_marks(lines: Iterable[Line]) -> Sequence[Mark]:
    """Marks of lines; none where theirs differ, as it could not be seen which are whose."""
    each = {tuple(sorted(line.marks)) for line in lines if line.marks}
    return each.pop() if len(each) == 1 else ()


def with_clear_marks(lines: Sequence[Line]) -> Sequence[Line]:
    """Lines without their marks where these differ."""
    return lines if clear_marks(lines) else [line._replace(marks=()) for line in lines]


class Panel(NamedTuple):
    """Curves that share their axes."""

    title: str
    lines: Sequence[Line]


class Curves(NamedTuple):
    """Reward against steps or trials: a panel for each world, all on the same scales."""

    axis: Axis
    panels: Sequence[Panel]
    ends: tuple[float, float] | None = None
    """The lowest mean reward there can be, and the highest: on the page the scale has both, so that
    it stands still while runs come in."""

    @property
    def numbers(self) -> Rows:
        """All windows of all lines, and their marks."""
        rows: Rows = [
            ["panel", "line", f"from_{self.axis}", f"to_{self.axis}", "reward", "low", "high", "n"]
        ]
        for panel in self.panels:
            for line in panel.lines:
                columns = (column.tolist() for column in line.band.columns)
                rows += [
                    [panel.title, line.label, start, end, mean, low, high, n]
                    for start, end, mean, low, high, n in zip(*columns, strict=True)
                ]
                if line.greedy is not None:
                    points = zip(line.greedy.at.tolist(), line.greedy.reward.tolist(), strict=True)
                    name = f"{line.label}: greedy"
                    rows += [[panel.title, name, at, at, reward] for at, reward in points]
                rows += [
                    [panel.title, f"{line.label}: introduction of {mark.label}", mark.at, mark.at]
                    for mark in line.marks
                ]
        return rows


def levels(places: Sequence[float], room: float) -> list[int]:
    """How high each of several names in a row stands, so that none lies on the next one.

    Args:
        places: where they begin, in order.
        room: that a name takes.
    """
    found: list[int] = []
    following, level = math.inf, 0
    for place in reversed(places):
        level = level + 1 if following - place < room else 0
        following = place
        found.insert(0, level)
    return found


# --- Arrivals ------------------------------------------------------------------------------------


class ArrivalLine(NamedTuple):
    """The share of runs that have got somewhere, with its name."""

    label: str
    arrivals: Arrivals
    style: Style


class ArrivalPanel(NamedTuple):
    """Lines on how soon the same thing was reached."""

    title: str
    lines: Sequence[ArrivalLine]


class Arriving(NamedTuple):
    """Shares of runs that have got somewhere, against steps: a panel for each thing reached.

    Lines are steps, each from the steps at which a run gets there to those of the next one, up to
    the last of which anything is known; ticks on them are runs that ended before they got there.
    """

    panels: Sequence[ArrivalPanel]

    @property
    def counts(self) -> Mapping[tuple[str, Style], str]:
        """How many runs each line is of, by its name and how it looks."""
        found: dict[tuple[str, Style], set[int]] = {}
        for panel in self.panels:
            for line in panel.lines:
                found.setdefault((line.label, line.style), set()).add(line.arrivals.n)
        return {
            name: f"n = {min(n)}" if len(n) == 1 else f"n = {min(n)}–{max(n)}"
            for name, n in found.items()
        }

    @property
    def numbers(self) -> Rows:
        """All steps of all lines, then the runs that ended before; of these there is no share."""
        rows: Rows = [["panel", "line", "steps", "share", "low", "high", "n"]]
        for panel in self.panels:
            for line in panel.lines:
                found = line.arrivals
                columns = (
                    part.tolist() for part in (found.steps, found.share, found.low, found.high)
                )
                rows += [
                    [panel.title, line.label, *numbers, found.n]
                    for numbers in zip(*columns, strict=True)
                ]
                rows += [
                    [panel.title, f"{line.label}: ended before", steps]
                    for steps in found.censored.tolist()
                ]
        return rows


# --- Dots ----------------------------------------------------------------------------------------


class RunDot(NamedTuple):
    """A run at its value."""

    value: float
    seed: int
    key: str = ""
    """Of the run, which a click opens."""

    @property
    def height(self) -> float:
        """Where it is drawn in its row, from -0.5 to 0.5, so that equal ones can be told apart.

        The same for a seed every time, and far apart for seeds in a row.
        """
        seed = self.seed
        return (9 * (seed % 3) + 3 * (seed // 3 % 3) + seed // 9 % 3) / 26 - 0.5


class Dot(NamedTuple):
    """An estimate with its name, and the runs that it is from."""

    label: str
    estimate: Estimate
    runs: Sequence[RunDot] = ()
    style: Style | None = None
    """If it has the colour of a curve."""


class Dots(NamedTuple):
    """Estimates under one another, one column for each quantity, rows shared by their order."""

    columns: Mapping[str, Sequence[Dot]]
    """The rows of each quantity, by its name with unit."""
    differences: Sequence[str] = ()
    """Quantities whose zero is marked."""

    @property
    def numbers(self) -> Rows:
        """All estimates."""
        rows: Rows = [["quantity", "row", "value", "low", "high", "n"]]
        for what, dots in self.columns.items():
            rows += [[what, dot.label, *dot.estimate] for dot in dots]
        return rows


# --- Sweeps --------------------------------------------------------------------------------------


class Choice(NamedTuple):
    """A variant of the experiment, which a click chooses."""

    place: int
    label: str


class Plane(NamedTuple):
    """Two settings swept together: a map of the plane, each cell with its value.

    Cells have equal sizes whatever their values; those without runs stay hatched.
    """

    axles: tuple[Axle, Axle]
    what: str
    """The name of the quantity."""
    cells: Mapping[Place, Estimate]
    framed: Place | None = None
    """The cell that has a frame, if any."""
    is_difference: bool = False
    """Whether cells hold how far each lies from the framed one, which is not among them."""
    choices: Mapping[Place, Choice] = {}

    @property
    def numbers(self) -> Rows:
        """All cells."""
        across, up = self.axles
        rows: Rows = [[across.key, up.key, self.what, "low", "high", "n"]]
        rows += [
            [across.values[i], up.values[j], *cell] for (i, j), cell in sorted(self.cells.items())
        ]
        return rows


class Series(NamedTuple):
    """Estimates along a swept setting; None where nothing was run."""

    label: str
    estimates: Sequence[Estimate | None]
    choices: Sequence[Choice | None] = ()


class Points(NamedTuple):
    """One setting swept: points with intervals."""

    axle: Axle
    what: str
    """The name of the quantity."""
    series: Sequence[Series]

    @property
    def numbers(self) -> Rows:
        """All points."""
        rows: Rows = [["line", self.axle.key, self.what, "low", "high", "n"]]
        for label, estimates, _ in self.series:
            pairs = zip(self.axle.values, estimates, strict=True)
            rows += [[label, value, *found] for value, found in pairs if found is not None]
        return rows


class Effect(NamedTuple):
    """A setting, and an estimate at each of its values."""

    axle: Axle
    estimates: Sequence[Estimate]


class Effects(NamedTuple):
    """Several settings, a small plot for each: points with intervals, all on one scale."""

    what: str
    """The name of the quantity."""
    effects: Sequence[Effect]

    @property
    def numbers(self) -> Rows:
        """All points."""
        rows: Rows = [["setting", "value", self.what, "low", "high", "n"]]
        for axle, estimates in self.effects:
            pairs = zip(axle.values, estimates, strict=True)
            rows += [[axle.key, value, *found] for value, found in pairs]
        return rows


class Trends(NamedTuple):
    """What each setting of a design does: a small plot for each, all on one scale.

    Dots are variants; the line is what the setting does by itself, with its band.
    """

    what: str
    """The name of the quantity."""
    analysis: Analysis

    @property
    def numbers(self) -> Rows:
        """All points of the lines, then the values of all variants once for each setting."""
        rows: Rows = [["setting", "shown", "value", self.what, "low", "high"]]
        for axle, values, *columns in self.analysis.responses:
            points = zip(values, *(column.tolist() for column in columns), strict=True)
            rows += [[axle.key, "line", *point] for point in points]
        for axle, column in self.analysis.factors:
            pairs = zip(column, self.analysis.values.tolist(), strict=True)
            rows += [[axle.key, "variant", *pair] for pair in pairs]
        return rows


class Shares(NamedTuple):
    """How much settings of a design account for: each by itself, and each pair beyond that."""

    what: str
    """The name of the quantity."""
    analysis: Analysis

    @property
    def names(self) -> Sequence[str]:
        """The settings."""
        return [factor.axle.label for factor in self.analysis.factors]

    @property
    def numbers(self) -> Rows:
        """All shares."""
        rows: Rows = [["setting", "with", f"share of the variance of {self.what}", "p"]]
        names = self.names
        rows += [[name, "", *share] for name, share in zip(names, self.analysis.alone, strict=True)]
        for (first, second), share in self.analysis.together.items():
            rows.append([names[first], names[second], *share])
        return rows


# --- Maps of value -------------------------------------------------------------------------------


class ValueMap(NamedTuple):
    """How far value had spread at a moment, averaged over runs, in the prey's own frame."""

    title: str
    value: FoldedValue
    n: int
    """Runs that it is over."""


class ValueMaps(NamedTuple):
    """Maps of value beside one another, the prey in the middle of each and facing right."""

    maps: Sequence[ValueMap]
    """All with the same rings and directions."""
    edges: np.ndarray
    """(ring,) float64: outer edge of each ring, in cells."""
    vision: float
    """Radius of the visual field, in cells."""

    @property
    def numbers(self) -> Rows:
        """All sectors of all maps."""
        inner = [0.0, *self.edges[:-1].tolist()]
        rows: Rows = [
            ["moment", "from_cells", "to_cells", "degrees_from_ahead", "share", "steps", "n"]
        ]
        for title, (distance, share), n in self.maps:
            n_rings, n_directions = share.shape
            rows += [
                [
                    title,
                    inner[ring],
                    float(self.edges[ring]),
                    360 * direction / n_directions,
                    float(share[ring, direction]),
                    float(distance[ring, direction]),
                    n,
                ]
                for ring in range(n_rings)
                for direction in range(n_directions)
            ]
        return rows


# --- Schedules -----------------------------------------------------------------------------------


class Lane(NamedTuple):
    """What is planned for a skill of a variant; all in trials."""

    variant: str
    skill: str
    joins: int
    """Beyond the last trial if it never does, or if a rule says when."""
    freeze: int
    """For how long the selection does not learn then."""
    explored: Sequence[tuple[int, int, float]]
    """First trial, the one after the last, and the chance of each step that the skill is taken."""
    trials: int
    """Of the run."""
    rule: str
    """By which it joins, in words; empty if none does."""

    @property
    def words(self) -> str:
        """What is planned, in short."""
        joins = f"at {self.joins:,}" if self.joins else "from the start"
        joins = self.rule or joins
        frozen = [f"frozen {self.freeze:,}"] if self.freeze else []
        explored = [
            f"explored {until - first:,} at {chance:.0%}"
            + (f" from {first:,}" if first != self.joins else "")
            for first, until, chance in self.explored
        ]
        return ", ".join([joins, *frozen, *explored])


class Schedules(NamedTuple):
    """Schedules of variants below one another, a lane for each skill, against trials."""

    lanes: Sequence[Lane]
    """Those of a variant together."""

    @property
    def numbers(self) -> Rows:
        """All that is planned."""
        rows: Rows = [["variant", "skill", "what", "from_trial", "to_trial", "probability"]]
        for lane in self.lanes:
            name = lane.variant, lane.skill
            if lane.rule:
                rows.append([*name, lane.words, "", "", ""])
                continue
            rows.append([*name, "can be chosen", lane.joins, lane.trials])
            if lane.freeze:
                rows.append([*name, "selection frozen", lane.joins, lane.joins + lane.freeze])
            rows += [[*name, "explored", *stretch] for stretch in lane.explored]
        return rows


Chart = (Curves | Arriving | Dots | Standings | Plane | Points | Effects | Trends | Shares) | (
    ValueMaps | Schedules
)
