"""What is known about one cell: pure functions from a snapshot to readings and hunts.

Cells are given by their grid coordinates in the world's own orientation.
"""

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from app.explain.ruled import Ruling, holding_at, ruling_at
from app.explain.worth import Unit
from app.live.snapshot import Snapshot
from app.words.plain import MOVE_NAMES, plain
from learners import hunts
from learners.hunts import Hunt, Policy
from learners.kernel.state import NOT_REACHED
from learners.names import MOVES
from learners.policies.applicable import applicable_q
from sim.geometry import STAY
from sim.world import CAPTURE, FLIGHT, READING_SHIFT, TIMEOUT, cell_at

ACTION_NAMES = tuple(
    "stay" if move == STAY else f"move {name}" for move, name in enumerate(MOVE_NAMES)
)
OUTCOME_NAMES = {CAPTURE: "capture", FLIGHT: "flight", TIMEOUT: "time-out"}


class OptionReading(NamedTuple):
    """What the selection knows of one option in a state."""

    name: str
    q: float
    visits: int
    greedy: bool
    """Whether no option is worth more; where several are greedy, they tie."""
    place: int = 0
    """Among all options of the learner, present or not."""


class SkillReading(NamedTuple):
    """What a skill, or what obeys a command, knows of the nine moves in a state."""

    name: str
    q: tuple[float, ...]
    """Local value of each move."""
    greedy: tuple[int, ...]
    """Moves of the largest value."""


@dataclass(frozen=True)
class CellReading:
    """All that a learner knows of the state in which a cell lies."""

    x: int
    y: int
    heading: int
    ring: int
    """From 0, outwards."""
    direction: int
    """Sector from 0, the first centred on east, counter-clockwise."""
    n_rings: int
    n_directions: int
    away: float
    """From the prey, in cells."""
    bearing: float
    """Where it lies for the prey, in degrees: 0 straight ahead, counter-clockwise."""
    unit: Unit
    steps_made: int
    """By the learner so far."""
    of_skills: tuple[int, int] | None
    """Ring and sector as skills see them, where these have sensors of their own."""
    seen: bool
    """Whether the cell lies in the prey's visual field."""
    options: tuple[OptionReading, ...]
    """Those present."""
    skills: tuple[SkillReading, ...]
    """Those present; none where the options are the primitive moves."""
    first_reach: int | None
    """Trial in which the state's value first rose above 0."""
    outcome: int
    """How a hunt from the cell ends if the learner neither explores nor learns."""
    ruling: Ruling | None = None
    """How a rule selects there; None where a table does."""
    holding: str = ""
    """How long what is chosen there holds; empty where each step has a choice of its own."""


def policy_of(snapshot: Snapshot) -> Policy:
    """What is greedy in each state."""
    if snapshot.rule is not None:
        return hunts.policy_by(snapshot.spec, snapshot.rule)
    kept, share = hunts.kept_by(snapshot.spec), snapshot.spec.learner.applicable
    skill_q, best_ever = snapshot.skill_q, snapshot.best_ever
    allowed_q = applicable_q(share, snapshot.selection_q, skill_q, best_ever)
    return hunts.greedy_moves(allowed_q, skill_q, kept)


def moment_of(snapshot: Snapshot) -> Hashable:
    """What tells a moment of a session from all others; commands act without a step."""
    return snapshot.generation, snapshot.step, snapshot.control.history


def actions_of(snapshot: Snapshot) -> tuple[str, ...]:
    """What it is to take each option, as people say it."""
    learner = snapshot.spec.learner
    return ACTION_NAMES if learner.options == MOVES else tuple(map(plain, learner.sub_policies))


class HuntShown(NamedTuple):
    """A hunt from a cell, with the heading of its prey."""

    x: int
    y: int
    heading: int
    hunt: Hunt


def hunts_from(
    snapshot: Snapshot, starts: Sequence[tuple[int, int]], heading: int, seed: int = 0
) -> list[HuntShown]:
    """Hunts without exploring and without learning, from cells ``(x, y)``.

    The seed counts up from one hunt to the next, so that each breaks ties its own way.

    Raises:
        ValueError: a cell is off the grid.
    """
    world, policy = snapshot.world, policy_of(snapshot)
    return [
        HuntShown(x, y, heading, hunts.hunt(world, policy, cell_at(world, x, y), heading, number))
        for number, (x, y) in enumerate(starts, start=seed)
    ]


def reading_at(
    snapshot: Snapshot, x: int, y: int, heading: int, success: np.ndarray | None = None
) -> CellReading:
    """Read off a snapshot what is known about a cell.

    Args:
        snapshot: the moment.
        x: column of the cell.
        y: row of the cell.
        heading: of the prey.
        success: outcomes from each cell, ``(heading, y, x)``; without it one hunt is made.

    Raises:
        ValueError: the cell is off the grid.
    """
    cell = cell_at(snapshot.world, x, y)
    ring, direction = sensed(snapshot, cell)
    of_skills = sensed_by_skills(snapshot, cell)
    here = (heading, ring, direction)
    world = snapshot.spec.world
    east, north = x - world.size // 2, y - world.size // 2
    first_reach = int(snapshot.first_reach[here])
    if success is None:
        outcome = hunts_from(snapshot, [(x, y)], heading)[0].hunt.outcome
    else:
        outcome = int(success[heading, y, x])
    return CellReading(
        x=x,
        y=y,
        heading=heading,
        ring=ring,
        direction=direction,
        n_rings=world.n_distances,
        n_directions=world.n_directions,
        away=math.hypot(east, north),
        bearing=(math.degrees(math.atan2(north, east)) - 45 * heading) % 360,
        unit=Unit.of(snapshot),
        steps_made=snapshot.step,
        of_skills=None if snapshot.world.skill_states is None else of_skills,
        seen=bool(int(snapshot.world.cell_word[cell]) >> heading & 1),
        options=_options_read(snapshot, here),
        skills=_skills_read(snapshot, heading, *of_skills),
        first_reach=None if first_reach == NOT_REACHED else first_reach,
        outcome=outcome,
        ruling=ruling_at(snapshot, here),
        holding=holding_at(snapshot, here),
    )


def sensed(snapshot: Snapshot, cell: int) -> tuple[int, int]:
    """Ring and direction that the selection reads at a cell."""
    reading = int(snapshot.world.cell_word[cell]) >> int(READING_SHIFT)
    return divmod(reading, snapshot.spec.world.n_directions)


def sensed_by_skills(snapshot: Snapshot, cell: int) -> tuple[int, int]:
    """Ring and direction that skills read at a cell."""
    skill_states = snapshot.world.skill_states
    if skill_states is None:
        return sensed(snapshot, cell)
    return divmod(int(skill_states[cell]), snapshot.spec.world.of_skills.n_directions)


def _options_read(snapshot: Snapshot, here: tuple[int, int, int]) -> tuple[OptionReading, ...]:
    q, visits = snapshot.selection_q[here], snapshot.visits[here]
    chosen_by = snapshot.choice_q[here]
    return tuple(
        OptionReading(
            name,
            float(q[option]),
            int(visits[option]),
            bool(chosen_by[option] == chosen_by.max()),
            option,
        )
        for option, name in enumerate(actions_of(snapshot))
        if np.isfinite(q[option])
    )


def _skills_read(
    snapshot: Snapshot, heading: int, ring: int, direction: int
) -> tuple[SkillReading, ...]:
    learner = snapshot.spec.learner
    readings: list[SkillReading] = []
    for skill, name in enumerate(learner.sub_policies):
        if name in snapshot.present or not learner.skills:
            q = snapshot.skill_q_of(skill, heading)[ring, direction]
            best = tuple(np.flatnonzero(q == q.max()).tolist())
            readings.append(SkillReading(plain(name), tuple(q.tolist()), best))
    return tuple(readings)
