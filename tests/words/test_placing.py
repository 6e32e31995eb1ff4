"""Labels beside one another along a line."""

import itertools

from hypothesis import given
from hypothesis import strategies as st

from app.words.placing import Room

places = st.floats(-10, 110)
widths = st.floats(0.5, 60)


def test_what_is_taken_is_not_free() -> None:
    room = Room(0, 100)
    assert room.taken(20, 40)
    assert not room.taken(30, 50)
    assert room.taken(40, 50)
    assert not room.taken(-1, 10)
    assert not room.taken(95, 101)


def test_the_nearest_room_is_before_a_place_or_after_it() -> None:
    room = Room(0, 100)
    room.take(30, 50)
    assert room.take_nearest(20, 40, within=20) == (30, True)
    assert room.take_nearest(20, 40, within=20) == (50, False)
    assert room.take_nearest(20, 40, within=20) is None
    assert room.take_nearest(10, 40, within=100) == (10, True)
    assert room.take_nearest(90, 40, within=100) is None


@given(wanted=st.lists(st.tuples(places, widths), max_size=12))
def test_nothing_lies_over_another(wanted: list[tuple[float, float]]) -> None:
    room, spans = Room(0, 100), []
    for place, width in wanted:
        if room.taken(place, place + width):
            spans.append((place, place + width))
        elif (spot := room.take_nearest(width, place, within=30)) is not None:
            edge, is_before = spot
            spans.append((edge - width, edge) if is_before else (edge, edge + width))
    spans.sort()
    assert all(low >= -1e-9 and high <= 100 + 1e-9 for low, high in spans)
    assert all(one[1] <= other[0] + 1e-9 for one, other in itertools.pairwise(spans))
