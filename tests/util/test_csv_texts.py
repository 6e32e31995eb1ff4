"""Tables for programs, and for spreadsheets."""

import csv
import io
import math

import pytest

from app.util import csv_texts

ROWS = [["line", "value"], ["Räuber, schnell", -50], ["=1+1", -0.5], ["", None], ["–", math.nan]]


def read(text: str) -> list[list[str]]:
    return [*csv.reader(io.StringIO(text.removeprefix("\ufeff"), newline=""))]


def test_programs_get_the_rows_as_they_are() -> None:
    text = csv_texts.for_programs(ROWS)
    assert text.startswith("line,value\r\n")
    assert read(text)[1:] == [
        ["Räuber, schnell", "-50"],
        ["=1+1", "-0.5"],
        ["", ""],
        ["–", ""],
    ]


def test_spreadsheets_get_the_same_with_a_mark_and_without_formulas() -> None:
    text = csv_texts.for_spreadsheets(ROWS)
    assert text.encode().startswith(b"\xef\xbb\xbfline,value\r\n")
    assert read(text)[1:] == [
        ["Räuber, schnell", "-50"],
        ["'=1+1", "-0.5"],
        ["", ""],
        ["–", ""],
    ]


@pytest.mark.parametrize(
    "cell", ["=1+1", "+1", "-5", "@SUM(A1)", "\t=1", "\r=1", "\n=1", "  =1", "\uff1d1", "\uff0d1"]
)
def test_a_text_is_no_formula(cell: str) -> None:
    assert read(csv_texts.for_spreadsheets([[cell, cell]])) == [[f"'{cell}", f"'{cell}"]]
    assert read(csv_texts.for_programs([[cell]])) == [[cell]]


@pytest.mark.parametrize("cell", [-50, -0.5, 0, 1e-9, "", "a=1", "'=1", "timed, a=-1", True])
def test_anything_else_stays_what_it_is(cell: object) -> None:
    assert read(csv_texts.for_spreadsheets([["", cell]])) == [["", str(cell)]]
