"""Lines through maps over states, on maps whose lines are known."""

import numpy as np
import pytest

from app.picture.contours import edges, isolines, segments
from sim import geometry
from sim.spec import WorldSpec

WORLD = WorldSpec()
RINGS, SECTORS = WORLD.n_distances, WORLD.n_directions
WIDTH = 2 * np.pi / SECTORS
OUTER = geometry.ring_edges(WORLD)
MIDDLE = (OUTER + np.concatenate([[0], OUTER[:-1]])) / 2


def by_ring() -> np.ndarray:
    """A quantity that is the number of the ring."""
    return np.repeat(np.arange(RINGS, dtype=float)[:, None], SECTORS, axis=1)


def distance(points: np.ndarray) -> np.ndarray:
    return np.hypot(points[..., 0], points[..., 1])


def test_a_line_lies_between_the_middles_of_the_states_on_its_two_sides() -> None:
    between = isolines(by_ring(), WORLD, [4.25])
    assert [line.level for line in between] == [4.25]
    expected = 0.75 * MIDDLE[4] + 0.25 * MIDDLE[5]
    assert distance(between[0].points) == pytest.approx(expected)


def test_a_line_goes_all_round_the_prey_and_is_round() -> None:
    (line,) = isolines(by_ring(), WORLD, [9.0])
    turns = np.diff(np.unwrap(np.arctan2(line.points[:, 1], line.points[:, 0])))
    assert abs(turns.sum()) == pytest.approx(2 * np.pi)
    assert np.degrees(np.abs(turns).max()) <= 4.01


def test_a_line_across_rings_points_away_from_the_prey() -> None:
    by_sector = np.tile(np.abs(np.arange(SECTORS) - 6.0), (RINGS, 1))
    lines = isolines(by_sector, WORLD, [3.0])
    bearings = {
        round(float(np.degrees(np.arctan2(y, x)))) for line in lines for x, y in line.points
    }
    assert bearings == {round(np.degrees(sector * WIDTH)) for sector in (3, 9)}


def test_no_line_runs_where_nothing_is_known() -> None:
    known = by_ring()
    known[:, :12] = np.nan
    ((_, points),) = isolines(known, WORLD, [8.0])
    # The other twelve sectors are those south of the prey.
    assert points[:, 1].max() <= 1e-9
    assert not isolines(np.full((RINGS, SECTORS), np.nan), WORLD, [1.0])


def test_each_level_has_its_lines_and_one_that_is_not_met_has_none() -> None:
    lines = isolines(by_ring(), WORLD, [2.5, 5.5, 99.0])
    assert [line.level for line in lines] == [2.5, 5.5]


def region(*states: tuple[int, int]) -> np.ndarray:
    """The region of some states, by ring and sector."""
    inside = np.zeros((RINGS, SECTORS), bool)
    for state in states:
        inside[state] = True
    return inside


def length_of(parts: np.ndarray) -> float:
    return float(distance(parts[:, 1] - parts[:, 0]).sum())


def test_the_edge_of_one_state_are_two_arcs_and_two_rays() -> None:
    parts = edges(region((6, 3)), WORLD)
    inner, outer = OUTER[5], OUTER[6]
    expected = (inner + outer) * WIDTH + 2 * (outer - inner)
    assert length_of(parts) == pytest.approx(expected, rel=1e-3)
    assert distance(parts).min() == pytest.approx(inner)
    assert distance(parts).max() == pytest.approx(outer)
    bearing = np.arctan2(parts[..., 1], parts[..., 0])
    assert bearing.min() == pytest.approx(2.5 * WIDTH)
    assert bearing.max() == pytest.approx(3.5 * WIDTH)


def test_between_states_of_a_region_there_is_no_edge() -> None:
    two = edges(region((6, SECTORS - 1), (6, 0)), WORLD)
    alone = edges(region((6, 0)), WORLD)
    rays = 2 * (OUTER[6] - OUTER[5])
    assert length_of(two) == pytest.approx(2 * length_of(alone) - rays, rel=1e-3)


def test_neither_nothing_nor_everything_has_an_edge() -> None:
    everything = np.ones((RINGS, SECTORS), bool)
    assert len(edges(everything, WORLD)) == len(edges(~everything, WORLD)) == 0


def test_a_line_of_points_is_its_segments() -> None:
    points = np.array([[0.0, 0], [1, 0], [1, 2]])
    assert segments(points).tolist() == [[[0, 0], [1, 0]], [[1, 0], [1, 2]]]
