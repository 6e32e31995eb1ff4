"""Where two runs part is said with its step and trial, what each did there, and why."""

import pytest

from app.explain.divergence import divergence_in_words, same_in_words
from app.live.divergence import Did, Divergence, first_divergence
from app.live.past import Budget, Past
from learners.commands import (
    Command,
    DefineSkill,
    Explore,
    FreezeSelection,
    Introduce,
    SetParameter,
)
from learners.control import Control
from learners.run import Run
from learners.skill_spec import SkillWeights
from sim.geometry import STAY
from tests.support.lines import SEED, SPEC, play
from tests.support.races import small

CONTROL = Control.at_start(SPEC)
NORTH, EAST = 7, 5


def parted(one: Did, other: Did) -> str:
    return divergence_in_words(Divergence(412_344, 12_907, False, (one, other), (SEED, SEED)))


def did(skill: str | None = None, move: int | None = NORTH, *given: Command) -> Did:
    return Did(skill, move, given, CONTROL)


UNTIL = "The same until step 412,344 (trial 12,907)"


@pytest.mark.parametrize(
    ("one", "other", "said"),
    [
        (did("approach"), did("circle_clockwise"), "A took approach, B circle clockwise"),
        (did("approach"), did("approach", EAST), "both took approach; A went north, B east"),
        (did("approach"), did("approach", STAY), "both took approach; A went north, B stayed"),
        (did("avoid", STAY), did("avoid"), "both took avoid; A stayed, B went north"),
        (did("avoid"), did("avoid"), "both took avoid, and learned otherwise from it"),
        (did(), did(None, EAST), "A went north, B east"),
        (did(), did(), "both went north, and learned otherwise from it"),
        (did("approach"), did(None, EAST), "A took approach, B went east"),
        (did(None, STAY), did("approach"), "A stayed, B took approach"),
    ],
)
def test_what_each_did_is_said(one: Did, other: Did, said: str) -> None:
    assert parted(one, other) == f"{UNTIL}: {said}."


def test_what_was_given_to_one_alone_is_said() -> None:
    freezes = FreezeSelection(True)
    one, other = did("approach"), did("avoid", NORTH, Introduce("avoid", 300), freezes)
    said = "there avoid added and selection frozen in B alone"
    assert parted(one, other) == f"{UNTIL}; {said}. Then A took approach, B avoid."
    assert parted(did(None, None), did(None, None, *other.given)) == f"{UNTIL}; {said}."
    both = did("approach", NORTH, Explore("approach", 30, 0.5)), other
    assert "; there approach explored at 50% in A alone, avoid added and" in parted(*both)


def line(run: Run, *script: tuple[int, Command]) -> Past:
    past = Past(run, Budget())
    play(run, past, script, rest=900)
    return past


def said_of(one: Past, other: Past) -> str:
    found = first_divergence(one, other)
    assert found is not None
    return divergence_in_words(found, "live", "branch")


def test_why_it_came_to_that_is_said_where_something_is_set_otherwise() -> None:
    plain = line(Run(SPEC, SEED))
    said = said_of(plain, line(Run(SPEC, SEED), (500, SetParameter("learner.epsilon", 0.9))))
    assert said.startswith("The same until step 500 (trial ")
    assert "; there Exploration ε = 0.9 in branch alone. Then " in said or (
        said.endswith("In branch exploration ε is 0.9 and not 0.1.")
    )
    steps = first_divergence(plain, line(Run(SPEC, SEED), (100, FreezeSelection(True))))
    assert steps is not None
    assert steps.step > 100
    assert divergence_in_words(steps, "live", "branch").endswith(
        "and learned otherwise from it. In branch the selection is frozen by hand."
    )


def test_runs_that_begin_otherwise_are_told_apart_by_what_they_begin_with() -> None:
    standard = line(Run(small("standard_q"), SEED))
    start = "Different from the start: "
    seed = said_of(standard, line(Run(small("standard_q"), 8)))
    assert seed.startswith(
        f"{start}live has seed {SEED} and branch has seed 8, so their trials start elsewhere."
        " In the first step "
    )
    timed = said_of(standard, line(Run(small("timed"), SEED)))
    assert timed.startswith(
        f"{start}live chooses among the nine moves, branch begins with approach (2 skills more"
        " later). In the first step live "
    )
    wide = said_of(standard, line(Run(small("standard_q", "world.size=40"), SEED)))
    assert wide.startswith(f"{start}their worlds are not the same. In the first step ")
    nothing = Past(Run(small("timed"), SEED), Budget())
    assert said_of(standard, nothing).endswith("(2 skills more later).")


def test_what_is_given_before_the_first_step_is_no_other_beginning() -> None:
    new = DefineSkill("sneak", SkillWeights(approach=1.0)), Introduce("sneak", 0)
    said = said_of(line(Run(SPEC, SEED)), line(Run(SPEC, SEED), (0, new[0]), (0, new[1])))
    assert said.startswith("The same until step 0 (trial 0); there sneak defined and sneak added")


def test_runs_that_are_the_same_are_said_to_be() -> None:
    assert same_in_words(412_344, 12_907) == (
        "The same as far as both are known: until step 412,344 (trial 12,907)."
    )
