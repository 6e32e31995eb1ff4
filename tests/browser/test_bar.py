"""The time bar in a real browser: what is drawn of a run, of a moment and of what a hand holds."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Frame, Locator, expect

import app
from app.analysis.estimates import Axis
from app.charts.bar.axis import axis_of
from app.live.requests import AddMark, Branch
from app.server.web_files import frame_document
from learners.commands import Introduce, SetParameter
from tests.support.live import LiveLab
from tests.support.screen import Begin, Screen, Shared, box_of

JOIN, EXPLORATION = "introduction:circle_clockwise", "episode:0:circle_clockwise"

_IMPORT = "const from = name => import(new URL(`../../web/time/${name}.js`, location.href));"
_STATE = f"""async () => {{
    {_IMPORT}
    const {{ state }} = await from("state");
    return {{ bar: state.bar, moment: state.moment }};
}}"""
_PLACES = f"""async ([trials, steps, shares]) => {{
    {_IMPORT}
    const {{ state }} = await from("state");
    const axis = await from("axis");
    const of = state.bar.axis;
    return {{
        trials: trials.map(trial => axis.shareOfTrial(of, trial)),
        steps: steps.map(step => axis.shareOfStep(of, step)),
        backTrials: shares.map(share => axis.trialAt(of, share)),
        backSteps: shares.map(share => axis.stepAt(of, share)),
    }};
}}"""
_TAKE = f"""async ([what, frames]) => {{
    {_IMPORT}
    const {{ state, changed }} = await from("state");
    Object.assign(state, what);
    changed();
    for (let drawn = 0; drawn < frames; drawn += 1) await new Promise(requestAnimationFrame);
}}"""
"""Shows another state, and waits until it is drawn."""
_MOVED = f"""async trials => {{
    {_IMPORT}
    const {{ state, changed }} = await from("state");
    const made = [];
    const watch = new MutationObserver(all => made.push(...all));
    const frame = () => new Promise(requestAnimationFrame);
    const {{ moment }} = state;
    state.moment = {{ ...moment, live: false }};
    changed();
    await frame();
    await frame();
    watch.observe(document.querySelector(".rows"), {{ childList: true, subtree: true }});
    for (const trial of trials) {{
        state.moment = {{ ...moment, live: false, trial }};
        changed();
        await frame();
        await frame();
    }}
    state.moment = moment;
    changed();
    const rows = made.filter(({{ target }}) => !target.closest?.(".handle, .here"));
    return rows.map(({{ target }}) => target.className);
}}"""


@pytest.fixture
def begin(begin: Begin) -> Begin:
    """As elsewhere, and the bar is that of where the run stands, not of one on its way there."""

    def begin_with_bar(*run: str, **how: Any) -> Shared:
        shared = begin(*run, **how)
        now = shared.live.session.status.snapshot
        shared.screen.expect_line(now.generation, now.step)
        return shared

    return begin_with_bar


def show(page: Frame, **what: Any) -> None:
    """Show another state than the lab's."""
    page.evaluate(_TAKE, [what, 2])


def piece(screen: Screen, id: str) -> Locator:
    return screen.time.locator(f'.piece[data-id="{id}"]')


def middle(part: Locator) -> float:
    box = box_of(part)
    return box.left + box.width / 2


def look_at(screen: Screen, trial: int) -> None:
    """Look at the beginning of a trial of the past."""
    screen.tell("seek_trial", trial=trial)
    expect(screen.time.locator(".past .here")).to_have_text(f"{trial:,}")


def look_at_now(screen: Screen) -> None:
    """Look at what is live."""
    screen.tell("live")
    expect(screen.time.locator(".time:not(.past)")).to_be_attached()


def test_all_scripts_and_styles_of_the_frame_are_fetched_at_once() -> None:
    folder = Path(app.__file__).parent / "web" / "time"
    html = frame_document("time").decode()
    scripts = set(re.findall(r'modulepreload" href="../../web/([\w./]+)"', html))
    own = {f"time/{path.name}" for path in folder.glob("*.js")}
    assert scripts == {*own, "player/pipe.js", "player/drawing.js"}
    styles = {style.name for style in folder.glob("*.css")}
    assert set(re.findall(r'stylesheet" href="../../web/time/([\w.]+)"', html)) == styles


def test_curves_and_lanes_share_an_axis(begin: Begin) -> None:
    live, screen = begin("timed", "trials=1000", trial=500)
    live.ask(Introduce("circle_clockwise", 100))
    live.go_to_trial(1_000)
    bar = screen.time
    # A dot at the end of the run, and only there, since it has fewer than 2,000 trials.
    dots = bar.locator("path.dots")
    expect(dots).to_have_attribute("d", re.compile(r"^M1000\.0 [\d.]+h0$"))
    # Two windows of trials, the first of them level.
    line = bar.locator("path.learned")
    expect(line).to_have_attribute("d", re.compile(r"^M0\.0 [\d.]+L500\.0 [\d.]+L1000\.0 "))
    expect(bar.locator(".lane").get_by_text("joined at 500")).to_be_visible()
    expect(bar.locator("path.ghost")).to_be_attached()
    expect(bar.locator(".legend").get_by_text("the preset's own run")).to_be_visible()
    steps = bar.get_by_role("button", name="steps", exact=True)
    trial = bar.get_by_role("button", name="trial", exact=True)
    expect(trial).to_have_attribute("aria-pressed", "true")
    steps.click()
    expect(steps).to_have_attribute("aria-pressed", "true")
    expect(bar.locator(".handle")).to_have_text(re.compile(r"^[\d.]+ [kM]$"))
    trial.click()
    expect(trial).to_have_attribute("aria-pressed", "true")


def test_both_sides_know_the_same_axis(begin: Begin) -> None:
    live, screen = begin("timed", "trials=1000", trial=700)
    run = live.session.status.snapshot
    trials, shares = [0, 1, 100, 333, 699, 700, 900, 5_000], [-1.0, 0.0, 0.25, 0.5, 1.0, 7.0]
    steps = [0, 1, run.step // 3, run.step]
    units: tuple[tuple[Axis, str], ...] = (("trials", "trial"), ("steps", "steps"))
    for unit, name in units:
        button = screen.time.get_by_role("button", name=name, exact=True)
        button.click()
        expect(button).to_have_attribute("aria-pressed", "true")
        found = screen.time_page.evaluate(_PLACES, [trials, steps, shares])
        axis = axis_of(live.session.status.snapshot, unit)
        assert found["trials"] == pytest.approx([axis.of_trial(trial) for trial in trials])
        assert found["steps"][:3] == pytest.approx(axis.of_steps(np.array(steps[:3])))
        # There and back again.
        again = screen.time_page.evaluate(_PLACES, [found["backTrials"], found["backSteps"], []])
        within = [min(max(share, 0.0), 1.0) for share in shares]
        assert again["trials"] == pytest.approx(within, abs=1 / 1_000)
        assert again["steps"] == pytest.approx(within, abs=1 / 1_000)
    screen.time.get_by_role("button", name="trial", exact=True).click()


def test_what_has_the_focus_keeps_it_while_the_bar_goes_on(begin: Begin) -> None:
    live, screen = begin(trial=100)
    avoid = piece(screen, "introduction:avoid")
    avoid.focus()
    live.go_to_trial(110)
    expect(screen.time.locator(".handle")).to_have_text("110")
    expect(avoid).to_be_focused()
    label = re.compile("^avoid joins at trial 14,500")
    expect(screen.time.get_by_role("slider", name=label)).to_be_focused()


def test_only_what_moves_is_touched_when_another_moment_is_shown(begin: Begin) -> None:
    _, screen = begin("timed", "trials=1000", trial=500)
    assert screen.time_page.evaluate(_MOVED, [400, 300, 7, 499, 20]) == []


def test_the_past_is_paler_after_the_moment_that_is_shown_and_live_has_its_mark(
    begin: Begin,
) -> None:
    live, screen = begin("timed", "trials=1000", trial=500)
    bar = screen.time
    expect(bar.locator(".veil, .live-end")).to_have_count(2)
    expect(bar.locator(".veil")).to_be_hidden()
    look_at(screen, 200)
    handle = bar.get_by_role("slider", name="Moment that is shown")
    told = "trial 200, 300 trials behind the live run"
    expect(handle).to_have_attribute("aria-valuetext", told)
    expect(bar.locator(".veil")).to_be_visible()
    box, veil = box_of(bar.locator(".axis .plot")), box_of(bar.locator(".veil"))
    assert (veil.left - box.left) / box.width == pytest.approx(0.2, abs=0.01)
    assert veil.width / box.width == pytest.approx(0.3, abs=0.01)
    back = bar.locator(".live-end").get_by_role("button", name="Live")
    assert (middle(back) - box.left) / box.width == pytest.approx(0.5, abs=0.01)
    size = box_of(handle)
    assert min(size.width, size.height) >= 24
    back.click()
    expect(bar.locator(".veil")).to_be_hidden()
    expect(handle).to_have_attribute("aria-valuetext", "trial 500, live")
    assert live.session.status.snapshot.trial == 500


def test_what_has_begun_where_one_looks_is_locked_and_says_so(begin: Begin) -> None:
    settings = ("trials=1000", "schedule.skills.circle_clockwise.at=300")
    _, screen = begin("timed", *settings, trial=500)
    joined = screen.time.get_by_role("img", name=re.compile("^circle clockwise joins at trial 300"))
    expect(joined).to_have_class(re.compile(r"\blocked\b"))
    expect(joined).to_have_attribute("title", re.compile("It has begun, so it is locked"))
    tip = screen.time.locator("#tip")
    joined.focus()
    screen.page.keyboard.press("Shift+Tab")
    screen.page.keyboard.press("Tab")
    expect(tip).to_have_text(re.compile("It has begun, so it is locked"))
    look_at(screen, 100)
    free = piece(screen, JOIN)
    expect(free).to_have_attribute("data-editable", "")
    expect(free).to_have_attribute("aria-valuetext", "trial 300")
    expect(free).to_have_role("slider")
    look_at(screen, 301)
    expect(joined).to_have_class(re.compile(r"\blocked\b"))
    look_at_now(screen)


def test_a_block_in_a_hand_is_drawn_where_it_is_held_and_where_it_was(begin: Begin) -> None:
    live, screen = begin(trial=100)
    page, block = screen.time_page, piece(screen, JOIN)
    bound = piece(screen, EXPLORATION)
    was = block.element_handle()
    before = middle(bound)
    show(page, draft={"id": JOIN, "at": 24_000}, held=True)
    lane = screen.time.locator('.lane[data-skill="circle_clockwise"]')
    expect(lane.locator(".number")).to_have_text(["24,000"])
    expect(lane.locator(".piece.was")).to_have_count(2)
    # Its exploration goes with it, and what was said of both is not said meanwhile.
    assert middle(bound) > before + 100
    expect(lane.locator(".label")).to_have_count(0)
    # Whatever the lab sends meanwhile, it is in the hand.
    live.go_to_trial(105)
    expect(screen.time.locator(".handle")).to_have_text("105")
    expect(lane.locator(".number")).to_have_text(["24,000"])
    assert page.evaluate("node => node.isConnected", was)
    show(page, draft={"id": EXPLORATION, "trials": 9_000, "probability": 0.4})
    expect(lane.locator(".number")).to_have_text(["12,000", "21,000", "40%"])
    show(page, draft=None, held=False)
    expect(lane.locator(".piece.was")).to_have_count(0)
    expect(lane.locator(".number")).to_have_count(0)
    assert page.evaluate("node => node.isConnected", was)
    assert middle(bound) == pytest.approx(before, abs=2)


def test_a_playhead_in_a_hand_is_drawn_there(begin: Begin) -> None:
    _, screen = begin("timed", "trials=1000", trial=500)
    page = screen.time_page
    step = page.evaluate(_STATE)["moment"]["step"]
    show(page, scrub={"trial": 250, "step": step // 2})
    expect(screen.time.locator(".past .here")).to_have_text("250")
    show(page, scrub=None)
    expect(screen.time.locator(".time:not(.past) .here")).to_have_text("500")


def test_a_and_a_loop_are_a_bracket(begin: Begin) -> None:
    _, screen = begin("timed", "trials=1000", trial=500)
    page, between = screen.time_page, screen.time.locator(".between")
    moment = page.evaluate(_STATE)["moment"]
    a, b = ({"trial": trial, "step": moment["step"]} for trial in (100, 300))
    expect(between).to_be_hidden()
    show(page, moment={**moment, "a": a})
    expect(between.locator("b:visible")).to_have_text(["A"])
    show(page, moment={**moment, "a": a, "loop": {"a": a, "b": b}})
    expect(between.locator("b:visible")).to_have_text(["A", "B"])
    plot, bracket = box_of(screen.time.locator(".axis .plot")), box_of(between)
    assert (bracket.left - plot.left) / plot.width == pytest.approx(0.1, abs=0.01)
    assert bracket.width / plot.width == pytest.approx(0.2, abs=0.01)
    show(page, moment=moment)


def branched(live: LiveLab, trial: int) -> int:
    """A branch at a trial of the live run; its number."""
    known = {seen.number for seen in live.session.status.lines}
    live.ask(Branch(live.place_of(trial), SetParameter("learner.epsilon", 0.2)))
    status = live.wait_for(lambda status: {seen.number for seen in status.lines} != known)
    (number,) = {seen.number for seen in status.lines} - known
    return number


def test_lines_are_a_tree_above_the_lanes_once_there_are_several(begin: Begin) -> None:
    live, screen = begin("timed", "trials=1000", trial=500)
    rows = screen.time.locator(".tree .line")
    expect(rows).to_have_count(0)
    line = live.session.status.snapshot.generation
    first, second = branched(live, 200), branched(live, 400)
    expect(rows).to_have_count(3)
    names = [screen.time.locator(f'.line[data-line="{n}"]') for n in (line, second, first)]
    tops = [box_of(row).top for row in names]
    assert tops == sorted(tops)
    expect(names[0]).to_have_attribute("aria-current", "true")
    expect(names[0].locator(".tag")).to_be_visible()
    expect(names[1].locator(".tag")).to_be_hidden()
    expect(names[1]).to_have_attribute("aria-label", re.compile("branched off at trial 400"))
    plot, fork = box_of(screen.time.locator(".axis .plot")), box_of(names[2].locator(".fork"))
    assert (fork.left - plot.left) / plot.width == pytest.approx(0.2, abs=0.01)
    screen.tell("look", line=first)
    expect(names[2]).to_have_attribute("aria-current", "true")
    expect(names[0]).not_to_have_attribute("aria-current", "true")
    look_at_now(screen)


def test_events_are_signs_of_a_kind_and_a_mark_has_its_text(begin: Begin) -> None:
    settings = ("trials=1000", "schedule.skills.circle_clockwise={at: 300, freeze: 20}")
    live, screen = begin("timed", *settings, trial=500)
    live.ask(AddMark(live.place_of(400), "the ring closes"))
    note = screen.time.locator(".mark.note")
    expect(note).to_have_text("the ring closes")
    expect(note).to_have_attribute("title", "trial 400: the ring closes")
    events = screen.time.locator(".event")
    expect(screen.time.locator('.event[data-kind="mark"]')).to_have_count(1)
    joins = screen.time.locator('.event[data-kind="join"]')
    expect(joins).to_have_attribute("aria-label", re.compile("circle clockwise joins.*: go there$"))
    steps = [int(event.get_attribute("data-step") or -1) for event in events.all()]
    assert live.place_of(300).step in steps


def test_the_bar_takes_the_room_that_the_stage_keeps_for_it(begin: Begin) -> None:
    _, screen = begin(trial=100)
    screen.time.locator(".lane").first.wait_for()
    screen.rest()
    height = box_of(screen.page.locator("iframe.pounce-time")).height
    assert height <= 225
    expect(screen.page.locator("iframe.pounce-time")).to_be_in_viewport(ratio=0.98)
    assert height == screen.time_page.evaluate(
        "() => Math.ceil(document.body.getBoundingClientRect().height)"
    )
