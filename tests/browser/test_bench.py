"""The lab bench in a real browser: layers, inspection, steering, files, keys."""

import io
import math
import re
from html import unescape
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Locator, expect

from app.documents import presets
from app.explain import cell
from app.explain.cell import OUTCOME_NAMES
from app.explain.cell_html import reading_html
from app.explain.chain import action_text, chain_of, ending_text, sum_text
from app.live.requests import OpenRun, StartAgain, StepOnce
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page import number_field, widgets
from app.page.keys import list_html
from app.page.panels import steering
from app.page.panels.transport import slider_of
from app.picture.layer import Extras, Layer, SuccessMap
from app.picture.layers import LAYERS
from app.picture.look import ALL, OF_TRIAL, Look
from app.picture.multiples import SIDE
from app.words.plain import HEADING_NAMES
from learners import hunts
from learners.commands import (
    DefineSkill,
    Explore,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Remove,
    SetParameter,
)
from learners.skill_spec import SkillWeights
from sim.world import CAPTURE, FLIGHT, TIMEOUT
from tests.support.live import LiveLab, preset_of
from tests.support.screen import TWO_FRAMES, Begin, Screen, arriving

LEARNED = 1_000
"""Trials after which two skills know enough of the small world for each layer to differ."""
HOSTILE = "<img src=x onerror=alert(1)>"

SHOWN = """name => window.__viserSceneTree.getState()[name].effectiveVisibility"""
IS_SHOWN = """([name, shown]) =>
    window.__viserSceneTree.getState()[name].effectiveVisibility === shown"""
HAS_POINTS = """([name, count]) =>
    window.__viserSceneTree.getState()[name].message.props.points.length === 3 * count"""
TRAIL_IS = """place => {
    const { points } = window.__viserSceneTree.getState()["/board/trail"].message.props;
    return (points[2] > -1 ? "on the board" : "away") === place;
}"""
CAMERA = "() => window.__viserMutable.camera.position.toArray()"
TELL_NOTHING_OF_THE_CAMERA = """() => {
    const { sendMessage } = window.__viserMutable;
    window.tellAll = () => { window.__viserMutable.sendMessage = sendMessage; };
    window.__viserMutable.sendMessage = message => {
        if (message.type !== "ViewerCameraMessage") sendMessage(message);
    };
}"""
TELL_ALL = "() => window.tellAll()"
CAMERA_IS = """([place, near]) => {
    const now = window.__viserMutable.camera.position.toArray();
    return near === (Math.hypot(...now.map((part, i) => part - place[i])) < 0.05);
}"""


# What is asked of a lab, and of a page ------------------------------------------------------


def now_of(live: LiveLab) -> Snapshot:
    """The moment that a lab is at."""
    return live.session.status.snapshot


def by_hand(status: Status) -> list[Any]:
    """Commands given by hand so far."""
    return [event.command for event in status.snapshot.control.history if event.author == "hand"]


def words(html: str) -> str:
    """What a piece of HTML says."""
    return " ".join(unescape(re.sub(r"<[^>]*>", "", html)).split())


def success_of(snapshot: Snapshot) -> Extras:
    """Where hunts from each cell end."""
    policy = hunts.greedy_moves(snapshot.selection_q, snapshot.skill_q)
    outcomes = hunts.success_map(snapshot.world, policy, snapshot.seed)
    assert outcomes is not None
    return Extras(SuccessMap(outcomes, snapshot.trial, snapshot.generation))


def expect_layer(screen: Screen, live: LiveLab, layer: Layer, extras: Extras) -> np.ndarray:
    """Wait until a page shows a layer with its words; returns its colours."""
    snapshot = now_of(live)
    look = layer.heeded(Look(layer=layer.key), snapshot.spec.learner)
    colours = layer.paint(snapshot, look, extras).colours
    screen.expect_cell_colours(colours)
    assert live.look_of() == look
    expect(screen.field("Layer")).to_have_value(layer.title)
    expect(screen.legend.locator("xpath=..")).to_have_text(
        words(layer.legend(snapshot, look, extras))
    )
    expect(screen.page.get_by_text(words(layer.caption(snapshot, look, extras)))).to_be_visible()
    return colours


def labelled(screen: Screen, label: str) -> Locator:
    """The slider with this label, and its number."""
    name = screen.page.locator("label").get_by_text(label, exact=True)
    return screen.page.locator(f"[id='{name.get_attribute('for')}']").locator("xpath=..")


def drag(screen: Screen, slider: Locator, steps: int = 12) -> None:
    """Take a slider's handle and pull it to the right, in many small moves."""
    box = slider.get_by_role("slider").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    screen.page.mouse.move(x, y)
    screen.page.mouse.down()
    screen.page.mouse.move(x + 50, y, steps=steps)
    screen.page.mouse.up()
    # A slider takes the last move when the next frame is drawn.
    screen.page.evaluate(TWO_FRAMES)


def cell_number(live: LiveLab, x: int, y: int) -> int:
    """Place of a cell among the board's points."""
    return y * now_of(live).spec.world.size + x


def click_cell(screen: Screen, live: LiveLab, x: int, y: int) -> None:
    """Click a cell of the board."""
    screen.page.mouse.click(*screen.place_of(cell_number(live, x, y)))


def test_each_layer_by_its_key_and_from_the_list(begin: Begin) -> None:
    live, screen = begin("hierarchical_2", trial=LEARNED)
    extras = success_of(now_of(live))
    seen: list[bytes] = []
    keys = "1234567890"
    # Those after the first ten have no key.
    for key, layer in zip(keys, LAYERS.values(), strict=False):
        screen.page.keyboard.press(key)
        seen.append(expect_layer(screen, live, layer, extras).tobytes())
    assert len(set(seen)) == len(keys)
    screen.choose("Layer", "Value of one option")
    expect_layer(screen, live, LAYERS["option"], extras)
    screen.choose("of", "circle clockwise")
    screen.expect_cell_colours(live.colours(Look(layer="option", option=1)))
    expect(screen.legend.locator("xpath=..")).to_contain_text("circle clockwise")
    screen.choose("of", "approach")
    screen.choose("Layer", "State value")


def test_the_success_map_is_of_the_moment_though_the_learner_stands_still(begin: Begin) -> None:
    live, screen = begin("hierarchical_2", trial=LEARNED)
    layer = LAYERS["success"]
    screen.choose("Layer", layer.title)
    seeing = expect_layer(screen, live, layer, success_of(now_of(live)))
    live.ask(SetParameter("world.vision_radius", 0.0))
    blind = expect_layer(screen, live, layer, success_of(now_of(live)))
    assert not np.array_equal(blind, seeing)
    screen.choose("Layer", "State value")


def test_frames_all_headings_and_overlays(begin: Begin) -> None:
    live, screen = begin("hierarchical_2", trial=LEARNED)
    live.ask(StepOnce())
    home = screen.page.evaluate(CAMERA)
    screen.turn_to_overlays()
    # A segment out of sight stands for none.
    for trail, place in [(True, "on the board"), (False, "away")]:
        screen.check("Trail", trail)
        screen.page.wait_for_function(TRAIL_IS, arg=place)
        assert live.look_of().trail is trail
    for name, frame in [("Prey faces north", 2), ("As in the running trial", OF_TRIAL)]:
        screen.choose("Headings", name)
        screen.expect_cell_colours(live.colours(Look(frame=frame)))
        assert live.look_of().frame == frame

    screen.choose("Headings", "All headings, side by side")
    screen.expect_cell_colours(live.colours(Look(frame=ALL)))
    # They are as wide as the board, but not as high, so that they are seen from nearer.
    screen.page.wait_for_function(CAMERA_IS, arg=[home, False])
    screen.page.mouse.click(*screen.place_of(2 * SIDE**2 + SIDE * 15 + SIDE // 2))
    screen.expect_cell_colours(live.colours(Look(frame=2)))
    expect(screen.field("Headings")).to_have_value("Prey faces north")
    screen.click("Back to all")
    screen.expect_cell_colours(live.colours(Look(frame=ALL)))
    expect(screen.button("Back to all")).to_be_hidden()
    screen.choose("Headings", "All as one, prey looks right")
    screen.expect_cell_colours(live.colours(Look(trail=False)))
    screen.page.wait_for_function(CAMERA_IS, arg=[home, True])

    overlays = {
        "Visual field": "field",
        "Grid lines": "grid",
        "Sensor rings": "sensors",
        "Start zone": "start_zone",
        "Last 20 paths": "paths",
    }
    drawn = {name: f"/board/{name}" for name in overlays.values()}
    first = {name: bool(screen.page.evaluate(SHOWN, node)) for name, node in drawn.items()}
    for wanted in ({name: not shown for name, shown in first.items()}, first):
        for label, name in overlays.items():
            screen.check(label, wanted[name])
        for name, node in drawn.items():
            screen.page.wait_for_function(IS_SHOWN, arg=[node, wanted[name]])
            assert getattr(live.look_of(), name) is wanted[name]

    screen.check("Trail")


# Inspection ---------------------------------------------------------------------------------


def test_a_click_inspects_a_cell_and_says_why_it_is_worth_that(begin: Begin) -> None:
    live, screen = begin("hierarchical_2", trial=LEARNED)
    snapshot = now_of(live)
    for x, y in [(14, 20), (23, 31)]:
        click_cell(screen, live, x, y)
        reading = cell.reading_at(snapshot, x, y, heading=0)
        title = screen.page.get_by_text(f"Cell ({x}, {y})", exact=True)
        expect(title.locator("xpath=../..")).to_have_text(words(reading_html(reading, Look())))
        expect(screen.button("Hunt here")).to_be_enabled()

    click_cell(screen, live, 14, 20)
    screen.check("Why this value?")
    chain = chain_of(snapshot, 14, 20, heading=0)
    assert chain.ending == "capture"
    expect(screen.text(ending_text(chain))).to_be_visible()
    first = chain.links[0]
    expect(screen.page.get_by_role("listitem").first).to_have_text(
        f"{action_text(first)}: {sum_text(first)}"
    )
    # Every other step of it, in a world this small.
    lines = ["/inspect/chain/line", 2 * (1 + len(chain.cells) // 2)]
    screen.page.wait_for_function(HAS_POINTS, arg=lines)
    screen.check("Why this value?", False)
    screen.page.wait_for_function(HAS_POINTS, arg=["/inspect/chain/line", 2])
    expect(screen.text(ending_text(chain))).to_have_count(0)


def test_shift_click_hunts_and_so_do_sixteen_from_a_ring(begin: Begin) -> None:
    live, screen = begin("hierarchical_2", trial=LEARNED)
    screen.turn_to("Inspect")
    before = now_of(live)
    screen.page.keyboard.down("Shift")
    click_cell(screen, live, 14, 20)
    screen.page.keyboard.up("Shift")
    (shown,) = cell.hunts_from(before, [(14, 20)], heading=0)
    expect(screen.text("from (14, 20), prey facing east:")).to_contain_text(
        f"{OUTCOME_NAMES[shown.hunt.outcome]} after {shown.hunt.steps} step"
    )
    assert screen.reads("Cell (14, 20)")
    screen.page.wait_for_function(HAS_POINTS, arg=["/inspect/ends", 2])

    screen.choose("Prey faces", HEADING_NAMES[2])
    screen.click("Hunt here")
    assert screen.reads("from (14, 20), prey facing north:")
    screen.page.wait_for_function(HAS_POINTS, arg=["/inspect/ends", 3])

    screen.click("Sixteen hunts from a ring")
    counts = screen.text("16 hunts").locator("xpath=..")
    expect(counts).to_be_visible()
    plural = {CAPTURE: "captures?", FLIGHT: "flights?", TIMEOUT: "time-outs?"}
    said = [
        re.search(rf"(\d+) {name}", counts.inner_text().replace("16 hunts", ""))
        for name in plural.values()
    ]
    assert sum(int(found[1]) for found in said if found) == 16
    screen.page.wait_for_function(HAS_POINTS, arg=["/inspect/ends", 17])

    screen.click("Clear")
    assert screen.reads("Click a cell")
    screen.page.wait_for_function(HAS_POINTS, arg=["/inspect/ends", 1])
    # Hunts teach nothing.
    assert now_of(live) is before


# Steering -----------------------------------------------------------------------------------


def test_a_drag_is_one_change_that_can_be_undone(
    begin: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    # It rests when that is said here: no machine is too slow to make the moves of one drag.
    monkeypatch.setattr(number_field, "_SLIDER_REST_S", math.inf)
    live, screen = begin("hierarchical_2", trial=LEARNED)
    former = now_of(live).spec.learner.epsilon
    screen.turn_to("Steer")
    assert screen.reads("Nothing has been changed by hand.")
    expect(screen.button("Undo")).to_be_disabled()
    slider = labelled(screen, "Exploration ε")
    drag(screen, slider)
    dragged_to = float(slider.get_by_role("slider").get_attribute("aria-valuenow") or 0)
    assert dragged_to > former
    number = screen.field("Exploration ε as a number")
    expect(number).to_have_value(f"{dragged_to:g}")
    assert by_hand(live.ask()) == []
    monkeypatch.setattr(number_field, "_SLIDER_REST_S", 0.0)
    live.lab.inbox.put(lambda: None)
    status = live.wait_for(lambda status: status.snapshot.spec.learner.epsilon != former)
    epsilon = status.snapshot.spec.learner.epsilon
    assert by_hand(status) == [SetParameter("learner.epsilon", epsilon)]
    assert epsilon == pytest.approx(dragged_to)
    change = screen.text(f"1: Exploration ε = {epsilon:g}, trial {LEARNED:,}")
    expect(change).to_be_visible()

    screen.click("Undo")
    status = live.wait_for(lambda status: status.snapshot.spec.learner.epsilon == former)
    assert status.snapshot.control.history[-2].undone
    expect(number).to_have_value(f"{former:g}")
    expect(change).to_have_css("text-decoration-line", "line-through")
    expect(screen.button("Undo")).to_be_disabled()
    assert len(by_hand(status)) == 2


def test_parameters_of_the_world_can_be_typed_and_undone_in_any_order(begin: Begin) -> None:
    live, screen = begin("hierarchical_2", trial=LEARNED)
    start = now_of(live).spec
    screen.turn_to("Steer")
    screen.fill("Vision radius as a number", "12")
    live.wait_for(lambda status: status.snapshot.spec.world.vision_radius == 12)
    screen.fill("Capture reward as a number", "150")
    live.wait_for(lambda status: status.snapshot.spec.world.capture_reward == 150)
    assert screen.reads(f"2: Capture reward = 150, trial {LEARNED:,}")
    expect(screen.field("Take back")).to_have_value("2: Capture reward = 150")
    screen.choose("Take back", "1: Vision radius = 12")
    screen.click("Undo")
    status = live.wait_for(lambda status: status.snapshot.spec.world.vision_radius != 12)
    world = status.snapshot.spec.world
    assert (world.vision_radius, world.capture_reward) == (start.world.vision_radius, 150)


def open_other_skills(screen: Screen) -> None:
    """Unfold the folder about further skills."""
    screen.turn_to("Steer")
    screen.unfold("Other skills", screen.button("Add my own skill now"))


def test_a_skill_of_ones_own_and_another_skill(begin: Begin) -> None:
    live, screen = begin("hierarchical_2", trial=LEARNED)
    before = now_of(live)
    open_other_skills(screen)
    own = screen.button("Add my own skill now")
    name = live.widget("Own skill")
    with arriving(name):
        screen.fill("Own skill", HOSTILE)
    own.click()
    assert screen.reads(f"'{HOSTILE}' is not allowed; allowed: a name of")
    with arriving(name):
        screen.fill("Own skill", "sneak")
    own.click()
    assert screen.reads("all weights are 0")
    assert now_of(live) is before

    for skill, weight in [("approach", "1.5"), ("avoid", "-0.5")]:
        screen.fill(f"× {skill} as a number", weight)
    own.click()
    status = live.wait_for(lambda status: "sneak" in status.snapshot.present)
    weights = SkillWeights(approach=1.5, avoid=-0.5)
    assert by_hand(status) == [DefineSkill("sneak", weights), Introduce("sneak", 300)]
    assert status.snapshot.spec.learner.custom_skills == {"sneak": weights}
    assert screen.reads(f"sneak added, trial {LEARNED:,}")

    other = screen.field("Skill").locator("visible=true")
    other.click()
    screen.page.get_by_role("option", name="circle counterclockwise", exact=True).click()
    screen.click("Add this skill now")
    status = live.wait_for(lambda status: "circle_counterclockwise" in status.snapshot.present)
    assert by_hand(status)[-1] == Introduce("circle_counterclockwise", 300)
    screen.turn_to("Run")
    expect(screen.text("sneak: new, practised until")).to_have_count(0)
    assert screen.reads("sneak: active")
    expect(
        screen.text(f"circle counterclockwise: new, practised until trial {LEARNED + 300:,}")
    ).to_be_visible()


def test_removing_a_skill_asks_first_and_can_be_undone(begin: Begin) -> None:
    live, screen = begin("hierarchical_2", trial=LEARNED)
    before = now_of(live)
    open_other_skills(screen)
    screen.choose("To remove", "circle clockwise")
    screen.click("Remove this skill …")
    dialog = screen.page.get_by_role("dialog")
    expect(dialog).to_contain_text("Remove circle clockwise?")
    expect(dialog).to_contain_text(steering.loss_of(before, "circle_clockwise"))
    screen.click("Keep it")
    expect(dialog).to_have_count(0)
    assert now_of(live) is before

    screen.click("Remove this skill …")
    screen.click("Remove circle clockwise")
    status = live.wait_for(lambda status: status.snapshot.present == ("approach",))
    assert by_hand(status) == [Remove("circle_clockwise")]
    expect(dialog).to_have_count(0)
    expect(screen.button("Remove this skill …")).to_be_disabled()

    screen.click("Undo")
    status = live.wait_for(lambda status: len(status.snapshot.present) == 2)
    assert status.snapshot.present == before.present
    np.testing.assert_array_equal(status.snapshot.selection_q, before.selection_q)


# Files --------------------------------------------------------------------------------------


def expect_saved_state(screen: Screen, snapshot: Snapshot) -> None:
    """Save the state, and find its tables in the file."""
    name = f"timed-seed{snapshot.seed}-trial{snapshot.trial}.npz"
    with screen.page.expect_download() as download:
        screen.click("Save tables")
    assert download.value.suggested_filename == name
    content = io.BytesIO(download.value.path().read_bytes())
    with np.load(content, allow_pickle=False) as tables:
        present = np.isfinite(snapshot.selection_q)
        np.testing.assert_array_equal(np.isnan(tables["selection_q"]), ~present)
        saved = tables["selection_q"][present]
        np.testing.assert_array_equal(saved, snapshot.selection_q[present])
        np.testing.assert_array_equal(tables["skill_q"], snapshot.skill_q)
        assert (tables["trial"], tables["step"]) == (snapshot.trial, snapshot.step)


def test_a_preset_is_saved_and_loaded_and_a_wrong_one_refused(begin: Begin) -> None:
    live, screen = begin(trial=100)
    live.ask(SetParameter("learner.epsilon", 0.2))
    before = now_of(live)
    screen.turn_to("File")
    screen.fill("Name", "../mine")
    expect(screen.button("Save as preset")).to_be_disabled()
    screen.fill("Name", "mine")
    expect(screen.button("Save as preset")).to_be_enabled()
    with screen.page.expect_download() as download:
        screen.click("Save as preset")
    assert download.value.suggested_filename == "mine.yaml"
    text = download.value.path().read_text()
    saved = presets.parse(text, "mine.yaml")
    assert saved.schedule == before.spec.schedule
    assert saved.learner.epsilon == 0.2
    assert screen.reads("Exploration ε was set to 0.2 at trial 100")
    expect_saved_state(screen, before)

    screen.upload(
        "Load preset", "wrong.yaml", f"learner: {{epsilon: 4, gamma: '{HOSTILE}'}}\ntrials: 0\n"
    )
    dialog = screen.page.get_by_role("dialog")
    expect(dialog).to_contain_text("This preset cannot be used; nothing has changed")
    for problem in ("learner.epsilon: value 4", "learner.gamma", HOSTILE, "trials: value 0"):
        expect(dialog).to_contain_text(problem)
    dialog.get_by_role("button", name="Close", exact=True).click()
    assert now_of(live) is before

    screen.upload("Load preset", "mine.yaml", text)
    taken = live.wait_for(lambda s: s.snapshot.generation == before.generation + 1).snapshot
    assert (taken.preset, taken.seed, taken.step) == ("mine", before.seed, 0)
    assert taken.spec == saved
    assert screen.reads("mine is loaded, and is in the list under Start again.")
    assert not live.session.status.playing
    expect(screen.field("Preset")).to_have_value("mine")


def test_names_with_html_are_shown_as_text(begin: Begin) -> None:
    live, screen = begin("hierarchical_2")
    live.ask(StartAgain(preset_of("hierarchical_2"), HOSTILE, 5))
    expect(screen.field("Preset")).to_have_value(HOSTILE)
    expect(screen.headline).to_be_visible()
    expect(screen.page.locator("img[src='x']")).to_have_count(0)


def test_the_preset_shown_is_that_of_the_run_even_if_its_list_was_touched(
    begin: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    live, screen = begin("hierarchical_2")
    monkeypatch.setattr(widgets, "TOUCHED_S", math.inf)
    live.ask(StartAgain(preset_of("standard_q"), "standard_q", 5))
    expect(screen.headline).to_contain_text("Nine moves, no skills")
    expect(screen.field("Preset")).to_have_value("standard_q")


# Keys ---------------------------------------------------------------------------------------


def press(screen: Screen, live: LiveLab, key: str) -> Status:
    """Press a key, and wait until what it asks for has been answered."""
    answered = live.session.status.answered
    screen.page.keyboard.press(key)
    return live.wait_for(lambda status: status.answered > answered)


def test_keys_do_what_their_list_says(begin: Begin) -> None:
    live, screen = begin(trial=100)
    step = now_of(live).step
    stepped = press(screen, live, "s").snapshot
    assert stepped.step == step + 1
    status = press(screen, live, "t")
    assert (status.snapshot.trial, status.snapshot.trial_step) == (stepped.trial + 1, 0)

    place = slider_of(status.speed)
    assert slider_of(press(screen, live, "j").speed) == pytest.approx(place - 0.5)
    assert slider_of(press(screen, live, "k").speed) == pytest.approx(place)

    assert press(screen, live, "n").snapshot.present == ("approach", "circle_clockwise")
    episodes = press(screen, live, "e").snapshot.control.episodes
    assert ("approach", 0.5) in [(episode.skill, episode.probability) for episode in episodes]
    assert press(screen, live, "f").snapshot.control.selection_frozen
    expect(screen.checkbox("Freeze selection")).to_be_checked()
    assert not press(screen, live, "f").snapshot.control.selection_frozen
    expect(screen.checkbox("Freeze selection")).not_to_be_checked()

    screen.page.keyboard.press("h")
    dialog = screen.page.get_by_role("dialog")
    expect(dialog).to_contain_text("freeze the selection, or let it learn")
    expect(dialog.get_by_role("row")).to_have_count(list_html().count("<tr"))
    dialog.get_by_role("button", name="Close", exact=True).click()
    expect(dialog).to_have_count(0)


def test_a_list_opens_and_closes_by_the_keys_that_people_try(begin: Begin) -> None:
    _, screen = begin("hierarchical_2", trial=LEARNED)
    dialog = screen.page.get_by_role("dialog")
    screen.page.keyboard.press("Shift+?")
    expect(dialog).to_contain_text("freeze the selection, or let it learn")
    screen.page.keyboard.press("Escape")
    expect(dialog).to_have_count(0)
    # With nothing to close it does no harm.
    screen.page.keyboard.press("Escape")
    screen.turn_to("File")
    screen.upload("Load preset", "wrong.yaml", "trials: 0\n")
    expect(dialog).to_contain_text("This preset cannot be used")
    screen.page.keyboard.press("Escape")
    expect(dialog).to_have_count(0)


def test_the_camera_comes_home_even_while_it_swings(begin: Begin) -> None:
    _, screen = begin()
    home = screen.page.evaluate(CAMERA)
    for has_told in (True, False):
        if not has_told:
            # As one that is about to.
            screen.page.evaluate(TELL_NOTHING_OF_THE_CAMERA)
        screen.page.mouse.move(560, 300)
        screen.page.mouse.down()
        screen.page.mouse.move(700, 380, steps=5)
        screen.page.mouse.up()
        screen.page.wait_for_function(CAMERA_IS, arg=[home, False])
        screen.page.keyboard.press("r")
        screen.page.wait_for_function(CAMERA_IS, arg=[home, True])
    screen.page.evaluate(TELL_ALL)


# What stands where --------------------------------------------------------------------------


def test_the_board_does_not_move_with_the_sentence(begin: Begin) -> None:
    live, screen = begin(trial=100)
    # What was frozen by hand has a lane of its own, which is there from here on.
    live.ask(Introduce("circle_clockwise", 10), FreezeSkills(True), StepOnce(), FreezeSkills(False))
    live.ask(StepOnce())
    expect(screen.time.locator(".lane")).to_have_count(4)
    places: list[object] = []
    for commands, said in [
        ([Introduce("avoid", 10), Explore("approach", 500, 0.3)], "approach in 30% of the steps"),
        ([FreezeSkills(True)], "Frozen by hand: the skills."),
        ([FreezeSelection(True)], "Frozen by hand: the selection and the skills, so"),
    ]:
        live.ask(*commands, StepOnce())
        expect(screen.headline).to_contain_text(said)
        screen.rest()
        room = screen.page.locator("#pounce-stage .board").bounding_box()
        assert room is not None
        # The bar below may take of what a square leaves free, for what is explored in it.
        places.append((room["x"], room["y"], min(room["width"], room["height"])))
    assert places == [places[0]] * len(places)


def test_nothing_reaches_below_a_scroll_bar(begin: Begin) -> None:
    _, screen = begin("hierarchical_2", trial=LEARNED)
    # So low that the panel has to be scrolled.
    screen.turn_to_overlays()
    screen.page.set_viewport_size({"width": 1366, "height": 600})
    bar = screen.page.locator(
        "[data-dock-edge='left'] .mantine-ScrollArea-scrollbar[data-orientation='vertical']"
    ).locator("visible=true")
    expect(bar).to_be_visible()
    edge = bar.bounding_box()
    assert edge is not None
    for part in (screen.legend, screen.page.locator("[data-dock-edge] .pounce-numbers")):
        rights = part.evaluate(
            "node => Array.from(node.querySelectorAll('*'))"
            ".map(child => child.getBoundingClientRect().right)"
        )
        assert max(rights) <= edge["x"]


def test_the_way_back_from_an_opened_run_stands_in_the_run_tab(begin: Begin) -> None:
    live, screen = begin(trial=120)
    back = screen.button("Back to timed, trial 120")
    expect(back).to_have_count(0)
    name = "figure_4_1: timed"
    live.ask(OpenRun(preset_of(), name, 4, 500, "0" * 64, f"{name}, seed 4"))
    live.wait_for(lambda status: not status.playing)
    note = screen.page.locator(".pounce-note").get_by_text(
        "On the board: figure_4_1: timed, seed 4"
    )
    expect(note).to_be_visible()
    back.click()
    status = live.wait_for(lambda status: status.aside is None)
    assert (status.snapshot.preset, status.snapshot.trial) == ("timed", 120)
    expect(back).to_have_count(0)
