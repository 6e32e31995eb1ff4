"""Greedy hunts, against hunts worked out as slowly and plainly as they can be."""

import dataclasses
import hashlib
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from app.documents import presets
from learners import hunts
from learners.commands import FreezeSelection, FreezeSkills, SetParameter
from learners.hunts import Hunt, Policy, greedy_moves, ring_of_starts, success_map
from learners.kernel.state import tables
from learners.run import Run
from learners.spec import RunSpec
from sim import rng
from sim.geometry import HEADINGS, MOVES, N_MOVES, STAY
from sim.spec import N_HEADINGS, WorldSpec
from sim.world import (
    CAPTURE,
    FLIGHT,
    TIMEOUT,
    World,
    board_xy,
    cell_at,
    compile_world,
    start_of_trial,
)
from tests.support.reference import MOVES as SLOW_MOVES
from tests.support.reference import SlowWorld, SplitMix64

ROOT = Path(__file__).resolve().parents[2]
OUTCOMES = {"capture": CAPTURE, "flight": FLIGHT, "timeout": TIMEOUT}
EAST, WEST = 0, 4

SIZE, SECTORS, RINGS, LIMIT = 20, 8, 4, 60
SPEC = WorldSpec(size=SIZE, n_directions=SECTORS, n_distances=RINGS, step_limit=LIMIT)
SLOW = SlowWorld(size=SIZE, n_directions=SECTORS, n_distances=RINGS, step_limit=LIMIT)
NO_SKILLS = np.zeros((0, RINGS, SECTORS, N_MOVES), np.float32)
PREY = SIZE // 2


def move_towards(heading: int) -> int:
    """Number of the move that goes the way of a heading."""
    return MOVES.tolist().index(HEADINGS[heading].tolist())


def approach_table() -> np.ndarray:
    """Values of a skill that goes straight for the prey, by direction alone, ``(1, ...)``."""
    skill_q = np.zeros((1, RINGS, SECTORS, N_MOVES), np.float32)
    for direction in range(SECTORS):
        skill_q[0, :, direction, move_towards((direction + 4) % 8)] = 1
    return skill_q


def only_option() -> np.ndarray:
    """A selection table with one option, ``(heading, distance, direction, 1)``."""
    return np.zeros((N_HEADINGS, RINGS, SECTORS, 1), np.float32)


def random_tables(seed: int, n_options: int, levels: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Selection and skills drawn at random, with a leaning towards the prey.

    With few ``levels``, most choices are ties.
    """
    draw = np.random.default_rng(seed)
    shapes = (N_HEADINGS, RINGS, SECTORS, n_options), (n_options, RINGS, SECTORS, N_MOVES)
    selection_q, skill_q = (draw.normal(size=shape).astype(np.float32) for shape in shapes)
    skill_q += 2 * approach_table()
    if n_options == N_MOVES:
        selection_q += 2 * approach_table()
    if levels:
        selection_q, skill_q = (np.rint(q * levels) / levels for q in (selection_q, skill_q))
    return selection_q, skill_q


def slow_hunt(
    world: SlowWorld,
    selection_q: np.ndarray,
    skill_q: np.ndarray,
    start: tuple[int, int],
    heading: int,
    seed: int,
) -> tuple[str, list[tuple[int, int]], list[int], list[int]]:
    """A greedy hunt in the words of the definition: outcome, cells, options and moves.

    The stream of draws is that of the hunt; the draw of a step is split as the learner's is.
    """
    number = ((start[1] + 1) * (world.size + 2) + start[0] + 1) * 8 + heading
    seeds = SplitMix64(seed)
    for _ in range(number):
        seeds.draw()
    draws = SplitMix64(seeds.draw())
    cells, options, moves = [start], [], []
    for _ in range(world.step_limit):
        heading_ring_direction = world.state(heading, cells[-1])
        draw = draws.draw()
        option = one_of_best(selection_q[heading_ring_direction], draw >> 16 & 0xFFFF)
        move = option
        if len(skill_q):
            move = one_of_best(skill_q[(option, *world.reading(cells[-1]))], draw >> 48)
        before = cells[-1]
        cells.append(world.moved(before, SLOW_MOVES[move]))
        options.append(option)
        moves.append(move)
        outcome = world.outcome(heading, before, cells[-1])
        if outcome is not None:
            return outcome, cells, options, moves
    return "timeout", cells, options, moves


def one_of_best(values: np.ndarray, draw16: int) -> int:
    """One of the actions with the largest value, by a draw from 0...65,535."""
    best = [action for action, value in enumerate(values) if value == max(values)]
    return best[draw16 * len(best) // 2**16]


def hunt_at(world: World, policy: Policy, x: int, y: int, heading: int, seed: int = 0) -> Hunt:
    return hunts.hunt(world, policy, cell_at(world, x, y), heading, seed)


def policy_of(run: Run) -> Policy:
    """The greedy policy of a run of skills."""
    known = tables(run.spec, run.state)
    return greedy_moves(known["selection_q"], known["skill_q"])


# What is greedy


def test_greedy_sets_name_all_that_tie_and_nothing_absent() -> None:
    selection_q = np.full((N_HEADINGS, RINGS, SECTORS, 3), -np.inf, np.float32)
    selection_q[..., 0], selection_q[..., 2] = -3, -3
    selection_q[1, 2, 3] = [-np.inf, 7, 5]
    skill_q = np.zeros((3, RINGS, SECTORS, N_MOVES), np.float32)
    skill_q[1, 2, 3, 8] = 0.5
    policy = greedy_moves(selection_q, skill_q)
    assert policy.options[0, 0, 0] == 0b101
    assert policy.options[1, 2, 3] == 0b010
    assert policy.moves[0, 0, 0, 0] == 0b111111111
    assert policy.moves[1, 0, 2, 3] == 0b100000000


def test_primitive_moves_are_options_that_know_only_themselves() -> None:
    selection_q = np.zeros((N_HEADINGS, RINGS, SECTORS, N_MOVES), np.float32)
    policy = greedy_moves(selection_q, NO_SKILLS)
    assert (policy.options == 0b111111111).all()
    for move in range(N_MOVES):
        assert (policy.moves[move] == 1 << move).all()


def test_a_state_without_any_option_is_an_error() -> None:
    selection_q = only_option()
    selection_q[3, 1, 2] = -np.inf
    with pytest.raises(ValueError, match="no option is present"):
        greedy_moves(selection_q, approach_table())


# One hunt


@pytest.mark.parametrize("n", [1, 2, 5, 9])
def test_an_approach_from_behind_captures_in_so_many_steps(n: int) -> None:
    world, policy = compile_world(SPEC), greedy_moves(only_option(), approach_table())
    hunt = hunt_at(world, policy, PREY - n, PREY, heading=EAST)
    assert (hunt.outcome, hunt.steps) == (CAPTURE, n)
    way = [board_xy(world, cell) for cell in hunt.cells]
    assert way == [(x, PREY) for x in range(PREY - n, PREY + 1)]
    assert set(hunt.moves.tolist()) == {move_towards(EAST)}
    assert set(hunt.options.tolist()) == {0}


def test_an_approach_in_sight_ends_in_flight() -> None:
    world, policy = compile_world(SPEC), greedy_moves(only_option(), approach_table())
    # The prey sees 27 * 20 / 120 = 4.5 cells far: the step from 5 cells to 4 is noticed.
    hunt = hunt_at(world, policy, PREY + 6, PREY, heading=EAST)
    assert (hunt.outcome, hunt.steps) == (FLIGHT, 2)
    assert board_xy(world, hunt.cells[-1]) == (PREY + 4, PREY)
    assert hunt_at(world, policy, PREY + 6, PREY, heading=WEST).outcome == CAPTURE


def test_a_hunt_that_stays_times_out() -> None:
    selection_q = np.zeros((N_HEADINGS, RINGS, SECTORS, N_MOVES), np.float32)
    selection_q[..., STAY] = 1
    world, policy = compile_world(SPEC), greedy_moves(selection_q, NO_SKILLS)
    hunt = hunt_at(world, policy, 3, 4, heading=2)
    assert (hunt.outcome, hunt.steps) == (TIMEOUT, LIMIT)
    assert {board_xy(world, cell) for cell in hunt.cells} == {(3, 4)}
    short = hunts.hunt(world, policy, cell_at(world, 3, 4), 2, max_steps=7)
    assert (short.outcome, short.steps) == (TIMEOUT, 7)


@pytest.mark.parametrize("levels", [0, 1], ids=["no ties", "many ties"])
@pytest.mark.parametrize("skills", [True, False], ids=["skills", "moves"])
def test_a_hunt_goes_the_way_of_the_slow_one(skills: bool, levels: int) -> None:
    selection_q, skill_q = random_tables(5, 3 if skills else N_MOVES, levels)
    skills_q = skill_q if skills else NO_SKILLS
    world, policy = compile_world(SPEC), greedy_moves(selection_q, skills_q)
    seen = Counter()
    for case in range(150):
        draw = np.random.default_rng(case)
        x, y, heading = (int(n) for n in draw.integers(0, [SIZE, SIZE, N_HEADINGS]))
        outcome, cells, options, moves = slow_hunt(
            SLOW, selection_q, skills_q, (x, y), heading, case
        )
        hunt = hunt_at(world, policy, x, y, heading, case)
        assert hunt.outcome == OUTCOMES[outcome]
        assert [board_xy(world, cell) for cell in hunt.cells] == cells
        assert hunt.options.tolist() == options
        assert hunt.moves.tolist() == moves
        seen[outcome] += 1
    assert len(seen) == 3, "each outcome must have been compared"


@pytest.mark.parametrize("skills", [True, False], ids=["skills", "moves"])
def test_skills_are_asked_by_what_they_see_themselves(skills: bool) -> None:
    finer = {"skill_n_directions": 24, "skill_n_distances": 18}
    slow = dataclasses.replace(SLOW, **finer)
    world = compile_world(SPEC.model_copy(update=finer))
    n_options = 3 if skills else N_MOVES
    selection_q, _ = random_tables(5, n_options)
    skill_q = np.random.default_rng(5).normal(size=(3 if skills else 0, 18, 24, N_MOVES))
    policy = greedy_moves(selection_q, skill_q.astype(np.float32))
    assert policy.moves.shape == (n_options, 1, 18, 24)
    for case in range(60):
        draw = np.random.default_rng(case)
        x, y, heading = (int(n) for n in draw.integers(0, [SIZE, SIZE, N_HEADINGS]))
        _, cells, options, moves = slow_hunt(slow, selection_q, skill_q, (x, y), heading, case)
        hunt = hunt_at(world, policy, x, y, heading, case)
        assert [board_xy(world, cell) for cell in hunt.cells] == cells
        assert hunt.options.tolist() == options
        assert hunt.moves.tolist() == moves


def test_ties_are_broken_at_random_and_by_the_seed_alone() -> None:
    world = compile_world(SPEC)
    values = np.zeros((N_HEADINGS, RINGS, SECTORS, N_MOVES), np.float32)
    policy = greedy_moves(values, NO_SKILLS)
    first = [hunt_at(world, policy, 2, 2, 0, seed).moves[0] for seed in range(1_800)]
    counts = Counter(int(move) for move in first)
    assert set(counts) == set(range(N_MOVES))
    assert max(counts.values()) < 270 < 2 * min(counts.values())
    again = [hunt_at(world, policy, 2, 2, 0, seed).moves[0] for seed in range(1_800)]
    assert first == again


def test_hunts_are_the_learners_own_trials_without_exploring_and_learning() -> None:
    spec = RunSpec.model_validate(
        {
            "world": {"size": 40, "step_limit": 200},
            "learner": {"options": ["approach", "circle_clockwise"], "alpha": 0.3},
            "trials": 6_000,
        }
    )
    run = Run(spec, seed=3)
    run.advance(until_trial=4_000)
    for command in (
        SetParameter("learner.epsilon", 0.0),
        FreezeSelection(True),
        FreezeSkills(True),
    ):
        run.apply(command)
    run.advance(until_trial=4_001)
    run.advance(until_trial=4_401)
    policy = policy_of(run)
    compared = Counter()
    for trial in range(4_001, 4_401):
        cell, heading = run.start_of(trial)
        hunt, *others = (hunts.hunt(run.world, policy, cell, heading, n) for n in range(8))
        if all(np.array_equal(hunt.cells, other.cells) for other in others):
            # No tie on the way, so there is only one.
            assert hunt.outcome == run.state.log_outcome[trial]
            assert hunt.steps == run.state.log_steps[trial]
            compared[hunt.outcome] += 1
    assert compared[CAPTURE] > 50
    assert compared.total() > 150


# Many hunts


@pytest.mark.parametrize("levels", [0, 1], ids=["no ties", "many ties"])
def test_a_map_says_of_each_cell_how_the_hunt_from_there_ends(levels: int) -> None:
    # A hunt with its way goes on to its end; one of a map stops where it goes round in circles.
    world, policy = compile_world(SPEC), greedy_moves(*random_tables(8, 2, levels))
    outcomes = success_map(world, policy, seed=4)
    assert outcomes is not None
    assert outcomes.shape == (N_HEADINGS, SIZE, SIZE)
    assert outcomes.dtype == np.int8
    assert set(np.unique(outcomes)) == {CAPTURE, FLIGHT, TIMEOUT}
    for heading, y, x in np.ndindex(outcomes.shape):
        assert outcomes[heading, y, x] == hunt_at(world, policy, x, y, heading, 4).outcome


def test_a_map_turns_with_the_tables() -> None:
    # An odd board is the same after a quarter turn; without ties no draw tells cells apart.
    spec = WorldSpec(size=21, n_directions=SECTORS, n_distances=RINGS, step_limit=LIMIT)
    world = compile_world(spec)
    selection_q, skill_q = random_tables(2, 3)
    outcomes = success_map(world, greedy_moves(selection_q, skill_q))
    turned_moves = [MOVES.tolist().index([-y, x]) for x, y in MOVES.tolist()]
    turned_selection = np.roll(selection_q, (2, SECTORS // 4), axis=(0, 2))
    turned_skill = np.empty_like(skill_q)
    turned_skill[..., turned_moves] = np.roll(skill_q, SECTORS // 4, axis=2)
    turned = success_map(world, greedy_moves(turned_selection, turned_skill))
    assert outcomes is not None
    assert turned is not None
    # (x, y) goes to (-y, x): with the axes (y, x), that is a turn clockwise of the array.
    expected = np.roll(np.rot90(outcomes, -1, axes=(1, 2)), 2, axis=0)
    # On the prey's own cell there is no direction that could turn.
    turned[:, 10, 10] = expected[:, 10, 10]
    np.testing.assert_array_equal(turned, expected)
    assert len(np.unique(outcomes)) == 3


def test_a_map_can_be_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hunts, "SLICE_STEPS", 100 * LIMIT)
    world, policy = compile_world(SPEC), greedy_moves(only_option(), approach_table())
    asked = []

    def wanted() -> bool:
        asked.append(True)
        return len(asked) <= 5

    assert success_map(world, policy, wanted=wanted) is None
    assert len(asked) == 6
    sliced = success_map(world, policy, wanted=lambda: True)
    monkeypatch.undo()
    np.testing.assert_array_equal(sliced, success_map(world, policy))


def test_a_long_step_limit_does_not_take_long() -> None:
    spec = WorldSpec(size=SIZE, n_directions=SECTORS, n_distances=RINGS, step_limit=1_000_000)
    # Without ties a hunt that does not end goes round in circles, and is seen to.
    outcomes = success_map(compile_world(spec), greedy_moves(*random_tables(8, 2)))
    assert outcomes is not None
    assert (outcomes == TIMEOUT).mean() > 0.1


def test_preparing_leaves_nothing_behind() -> None:
    world = compile_world(SPEC)
    hunts.prepare(world)
    for before, after in zip(world, compile_world(SPEC), strict=True):
        np.testing.assert_array_equal(before, after)


# Rings


def test_a_ring_of_starts_lies_all_round_the_prey() -> None:
    world = compile_world(WorldSpec())
    places = [board_xy(world, cell) for cell in ring_of_starts(world, 50.0)]
    assert len(set(places)) == 16
    offsets = np.array(places) - 60
    np.testing.assert_allclose(np.hypot(*offsets.T), 50, atol=0.8)
    bearing = np.degrees(np.arctan2(offsets[:, 1], offsets[:, 0])) % 360
    np.testing.assert_allclose(bearing, 22.5 * np.arange(16), atol=1)
    assert places[0] == (110, 60)
    assert places[4] == (60, 110)


def test_starts_are_rounded_to_the_nearest_cell() -> None:
    world = compile_world(SPEC)
    places = [board_xy(world, cell) for cell in ring_of_starts(world, 5.0, n=8)]
    # 5 / sqrt(2) is 3.54.
    assert places == [(15, 10), (14, 14), (10, 15), (6, 14), (5, 10), (6, 6), (10, 5), (14, 6)]


def test_a_ring_that_does_not_fit_is_moved_to_the_edge() -> None:
    world = compile_world(SPEC)
    places = [board_xy(world, cell) for cell in ring_of_starts(world, 15.0, n=4)]
    assert places == [(19, 10), (10, 19), (0, 10), (10, 0)]


# Compiled, and as plain Python

PLAIN_SPEC = WorldSpec(size=SIZE, n_directions=SECTORS, n_distances=RINGS, step_limit=12)


def fingerprint() -> str:
    """Digest of maps and of a hunt's way, with ties and without."""
    world = compile_world(PLAIN_SPEC)
    total = hashlib.sha256()
    for levels in (0, 1):
        policy = greedy_moves(*random_tables(6, 2, levels))
        outcomes = success_map(world, policy, seed=9)
        assert outcomes is not None
        total.update(outcomes.tobytes())
        for part in hunt_at(world, policy, 3, 12, 5, seed=9)[:3]:
            total.update(np.asarray(part, np.int64).tobytes())
    return total.hexdigest()


def test_compiled_hunts_equal_plain_ones() -> None:
    # Unsigned words that wrap around are meant to; only plain Python warns of them.
    plain = subprocess.run(
        [sys.executable, "-W", "ignore", __file__],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert plain.stdout.split() == ["plain", fingerprint()]


@pytest.mark.parametrize("preset", ["timed", "standard_q"])
def test_the_endings_of_many_hunts_are_those_of_single_ones(preset: str) -> None:
    run = Run(presets.load(preset, ["world.size=40", "schedule=null"]), 3)
    run.advance(until_trial=2_000)
    found = tables(run.spec, run.state)
    selection_q = np.nan_to_num(found["selection_q"], nan=-np.inf)
    policy = hunts.greedy_moves(selection_q, found["skill_q"])
    starts, outcomes = rng.streams(11)[rng.STARTS], list[int]()
    for number in range(300):
        cell, heading = start_of_trial(run.world, starts, number)
        hunted = hunts.hunt(run.world, policy, int(cell), int(heading), seed=number)
        outcomes.append(hunted.outcome)
    counts = [outcomes.count(outcome) for outcome in (CAPTURE, FLIGHT, TIMEOUT)]
    assert 0 < counts[0] < 300
    assert list(hunts.endings(run.world, policy, starts, 300)) == counts


if __name__ == "__main__":
    is_compiled = hasattr(hunts.follow, "py_func")
    sys.stdout.write(f"{'compiled' if is_compiled else 'plain'} {fingerprint()}")
