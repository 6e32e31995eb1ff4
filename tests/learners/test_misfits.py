"""A schedule that cannot work with its learner is refused, and why."""

from typing import Any

import pytest
from pydantic import ValidationError

from learners.names import MAX_TRIALS
from learners.spec import RunSpec
from sim.spec import ProblemsError

SKILLS: dict[str, Any] = {"options": ["approach", "avoid"], "alpha": 0.1}
BY_A_RULE = SKILLS | {"selection": "collective", "skills_that_learn": "all"}
REACH = {"by": "reach"}


def refusals(learner: dict[str, Any], schedule: dict[str, Any]) -> list[str]:
    """What is said of a schedule, one line for each problem."""
    document = {"learner": learner, "schedule": schedule, "trials": 10}
    with pytest.raises(ValidationError) as refused:
        RunSpec.model_validate(document)
    found: list[str] = []
    for error in refused.value.errors():
        cause = error.get("ctx", {}).get("error")
        assert isinstance(cause, ProblemsError)
        found += [f"{'.'.join(map(str, p.key))}: {p.value!r} {p.message}" for p in cause.problems]
    return found


def test_a_rule_needs_skills() -> None:
    assert refusals({"options": "moves", "alpha": 0.6}, {"introduce": REACH}) == [
        "introduce: 'reach' is a rule by which skills join, and the options are moves;"
        " allowed: none"
    ]


def test_the_change_of_a_table_cannot_be_watched_where_there_is_none() -> None:
    by_change = {"by": "change"}
    expected = (
        "introduce.by: 'change' asks how much a table changes, and collective has none;"
        " allowed: novelty, reach"
    )
    assert refusals(BY_A_RULE, {"introduce": by_change}) == [expected]
    own = {"skills": {"avoid": {"introduce": by_change}}}
    assert refusals(BY_A_RULE, own) == [f"skills.avoid.{expected}"]


def test_nothing_is_to_be_reached_where_all_begins_above_0() -> None:
    (line,) = refusals(SKILLS | {"initial_q": 2.5}, {"introduce": REACH})
    assert line == (
        "introduce.by: 'reach' waits for states whose value rises above 0, and all begin there,"
        " with initial_q 2.5; allowed: novelty, change"
    )


def test_a_context_needs_values_of_states() -> None:
    episode = {"skill": "avoid", "duration": 5, "probability": 0.5, "where": {"value_at_most": 1}}
    assert refusals(BY_A_RULE, {"episodes": [episode]}) == [
        "episodes.0.where.value_at_most: 1.0 asks what a table says of a state, and collective has"
        " none; allowed: none"
    ]


def test_an_exploration_of_a_skill_that_joins_by_a_rule_begins_with_that() -> None:
    episode = {"skill": "avoid", "at": 5, "duration": 5, "probability": 0.5}
    assert refusals(SKILLS, {"introduce": REACH, "episodes": [episode]}) == [
        "episodes.0.at: 5 is a trial, and a rule says when avoid joins; allowed: introduction"
    ]


def test_a_skill_has_a_trial_or_a_rule() -> None:
    with pytest.raises(ValidationError, match="stands beside a rule by which the skill joins"):
        RunSpec.model_validate(
            {
                "learner": SKILLS,
                "schedule": {"skills": {"avoid": {"at": 3, "introduce": REACH}}},
                "trials": 10,
            }
        )


def test_the_first_skill_listed_is_there_from_the_start() -> None:
    document = {"learner": SKILLS, "schedule": {"introduce": REACH}, "trials": 10}
    schedule = RunSpec.model_validate(document).schedule
    joins = [schedule.introduced_at(skill) for skill in ("approach", "avoid")]
    assert joins == [0, MAX_TRIALS]
