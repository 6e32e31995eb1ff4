"""Every run is a dot at its value that opens it, and every variant has its mean."""

import re
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.charts.model import Dots
from app.charts.page.runs import runs_html
from app.charts.view import View
from app.charts.wording import PADDED
from app.documents.experiments import Experiment
from app.results.gather import PlacedRun
from app.words.numbers import shared_form, shown_number
from tests.support.charts import chart_of, estimates_of, points_of
from tests.support.runs import (
    HOSTILE,
    NOTHING,
    ONE_SETTING,
    THESIS,
    Shown,
    called,
    experiment_of,
    fact,
    reward,
    some_runs,
)


def runs_shown(
    experiment: Experiment, runs: Sequence[PlacedRun], chosen: int | None = None
) -> Shown:
    chart, frame = chart_of(experiment, runs, View("runs", variant=chosen))
    assert isinstance(chart, Dots)
    return Shown(runs_html(chart, frame))


def test_every_run_is_a_dot_at_its_value_that_opens_it() -> None:
    experiment = experiment_of(THESIS)
    runs = some_runs(experiment, 5)
    shown = runs_shown(experiment, runs)
    x, links = shown.value_at("x"), shown.links("open")
    assert set(links) == {run.key for _, run in runs}
    for place, run in runs:
        link, value = links[run.key], reward((place, run))
        (dot,) = link.iter("circle")
        assert x(float(dot.get("cx", ""))) == pytest.approx(value, abs=0.3)
        (title,) = link.iter("title")
        label = experiment.variants[place].label
        said = shown_number(value, PADDED)
        assert title.text == (f"{label}, seed {run.seed}: {said} (a click opens this run)")


def test_a_row_has_mean_and_interval_and_a_label_that_chooses() -> None:
    experiment = experiment_of(THESIS)
    runs = some_runs(experiment, 4)
    shown = runs_shown(experiment, runs)
    x, links = shown.value_at("x"), shown.links("variant")
    assert list(links) == ["0", "1", "2", "3"]
    estimates = estimates_of(experiment, runs)
    # All with as many decimals, so that a column can be read downwards.
    form = shared_form(number for estimate in estimates for number in estimate[:3])
    for place, estimate in enumerate(estimates):
        assert experiment.variants[place].label in " ".join(links[str(place)].itertext())
        row = shown.one("g", class_="row", data_variant=str(place))
        (mean,) = shown.all("path", row, class_="mean")
        assert x(points_of(mean.get("d"))[0][0]) == pytest.approx(estimate.value, abs=0.3)
        (interval,) = shown.all("path", row, class_="interval")
        low, high = map(float, re.findall(r"M(\S+) \S+H(\S+)", interval.get("d"))[0])
        assert (x(low), x(high)) == pytest.approx((estimate.low, estimate.high), abs=0.3)
        text = (shown_number(number, form) for number in estimate[:3])
        assert "{} [{}, {}]".format(*text) in shown.text


def test_dots_lie_in_their_rows_and_the_same_way_each_time() -> None:
    experiment = experiment_of(THESIS)
    runs = [fact(place, seed, 50.0) for place in range(4) for seed in range(20)]
    shown, again = runs_shown(experiment, runs), runs_shown(experiment, runs[::-1])
    heights = {}
    for place, run in runs:
        (dot,) = shown.links("open")[run.key].iter("circle")
        (twin,) = again.links("open")[run.key].iter("circle")
        assert dot.get("cy") == twin.get("cy")
        heights.setdefault(place, set()).add(float(dot.get("cy", "")))
    assert all(len(found) > 10 for found in heights.values())
    assert all(max(heights[k]) < min(heights[k + 1]) for k in range(3))


def test_failed_runs_are_counted_in_words() -> None:
    experiment = experiment_of(THESIS)
    runs = [fact(0, 0, 1.0), fact(0, 1, 0, "it broke"), fact(1, 0, 0, "so did it")]
    shown = runs_shown(experiment, [*runs, fact(2, 0, NOTHING)])
    assert "2 runs failed." in shown.text
    assert "1 run without a value." in shown.text
    assert list(shown.links("open")) == [runs[0][1].key]


def dots_in(shown: Shown) -> int:
    """Dots that are no links."""
    return sum(path.get("d").count("M") for path in shown.all("path", class_="dots"))


def test_of_many_runs_only_the_chosen_ones_are_links() -> None:
    experiment = experiment_of(THESIS)
    runs = some_runs(experiment, 100)
    shown = runs_shown(experiment, runs)
    assert not shown.links("open")
    assert dots_in(shown) == 400
    chosen = runs_shown(experiment, runs, chosen=1)
    assert set(chosen.links("open")) == {run.key for place, run in runs if place == 1}
    assert dots_in(chosen) == 300


def test_too_many_runs_are_means_alone_and_it_says_so() -> None:
    experiment = experiment_of(THESIS)
    shown = runs_shown(experiment, some_runs(experiment, 400))
    assert dots_in(shown) == 0
    assert "1,600 runs are too many to draw one by one" in shown.text
    assert len(shown.all("path", class_="mean")) == 4


def test_many_variants_are_columns_that_choose() -> None:
    experiment = called([f"number {k}" for k in range(60)])
    runs = some_runs(experiment, 3)
    shown = runs_shown(experiment, runs, chosen=5)
    links = shown.links("variant")
    assert list(links) == [str(place) for place in range(60)]
    assert not shown.links("open")
    y = shown.value_at("y")
    named = {
        text.text: float(text.get("x", ""))
        for text in shown.one("g", class_="x-ticks").iter("text")
    }
    assert len(named) > 3
    for place, link in links.items():
        (zone,) = link.iter("path")
        left, right = re.findall(r"M(\S+) \S+H([\d.]+)V", zone.get("d", ""))[0]
        assert all(
            (float(left) < at < float(right)) == (name == f"number {place}")
            for name, at in named.items()
        )
        (title,) = link.iter("title")
        assert title.text is not None
        assert title.text.startswith(f"number {place}: ")
    dots = shown.one("path", class_="dots").get("d", "")
    found = sorted(y(b) for _, b in points_of(dots))
    assert np.allclose(found, sorted(map(reward, runs)), atol=0.4)


def test_columns_whose_names_are_long_are_numbered_and_say_so() -> None:
    experiment = called([f"a name that is long, number {k}" for k in range(60)])
    shown = runs_shown(experiment, some_runs(experiment, 2))
    assert "number of the variant in the experiment; its name is under the pointer" in shown.text
    x = shown.value_at("x")
    for place, link in shown.links("variant").items():
        (zone,) = link.iter("path")
        left, right = re.findall(r"M(\S+) \S+H([\d.]+)V", zone.get("d", ""))[0]
        assert x(float(left)) < int(place) + 1 < x(float(right))
        assert f"{int(place) + 1}: a name" in " ".join(link.itertext())


@pytest.mark.parametrize("n_variants", [4, 60])
def test_the_dot_of_a_single_run_is_not_hidden_by_its_mean(n_variants: int) -> None:
    experiment = called([f"number {k}" for k in range(n_variants)])
    assert not runs_shown(experiment, some_runs(experiment, 1)).all("path", class_="mean")
    assert runs_shown(experiment, some_runs(experiment, 2)).all("path", class_="mean")


def test_columns_too_narrow_to_click_stand_for_their_highest() -> None:
    experiment = experiment_of(
        "presets: [timed]\ngrid: {learner.alpha: {start: 0.001, stop: 0.45, step: 0.001}}"
    )
    runs = some_runs(experiment, 1)
    links = runs_shown(experiment, runs).links("variant")
    assert len(links) == 150
    values = {run[0]: reward(run) for run in runs}
    wanted = {max(range(k, k + 3), key=lambda place: values[place]) for k in range(0, 450, 3)}
    assert set(map(int, links)) == wanted


def test_columns_of_too_many_runs_are_means_alone_and_say_so() -> None:
    experiment = called([f"number {k}" for k in range(60)])
    shown = runs_shown(experiment, some_runs(experiment, 30))
    assert dots_in(shown) == 0
    assert "1,800 runs are too many to draw one by one" in shown.text
    assert len(points_of(shown.one("path", class_="mean").get("d", ""))) == 60


def test_single_runs_have_no_interval() -> None:
    experiment = experiment_of(THESIS)
    text = runs_shown(experiment, some_runs(experiment, 1)).text
    assert "interval" not in text.replace("One run has no interval.", "")


def test_hostile_labels_are_only_texts() -> None:
    runs = [fact(place, 0, 10.0 * place) for place in range(3)]
    shown = runs_shown(called(HOSTILE), runs)
    assert not shown.all("script")
    assert set(shown.links("variant")) == {"0", "1", "2"}
    assert HOSTILE[0] in shown.text
    assert HOSTILE[1] in shown.text
    (title,) = shown.links("open")["key-0-0"].iter("title")
    assert title.text is not None
    assert HOSTILE[0] in title.text


@given(st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=6))
def test_any_values_can_be_drawn(values: Sequence[float]) -> None:
    runs = [fact(k % 4, k, value) for k, value in enumerate(values)]
    assert len(runs_shown(experiment_of(ONE_SETTING), runs).links("open")) == len(values)
