"""The markup of lessons: two signs, and whatever else is written stays a text."""

import html
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.lessons.markup import html_of, plain_of

SIGNS = st.text(st.sampled_from("*`<>&\"' \nab"), max_size=40) | st.text(max_size=40)
TAGS = re.compile("</?(?:b|code|br)>")


@pytest.mark.parametrize(
    ("text", "shown", "plain"),
    [
        ("A **cone** of `Q`.", "A <b>cone</b> of <code>Q</code>.", "A cone of Q."),
        ("**two words** here", "<b>two words</b> here", "two words here"),
        ("**a** and **b**", "<b>a</b> and <b>b</b>", "a and b"),
        ("2 ** 3 ** 4", "2 ** 3 ** 4", "2 ** 3 ** 4"),
        ("**open", "**open", "**open"),
        ("****", "****", "****"),
        ("*****", "*****", "*****"),
        ("`**a**`", "<code>**a**</code>", "**a**"),
        ("**`a`**", "<b>`a`</b>", "`a`"),
        ("<b>a</b> & b", "&lt;b&gt;a&lt;/b&gt; &amp; b", "<b>a</b> & b"),
        ("**<i>**", "<b>&lt;i&gt;</b>", "<i>"),
        ("one\ntwo\n", "one<br>two", "one\ntwo\n"),
    ],
)
def test_bold_and_code_are_marked_and_nothing_else_is(text: str, shown: str, plain: str) -> None:
    assert html_of(text) == shown
    assert plain_of(text) == plain


@given(SIGNS)
@settings(max_examples=150, deadline=None)
def test_whatever_is_written_there_are_no_other_tags(text: str) -> None:
    without = TAGS.sub("", html_of(text))
    assert not set(without) & set("<>\"'")


@given(st.text(st.sampled_from("*`<>&\"' ab"), max_size=40))
@settings(max_examples=100, deadline=None)
def test_what_is_shown_reads_as_the_plain_text(text: str) -> None:
    assert html.unescape(TAGS.sub("", html_of(text))).strip() == plain_of(text).strip()
