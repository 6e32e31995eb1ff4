"""What a lesson says around its own texts: all of it in each language, with the same parts."""

import re
from pathlib import Path
from string import Formatter

import pytest

import app
from app.documents import lessons
from app.lessons.phrases import LANGUAGES
from app.lessons.phrases.english import ENGLISH
from app.lessons.words import IN_ENGLISH, words_of
from app.picture.octants import OCTANTS

ROOT = Path(app.__file__).parent
SHIPPED = sorted(
    {language for name in lessons.shipped() for language in lessons.load(name).spec.languages}
)
SCRIPTS = [ROOT / "web" / part / "words.js" for part in ("lesson", "audience", "time")]
OTHERS = [language for language in SHIPPED if language != "en"]
_SAID = re.compile(r"""say\(\s*f?["']([a-z_.{}]+)""")
_COUNTED = re.compile(r"""counted\(\s*["']([a-z_]+(?:\.[a-z_]+)?)["']""")
_TABLE = re.compile(r"^  (\w+): \{$(.*?)^  \},$", re.MULTILINE | re.DOTALL)
_ENTRY = re.compile(r'^    (\w+): "(.*)",$', re.MULTILINE)


def parts_of(phrase: str) -> list[str]:
    return sorted(name for _, name, _, _ in Formatter().parse(phrase) if name is not None)


def tables_of(script: Path) -> dict[str, dict[str, str]]:
    """What a script of the page says, by language."""
    return {
        language: dict(_ENTRY.findall(entries))
        for language, entries in _TABLE.findall(script.read_text("utf-8"))
    }


@pytest.mark.parametrize("language", SHIPPED)
def test_each_shipped_language_has_every_phrase_with_the_same_parts(language: str) -> None:
    phrases = LANGUAGES[language].phrases
    assert {key: parts_of(phrase) for key, phrase in phrases.items()} == {
        key: parts_of(phrase) for key, phrase in ENGLISH.phrases.items()
    }
    assert all(phrases.values())


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.parent.name)
def test_so_has_the_page(script: Path) -> None:
    tables = tables_of(script)
    assert sorted(tables) == SHIPPED
    english = {key: sorted(re.findall(r"\{\d\}", text)) for key, text in tables["en"].items()}
    assert english
    for table in tables.values():
        assert {key: sorted(re.findall(r"\{\d\}", text)) for key, text in table.items()} == english


@pytest.mark.parametrize("language", SHIPPED)
def test_the_card_calls_octants_as_the_board_does(language: str) -> None:
    names = [words_of(language).octant(octant) for octant in OCTANTS]
    assert len(set(names)) == len(OCTANTS)
    card = tables_of(ROOT / "web" / "lesson" / "words.js")[language]
    assert [card[octant] for octant in OCTANTS] == names


def test_all_that_is_said_is_in_the_table_and_all_of_that_is_said() -> None:
    folders = (ROOT / "lessons", ROOT / "page" / "lesson")
    text = "\n".join(path.read_text("utf-8") for each in folders for path in each.glob("*.py"))
    said = {key for key in _SAID.findall(text) if "{" not in key}
    said |= {f"{key}.more" for key in _COUNTED.findall(text)}
    assert said <= set(ENGLISH.phrases)
    quoted = set(re.findall(r"""["']([a-z_]+(?:\.[a-z_]+)*)["']""", text))
    quoted |= {f"{key}.{form}" for key in quoted for form in ("one", "more")}
    composed = ("octant.", "sheet.", "control.")
    assert {key for key in ENGLISH.phrases if not key.startswith(composed)} <= quoted


@pytest.mark.parametrize(
    ("language", "number", "written"),
    [
        ("en", 2_000, "2,000"),
        ("en", 12_000, "12,000"),
        ("en", 0.9, "0.9"),
        ("en", -50, "\N{MINUS SIGN}50"),
        ("de", 2_000, "2000"),
        ("de", 12_000, "12\u202f000"),
        ("de", 1_234_567, "1\u202f234\u202f567"),
        ("de", 0.9, "0,9"),
        ("de", -12_000, "\N{MINUS SIGN}12\u202f000"),
        ("de-CH", 0.25, "0,25"),
        ("xx", 12_000, "12,000"),
    ],
)
def test_numbers(language: str, number: float, written: str) -> None:
    assert words_of(language).number(number) == written


def test_numbers_in_phrases() -> None:
    german = words_of("de")
    assert german.say("control.run_to", trial=14_500) == "Lernen bis Versuch 14\u202f500"
    assert german.percent(0.95) == "95\u00a0%"
    assert german.counted("runs", 1) == "1 Lauf"
    assert german.counted("runs", 20) == "20 Läufe"
    assert german.listed(["a", "b", "c"]) == "a, b und c"
    assert german.rounded(66.66) == "66,7"
    assert IN_ENGLISH.listed(["a"]) == "a"


def test_what_a_language_lacks_is_said_in_english(monkeypatch: pytest.MonkeyPatch) -> None:
    german = dict(LANGUAGES["de"].phrases)
    del german["check.done"]
    monkeypatch.setattr(
        "app.lessons.words.LANGUAGES",
        {"en": ENGLISH, "zz": type(ENGLISH)(" ", 1_000, ",", " %", german)},
    )
    assert words_of("zz").say("check.done") == "Done."
    assert words_of("zz").say("check.not_yet") == "Noch nicht."
