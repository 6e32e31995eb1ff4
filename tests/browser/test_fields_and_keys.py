"""What is typed and pasted into fields, and what single keys do on any keyboard."""

import math
from typing import Any

import pytest
from playwright.sync_api import expect

from app.live.requests import SetSpeed
from app.page import keys
from app.page.keys import KEYS
from learners.commands import SetParameter
from tests.support.live import until
from tests.support.screen import TWO_FRAMES, Shared

CAMERA = """() => {
    return window.__viserMutable.camera.quaternion.toArray();
}"""


# Fields


@pytest.mark.parametrize("pasted", [False, True])
def test_what_is_typed_or_pasted_is_what_is_taken(shared: Shared, pasted: bool) -> None:
    screen = shared.screen
    field, keyboard = screen.field("Trials"), screen.page.keyboard
    for text, number in [
        ("13\u202f000", 13_000),
        ("14.000", 14_000),
        ("1e3", 1_000),
        # With a blank, so that the page shows when the lab has written it.
        (" 12,000", 12_000),
    ]:
        field.press("ControlOrMeta+a")
        if pasted:
            screen.page.evaluate("text => navigator.clipboard.writeText(text)", text)
            keyboard.press("ControlOrMeta+v")
        else:
            # As fast as people do: of faster typing the page tells the end once more, later on.
            keyboard.type(text, delay=60)
        keyboard.press("Tab")
        expect(field).to_have_value(f"{number:,}")
        shared.live.expect_value("Trials", f"{number:,}")


def test_what_is_no_number_there_is_refused_and_no_button_takes_another(shared: Shared) -> None:
    live, screen = shared
    for text in ("\N{MINUS SIGN}40", "150,5"):
        screen.fill("Trials", text)
        refusal = f"Trials: '{text}' is not taken: "
        expect(screen.notice("Not taken").filter(has_text=refusal)).to_be_visible()
        screen.click("Start exploring")
        expect(screen.notice("That cannot be done now").filter(has_text=refusal)).to_be_visible()
        expect(screen.field("Trials")).to_have_value(text)
    assert live.session.status.snapshot.control.episodes == ()
    screen.fill("Trials", "2,000")


def test_a_live_number_takes_effect_when_it_is_finished(
    shared: Shared, monkeypatch: pytest.MonkeyPatch
) -> None:
    # However slowly it is typed here, it is finished by Enter alone.
    monkeypatch.setattr("app.page.number_field._REST_S", math.inf)
    live, screen = shared
    screen.turn_to("Steer")
    for label, text, key, value in [
        ("Flight reward", "\N{MINUS SIGN}40", "world.flight_reward", -40.0),
        ("Capture reward", "150,5", "world.capture_reward", 150.5),
        ("Exploration ε", "15 %", "learner.epsilon", 0.15),
    ]:
        before = len(live.session.status.snapshot.control.history)
        field = screen.field(f"{label} as a number")
        field.press("ControlOrMeta+a")
        screen.page.keyboard.type(text)
        field.press("Enter")
        status = live.wait_for(lambda s, n=before: len(s.snapshot.control.history) > n)
        assert status.snapshot.control.history[-1].command == SetParameter(key, value)
        expect(field).to_have_value(f"{value:g}")
        assert len(status.snapshot.control.history) == before + 1
    screen.turn_to("Run")


def test_no_field_of_the_page_drops_characters_before_the_lab_sees_them(shared: Shared) -> None:
    screen = shared.screen
    for tab in ("Steer", "Experiments", "Run"):
        screen.turn_to(tab)
        expect(screen.page.locator("input[inputmode]").locator("visible=true")).to_have_count(0)


# Keys


def press(shared: Shared, key: str, code: str, shift: bool = False) -> None:
    """Press a key as a keyboard with other letters does."""
    devtools = shared.screen.page.context.new_cdp_session(shared.screen.page)
    about: dict[str, Any] = {"key": key, "code": code, "modifiers": 8 if shift else 0}
    devtools.send("Input.dispatchKeyEvent", {"type": "keyDown", "text": key, **about})
    devtools.send("Input.dispatchKeyEvent", {"type": "keyUp", **about})
    devtools.detach()


def steps_after(shared: Shared, key: str, code: str) -> None:
    """Press a key, and wait until there is one step more."""
    before = shared.live.session.status.snapshot.step
    press(shared, key, code)
    status = shared.live.wait_for(lambda status: status.snapshot.step > before)
    assert status.snapshot.step == before + 1


def test_no_key_moves_the_camera(shared: Shared) -> None:
    page = shared.screen.page
    page.mouse.click(560, 300)
    home = page.evaluate(CAMERA)
    # Where runs stand side by side there is no camera, and keys are theirs.
    codes = {key.code for key in KEYS if key not in (keys.PLAY, keys.PRESENT, keys.SIDE)}
    # What would turn it back is not held with what turns it, and what takes the focus comes last.
    back, last = {"KeyS", "KeyD", "KeyE"}, {"KeyB", "KeyH"}
    codes = {*codes, "KeyW", "KeyA", "KeyQ", "ArrowLeft", "ArrowUp"} - back - last
    for held in (codes, back, {"KeyB"}):
        for place in sorted(held):
            page.keyboard.down(place)
        page.evaluate(TWO_FRAMES)
        for place in sorted(held):
            page.keyboard.up(place)
    note = shared.screen.time.get_by_role("textbox")
    expect(note).to_be_focused()
    page.keyboard.press("Escape")
    expect(note).to_have_count(0)
    page.keyboard.press("KeyH")
    expect(page.get_by_role("dialog")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)
    # What was asked of the past makes branches, and the page goes to each once that is there.
    asks = shared.live.lab.browsers[0].asks
    until(lambda: not asks.is_branching)
    page.keyboard.press("End")
    # It follows the room for the board, and that alone.
    assert page.evaluate(CAMERA) == pytest.approx(home, abs=1e-3)
    expect(page.get_by_role("button", name="Reset view")).to_be_hidden()


def test_ends_are_of_time_after_a_click_and_of_what_has_the_focus_by_tab(shared: Shared) -> None:
    live, screen = shared
    keyboard, speed = screen.page.keyboard, screen.page.get_by_role("slider").first
    tab, place = screen.tab("Run"), screen.time.locator(".transport .place")
    live.go_to_trial(max(live.session.status.snapshot.trial, 3))
    for clicked in (tab, speed):
        clicked.click()
        speed_then = live.session.status.speed
        keyboard.press("Home")
        expect(screen.reading("Trial")).to_have_text("0")
        expect(place).to_contain_text("The past")
        keyboard.press("End")
        expect(place).not_to_contain_text("The past")
        expect(tab).to_have_attribute("aria-selected", "true")
        assert live.session.status.speed == speed_then
    keyboard.press("Shift+Tab")
    keyboard.press("Tab")
    expect(speed).to_be_focused()
    keyboard.press("Home")
    live.wait_for(lambda status: status.speed == 1.0)
    expect(place).not_to_contain_text("The past")
    live.ask(SetSpeed(20_000.0))


@pytest.mark.parametrize("letter", ["ы", "ד", "\N{GREEK SMALL LETTER SIGMA}", "س", "o", "s"])
def test_keys_act_by_their_place_whatever_letter_is_there(shared: Shared, letter: str) -> None:
    steps_after(shared, letter, "KeyS")
    shared.screen.page.keyboard.press("Shift+?")
    written = shared.screen.page.get_by_role("dialog").locator("kbd[data-code=KeyS]")
    expect(written).to_have_text(letter.upper())
    shared.screen.page.keyboard.press("Escape")
    expect(written).to_have_count(0)


def test_digits_act_where_they_take_shift_and_where_they_stand_apart(shared: Shared) -> None:
    layer = shared.screen.field("Layer")
    for key, code, shift, title in [
        ("é", "Digit2", False, "Value of one option"),
        ("3", "Digit3", True, "Chosen skill"),
        ("1", "Numpad1", False, "State value"),
    ]:
        press(shared, key, code, shift)
        expect(layer).to_have_value(title)


def test_keys_are_for_the_field_while_somebody_types_but_not_for_a_box(shared: Shared) -> None:
    live, screen = shared
    before = live.session.status.answered
    screen.fill("Seed", "s")
    screen.page.keyboard.press("t")
    expect(screen.field("Seed")).to_have_value("st")
    assert live.session.status.answered == before
    screen.fill("Seed", "3")
    screen.checkbox("Freeze skills").click()
    live.wait_for(lambda status: status.snapshot.control.skills_frozen)
    steps_after(shared, "s", "KeyS")
    screen.checkbox("Freeze skills").click()
    live.wait_for(lambda status: not status.snapshot.control.skills_frozen)


def test_single_keys_can_be_turned_off_and_stay_so_in_this_browser(shared: Shared) -> None:
    live, screen = shared
    page = screen.page
    page.keyboard.press("h")
    box = page.get_by_role("dialog").get_by_role("checkbox", name="Single keys act")
    box.uncheck()
    page.keyboard.press("Escape")
    expect(box).to_have_count(0)
    page.reload()
    screen.settle(live)
    before = live.session.status.answered
    for key in ("s", "n", "h"):
        page.keyboard.press(key)
    screen.turn_to("File")
    screen.click("Keys (?)")
    expect(box).not_to_be_checked()
    assert live.session.status.answered == before
    # Space is for what has the focus in a list like this, which takes it as it opens.
    page.wait_for_function("() => document.activeElement?.closest('[role=dialog]')")
    box.focus()
    page.keyboard.press("Space")
    expect(box).to_be_checked()
    page.keyboard.press("Escape")
    expect(box).to_have_count(0)
    screen.turn_to("Now")
    steps_after(shared, "s", "KeyS")
