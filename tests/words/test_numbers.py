"""Numbers as people read them, and round marks along axes."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.words.numbers import (
    counted,
    duration,
    in_millions,
    in_short,
    labelled_ticks,
    megabytes,
    of_any_size,
    rate_in_short,
    round_numbers,
    shared_form,
    shown_number,
    significant,
    speed_in_words,
    ticks,
)
from learners.names import MAX_TRIALS

ends = st.floats(-1e6, 1e6)
spans = st.floats(1e-6, 1e6)


def test_one_thing_has_no_s() -> None:
    assert [counted(n, "run") for n in (0, 1, 1_200)] == ["0 runs", "1 run", "1,200 runs"]


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (0, "0"),
        (9_999, "9,999"),
        (9_999.6, "10 k"),
        (999_499, "999 k"),
        (1_234_000, "1.23 M"),
        (2e9, "2,000 M"),
    ],
)
def test_steps_are_short(number: float, text: str) -> None:
    assert in_short(number) == text


def test_an_axis_has_its_own_limits_of_what_is_short() -> None:
    trials = (0, 500, 20_000, 500_000, 1_500_000)
    assert [in_short(n, k_from=1e5) for n in trials] == ["0", "500", "20,000", "500 k", "1.5 M"]
    assert [in_short(n, m_from=1e5) for n in (9_000, 250_000)] == ["9,000", "0.25 M"]


def test_millions_have_two_decimals_and_no_unit() -> None:
    assert [in_millions(n) for n in (0, 384_000, 2.41e6, math.nan)] == ["0.00", "0.38", "2.41", "–"]


@pytest.mark.parametrize(
    ("rate", "text"),
    [
        (0.0, "0"),
        (99.4, "99"),
        (997.0, "1 k"),
        (1_995.0, "2 k"),
        (6_313.0, "6.3 k"),
        (20_480.0, "20 k"),
        (999_600.0, "1 M"),
        (24_560_000.0, "25 M"),
    ],
)
def test_a_rate_has_two_digits_that_hold(rate: float, text: str) -> None:
    assert rate_in_short(rate) == text


def test_a_speed_of_one_step_has_no_s() -> None:
    assert [speed_in_words(n) for n in (1.2, 25_000)] == ["1 step/s", "25 k steps/s"]


@pytest.mark.parametrize(
    ("seconds", "words"), [(0.2, "0 s"), (89, "89 s"), (600, "10 min"), (36_000, "10.0 h")]
)
def test_times_are_short(seconds: float, words: str) -> None:
    assert duration(seconds) == words


def test_no_file_takes_no_room() -> None:
    assert [megabytes(n) for n in (0, 4_200_000, 2e9)] == ["0.1 MB", "4.2 MB", "2,000.0 MB"]


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [
        (80.0, ".3g", "80"),
        (80.0, "#.3g", "80.0"),
        (100.0, "#.3g", "100"),
        (12345.6, "#.3g", "12,346"),
        (-3.0, "#.3g", "\N{MINUS SIGN}3.00"),
        (-0.25, ".1f", "\N{MINUS SIGN}0.2"),
        (math.nan, ".3g", "\N{EN DASH}"),
        (math.inf, ".3g", "never"),
    ],
)
def test_measured_values_have_as_many_digits(value: float, form: str, text: str) -> None:
    assert shown_number(value, form) == text


@pytest.mark.parametrize(
    ("amount", "text"),
    [
        (0, "0"),
        (1e-9, "0"),
        (0.0001, "0.0001"),
        (0.5, "0.5"),
        (7.07, "7.1"),
        (14.1, "14"),
        (100, "100"),
        (49_900, "49.9 k"),
        (1e6, "1 M"),
    ],
)
def test_amounts_of_any_size_are_short(amount: float, text: str) -> None:
    assert of_any_size(amount) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (100.0, "100"),
        (-50.0, "\N{MINUS SIGN}50"),
        (12.413, "12.4"),
        (4_321.0, "4320"),
        (0.07294, "0.0729"),
        (0.00000123456, "0.00000123"),
        (1.23e-20, "1.23e\N{MINUS SIGN}20"),
    ],
)
def test_digits_that_mean_something_are_shown_however_small_a_value_is(
    value: float, text: str
) -> None:
    assert significant(value) == text


# Marks of axes


def test_round_numbers_go_upwards_from_the_least() -> None:
    found = round_numbers(40)
    assert [next(found) for _ in range(5)] == [50, 100, 200, 500, 1_000]


@pytest.mark.parametrize(
    ("end", "most", "least", "expected"),
    [
        (1, 8, 1, [0, 1]),
        (100, 8, 1, [0, 20, 40, 60, 80, 100]),
        (48_000, 8, 1, [0, 10_000, 20_000, 30_000, 40_000]),
        (2_000_000, 8, 1, [0, 500_000, 1_000_000, 1_500_000, 2_000_000]),
        (1_000, 4, 1e-12, [0, 500, 1_000]),
        (4_000, 4, 1e-12, [0, 1_000, 2_000, 3_000, 4_000]),
        (286_544, 4, 1e-12, [0, 100_000, 200_000]),
        (5_500_000, 4, 1e-12, [0, 2_000_000, 4_000_000]),
    ],
)
def test_ticks_are_round(end: int, most: int, least: float, expected: list[int]) -> None:
    assert ticks(0, end, most, least) == expected


@given(end=st.integers(1, MAX_TRIALS), most=st.sampled_from([4, 8]))
def test_ticks_of_trials_are_whole_and_evenly_spaced(end: int, most: int) -> None:
    found = ticks(0, end, most, least=1)
    assert 2 <= len(found) <= most + 1
    assert found[0] == 0
    assert found[-1] <= end < 2 * found[-1] + 1
    assert len(set(np.diff(found))) == 1
    assert str(int(found[1])).rstrip("0") in ("1", "2", "5")


@given(low=ends, span=spans, most=st.integers(2, 10))
def test_ticks_lie_between_the_ends_and_their_labels_differ(
    low: float, span: float, most: int
) -> None:
    found = labelled_ticks(low, low + span, most)
    assert len(found) <= most + 1
    assert all(low - 1e-6 * span <= tick <= low + span * (1 + 1e-6) for tick, _ in found)
    texts = [text for _, text in found]
    assert len(set(texts)) == len(texts)
    assert all("-" not in text for text in texts)


def test_numbers_of_a_column_have_as_many_decimals() -> None:
    for numbers, form in (
        ([78.1, 0.5, 101.0], ".1f"),
        ([-0.941, 1.05], ".3f"),
        ([1.05, 1.2], ".2f"),
        ([5_500_000.0], ".0f"),
        ([0.0, math.nan], ".2f"),
        ([], ".2f"),
    ):
        assert shared_form(numbers) == form
