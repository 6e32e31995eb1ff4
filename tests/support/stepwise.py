"""The compiled learner beside a slow reference: the same run for both, and their steps."""

import numpy as np

from learners.kernel.state import CELL, HEADING, OPTION, TRAIL_LENGTH, TRIAL_STEP, tables
from learners.run import Run
from learners.spec import RunSpec
from sim.world import CAPTURE, FLIGHT, TIMEOUT, board_xy
from tests.support.reference import MOVES, SlowLearner, SlowSettings, SlowWorld, Step

STANDARD = SlowWorld()
SMALL = SlowWorld(size=24, step_limit=60)
# The start is as near as it may be, so that many trials end on the prey's cell; and the first ring
# is so wide that the state there is one that is learned.
CLOSE = SlowWorld(size=20, n_directions=8, n_distances=4, start_radius=(6, 20), step_limit=40)
# An odd size puts the prey in the middle exactly.
ODD = SlowWorld(size=29, n_directions=16, n_distances=11, step_limit=80)
COARSE = SlowWorld(size=30, n_directions=8, n_distances=6, step_limit=100)
# Skills see finer than the selection, and other rings.
BLURRED = SlowWorld(
    size=26,
    n_directions=8,
    n_distances=6,
    step_limit=80,
    skill_n_directions=24,
    skill_n_distances=18,
    twice_ring_exponent=4,
)

OUTCOMES = {CAPTURE: "capture", FLIGHT: "flight", TIMEOUT: "timeout"}
TRIALS = 100_000
"""More than any comparison gets to."""


def spec_of(settings: SlowSettings) -> RunSpec:
    """The same run as a preset would state it."""
    world = settings.world
    return RunSpec.model_validate(
        {
            "world": {
                "size": world.size,
                "n_directions": world.n_directions,
                "n_distances": world.n_distances,
                "vision_radius": world.vision_radius,
                "start_radius": world.start_radius,
                "step_limit": world.step_limit,
                "capture_reward": world.capture_reward,
                "flight_reward": world.flight_reward,
                "skill_n_directions": world.skill_n_directions,
                "skill_n_distances": world.skill_n_distances,
                "ring_exponent": world.twice_ring_exponent / 2,
            },
            "learner": {
                "options": list(settings.skills) or "moves",
                "alpha": settings.alpha,
                "skill_alpha": settings.skill_alpha,
                "gamma": settings.gamma,
                "epsilon": settings.epsilon,
                "initial_q": settings.initial_q,
                "spiral_penalty": settings.spiral_penalty,
                "local_rewards": "binary" if settings.binary_rewards else "signed",
                "skills_that_learn": "all" if settings.all_skills_learn else "chosen",
            },
            "schedule": {
                "safe_introduction": settings.safe_introduction,
                "skills": {skill: timer._asdict() for skill, timer in settings.timers.items()},
                "episodes": [
                    {
                        "skill": episode.skill,
                        "at": episode.first,
                        "duration": episode.duration,
                        "probability": episode.probability,
                    }
                    for episode in settings.episodes
                ],
            },
            "trials": TRIALS,
        }
    )


def last_cell(run: Run) -> tuple[int, int]:
    """Where the last step led."""
    return board_xy(run.world, run.state.trail[run.step % TRAIL_LENGTH])


def assert_same_step(run: Run, slow: SlowLearner, trial: int, step: Step) -> None:
    """The last step of both learners was the same."""
    options = slow.settings.options
    assert last_cell(run) == step.cell
    assert run.trial == slow.trial
    assert board_xy(run.world, run.state.place[CELL]) == slow.cell
    assert run.state.place[HEADING] == slow.heading
    if step.outcome is None:
        assert options[int(run.state.place[OPTION])] == step.option
        assert run.state.tally[TRIAL_STEP] == slow.trial_step
    else:
        assert OUTCOMES[int(run.state.log_outcome[trial])] == step.outcome
        assert board_xy(run.world, run.state.log_cell[trial]) == step.cell


def selection_of(slow: SlowLearner) -> np.ndarray:
    """``(heading, distance, direction, option) float32``, NaN for an option that never joined."""
    world, options = slow.world, slow.settings.options
    shape = (8, world.n_distances, world.n_directions, len(options))
    selection = np.full(shape, np.nan, np.float32)
    for state, values in slow.selection.items():
        for option, value in values.items():
            selection[*state, options.index(option)] = value
    return selection


def skills_of(slow: SlowLearner) -> np.ndarray:
    """``(skill, distance, direction, move) float32``."""
    world = slow.world
    shape = (len(slow.settings.skills), world.n_skill_rings, world.n_skill_sectors, len(MOVES))
    skills = np.full(shape, np.nan, np.float32)
    for number, skill in enumerate(slow.settings.skills):
        for reading, values in slow.skills[skill].items():
            skills[number, *reading] = [values[move] for move in MOVES]
    return skills


def visits_of(slow: SlowLearner) -> np.ndarray:
    """``(heading, distance, direction, option) uint32``."""
    world = slow.world
    shape = (8, world.n_distances, world.n_directions, len(slow.settings.options))
    visits = np.zeros(shape, np.uint32)
    for (state, option), count in slow.visits.items():
        visits[*state, slow.settings.options.index(option)] = count
    return visits


def assert_same_tables(run: Run, slow: SlowLearner) -> None:
    """All that was learned is the same to the last bit."""
    fast = tables(run.spec, run.state)
    for name, expected in (("selection_q", selection_of(slow)), ("skill_q", skills_of(slow))):
        assert fast[name].dtype == np.float32
        np.testing.assert_array_equal(fast[name], expected, err_msg=name, strict=True)
        assert fast[name].tobytes() == expected.tobytes(), f"{name}: the sign of a zero"
    np.testing.assert_array_equal(fast["visits"], visits_of(slow), err_msg="visits", strict=True)
