"""Learners in several worlds, on paper: their marks, and the numbers beside them."""

import csv
import io
import math
from typing import Any

from app.analysis.estimates import Estimate
from app.charts.paper.drawing import drawn
from app.charts.paper.standings import standings_figure
from app.charts.standings import Standing, Standings

GONE = Estimate(math.nan, math.nan, math.nan, 0)
CHART = Standings(
    ("standard", "size 60"),
    {
        "area": [
            Standing("feudal", [Estimate(70, 65, 75, 9), Estimate(85, 84, 86, 9)], is_new=True),
            Standing("timed", [Estimate(55, 54, 56, 9), GONE]),
        ]
    },
    against="timed",
)


def axes_of(chart: Standings) -> Any:
    (axes,) = standings_figure(chart, "small print").axes
    return axes


def test_each_learner_has_a_mark_and_its_interval_in_each_world() -> None:
    axes = axes_of(CHART)
    lines = {(float(x), float(y)) for line in axes.lines for x, y in [*line.get_xydata()]}
    assert {(70.0, 0.0), (55.0, 1.0)} < lines
    (other,) = [y for x, y in lines if x == 85.0]
    assert 0 < abs(other) < 0.5, "in the same row, and apart"
    assert [text.get_text() for text in axes.get_yticklabels()] == ["feudal", "timed"]
    filled = {
        float(line.get_xdata()[0]): line.get_markerfacecolor()
        for line in axes.lines
        if len(line.get_xdata()) == 1
    }
    assert filled[55.0] == "white"
    assert filled[70.0] != "white"


def test_a_line_is_where_the_one_is_that_the_others_are_set_against() -> None:
    axes = axes_of(CHART)
    dashed = [line for line in axes.lines if line.is_dashed()]
    assert [[*map(float, line.get_xdata())] for line in dashed] == [[55.0, 55.0]]
    bare = axes_of(CHART._replace(against=""))
    assert not [line for line in bare.lines if line.is_dashed()]


def test_the_numbers_are_all_estimates_world_by_world() -> None:
    rows = [*csv.DictReader(io.StringIO(drawn("s", CHART, "").csv))]
    named = [(row["row"], row["world"], row["value"]) for row in rows]
    assert named[:3] == [
        ("feudal", "standard", "70"),
        ("feudal", "size 60", "85"),
        ("timed", "standard", "55"),
    ]
    assert {row["quantity"] for row in rows} == {"area"}
