"""The round board of all headings, and the square of one."""

import numpy as np
import pytest

from app.picture import outlines
from app.picture.contours import Contour
from app.picture.outlines import BOARD_UNITS
from sim.spec import WorldSpec

WORLD = WorldSpec()
RIM = 59.5 / 120 * BOARD_UNITS
shapes = pytest.mark.parametrize("is_round", [True, False], ids=["round", "square"])


def distance(points: np.ndarray) -> np.ndarray:
    return np.hypot(points[..., 0], points[..., 1])


def test_the_round_board_lies_on_the_square_of_every_heading() -> None:
    assert distance(outlines.border(WORLD, is_round=True)) == pytest.approx(RIM)
    low, high = outlines.edges(WORLD)
    assert min(-low, high) >= RIM


@shapes
def test_whatever_is_drawn_of_the_board_lies_on_it(is_round: bool) -> None:
    for lines in (outlines.grid(WORLD, is_round), outlines.sensors(WORLD, is_round)):
        assert len(lines) > 10
        # As good as on it: the ends of lines are on the edge itself.
        assert outlines.is_on_board(lines * (1 - 1e-9), WORLD, is_round).all()


@shapes
def test_what_leaves_the_board_is_drawn_at_its_edge(is_round: bool) -> None:
    corner = np.array([[5.8, 5.8], [-7.0, 0.5], [1.0, 2.0]])
    kept = outlines.kept_on_board(corner, WORLD, is_round)
    assert kept[2].tolist() == [1.0, 2.0]
    assert outlines.is_on_board(kept * (1 - 1e-9), WORLD, is_round).all()
    if is_round:
        assert distance(kept[:2]) == pytest.approx(RIM)
        assert np.arctan2(*kept[0]) == pytest.approx(np.arctan2(*corner[0]))


def test_contours_keep_their_colours_and_end_with_the_board() -> None:
    near = np.array([[[10.0, 0], [20, 0]]])
    far = np.array([[[55.0, 55], [58, 58]], [[0, -30], [0, -40]]])
    contours = [Contour(far, (1, 2, 3)), Contour(near, (7, 8, 9))]
    lines, colours = outlines.contour_lines(contours, WORLD, is_round=True)
    assert (lines * 10).tolist() == [[[0, -30], [0, -40]], [[10, 0], [20, 0]]]
    assert colours.tolist() == [[[1, 2, 3]] * 2, [[7, 8, 9]] * 2]
    assert len(outlines.contour_lines(contours, WORLD, is_round=False)[0]) == 3
    assert len(outlines.contour_lines([], WORLD, is_round=True)[0]) == 0
