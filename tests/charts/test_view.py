"""The view of results: what it offers, what a click changes, and that every run can be found."""

import math
from collections.abc import Sequence
from dataclasses import replace
from urllib.parse import quote
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.charts.downloads import drawing_of
from app.charts.page.results import results_html
from app.charts.variants import swept, with_short_names
from app.charts.view import COLUMNS, Size, View, answer, first_view
from app.documents import presets
from app.documents.experiments import Experiment, load, parse
from app.metrics import FINAL_REWARD, IN_TABLE
from app.results.gather import Gathering, PlacedRun
from tests.support.runs import (
    HOSTILE,
    ONE_SETTING,
    PLANE,
    THESIS,
    Shown,
    address,
    called,
    experiment_of,
    fact,
    filled,
    gathering_of,
    reward,
    some_runs,
)

SIZE = Size(684)
WIDE = Size(1900)
"""So wide that all columns have room."""
ROWS = SIZE.rows
NOTHING = math.nan


def html_of(
    experiment: Experiment, runs: Sequence[PlacedRun], view: View, size: Size = SIZE
) -> str:
    gatherer = filled(experiment, runs)
    return results_html(gatherer, gatherer.gathering(), view, address, size)


def shown(
    experiment: Experiment, runs: Sequence[PlacedRun], view: View, size: Size = SIZE
) -> Shown:
    return Shown(html_of(experiment, runs, view, size))


def of_runs(page: Shown, tag: str) -> list[ElementTree.Element]:
    """Elements of the table of runs."""
    return page.all(tag, page.one("table", class_="runs"))


def rows_of(page: Shown) -> list[list[str]]:
    """What the table's rows say, cell by cell."""
    (body,) = of_runs(page, "tbody")
    return [["".join(cell.itertext()) for cell in row.iter("td")] for row in body.iter("tr")]


def opened_in_table(page: Shown) -> list[str]:
    """Words of the rows' links, in their order, each once."""
    (body,) = of_runs(page, "tbody")
    hrefs = [link.get("href") for link in body.iter("a")]
    return list(dict.fromkeys(hrefs))


def headings_of(page: Shown) -> list[str]:
    """Hints of the table's headings."""
    return [link.get("title", "") for head in of_runs(page, "th") for link in head.iter("a")]


def words_of(page: Shown) -> set[str]:
    return set(page.words)


# --- What is looked at first ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "chart"),
    [
        (THESIS, "curves"),
        (ONE_SETTING, "curves"),
        (PLANE, "plane"),
        ("presets: [timed]\ngrid: {learner.gamma: {start: 0.1, stop: 0.9, step: 0.05}}", "runs"),
        (f"{PLANE}\n".replace("[timed]", "[timed, standard_q]"), "runs"),
    ],
)
def test_first_come_curves_of_a_few_then_a_plane_then_runs(text: str, chart: str) -> None:
    assert first_view(experiment_of(text)) == View(chart)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "name"),
    [(PLANE, "Plane"), (ONE_SETTING, "Sweep"), (THESIS, None)],
)
def test_a_plane_is_offered_where_one_preset_was_swept(text: str, name: str | None) -> None:
    experiment = experiment_of(text)
    page = shown(experiment, [fact(0, 0, 1.0)], View("runs"))
    links = page.links("chart")
    assert "curves" in links
    assert ("plane" in links) == (name is not None)
    if name is not None:
        assert links["plane"].text == name
    view = View("runs")
    after = answer(view, "chart/plane", gathering_of(experiment, []), ROWS)
    assert after == (view if name is None else View("plane"))


def test_before_any_run_is_over_a_sentence_says_so() -> None:
    page = shown(experiment_of(THESIS), [], View("curves"))
    assert "No run is over yet." in page.text
    assert not page.all("svg")
    assert not page.all("table")


def test_if_all_runs_failed_the_table_says_why() -> None:
    page = shown(experiment_of(THESIS), [fact(0, 0, 0, "it broke")], View("curves"))
    assert "Every run that is over has failed." in page.text
    assert not page.all("svg")
    assert "it broke" in page.text


@pytest.mark.parametrize("chart", ["curves", "runs", "plane"])
@pytest.mark.parametrize("variant", [None, 2])
@pytest.mark.parametrize("text", [THESIS, ONE_SETTING, PLANE])
def test_every_view_can_be_shown(text: str, chart: str, variant: int | None) -> None:
    experiment = experiment_of(text)
    runs = some_runs(experiment, 2)
    page = shown(experiment, runs, View(chart, variant=variant))  # type: ignore[arg-type]
    assert page.all("svg")
    assert ("variant/all" in page.words) == (variant is not None)


# --- Clicks --------------------------------------------------------------------------------------


def _some_gathering() -> Gathering:
    experiment = experiment_of(PLANE)
    return gathering_of(experiment, some_runs(experiment, 2))


GATHERING = _some_gathering()
VIEW = View("runs", page=1)


@pytest.mark.parametrize(
    ("words", "after"),
    [
        ("chart/curves", replace(VIEW, chart="curves")),
        ("chart/plane", replace(VIEW, chart="plane")),
        ("axis/trials", replace(VIEW, axis="trials")),
        ("variant/3", replace(VIEW, variant=3, page=0)),
        ("order/value", replace(VIEW, order="value", page=0)),
        ("order/variant", replace(VIEW, descending=True, page=0)),
        ("page/2", replace(VIEW, page=2)),
    ],
)
def test_words_change_the_view(words: str, after: View) -> None:
    assert answer(VIEW, words, GATHERING, ROWS) == after


def test_choosing_again_unchooses() -> None:
    chosen = answer(VIEW, "variant/3", GATHERING, ROWS)
    assert answer(chosen, "variant/3", GATHERING, ROWS).variant is None
    assert answer(chosen, "variant/all", GATHERING, ROWS).variant is None
    assert answer(chosen, "variant/4", GATHERING, ROWS).variant == 4


def test_ordering_again_turns_round() -> None:
    once = answer(VIEW, "order/final_success", GATHERING, ROWS)
    twice = answer(once, "order/final_success", GATHERING, ROWS)
    assert (once.descending, twice.descending) == (False, True)
    assert answer(twice, "order/final_success", GATHERING, ROWS) == once
    assert not answer(twice, "order/steps", GATHERING, ROWS).descending


@pytest.mark.parametrize(
    "words",
    [
        *("", "/", "chart", "chart/", "chart/pie", "axis/reward", "axis/steps/", "variant/"),
        *("variant/12", "variant/-1", "variant/1.0", "variant/²", "variant/٣", "variant/ 1"),
        *("order/", "order/key", "order/__class__", "page/3", "page/-1", "page/" + "9" * 5000),
        *("open/key-0-0", "Chart/curves", "page/1/2", "variant/All", "variant/0x1"),
    ],
)
def test_words_that_make_no_sense_change_nothing(words: str) -> None:
    assert answer(VIEW, words, GATHERING, ROWS) == VIEW


@given(
    st.one_of(
        st.text(),
        st.builds(
            lambda verb, rest: f"{verb}/{rest}",
            st.sampled_from(["chart", "axis", "variant", "order", "page", "open"]),
            st.one_of(st.text(), st.integers().map(str), st.sampled_from(COLUMNS)),
        ),
    )
)
def test_whatever_is_said_the_view_stays_one_that_can_be_shown(words: str) -> None:
    view = answer(VIEW, words, GATHERING, ROWS)
    assert view.chart in ("curves", "runs", "plane")
    assert view.axis in ("steps", "trials")
    assert view.variant is None or 0 <= view.variant < len(GATHERING.experiment.variants)
    assert view.order in COLUMNS
    assert 0 <= view.page < 3


def test_every_link_is_understood() -> None:
    experiment = experiment_of(PLANE)
    runs = some_runs(experiment, 3)
    gatherer = filled(experiment, runs)
    gathering = gatherer.gathering()
    for chart in ("curves", "runs", "plane"):
        view = View(chart, variant=1, page=0)
        page = Shown(results_html(gatherer, gathering, view, address, SIZE))
        for words in words_of(page):
            if words.startswith("open/"):
                assert words.removeprefix("open/") in {run.key for _, run in runs}
            else:
                assert answer(view, words, gathering, ROWS) != view


# --- The table -----------------------------------------------------------------------------------


def test_a_row_says_all_of_a_run_and_opens_it() -> None:
    placed = fact(
        *(2, 7, 80.125),
        final_greedy=71.25,
        final_success=0.856,
        steps_to_70=1_057_691,
        steps=5_670_000,
        seconds=0.44,
    )
    page = shown(experiment_of(THESIS), [placed], View("runs"))
    assert rows_of(page) == [
        ["timed", "7", "80.12", "71.2", "86 %", "1.06", "5.67", "01234567", "open ▸"]
    ]
    assert opened_in_table(page) == [address(f"open/{placed[1].key}")]


def test_a_click_anywhere_in_a_row_opens_its_run_and_one_stop_of_the_keyboard_does() -> None:
    runs = [fact(2, seed, 80.0) for seed in range(2)]
    (body,) = of_runs(shown(experiment_of(THESIS), runs, View("runs")), "tbody")
    for (_, run), row in zip(runs, body.iter("tr"), strict=True):
        for cell in row.iter("td"):
            # Nothing of a cell lies beside its link, which fills it.
            (link,) = cell
            assert link.tag == "a"
            assert link.get("href") == address(f"open/{run.key}")
            assert not cell.text
            assert not link.tail
        assert [link.get("tabindex") for link in row.iter("a")].count(None) == 1


def test_a_run_that_ended_before_it_got_there_takes_more_than_it_had() -> None:
    page = shown(experiment_of(THESIS), [fact(0, 0, 1.0, steps=4_560_000)], View("runs"))
    assert rows_of(page)[0][5] == ">\N{NO-BREAK SPACE}4.56"


HORIZON = f"{THESIS}\nhorizon: 5500000"
AT_HORIZON = {"horizon_reward": 61.5, "horizon_greedy": 52.5, "horizon_area": 33.25}


def test_columns_at_the_horizon_say_at_how_many_steps_that_is() -> None:
    page = shown(experiment_of(HORIZON), [fact(0, 0, 70.0, **AT_HORIZON)], View("runs"), WIDE)
    headings = ["".join(head.itertext()) for head in of_runs(page, "th")]
    row = dict(zip(headings, rows_of(page)[0], strict=True))
    assert row["reward"] == "70.0"
    assert row["reward at 5.5 M"] == "61.5"
    assert row["greedy at 5.5 M"] == "52.5"
    assert row["area under the curve at 5.5 M steps"] == "33.25"
    # Of an experiment without a horizon there is nothing to say.
    page = shown(experiment_of(THESIS), [fact(0, 0, 70.0)], View("runs"), WIDE)
    assert not any("5.5 M" in hint or "horizon" in hint for hint in headings_of(page))


def test_columns_are_those_that_were_asked_for_as_far_as_there_is_room() -> None:
    few = experiment_of("presets: [timed]\nmetrics: [area, steps_to_70]")
    runs = [fact(0, 0, 1.0, area=20.0)]
    titles = ["".join(head.itertext()) for head in of_runs(shown(few, runs, View("runs")), "th")]
    wanted = ["variant\N{NO-BREAK SPACE}▲", "seed", "area under the curve", "M steps to 70"]
    assert titles == [*wanted, "M steps", "seconds", "digest", ""]
    # A variant's name has room in any panel.
    for width in (650, 684, 900, 1_240):
        page = shown(experiment_of(HORIZON), runs, View("runs"), Size(width))
        widths = [float(col.get("style", "")[6:-2]) for col in of_runs(page, "col")[1:]]
        assert sum(widths) <= width - 110


def test_what_dots_show_can_be_chosen() -> None:
    experiment = experiment_of(HORIZON)
    runs = [fact(0, 0, 70.0, **AT_HORIZON), fact(0, 1, 72.0, **AT_HORIZON)]
    gathering = filled(experiment, runs).gathering()
    page = shown(experiment, runs, View("runs"))
    assert "area under the curve at 5.5 M steps" in page.text
    assert [row[2] for row in rows_of(page)] == ["33.25", "33.25"]
    offered = page.links("metric")
    assert "".join(offered["horizon_reward"].itertext()) == "reward at 5.5 M"
    view = answer(View("runs"), "metric/final_reward", gathering, ROWS)
    page = shown(experiment, runs, view)
    assert "final reward (mean per trial, all 400 trials)" in page.text
    assert [row[2] for row in rows_of(page)] == ["70.00", "72.00"]
    drawing = drawing_of(filled(experiment, runs), gathering, view)
    assert "final reward (mean per trial, all 400 trials)" in drawing.csv
    for nonsense in ("metric/", "metric/steps", "metric/nothing"):
        assert answer(view, nonsense, gathering, ROWS) == view
    # Curves are of rewards.
    assert not shown(experiment, runs, View("curves")).links("metric")


def test_medians_count_runs_that_ended_before_until_then() -> None:
    runs = [
        fact(0, 0, 1.0, steps_to_70=1e6, steps=5_000_000),
        *(fact(0, seed, 1.0, steps=4_560_000) for seed in (1, 2)),
        *(fact(1, seed, 1.0, steps_to_70=seed * 1e6, steps=5_000_000) for seed in (1, 2, 3)),
    ]
    first, second, *_ = experiment_of(HORIZON).variants
    text = shown(experiment_of(HORIZON), runs, View("runs")).text
    more_than = ">\N{NO-BREAK SPACE}4.56"
    assert f"{first.label} {more_than}; {second.label} 2.00." in text


def test_failed_runs_say_why_and_cannot_be_opened() -> None:
    error = f"Trouble\nValueError: {HOSTILE[0]}" + "x" * 10_000
    runs = [fact(0, 0, 0, error), fact(0, 1, 1.0)]
    page = shown(experiment_of(THESIS), runs, View("runs"))
    assert not page.all("script")
    (failed,) = page.all("tr", class_="failed")
    assert not list(failed.iter("a"))
    text = "".join(failed.itertext())
    assert "failed: " in text
    assert f"ValueError: {HOSTILE[0]}" in text
    assert len(text) < 300
    assert len(html_of(experiment_of(THESIS), runs, View("runs"))) < 20_000


def test_seeds_as_long_as_they_get_are_there_in_full() -> None:
    seed = 2**63 - 1
    page = shown(experiment_of(THESIS), [fact(0, seed, 1.0)], View("runs"))
    assert rows_of(page)[0][1] == str(seed)


def test_with_a_variant_chosen_only_its_runs_are_listed() -> None:
    experiment = experiment_of(THESIS)
    runs = some_runs(experiment, 5)
    page = shown(experiment, runs, View("curves", variant=2))
    assert {row[0] for row in rows_of(page)} == {"timed"}
    assert "1–5 of 5" in page.text
    assert "chosen:" in page.text


values = st.one_of(st.floats(-50, 100), st.just(NOTHING))


@given(
    st.lists(st.tuples(st.integers(0, 3), values, st.booleans()), min_size=1, max_size=40),
    st.sampled_from(COLUMNS),
    st.booleans(),
)
def test_every_run_is_on_exactly_one_page(
    made: list[tuple[int, float, bool]], order: str, descending: bool
) -> None:
    experiment = experiment_of(THESIS)
    runs = [
        fact(variant, seed, value, "" if done else "broke", final_success=value)
        for seed, (variant, value, done) in enumerate(made)
    ]
    gathering = gathering_of(experiment, runs)
    n_pages = max(math.ceil(len(runs) / ROWS), 1)
    gatherer = filled(experiment, runs)
    seeds: list[int] = []
    for page in range(n_pages):
        view = View("curves", order=order, descending=descending)
        view = answer(view, f"page/{page}", gathering, ROWS)
        found = Shown(results_html(gatherer, gatherer.gathering(), view, address, SIZE))
        rows = rows_of(found)
        assert len(rows) == min(ROWS, len(runs) - page * ROWS)
        seeds += [int(row[1]) for row in rows]
        first = page * ROWS
        assert f"{first + 1}–{first + len(rows)} of {len(runs)}" in found.text
    assert sorted(seeds) == list(range(len(runs)))
    if order in ("value", "final_success"):
        column = [reward(runs[seed]) for seed in seeds if not runs[seed][1].error]
        there = [value for value in column if not math.isnan(value)]
        assert there == sorted(there, reverse=descending)
        is_missing = [bool(runs[s][1].error) or math.isnan(reward(runs[s])) for s in seeds]
        assert is_missing == sorted(is_missing)


@pytest.mark.parametrize("column", [c for c in COLUMNS if c != "horizon_area"])
def test_every_column_orders_both_ways(column: str) -> None:
    experiment = experiment_of(HORIZON)
    runs = [
        fact(
            place,
            seed=place,
            value=10.0 * place,
            **{
                metric.column: 60_000.0 * (place + 1)
                for metric in IN_TABLE
                if metric.column != FINAL_REWARD.column
            },
            seconds=1.0 + place,
            digest=f"{place}abcdefgh",
        )
        for place in range(4)
    ]
    mixed = [runs[2], runs[0], runs[3], runs[1]]
    for descending in (False, True):
        page = shown(experiment, mixed, View("runs", order=column, descending=descending), WIDE)
        wanted = [address(f"open/{run.key}") for _, run in runs]
        assert opened_in_table(page) == (wanted[::-1] if descending else wanted)
        heads = [head for head in of_runs(page, "th") if head.get("aria-sort")]
        assert [head.get("aria-sort") for head in heads] == [
            "descending" if descending else "ascending"
        ]
        assert ("▼" if descending else "▲") in "".join(heads[0].itertext())


def test_a_run_that_ended_before_comes_after_those_that_got_there() -> None:
    runs = [fact(0, 0, 1.0), fact(0, 1, 1.0, steps_to_70=9), fact(0, 2, 0, "broke")]
    for descending, wanted in ((False, ["1", "0", "2"]), (True, ["0", "1", "2"])):
        view = View("runs", order="steps_to_70", descending=descending)
        assert [row[1] for row in rows_of(shown(experiment_of(THESIS), runs, view))] == wanted


def test_a_page_that_is_not_there_shows_the_last_one() -> None:
    experiment = experiment_of(THESIS)
    page = shown(experiment, some_runs(experiment, 5), View("curves", variant=1, page=2))
    assert "1–5 of 5" in page.text


def test_the_pager_leads_to_both_ends_and_both_neighbours() -> None:
    experiment = experiment_of(THESIS)
    runs = some_runs(experiment, 50)
    page = shown(experiment, runs, View("curves", page=10))
    last = (len(runs) - 1) // ROWS
    assert {w for w in words_of(page) if w.startswith("page/")} == {
        *("page/0", "page/9", "page/11", f"page/{last}")
    }
    first = 10 * ROWS + 1
    assert f"{first}–{first + ROWS - 1} of {len(runs)}" in page.text


# --- Large, and hostile --------------------------------------------------------------------------


@pytest.mark.parametrize("chart", ["curves", "runs", "plane"])
@pytest.mark.parametrize("variant", [None, 50])
def test_ten_thousand_runs_are_light(chart: str, variant: int | None) -> None:
    experiment = experiment_of(
        "presets: [timed]\ngrid:\n"
        "  schedule.skills.circle_clockwise.at: {start: 0, stop: 360, step: 40}\n"
        "  schedule.skills.avoid.at: {start: 0, stop: 360, step: 40}\n"
    )
    gatherer = filled(experiment, [fact(place, 0, float(place)) for place in range(100)])
    runs = [
        (place, replace(run, key=f"timed-circle-clockwise-avoid-{run.key}-0123456789abcdef"))
        for place, run in some_runs(experiment, 100)
    ]
    gathering = replace(gatherer.gathering(), runs=runs)
    view = View(chart, variant=variant, order="value")  # type: ignore[arg-type]

    def long_address(words: str) -> str:
        return f"call/{'s' * 22}/{quote(words, safe='')}"

    html = results_html(gatherer, gathering, view, long_address, SIZE)
    assert len(html.encode()) < 100_000
    assert f"of {100 if variant else 10_000:,}" in html


def test_means_of_thousands_of_variants_need_no_intervals() -> None:
    experiment = experiment_of(
        "presets: [timed]\ngrid: {learner.alpha: {start: 0.001, stop: 0.45, step: 0.001}}"
    )
    runs = [fact(0, 0, 1.0), fact(0, 1, 3.0), fact(449, 0, 7.0), fact(3, 0, 0, "broke")]
    page = shown(experiment, runs, View("runs"))
    titles = [title.text or "" for title in page.all("title")]
    assert any(title.endswith(": 2.00, n = 2") for title in titles)
    assert any(title.endswith(": 7.00, n = 1") for title in titles)
    assert len(html_of(experiment, runs, View("runs"))) < 100_000
    assert swept(experiment) is None


@pytest.mark.parametrize("chart", ["curves", "runs"])
def test_hostile_labels_are_only_texts(chart: str) -> None:
    experiment = called(HOSTILE)
    runs = [fact(place, 0, 1.0 + place) for place in range(3)]
    for variant in (None, 0, 1, 2):
        page = shown(experiment, runs, View(chart, variant=variant))  # type: ignore[arg-type]
        assert not page.all("script")
        assert HOSTILE[1] in page.text


def test_the_panel_is_as_wide_as_it_is_asked_to_be() -> None:
    experiment = experiment_of(THESIS)
    gatherer = filled(experiment, some_runs(experiment, 2))
    for width in (684, 1080):
        for chart in ("curves", "runs"):
            html = results_html(gatherer, gatherer.gathering(), View(chart), address, Size(width))
            picture = Shown(html).one("svg", role="group")
            assert picture.get("viewBox", "").split()[2] == str(width)
            for text in picture.iter("text"):
                assert 0 <= float(text.get("x", "0")) <= width


def test_what_was_swept_is_called_by_its_values_and_the_presets_own_place_is_framed() -> None:
    experiment = load("timing_plane", 1)
    own = next(
        place
        for place, variant in enumerate(experiment.variants)
        if variant.spec == presets.load("timed")
    )
    runs = some_runs(experiment, 1)
    page = shown(experiment, runs, View("plane", variant=own))
    assert [row[0] for row in rows_of(page)] == ["12,000 / 14,500"]
    assert "the preset's own setting" in page.text
    assert len([g for g in page.all("g") if g.get("class") == "own"]) == 1


def test_names_that_were_given_stay_and_others_are_made_of_what_differs() -> None:
    labels = {
        name: [variant.label for variant in with_short_names(load(name, 1))[0].variants]
        for name in ("figure_4_1", "figure_4_2", "figure_4_3", "freeze")
    }
    assert labels["figure_4_1"][:2] == ["standard_q", "hierarchical_3"]
    assert labels["figure_4_2"][:2] == ["standard_q / 60", "standard_q / 120"]
    assert labels["figure_4_3"][0] == "standard_q, 24 x 18"
    assert labels["freeze"] == ["0", "30", "100", "300", "1,000", "2,000"]
    for name, found in labels.items():
        assert len(set(found)) == len(found), name


@pytest.mark.parametrize(
    ("text", "final"),
    [
        ("trials: 600", "all 600 trials"),
        ("trials: 5000", "last 2,000 trials"),
        ("settings: [{trials: 600}, {trials: 900}]", "all trials, at most 900"),
        ("settings: [{trials: 600}, {trials: 9000}]", "last 2,000 trials, or all of fewer"),
        ("steps: 5000", "last 2,000 trials, or all of fewer"),
        ("trials: 9000\nstop: {success: 0.5}", "last 2,000 trials, or all of fewer"),
        ("trials: 600\nstop: {success: 0.5}", "all trials, at most 600"),
    ],
)
def test_what_is_final_is_said_as_it_was_measured(text: str, final: str) -> None:
    experiment = parse(f"presets: [timed]\n{text}", "some.yaml")
    runs = [fact(0, 0, 1.0), fact(0, 1, 2.0)]
    page = shown(experiment, runs, View("runs"), WIDE)
    assert f"final reward (mean per trial, {final})" in page.text
    assert f"final reward (mean per trial, {final}): sort" in headings_of(page)
    assert f"captures in per cent, {final}: sort" in headings_of(page)
    gatherer = filled(experiment, runs)
    drawing = drawing_of(gatherer, gatherer.gathering(), View("runs"))
    assert f"(mean per trial, {final})" in drawing.csv


def test_a_high_panel_has_a_high_chart_and_many_rows_and_a_low_one_few() -> None:
    experiment = experiment_of(THESIS)
    gatherer = filled(experiment, some_runs(experiment, 20))
    heights, rows = [], []
    for height in (100, 752, 1064):
        size = Size(684, height)
        view = View("curves")
        page = Shown(results_html(gatherer, gatherer.gathering(), view, address, size))
        heights.append(float(page.one("svg", role="group").get("viewBox", "").split()[3]))
        rows.append(len(rows_of(page)))
        assert rows[-1] == size.rows
        last = answer(view, f"page/{(80 - 1) // size.rows}", gatherer.gathering(), size.rows)
        page = Shown(results_html(gatherer, gatherer.gathering(), last, address, size))
        assert "of 80" in page.text
        assert len(rows_of(page)) == 80 - last.page * size.rows
    assert heights[0] < heights[1] < heights[2]
    assert rows[0] < rows[1] < rows[2]


def test_what_was_not_measured_is_not_called_more() -> None:
    experiment = experiment_of(HORIZON)
    runs = [
        fact(0, 0, 1.0, steps_to_70=math.inf, steps=9_000_000),
        fact(0, 1, 1.0, steps_to_70=math.nan),
    ]
    cells = [row[5] for row in rows_of(shown(experiment, runs, View("runs")))]
    assert cells == [">\N{NO-BREAK SPACE}9.00", "–"]


def test_of_a_search_it_says_where_the_effects_of_its_settings_are() -> None:
    search = experiment_of(
        "presets: [timed]\nsample: {count: 2, seed: 1, keys: {learner.gamma: [0.5, 0.9]}}"
    )
    assert "pounce report" in shown(search, [fact(0, 0, 1.0)], View("runs")).text
    assert "pounce report" not in shown(experiment_of(PLANE), [fact(0, 0, 1.0)], View("runs")).text


def test_windows_of_curves_are_of_steps_or_of_trials() -> None:
    experiment = experiment_of(THESIS)
    gatherer = filled(experiment, some_runs(experiment, 2))
    gathering = gatherer.gathering()
    page = shown(experiment, some_runs(experiment, 2), View("curves"))
    assert set(page.links("windows")) == {"trials"}
    view = answer(View("curves"), "windows/trials", gathering, ROWS)
    assert view == View("curves", windows="trials")
    assert set(Shown(results_html(gatherer, gathering, view, address, SIZE)).links("windows")) == {
        "steps"
    }
    assert answer(view, "windows/years", gathering, ROWS) == view
    # Against trials, windows are of trials.
    against_trials = answer(view, "axis/trials", gathering, ROWS)
    page = Shown(results_html(gatherer, gathering, against_trials, address, SIZE))
    assert not page.links("windows")
