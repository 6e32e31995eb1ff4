"""The chart of runs that have got somewhere: its steps, its ends, and its numbers."""

import math

import numpy as np
import pytest

from app.analysis.passages import Passage, arrivals
from app.charts.model import ArrivalLine, ArrivalPanel, Arriving
from app.charts.paper.arrivals import arrivals_figure
from app.charts.paper.drawing import drawn
from app.charts.styles import style_of

SOME = arrivals([Passage(1e6, False), Passage(2e6, True), Passage(3e6, False), Passage(4e6, True)])
NONE = arrivals([Passage(5e6, True)])


def chart(*labels: str) -> Arriving:
    some = ArrivalLine("some", SOME, style_of(0))
    none = ArrivalLine("none", NONE, style_of(1))
    return Arriving([ArrivalPanel(label, [some, none]) for label in labels])


def test_lines_are_steps_from_none_at_the_start_to_the_last_that_is_known() -> None:
    (axes,) = arrivals_figure(chart("there"), "small print").axes
    steps = [line for line in axes.lines if line.get_drawstyle() == "steps-post"]
    some, none = (np.asarray(line.get_xydata()) for line in steps)
    # One of four; then one of the two that are left has half of the rest.
    assert some == pytest.approx(np.array([[0, 0], [1, 0.25], [3, 0.625], [4, 0.625]]))
    assert none == pytest.approx(np.array([[0, 0], [5, 0]]))
    assert axes.get_xlim()[1] > 5


def test_runs_that_ended_before_are_ticks_on_their_line() -> None:
    (axes,) = arrivals_figure(chart("there"), "small print").axes
    ticks = [line for line in axes.lines if line.get_marker() == "|"]
    some, none = (np.asarray(line.get_xydata()) for line in ticks)
    assert some == pytest.approx(np.array([[2, 0.25], [4, 0.625]]))
    assert none == pytest.approx(np.array([[5, 0]]))


def test_the_numbers_are_those_of_the_lines() -> None:
    header, *rows = chart("there").numbers
    assert header == ["panel", "line", "steps", "share", "low", "high", "n"]
    assert [row[1:4] for row in rows[:2]] == [["some", 1e6, 0.25], ["some", 3e6, 0.625]]
    assert all(low < share < high for *_, share, low, high, _ in rows[:2])
    assert [row[1:] for row in rows[2:]] == [
        ["some: ended before", 2e6],
        ["some: ended before", 4e6],
        ["none: ended before", 5e6],
    ]


@pytest.mark.filterwarnings("error")
def test_each_thing_that_is_reached_has_a_panel() -> None:
    names = ["to $50", "to 70", "to 90"]
    drawing = drawn("a", chart(*names), "small print")
    assert all(name in drawing.svg for name in names)
    figure = arrivals_figure(chart(*names), "small print")
    assert [axes.get_visible() for axes in figure.axes] == [True, True, True, False]
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["some (n = 4)", "none (n = 1)"]


def test_a_line_of_runs_that_all_got_there_ends_with_the_last_of_them() -> None:
    every = arrivals([Passage(1e6, False), Passage(2e6, False)])
    panel = ArrivalPanel("there", [ArrivalLine("every", every, style_of(0))])
    (axes,) = arrivals_figure(Arriving([panel]), "small print").axes
    (line,) = (line for line in axes.lines if line.get_drawstyle() == "steps-post")
    assert np.asarray(line.get_xydata())[-1] == pytest.approx([2, 1])
    assert math.isnan(every.low[-1])
