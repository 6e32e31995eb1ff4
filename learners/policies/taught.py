"""Direct teaching: a script chooses the skill for some trials, and the learner learns (3.2).

A script is a policy that somebody wrote who knows the task. Its choices are imposed as those of an
exploration episode are, without chance; skills choose their moves as ever, and both levels learn
from what comes of it.

``flank``, the one script there is: with b the angle between the prey's heading and the predator, d
their distance and R the radius of the visual field, in cells,

    avoid      if b <= 90 degrees + 0.1 rad and d <= R + 1.5, so in the field or about to enter it
    approach   else if b > 90 degrees + 0.35 rad, so behind the prey
    circle     else, to get there: clockwise where there are both circles

1.5 is a little more than the longest move.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Final

import numpy as np

from learners.kernel.state import NO_OPTION
from learners.names import Script
from learners.skills import CIRCLES
from sim import geometry
from sim.bits import U
from sim.compiled import piece
from sim.spec import N_HEADINGS, WorldSpec

_IN_FRONT: Final = math.pi / 2 + 0.1
_BEHIND: Final = math.pi / 2 + 0.35
_MARGIN: Final = 1.5


def flank(world: WorldSpec) -> np.ndarray:
    """What ``flank`` does, ``(heading, y, x) uint8``: 0 is approach, 1 avoid, 2 a circle."""
    dx, dy = geometry.offsets(world)
    distance = np.hypot(dx, dy)
    heading = np.arange(N_HEADINGS)[:, None, None] * (math.tau / N_HEADINGS)
    relative = np.abs(np.remainder(np.arctan2(dy, dx) - heading + math.pi, math.tau) - math.pi)
    near = distance <= world.vision_radius * world.scale + _MARGIN
    chosen = np.where(relative > _BEHIND, 0, 2)
    return np.where((relative <= _IN_FRONT) & near, 1, chosen).astype(np.uint8)


def table_of(
    script: Script, world: WorldSpec, skills: Sequence[str], present: Sequence[str]
) -> np.ndarray:
    """Options that a script chooses, ``(heading * cell,) uint8``, by cells of the framed board.

    Args:
        script: its name.
        world: in which it is.
        skills: all options, in order.
        present: those that there are now; in the place of others is ``NO_OPTION``, and there the
            learner chooses.
    """
    return _table(script, world.model_dump_json(), tuple(skills), tuple(present))


@lru_cache(maxsize=8)
def _table(
    script: Script, document: str, skills: tuple[str, ...], present: tuple[str, ...]
) -> np.ndarray:
    by_name = {"flank": flank}[script](WorldSpec.model_validate_json(document))
    circle = next((name for name in CIRCLES if name in skills), CIRCLES[0])
    options = [
        skills.index(name) if name in present else NO_OPTION
        for name in ("approach", "avoid", circle)
    ]
    chosen = np.array(options, np.uint8)[by_name]
    framed = np.pad(chosen, ((0, 0), (1, 1), (1, 1)), mode="edge").ravel()
    framed.flags.writeable = False
    return framed


@piece
def is_taught(script: np.ndarray | None) -> bool:
    """Whether a script chooses."""
    return script is not None


@piece
def scripted_option(
    script: np.ndarray | None, n_cells: np.uint64, heading: np.uint64, cell: np.uint64
) -> np.uint64:
    """Option that a script chooses at a cell; ``NO_OPTION`` where there is none, or no script."""
    if script is None:
        return U(NO_OPTION)
    return U(script[heading * n_cells + cell])
