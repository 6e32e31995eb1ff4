"""What can be measured of a learner between two of its steps, and leaves no mark on it.

How well a skill does that is left to itself, from its table as it stands; what the last steps were
like, from the trail; and where trials started, from their numbers.
"""

from typing import NamedTuple

import numpy as np

from learners import measures
from learners.hunts import stream_of
from learners.kernel.choices import skill_move
from learners.kernel.forms import Forms, earned, forms_of, is_behind, skill_row
from learners.kernel.state import STEP, TRAIL_LENGTH, TRIAL_STEP
from learners.run import Run, units
from learners.skills import wrapped
from sim import rng
from sim.bits import U
from sim.compiled import loop
from sim.rng import GAMMA, mix
from sim.world import (
    FLIGHT,
    PREY_BIT,
    READING_SHIFT,
    World,
    moved,
    outcome_of,
    skill_state_of,
    start_of_trial,
)

EXERCISES = 100
EXERCISE_STEPS = 100
"""Of a skill that is left to itself: a share of 0.9 is known to within 0.01 by them."""
EXERCISE_SEED = 5_110_377
"""Of where these start: the same for all runs in a world."""

_NOTHING = np.float32(0)


class Travel(NamedTuple):
    """What the last steps of a run were like."""

    distance: np.ndarray
    """(step,) float32: from the prey after each of them, in cells."""
    stayed: float
    """Share of them that ended in the reading of the selection that they started in."""


class Trials(NamedTuple):
    """Where trials started and ended, and how that looked to the prey."""

    distance: np.ndarray
    """(trial,) float32: from the prey at the start, in cells."""
    gained: np.ndarray
    """(trial,) float32: how much closer they ended than they started, in cells."""
    seen: np.ndarray
    """(trial,) bool: whether they started in the visual field."""


@loop
def exercise(
    world: World,
    words: np.ndarray,
    forms: Forms | None,
    weights: np.ndarray,
    skill: np.uint64,
    epsilon16: np.uint64,
    starts: np.uint64,
    n_exercises: int,
    max_steps: int,
) -> tuple[int, int]:
    """Let a skill choose every move as it does while it learns, but learn nothing.

    An exercise starts where a trial would, and ends on the prey's cell, which sees nothing.

    Args:
        world: the world.
        words: rows of the skills.
        forms: of the skills, where they differ.
        weights: of the local rewards, see ``learners.skills.local_reward``.
        skill: number of the skill.
        epsilon16: its chance of a random move, in units of 2**-16.
        starts: stream of the starts.
        n_exercises: how many.
        max_steps: of each.

    Returns:
        Steps made, and those of them that earned a local reward above 0.
    """
    made = 0
    paid = 0
    for number in range(n_exercises):
        cell, heading = start_of_trial(world, starts, number)
        counter = stream_of(starts, heading, cell)
        for _ in range(max_steps):
            reading = U(world.cell_word[cell]) >> READING_SHIFT
            state = skill_state_of(world.skill_states, cell, reading)
            counter += GAMMA
            row = skill_row(forms, world.n_skill_states, skill, state, heading)
            move = skill_move(words, row, epsilon16, mix(counter))
            cell_t = moved(world.cell_word, world.clipped, world.move_step, cell, move)
            is_there = U(world.cell_word[cell_t]) & PREY_BIT
            turn = _NOTHING
            if not is_there:
                turn = wrapped(world.angle[cell_t] - world.angle[cell])
            d_tm1, d_t = world.distance[cell], world.distance[cell_t]
            made += 1
            was_behind = is_behind(world.angle[cell], heading)
            fled = outcome_of(world, cell, cell_t, heading) == FLIGHT
            r_t = earned(forms, weights, None, skill, d_tm1, d_t, turn, was_behind, fled)
            if r_t > _NOTHING:
                paid += 1
            cell = cell_t
            if is_there:
                break
    return made, paid


@loop
def fill_starts(
    world: World, starts: np.uint64, first: int, cells: np.ndarray, headings: np.ndarray
) -> None:
    """Write down where trials start, from the one of number ``first`` on.

    Args:
        world: the world.
        starts: stream of the starts.
        first: number of a trial.
        cells: ``(trial,) int64``, to be filled.
        headings: ``(trial,) int64``, to be filled.
    """
    for place in range(cells.size):
        cell, heading = start_of_trial(world, starts, first + place)
        cells[place] = cell
        headings[place] = heading


def progress(run: Run, skill: str) -> float:
    """Share of the steps of a skill left to itself that earn a local reward above 0."""
    learner = run.spec.learner
    number = learner.skills.index(skill)
    weights = np.zeros((len(learner.skills), 4), np.float32)
    weights[number, :3] = learner.reward_of(skill)
    made, paid = exercise(
        run.world,
        run.state.skill_words,
        forms_of(run.spec, skills_learn=False),
        weights.ravel(),
        U(number),
        units(learner.epsilon, 16),
        rng.streams(EXERCISE_SEED)[rng.STARTS],
        EXERCISES,
        EXERCISE_STEPS,
    )
    return paid / made


def travel(run: Run) -> Travel:
    """What the steps on the trail were like; the first step of a trial has none before it.

    Raises:
        ValueError: the run has not made so many steps yet.
    """
    step = int(run.state.tally[STEP])
    if step < TRAIL_LENGTH:
        raise ValueError(f"step: {step} is too early; allowed: {TRAIL_LENGTH} or later")
    cells = np.roll(run.state.trail, -(step + 1) % TRAIL_LENGTH)
    # Where trials began, in steps before now; the running one may just be about to.
    done = measures.trials_done(run.state)
    lengths = run.state.log_steps[max(done - TRAIL_LENGTH, 0) : done][::-1]
    since = np.cumsum(np.concatenate([run.state.tally[[TRIAL_STEP]], lengths]), dtype=np.int64)
    is_first = np.zeros(TRAIL_LENGTH + 1, bool)
    is_first[TRAIL_LENGTH - since[since < TRAIL_LENGTH]] = True
    readings = run.world.cell_word[cells] >> int(READING_SHIFT)
    same = readings[1:] == readings[:-1]
    within = ~is_first[1:-1]
    return Travel(run.world.distance[cells], float(same[within].mean()))


def trials(run: Run, first: int, last: int) -> Trials:
    """Where the trials ``first`` to ``last - 1``, which have ended, started and ended."""
    cells, headings = np.empty(last - first, np.int64), np.empty(last - first, np.int64)
    fill_starts(run.world, run.state.streams[rng.STARTS], first, cells, headings)
    distance = run.world.distance[cells]
    ended = run.world.distance[run.state.log_cell[first:last]]
    seen = (run.world.cell_word[cells] >> headings) & 1 == 1
    return Trials(distance, distance - ended, seen)


def prepare(run: Run) -> None:
    """Compile what this takes, or load what was compiled before, ahead of the first look."""
    trials(run, 0, 0)
    for skill in run.present[:1]:
        progress(run, skill)
