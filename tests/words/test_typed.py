"""What a person types is what is taken, or it is refused with the reason."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.words.typed import NumeralError, decimal, plain, whole

BLANKS = {
    "space": " ",
    "no-break space": "\u00a0",
    "thin space": "\u2009",
    "figure space": "\u2007",
    "narrow no-break space": "\u202f",
    "ideographic space": "\u3000",
}


@pytest.mark.parametrize("blank", BLANKS.values(), ids=BLANKS)
def test_any_blank_groups_digits(blank: str) -> None:
    assert whole(f"12{blank}000", 0, 10**6) == 12_000
    assert decimal(f"12{blank}000", 0, 10**6) == 12_000
    assert decimal(f"12{blank}000,5", 0, 10**6) == 12_000.5


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("12000", 12_000),
        (" 12000\n", 12_000),
        ("+12000", 12_000),
        ("12,000", 12_000),
        ("12.000", 12_000),
        ("12'000", 12_000),
        ("12\u2019000", 12_000),
        ("12_000", 12_000),
        ("1,234,567", 1_234_567),
        ("1.234.567", 1_234_567),
        ("12,34,567", 1_234_567),
        ("1e3", 1_000),
        ("1E+3", 1_000),
        ("1.5e3", 1_500),
        ("1,5e3", 1_500),
        ("1.234e3", 1_234),
        ("007", 7),
        ("-40", -40),
        ("\u221240", -40),
        ("\u2212 40", -40),
        ("\u201340", -40),
        ("\uff0d\uff14\uff10", -40),
        ("\u0661\u0662\u066c\u0660\u0660\u0660", 12_000),
        ("\u200e12\u200f", 12),
        ("9223372036854775807", 2**63 - 1),
    ],
)
def test_a_whole_number_is_taken_as_it_was_meant(text: str, meant: int) -> None:
    assert whole(text, -(10**19), 10**19) == meant


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("150.5", 150.5),
        ("150,5", 150.5),
        (".5", 0.5),
        (",5", 0.5),
        ("5.", 5.0),
        ("0,500", 0.5),
        ("1.234", 1.234),
        ("1,2345", 1.2345),
        ("1234,567", 1234.567),
        ("1,234.5", 1234.5),
        ("1.234,5", 1234.5),
        ("1 234,567", 1234.567),
        ("1\u066b234", 1.234),
        ("1e-3", 0.001),
        ("1,5E2", 150.0),
        ("\u22120,5", -0.5),
    ],
)
def test_a_decimal_is_taken_as_it_was_meant(text: str, meant: float) -> None:
    assert decimal(text, -1e6, 1e6) == meant


@pytest.mark.parametrize("text", ["1,234", "12,000", "-1,234", "\uff11\uff0c\uff12\uff13\uff14"])
def test_what_can_mean_two_decimals_is_refused_with_both(text: str) -> None:
    with pytest.raises(NumeralError, match=r"not taken: it could be -?\d.* or -?\d.*; allowed:"):
        decimal(text, -1e6, 1e6)


def test_both_readings_are_said() -> None:
    with pytest.raises(NumeralError, match="not taken: it could be 12 or 12000; allowed: a number"):
        decimal("12,000", 0, 1e6)
    with pytest.raises(NumeralError, match="it could be 1234 or 1234000"):
        whole("1,234e3", 0, 10**9)


@pytest.mark.parametrize(
    "text",
    [
        "",
        " \u00a0",
        "-",
        ".",
        "e5",
        "1e",
        "twelve",
        "12k",
        "12 steps",
        "--5",
        "40-",
        "0x10",
        "0o14",
        "1:30",
        "inf",
        "-.inf",
        "nan",
        "\u00bd",
        "10\u00b2",
        "1,00,0",
        "1 0000",
        "1_0",
        "1,000_000",
        "1,,000",
        "12\n000",
        "12\x00",
        "\ud8001",
        "50 %",
        "9" * 10_000,
        "1e999999999",
        "1e999",
    ],
)
def test_what_is_no_number_is_refused(text: str) -> None:
    for read in (whole, decimal):
        with pytest.raises(NumeralError, match=r"^not taken: .*; allowed: a .*number, 0 to 100$"):
            read(text, 0, 100)


@pytest.mark.parametrize("text", ["12.5", "12,00", "12.0", "0.500", "1,234.0"])
def test_a_whole_number_has_no_decimal_mark(text: str) -> None:
    with pytest.raises(NumeralError, match="not taken: it has a decimal mark; allowed: a whole"):
        whole(text, 0, 10**6)
    with pytest.raises(NumeralError, match="it is no whole number"):
        whole("12.5e0", 0, 10**6)


def test_limits_are_allowed_and_nothing_beyond() -> None:
    assert (whole("1", 1, 5), whole("5", 1, 5)) == (1, 5)
    assert (decimal("0,1", 0.1, 0.3), decimal("0,3", 0.1, 0.3)) == (0.1, 0.3)
    with pytest.raises(NumeralError, match="it is too small; allowed: a whole number, 1 to 5"):
        whole("0", 1, 5)
    with pytest.raises(NumeralError, match=r"it is too large; allowed: a number, 0\.1 to 0\.3"):
        decimal("0.30001", 0.1, 0.3)


def test_percent_is_for_shares() -> None:
    for text in ("50%", "50 %", "50\u202f\uff05", "0.5", "50\u066a", "5e1 %"):
        assert decimal(text, 0, 1, share=True) == 0.5
    assert decimal("12,5 %", 0, 1, share=True) == 0.125
    with pytest.raises(NumeralError, match="it is too large"):
        decimal("50", 0, 1, share=True)
    with pytest.raises(NumeralError, match="it is empty"):
        decimal("%", 0, 1, share=True)


@given(st.integers(-(10**18), 10**18))
def test_a_whole_number_is_taken_however_it_is_written(number: int) -> None:
    for text in (f"{number}", f"{number:,}", f"{number:_}", f"{number:,}".replace(",", "\u202f")):
        assert whole(text, -(10**18), 10**18) == number


@given(st.floats(-1e20, 1e20))
def test_a_decimal_is_taken_as_programs_write_it(number: float) -> None:
    assert decimal(repr(number), -1e20, 1e20) == number
    assert decimal(plain(number), -1e21, 1e21) == pytest.approx(number, rel=1e-11)


@given(st.text(max_size=12))
def test_no_text_does_anything_else(text: str) -> None:
    for read in (whole, decimal):
        try:
            number = read(text, -5, 5)
        except NumeralError:
            continue
        assert -5 <= number <= 5
