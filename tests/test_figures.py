"""Pictures of the value: what is drawn where, and in which colour."""

import io

import numpy as np
import pytest

from app import figures
from app.statistics import Estimate
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


# --- Planes of differences -----------------------------------------------------------------------


def difference(value: float, arm: float) -> Estimate:
    return Estimate(value, value - arm, value + arm, 5)


def test_differences_are_coloured_around_zero_however_lopsided_they_are() -> None:
    """The lowest is deep red and what is as far above 0 would be deep blue: +1 is nearly white."""
    from matplotlib import colormaps, image

    axles = figures.Axle("x", (1, 2, 3)), figures.Axle("y", (1,))
    cells = {(0, 0): difference(-20.0, 1), (2, 0): difference(1.0, 0.5)}
    drawing = figures.draw_differences("plane", axles, cells, (1, 0), "difference", "small print")
    picture = image.imread(io.BytesIO(drawing.png))[:, :, :3]
    # The scale beside the cells has all colours, in the right third of the picture.
    cells_only = picture[:, : picture.shape[1] * 2 // 3].reshape(-1, 3)
    scale = colormaps["RdBu"]
    for at in (0.0, 0.5, (1 + 1 / 20) / 2):
        assert (np.abs(cells_only - scale(at)[:3]).max(axis=1) < 0.01).sum() > 1_000
    assert not (np.abs(cells_only - scale(1.0)[:3]).max(axis=1) < 0.01).any()
    rows = drawing.csv.splitlines()
    assert rows[1:] == ["1,1,-20.0,-21.0,-19.0,5", "3,1,1.0,0.5,1.5,5"]


def test_an_interval_that_does_not_exist_excludes_nothing() -> None:
    assert figures.excludes_zero(difference(-2.0, 1))
    assert figures.excludes_zero(difference(2.0, 1))
    assert not figures.excludes_zero(difference(1.0, 1))
    assert not figures.excludes_zero(Estimate(5.0, np.nan, np.nan, 1))


def test_large_whole_values_have_a_comma() -> None:
    shown = [figures.grouped(value) for value in (999, 1_500, 24_000, 0.95, "a", -2_000)]
    assert shown == ["999", "1,500", "24,000", "0.95", "a", "-2,000"]
