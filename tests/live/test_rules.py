"""A skill that joins by a rule joins again in every moment that is made again, and in any file."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.live.codec import decoded, encoded
from app.live.held import Held
from app.live.past import Budget, Past
from app.live.records import Began, Branched, Gave, Record, Stood
from app.live.replayed import replayed
from learners.commands import Explore, FreezeSkills, Introduce
from learners.kernel.state import digest
from learners.run import Run, replay
from tests.support.lines import Script, play, scripts, stands
from tests.support.schedules import ruled_spec

SEED = 5
EAGER = ruled_spec("schedule.introduce={by: reach, window: 8, below: 0.4}")


def joins(run: Run) -> list[tuple[str, int]]:
    """Skills that joined by the rule, and when."""
    return [
        (event.command.skill, event.trial)
        for event in run.control.history
        if isinstance(event.command, Introduce) and event.author == "trigger"
    ]


@given(script=scripts, rest=st.integers(0, 2_000), shares=st.lists(st.floats(0, 1), max_size=6))
def test_a_moment_is_what_a_run_stopped_there_would_be(
    script: Script, rest: int, shares: list[float]
) -> None:
    run = Run(EAGER, SEED)
    past = Past(run, Budget(nearest_steps=25), lambda: 0.0)
    play(run, past, script, rest)
    for step in [*(round(share * run.step) for share in shares), run.step]:
        found = past.run_at(step)
        assert found is not None
        assert stands(found) == stands(replay(EAGER, SEED, run.journal, step))


def test_a_session_and_its_branch_are_made_again_from_what_was_written() -> None:
    run = Run(EAGER, SEED)
    run.advance()
    assert joins(run)
    middle = next(event.step for event in run.control.history if event.author == "trigger") + 70
    explore = Explore("approach", 30, 0.5, value_at_most=0.5)
    branch = replay(EAGER, SEED, [(middle, explore)], middle + 500)
    records: list[Record] = [
        Began(0, "mine", EAGER, SEED),
        Gave(0, 40, FreezeSkills(False)),
        Stood(0, run.step, run.trial, digest(run.state), run.trial),
        Branched(1, 0, middle, (explore,)),
        Stood(1, branch.step, branch.trial, digest(branch.state), run.trial),
    ]
    made = replayed([decoded(json.loads(json.dumps(encoded(record)))) for record in records])
    assert made.is_same
    assert [line.digest for line in made.lines.values()] == [
        digest(run.state),
        digest(branch.state),
    ]


@pytest.mark.parametrize("steps", [7, 100, 10_000])
def test_it_pauses_where_a_rule_is_about_to_add_a_skill(steps: int) -> None:
    alone = Run(EAGER, SEED)
    alone.advance()
    held = Held(Run(EAGER, SEED), 1, "mine", until_trial=EAGER.trials, playing=True)
    for skill, trial in joins(alone):
        while held.playing:
            held.go_on(steps, pauses_at_joins=True)
        assert (held.run.trial, skill in held.run.present) == (trial, False)
        held.play()
    while held.playing:
        held.go_on(steps, pauses_at_joins=True)
    assert digest(held.run.state) == digest(alone.state)
    assert joins(held.run) == joins(alone)
