"""Which variants stand for many."""

import math
from itertools import pairwise

from app.results.reference import told_of


def test_few_variants_are_all_told_of() -> None:
    assert told_of([3.0, math.nan, 1.0], 0, 8) == [0, 1, 2]


def test_of_many_the_ends_and_the_reference_are_among_those_told_of() -> None:
    values = [float(k * 37 % 56) for k in range(56)]
    places = told_of(values, 20, 8)
    assert len(places) == 8
    assert places == sorted(places)
    assert {20, values.index(min(values)), values.index(max(values))} <= {*places}
    ranks = sorted(values[place] for place in places if place != 20)
    gaps = [after - before for before, after in pairwise(ranks)]
    assert max(gaps) <= 2 * min(gaps)


def test_before_anything_is_known_the_first_ones_and_the_reference_are_told_of() -> None:
    assert told_of([math.nan] * 20, 9, 4) == [0, 1, 2, 9]
