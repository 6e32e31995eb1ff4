"""Choices that are kept, pre-training and teaching do what their definitions say, bit for bit."""

import os
import subprocess
import sys
from collections.abc import Mapping
from typing import NamedTuple

import pytest

from learners.kernel.state import CELL, EARLIER, HEADING, TRIAL_STEP, digest
from learners.run import Run
from learners.spec import RunSpec
from sim.world import board_xy
from tests.support.pages import ROOT
from tests.support.reference import SlowEpisode, SlowTimer
from tests.support.reference_held import ONE_STEP, HeldLearner, HeldSettings, SlowHeld
from tests.support.stepwise import (
    BLURRED,
    CLOSE,
    COARSE,
    SMALL,
    assert_same_step,
    assert_same_tables,
    last_cell,
    spec_of,
)

THREE_SKILLS = ("approach", "circle_clockwise", "avoid")
ONE_BY_ONE = {
    "approach": SlowTimer(0, 20),
    "circle_clockwise": SlowTimer(60, 15),
    "avoid": SlowTimer(100, 10),
}
EPISODES = (
    SlowEpisode("circle_clockwise", 60, 80, 0.95),
    SlowEpisode("avoid", 100, 60, 0.30),
)


class Case(NamedTuple):
    """A run to compare, and what must have happened in it for the comparison to mean much."""

    settings: HeldSettings
    must_see: Mapping[str, int]
    steps: int = 6_000


CASES = {
    "moves kept until the state changes": Case(
        HeldSettings(COARSE, alpha=0.6, held=SlowHeld(True, 10)),
        {
            "kept": 1_000,
            "ended by a change": 300,
            "ended by its length": 20,
            "ended with the trial after several steps": 20,
            "capture": 1,
            "flight": 10,
        },
    ),
    "moves kept for 3 steps, discounted once": Case(
        HeldSettings(SMALL, alpha=0.6, initial_q=2.5, held=SlowHeld(False, 3, once=True)),
        {"kept": 2_000, "ended by its length": 500},
    ),
    "skills kept until the state changes, discounted once": Case(
        HeldSettings(CLOSE, THREE_SKILLS, held=SlowHeld(True, 10, once=True)),
        {"kept": 1_000, "ended with the trial after several steps": 50, "timeout": 5},
    ),
    "skills kept for 4 steps": Case(
        HeldSettings(SMALL, THREE_SKILLS, held=SlowHeld(False, 4)),
        {"kept": 3_000, "ended by its length": 300, "flight": 20},
    ),
    "timers, freezes and episodes with choices kept": Case(
        HeldSettings(
            SMALL, THREE_SKILLS, timers=ONE_BY_ONE, episodes=EPISODES, held=SlowHeld(True, 5)
        ),
        {"kept": 2_000, "imposed": 500, "ended by its length": 50},
        12_000,
    ),
    "taught": Case(
        HeldSettings(SMALL, THREE_SKILLS, taught=80),
        {"taught to avoid": 20, "taught to approach": 100, "taught to circle_clockwise": 100},
    ),
    "taught, with choices kept, what has not joined": Case(
        HeldSettings(
            SMALL,
            THREE_SKILLS,
            timers=ONE_BY_ONE,
            episodes=EPISODES,
            taught=90,
            held=SlowHeld(True, 4),
        ),
        {"taught what is not there": 200, "taught to circle_clockwise": 100, "kept": 2_000},
        12_000,
    ),
    "each skill alone first": Case(
        HeldSettings(SMALL, THREE_SKILLS, alone=700),
        {"alone and done": 20, "flight": 10},
    ),
    "each alone first, then one by one, taught and kept": Case(
        HeldSettings(
            BLURRED,
            THREE_SKILLS,
            timers=ONE_BY_ONE,
            episodes=EPISODES,
            taught=70,
            alone=333,
            held=SlowHeld(True, 10),
            all_skills_learn=True,
            binary_rewards=True,
        ),
        {"alone and done": 5, "kept": 1_000, "taught what is not there": 100},
        9_000,
    ),
    "applicable skills alone": Case(
        HeldSettings(SMALL, THREE_SKILLS, applicable=0.6),
        {"not applicable": 500},
    ),
    "applicable skills alone, in episodes, with choices kept": Case(
        HeldSettings(
            CLOSE,
            THREE_SKILLS,
            timers=ONE_BY_ONE,
            episodes=EPISODES,
            applicable=0.9,
            held=SlowHeld(False, 2),
            initial_q=-0.5,
        ),
        {"not applicable": 100, "none applicable": 50},
        9_000,
    ),
}


def held_spec_of(settings: HeldSettings) -> RunSpec:
    """The same run as a preset would state it."""
    document = spec_of(settings).model_dump()
    until = "change" if settings.held.until_change else "steps"
    discount = "choice" if settings.held.once else "step"
    held = {"until": until, "most": settings.held.most, "discount": discount}
    document["learner"] |= {
        "held": None if settings.held == ONE_STEP else held,
        "applicable": settings.applicable,
    }
    document["schedule"] |= {
        "teach": {"trials": settings.taught} if settings.taught else None,
        "pretrain": settings.alone,
    }
    return RunSpec.model_validate(document)


@pytest.mark.parametrize("name", CASES)
def test_every_step_and_every_value_is_that_of_the_reference(name: str) -> None:
    case = CASES[name]
    slow = HeldLearner(case.settings, seed=31)
    run = Run(held_spec_of(case.settings), seed=31)
    pretrained = case.settings.alone * len(case.settings.skills)
    for number in range(1, case.steps + 1):
        trial = run.trial
        step = slow.step()
        assert run.advance(max_steps=1) == 1
        if number > pretrained:
            assert_same_step(run, slow, trial, step)
        else:
            assert last_cell(run) == step.cell
            assert board_xy(run.world, run.state.place[CELL]) == slow.cell
            assert (run.state.place[HEADING], run.trial) == (slow.heading, 0)
            assert run.state.tally[TRIAL_STEP] == slow.trial_step
        if number % 500 == 0 or number in (pretrained, case.steps):
            assert_same_tables(run, slow)
    assert run.state.best_ever.tolist() == [
        *(slow.most_ever.values() if case.settings.applicable is not None else ())
    ]
    for event, times in case.must_see.items():
        assert slow.happened[event] >= times, event


@pytest.mark.parametrize("name", CASES)
def test_how_steps_are_divided_into_calls_makes_no_difference(name: str) -> None:
    settings = CASES[name].settings
    slow, run = HeldLearner(settings, seed=32), Run(held_spec_of(settings), seed=32)
    for steps in (1, 332, 367, 1, 4_300):
        for _ in range(steps):
            slow.step()
        assert run.advance(max_steps=steps) == steps
        assert_same_tables(run, slow)
        if run.alone is None:
            logged = run.state.log_steps[: run.trial].sum()
            assert logged + run.state.tally[[EARLIER, TRIAL_STEP]].sum() == run.step


def _digest_of(name: str) -> str:
    run = Run(held_spec_of(CASES[name].settings), seed=33)
    run.advance(max_steps=2_500)
    return digest(run.state)


def test_compiled_and_plain_python_agree_bit_for_bit() -> None:
    # Unsigned words that wrap around are meant to; only plain Python warns of them.
    plain = subprocess.run(
        [sys.executable, "-W", "ignore", __file__],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert plain.stdout.splitlines() == [_digest_of(name) for name in CASES]


if __name__ == "__main__":
    sys.stdout.writelines(f"{_digest_of(name)}\n" for name in CASES)
