"""Widgets, on a real server that nobody looks at: what is true, and what somebody wants."""

import pytest
import viser

from app.page import widgets
from app.page.widgets import Choice, Input, add_buttons
from tests.support.person import Person


@pytest.fixture(autouse=True)
def no_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(widgets, "TOUCHED_S", -1.0)


# Inputs


def test_an_input_shows_what_is_true_and_tells_what_a_person_sets(
    gui: viser.GuiApi, person: Person
) -> None:
    told: list[object] = []
    box = Input(gui.add_checkbox("Box", False), lambda client, on: told.append((client, on)))
    box.show(True)
    assert person.value("Box")
    assert told == [], "a change by the program is nobody's wish"
    person.check("Box", False)
    assert told == [(person, False)]
    box.show(True)
    assert person.value("Box")


def test_what_a_person_has_set_and_nobody_knows_of_yet_is_not_set_back(
    gui: viser.GuiApi, person: Person
) -> None:
    told: list[object] = []
    handle = gui.add_checkbox("Box", False)
    box = Input(handle, lambda _, on: told.append(on))
    # As viser does it before it calls back.
    handle._impl.value = True
    box.show(False)
    box.put(False)
    assert person.value("Box")
    person.check("Box")
    assert told == [True]
    box.show(False)
    assert not person.value("Box")


def test_what_was_just_touched_is_left_alone(
    gui: viser.GuiApi, person: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(widgets, "TOUCHED_S", 1_000.0)
    slider = Input(gui.add_slider("Slider", 0, 10, 1, 5), lambda *_: None)
    person.move("Slider", 7)
    slider.show(5)
    assert person.value("Slider") == 7
    slider.put(5)
    assert person.value("Slider") == 5


# Lists


def test_a_choice_is_of_ids_whatever_they_are_called(gui: viser.GuiApi, person: Person) -> None:
    told: list[int] = []
    choice = Choice(gui, "List", {"one": 1, "two": 2}, lambda _, id_: told.append(id_))
    person.choose("List", "two")
    assert (choice.chosen, told) == (2, [2])
    assert not choice.offer({"one": 1, "two": 2})
    assert choice.offer({"zero": 0, "the one": 1, "the second": 2})
    assert (choice.chosen, person.value("List")) == (2, "the second")
    choice.offer({"zero": 0, "the second": 1})
    assert (choice.chosen, person.value("List")) == (0, "zero")
    choice.choose(1)
    assert person.value("List") == "the second"
    assert told == [2]


def test_where_there_is_nothing_to_choose_that_is_said(gui: viser.GuiApi, person: Person) -> None:
    choice: Choice[str | None] = Choice(gui, "List", {}, nothing="(none)")
    assert (choice.chosen, person.options("List")) == (None, ["(none)"])
    choice.offer({"a": "A"})
    assert (choice.chosen, person.options("List")) == ("A", ["a"])
    choice.offer({})
    assert (choice.chosen, person.options("List")) == (None, ["(none)"])


def test_buttons_in_a_row_have_ids(gui: viser.GuiApi, person: Person) -> None:
    pressed: list[int] = []
    add_buttons(gui, "Row", {"less": -1, "more": 1}, lambda _, id_: pressed.append(id_))
    for name in ("more", "more", "less"):
        person.click(name)
    assert pressed == [1, 1, -1]
