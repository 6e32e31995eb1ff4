"""Curves lie where their numbers say, with their bands and marks, and their names are links."""

from collections.abc import Sequence
from xml.etree import ElementTree

import numpy as np

from app.analysis.estimates import Band
from app.charts.model import Curves
from app.charts.page.curves import curves_html
from app.charts.view import View
from app.documents.experiments import Experiment
from app.metrics.course import GreedyCurve
from app.results.gather import Curve, Moment
from tests.support.charts import chart_of, points_of
from tests.support.runs import HOSTILE, NOTHING, THESIS, Shown, called, experiment_of


def curve_of(
    variant: int,
    mean: Sequence[float],
    n: Sequence[int] | int = 3,
    joined: Sequence[Moment] = (),
    arm: float = 5.0,
) -> Curve:
    """A curve with windows of a million steps."""
    start = np.arange(len(mean), dtype=np.int64) * 1_000_000
    values = np.asarray(mean, np.float64)
    there = np.broadcast_to(np.asarray(n, np.int64), values.shape)
    band = Band(start, start + 1_000_000, values, values - arm, values + arm, there)
    return Curve(variant, int(there.max(initial=0)), band, joined)


def curves_shown(
    experiment: Experiment, found: Sequence[Curve], chosen: int | None = None
) -> Shown:
    chart, frame = chart_of(experiment, [], View("curves", variant=chosen), found)
    assert isinstance(chart, Curves)
    return Shown(curves_html(chart, frame))


def lines_of(shown: Shown, variant: int) -> list[ElementTree.Element]:
    """The paths of a mean."""
    group = shown.one("g", class_="curve", data_variant=str(variant))
    return [path for path in group.iter("path") if path.get("class") != "band"]


def test_a_curve_lies_where_its_means_are_and_its_band_around_it() -> None:
    means = [-40.0, 10.0, 35.0, 80.0]
    shown = curves_shown(experiment_of(THESIS), [curve_of(2, means)])
    x, y = shown.value_at("x"), shown.value_at("y")
    (line,) = lines_of(shown, 2)
    found = [(x(a), y(b)) for a, b in points_of(line.get("d", ""))]
    assert np.allclose(found, list(zip([0.5, 1.5, 2.5, 3.5], means, strict=True)), atol=0.1)
    ribbon = points_of(shown.one("path", class_="band").get("d", ""))
    assert np.allclose(
        [y(b) for _, b in ribbon], [m + 5 for m in means] + [m - 5 for m in means[::-1]], atol=0.1
    )


def test_the_legend_names_every_curve_with_its_runs_and_links_to_it() -> None:
    experiment = experiment_of(THESIS)
    shown = curves_shown(experiment, [curve_of(place, [0, 1], place + 1) for place in range(4)])
    links = shown.links("variant")
    assert list(links) == ["0", "1", "2", "3"]
    for place, variant in enumerate(experiment.variants):
        text = " ".join(links[str(place)].itertext())
        assert variant.label in text
        assert f"{place + 1} run{'s' * (place > 0)}" in text


def test_a_gap_is_left_open_and_a_lone_point_is_seen() -> None:
    means = [1.0, 2.0, NOTHING, 4.0, NOTHING, 6.0, 7.0]
    shown = curves_shown(experiment_of(THESIS), [curve_of(0, means)])
    (line,) = lines_of(shown, 0)
    assert line.get("d", "").count("M") == 3
    assert shown.one("path", class_="band").get("d", "").count("Z") == 3


def test_a_line_is_faint_where_fewer_runs_are_left() -> None:
    shown = curves_shown(experiment_of(THESIS), [curve_of(0, [1, 2, 3, 4], [3, 3, 2, 2])])
    strong, faint = lines_of(shown, 0)
    assert float(faint.get("stroke-opacity", "")) < float(strong.get("stroke-opacity", ""))
    assert float(faint.get("stroke-width", "")) < float(strong.get("stroke-width", ""))
    assert points_of(strong.get("d", ""))[-1] == points_of(faint.get("d", ""))[0]


def test_moments_that_all_share_are_marked_and_others_are_not() -> None:
    experiment = experiment_of(THESIS)
    moments = [Moment("circle_clockwise", 12_000, 1.0e6), Moment("avoid", 14_500, 3.0e6)]
    late = [moments[0], moments[1]._replace(step=3.5e6)]
    means = [0.0] * 10
    shown = curves_shown(experiment, [curve_of(0, means), curve_of(2, means, joined=moments)])
    marks = shown.one("g", class_="joined")
    assert [text.text for text in marks.iter("text")] == ["circle clockwise", "avoid"]
    x = shown.value_at("x")
    places = [x(points_of(path.get("d", ""))[0][0]) for path in marks.iter("path")]
    assert np.allclose(places, [1.0, 3.0], atol=0.02)

    both = [curve_of(2, means, joined=moments), curve_of(3, means, joined=late)]
    assert not list(curves_shown(experiment, both).one("g", class_="joined"))
    chosen = curves_shown(experiment, both, chosen=3).one("g", class_="joined")
    assert [text.text for text in chosen.iter("text")] == ["circle clockwise", "avoid"]


def test_a_chosen_curve_stands_out_from_grey_ones_and_keeps_its_colour() -> None:
    experiment = experiment_of(THESIS)
    found = [curve_of(place, [0, 50]) for place in range(4)]
    before, after = curves_shown(experiment, found), curves_shown(experiment, found, chosen=2)
    assert lines_of(after, 2)[0].get("stroke") == lines_of(before, 2)[0].get("stroke")
    assert {lines_of(after, k)[0].get("stroke") for k in (0, 1, 3)} == {"currentColor"}
    assert len(after.all("path", class_="band")) == 1
    assert after.all("g", class_="curve")[-1].get("data-variant") == "2"


def test_reward_is_shown_on_its_whole_scale() -> None:
    y = curves_shown(experiment_of(THESIS), [curve_of(0, [10, 11])])
    names = [t.text for t in y.one("g", class_="y-ticks").iter("text")]
    assert names[0] == "\N{MINUS SIGN}50"
    assert names[-1] == "100"


def test_variants_without_a_run_have_no_curve_and_say_so() -> None:
    shown = curves_shown(experiment_of("presets: [standard_q, timed]"), [])
    assert "No curve yet" in shown.text
    assert list(shown.links("variant")) == ["0", "1"]


def test_a_sentence_says_of_single_runs_that_they_have_no_interval() -> None:
    experiment = experiment_of(THESIS)
    one = curves_shown(experiment, [curve_of(0, [1, 2], 1, arm=NOTHING)]).text
    assert "Each line is one run. One run has no interval." in one
    assert "too narrow" not in one
    some = curves_shown(experiment, [curve_of(0, [1, 2], 4)]).text
    assert "With fewer than 10 runs, intervals are too narrow." in some
    both = curves_shown(experiment, [curve_of(0, [1, 2], 4), curve_of(1, [1, 2], 1)]).text
    assert "intervals are too narrow, and of one there is none." in both


def test_curves_of_single_runs_have_no_band() -> None:
    shown = curves_shown(experiment_of(THESIS), [curve_of(0, [1, 2], 1, arm=NOTHING)])
    assert shown.one("path", class_="band").get("d") == ""


def test_hostile_labels_are_only_texts() -> None:
    shown = curves_shown(called(HOSTILE), [curve_of(place, [1, 2]) for place in range(3)])
    assert not shown.all("script")
    assert set(shown.links("variant")) == {"0", "1", "2"}
    assert HOSTILE[0] in shown.text
    assert HOSTILE[1] in shown.text


def test_a_greedy_curve_is_thin_with_dots_where_it_was_measured_and_says_what_it_is() -> None:
    greedy = [
        GreedyCurve(np.array([2, 4, 5]), np.array([500_000, 1_500_000, last]), np.array(rewards))
        for last, rewards in ((1_600_000, [10.0, 50.0, 9.0]), (1_700_000, [20.0, 70.0, 9.0]))
    ]
    found = curve_of(0, [0.0, 40.0, 60.0])._replace(greedy=greedy)
    shown = curves_shown(experiment_of(THESIS), [found, curve_of(1, [0.0, 1.0, 2.0])])
    (group,) = shown.all("g", class_="greedy")
    line, dots = list(group.iter("path"))
    places = points_of(line.get("d", ""))
    assert len(places) == dots.get("d", "").count("h0") == 3
    (thick, *_) = lines_of(shown, 0)
    assert float(line.get("stroke-width", "")) < float(thick.get("stroke-width", ""))
    # At the mean of both runs: 15 after 0.5 M steps, 60 after 1.5 M, as the thick one after 2.5 M.
    assert places[1][1] == points_of(thick.get("d", ""))[2][1]
    assert "greedy reward, in hunts without random moves" in shown.text
    assert not curves_shown(experiment_of(THESIS), [found], chosen=1).all("g", class_="greedy")
