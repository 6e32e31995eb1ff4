"""Moments whose tables are small enough to check by hand.

The board has 20 x 20 cells with the prey at (10, 10), eight directions and four rings. The rings'
outer edges are 14.14 * (k / 4)^1.5: 1.77, 5.00, 9.19 and 14.14 cells. The prey faces east and sees
27 * 20 / 120 = 4.5 cells far.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from app.live import snapshot
from app.live.snapshot import Snapshot
from learners.names import MOVES
from learners.run import Run
from learners.spec import RunSpec
from sim.geometry import HEADINGS
from sim.geometry import MOVES as WAYS

EAST, NORTH, WEST = 0, 2, 4
APPROACH, CIRCLE = 0, 1


def move_towards(heading: int) -> int:
    """Number of the move that way."""
    return WAYS.tolist().index(HEADINGS[heading].tolist())


MOVE_EAST, MOVE_WEST, MOVE_NORTH = (move_towards(heading) for heading in (EAST, WEST, NORTH))


def moment(
    options: Sequence[str] | str = ("approach", "circle_clockwise"), **world: int
) -> Snapshot:
    """An untrained learner in the small world; approach goes straight for the prey.

    ``world`` is what is stated of it besides.
    """
    spec = RunSpec.model_validate(
        {
            "world": {"size": 20, "n_directions": 8, "n_distances": 4, **world},
            "learner": {
                "options": options if options == MOVES else tuple(options),
                "alpha": 0.1,
            },
            "trials": 10,
        }
    )
    taken = snapshot.take(Run(spec, seed=0), "by hand", generation=1)
    skill_q = np.zeros_like(taken.skill_q)
    if len(skill_q):
        for direction in range(8):
            skill_q[APPROACH, :, direction, move_towards((direction + 4) % 8)] = 1
    return replace(taken, skill_q=skill_q)


def valued(taken: Snapshot, entries: dict[tuple[int, int, int, int], float]) -> Snapshot:
    """The same moment with some entries ``(heading, ring, direction, option)`` of the table."""
    selection_q = taken.selection_q.copy()
    for key, value in entries.items():
        selection_q[key] = value
    return replace(taken, selection_q=selection_q, value=selection_q.max(axis=-1))


def way_from_behind() -> Snapshot:
    """A table that knows the way from straight behind the prey, and what waits before it."""
    return valued(
        moment(),
        {
            (EAST, 0, WEST, APPROACH): 99,
            (EAST, 1, WEST, APPROACH): 80,
            (EAST, 1, WEST, CIRCLE): 5,
            (EAST, 2, WEST, APPROACH): 60,
            (EAST, 2, EAST, APPROACH): -20,
            (EAST, 2, EAST, CIRCLE): -30,
            (EAST, 1, EAST, APPROACH): -45,
            (EAST, 1, EAST, CIRCLE): -46,
        },
    )
