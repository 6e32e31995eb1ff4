"""The compiled loop does exactly what the definition says, step by step and bit for bit."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import pytest

from learners.run import Run
from tests.support.reference import (
    SlowEpisode,
    SlowLearner,
    SlowSettings,
    SlowTimer,
    SlowWorld,
    SplitMix64,
)
from tests.support.stepwise import (
    BLURRED,
    CLOSE,
    COARSE,
    ODD,
    SMALL,
    STANDARD,
    assert_same_step,
    assert_same_tables,
    spec_of,
)

# Skills see coarser than the selection, in one of the two alone.
FINE = SlowWorld(
    size=27, n_directions=24, n_distances=9, skill_n_directions=8, twice_ring_exponent=2
)
# Starts lie on the edge, and beyond it by rounding.
WALLED = SlowWorld(size=20, start_radius=(57, 60), step_limit=50, vision_radius=40)
THREE_SKILLS = ("approach", "circle_clockwise", "avoid")


@dataclass(frozen=True)
class Case:
    """A run to compare, and what must have happened in it for the comparison to mean much."""

    settings: SlowSettings
    steps: int
    seed: int = 1
    must_see: Mapping[str, int] = field(default_factory=dict)


CASES = {
    "moves, standard world": Case(SlowSettings(STANDARD, alpha=0.6), 4_000, 1, {"timeout": 2}),
    "moves, small world": Case(
        SlowSettings(SMALL, alpha=0.6), 6_000, 2, {"capture": 5, "flight": 50, "timeout": 50}
    ),
    "moves, close to the prey": Case(
        SlowSettings(CLOSE, alpha=0.6), 6_000, 3, {"flight on the prey's cell": 5, "capture": 50}
    ),
    "moves, other rates and initial value": Case(
        SlowSettings(ODD, alpha=0.3, epsilon=0.35, gamma=0.8, initial_q=2.5), 4_000, 4
    ),
    "two skills, standard world": Case(
        SlowSettings(STANDARD, ("approach", "circle_clockwise")), 4_000, 5, {"capture": 1}
    ),
    "two skills, 16 x 11": Case(
        SlowSettings(ODD, ("approach", "circle_counterclockwise")), 5_000, 6, {"flight": 20}
    ),
    "three skills, 8 x 6": Case(SlowSettings(COARSE, THREE_SKILLS), 5_000, 7, {"timeout": 5}),
    "skills on the prey's cell": Case(
        SlowSettings(CLOSE, ("circle_clockwise", "approach", "circle_counterclockwise")),
        6_000,
        8,
        {"flight on the prey's cell": 5, "capture": 50},
    ),
    "hugging the wall": Case(
        SlowSettings(WALLED, ("avoid", "circle_clockwise")), 4_000, 9, {"clipped": 1_000}
    ),
    "moves into the wall": Case(
        SlowSettings(WALLED, alpha=0.6, epsilon=0.5), 3_000, 10, {"clipped": 200}
    ),
    "timers, freeze and overlapping episodes": Case(
        SlowSettings(
            SMALL,
            THREE_SKILLS,
            timers={
                "approach": SlowTimer(0, 20),
                "circle_clockwise": SlowTimer(60, 15),
                "avoid": SlowTimer(100, 10),
            },
            episodes=(
                SlowEpisode("circle_clockwise", 60, 80, 0.95),
                SlowEpisode("avoid", 100, 60, 0.30),
                SlowEpisode("approach", 130, 20, 0.25),
                SlowEpisode("circle_clockwise", 170, 20, 0.5),
            ),
        ),
        12_000,
        11,
        {
            "frozen": 500,
            "imposed": 1_000,
            "passed over by two episodes": 20,
            "no other option": 5,
            "joined below the initial value": 20,
        },
    ),
    "timers without safe introduction": Case(
        SlowSettings(
            SMALL,
            THREE_SKILLS,
            timers={
                "approach": SlowTimer(0, 20),
                "circle_clockwise": SlowTimer(90, 15),
                "avoid": SlowTimer(140, 10),
            },
            episodes=(
                SlowEpisode("circle_clockwise", 90, 60, 0.95),
                SlowEpisode("avoid", 140, 60, 0.30),
            ),
            safe_introduction=False,
        ),
        12_000,
        15,
        {"frozen": 500, "imposed": 1_000, "raised a utility by joining": 20},
    ),
    "without safe introduction, every state is worth less than the initial value": Case(
        SlowSettings(
            CLOSE,
            ("avoid", "approach", "circle_counterclockwise"),
            timers={"approach": SlowTimer(40), "circle_counterclockwise": SlowTimer(40, 5)},
            initial_q=2.5,
            safe_introduction=False,
        ),
        6_000,
        16,
        {"frozen": 20, "raised a utility by joining": 100},
    ),
    "a skill that joins first explores alone": Case(
        SlowSettings(
            COARSE,
            ("avoid", "approach"),
            timers={"avoid": SlowTimer(30, 0)},
            episodes=(SlowEpisode("approach", 0, 20, 0.4), SlowEpisode("avoid", 35, 10, 1.0)),
            initial_q=-1.5,
        ),
        5_000,
        12,
        {"no other option": 100, "imposed": 100, "joined below the initial value": 5},
    ),
    "an episode leaves out the best option": Case(
        SlowSettings(
            CLOSE,
            (*THREE_SKILLS, "circle_counterclockwise"),
            alpha=0.3,
            episodes=(SlowEpisode("approach", 20, 400, 0.1),),
        ),
        5_000,
        14,
        {"best option left out": 50, "imposed": 100},
    ),
    "skills that see finer": Case(
        SlowSettings(BLURRED, THREE_SKILLS), 6_000, 17, {"flight": 20, "capture": 3}
    ),
    "skills that see coarser": Case(
        SlowSettings(FINE, ("circle_counterclockwise", "approach")), 5_000, 18, {"flight": 20}
    ),
    "moves, whatever skills would see": Case(SlowSettings(BLURRED, alpha=0.6), 4_000, 19),
    "circles free to spiral": Case(
        SlowSettings(
            SMALL,
            ("circle_clockwise", "approach", "circle_counterclockwise"),
            spiral_penalty=0.0,
        ),
        5_000,
        20,
        {"flight": 20},
    ),
    "local rewards that are binary": Case(
        SlowSettings(
            SMALL,
            (*THREE_SKILLS, "circle_counterclockwise"),
            spiral_penalty=0.8,
            binary_rewards=True,
        ),
        6_000,
        22,
        {"flight": 20},
    ),
    "all present skills learn": Case(
        SlowSettings(
            SMALL,
            THREE_SKILLS,
            timers={"circle_clockwise": SlowTimer(40, 15), "avoid": SlowTimer(80)},
            episodes=(SlowEpisode("circle_clockwise", 40, 60, 0.7),),
            all_skills_learn=True,
        ),
        8_000,
        23,
        {"imposed": 500, "frozen": 100, "learned from another's move": 5_000},
    ),
    "every open point at once": Case(
        SlowSettings(
            BLURRED, THREE_SKILLS, spiral_penalty=0.5, binary_rewards=True, all_skills_learn=True
        ),
        6_000,
        24,
        {"learned from another's move": 10_000},
    ),
    "one skill": Case(SlowSettings(ODD, ("avoid",)), 3_000, 13, {"clipped": 500}),
}


@pytest.mark.parametrize("name", CASES)
def test_every_step_and_every_value_is_that_of_the_reference(name: str) -> None:
    case = CASES[name]
    slow = SlowLearner(case.settings, case.seed)
    run = Run(spec_of(case.settings), case.seed)
    for number in range(1, case.steps + 1):
        trial = run.trial
        step = slow.step()
        assert run.advance(max_steps=1) == 1
        assert_same_step(run, slow, trial, step)
        if number % 1_000 == 0 or number == case.steps:
            assert_same_tables(run, slow)
    for event, times in case.must_see.items():
        assert slow.happened[event] >= times, event


@pytest.mark.parametrize(
    ("settings", "steps"),
    [
        (SlowSettings(CLOSE, alpha=0.6), 60_000),
        (SlowSettings(CLOSE, THREE_SKILLS), 60_000),
        (CASES["timers, freeze and overlapping episodes"].settings, 40_000),
        (CASES["timers without safe introduction"].settings, 40_000),
    ],
    ids=["moves", "three skills", "timed", "timed without safe introduction"],
)
def test_a_longer_run_made_in_few_calls_learns_the_same(settings: SlowSettings, steps: int) -> None:
    slow = SlowLearner(settings, seed=21)
    run = Run(spec_of(settings), seed=21)
    for _ in range(2):
        for _ in range(steps // 2):
            slow.step()
        run.advance(max_steps=steps // 2)
        assert_same_tables(run, slow)
    assert slow.happened["capture"] > 100


def test_the_references_own_generator_is_the_published_one() -> None:
    """The first numbers of the author's C code for the seed 1234567."""
    generator = SplitMix64(1234567)
    assert [generator.draw() for _ in range(5)] == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
        4593380528125082431,
        16408922859458223821,
    ]
