"""Greedy hunts of a learner that keeps its choices, against hunts worked out slowly and plainly."""

from collections import Counter

import numpy as np
import pytest

from learners import hunts
from learners.commands import FreezeSelection, FreezeSkills, SetParameter
from learners.hunts import Kept, Policy, greedy_moves, policy_of, success_map
from learners.kernel.state import tables
from learners.run import Run
from learners.spec import RunSpec
from sim.geometry import N_MOVES
from sim.spec import N_HEADINGS, WorldSpec
from sim.world import CAPTURE, FLIGHT, TIMEOUT, board_xy, cell_at, compile_world
from tests.support.reference import MOVES, SlowWorld, SplitMix64

OUTCOMES = {"capture": CAPTURE, "flight": FLIGHT, "timeout": TIMEOUT}
SIZE, SECTORS, RINGS, LIMIT = 20, 8, 4, 60
SPEC = WorldSpec(size=SIZE, n_directions=SECTORS, n_distances=RINGS, step_limit=LIMIT)
SLOW = SlowWorld(size=SIZE, n_directions=SECTORS, n_distances=RINGS, step_limit=LIMIT)
N_READINGS = RINGS * SECTORS

KEPT = {
    "anew in each step": None,
    "until the state changes, five steps at most": Kept(np.arange(N_READINGS, dtype=np.uint32), 5),
    "always four steps": Kept(np.zeros(N_READINGS, np.uint32), 4),
    "until the ring changes": Kept(np.arange(N_READINGS, dtype=np.uint32) // SECTORS, 50),
}


def random_tables(seed: int, levels: int, *, sees: bool) -> tuple[np.ndarray, np.ndarray]:
    """Selection among three skills, and these, drawn at random; few levels make ties."""
    draw = np.random.default_rng(seed)
    selection_q = draw.normal(size=(N_HEADINGS, RINGS, SECTORS, 3))
    shape = (3, N_HEADINGS, RINGS, SECTORS, N_MOVES) if sees else (3, RINGS, SECTORS, N_MOVES)
    skill_q = draw.normal(size=shape)
    if levels:
        selection_q, skill_q = (np.rint(q * levels) / levels for q in (selection_q, skill_q))
    return selection_q.astype(np.float32), skill_q.astype(np.float32)


def one_of_best(values: np.ndarray, draw16: int) -> int:
    """One of the actions with the largest value, by a draw from 0...65,535."""
    best = np.flatnonzero(values == values.max()).tolist()
    return best[draw16 * len(best) // 2**16]


def slow_hunt(
    selection_q: np.ndarray,
    skill_q: np.ndarray,
    kept: Kept | None,
    start: tuple[int, int],
    heading: int,
    seed: int,
) -> tuple[str, list[tuple[int, int]], list[int]]:
    """Outcome, cells and options: an option is chosen where none is kept any more."""
    number = ((start[1] + 1) * (SIZE + 2) + start[0] + 1) * 8 + heading
    seeds = SplitMix64(seed)
    for _ in range(number):
        seeds.draw()
    draws = SplitMix64(seeds.draw())
    cells, options = [start], list[int]()
    chosen_in, steps = None, 0
    for _ in range(LIMIT):
        draw = draws.draw()
        _, ring, sector = SLOW.state(heading, cells[-1])
        group = None if kept is None else int(kept.group[ring * SECTORS + sector])
        if kept is None or chosen_in != group or steps == kept.most:
            options.append(one_of_best(selection_q[heading, ring, sector], draw >> 16 & 0xFFFF))
            chosen_in, steps = group, 0
        else:
            options.append(options[-1])
        steps += 1
        known = skill_q[options[-1]]
        known = known[heading] if known.ndim == 4 else known
        move = one_of_best(known[SLOW.reading(cells[-1])], draw >> 48)
        before = cells[-1]
        cells.append(SLOW.moved(before, MOVES[move]))
        outcome = SLOW.outcome(heading, before, cells[-1])
        if outcome is not None:
            return outcome, cells, options
    return "timeout", cells, options


@pytest.mark.parametrize("sees", [False, True], ids=["blind skills", "skills that see headings"])
@pytest.mark.parametrize("levels", [0, 1], ids=["no ties", "many ties"])
@pytest.mark.parametrize("name", KEPT)
def test_a_hunt_goes_the_way_of_the_slow_one(name: str, levels: int, *, sees: bool) -> None:
    world, kept = compile_world(SPEC), KEPT[name]
    selection_q, skill_q = random_tables(3, levels, sees=sees)
    policy = greedy_moves(selection_q, skill_q, kept)
    assert policy.moves.shape == (3, 8 if sees else 1, RINGS, SECTORS)
    outcomes = success_map(world, policy)
    assert outcomes is not None
    seen = Counter[str]()
    for case in range(60):
        draw = np.random.default_rng(case)
        x, y, heading = (int(n) for n in draw.integers(0, [SIZE, SIZE, N_HEADINGS]))
        outcome, cells, options = slow_hunt(selection_q, skill_q, kept, (x, y), heading, 0)
        hunt = hunts.hunt(world, policy, cell_at(world, x, y), heading)
        assert hunt.outcome == OUTCOMES[outcome]
        assert [board_xy(world, cell) for cell in hunt.cells] == cells
        assert hunt.options.tolist() == options
        # One of a map stops where it goes round in circles.
        assert outcomes[heading, y, x] == hunt.outcome
        seen[outcome] += 1
    assert len(seen) > 1


FEUDAL = RunSpec.model_validate(
    {
        "world": {"size": 40, "step_limit": 200},
        "learner": {"options": "commands", "alpha": 0.2, "skill_alpha": 0.05},
        "trials": 6_000,
    }
)


def without_exploring(run: Run) -> None:
    """It goes on as a hunt would: greedy, and as it is."""
    for command in (
        SetParameter("learner.epsilon", 0.0),
        FreezeSelection(True),
        FreezeSkills(True),
    ):
        run.apply(command)


def test_hunts_of_a_manager_are_its_own_trials_without_exploring_and_learning() -> None:
    run = Run(FEUDAL, seed=3)
    run.advance(until_trial=3_000)
    without_exploring(run)
    run.advance(until_trial=3_001)
    policy = policy_of(run.spec, run.state)
    run.advance(until_trial=3_401)
    compared = Counter[int]()
    for trial in range(3_001, 3_401):
        cell, heading = run.start_of(trial)
        hunt, *others = (hunts.hunt(run.world, policy, cell, heading, n) for n in range(8))
        if all(np.array_equal(hunt.cells, other.cells) for other in others):
            # No tie on the way, so there is only one.
            assert hunt.outcome == run.state.log_outcome[trial]
            assert hunt.steps == run.state.log_steps[trial]
            compared[hunt.outcome] += 1
    assert compared[CAPTURE] > 50
    assert compared.total() > 150


def test_the_policy_of_a_manager_is_that_of_its_tables() -> None:
    run = Run(FEUDAL, seed=4)
    run.advance(until_trial=1_000)
    found = tables(run.spec, run.state)
    kept = hunts.kept_by(run.spec)
    expected = greedy_moves(found["selection_q"], found["skill_q"], kept)
    policy = policy_of(run.spec, run.state)
    assert isinstance(policy, Policy)
    assert policy.moves.shape == (5, 8, 18, 24)
    np.testing.assert_array_equal(policy.moves, expected.moves)
    np.testing.assert_array_equal(policy.options, expected.options)
    assert policy.kept is not None
    assert policy.kept.most == 50
    # Blocks of three sectors and three rings.
    group = policy.kept.group.reshape(18, 24)
    assert len(np.unique(group)) == 6 * 8
    assert all(len(np.unique(group[r : r + 3, s : s + 3])) == 1 for r in (0, 15) for s in (0, 21))
