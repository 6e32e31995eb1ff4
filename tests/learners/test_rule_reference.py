"""Skills join, and are explored, in the very steps in which the slow reference has them."""

import math

import numpy as np
import pytest

from learners.commands import Introduce
from learners.run import Run
from learners.spec import RunSpec
from tests.support.reference import SlowSettings
from tests.support.reference_rule import RuledLearner, SlowRule
from tests.support.stepwise import (
    CLOSE,
    COARSE,
    SMALL,
    assert_same_step,
    assert_same_tables,
    spec_of,
)

SKILLS = ("approach", "circle_clockwise", "avoid")

CASES = {
    "novelty": (
        SlowSettings(CLOSE, SKILLS),
        SlowRule("novelty", 25, 0.6, freeze=10, duration=60, probability=0.5),
    ),
    "reach, explored where nothing is known": (
        SlowSettings(CLOSE, SKILLS),
        SlowRule("reach", 20, 0.05, freeze=5, duration=80, probability=0.6, value_at_most=1.0),
    ),
    "reach, no freeze, explorations overlap": (
        SlowSettings(COARSE, SKILLS, epsilon=0.3),
        SlowRule("reach", 8, 0.3, freeze=0, duration=70, probability=0.3, value_at_most=0.0),
    ),
    "change": (
        SlowSettings(SMALL, SKILLS, alpha=0.3),
        SlowRule("change", 15, 2.0, freeze=10, duration=90, probability=0.9),
    ),
    "a window of one trial, four skills": (
        SlowSettings(CLOSE, (*SKILLS, "circle_counterclockwise"), all_skills_learn=True),
        SlowRule("novelty", 1, 0.5, freeze=3, duration=30, probability=0.4, value_at_most=2.5),
    ),
}


def ruled(settings: SlowSettings, rule: SlowRule) -> RunSpec:
    """The same run as a preset would state it."""
    first, *others = settings.skills
    where = {} if rule.value_at_most == math.inf else {"value_at_most": rule.value_at_most}
    document = spec_of(settings).model_dump()
    document["schedule"] |= {
        "introduce": {"by": rule.by, "window": rule.window, "below": rule.below},
        "skills": {first: {"at": 0, "freeze": rule.freeze}}
        | {skill: {"freeze": rule.freeze} for skill in others},
        "episodes": [
            {
                "skill": skill,
                "duration": rule.duration,
                "probability": rule.probability,
                "where": where or None,
            }
            for skill in others
        ],
    }
    return RunSpec.model_validate(document)


def joined(run: Run) -> list[tuple[str, int]]:
    """Skills that joined by a rule, and the trials before which they did."""
    return [
        (event.command.skill, event.trial)
        for event in run.control.history
        if isinstance(event.command, Introduce) and event.author == "trigger"
    ]


@pytest.mark.parametrize("name", CASES)
def test_every_step_and_every_value_is_that_of_the_reference(name: str) -> None:
    settings, rule = CASES[name]
    slow, run = RuledLearner(settings, rule, seed=3), Run(ruled(settings, rule), seed=3)
    for number in range(1, 9_001):
        trial = run.trial
        step = slow.step()
        assert run.advance(max_steps=1) == 1
        assert_same_step(run, slow, trial, step)
        assert joined(run) == slow.joined
        if number % 3_000 == 0:
            assert_same_tables(run, slow)
    assert len(slow.joined) == len(settings.skills) - 1
    assert slow.happened["imposed"] > 100
    assert (slow.happened["left to an ordinary choice"] > 20) == (rule.value_at_most < math.inf)
    noted = [(note.new_states, note.reached, note.steps) for note in slow.notes]
    state, done = run.state, slice(run.trial)
    logs = np.stack([state.log_new_states, state.log_reached, state.log_steps], axis=1)
    np.testing.assert_array_equal(logs[done], noted)
    change = [note.change for note in slow.notes]
    np.testing.assert_array_equal(state.log_change[done], np.array(change, np.float32))


@pytest.mark.parametrize("name", CASES)
def test_a_run_made_in_few_calls_learns_the_same(name: str) -> None:
    settings, rule = CASES[name]
    slow, run = RuledLearner(settings, rule, seed=8), Run(ruled(settings, rule), seed=8)
    for steps in (20_000, 1, 4_999):
        for _ in range(steps):
            slow.step()
        run.advance(max_steps=steps)
        assert joined(run) == slow.joined
        assert_same_tables(run, slow)
