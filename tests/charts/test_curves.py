"""Charts show every run and variant where its number says, and link each to what it is."""

import colorsys
import itertools
import math
import re
from collections.abc import Iterator, Sequence
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.analysis.estimates import Band, Estimate
from app.analysis.sweeps import Sweep, sweep_of
from app.charts import curves, parts, sweeps
from app.charts.paper import THESIS_STYLES, Style, style_of
from app.charts.parts import Context
from app.documents.experiments import Experiment
from app.metrics import FINAL_REWARD
from app.results.gather import MOST_CURVES, Curve, Moment, RunFact
from tests.support.runs import (
    HOSTILE,
    NOTHING,
    ONE_SETTING,
    PLANE,
    THESIS,
    Shown,
    address,
    called,
    experiment_of,
    fact,
    gathering_of,
    some_runs,
)

WIDTH = 684


# --- Making results, and reading what is shown -------------------------------------------------


def context_of(
    experiment: Experiment, runs: Sequence[RunFact], chosen: int | None = None
) -> Context:
    """What a chart is asked for, if these runs are over."""
    return Context(gathering_of(experiment, runs), address, WIDTH, chosen)


def estimates_of(experiment: Experiment, runs: Sequence[RunFact]) -> list[Estimate]:
    """Means with intervals of a sort."""
    found = []
    for place in range(len(experiment.variants)):
        values = [r.value for r in runs if r.variant == place and not math.isnan(r.value)]
        mean = float(np.mean(values)) if values else NOTHING
        ends = (min(values), max(values)) if len(values) > 1 else (NOTHING, NOTHING)
        found.append(Estimate(mean, *ends, len(values)))
    return found


def sweep_in(experiment: Experiment) -> Sweep:
    """What was swept in it."""
    variants = experiment.variants
    sweep = sweep_of([v.overrides for v in variants], variants[0].spec.model_dump())
    assert sweep is not None
    return sweep


def points_of(path: str) -> list[tuple[float, float]]:
    """Corners of a path of absolute lines."""
    return [(float(x), float(y)) for x, y in re.findall(r"[ML](-?[\d.]+) (-?[\d.]+)", path)]


# --- Numbers and texts ---------------------------------------------------------------------------


@given(st.floats(-1e3, 1e3), st.floats(1, 1e6), st.integers(2, 10))
def test_ticks_are_round_numbers_between_the_ends(low: float, span: float, most: int) -> None:
    found = parts.ticks(low, low + span, most)
    assert len(found) <= most + 1
    assert all(low - span * 1e-6 <= tick <= low + span * (1 + 1e-6) for tick in found)
    for a, b in itertools.pairwise(found):
        first_digit = (b - a) / 10 ** math.floor(math.log10(b - a) + 1e-6)
        assert min(abs(first_digit - digit) for digit in (1, 2, 5)) < 1e-4
        assert abs(a / (b - a) - round(a / (b - a))) < 1e-3


@given(st.text(max_size=80), st.integers(1, 60))
def test_shortened_texts_fit(text: str, characters: int) -> None:
    short = parts.shortened(text, characters)
    assert len(short) <= characters
    assert short == text or "…" in short


def test_the_values_in_a_label_outlive_its_keys() -> None:
    label = "timed, circle_clockwise.at=12000, avoid.at=14500"
    for characters in range(20, len(label)):
        short = parts.shortened(label, characters)
        assert len(short) <= characters
        assert re.search(r"=12000, .*=14500$", short), short


@pytest.mark.parametrize(
    ("value", "text"),
    [(80.0, "80.0"), (0.7, "0.700"), (100.0, "100"), (12345.6, "12,346"), (-3.0, "\u22123.00")],
)
def test_numbers_have_three_digits(value: float, text: str) -> None:
    assert parts.shown_number(value) == text


def test_a_number_that_is_not_there_is_a_dash() -> None:
    assert parts.shown_number(NOTHING) == "–"


# --- Colours -------------------------------------------------------------------------------------


def _luminance(colour: str) -> float:
    rgb = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


def colours_on_pages(name: str) -> tuple[str, str]:
    """What a name of a colour stands for on a light page, and on a dark one."""
    light, dark = re.findall(r"\.pounce-results\{(--[^}]*)\}", parts.style_sheet())
    key = name.removeprefix("var(").removesuffix(")")
    found = [dict(rule.split(":") for rule in rules.split(";") if rule) for rules in (light, dark)]
    return found[0][key], found[1][key]


@pytest.mark.parametrize("style", [*THESIS_STYLES.values(), *map(style_of, range(8))])
def test_lines_stand_out_from_white_and_from_nearly_black(style: Style) -> None:
    name = parts.colour_of(style)
    if name != "currentColor":
        on_white, on_dark = (_luminance(colour) for colour in colours_on_pages(name))
        assert 1.05 / (on_white + 0.05) >= 3
        # As the dots of runs are drawn, which are small and a little transparent.
        dark = _luminance("#242424")
        assert (0.75 * on_dark + 0.25 * dark + 0.05) / (dark + 0.05) >= 3.5


def test_the_learners_of_the_thesis_look_as_there() -> None:
    variants = experiment_of(THESIS).variants
    assert parts.styles_of(variants) == [THESIS_STYLES[v.preset] for v in variants]


def test_several_variants_of_one_preset_are_told_apart() -> None:
    styles = parts.styles_of(experiment_of(ONE_SETTING).variants)
    assert len({parts.colour_of(style) for style in styles}) == 4


def _hue(colour: str) -> float:
    """In degrees."""
    return 360 * colorsys.rgb_to_hsv(*(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)))[0]


def test_lines_of_the_same_hue_differ_in_their_dashes() -> None:
    styles = parts.styles_of(called([f"number {k}" for k in range(MOST_CURVES)]).variants)
    coloured = [
        (_hue(colours_on_pages(name)[0]), style.dashes)
        for style in styles
        if (name := parts.colour_of(style)) != "currentColor"
    ]
    for (hue, dashes), (other, others_dashes) in itertools.combinations(coloured, 2):
        apart = abs(hue - other)
        assert min(apart, 360 - apart) > 10 or dashes != others_dashes


# --- Learning curves -----------------------------------------------------------------------------


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


def curves_shown(experiment: Experiment, found: Sequence[Curve], **options: int) -> Shown:
    return Shown(curves.curves(context_of(experiment, [], **options), found, "steps"))


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
    shown = curves_shown(experiment_of(THESIS), [curve_of(0, [], 0), curve_of(1, [], 0)])
    assert "No curve yet" in shown.text
    assert list(shown.links("variant")) == ["0", "1"]


def test_a_sentence_says_of_single_runs_that_they_have_no_interval() -> None:
    experiment = experiment_of(THESIS)
    one = curves_shown(experiment, [curve_of(0, [1, 2], 1, arm=NOTHING)]).text
    assert "Each line is one run. One run has no interval." in one
    assert "too narrow" not in one
    some = curves_shown(experiment, [curve_of(0, [1, 2], 4)]).text
    assert "With fewer than 5 runs, intervals are too narrow." in some
    both = curves_shown(experiment, [curve_of(0, [1, 2], 4), curve_of(1, [1, 2], 1)]).text
    assert "intervals are too narrow, and of one there is none." in both
    assert "interval" not in runs_shown(experiment, some_runs(experiment, 1)).text.replace(
        "One run has no interval.", ""
    )


def test_curves_of_single_runs_have_no_band() -> None:
    shown = curves_shown(experiment_of(THESIS), [curve_of(0, [1, 2], 1, arm=NOTHING)])
    assert shown.one("path", class_="band").get("d") == ""


# --- Every run a dot -----------------------------------------------------------------------------


def runs_shown(experiment: Experiment, runs: Sequence[RunFact], **options: int) -> Shown:
    estimates = estimates_of(experiment, runs)
    return Shown(curves.runs(context_of(experiment, runs, **options), estimates))


def test_every_run_is_a_dot_at_its_value_that_opens_it() -> None:
    experiment = experiment_of(THESIS)
    runs = some_runs(experiment, 5)
    shown = runs_shown(experiment, runs)
    x, links = shown.value_at("x"), shown.links("open")
    assert set(links) == {run.key for run in runs}
    for run in runs:
        link = links[run.key]
        (dot,) = link.iter("circle")
        assert x(float(dot.get("cx", ""))) == pytest.approx(run.value, abs=0.3)
        (title,) = link.iter("title")
        label = experiment.variants[run.variant].label
        value = parts.shown_number(run.value)
        assert title.text == (
            f"{label}, seed {run.seed}: {value} - click to open this run in the lab"
        )


def test_a_row_has_mean_and_interval_and_a_label_that_chooses() -> None:
    experiment = experiment_of(THESIS)
    runs = some_runs(experiment, 4)
    shown = runs_shown(experiment, runs)
    x, links = shown.value_at("x"), shown.links("variant")
    assert list(links) == ["0", "1", "2", "3"]
    for place, estimate in enumerate(estimates_of(experiment, runs)):
        assert experiment.variants[place].label in " ".join(links[str(place)].itertext())
        row = shown.one("g", class_="row", data_variant=str(place))
        (mean,) = shown.all("path", row, class_="mean")
        assert x(points_of(mean.get("d"))[0][0]) == pytest.approx(estimate.value, abs=0.3)
        (interval,) = shown.all("path", row, class_="interval")
        low, high = map(float, re.findall(r"M(\S+) \S+H(\S+)", interval.get("d"))[0])
        assert (x(low), x(high)) == pytest.approx((estimate.low, estimate.high), abs=0.3)
        text = (parts.shown_number(number) for number in estimate[:3])
        assert "{} [{}, {}]".format(*text) in shown.text


def test_dots_lie_in_their_rows_and_the_same_way_each_time() -> None:
    experiment = experiment_of(THESIS)
    runs = [fact(place, seed, 50.0) for place in range(4) for seed in range(20)]
    shown, again = runs_shown(experiment, runs), runs_shown(experiment, runs[::-1])
    heights = {}
    for run in runs:
        (dot,) = shown.links("open")[run.key].iter("circle")
        (twin,) = again.links("open")[run.key].iter("circle")
        assert dot.get("cy") == twin.get("cy")
        heights.setdefault(run.variant, set()).add(float(dot.get("cy", "")))
    assert all(len(found) > 10 for found in heights.values())
    assert all(max(heights[k]) < min(heights[k + 1]) for k in range(3))


def test_failed_runs_are_counted_in_words() -> None:
    experiment = experiment_of(THESIS)
    runs = [fact(0, 0, 1.0), fact(0, 1, 0, "it broke"), fact(1, 0, 0, "so did it")]
    shown = runs_shown(experiment, [*runs, fact(2, 0, NOTHING)])
    assert "2 runs failed." in shown.text
    assert "1 run without a value." in shown.text
    assert list(shown.links("open")) == [runs[0].key]


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
    assert set(chosen.links("open")) == {run.key for run in runs if run.variant == 1}
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
    assert np.allclose(found, sorted(run.value for run in runs), atol=0.4)


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
    values = {run.variant: run.value for run in runs}
    wanted = {max(range(k, k + 3), key=lambda place: values[place]) for k in range(0, 450, 3)}
    assert set(map(int, links)) == wanted


def test_columns_of_too_many_runs_are_means_alone_and_say_so() -> None:
    experiment = called([f"number {k}" for k in range(60)])
    shown = runs_shown(experiment, some_runs(experiment, 30))
    assert dots_in(shown) == 0
    assert "1,800 runs are too many to draw one by one" in shown.text
    assert len(points_of(shown.one("path", class_="mean").get("d", ""))) == 60


# --- Sweeps --------------------------------------------------------------------------------------


def plane_shown(
    runs: Sequence[RunFact],
    sweep: Sweep | None = None,
    chosen: int | None = None,
    own: int | None = None,
) -> Shown:
    experiment = experiment_of(PLANE)
    return Shown(
        sweeps.plane(
            context_of(experiment, runs, chosen),
            sweep or sweep_in(experiment),
            estimates_of(experiment, runs),
            own,
        )
    )


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
        assert text.text == parts.shown_number(10.0 * place + 0.5)
        (title,) = link.iter("title")
        assert title.text is not None
        assert title.text.startswith(f"{variant.label}: ")
        assert title.text.endswith("n = 2")
        (cell,) = link.iter("path")
        setting = variant.overrides["learner.alpha"], variant.overrides["learner.gamma"]
        corners[setting] = points_of(cell.get("d", ""))[0]
        ink, ground = _luminance(f"#{3 * text.get('fill', '')[1:3]}"), _luminance(cell.get("fill"))
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
    sweep = sweep_in(experiment_of(PLANE))
    places = {where: place for where, place in sweep.places.items() if place != 3}
    shown = plane_shown([fact(k, 0, k) for k in range(12)], sweep._replace(places=places))
    assert set(shown.links("variant")) == {str(place) for place in range(12) if place != 3}
    assert len(shown.all("path", class_="empty")) == 1


def line_shown(text: str, runs: Sequence[RunFact], **options: int) -> Shown:
    experiment = experiment_of(text)
    return Shown(
        sweeps.line(
            context_of(experiment, runs, **options),
            sweep_in(experiment),
            estimates_of(experiment, runs),
        )
    )


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


# --- Whatever a label says -----------------------------------------------------------------------


def _all_charts(experiment: Experiment, runs: Sequence[RunFact]) -> Iterator[Shown]:
    yield curves_shown(experiment, [curve_of(place, [1, 2]) for place in range(3)])
    yield runs_shown(experiment, runs)


def test_hostile_labels_are_only_texts() -> None:
    experiment = called(HOSTILE)
    runs = [fact(place, 0, 10.0 * place) for place in range(3)]
    for shown in _all_charts(experiment, runs):
        assert not shown.all("script")
        assert set(shown.links("variant")) == {"0", "1", "2"}
        assert HOSTILE[0] in shown.text
        assert HOSTILE[1] in shown.text
    (title,) = runs_shown(experiment, runs).links("open")["key-0-0"].iter("title")
    assert title.text is not None
    assert HOSTILE[0] in title.text


@given(st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=6))
def test_any_values_can_be_drawn(values: Sequence[float]) -> None:
    experiment = experiment_of(ONE_SETTING)
    runs = [fact(k % 4, k, value) for k, value in enumerate(values)]
    assert len(runs_shown(experiment, runs).links("open")) == len(values)
    assert len(line_shown(ONE_SETTING, runs).links("variant")) == 4
