"""Static selection and skills that differ: as the definition says, step by step and bit for bit."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from learners.kernel.state import tables, value_of
from learners.policies.static import RULES
from learners.run import Run
from tests.support.reference import SlowEpisode, SlowTimer, SlowWorld
from tests.support.reference_static import (
    SlowSkill,
    StaticLearner,
    StaticSettings,
    spec_of,
)
from tests.support.stepwise import assert_same_step, visits_of

SMALL = SlowWorld(size=24, step_limit=60)
CLOSE = SlowWorld(size=20, n_directions=8, n_distances=4, start_radius=(6, 20), step_limit=40)
BLURRED = SlowWorld(
    size=26,
    n_directions=8,
    n_distances=6,
    step_limit=80,
    skill_n_directions=24,
    skill_n_distances=18,
    twice_ring_exponent=4,
)
TWO = ("appetite", "fear")
FOUR = ("fear", "approach", "appetite", "avoid")
OF_ONES_OWN = {
    "slow": SlowSkill({"approach": 0.5}, alpha=0.125, sees_heading=True),
    "shy": SlowSkill({"avoid": 1.0}, flight=-4.0, ends_with_trial=True),
    "bold": SlowSkill({"circle_clockwise": 2.0}, behind=-0.5, flight=3.0, sees_heading=True),
}


def static(rule: str, skills: tuple[str, ...] = TWO, **others: Any) -> StaticSettings:
    """Settings in which a rule selects."""
    values = {"world": CLOSE, "skill_alpha": 0.05} | others
    return StaticSettings(skills=skills, rule=rule, all_skills_learn=True, **values)


@dataclass(frozen=True)
class Case:
    """A run to compare, and what must have happened in it for the comparison to mean much."""

    settings: StaticSettings
    steps: int = 5_000
    must_see: Mapping[str, int] = field(default_factory=dict)


CASES = {
    **{f"{rule}, appetite and fear": Case(static(rule, world=SMALL)) for rule in RULES},
    **{f"{rule}, four skills": Case(static(rule, FOUR), 4_000) for rule in RULES},
    **{
        f"{rule}, weights": Case(
            static(rule, FOUR, weights={"fear": 0.3, "avoid": 2.5, "appetite": 0.0}), 3_000
        )
        for rule in RULES
    },
    **{
        f"{rule}, timers and episodes": Case(
            static(
                rule,
                FOUR,
                timers={"appetite": SlowTimer(20, 10), "avoid": SlowTimer(40, 30)},
                episodes=(
                    SlowEpisode("appetite", 20, 40, 0.8),
                    SlowEpisode("avoid", 45, 30, 0.3),
                ),
            ),
            3_000,
            {"imposed": 200},
        )
        for rule in RULES
    },
    "a learned selection of skills that differ": Case(
        StaticSettings(CLOSE, ("approach", *OF_ONES_OWN), own=OF_ONES_OWN), 6_000
    ),
    "all of them learn, and are told only that they earned something": Case(
        StaticSettings(
            CLOSE,
            ("appetite", *OF_ONES_OWN),
            own=OF_ONES_OWN,
            all_skills_learn=True,
            binary_rewards=True,
        ),
        4_000,
        {"learned from another's move": 1_000},
    ),
    "skills that differ and see other states than the selection": Case(
        StaticSettings(BLURRED, ("fear", *OF_ONES_OWN), own=OF_ONES_OWN, initial_q=0.5), 4_000
    ),
    "a rule for skills of one's own": Case(
        static("collective", tuple(OF_ONES_OWN), own=OF_ONES_OWN, initial_q=0.25),
        4_000,
        {"nobody's own best move": 100},
    ),
}
MUST_SEE = {
    "negotiated_unhappiness": {"taken over": 200},
    "w_learning": {"W learned": 500},
}


def assert_same_tables(run: Run, slow: StaticLearner) -> None:
    """All that was learned is the same to the last bit."""
    fast = tables(run.spec, run.state)
    skill_q = slow.skill_q()
    if fast["skill_q"].ndim == 4:
        skill_q = skill_q[:, 0]
    np.testing.assert_array_equal(fast["skill_q"], skill_q, strict=True)
    np.testing.assert_array_equal(fast["visits"], visits_of(slow), strict=True)
    if slow.settings.rule == "learned":
        for state, values in slow.selection.items():
            for option, value in values.items():
                at = slow.settings.options.index(option)
                assert fast["selection_q"][(*state, at)] == value
        return
    np.testing.assert_array_equal(fast["selection_q"], slow.wishes(), strict=True)
    reached = {
        state: int(fast["first_reach"][state])
        for state in slow.selection
        if fast["first_reach"][state] >= 0
    }
    if slow.settings.initial_q <= 0:
        assert reached == slow.reached
    if slow.settings.rule == "w_learning":
        shape = (len(slow.settings.skills), *value_of(run.spec, run.state).shape)
        w = np.full(shape, np.nan, np.float32)
        for number, name in enumerate(slow.settings.skills):
            for state, value in slow.w[name].items():
                w[(number, *state)] = value
        np.testing.assert_array_equal(run.state.w_values.reshape(shape), w, strict=True)
    else:
        assert run.state.w_values.size == 0


@pytest.mark.parametrize("name", CASES)
def test_every_step_and_every_value_is_that_of_the_reference(name: str) -> None:
    case = CASES[name]
    slow = StaticLearner(case.settings, 5)
    run = Run(spec_of(case.settings), 5)
    for number in range(1, case.steps + 1):
        trial = run.trial
        step = slow.step()
        assert run.advance(max_steps=1) == 1
        assert_same_step(run, slow, trial, step)
        if number % 1_000 == 0:
            assert_same_tables(run, slow)
    must_see = dict(case.must_see)
    if "four skills" in name:
        must_see |= MUST_SEE.get(case.settings.rule, {})
    for event, times in must_see.items():
        assert slow.happened[event] >= times, event
    assert slow.happened["flight"] > 5
