"""When value first came to the place under a click on the board."""

from typing import NamedTuple

import numpy as np

from app.explain.cell import sensed
from app.live.snapshot import Snapshot
from app.page.panels.inspection import cell_under
from app.picture.frames import in_frame
from app.picture.look import Look
from sim.world import cell_at


class Rise(NamedTuple):
    """That a state's value first rose above 0."""

    state: int
    """Its index in the flat ``(heading, distance, direction)`` table."""
    trial: int


def rise_under(snapshot: Snapshot, look: Look, place: tuple[float, float]) -> Rise | None:
    """The first rise at a place of the board; None off the grid, or where none was yet.

    Where all headings take part in a picture, that of the heading for which it came first.

    Args:
        snapshot: the moment that is shown.
        look: how the board is drawn.
        place: east and north of the prey, in board units.
    """
    cell = cell_under(place, snapshot.world.size)
    if cell is None:
        return None
    ring, direction = sensed(snapshot, cell_at(snapshot.world, *cell))
    numbers = np.arange(snapshot.first_reach.size).reshape(snapshot.first_reach.shape)
    states = in_frame(numbers, snapshot, look)[:, ring, direction]
    trials = snapshot.first_reach.ravel()[states]
    reached = trials >= 0
    if not reached.any():
        return None
    first = int(np.where(reached, trials, np.iinfo(trials.dtype).max).argmin())
    return Rise(int(states[first]), int(trials[first]))
