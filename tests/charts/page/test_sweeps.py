"""Cells and points of what was swept have their values, and choose their variants."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.charts.model import Plane, Points
from app.charts.page.plane import plane_html
from app.charts.page.points import points_html
from app.charts.page.svg import Frame
from app.charts.view import View
from app.metrics import FINAL_REWARD
from app.results.gather import PlacedRun
from app.words.numbers import shown_number
from tests.support.charts import chart_of, luminance, points_of
from tests.support.runs import ONE_SETTING, PLANE, Shown, experiment_of, fact


def plane_of(runs: Sequence[PlacedRun], chosen: int | None = None) -> tuple[Plane, Frame]:
    chart, frame = chart_of(experiment_of(PLANE), runs, View("plane", variant=chosen))
    assert isinstance(chart, Plane)
    return chart, frame


def plane_shown(runs: Sequence[PlacedRun], chosen: int | None = None) -> Shown:
    return Shown(plane_html(*plane_of(runs, chosen)))


def test_every_cell_of_a_plane_has_its_value_and_chooses_its_variant() -> None:
    experiment = experiment_of(PLANE)
    runs = [fact(place, seed, 10.0 * place + seed) for place in range(12) for seed in range(2)]
    shown = plane_shown(runs, chosen=4)
    links = shown.links("variant")
    assert set(links) == {str(place) for place in range(12)}
    corners = {}
    for place, variant in enumerate(experiment.variants):
        link = links[str(place)]
        (text,) = link.iter("text")
        assert text.text == shown_number(10.0 * place + 0.5, ".1f")
        (title,) = link.iter("title")
        assert title.text is not None
        assert title.text.startswith(f"{variant.label}: ")
        assert title.text.endswith("n = 2")
        (cell,) = link.iter("path")
        setting = variant.overrides["learner.alpha"], variant.overrides["learner.gamma"]
        corners[setting] = points_of(cell.get("d", ""))[0]
        ink, ground = luminance(f"#{3 * text.get('fill', '')[1:3]}"), luminance(cell.get("fill"))
        assert abs(math.log((ink + 0.05) / (ground + 0.05))) > math.log(4.5)
    across = [corners[alpha, 0.5][0] for alpha in (0.1, 0.5, 0.9)]
    up = [corners[0.1, gamma][1] for gamma in (0.5, 0.6, 0.8, 0.9)]
    assert across == sorted(across)
    assert up == sorted(up, reverse=True)


def test_the_axes_of_a_plane_name_settings_and_values() -> None:
    shown = plane_shown([fact(0, 0, 1.0)])
    for axis, names in (("x", ["0.1", "0.5", "0.9"]), ("y", ["0.5", "0.6", "0.8", "0.9"])):
        ticks = shown.one("g", class_=f"{axis}-ticks")
        assert [text.text for text in ticks.iter("text")] == names
    assert "learner.alpha" in shown.text
    assert "learner.gamma" in shown.text
    assert FINAL_REWARD.label in shown.text


def test_cells_without_a_run_are_empty_but_can_be_chosen() -> None:
    shown = plane_shown([fact(0, 0, 1.0), fact(1, 0, 2.0)])
    assert len(shown.links("variant")) == 12
    assert len(shown.all("path", class_="empty")) == 10
    assert shown.text.count("no run yet") == 10


def test_a_plane_says_of_how_many_runs_its_cells_are() -> None:
    one = plane_shown([fact(0, 0, 1.0), fact(1, 0, 2.0)]).text
    assert "Each cell is one run; a click chooses it." in one
    two = [fact(0, 0, 1.0), fact(0, 1, 1.0), fact(1, 0, 2.0)]
    assert "Each cell is the mean of 1 to 2 runs" in plane_shown(two).text
    assert "Each cell is the mean of 2 runs" in plane_shown(two[:2]).text


def test_a_plane_with_a_hole_has_a_cell_there_that_is_no_link() -> None:
    chart, frame = plane_of([fact(k, 0, k) for k in range(12)])
    choices = {at: choice for at, choice in chart.choices.items() if choice.place != 3}
    shown = Shown(plane_html(chart._replace(choices=choices), frame))
    assert set(shown.links("variant")) == {str(place) for place in range(12) if place != 3}
    assert len(shown.all("path", class_="empty")) == 1


def line_shown(text: str, runs: Sequence[PlacedRun], chosen: int | None = None) -> Shown:
    chart, frame = chart_of(experiment_of(text), runs, View("plane", variant=chosen))
    assert isinstance(chart, Points)
    return Shown(points_html(chart, frame))


def test_points_of_a_sweep_lie_at_their_value_and_mean_with_intervals() -> None:
    runs = [fact(place, seed, 20 + 9 * place + seed) for place in range(4) for seed in range(3)]
    shown = line_shown(ONE_SETTING, runs, chosen=1)
    x, y, links = shown.value_at("x"), shown.value_at("y"), shown.links("variant")
    assert list(links) == ["0", "1", "2", "3"]
    for place, gamma in enumerate((0.5, 0.6, 0.8, 0.9)):
        (dot,) = links[str(place)].iter("circle")
        at = x(float(dot.get("cx", ""))), y(float(dot.get("cy", "")))
        assert at == pytest.approx((gamma, 21 + 9 * place), abs=0.2)
    assert len(shown.all("path", class_="interval")) == 4


def test_ratios_are_swept_on_a_scale_of_ratios() -> None:
    text = "presets: [timed]\ngrid: {schedule.skills.avoid.at: [20, 40, 80, 160, 320]}"
    links = line_shown(text, [fact(k, 0, k) for k in range(5)]).links("variant")
    dots = [next(links[str(k)].iter("circle")) for k in range(5)]
    gaps = np.diff([float(dot.get("cx", "")) for dot in dots])
    assert np.allclose(gaps, gaps[0], atol=0.2)


def test_words_are_swept_side_by_side_and_what_was_not_run_is_an_empty_dot() -> None:
    both = "{learner.alpha: [0.1, 0.2, 0.3], learner.gamma: [0.9, 0.5, 0.6]}"
    text = f"presets: [timed]\nlinked: [{both}]"
    shown = line_shown(text, [fact(0, 0, 1.0), fact(2, 0, 3.0)])
    dots = [dot.get("fill") for dot in shown.all("circle")]
    assert len(dots) == 3
    assert dots[1] == "transparent"
    assert len(list(shown.one("g", class_="x-ticks").iter("text"))) == 3


@given(st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=6))
def test_any_values_can_be_drawn(values: Sequence[float]) -> None:
    runs = [fact(k % 4, k, value) for k, value in enumerate(values)]
    assert len(line_shown(ONE_SETTING, runs).links("variant")) == 4
