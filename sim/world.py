"""The world compiled into small tables by cell, and the events of a trial (section 4.1).

The board has a frame of one cell around it, so that a move is one addition; a cell of the
frame knows the board cell that the move is clipped to. All that the learner's loop asks of a
cell is in one word and two floats, and no trigonometry is left in the loop.
"""

import math
from typing import NamedTuple

import numpy as np

from sim import geometry
from sim.bits import U
from sim.compiled import piece
from sim.rng import GAMMA, mix
from sim.spec import N_HEADINGS, WorldSpec

PREY_BIT = U(1 << 8)
FRAME_BIT = U(1 << 9)
READING_SHIFT = U(16)

ONGOING = 0
CAPTURE = 1
FLIGHT = 2
TIMEOUT = 3
"""How a trial ended; a time-out is a truncation, the other two are terminations."""

_ZERO = U(0)
_ONE = U(1)
_TWO = U(2)
_THREE = U(3)
_S11 = U(11)
_S61 = U(61)
_UNIT = 2.0**-53
_TURN = 2.0 * math.pi


class World(NamedTuple):
    """Tables and numbers of one world. A cell is ``(y + 1) * width + x + 1``."""

    cell_word: np.ndarray
    """(cell,) uint32: visibility by heading, prey and frame bits, and from bit 16 the selection's
    reading of direction and distance."""
    skill_states: np.ndarray | None
    """(cell,) uint32: what skills read there; None where it is what the selection reads."""
    distance: np.ndarray
    """(cell,) float32: cells from the prey."""
    angle: np.ndarray
    """(cell,) float32: bearing from the prey in radians, -pi...pi; 0 on the prey's cell."""
    clipped: np.ndarray
    """(cell,) uint32: the board cell that stands for a cell of the frame."""
    move_step: np.ndarray
    """(move,) uint64: what a move adds to a cell, wrapping."""
    n_readings: np.uint64
    """Of direction and distance, by the selection."""
    n_skill_states: np.uint64
    prey_cell: np.uint64
    width: np.uint64
    size: int
    start_nearest: float
    start_farthest: float
    """In cells."""
    step_limit: int
    capture_reward: np.float32
    flight_reward: np.float32


def compile_world(spec: WorldSpec) -> World:
    """Tabulate a world."""
    size, width = spec.size, spec.size + 2
    dx, dy = geometry.offsets(spec)
    px, py = geometry.prey_xy(spec)

    headings = np.arange(N_HEADINGS)[:, None, None]
    word = (geometry.visible(spec).astype(np.uint32) << headings.astype(np.uint32)).sum(
        axis=0, dtype=np.uint32
    )
    word |= geometry.readings(spec).astype(np.uint32) << np.uint32(READING_SHIFT)
    word[py, px] |= np.uint32(PREY_BIT)

    framed = np.pad(word, 1, mode="edge")
    on_frame = np.pad(np.zeros((size, size), dtype=bool), 1, constant_values=True)
    framed[on_frame] |= np.uint32(FRAME_BIT)
    clip = np.clip(np.arange(-1, size + 1), 0, size - 1) + 1
    clipped = clip[:, None] * width + clip[None, :]

    steps = geometry.MOVES[:, 1] * width + geometry.MOVES[:, 0]
    return World(
        cell_word=framed.ravel(),
        skill_states=_skill_states(spec),
        distance=np.pad(np.hypot(dx, dy), 1, mode="edge").astype(np.float32).ravel(),
        angle=np.pad(np.arctan2(dy, dx), 1, mode="edge").astype(np.float32).ravel(),
        clipped=clipped.astype(np.uint32).ravel(),
        move_step=steps.astype(np.uint64),
        n_readings=U(spec.n_readings),
        n_skill_states=U(spec.n_skill_states),
        prey_cell=U((py + 1) * width + px + 1),
        width=U(width),
        size=size,
        start_nearest=spec.start_radius[0] * spec.scale,
        start_farthest=spec.start_radius[1] * spec.scale,
        step_limit=spec.step_limit,
        capture_reward=np.float32(spec.capture_reward),
        flight_reward=np.float32(spec.flight_reward),
    )


def _skill_states(spec: WorldSpec) -> np.ndarray | None:
    if spec.shares_sensors:
        return None
    readings = geometry.readings(spec.of_skills)
    return np.pad(readings, 1, mode="edge").astype(np.uint32).ravel()


def board_xy(world: World, cell: int) -> tuple[int, int]:
    """Grid coordinates of a cell."""
    return int(cell) % int(world.width) - 1, int(cell) // int(world.width) - 1


def cell_at(world: World, x: int, y: int) -> int:
    """Cell at grid coordinates.

    Raises:
        ValueError: the coordinates lie off the grid.
    """
    if not (0 <= x < world.size and 0 <= y < world.size):
        raise ValueError(f"cell: ({x}, {y}) is off the grid; allowed: 0 to {world.size - 1}")
    return (y + 1) * int(world.width) + x + 1


@piece
def start_of_trial(world: World, starts: np.uint64, trial: int) -> tuple[np.uint64, np.uint64]:
    """Cell and heading with which a trial starts (section 4.1.2).

    A function of the stream of starts and the trial's number alone.
    """
    counter = starts + U(trial) * _THREE * GAMMA
    far = mix(counter + GAMMA)
    turn = mix(counter + _TWO * GAMMA)
    facing = mix(counter + _THREE * GAMMA)
    radius = world.start_nearest + (world.start_farthest - world.start_nearest) * (
        float(far >> _S11) * _UNIT
    )
    angle = _TURN * (float(turn >> _S11) * _UNIT)
    middle = world.size // 2
    x = math.floor(middle + radius * math.cos(angle) + 0.5)
    y = math.floor(middle + radius * math.sin(angle) + 0.5)
    x = min(max(x, 0), world.size - 1)
    y = min(max(y, 0), world.size - 1)
    return U(y + 1) * world.width + U(x + 1), facing >> _S61


@piece
def skill_state_of(
    skill_states: np.ndarray | None, cell: np.uint64, reading: np.uint64
) -> np.uint64:
    """What skills read at a cell where the selection has this reading."""
    # Told by the type, so that the compiler leaves out what is not asked for.
    if skill_states is None:
        return reading
    return U(skill_states[cell])


@piece
def moved(
    cell_word: np.ndarray,
    clipped: np.ndarray,
    move_step: np.ndarray,
    cell: np.uint64,
    move: np.uint64,
) -> np.uint64:
    """Cell after a move, each coordinate clipped at the edge on its own."""
    target = cell + move_step[move]
    if U(cell_word[target]) & FRAME_BIT:
        target = U(clipped[target])
    return target


@piece
def in_view(word_tm1: np.uint64, word_t: np.uint64, heading: np.uint64) -> bool:
    """Whether a move ends in the visual field of a prey of this heading.

    A move onto the prey's own cell is judged from the cell it came from.
    """
    judged = word_tm1 if word_t & PREY_BIT else word_t
    return (judged >> heading) & _ONE != _ZERO


@piece
def outcome_of(world: World, cell: np.uint64, cell_t: np.uint64, heading: np.uint64) -> int:
    """What a step from one cell to another ends in (section 4.1), the step limit aside."""
    # The loop that learns has these lines of its own, with the rewards among them: to call a
    # piece there that tells the outcomes apart first costs it 2 to 3 % of its speed.
    word_t = U(world.cell_word[cell_t])
    if word_t & (PREY_BIT | (_ONE << heading)):
        closer = world.distance[cell_t] < world.distance[cell]
        if closer and in_view(U(world.cell_word[cell]), word_t, heading):
            return FLIGHT
        if word_t & PREY_BIT:
            return CAPTURE
    return ONGOING
