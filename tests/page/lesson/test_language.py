"""A German lesson in a browser: nothing of what it is told is English."""

import re
from collections.abc import Iterator
from string import Formatter
from typing import Any, Final, Literal

import pytest
import viser

from app.documents import lessons
from app.lessons.phrases import LANGUAGES
from app.lessons.phrases.english import ENGLISH
from app.page.lesson import messages
from tests.support.lessons import Room, Sitter, small_session
from tests.support.person import Person

GERMAN: Final = """
title: Eine kleine
language: de
minutes: 4
setup: {preset: timed, set: {world.size: 40}, seed: 3, start: 200, speed: 50000}
show: [play, speed, step, trial, headings, side, watch, plan, undo, layer.value]
steps:
  - ask: sectors
    id: where
    text: "In welchen Richtungen?"
    confidence: true
    reveal: {reach: octants, above: 0.1, at: +50}
  - {see: {same_as: where}, id: where_seen, text: "Und jetzt?"}
  - ask: moment
    id: when
    text: "In welchem Versuch?"
    from: 200
    to: 1000
    reveal: {measure: trial, above: 300}
    run: +120
  - {see: {same_as: when}, id: when_seen, text: "Wann war es?"}
  - ask: sketch
    id: how
    text: "Zeichne es."
    from: 300
    to: 500
    reveal: {reward: 50, at: 500}
  - {see: {same_as: how}, id: how_seen, text: "Wie war es?"}
  - ask: number
    id: known
    text: "Wie viel?"
    low: 0
    high: 10
    key: 5
    confidence: true
  - do: {command: introduce, skill: avoid, explore: {trials: 2000, chance: 0.3}}
    id: add
    text: "Lass ihn weggehen lernen."
    unlock: [add_skill, explore, freeze, start_again]
    check: {all: [{present: avoid, by: +2000}, {command: explore}, {command: stop_exploring}]}
    hints: ["Schau unter die Karte.", "Drücke auf den Knopf.", {do: true}]
  - do: {command: run_to, at: +50}
    id: on
    text: "Lass ihn lernen."
    check: {measure: trial, above: 100}
  - free: {show: all}
    text: "Probier es aus."
  - do: {command: experiment, name: ablation}
    id: many
    text: "Starte das Experiment."
    check: {command: experiment}
"""


def read_of(state: dict[str, Any]) -> Iterator[str]:
    """All that somebody reads of what a frame is sent, but for the names of layers."""
    lesson, card = state["lesson"], state["lesson"]["card"]
    yield from filter(None, (state["fault"], lesson["said"], card["busy"], card["html"]))
    yield from card["hints"]
    for told in (card["check"], card["reveal"]):
        if told is not None:
            yield told["html"]
    for control in lesson["controls"]:
        yield from (control["label"], control["why"])
        if control["control"] != "layer":
            yield from (label for _, label in control["options"])


def pattern_of(phrase: str) -> re.Pattern[str]:
    """Finds a phrase, whatever is filled in."""
    parts = Formatter().parse(phrase)
    found = "".join(re.escape(text) + ("" if name is None else ".+") for text, name, _, _ in parts)
    return re.compile(rf"(?<!\w){found}(?!\w)")


PHRASES = {
    key: pattern_of(phrase)
    for key, phrase in ENGLISH.phrases.items()
    if phrase != LANGUAGES["de"].phrases[key]
}


class Heard:
    """All that a frame was ever sent."""

    def __init__(self, sitter: Sitter) -> None:
        self.read: set[str] = set()
        self._send = sitter.frame.send
        sitter.frame.send = self.send

    def send(self, kind: str, content: dict[str, Any]) -> None:
        if content["lesson"] is not None:
            self.read |= set(read_of(content))
        self._send(kind, content)


@pytest.fixture
def room(gui: viser.GuiApi, person: Person, monkeypatch: pytest.MonkeyPatch) -> Iterator[Room]:
    # What is said of many runs is said of a few, and these are soon made.
    monkeypatch.setattr("app.lessons.twenty.SEEDS", (0, 1))
    session = small_session()
    session.start()
    room = Room(session, gui, lessons.parse(GERMAN, "klein.yaml"))
    yield room
    room.close()


def test_nothing_that_a_german_lesson_says_is_english(room: Room) -> None:
    (sitter,) = room.sitters
    heard = Heard(sitter)
    sitter.start("klein")
    _guess(room, sitter, "where", ["w", "nw"], 90)
    assert sitter.on_board.language == "de"
    _guess(room, sitter, "when", 250, None)
    assert sitter.on_bar.sent["language"] == "de"
    points = [[trial, 10.0] for trial in (300, 340, 380, 420, 460, 500)]
    _guess(room, sitter, "how", points, None)
    assert sitter.on_bar.sent["language"] == "de"
    sitter.do(messages.Answer("known", 5), messages.Commit("known", 70))
    room.until(lambda: bool(sitter.card["reveal"] and sitter.card["reveal"]["ready"]))
    assert sitter.card["reveal"]["html"] == "Richtig ist: 5."
    _go_on(room, sitter)
    sitter.do(messages.Use("play"))
    sitter.do(messages.Use("play"))
    for control in ("add_skill.avoid", "explore.avoid", "explore.avoid"):
        room.until(lambda control=control: control in _controls_of(sitter))
        sitter.do(messages.Use(control))
    room.until(lambda: sitter.lesson["next"])
    _go_on(room, sitter)
    sitter.do(messages.Use("run_to"))
    room.until(lambda: sitter.lesson["next"])
    _go_on(room, sitter)
    _go_on(room, sitter)
    room.until(lambda: sitter.lesson["said"] != "")
    assert "Experiment ablation starten" in heard.read
    assert "avoid erkunden: 2000 Versuche mit 30\u00a0%" in heard.read
    assert any(text.startswith("Ja, in Versuch ") or text == "Geschafft." for text in heard.read)
    english = {
        text: key for text in heard.read for key, found in PHRASES.items() if found.search(text)
    }
    assert not english


def test_who_changes_the_language_is_told_all_in_that(room: Room) -> None:
    (sitter,) = room.sitters
    sitter.start("the_cone", "de")
    sitter.do(messages.Next())
    room.until(lambda: sitter.lesson["at"] == 1)
    assert sitter.on_board.language == "de"
    sitter.do(messages.SetLanguage("en"))
    assert sitter.on_board.language == "en"


def _controls_of(sitter: Sitter) -> set[str]:
    return {control["control"] for control in sitter.lesson["controls"]}


def _guess(
    room: Room, sitter: Sitter, question: str, answer: Any, sure: Literal[90] | None
) -> None:
    """Guess, go on to what was seen, and on to the next card once it is told what came of it."""
    sitter.do(messages.Answer(question, answer), messages.Commit(question, sure))
    _go_on(room, sitter)
    seen = f"{question}_seen"
    sitter.do(messages.Answer(seen, answer), messages.Commit(seen))
    room.until(lambda: bool(sitter.card["reveal"] and sitter.card["reveal"]["ready"]))
    room.show()
    on_board, on_bar = sitter.on_board, sitter.on_bar
    _go_on(room, sitter)
    sitter.on_board, sitter.on_bar = on_board, on_bar


def _go_on(room: Room, sitter: Sitter) -> None:
    at = sitter.lesson["at"]
    sitter.do(messages.Next())
    room.until(lambda: sitter.lesson["at"] == at + 1)
