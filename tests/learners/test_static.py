"""Static selection and skills that differ: as the definition says, step by step and bit for bit."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from learners.checkpoints import logs_of
from learners.commands import FreezeSelection, FreezeSkills, Introduce, Remove, Undo
from learners.hunts import hunt, policy_of, stream_of
from learners.kernel.state import digest, tables, value_of
from learners.policies.greedy import choices_of, rule_of
from learners.policies.static import RULES
from learners.run import Run, replay
from learners.skill_spec import BUILT_IN, SkillWeights
from learners.spec import RunSpec
from sim.bits import U
from sim.world import board_xy, cell_at
from tests.support.reference import MOVES, SlowEpisode, SlowTimer, SplitMix64
from tests.support.reference_static import (
    APPETITE,
    SlowSkill,
    StaticLearner,
    StaticSettings,
    spec_of,
)
from tests.support.stepwise import BLURRED, CLOSE, OUTCOMES, SMALL, assert_same_step, visits_of

TWO = ("appetite", "fear")
FOUR = ("fear", "approach", "appetite", "avoid")
OF_ONES_OWN = {
    "slow": SlowSkill({"approach": 0.5}, alpha=0.125, sees_heading=True),
    "shy": SlowSkill({"avoid": 1.0}, flight=-4.0, ends_with_trial=True),
    "bold": SlowSkill({"circle_clockwise": 2.0}, behind=-0.5, flight=3.0, sees_heading=True),
}


def static(rule: str, skills: tuple[str, ...] = TWO, **others: Any) -> StaticSettings:
    """Settings in which a rule selects."""
    values: dict[str, Any] = {"world": CLOSE, "skill_alpha": 0.3}
    values |= others
    return StaticSettings(skills=skills, rule=rule, all_skills_learn=True, **values)


@dataclass(frozen=True)
class Case:
    """A run to compare, and what must have happened in it for the comparison to mean much."""

    settings: StaticSettings
    steps: int = 5_000
    must_see: Mapping[str, int] = field(default_factory=dict[str, int])


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
            {"imposed": 150},
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
    "an appetite that goes on when a trial ends": Case(
        static(
            "best_happiness",
            ("greed", "fear"),
            own={"greed": replace(APPETITE, ends_with_trial=False)},
        ),
        4_000,
        {"gained behind": 500},
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


def preset(**learner: object) -> RunSpec:
    """A preset with appetite and fear, but for what is given of the learner."""
    stated = {
        "options": list(TWO),
        "alpha": 0.1,
        "selection": "collective",
        "skills_that_learn": "all",
    }
    return RunSpec.model_validate({"learner": stated | learner, "trials": 2_000})


@pytest.mark.parametrize("rule", RULES)
def test_what_a_rule_may_choose_is_found_by_asking_it_with_every_tie_broken(rule: str) -> None:
    slow = StaticLearner(static(rule, FOUR, weights={"fear": 0.5}), 3)
    for _ in range(2_500):
        slow.step()
    run = Run(spec_of(slow.settings), 3)
    run.advance(max_steps=2_500)
    rule_now = rule_of(run.spec, run.state)
    assert rule_now is not None
    found = choices_of(run.spec, rule_now)
    parts = [((2 * part + 1) << 16) // (2 * 9) for part in range(9)]
    quarters = [((2 * part + 1) << 16) // (2 * len(FOUR)) for part in range(len(FOUR))]
    cells = {slow.world.reading((x, y)): (x, y) for x in range(20) for y in range(20)}
    for heading in (0, 3):
        for reading, cell in cells.items():
            slow.heading, slow.cell = heading, cell
            made = Counter(
                slow.selected(None, list(FOUR), skill16, move16)
                for skill16 in quarters
                for move16 in parts
            )
            at = (heading, *reading)
            for number, name in enumerate(FOUR):
                moves = {MOVES.index(move) for chosen, move in made if chosen == name}
                assert {m for m in range(9) if int(found.moves[(number, *at)]) >> m & 1} == moves
                share = sum(times for (chosen, _), times in made.items() if chosen == name) / 36
                assert found.share[(*at, number)] == pytest.approx(share, abs=1e-5)
                assert int(found.options[at]) >> number & 1 == (share > 0)


@pytest.mark.parametrize("rule", RULES)
def test_a_greedy_hunt_asks_the_rule_in_each_step_with_the_steps_draw(rule: str) -> None:
    slow = StaticLearner(static(rule, world=SMALL), 4)
    for _ in range(6_000):
        slow.step()
    run = Run(spec_of(slow.settings), 4)
    run.advance(max_steps=6_000)
    policy = policy_of(run.spec, run.state)
    for place in ((2, 3), (20, 12), (12, 22)):
        for heading in range(8):
            made = hunt(run.world, policy, cell_at(run.world, *place), heading, seed=9)
            start = U(cell_at(run.world, *place))
            draws = SplitMix64(int(stream_of(U(9), U(heading), start)))
            slow.heading, slow.cell = heading, place
            outcome, steps = None, 0
            for steps in range(1, made.steps + 1):
                draw = draws.draw()
                name, move = slow.selected(None, list(TWO), draw >> 16 & 0xFFFF, draw >> 48)
                assert (TWO[made.options[steps - 1]], MOVES[made.moves[steps - 1]]) == (name, move)
                after = SMALL.moved(slow.cell, move)
                outcome = SMALL.outcome(heading, slow.cell, after)
                slow.cell = after
                if outcome is not None:
                    break
            assert made.steps == steps
            assert OUTCOMES[made.outcome] == (outcome or "timeout")
            assert board_xy(run.world, made.cells[-1]) == slow.cell


@pytest.mark.parametrize(
    ("given", "key", "says"),
    [
        ({"learner": {"options": "moves"}}, "selection", "there are none; allowed: learned"),
        ({"learner": {"skills_that_learn": "chosen"}}, "skills_that_learn", "allowed: all"),
        ({"learner": {"held": {"until": "change"}}}, "held", "chooses anew in each step"),
        ({"learner": {"selection": "learned", "weights": {"fear": 1.0}}}, "weights.fear", "weight"),
        ({"learner": {"weights": {"avoid": 1.0}}}, "weights.avoid", "allowed: appetite, fear"),
        ({"world": {"skill_n_directions": 8}}, "selection", "skill_n_directions"),
        (
            {"schedule": {"introduce": {"by": "change"}}},
            "introduce.by",
            "asks how much a table changes, and collective has none; allowed: novelty, reach",
        ),
        (
            {"schedule": {"skills": {"fear": {"introduce": {"by": "change"}}}}},
            "skills.fear.introduce.by",
            "asks how much a table changes, and collective has none; allowed: novelty, reach",
        ),
        (
            {
                "schedule": {
                    "episodes": [
                        {
                            "skill": "fear",
                            "duration": 5,
                            "probability": 0.5,
                            "where": {"value_at_most": 1.0},
                        }
                    ]
                }
            },
            "episodes.0.where.value_at_most",
            "asks what a table says of a state, and collective has none; allowed: none",
        ),
        ({"schedule": {"teach": {"trials": 5}}}, "teach", "is for a selection that learns"),
    ],
)
def test_what_cannot_work_with_a_rule_is_refused_with_the_reason(
    given: dict[str, dict[str, object]], key: str, says: str
) -> None:
    document: dict[str, Any] = preset().model_dump(exclude_defaults=True)
    for part, values in given.items():
        document[part] = document.get(part, {}) | values
    with pytest.raises(ValidationError) as refused:
        RunSpec.model_validate(document)
    (error,) = refused.value.errors()
    problems = error.get("ctx", {})["error"].problems
    found = {".".join(map(str, problem.key)): problem.message for problem in problems}
    assert says in found[key], found


def test_a_built_in_skill_is_not_stated_again_and_its_parts_are_as_they_are_documented() -> None:
    with pytest.raises(ValidationError, match="built-in skill"):
        preset(custom_skills={"fear": {}})
    alike: dict[str, Any] = {"sees": "prey_heading", "ends_with_trial": True, "alpha": 0.05}
    assert BUILT_IN["appetite"] == SkillWeights(behind=1.0, **alike)
    assert BUILT_IN["fear"] == SkillWeights(flight=-50.0, **alike)


def test_a_skill_that_sees_headings_joins_by_hand_a_learner_whose_skills_see_none() -> None:
    spec = RunSpec.model_validate(
        {"learner": {"options": ["approach", "avoid"], "alpha": 0.1}, "trials": 500}
    )
    run = Run(spec, 3)
    run.advance(max_steps=3_000)
    before = tables(run.spec, run.state)["skill_q"]
    run.apply(Introduce("fear", 5))
    after = tables(run.spec, run.state)["skill_q"]
    assert after.shape == (3, 8, *before.shape[1:])
    np.testing.assert_array_equal(after[:2], np.broadcast_to(before[:, None], after[:2].shape))
    assert not after[2].any()
    run.advance(max_steps=20_000)
    learned = tables(run.spec, run.state)["skill_q"][2]
    assert learned.min() < -1
    assert learned.max() <= 0
    assert len({view.tobytes() for view in learned}) > 1
    again = replay(spec, 3, run.journal, run.step)
    assert digest(again.state) == digest(run.state)
    run.apply(Undo(run.control.history[-1].number))
    assert run.present == ("approach", "avoid")


@pytest.mark.parametrize("rule", RULES)
def test_a_run_is_the_same_however_its_steps_are_divided_and_from_any_checkpoint(rule: str) -> None:
    spec = preset(selection=rule, weights={"fear": 2.0})
    whole = Run(spec, 8)
    whole.advance(max_steps=12_345)
    parts = Run(spec, 8)
    for steps in (1, 7, 1_000, 2_222):
        parts.advance(max_steps=steps)
    copy = Run.restored(parts.checkpoint(), logs_of(parts.state))
    assert digest(copy.state) == digest(parts.state)
    for run in (parts, copy):
        run.advance(max_steps=12_345 - run.step)
        assert digest(run.state) == digest(whole.state)


def test_what_is_learned_is_held_still_by_command_at_both_levels() -> None:
    run = Run(preset(selection="w_learning"), 2)
    run.advance(max_steps=5_000)
    run.apply(FreezeSelection(True))
    w_before, q_before = run.state.w_values.copy(), run.state.skills.copy()
    run.advance(max_steps=2_000)
    np.testing.assert_array_equal(run.state.w_values, w_before)
    assert (run.state.skills != q_before).any()
    run.apply(FreezeSelection(False))
    run.apply(FreezeSkills(True))
    q_before = run.state.skills.copy()
    run.advance(max_steps=2_000)
    assert (run.state.w_values != w_before).any()
    np.testing.assert_array_equal(run.state.skills, q_before)


def test_a_removed_skill_has_no_say_any_more() -> None:
    run = Run(preset(), 2)
    run.advance(max_steps=5_000)
    run.apply(Remove("fear"))
    shown = tables(run.spec, run.state)["selection_q"]
    assert np.isnan(shown[..., 1]).all()
    before = tables(run.spec, run.state)["visits"][..., 1].sum()
    run.advance(max_steps=5_000)
    assert tables(run.spec, run.state)["visits"][..., 1].sum() == before
