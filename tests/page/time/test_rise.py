"""When value first came to a place under a click."""

import numpy as np
import pytest

from app.explain.cell import sensed
from app.page.panels.inspection import cell_under
from app.page.time.rise import rise_under
from app.picture.look import FOLDED, Look
from learners.run import Run
from sim.world import cell_at
from tests.support.schedules import seen, small_run, to

PLACES = [(0.5, 0.0), (-1.0, 0.4), (-2.0, -2.0), (-0.6, 0.0), (3.0, 3.0)]


@pytest.fixture(scope="module")
def run() -> Run:
    return to(small_run(), 300)


@pytest.mark.parametrize("place", PLACES)
def test_of_one_heading_it_is_the_state_under_the_click(
    run: Run, place: tuple[float, float]
) -> None:
    shot = seen(run)
    cell = cell_under(place, shot.world.size)
    assert cell is not None
    ring, direction = sensed(shot, cell_at(shot.world, *cell))
    for heading in range(8):
        trial = int(shot.first_reach[heading, ring, direction])
        rise = rise_under(shot, Look(frame=heading), place)
        assert (rise is None) == (trial < 0)
        if rise is not None:
            where = np.unravel_index(rise.state, shot.first_reach.shape)
            assert tuple(map(int, where)) == (heading, ring, direction)
            assert rise.trial == trial


def test_where_all_headings_take_part_it_is_the_first_of_theirs(run: Run) -> None:
    shot = seen(run)
    found = [rise_under(shot, Look(frame=FOLDED), place) for place in PLACES]
    rises = [rise for rise in found if rise is not None]
    assert rises
    for rise in rises:
        assert shot.first_reach.ravel()[rise.state] == rise.trial
    each = [rise_under(shot, Look(frame=0), place) for place in PLACES]
    for folded, one in zip(found, each, strict=True):
        # A prey that looks east is one of the eight.
        if one is not None:
            assert folded is not None
            assert folded.trial <= one.trial


def test_off_the_grid_there_is_none(run: Run) -> None:
    assert rise_under(seen(run), Look(), (99.0, 0.0)) is None
