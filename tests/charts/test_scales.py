"""Ends of a scale of colours, and which points of a curve are joined."""

import math

import numpy as np

from app.charts.greedy import joined_up
from app.charts.scales import colour_ends


def test_a_few_numbers_far_away_take_no_colours_from_the_others_and_are_spoken_of() -> None:
    near = [78 + 0.1 * k for k in range(40)]
    ends = colour_ends([*near, 12.0, math.nan])
    assert (ends.low, ends.high) == (78, max(near))
    assert (ends.below, ends.above) == (1, 0)
    assert ends.share(12.0) == 0
    assert ends.in_words("cell", "78 to 81.9") == "Colours go from 78 to 81.9; 1 cell is lower."


def test_numbers_that_are_far_apart_all_over_have_all_colours() -> None:
    for numbers in ([1.0, 2, 3, 90, 95, 100], [5.0] * 10 + [50.0] * 3, [0.0, 1.0]):
        ends = colour_ends(numbers)
        assert (ends.low, ends.high) == (min(numbers), max(numbers))
        assert ends.in_words("cell", "") == ""


def test_there_is_a_scale_of_one_number_and_of_none() -> None:
    for numbers in ([3.0], [0.0], [], [math.nan]):
        ends = colour_ends(numbers)
        assert ends.low < ends.high


def test_points_are_joined_but_where_they_are_far_apart() -> None:
    at = np.asarray([0.0, 1, 2, 3, 40, 41, 42])
    assert [[*at[part]] for part in joined_up(at)] == [[0, 1, 2, 3], [40, 41, 42]]
    assert len(joined_up(np.asarray([0.0, 1, 2, 3]))) == 1
    assert len(joined_up(np.asarray([0.0]))) == 1
