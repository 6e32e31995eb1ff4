"""Which headings take part in a picture: all eight, turned so that the prey faces east, or one.

Layers work on arrays over states, ``(heading, distance, direction, ...)``, of those that do.
"""

import functools

import numpy as np

from app.live.snapshot import Snapshot
from app.picture.look import ALL, FOLDED, Look, heading_shown
from app.words.plain import HEADING_NAMES
from sim import geometry
from sim.geometry import N_MOVES
from sim.spec import N_HEADINGS, WorldSpec


def folds(look: Look) -> bool:
    """Whether all headings take part, turned."""
    return look.frame == FOLDED


def in_frame(per_heading: np.ndarray, snapshot: Snapshot, look: Look) -> np.ndarray:
    """Maps of the headings that take part, ``(heading, distance, direction, ...)``.

    All eight, turned, where the picture is folded, or as they are where they are side by side;
    otherwise one, as it is.
    """
    if look.frame == ALL:
        return per_heading
    if not folds(look):
        heading = heading_shown(look, snapshot.heading)
        return per_heading[heading : heading + 1]
    _, n_distances, n_directions = per_heading.shape[:3]
    flat = per_heading.reshape(-1, *per_heading.shape[3:])
    return flat.take(_fold_index(n_distances, n_directions), axis=0)


def rim(world: WorldSpec) -> float:
    """Radius of the board of a folded picture, in cells.

    Of the largest circle on the board: however the square is turned, all headings have that.
    """
    return world.size - 0.5 - world.size // 2


@functools.lru_cache(maxsize=8)
def _fold_index(n_distances: int, n_directions: int) -> np.ndarray:
    """(heading, distance, direction) int64: the state that each turned state was."""
    shape = (N_HEADINGS, n_distances, n_directions)
    return geometry.fold(np.arange(np.prod(shape)).reshape(shape), n_directions)


def is_of_one(look: Look) -> bool:
    """Whether one heading is shown, and no other."""
    return look.frame not in (FOLDED, ALL)


def facing(snapshot: Snapshot, look: Look) -> str:
    """Where the prey looks in the picture, in words."""
    return HEADING_NAMES[heading_shown(look, snapshot.heading)]


def _turned_moves() -> np.ndarray:
    number = {(int(x), int(y)): move for move, (x, y) in enumerate(geometry.MOVES)}
    compass = [number[int(x), int(y)] for x, y in geometry.HEADINGS]
    turned = np.full((N_HEADINGS, N_MOVES), geometry.STAY)
    for heading in range(N_HEADINGS):
        for direction in range(N_HEADINGS):
            turned[heading, compass[direction]] = compass[(direction - heading) % N_HEADINGS]
    return turned


TURNED = _turned_moves()
"""(heading, move) int64: how a move points when the prey of a heading is turned to the east."""
UNTURNED = np.argsort(TURNED, axis=1)
"""(heading, move) int64: the move in the world that points so in the turned picture."""
