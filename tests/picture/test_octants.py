"""The octants round the prey: which places are in which, and what is drawn of them."""

import math

import numpy as np
import pytest

from app.picture import octants
from app.picture.octants import OCTANTS, Fill
from sim import geometry
from sim.geometry import HEADINGS
from sim.spec import WorldSpec

UNITS, SIDE = 12.0, 60
headings = pytest.mark.parametrize("heading", range(8))


def has(octant: str, points: np.ndarray, heading: int = 0) -> list[bool]:
    return [octants.octant_at(east, north, heading) == octant for east, north in points]


def test_they_go_counter_clockwise_from_straight_ahead_on() -> None:
    for octant, (east, north) in zip(OCTANTS, HEADINGS, strict=True):
        assert octants.octant_at(float(east), float(north)) == octant
        assert octants.octant_at(*octants.middle(octant, 3.0)) == octant


@headings
@pytest.mark.parametrize("size", [31, 40])
def test_each_cell_but_the_preys_is_in_one_octant_and_none_is_on_a_border(
    size: int, heading: int
) -> None:
    east, north = geometry.offsets(WorldSpec(size=size))
    for x, y in zip(east.ravel().tolist(), north.ravel().tolist(), strict=True):
        octant = octants.octant_at(x, y, heading)
        if (x, y) == (0, 0):
            assert octant is None
            continue
        assert octant in OCTANTS
        # By the angle to each middle, of which the nearest is nearer than any other by far.
        middles = [octants.middle(o, 1.0, heading) for o in OCTANTS]
        nearness = sorted((x * e + y * n) / math.hypot(x, y) for e, n in middles)
        assert nearness[-1] - nearness[-2] > 1e-6
        e, n = octants.middle(octant, 1.0, heading)
        assert (x * e + y * n) / math.hypot(x, y) == pytest.approx(nearness[-1])


def test_a_turned_prey_has_its_octants_with_it() -> None:
    for number, octant in enumerate(OCTANTS):
        east, north = (float(part) for part in HEADINGS[number])
        # Whatever it looks at is ahead.
        assert octants.octant_at(east, north, heading=number) == "e"
        turned = OCTANTS[(number + 3) % 8]
        assert octants.middle(octant, 2.0, heading=3) == pytest.approx(octants.middle(turned, 2.0))


@headings
def test_what_is_drawn_of_an_octant_lies_in_it(heading: int) -> None:
    for octant in OCTANTS:
        edge = octants.outline(octant, 0.5, 5.5, 0.06, heading)
        assert edge[0].tolist() == edge[-1].tolist()
        assert all(has(octant, edge, heading))
        assert np.hypot(*edge.T) == pytest.approx(np.clip(np.hypot(*edge.T), 0.5, 5.5))
        lines = octants.hatch(octant, 0.5, 5.5, 0.4, heading)
        assert len(lines) > 4
        assert all(has(octant, lines.reshape(-1, 2), heading))


def test_borders_lie_between_neighbours() -> None:
    for number, line in enumerate(octants.borders(0.5, 5.5)):
        angles = np.arctan2(line[:, 1], line[:, 0]) % (2 * np.pi)
        assert angles == pytest.approx((number + 0.5) * np.pi / 4)


def test_fills_are_where_they_are_said_to_be() -> None:
    picture = octants.filled([Fill("w", 1.0, 5.0, (10, 20, 30), 0.5)], UNITS, SIDE)
    assert picture.shape == (SIDE, SIDE, 4)

    def at(east: float, north: float) -> list[int]:
        row, column = (int((part / UNITS + 0.5) * SIDE) for part in (north, east))
        return picture[row, column].tolist()

    assert at(-3.0, 0.0) == [10, 20, 30, 128]
    assert [at(*place)[3] for place in [(3, 0), (-0.4, 0), (-5.8, 0), (-2, 2), (0, 3)]] == [0] * 5
    # Rows go from the south on.
    south = octants.filled([Fill("s", 1.0, 5.0, (10, 20, 30), 0.5)], UNITS, SIDE)
    assert south[SIDE // 4, SIDE // 2, 3] == 128
    assert south[-SIDE // 4, SIDE // 2, 3] == 0
    turned = octants.filled([Fill("w", 1.0, 5.0, (10, 20, 30), 0.5)], UNITS, SIDE, heading=2)
    assert (turned == south).all()


def test_the_later_fill_lies_over_the_earlier() -> None:
    below, above = Fill("n", 0.5, 5.5, (200, 0, 0), 1.0), Fill("n", 0.5, 5.5, (0, 0, 200), 0.5)
    picture = octants.filled([below, above], UNITS, SIDE)
    assert picture[3 * SIDE // 4, SIDE // 2].tolist() == [100, 0, 100, 255]
    assert not octants.filled([], UNITS, SIDE).any()
    assert not octants.filled([Fill("n", 0.5, 5.5, (200, 0, 0), 0.0)], UNITS, SIDE)[..., 3].any()
