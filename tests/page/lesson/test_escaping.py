"""Whatever a lesson says, its page shows it as a text: in no language, on no card is it markup."""

import re
from collections.abc import Iterator
from typing import Any, Final

import pytest
import viser

from app.page.lesson import messages
from tests.support.lessons import Room, small_lesson, small_session
from tests.support.person import Person

BAIT: Final = "<img src=x onerror=alert(1)>"
_TAG: Final = re.compile(r"<[^>]*>")
_OURS: Final = {"<b>", "</b>", "<code>", "</code>", "<br>"}

HOSTILE: Final = f"""
title: "{BAIT}"
minutes: 4
setup: {{preset: timed, set: {{world.size: 40}}, start: 50}}
show: [play]
steps:
  - {{say: "**A** {BAIT}", id: one, notes: "{BAIT} `{BAIT}`"}}
  - ask: choice
    id: two
    text: "{BAIT}?"
    options: ["{BAIT}", "no{BAIT}"]
    values: ["yes", "no"]
    reveal: {{measure: value_states, above: 5, at: +10}}
  - {{ask: number, id: three, text: "{BAIT}", low: 0, high: 9, unit: "{BAIT}", key: 4}}
  - do: {{command: play}}
    id: four
    text: "{BAIT}"
    check: {{measure: trial, above: 1}}
    hints: ["{BAIT}", "**{BAIT}**"]
  - {{why: {{text: "`{BAIT}`"}}}}
  - {{free: {{show: all}}, text: "{BAIT}"}}
texts:
  de:
    title: "de {BAIT}"
    cards:
      - {{text: "de {BAIT}", notes: "de {BAIT}"}}
      - {{text: "de {BAIT}", options: ["a{BAIT}", "b{BAIT}"]}}
      - {{text: "de {BAIT}", unit: "de {BAIT}"}}
      - {{text: "de {BAIT}", hints: ["de {BAIT}", "{BAIT}"]}}
      - {{text: "de {BAIT}"}}
      - {{text: "de {BAIT}"}}
"""


@pytest.fixture
def room(gui: viser.GuiApi, person: Person) -> Iterator[Room]:
    session = small_session()
    session.start()
    room = Room(session, gui, small_lesson(HOSTILE, "bait"))
    yield room
    room.close()


def as_markup(lesson: dict[str, Any]) -> Iterator[str]:
    """What the card's page takes for HTML."""
    card = lesson["card"]
    yield card["html"]
    yield from card["hints"]
    yield lesson["notes"] or ""
    yield lesson["inspect"] or ""
    for part in ("reveal", "check"):
        yield (card[part] or {}).get("html") or ""
    for _, label in (card["ask"] or {}).get("options", ()):
        yield label


@pytest.mark.parametrize("language", ["en", "de"])
def test_no_card_has_markup_of_the_file(room: Room, language: str) -> None:
    (sitter,) = room.sitters
    sitter.start("bait", language)
    for at in range(6):
        room.until(lambda at=at: sitter.lesson["at"] == at and sitter.card["busy"] is None)
        asked = sitter.card["ask"]
        if asked is not None:
            answer = "yes" if asked["kind"] == "choice" else 4
            name = sitter.card["id"]
            sitter.do(messages.Answer(name, answer), messages.Commit(name, None))
        if sitter.card["next_hint"]:
            sitter.do(messages.Hint(), messages.Hint())
            assert len(sitter.card["hints"]) == 2
        shown = list(as_markup(sitter.lesson))
        assert any("&lt;img" in html for html in shown)
        assert {tag for html in shown for tag in _TAG.findall(html)} <= _OURS
        if at < 5:
            room.until(lambda: sitter.lesson["next"])
            sitter.do(messages.Next())
