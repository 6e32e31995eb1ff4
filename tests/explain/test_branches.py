"""A branch's name says what is otherwise on it; so does the note, which says how to go back."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.documents import presets
from app.explain.branches import MOST_CHARACTERS, difference_in_words, name_of
from app.schedule.edits import changed, moved, now_of, with_episode, without
from learners.commands import (
    Command,
    CommandError,
    DefineSkill,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Remove,
    SetParameter,
    SetSchedule,
    StopExploring,
    StopTeaching,
    Teach,
    Undo,
)
from learners.names import MAX_TRIALS
from learners.run import Run
from learners.schedule_spec import TriggerSpec
from learners.skill_spec import SkillWeights
from tests.support.schedules import AVOID, AVOIDING, commands, driven, seen, small_run, to

BACK = " End goes back to the live run, which is as it was."


def standard(trial: int) -> Run:
    """The schedule of the thesis, in a world whose hunts are over at once."""
    return to(Run(presets.load("timed", ["world.size=30", "world.step_limit=5"]), 1), trial)


@pytest.fixture(scope="module")
def run() -> Run:
    """Where circle clockwise is about to join, and avoid is ahead."""
    return standard(12_000)


def told(run: Run, *given: Command) -> tuple[str, str]:
    """Name of a branch with these commands, and what its note says is otherwise."""
    note = difference_in_words(run.control, run.trial, given)
    assert note.startswith("Here ")
    assert note.endswith(BACK)
    return name_of(run.control, run.trial, given), note.removesuffix(BACK)


def test_a_skill_that_joins_at_another_time_is_said_by_how_much(run: Run) -> None:
    plan, now = run.spec.schedule, now_of(seen(run))
    assert told(run, Introduce("avoid", 300)) == (
        "avoid 2,500 earlier",
        "Here avoid joins at trial 12,000 and not at 14,500.",
    )
    later = SetSchedule(moved(plan, AVOID, 5_500, now))
    assert told(run, later)[0] == "avoid 5,500 later"
    assert told(run, later, SetSchedule(plan))[0] == "the same again"
    assert told(run, SetSchedule(moved(plan, AVOID, MAX_TRIALS, now))) == (
        "no avoid",
        "Here avoid does not join at trial 14,500.",
    )
    assert told(run, Introduce("circle_counterclockwise", 0)) == (
        "circle counterclockwise added",
        "Here circle counterclockwise joins at trial 12,000.",
    )


def test_one_that_joins_just_when_it_was_to_join_is_not_earlier_by_nothing(run: Run) -> None:
    assert told(run, Introduce("circle_clockwise", 0))[0] == "circle clockwise added"


def test_one_that_leaves_is_no_more() -> None:
    later = standard(16_600)
    assert told(later, Remove("avoid")) == ("no avoid", "Here avoid leaves at trial 16,600.")
    assert told(later, Remove("avoid"), Introduce("avoid", 0))[0] == "the same again"


def test_explorations_are_named_with_the_share_of_steps() -> None:
    exploring = standard(15_000)
    assert told(exploring, Explore("circle_clockwise", 1_000, 0.05)) == (
        "circle clockwise explored at 5%",
        "Here circle clockwise is explored in 5% of the steps until trial 16,000.",
    )
    assert told(exploring, StopExploring("avoid")) == (
        "avoid not explored",
        "Here avoid is not explored from trial 15,000 on.",
    )


def test_what_is_planned_otherwise_is_named(run: Run) -> None:
    plan, now = run.spec.schedule, now_of(seen(run))
    names = {
        "avoid explored at 60%": changed(plan, AVOIDING, now, probability=0.6),
        "avoid explored for 500": changed(plan, AVOIDING, now, trials=500),
        "avoid explored from 15,000 on": changed(plan, AVOIDING, now, at=15_000),
        "avoid not explored": without(plan, AVOIDING, now),
        "approach explored at 20%": with_episode(plan, "approach", 20_000, 500, 0.2, now),
        "avoid, freeze of 0": changed(plan, AVOID, now, trials=0),
    }
    assert {told(run, SetSchedule(after))[0]: after for after in names.values()} == names


def test_parameters_and_what_is_held_still_are_named(run: Run) -> None:
    assert told(run, SetParameter("learner.epsilon", 0.2)) == (
        "ε 0.2",
        "Here exploration ε is 0.2 and not 0.1.",
    )
    flight = told(run, SetParameter("world.flight_reward", -5.0))
    assert flight[1] == "Here flight reward is \N{MINUS SIGN}5 and not \N{MINUS SIGN}50."
    assert told(run, FreezeSelection(True))[0] == "selection frozen"
    assert told(run, FreezeSkills(True))[0] == "skills frozen"
    assert told(run, FollowSchedule(False)) == (
        "schedule not followed",
        "Here the schedule is not followed.",
    )
    weights = SkillWeights(approach=0.5)
    assert told(run, DefineSkill("spiral_in", weights))[0] == "spiral in defined"


def test_only_what_comes_of_several_commands_is_told(run: Run) -> None:
    undone = Undo(len(run.control.history))
    assert told(run, SetParameter("learner.epsilon", 0.2), undone) == (
        "the same again",
        "Here nothing is otherwise from trial 12,000 on.",
    )
    given = (SetParameter("learner.epsilon", 0.3), Introduce("avoid", 0), FreezeSkills(True))
    assert told(run, *given) == (
        "avoid 2,500 earlier and 2 more",
        "Here avoid joins at trial 12,000 and not at 14,500, exploration ε is 0.3 and not 0.1"
        " and the skills are frozen by hand.",
    )
    assert told(run, *given, FollowSchedule(False))[1] == (
        "Here avoid joins at trial 12,000 and not at 14,500, exploration ε is 0.3 and not 0.1"
        " and 2 other things are set otherwise."
    )


def test_a_long_name_of_a_skill_is_cut_and_not_what_is_otherwise(run: Run) -> None:
    name = "a_skill_with_a_name_that_is_long"
    given = (DefineSkill(name, SkillWeights(approach=0.5)), Introduce(name, 0))
    assert told(run, *given)[0] == "a skill with a name that is long added"
    explored = told(run, *given, Explore(name, 100, 0.25))[0]
    assert explored == "a skill with a name th… added and 1 more"
    assert len(explored) == MOST_CHARACTERS


@given(st.lists(st.tuples(st.integers(0, 3_000), commands), max_size=6), st.lists(commands))
def test_a_name_is_there_is_short_and_needs_no_escaping(
    script: list[tuple[int, Command]], wished: list[Command]
) -> None:
    fork = driven(small_run(), script)
    branch = fork.copy()
    done: list[Command] = []
    for command in wished:
        try:
            branch.apply(command)
        except CommandError:
            continue
        done.append(command)
    name, note = told(fork, *done)
    assert 1 <= len(name) <= MOST_CHARACTERS
    assert len(note) < 400
    assert not set("<>&\"'\n") & set(name + note)


def test_one_that_joins_by_a_rule_or_no_longer_is_named() -> None:
    run = Run(presets.load("timed_context", ["world.size=30", "world.step_limit=5"]), 1)
    plan, now = run.spec.schedule, now_of(seen(run))
    assert told(run, SetSchedule(changed(plan, AVOID, now, at=900))) == (
        "avoid at trial 900",
        "Here avoid joins at trial 900 and not by its rule.",
    )
    assert told(run, Introduce("avoid", 0))[1].startswith(
        "Here avoid joins at trial 0 and not by its rule"
    )
    novelty = plan.model_copy(update={"introduce": TriggerSpec(by="novelty")})
    assert told(run, SetSchedule(novelty)) == (
        "circle clock… by another rule and 1 more",
        "Here circle clockwise joins by another rule and avoid joins by another rule.",
    )
    assert told(run, SetSchedule(changed(plan, AVOID, now, trials=7)))[0] == "avoid, freeze of 7"
    assert told(run, SetSchedule(changed(plan, AVOIDING, now, probability=0.6))) == (
        "avoid explored at 60%",
        "Here avoid is explored in 60% of the steps where nothing else is worth more than 1, for"
        " 2,000 trials once it joins.",
    )
    assert told(run, SetSchedule(without(plan, AVOIDING, now)))[1] == (
        "Here avoid is not explored once it joins."
    )
    assert told(run, Explore("approach", 9, 0.5, value_at_most=2))[1] == (
        "Here approach is explored in 50% of the steps where nothing else is worth more than 2"
        " until trial 9."
    )


def test_teaching_is_said_with_its_end() -> None:
    run = standard(14_600)
    assert told(run, Teach("flank", 200)) == (
        "taught for 200",
        "Here a script teaches until trial 14,800.",
    )
    run.apply(Teach("flank", 200))
    assert told(run, StopTeaching()) == (
        "not taught",
        "Here no script teaches from trial 14,600 on.",
    )
    assert told(run, Teach("flank", 200))[0] == "the same again"
