"""A lesson on paper: room for each kind of answer, and nothing given away before the answers."""

import re
from html.parser import HTMLParser

import pytest

from app.documents import lessons
from app.documents.lessons import Lesson
from app.lessons.sheet import MOST_BOARDS, findings_of, sheet

HEAD = """
title: All kinds
minutes: 3
setup: {preset: timed, seed: 3, start: 400, schedule: "off"}
show: [play]
steps:
  - say: "**Bold** <script>alert(1)</script> & `code`"
    notes: Say it aloud.
  - {id: one, ask: choice, text: "Which?", options: ["yes", "no"], confidence: true,
     reveal: {measure: success, above: 0.9, at: 500}}
  - {id: many, ask: number, text: "How many?", low: 0, high: 3456, unit: places,
     reveal: {measure: value_states, at: 500}}
  - {id: where, ask: sectors, text: "Where?", reveal: {reach: octants, above: 0.02, at: 500}}
  - {id: when, ask: moment, text: "When?", from: 400, to: 600,
     reveal: {measure: value_states, above: 40}}
  - {id: drawn, ask: sketch, text: "Draw.", from: 400, to: 600, low: -50, high: 100,
     reveal: {reward: 100}}
  - {do: {command: run_to, at: 600}, text: "Go on.", check: {measure: trial, above: 599}}
  - {see: {same_as: where}, text: "What is to be seen?"}
  - why: {text: Because of the secret.}
  - {id: sure, ask: choice, text: "And 2 and 2?", options: [three, four], key: four}
  - {free: {show: all}, text: Try it.}
"""
GERMAN = """
texts:
  de:
    title: Alle Arten
    cards:
      - {text: Fett, notes: Laut sagen.}
      - {text: "Was?", options: [ja, nein]}
      - {text: "Wie viele?", unit: Orte}
      - {text: "Wo?"}
      - {text: "Wann?"}
      - {text: "Zeichne."}
      - {text: "Weiter."}
      - {text: "Was ist zu sehen?"}
      - {text: "Wegen des Geheimnisses."}
      - {text: "Und 2 und 2?", options: [drei, vier]}
      - {text: "Versuche es."}
"""


@pytest.fixture(scope="module")
def lesson() -> Lesson:
    return lessons.parse(HEAD + GERMAN, "kinds.yaml")


@pytest.fixture(scope="module")
def written(lesson: Lesson) -> str:
    return sheet(lesson, "en", findings_of(lesson, range(3)))


class Tags(HTMLParser):
    """All tags of a page, and whether each that is opened is closed again."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.names: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []
        self._open: list[str] = []
        self.feed(page)
        self.is_whole = not self._open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names.append(tag)
        self.attributes += attrs
        if tag != "meta":
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names.append(tag)
        self.attributes += attrs

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag


def parts(page: str) -> tuple[str, str]:
    """The questions, and the answers."""
    questions, _, answers = page.partition('<section class="answers">')
    return questions, answers


def test_it_is_one_file_without_scripts_that_loads_nothing(written: str) -> None:
    tags = Tags(written)
    assert tags.is_whole
    assert "script" not in tags.names
    assert {"link", "iframe", "img"}.isdisjoint(tags.names)
    assert not [name for name, _ in tags.attributes if name.startswith("on")]
    links = [value or "" for name, value in tags.attributes if name in ("href", "src")]
    assert all(link.startswith("data:image/png;base64,") for link in links)
    assert "&lt;script&gt;alert(1)&lt;/script&gt; &amp; <code>code</code>" in written
    assert "<b>Bold</b>" in written


def test_there_is_room_for_every_kind_of_answer(written: str) -> None:
    questions, _ = parts(written)
    assert questions.count('class="boxes"') == 2
    assert questions.count('class="boxes sure"') == 1
    assert questions.count('class="blank"') == 1
    # An empty compass to predict with, and one for what was seen.
    assert questions.count("Shade the directions.</title>") == 2
    assert questions.count("Mark the trial.</title>") == 1
    assert questions.count("Draw the reward per trial (up) along the trials (to the right).") == 2
    # Nothing is drawn into the frame, and nothing is grey in the compass.
    assert 'stroke-width="2"/>' not in questions
    assert "rgb(150,150,150)" not in questions
    assert questions.count('class="line"') == 2 + 3 + 4


def test_nothing_is_given_away_before_the_answers(written: str) -> None:
    questions, answers = parts(written)
    assert "secret" not in questions
    assert "Say it aloud" not in questions
    # The board as it is where the lesson begins, and what was to be seen among the answers alone.
    assert questions.count("<figcaption>The board at trial 400.") == 1
    assert "trial 600" not in questions
    assert answers.count("<figcaption>The board at trial 600.") == 1
    assert "Because of the secret." in answers
    assert "Say it aloud." in answers


def test_answers_are_of_the_run_and_of_the_others(lesson: Lesson, written: str) -> None:
    _, answers = parts(written)
    found = findings_of(lesson, range(3))
    assert re.search(r"This run: no</p>\s*<p>In 3 of 3 runs: no", answers)
    own = found.own["many"]
    band = found.others["many"].band
    assert isinstance(own, float)
    assert band is not None
    assert f"This run: {own:.0f} places" in answers
    assert f"In 3 runs from {band.low:.0f} places to {band.high:.0f} places" in answers
    assert "In how many of 3 runs each direction is among them" in answers
    assert f"This run: trial {found.own['when']:.0f}" in answers
    assert "the grey band lies between the lowest and the highest of 3 runs" in answers
    assert "<b>four</b>" in answers
    assert "1 for the first" not in answers


def test_it_can_be_had_in_each_language_of_the_lesson(lesson: Lesson) -> None:
    german = sheet(lesson, "de", findings_of(lesson, range(1)))
    assert '<html lang="de">' in german
    assert "<h1>Alle Arten</h1>" in german
    assert "Schraffiere die Richtungen." in german
    assert "Dieser Lauf: nein" in german
    assert "hinten" in parts(german)[1]
    assert "Antworten: Alle Arten" in german
    assert not re.search(r"Predict|Shade|This run|What do you see", german)


def test_a_sheet_stays_small_however_many_cards_there_are() -> None:
    see = "  - {see: {same_as: one}, text: Look.}\n"
    head = HEAD.partition("  - {id: many")[0]
    long = lessons.parse(head + see * 38, "long.yaml")
    page = sheet(long, "en", findings_of(long, range(1)))
    assert page.count("<figcaption>") == MOST_BOARDS
    assert len(page) < 1_000_000
