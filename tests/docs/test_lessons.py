"""Every key, measure, region, command and control that a lesson can name has its row."""

import re
from collections.abc import Iterable

import pytest
from pydantic import BaseModel

from app.documents.lesson_cards import CONTROLS, NEEDS, VERBS, Card
from app.documents.lesson_grammar import (
    DEEDS,
    DIRECTIONS,
    EACH_OCTANT,
    LAYERS,
    MEASURES_OF,
    PLAIN_MEASURES,
    REGIONS,
    SHAPES,
    Check,
    Measured,
    OfExperiment,
)
from app.documents.lesson_questions import BELONG, MAX_WORDS, QUESTIONS, Asked
from app.documents.lesson_spec import MAX_CARDS, Evidence, LessonSpec, Setup, Texts, Words
from app.documents.lessons import parse
from tests.support.pages import ROOT

PAGE = "presets/lessons/README.md"
TEXT = (ROOT / PAGE).read_text("utf-8")


def keys_of(model: type[BaseModel]) -> list[str]:
    return [field.alias or name for name, field in model.model_fields.items()]


def names(rows: Iterable[list[str]]) -> list[str]:
    return [row[0].strip("`") for row in rows]


def tables(heading: str) -> list[list[list[str]]]:
    """The tables below a heading and above the next one, without their first rows."""
    text = re.split(rf"^{re.escape(heading)}$", TEXT, maxsplit=1, flags=re.MULTILINE)[1]
    text = re.split(r"^#+ ", text, maxsplit=1, flags=re.MULTILINE)[0]
    found = re.findall(r"(?:^\|.*\n)+", text, flags=re.MULTILINE)
    cells = [[line.strip("|\n").split("|") for line in table.splitlines()] for table in found]
    return [[[cell.strip() for cell in row] for row in table[2:]] for table in cells]


OF_CARDS_ALONE = [key for key in keys_of(Card) if key not in (*keys_of(Asked), *VERBS)]


@pytest.mark.parametrize(
    ("heading", "place", "expected"),
    [
        ("## The lesson", 0, keys_of(LessonSpec)),
        ("### Setup", 0, keys_of(Setup)),
        ("## Cards", 0, VERBS),
        ("## Cards", 1, ["id", "text", *OF_CARDS_ALONE[1:]]),
        ("## Questions", 0, QUESTIONS),
        ("## Questions", 1, [key for key in keys_of(Asked) if key != "text"]),
        ("## Checks", 0, [key for key in keys_of(Check) if key not in keys_of(Measured)]),
        ("### Measures", 0, PLAIN_MEASURES),
        ("### Measures", 1, MEASURES_OF),
        ("### Regions", 0, REGIONS),
        ("## Commands", 0, DEEDS),
        ("## Controls", 0, [n for n in CONTROLS if n in ("layer.value",) or "." not in n]),
        ("## Other languages", 0, keys_of(Words)),
        ("## Evidence", 0, keys_of(Evidence)),
    ],
)
def test_every_name_has_its_row_and_no_other(
    heading: str, place: int, expected: Iterable[str]
) -> None:
    rows = tables(heading)[place]
    assert names(rows) == list(expected)
    assert all(row[-1] for row in rows)


def test_what_controls_are_is_said_as_on_the_page() -> None:
    for name, *_, words in tables("## Controls")[0]:
        assert words.startswith(CONTROLS[name.strip("`")])


def test_what_a_command_needs_is_said() -> None:
    for name, needs, possible, _ in tables("## Commands")[0]:
        found = tuple(tuple(re.findall(r"`(\w+)`", cell)) for cell in (needs, possible))
        assert found == NEEDS[name.strip("`")]


def test_what_each_measure_finds_is_said() -> None:
    plain, of_something = tables("### Measures")
    words = {"number": "number", "word": "word", "yes": "yes or no"}
    for name, finds, _ in plain:
        assert finds.startswith(words[PLAIN_MEASURES[name.strip("`")]])
    for name, _, finds, _ in of_something:
        assert finds.startswith(words[MEASURES_OF[name.strip("`")]])
    listed = {name.strip("`"): row for name, *row in (*plain, *of_something)}
    for name, closed in (("shape", SHAPES), ("spread_direction", DIRECTIONS)):
        assert re.findall(r"`([^`]+)`", listed[name][-1]) == list(closed)
    assert re.findall(r"\w+", listed["experiment"][0]) == keys_of(OfExperiment)
    assert f"`{EACH_OCTANT}` stands for each of them" in TEXT


def test_which_questions_have_a_key_is_said() -> None:
    rows = {name.strip("`"): of for name, of, _ in tables("## Questions")[1]}
    for key, kinds in BELONG.items():
        assert re.findall(r"`(\w+)`", rows[key]) == list(kinds)
    assert {key for key, of in rows.items() if of != "all"} == set(BELONG)


def test_the_keys_of_all_layers_are_there() -> None:
    line = TEXT.partition("The keys of layers")[2].partition("are")[2].partition(".")[0]
    assert re.findall(r"`(\w+)`", line) == list(LAYERS)


def test_bounds_are_said() -> None:
    text = " ".join(TEXT.partition("## Bounds")[2].partition("##")[0].split())
    assert f"up to {MAX_CARDS} cards" in text
    assert f"up to {MAX_WORDS} words" in text
    assert keys_of(Texts) == ["title", "cards"]


def test_the_examples_are_sound() -> None:
    shortest, check, texts = re.findall(r"```yaml\n(.*?)```", TEXT, re.DOTALL)
    assert parse(shortest, "mine.yaml").spec.steps[0].kind == "say"
    assert parse(shortest + texts, "mine.yaml").spec.languages == ("en", "de")
    done = f"  - do: {{command: play}}\n    text: A\n    unlock: [play]\n    {check}"
    assert parse(shortest + done, "mine.yaml").spec.steps[1].check is not None
