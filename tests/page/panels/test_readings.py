"""What stands beside the board: numbers, curve, marks, legend, and no markup from strangers."""

import itertools
import re
import secrets
from collections.abc import Callable, Iterator
from dataclasses import replace
from html.parser import HTMLParser
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.documents import presets
from app.explain.sentence import provenance
from app.live import snapshot
from app.live.held import Opened
from app.live.session import Session, Status
from app.live.snapshot import Snapshot
from app.metrics.course import GreedyCurve
from app.page import headline
from app.page.panels import curve
from app.page.panels.readings import Readings
from app.page.texts import Texts
from app.picture.layer import Extras
from app.picture.look import Look
from app.picture.theme import DARK, LIGHT
from app.server.calls import Calls
from app.server.server import close_server, open_server
from learners.commands import (
    Command,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    SetParameter,
    StopExploring,
    Undo,
)
from learners.measures import Curve, Endings
from learners.run import Run
from learners.spec import RunSpec


def spec_of(*settings: str, preset: str = "timed") -> RunSpec:
    """A preset in a small world."""
    return presets.load(preset, ["world.size=40", *settings])


def moment(run: Run | None = None, **parts: object) -> Snapshot:
    """The moment that a run is at, with some parts replaced."""
    return replace(snapshot.take(run or Run(spec_of(), seed=1), "timed", 0), **parts)


def status_of(taken: Snapshot, **parts: object) -> Status:
    """A playing session at a moment, with some parts replaced."""
    idle = Session(taken.spec, "timed", seed=1, speed=100.0, playing=True).status
    return replace(idle, snapshot=taken, preparing=False, **parts)


class Page(HTMLParser):
    """The tags and the text of a piece of HTML."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.words: list[str] = []
        self.feed(html)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.tags.append(tag)

    def handle_data(self, data: str) -> None:
        self.words.append(data)


# Headline and numbers


def test_the_sentence_above_the_board_is_that_of_the_moment() -> None:
    assert (
        ": approach. It is practised until"
        in Page(headline.sentence_html(status_of(moment()))).text
    )


def test_markup_in_an_error_is_shown_and_not_obeyed() -> None:
    error = "ValueError: <img src=x onerror=alert(1)> & <script>steal()</script>"
    harmless = headline.sentence_html(status_of(moment(), error="ValueError: x"))
    shown = Page(headline.sentence_html(status_of(moment(), error=error)))
    assert error in shown.text
    assert shown.tags == Page(harmless).tags


def test_an_error_is_shown_only_when_there_is_one() -> None:
    assert "Error" not in Page(headline.sentence_html(status_of(moment()))).text


@pytest.mark.parametrize("same", [None, True, False])
def test_a_run_of_an_experiment_is_named_under_the_sentence(same: bool | None) -> None:
    digest = "3fa9c1d2" + "0" * 56
    found = "" if same is None else digest if same else "f" * 64
    opened = Opened("figure_4_1: timed, seed 3", 1_000, digest, same, found)
    page = Page(headline.sentence_html(status_of(moment(), opened=opened)))
    sentence = Page(headline.sentence_html(status_of(moment()))).text
    assert page.text == f"{sentence} {provenance(opened)}"


@pytest.mark.parametrize("same", [None, True, False])
def test_markup_in_the_name_of_a_run_is_shown_and_not_obeyed(same: bool | None) -> None:
    name = "<img src=x onerror=alert(1)> & <script>steal()</script>"
    hostile = Opened(name, 1_000, "<b>3f</b>", same, "<b>3f</b>")
    harmless = Opened("timed", 1_000, "3f", same, "3f")
    shown = Page(headline.sentence_html(status_of(moment(), opened=hostile)))
    assert name in shown.text
    expected = Page(headline.sentence_html(status_of(moment(), opened=harmless)))
    assert shown.tags == expected.tags


def test_numbers_are_those_of_the_moment() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(until_trial=1_234)
    taken = moment(run, recent=Endings(captures=3, flights=4, timeouts=5), recent_reward=8.25)
    status = status_of(taken, steps_per_s=20_480.0)
    shown = headline.numbers_html(status, 2, greedy_curve((1_021, 20_345, -12.25)))
    reached = int((taken.value > 0).sum())
    assert reached > 0
    assert Page(shown).text == (
        f"Trial 1,234 Success 25% Reward 8.2 Greedy \N{MINUS SIGN}12.2"
        f" Steps {run.step:,} Steps/s 20 k States of value {reached:,} Viewers 2"
    )
    assert "measured at trial 1,021, step 20,345" in shown
    assert "of 3,456" in shown


def test_what_matters_first_is_read_on_the_stage_too() -> None:
    taken = moment(recent=Endings(captures=3, flights=4, timeouts=5), recent_reward=8.25)
    assert Page(headline.readings_html(status_of(taken))).text == (
        f"Trial {taken.trial} Success 25% Reward 8.2"
    )


def test_exploration_that_is_forced_is_said_beside_the_numbers_that_it_makes_small() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(until_trial=100)
    assert "forced" not in headline.numbers_html(status_of(moment(run)))
    run.apply(Explore("approach", 100, 0.95))
    status = status_of(moment(run))
    for shown in (headline.numbers_html(status), headline.readings_html(status)):
        assert "Forced exploration : approach 95%" in Page(shown).text
    run.advance(until_trial=200)
    assert "Forced" not in headline.readings_html(status_of(moment(run)))


def test_viewers_are_counted_where_there_are_others() -> None:
    assert "Viewers" not in headline.numbers_html(status_of(moment()), viewers=1)


def test_before_the_first_end_of_a_trial_there_is_no_success() -> None:
    text = Page(headline.numbers_html(status_of(moment()))).text
    nothing = "\N{EN DASH}"
    assert f"Success {nothing} Reward {nothing} Greedy {nothing} Steps" in text


@pytest.mark.parametrize(
    ("rate", "shown"),
    [
        (0.0, "0"),
        (999.6, "1,000"),
        (9_999.0, "9,999"),
        (12_345.0, "12 k"),
        (999_400.0, "999 k"),
        (999_600.0, "1 M"),
        (1_000_000.0, "1 M"),
        (24_560_000.0, "24.6 M"),
    ],
)
def test_rates_are_short(rate: float, shown: str) -> None:
    text = Page(headline.numbers_html(status_of(moment(), steps_per_s=rate))).text
    assert f"Steps/s {shown} States" in text


# The curve


def learned(steps: list[int], reward: list[float]) -> Curve:
    """A learning curve."""
    return Curve(np.array(steps, np.int64), np.array(reward, np.float64))


def greedy_curve(*points: tuple[int, int, float]) -> GreedyCurve:
    """A greedy curve of points of trial, step and reward."""
    trial, step, reward = zip(*points, strict=True)
    return GreedyCurve(np.array(trial), np.array(step), np.array(reward, np.float32))


def test_a_curve_without_a_window_is_a_flat_line() -> None:
    steps, reward = curve.learned_of(moment(curve=learned([], []), step=0))
    assert steps.tolist() == [0.0, 1.0]
    assert reward.tolist() == [0.0, 0.0]


def test_a_curve_of_one_window_is_a_flat_line_at_its_height() -> None:
    steps, reward = curve.learned_of(moment(curve=learned([700], [-12.5]), step=700))
    assert steps.tolist() == [0.0, 700.0]
    assert reward.tolist() == [-12.5, -12.5]


def test_windows_in_which_no_trial_ended_are_left_out() -> None:
    nan = float("nan")
    gaps = learned([1_000, 2_000, 3_000, 3_500], [nan, -50.0, nan, 100.0])
    steps, reward = curve.learned_of(moment(curve=gaps, step=3_500))
    assert steps.tolist() == [2_000.0, 3_500.0]
    assert reward.tolist() == [-50.0, 100.0]


def test_a_curve_of_nothing_but_gaps_is_a_flat_line() -> None:
    gaps = learned([1_000, 2_000], [float("nan")] * 2)
    steps, reward = curve.learned_of(moment(curve=gaps, step=2_000))
    assert steps.tolist() == [0.0, 2_000.0]
    assert np.isfinite(reward).all()


@pytest.mark.parametrize(("last", "shown"), [(3_400, 3), (3_600, 4), (4_000, 4)])
def test_a_window_that_has_just_begun_does_not_end_the_curve(last: int, shown: int) -> None:
    spiked = learned([1_000, 2_000, 3_000, last], [10.0, 12.0, 11.0, 100.0])
    _, reward = curve.learned_of(moment(curve=spiked, step=last))
    assert len(reward) == shown


def test_windows_of_trials_are_drawn_where_they_end() -> None:
    # However short a window is in steps.
    dip = learned([50_000, 90_000, 91_000], [60.0, 20.0, 70.0])
    taken = moment(trial_curve=dip, curve=learned([50_000, 100_000], [60.0, 55.0]), step=95_000)
    steps, reward = curve.learned_of(taken, "trials")
    assert steps.tolist() == [50_000.0, 90_000.0, 91_000.0]
    assert reward.tolist() == [60.0, 20.0, 70.0]
    assert curve.learned_of(taken, "steps")[1].tolist() == [60.0, 55.0]


def test_the_greedy_curve_has_its_points_where_it_was_measured_and_changes_no_other() -> None:
    taken = moment(curve=learned([1_000, 3_000], [10.0, 30.0]), step=3_500)
    greedy = greedy_curve((5, 500, 4.0), (20, 2_000, 40.0), (31, 3_400, 50.0))
    steps, learning, thin = curve.data_of(taken, "steps", greedy)
    assert steps.tolist() == [500.0, 1_000.0, 2_000.0, 3_000.0, 3_400.0]
    nan = float("nan")
    # On its own line in between, and nowhere beyond its ends.
    assert np.array_equal(learning, [nan, 10.0, 20.0, 30.0, nan], equal_nan=True)
    assert np.array_equal(thin, [4.0, nan, 40.0, nan, 50.0], equal_nan=True)


def test_no_point_is_drawn_of_what_is_yet_to_come() -> None:
    taken = moment(curve=learned([1_000, 2_000], [0.0, 1.0]), step=2_000)
    _, _, thin = curve.data_of(taken, "steps", greedy_curve((9, 1_500, 3.0), (90, 9_000, 5.0)))
    assert thin[np.isfinite(thin)].tolist() == [3.0]


def test_the_legend_names_both_curves_and_offers_the_other_windows() -> None:
    taken = moment(step=300_000, trial=2_000)
    shown = curve.legend_html(taken, "steps", LIGHT, lambda words: f"call/{words}")
    assert Page(shown).text == (
        "as it learns greedy: without random moves windows of 2,000 steps 500 trials"
    )
    assert re.findall(r'href="([^"]*)"', shown) == ["call/windows/trials"]
    other = curve.legend_html(taken, "trials", DARK, lambda words: f"call/{words}")
    assert re.findall(r'href="([^"]*)"', other) == ["call/windows/steps"]


def test_skills_are_marked_where_they_came_in_and_not_at_the_start() -> None:
    run = Run(spec_of(), seed=1)
    assert curve.marks_of(moment(run))[:2] == ((), ())
    run.advance(max_steps=4_321)
    run.apply(Introduce("circle_clockwise", 10))
    run.advance(max_steps=1_000)
    run.apply(Introduce("avoid", 10))
    assert curve.marks_of(moment(run))[:2] == (
        (4_321.0, 5_321.0),
        ("circle", "avoid"),
    )


@pytest.mark.parametrize(
    ("command", "name"),
    [
        (Explore("approach", 100, 0.5), "explore approach"),
        (FreezeSelection(True), "freeze selection"),
        (FreezeSkills(True), "freeze skills"),
        (SetParameter("learner.skill_alpha", 0.35), "α of skills = 0.35"),
    ],
)
def test_what_was_done_by_hand_is_marked_unless_it_is_undone(command: Command, name: str) -> None:
    run = Run(spec_of(), seed=1)
    run.advance(max_steps=4_321)
    run.apply(command)
    assert curve.marks_of(moment(run))[:2] == ((4_321.0,), (name,))
    run.apply(Undo(run.control.history[-1].number))
    assert curve.marks_of(moment(run))[:2] == ((), ())


def test_the_end_of_what_was_begun_by_hand_is_marked_too() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(max_steps=100)
    for command in (Explore("approach", 100, 0.5), FreezeSelection(True)):
        run.apply(command)
    run.advance(max_steps=100)
    for command in (FreezeSelection(False), StopExploring("approach")):
        run.apply(command)
    at, names, _ = curve.marks_of(moment(run))
    assert at == (100.0, 100.0, 200.0, 200.0)
    assert names[2:] == ("unfreeze selection", "stop exploring"), "in the order they were given"


def test_a_join_keeps_its_mark_until_it_is_taken_back() -> None:
    run = Run(spec_of("schedule.skills.circle_clockwise.at=5"), seed=1)
    run.advance(until_trial=10)
    for place in range(20):
        run.apply(SetParameter("learner.epsilon", place / 100))
    names = curve.marks_of(moment(run)).names
    assert names[0] == "circle"
    assert names[-1].endswith("0.19")
    assert len(names) == 8
    number = len(run.control.history)
    run.apply(Introduce("avoid", 0))
    assert curve.marks_of(moment(run)).names[-1] == "avoid"
    run.apply(Undo(number))
    assert "avoid" not in curve.marks_of(moment(run)).names


def test_what_leaves_the_learning_alone_and_what_the_schedule_brings_is_not_marked() -> None:
    run = Run(spec_of("schedule.skills.circle_clockwise.at=5"), seed=1)
    run.advance(until_trial=10)
    run.apply(FollowSchedule(False))
    assert [e.skill for e in run.control.episodes] == ["circle_clockwise"]
    names = curve.marks_of(moment(run)).names
    assert names == ("circle",)


shares = st.lists(st.floats(0, 1), min_size=1, max_size=8).map(sorted)
words = st.text("aMWi ", min_size=1, max_size=curve.LONGEST_NAME)


@given(shares=shares, data=st.data())
def test_no_name_of_a_mark_is_cut_or_lies_over_another(
    shares: list[float], data: st.DataObject
) -> None:
    names = tuple(data.draw(words) for _ in shares)
    at = tuple(share * 5_000 for share in shares)
    rows = curve.mark_rows(at, names, 5_000)
    for row in rows:
        assert len(row.names) == len(at)
        spans = sorted(
            row.span_of(share * curve.PLOT_PX, name)
            for share, name in zip(shares, row.names, strict=True)
            if name
        )
        assert spans[0][0] >= -curve.BESIDE_PLOT_PX
        assert spans[-1][1] <= curve.PLOT_PX
        assert all(one[1] <= other[0] for one, other in itertools.pairwise(spans))
    shown = [[row.names[mark] for row in rows if row.names[mark]] for mark in range(len(at))]
    assert all(found in ([], [name]) for found, name in zip(shown, names, strict=True))
    assert shown[-1] == [names[-1]]


def test_a_mark_at_the_right_edge_has_its_name_to_the_left() -> None:
    (row,) = curve.mark_rows((5_000.0,), ("α of skills = 0.35",), 5_000)
    assert (row.align, row.names) == (2, ["α of skills = 0.35"])
    (row,) = curve.mark_rows((0.0,), ("α of skills = 0.35",), 5_000)
    assert row.align == 1


def test_skills_that_are_there_from_the_start_have_no_marks() -> None:
    run = Run(spec_of(preset="hierarchical_3"), seed=1)
    run.advance(max_steps=5_000)
    assert curve.marks_of(moment(run))[:2] == ((), ())


# The panel of a browser, on a real server that nobody looks at


class AtOnce:
    """An inbox in which nothing waits."""

    def put(self, act: Callable[[], object]) -> None:
        act()


@pytest.fixture
def calls() -> Calls:
    return Calls()


@pytest.fixture
def panel(calls: Calls, monkeypatch: pytest.MonkeyPatch) -> Iterator[Readings]:
    server = open_server(port=0)
    client: Any = SimpleNamespace(gui=server.gui)
    inbox: Any = AtOnce()
    names = iter(("secret", "told"))
    monkeypatch.setattr(secrets, "token_urlsafe", lambda _: next(names))
    yield Readings(client, status_of(moment()), calls, inbox, lambda: None, lambda: None)
    close_server(server)


def test_every_new_curve_is_drawn_though_the_former_ones_are_gone(panel: Readings) -> None:
    base = status_of(moment())
    for number in range(50):
        # Nobody but the panel keeps the curve, so that another one may come to lie in its place.
        taken = replace(base.snapshot, curve=learned([1_000, 2_000], [0.0, float(number)]))
        panel.update(Texts(replace(base, snapshot=taken), Look(), Extras(), 1), "")
        del taken
        assert panel._curve.data[1][-1] == number


def test_a_curve_that_is_drawn_is_not_sent_again(panel: Readings) -> None:
    status = status_of(moment(curve=learned([1_000, 2_000], [0.0, 1.0])))
    panel.update(Texts(status, Look(), Extras(), 1), "")
    sent = panel._curve.data
    panel.update(Texts(status, Look(), Extras(), 1), "")
    assert panel._curve.data is sent


def test_windows_are_changed_by_a_link_until_the_browser_leaves(
    panel: Readings, calls: Calls
) -> None:
    taken = moment(curve=learned([10, 20], [0.0, 1.0]), trial_curve=learned([9, 20], [3.0, 4.0]))
    texts = Texts(status_of(replace(taken, step=20)), Look(), Extras(), 1)
    panel.update(texts, "")
    assert panel._curve.data[1].tolist() == [0.0, 1.0]
    assert "secret/windows%2Ftrials" in panel._curve_legend.content
    assert calls.take("secret/windows/trials")
    panel.update(texts, "")
    assert panel._curve.data[1].tolist() == [3.0, 4.0]
    for nonsense in ("windows/years", "windows", "open/steps", ""):
        assert calls.take(f"secret/{nonsense}")
    panel.update(texts, "")
    assert panel._curve.data[1].tolist() == [3.0, 4.0]
    panel.leave()
    assert not calls.take("secret/windows/steps")


def test_a_point_of_the_greedy_curve_is_drawn_once_it_is_measured(panel: Readings) -> None:
    status = status_of(moment(curve=learned([1_000, 2_000], [0.0, 1.0]), step=2_000))
    panel.update(Texts(status, Look(), Extras(), 1), "")
    assert not np.isfinite(panel._curve.data[2]).any()
    measured = greedy_curve((60, 1_500, 42.0))
    panel.update(Texts(status, Look(), Extras(), 1, greedy=measured), "")
    assert panel._curve.data[0].tolist() == [1_000.0, 1_500.0, 2_000.0]
    assert panel._curve.data[2][1] == 42.0
