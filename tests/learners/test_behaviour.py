"""What is measured of a learner between two steps, against the same as slowly as it can be."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy import float32

from app.documents import presets
from learners import behaviour
from learners.kernel.forms import forms_of
from learners.kernel.state import CELL, HEADING, TRAIL_LENGTH, digest, tables
from learners.run import Run
from sim import rng
from sim.bits import U
from sim.world import board_xy
from tests.support.reference import MOVES, SlowWorld, SplitMix64, local_reward

SKILLS = ("approach", "circle_clockwise", "avoid")
SMALL = ["world.size=20", "world.n_directions=8", "world.n_distances=4", "world.step_limit=60"]
FINE = ["world.n_directions=16", "world.n_distances=6"]
SLOW = SlowWorld(size=20, n_directions=8, n_distances=4, step_limit=60)


def learned(preset: str = "hierarchical_3", steps: int = 20_000, seed: int = 5) -> Run:
    """A run in a small world."""
    run = Run(presets.load(preset, SMALL), seed)
    run.advance(max_steps=steps)
    assert run.step == steps
    return run


def start_of(starts: int, number: int) -> tuple[tuple[int, int], int]:
    """Where a trial starts."""
    draws = SplitMix64(starts)
    for _ in range(3 * number):
        draws.draw()
    return SLOW.start(draws)


def slow_exercise(
    skill_q: np.ndarray,
    skill: str,
    epsilon16: int,
    starts: int,
    n: int,
    max_steps: int,
    counts: Callable[[tuple[int, int], int], bool] = lambda _cell, _heading: True,
) -> tuple[int, int]:
    """Steps of a skill that is left to itself, and those that count and earned something."""
    made = earned = 0
    for number in range(n):
        cell, heading = start_of(starts, number)
        seeds = SplitMix64(starts)
        for _ in range(((cell[1] + 1) * (SLOW.size + 2) + cell[0] + 1) * 8 + heading):
            seeds.draw()
        draws = SplitMix64(seeds.draw())
        for _ in range(max_steps):
            draw = draws.draw()
            view = skill_q if skill_q.ndim == 3 else skill_q[heading]
            values = view[SLOW.reading(cell)]
            best = [move for move, value in enumerate(values) if value == max(values)]
            if draw >> 32 & 0xFFFF < epsilon16:
                best = list(range(len(MOVES)))
            before, move = cell, best[(draw >> 48) * len(best) // 2**16]
            cell = SLOW.moved(before, MOVES[move])
            made += 1
            gained = local_reward(SLOW, skill, before, cell) > float32(0)
            earned += int(gained and counts(before, heading))
            if cell == SLOW.prey:
                break
    return made, earned


def is_behind(cell: tuple[int, int], heading: int) -> bool:
    """More than 105 degrees from where the prey looks."""
    relative = SLOW.bearing(cell) - heading * math.pi / 4
    return abs(math.remainder(relative, 2 * math.pi)) > math.radians(105)


@pytest.mark.parametrize("skill", SKILLS)
def test_a_skill_that_is_left_to_itself_does_what_it_would_while_it_learns(skill: str) -> None:
    run, number = learned(), SKILLS.index(skill)
    starts = rng.streams(3)[rng.STARTS]
    weights = np.zeros((3, 4), np.float32)
    weights[number, :3] = run.spec.learner.reward_of(skill)[:3]
    words, chance = run.state.skill_words, U(6554)
    found = behaviour.exercise(
        run.world, words, None, weights.ravel(), U(number), chance, starts, 8, 40
    )
    skill_q = tables(run.spec, run.state)["skill_q"][number]
    assert found == slow_exercise(skill_q, skill, 6554, int(starts), 8, 40)
    assert 0 < found[1] < found[0]


def test_a_skill_sees_by_its_own_sensors() -> None:
    own = ["world.skill_n_directions=16", "world.skill_n_distances=6"]
    run = Run(presets.load("hierarchical_2", [*SMALL, *own]), 5)
    run.advance(max_steps=20_000)
    fine = Run(presets.load("hierarchical_2", [*SMALL, *FINE]), 5)
    fine.state.skills[:] = run.state.skills
    assert behaviour.progress(run, "approach") == behaviour.progress(fine, "approach")


def test_practice_makes_progress() -> None:
    early, late = learned("hierarchical_2", 1), learned("hierarchical_2", 60_000)
    for skill in SKILLS[:2]:
        assert 0.25 < behaviour.progress(early, skill) < 0.6
        assert behaviour.progress(late, skill) > 0.75


@pytest.mark.parametrize("more", [0, 1, 37, 12_000])
def test_the_trail_is_read_as_the_steps_went(more: int) -> None:
    run = learned("standard_q", TRAIL_LENGTH + more)
    again = Run(run.spec, run.seed)
    again.advance(max_steps=more)
    distance: list[float] = []
    stays: list[bool] = []
    while again.step < run.step:
        before, is_first = int(again.state.place[CELL]), not again.state.tally[2]
        again.advance(max_steps=1)
        ended = not again.state.tally[2]
        after = int(again.state.log_cell[again.trial - 1] if ended else again.state.place[CELL])
        places = [board_xy(again.world, cell) for cell in (before, after)]
        distance.append(SLOW.distance(places[1]))
        if not is_first and len(distance) > 1:
            stays.append(SLOW.reading(places[0]) == SLOW.reading(places[1]))
    found = behaviour.travel(run)
    np.testing.assert_allclose(found.distance, distance, rtol=1e-6)
    assert found.stayed == pytest.approx(np.mean(stays), abs=1e-12)


def test_before_the_trail_is_full_it_says_nothing() -> None:
    with pytest.raises(ValueError, match=f"allowed: {TRAIL_LENGTH} or later"):
        behaviour.travel(learned(steps=TRAIL_LENGTH - 1))


def test_trials_start_where_they_would() -> None:
    run = learned("standard_q")
    found = behaviour.trials(run, 10, 60)
    starts = [start_of(int(run.state.streams[rng.STARTS]), trial) for trial in range(10, 60)]
    ends = [board_xy(run.world, cell) for cell in run.state.log_cell[10:60]]
    distance = np.array([SLOW.distance(cell) for cell, _ in starts])
    np.testing.assert_allclose(found.distance, distance, rtol=1e-6)
    gained = distance - [SLOW.distance(cell) for cell in ends]
    np.testing.assert_allclose(found.gained, gained, atol=1e-5)
    assert found.seen.tolist() == [SLOW.visible(heading, cell) for cell, heading in starts]
    assert 0 < found.seen.sum() < 50


def test_a_start_agrees_with_the_run() -> None:
    run = learned("standard_q", 500)
    cells, headings = np.empty(1, np.int64), np.empty(1, np.int64)
    behaviour.fill_starts(run.world, run.state.streams[rng.STARTS], run.trial, cells, headings)
    assert run.start_of(run.trial) == (cells[0], headings[0])
    assert int(run.state.place[HEADING]) == headings[0]


def test_nothing_is_left_of_a_look() -> None:
    run, other = learned(), learned()
    behaviour.progress(run, "approach")
    behaviour.travel(run)
    behaviour.trials(run, 0, run.trial)
    for each in (run, other):
        each.advance(max_steps=5_000)
    assert digest(run.state) == digest(other.state)


def test_what_is_behind_the_prey_counts_for_a_skill_that_is_rewarded_for_it() -> None:
    run = learned("static_appetite_fear")
    skill_q = tables(run.spec, run.state)["skill_q"][0]
    starts = rng.streams(3)[rng.STARTS]
    forms = forms_of(run.spec, skills_learn=False)
    found = behaviour.exercise(
        run.world, run.state.skill_words, forms, np.zeros(8, np.float32), U(0), U(0), starts, 8, 40
    )
    expected = slow_exercise(skill_q, "approach", 0, int(starts), 8, 40, is_behind)
    assert found == expected
    assert 0 < found[1] < found[0]
    assert behaviour.progress(run, "fear") == 0
