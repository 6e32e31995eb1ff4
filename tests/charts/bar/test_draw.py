"""The bar as it is sent: well-formed, small, and no markup from strangers."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.analysis.estimates import Axis
from app.charts.bar.draw import bar_html
from app.charts.bar.model import Ghost, Moment, bar_of
from app.documents import presets
from app.live import snapshot
from app.schedule.blocks import Block, Past, blocks_of
from learners.commands import Command, FreezeSelection
from learners.run import Run
from learners.spec import MAX_TRIALS
from tests.support.curves import greedy_curve, learned
from tests.support.schedules import AVOIDING, commands, driven, seen, small_run, to


def drawn(moment: Moment, unit: Axis = "trials") -> ElementTree.Element:
    """The bar, parsed: it is well-formed."""
    return ElementTree.fromstring(
        bar_html(bar_of(moment, unit, 2_000), lambda words: f"call/{words}")
    )


def moment(run: Run, **parts: object) -> Moment:
    shot = seen(run)
    return Moment(shot, blocks_of(shot))._replace(**parts)


def classes(html: ElementTree.Element, name: str) -> list[ElementTree.Element]:
    return [node for node in html.iter() if name in node.get("class", "").split()]


def said(node: ElementTree.Element) -> str:
    return "".join(node.itertext())


def items(html: ElementTree.Element) -> list[str]:
    (head,) = classes(html, "head")
    return [said(item) for item in head]


def test_the_legend_names_what_is_there_and_nothing_else() -> None:
    before = drawn(moment(small_run()))
    assert items(before) == ["as it learns", "greedy", "forced exploration", "frozen", "planned"]
    run = to(small_run(), 400)
    run.apply(FreezeSelection(True))
    ghost = Ghost(
        "the run before", "seed 3", learned([9], [1]), learned([9], [1]), seen(run).progress
    )
    after = drawn(moment(run, ghost=ghost, left_out=3))
    assert items(after) == [
        "as it learns",
        "greedy",
        "the run before",
        "forced exploration",
        "frozen",
        "by hand",
        "3 earlier changes not drawn",
    ]


def test_each_curve_is_a_line_and_far_dots_are_joined_by_a_dashed_one() -> None:
    greedy = greedy_curve((100, 2_000, 4), (200, 4_000, 40), (300, 6_000, 50))
    html = drawn(moment(to(small_run(), 400), greedy=greedy))
    assert len(classes(html, "learned")) == 2, "in the legend and as a line"
    (dots,) = classes(html, "dots")
    assert dots.get("d", "").count("h0") == 3
    assert classes(html, "far") == []
    shot = seen(to(small_run(), 400))
    bar = bar_of(Moment(shot, blocks_of(shot), greedy=greedy), "trials", greedy_every=40)
    assert 'class="greedy far"' in bar_html(bar, str)


def test_what_lies_ahead_is_a_link_that_chooses_it_and_the_past_is_not() -> None:
    html = drawn(moment(to(small_run(), 130), chosen=AVOIDING))
    links = [node for node in html.iter("a") if "piece" in node.get("class", "")]
    assert sorted(node.get("href", "") for node in links) == [
        "call/plan/episode:1:avoid",
        "call/plan/episode:2:approach",
        "call/plan/introduction:avoid",
    ]
    assert [node.get("href") for node in classes(html, "chosen")] == [f"call/plan/{AVOIDING}"]
    pasts = [node for node in classes(html, "piece") if node.tag != "a"]
    assert len(pasts) == 3


def test_the_axis_says_what_it_is_of_and_offers_the_other() -> None:
    for unit, other in (("trials", "steps"), ("steps", "trials")):
        html = drawn(moment(to(small_run(), 130)), unit)
        (axis,) = classes(html, "axis")
        assert [node.get("href") for node in axis.iter("a")] == [f"call/axis/{other}"]
    (here,) = classes(drawn(moment(to(small_run(), 130))), "here")
    assert (said(here), here.get("style")) == ("130", "left:26%")


def test_no_number_of_the_axis_is_covered_by_that_of_the_playhead() -> None:
    (axis,) = classes(drawn(moment(to(small_run(), 101))), "axis")
    numbers = [said(node) for node in axis.iter("span")]
    assert "100" not in numbers
    assert "200" in numbers


@settings(deadline=None)
@given(
    script=st.lists(st.tuples(st.integers(0, 800), commands), max_size=20),
    unit=st.sampled_from(["trials", "steps"]),
)
def test_whatever_was_done_can_be_drawn(script: list[tuple[int, Command]], unit: Axis) -> None:
    html = drawn(moment(driven(small_run(), script)), unit)
    for node in html.iter():
        for share in re.findall(r"(?:left|right|width|bottom):([-\d.]+)%", node.get("style", "")):
            assert 0 <= float(share) <= 100


def test_every_text_is_escaped() -> None:
    hostile = '</span><script>alert("x")</script>&\x00\ud800'
    shot = seen(small_run())
    learner = shot.spec.learner.model_copy(update={"options": ("approach", hostile)})
    shot = replace(shot, spec=shot.spec.model_copy(update={"learner": learner}))
    blocks = (Block("a", "exploration", hostile, 5, 50, "planned", probability=0.5),)
    ghost = Ghost(hostile, hostile, learned([9], [1]), learned([9], [1]), shot.progress)
    html = drawn(Moment(shot, blocks, chosen=hostile, ghost=ghost))
    assert list(html.iter("script")) == []
    assert any('<script>alert("x")</script>&' in node.get("title", "") for node in html.iter())


@pytest.mark.parametrize("n_skills", [1, 12])
@pytest.mark.parametrize("trials", [1, 100, 48_000, MAX_TRIALS])
def test_few_and_many_skills_and_trials_fit(n_skills: int, trials: int) -> None:
    names = [f"a_skill_of_ones_own_number_{k}" for k in range(n_skills)]
    spec = presets.load(
        "hierarchical_2",
        [
            "world.size=30",
            f"trials={trials}",
            f"learner.custom_skills={{{', '.join(f'{name}: {{approach: 1}}' for name in names)}}}",
            f"learner.options=[{', '.join(names)}]",
        ],
    )
    html = drawn(moment(Run(spec, 1)))
    assert len(classes(html, "lane")) == n_skills
    assert ("low" in html.get("class", "").split()) == (n_skills > 5)


def test_a_whole_run_is_sent_in_few_bytes() -> None:
    run = Run(presets.load("timed"), 3)
    run.advance(until_trial=48_000)
    shot = snapshot.take(run, "timed", 0)
    for unit in ("trials", "steps"):
        html = bar_html(bar_of(Moment(shot, Past().blocks_of(shot)), unit, 2_000), str)
        assert len(html) < 9_000
