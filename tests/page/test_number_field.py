"""Fields for numbers: what a page sends of a text, and what is understood of it."""

import math
import time

import pytest
import viser

from app.page import number_field
from app.page.number_field import Dial, Limits, NumberField
from app.server.callbacks import RefusedError
from tests.support.person import Person

TRIALS = Limits(1, 100_000)
SHARE = Limits(0.0, 1.0, whole=False, share=True)


@pytest.mark.parametrize(
    ("text", "number"),
    [("12,000", 12_000), ("12 000", 12_000), ("12.000", 12_000), ("1e3", 1_000), ("7", 7)],
)
def test_what_is_typed_is_what_is_taken_and_shown_as_it_was_understood(
    gui: viser.GuiApi, person: Person, text: str, number: int
) -> None:
    field = NumberField(gui, "Trials", 2_000, TRIALS)
    person.fill("Trials", text)
    assert (field.read(), field.handle.value) == (number, f"{number:,}")
    assert person.told == []


@pytest.mark.parametrize("text", ["12.5", "0", "\N{MINUS SIGN}40", "seven", "", "12,00"])
def test_a_form_keeps_what_it_does_not_take_and_says_so(
    gui: viser.GuiApi, person: Person, text: str
) -> None:
    field = NumberField(gui, "Trials", 2_000, TRIALS)
    person.fill("Trials", text)
    assert len(person.told) == 1
    assert person.told[0].startswith(f"Trials: {text!r} is not taken: ")
    assert person.told[0].endswith("; allowed: a whole number, 1 to 100000")
    assert field.text == text
    with pytest.raises(RefusedError, match="is not taken: "):
        field.read()


def test_a_button_takes_what_stands_there_even_if_nobody_has_left_the_field(
    gui: viser.GuiApi,
    person: Person,
) -> None:
    field = NumberField(gui, "Trials", 2_000, TRIALS)
    person.type("Trials", "12,000")
    assert field.read() == 12_000


class Live:
    """A field that is in force as soon as it is finished."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self.taken: list[float] = []
        self.field = NumberField(
            gui, "ε", 0.5, SHARE, changed=lambda _, number: self.taken.append(number), live=True
        )


@pytest.mark.parametrize(("text", "number"), [("0,25", 0.25), ("25 %", 0.25), ("2.5e-1", 0.25)])
def test_a_live_number_is_in_force_once_it_is_finished_and_not_before(
    gui: viser.GuiApi, person: Person, text: str, number: float
) -> None:
    live = Live(gui)
    person.type("ε", text)
    assert live.taken == []
    person.fill("ε", text)
    assert live.taken == [number]
    assert live.field.handle.value == "0.25"


def test_a_live_field_shows_what_is_in_force_after_a_text_that_is_not_taken(
    gui: viser.GuiApi,
    person: Person,
) -> None:
    live = Live(gui)
    person.fill("ε", "1,5")
    assert live.field.handle.value == "0.5"
    assert person.told == ["ε: '1,5' is not taken: it is too large; allowed: a number, 0 to 1"]
    assert live.taken == []


def test_a_keystroke_that_comes_late_changes_nothing(
    gui: viser.GuiApi, person: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(number_field, "_ECHO_S", math.inf)
    live = Live(gui)
    person.fill("ε", "x")
    # The page sends the end of a text at once, and may send its last keystroke after it.
    person.type("ε", "x")
    assert live.field.handle.value == "0.5"
    assert len(person.told) == 1


def test_a_live_number_that_has_rested_is_taken_but_never_half_of_one(
    gui: viser.GuiApi, person: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(number_field, "_REST_S", 3_600.0)
    live = Live(gui)
    person.type("ε", "0.2e-")
    live.field.settle(math.inf)
    assert live.taken == []
    person.type("ε", "0.2e-1")
    live.field.settle(time.monotonic())
    assert live.taken == []
    live.field.settle(math.inf)
    assert live.taken == [0.02]
    assert person.told == []


def test_what_is_true_does_not_take_the_place_of_what_is_being_typed(
    gui: viser.GuiApi, person: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    live = Live(gui)
    person.type("ε", "0.")
    monkeypatch.setattr(number_field, "TOUCHED_S", 0.0)
    live.field.show(0.7)
    assert live.field.handle.value == "0."
    monkeypatch.setattr(number_field, "_GIVEN_UP_S", 0.0)
    live.field.show(0.7)
    assert live.field.handle.value == "0.7"


def test_a_dial_is_one_number(gui: viser.GuiApi, person: Person) -> None:
    dial = Dial(gui, "Probability", 0.5, SHARE, 0.05)
    person.fill("Probability as a number", "95 %")
    assert (dial.read(), person.value("Probability")) == (0.95, 0.95)
    person.move("Probability", 0.3)
    assert (dial.read(), dial.field.handle.value) == (0.3, "0.3")
    person.fill("Probability as a number", "half")
    assert person.told[0].startswith("Probability: 'half' is not taken: it is no number")
    with pytest.raises(RefusedError):
        dial.read()


def test_a_seed_is_a_name_and_has_no_commas(gui: viser.GuiApi, person: Person) -> None:
    field = NumberField(gui, "Seed", 2**63 - 1, Limits(0, 2**63 - 1, grouped=False))
    assert field.handle.value == "9223372036854775807"
    person.fill("Seed", "9,223,372,036,854,775,806")
    assert (field.read(), field.handle.value) == (2**63 - 2, "9223372036854775806")
