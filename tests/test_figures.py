"""Pictures of the value: what is drawn where, and in which colour."""

import io

import numpy as np
import pytest

from app import figures
from learners.measures import FoldedValue
from sim import geometry
from sim.spec import WorldSpec

EDGES = geometry.ring_edges(WorldSpec())
NOTHING = (244, 245, 247)


def png_of(distance: np.ndarray, share: np.ndarray) -> np.ndarray:
    """(y, x, 4) float32: the picture of one map without its scale, the first row at the top."""
    from matplotlib import image

    map_ = figures.ValueMap("a moment", FoldedValue(distance, share), 3)
    drawing = figures.draw_values("value", [map_], EDGES, 27, "small print")
    picture = image.imread(io.BytesIO(drawing.png))
    return picture[:, : picture.shape[1] * 3 // 4]


def middle_of(picture: np.ndarray, colour: tuple[int, int, int]) -> tuple[float, float]:
    """Mean place of all pixels of a colour, (x to the right, y upwards) in pixels."""
    same = np.abs(picture[:, :, :3] * 255 - colour).max(axis=2) < 3
    rows, columns = np.nonzero(same)
    assert rows.size > 100
    return float(columns.mean()), float(-rows.mean())


@pytest.mark.parametrize(
    ("direction", "to"), [(0, (1, 0)), (6, (0, 1)), (12, (-1, 0)), (18, (0, -1))]
)
def test_directions_go_counter_clockwise_from_the_right(
    direction: int, to: tuple[int, int]
) -> None:
    # All is known but for one sector, so that only there the paper is bare.
    share = np.ones((18, 24))
    share[:, direction] = 0
    picture = png_of(np.where(share > 0, 50.0, np.nan), share)
    bare = middle_of(picture, NOTHING)
    there = middle_of(picture, tuple(figures.value_colours(np.array(50.0), np.array(1.0))))
    offset = np.array(bare) - there
    assert np.argmax(np.abs(offset)) == np.argmax(np.abs(to))
    assert offset @ to > 100


def test_near_is_bright_and_far_is_dark_and_few_are_pale() -> None:
    near, far = figures.value_colours(np.array([1.0, 150.0]), np.array([1.0, 1.0])).astype(int)
    assert near.sum() > far.sum()
    pale = figures.value_colours(np.array([150.0]), np.array([0.1]))[0].astype(int)
    assert np.abs(pale - NOTHING).max() < np.abs(far - NOTHING).max()
    assert tuple(figures.value_colours(np.array([np.nan]), np.array([0.0]))[0]) == NOTHING
