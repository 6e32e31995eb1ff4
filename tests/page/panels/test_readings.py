"""What stands beside the board: numbers, curve, marks, legend, and no markup from strangers."""

import itertools
from collections.abc import Iterator
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
from app.page.panels import curve, readings
from app.page.panels.readings import Readings, Texts
from app.picture.layer import Extras
from app.picture.look import Look
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


def test_the_headline_carries_the_sentence() -> None:
    assert "One skill, approach" in Page(readings.headline_html(status_of(moment()))).text


def test_markup_in_an_error_is_shown_and_not_obeyed() -> None:
    error = "ValueError: <img src=x onerror=alert(1)> & <script>steal()</script>"
    harmless = readings.headline_html(status_of(moment(), error="ValueError: x"))
    shown = Page(readings.headline_html(status_of(moment(), error=error)))
    assert error in shown.text
    assert shown.tags == Page(harmless).tags


def test_an_error_is_shown_only_when_there_is_one() -> None:
    assert "Error" not in Page(readings.headline_html(status_of(moment()))).text


@pytest.mark.parametrize("same", [None, True, False])
def test_a_run_of_an_experiment_is_named_under_the_sentence(same: bool | None) -> None:
    digest = "3fa9c1d2" + "0" * 56
    found = "" if same is None else digest if same else "f" * 64
    opened = Opened("figure_4_1: timed, seed 3", 1_000, digest, same, found)
    page = Page(readings.headline_html(status_of(moment(), opened=opened)))
    sentence = Page(readings.headline_html(status_of(moment()))).text
    assert page.text == f"{sentence} {provenance(opened)}"


@pytest.mark.parametrize("same", [None, True, False])
def test_markup_in_the_name_of_a_run_is_shown_and_not_obeyed(same: bool | None) -> None:
    name = "<img src=x onerror=alert(1)> & <script>steal()</script>"
    hostile = Opened(name, 1_000, "<b>3f</b>", same, "<b>3f</b>")
    harmless = Opened("timed", 1_000, "3f", same, "3f")
    shown = Page(readings.headline_html(status_of(moment(), opened=hostile)))
    assert name in shown.text
    expected = Page(readings.headline_html(status_of(moment(), opened=harmless)))
    assert shown.tags == expected.tags


def test_numbers_are_those_of_the_moment() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(until_trial=1_234)
    taken = moment(run, recent=Endings(captures=3, flights=4, timeouts=5))
    text = Page(readings.numbers_html(status_of(taken, steps_per_s=20_480.0))).text
    reached = int((taken.value > 0).sum())
    assert reached > 0
    assert text == (
        f"Trial 1,234 Steps {run.step:,} Steps/s 20 k Success 25%"
        f" States of value {reached:,} of 3,456 Viewers 1"
    )


def test_before_the_first_end_of_a_trial_there_is_no_success() -> None:
    text = Page(readings.numbers_html(status_of(moment()))).text
    assert "Success \N{EN DASH} States" in text


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
    text = Page(readings.numbers_html(status_of(moment(), steps_per_s=rate))).text
    assert f"Steps/s {shown} Success" in text


# The curve


def learned(steps: list[int], reward: list[float]) -> Curve:
    """A learning curve."""
    return Curve(np.array(steps, np.int64), np.array(reward, np.float64))


def test_a_curve_without_a_window_is_a_flat_line() -> None:
    steps, reward = curve.data_of(moment(curve=learned([], []), step=0))
    assert steps.tolist() == [0.0, 1.0]
    assert reward.tolist() == [0.0, 0.0]


def test_a_curve_of_one_window_is_a_flat_line_at_its_height() -> None:
    steps, reward = curve.data_of(moment(curve=learned([700], [-12.5]), step=700))
    assert steps.tolist() == [0.0, 700.0]
    assert reward.tolist() == [-12.5, -12.5]


def test_windows_in_which_no_trial_ended_are_left_out() -> None:
    nan = float("nan")
    gaps = learned([1_000, 2_000, 3_000, 3_500], [nan, -50.0, nan, 100.0])
    steps, reward = curve.data_of(moment(curve=gaps, step=3_500))
    assert steps.tolist() == [2_000.0, 3_500.0]
    assert reward.tolist() == [-50.0, 100.0]


def test_a_curve_of_nothing_but_gaps_is_a_flat_line() -> None:
    gaps = learned([1_000, 2_000], [float("nan")] * 2)
    steps, reward = curve.data_of(moment(curve=gaps, step=2_000))
    assert steps.tolist() == [0.0, 2_000.0]
    assert np.isfinite(reward).all()


@pytest.mark.parametrize(("last", "shown"), [(3_400, 3), (3_600, 4), (4_000, 4)])
def test_a_window_that_has_just_begun_does_not_end_the_curve(last: int, shown: int) -> None:
    spiked = learned([1_000, 2_000, 3_000, last], [10.0, 12.0, 11.0, 100.0])
    _, reward = curve.data_of(moment(curve=spiked, step=last))
    assert len(reward) == shown


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


@pytest.fixture
def panel() -> Iterator[Readings]:
    server = open_server(port=0)
    client: Any = SimpleNamespace(gui=server.gui)
    yield Readings(client, status_of(moment()))
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
