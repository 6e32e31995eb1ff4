"""What a term means is said once, in one plain sentence."""

import pytest

from app.words.glossary import TERMS, table_html, term

LONGEST = 160
"""Characters that are read at a glance."""


@pytest.mark.parametrize("key", TERMS)
def test_a_term_is_explained_in_one_short_sentence(key: str) -> None:
    meaning = TERMS[key]
    assert meaning.endswith(".")
    assert ". " not in meaning
    assert meaning[0].isupper()
    assert len(meaning) <= LONGEST


def test_a_term_that_stands_in_a_text_says_which_it_is() -> None:
    shown = term("skill", "Skills")
    assert 'data-term="skill"' in shown
    assert 'tabindex="0"' in shown
    assert shown.endswith(">Skills</span>")
    assert term("trial").endswith(">trial</span>")


def test_what_stands_there_is_escaped() -> None:
    assert "<b>" not in term("skill", "<b>skills</b>")


def test_a_term_that_nobody_explains_is_none() -> None:
    with pytest.raises(KeyError):
        term("epistemology")


def test_the_page_gets_all_meanings_at_once() -> None:
    assert "data-terms" in table_html()
    assert "&#34;capture&#34;" in table_html()
