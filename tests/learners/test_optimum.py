"""The exact optimum: what it must be in closed form, and that no learner ever beats it."""

import numpy as np
import pytest

from learners.kernel.state import STEP, tables
from learners.run import Run
from learners.spec import RunSpec
from sim import rng
from sim.world import CAPTURE, FLIGHT, board_xy, start_of_trial
from tests.support.optimum import GAMMA, HEADINGS, model_of, optimal_values
from tests.support.optimum import MOVES as OPTIMUM_MOVES
from tests.support.reference import MOVES, Cell, Move, SlowWorld

SIZE = 30
SEED = 4
REWARD = {CAPTURE: 100.0, FLIGHT: -50.0}
ROUNDING = 1e-9

LEARNERS = {
    "moves": ("moves", 0.6, 20_000),
    "two skills": (["approach", "circle_clockwise"], 0.1, 20_000),
    "three skills": (["approach", "circle_clockwise", "avoid"], 0.1, 20_000),
}


@pytest.fixture(scope="module")
def optimum() -> np.ndarray:
    """``(heading, y, x)`` in the small world."""
    return optimal_values(SIZE)


@pytest.fixture(scope="module", params=LEARNERS)
def trained(request: pytest.FixtureRequest) -> Run:
    """Each learner at the end of its training in the small world."""
    options, alpha, trials = LEARNERS[request.param]
    run = Run(
        RunSpec.model_validate(
            {
                "world": {"size": SIZE},
                "learner": {"options": options, "alpha": alpha},
                "trials": trials,
            }
        ),
        SEED,
    )
    run.advance()
    return run


def starts_of(run: Run, first: int, last: int) -> list[tuple[Cell, int]]:
    """Cell and heading with which trials of a run start, whether they were made or not."""
    stream = rng.streams(run.seed)[rng.STARTS]
    drawn = [start_of_trial(run.world, stream, trial) for trial in range(first, last)]
    return [(board_xy(run.world, int(cell)), int(heading)) for cell, heading in drawn]


class GreedyPolicy:
    """What a learner would do if it neither explored nor learned."""

    def __init__(self, run: Run, world: SlowWorld) -> None:
        learned = tables(run.spec, run.state)
        self.world = world
        self.selection, self.skills = learned["selection_q"], learned["skill_q"]
        self.options_are_moves = run.spec.learner.options == "moves"

    def move(self, cell: Cell, heading: int) -> Move:
        """The best move of the best option; the first one of equals."""
        option = int(np.nanargmax(self.selection[self.world.state(heading, cell)]))
        if self.options_are_moves:
            return MOVES[option]
        return MOVES[int(np.argmax(self.skills[option][self.world.reading(cell)]))]


def greedy_return(policy: GreedyPolicy, cell: Cell, heading: int) -> float:
    """Discounted reward of a trial without exploration.

    Policy and world are both certain, so a cell that comes again means that the trial goes round
    in circles until it is cut off.
    """
    world, been = policy.world, set()
    while cell not in been:
        been.add(cell)
        after = world.moved(cell, policy.move(cell, heading))
        outcome = world.outcome(heading, cell, after)
        if outcome is not None:
            reward = world.capture_reward if outcome == "capture" else world.flight_reward
            return reward * GAMMA ** (len(been) - 1)
        cell = after
    return 0.0


def test_no_greedy_trial_of_a_trained_learner_beats_the_optimum(
    trained: Run, optimum: np.ndarray
) -> None:
    policy = GreedyPolicy(trained, SlowWorld(size=SIZE))
    trials = trained.spec.trials
    starts = starts_of(trained, trials, trials + 300)
    reached = np.array([greedy_return(policy, cell, heading) for cell, heading in starts])
    best = np.array([optimum[heading, y, x] for (x, y), heading in starts])
    assert (reached <= best + ROUNDING).all()
    # The bound means little unless learners come close to it.
    assert (reached > 0).mean() > 0.7
    assert reached.sum() > 0.35 * best.sum()
    assert (reached > 0.999 * best).sum() >= 30


def test_no_trial_of_a_learner_in_training_beats_the_optimum(
    trained: Run, optimum: np.ndarray
) -> None:
    """The trials the learner really made: rewards and steps are those of its own log."""
    state = trained.state
    starts = starts_of(trained, 0, trained.spec.trials)
    best = np.array([optimum[heading, y, x] for (x, y), heading in starts])
    reward = np.array([REWARD.get(int(outcome), 0.0) for outcome in state.log_outcome])
    reached = reward * GAMMA ** (state.log_steps - 1)
    assert int(state.log_steps.sum()) == state.tally[STEP]
    assert (reached <= best + ROUNDING).all()
    assert (reached > 0.999 * best).sum() >= 500


@pytest.mark.parametrize("size", [30, 31, 60])
@pytest.mark.parametrize("heading", range(8))
def test_from_directly_behind_the_prey_the_optimum_is_the_straight_way(
    size: int, heading: int
) -> None:
    values = optimal_values(size)[heading]
    dx, dy = HEADINGS[heading]
    for n in range(1, (size - 1) // 2 + 1):
        behind = size // 2 - n * dx, size // 2 - n * dy
        assert values[behind[1], behind[0]] == pytest.approx(100 * 0.9 ** (n - 1), rel=1e-12)


@pytest.mark.parametrize("size", [30, 31])
def test_nothing_is_faster_than_the_straight_way_and_from_ahead_all_is_slower(size: int) -> None:
    """As many steps as the larger of the two offsets, from any cell of the blind half-plane."""
    y, x = np.mgrid[0:size, 0:size] - size // 2
    steps = np.maximum(abs(x), abs(y))
    elsewhere = steps > 0
    straight = 100 * 0.9 ** (steps - 1.0)
    for values, (dx, dy) in zip(optimal_values(size), HEADINGS, strict=True):
        ahead = x * dx + y * dy
        assert (values <= straight + ROUNDING)[elsewhere].all()
        np.testing.assert_allclose(
            values[elsewhere & (ahead <= 0)], straight[elsewhere & (ahead <= 0)]
        )
        on_the_axis = (ahead > 0) & (x * dy - y * dx == 0)
        assert (values < straight - ROUNDING)[on_the_axis].all()
        assert (values > 0)[elsewhere].all(), "capture is possible from everywhere"


@pytest.mark.parametrize("size", [31, 45])
def test_turning_the_board_by_90_degrees_turns_the_optimum(size: int) -> None:
    """(x, y) goes to (-y, x) and the heading two on; the grid is odd, so its middle stays."""
    values = optimal_values(size)
    for heading in range(8):
        turned = np.rot90(values[heading], k=-1)
        np.testing.assert_array_equal(values[(heading + 2) % 8], turned)
    assert not np.array_equal(values[1], values[0])


def test_a_quarter_turn_moves_the_row_south_of_the_prey_to_the_column_east_of_it() -> None:
    """The turn of the array ``[y, x]`` above is the turn of the board that it is meant to be."""
    board = np.zeros((5, 5))
    board[0, 2] = 1
    assert np.rot90(board, k=-1)[2, 4] == 1


@pytest.mark.parametrize("size", [20, 21])
def test_the_model_is_that_of_the_reference(size: int) -> None:
    """Every move from every cell for every heading."""
    model, world = model_of(size), SlowWorld(size=size)
    assert OPTIMUM_MOVES == MOVES
    for x in range(size):
        for y in range(size):
            if (x, y) == world.prey:
                continue
            for number, move in enumerate(MOVES):
                after = world.moved((x, y), move)
                assert (model.next_x[number, y, x], model.next_y[number, y, x]) == after
                outcomes = [world.outcome(heading, (x, y), after) for heading in range(8)]
                flights = model.flight[number, :, y, x]
                captures = model.capture[number, :, y, x]
                assert [outcome == "flight" for outcome in outcomes] == flights.tolist()
                assert [outcome == "capture" for outcome in outcomes] == captures.tolist()
