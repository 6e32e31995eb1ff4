"""A rule is met where its statistic says so, whoever asks and when; by hand one may be earlier."""

from collections.abc import Callable, Iterable
from typing import Literal, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.documents import presets
from learners.checkpoints import logs_of
from learners.commands import (
    Author,
    Command,
    CommandError,
    Event,
    Explore,
    FollowSchedule,
    Introduce,
    Remove,
    SetSchedule,
    Undo,
)
from learners.control import awaited
from learners.kernel.state import TRIAL, LearnerState, digest, new_state
from learners.names import MAX_TRIALS
from learners.run import Run, replay
from learners.schedule_spec import TriggerSpec
from learners.spec import RunSpec
from learners.triggers.watch import is_met, outlook, statistic, watch_for
from sim.world import compile_world
from tests.support.schedules import commands, driven

SMALL = (
    "world.size=20",
    "world.n_directions=8",
    "world.n_distances=4",
    "world.step_limit=40",
    "trials=400",
)
RULE = "{by: reach, window: 20, below: 0.2}"
SEED = 6


Watched = Literal["novelty", "reach", "change"]


def spec(rule: str = RULE, *settings: str) -> RunSpec:
    """Three skills in a small world, two of which join by a rule."""
    schedule = (
        f"schedule.introduce={rule}",
        "schedule.skills={approach: {freeze: 10}, circle_clockwise: {freeze: 20},"
        " avoid: {freeze: 5}}",
        "schedule.episodes=[{skill: circle_clockwise, duration: 40, probability: 0.9},"
        " {skill: avoid, duration: 30, probability: 0.3, where: {value_at_most: 1}}]",
    )
    return presets.load("hierarchical_3", [*SMALL, *schedule, *settings])


class Joined(NamedTuple):
    """A skill that joined, and how."""

    skill: str
    freeze: int
    trial: int
    author: Author
    event: Event


def joined(run: Run) -> list[Joined]:
    """Introductions but the first, in order."""
    return [
        Joined(event.command.skill, event.command.freeze_trials, event.trial, event.author, event)
        for event in run.control.history
        if isinstance(event.command, Introduce)
    ][1:]


def done(run: Run) -> Run:
    run.advance()
    return run


def told(run: Run, given: Iterable[tuple[int, Command]]) -> Run:
    """The run at its end, with commands given before trials."""
    for trial, command in given:
        run.advance(until_trial=trial)
        run.apply(command)
    return done(run)


@pytest.fixture(scope="module")
def run() -> Run:
    return done(Run(spec(), SEED))


# --- When it is met ------------------------------------------------------------------------------


def test_skills_join_in_the_order_listed_as_the_triggers_and_are_explored(run: Run) -> None:
    circle, avoid = joined(run)
    assert circle[:2] == ("circle_clockwise", 20)
    assert avoid[:2] == ("avoid", 5)
    assert {circle.author, avoid.author} == {"trigger"}
    assert circle.trial >= 30
    assert circle.trial + 20 + 20 <= avoid.trial < 400
    after = run.control.history[avoid.event.number + 1]
    assert (after.command, after.author, after.cause) == (
        Explore("avoid", 30, 0.3, value_at_most=1),
        "schedule",
        avoid.event.number,
    )
    assert (after.trial, after.trial_step) == (avoid.trial, 0)


@pytest.mark.parametrize(
    "rule", [RULE, "{by: novelty, window: 30, below: 0.7}", "{by: change, window: 10, below: 2.0}"]
)
def test_a_skill_joins_before_the_first_trial_in_which_its_statistic_is_below(rule: str) -> None:
    run = done(Run(spec(rule), SEED))
    by_rule = run.spec.schedule.introduce
    assert by_rule is not None
    since = 10
    assert joined(run)
    for event in joined(run):
        found = statistic(run.state, watch_for(by_rule, since))
        low = found.trials[found.values < by_rule.below]
        assert low[0] == event.trial
        assert found.trials[0] == since + by_rule.window
        since = event.trial + event.freeze


def test_the_statistic_is_the_mean_of_the_logs() -> None:
    run = done(Run(spec("{by: novelty, below: 0}"), SEED))
    state, n = run.state, run.trial
    means: dict[Watched, Callable[[slice], float]] = {
        "novelty": lambda part: state.log_new_states[part].mean(),
        "reach": lambda part: state.log_reached[part].mean(),
        "change": lambda part: (
            state.log_change[part].astype(float).sum() / state.log_steps[part].sum()
        ),
    }
    for by, mean in means.items():
        found = statistic(state, watch_for(TriggerSpec(by=by, window=50), 7))
        expected = [mean(slice(trial - 50, trial)) for trial in range(57, n + 1)]
        assert found.trials.tolist() == list(range(57, n + 1))
        np.testing.assert_allclose(found.values, expected, rtol=1e-4)
    assert statistic(state, watch_for(TriggerSpec(by="reach", window=50), n - 49)).trials.size == 0


def test_all_states_that_were_reached_are_in_the_log(run: Run) -> None:
    reached = run.state.first_reach[run.state.first_reach >= 0]
    counts = np.bincount(reached, minlength=run.trial)
    np.testing.assert_array_equal(run.state.log_reached[: run.trial], counts)


def test_a_mean_at_the_threshold_is_not_below_it() -> None:
    # 3 of 30 is 0.1 to the last bit, though 0.1 * 30 is not 3.
    state = _state_with(np.tile([1, *[0] * 9], 6))
    state.tally[TRIAL] = 60
    assert not is_met(state, watch_for(TriggerSpec(by="novelty", window=30, below=0.1), 0))
    assert is_met(state, watch_for(TriggerSpec(by="novelty", window=30, below=0.1001), 0))


def test_changes_without_bound_do_not_overflow() -> None:
    state = _state_with(np.zeros(100, int))
    state.log_change[:] = np.finfo(np.float32).max
    state.log_steps[:] = 1
    state.tally[TRIAL] = 100
    watch = watch_for(TriggerSpec(by="change", window=100, below=1e6), 0)
    assert not is_met(state, watch)
    assert statistic(state, watch).values.tolist() == [2.0**26]


# --- What else has a say -------------------------------------------------------------------------


def test_by_hand_a_skill_joins_earlier_and_the_next_one_waits_from_there() -> None:
    early = told(Run(spec(), SEED), [(15, Introduce("circle_clockwise", 200))])
    circle, avoid = joined(early)
    assert (circle.author, circle.trial) == ("hand", 15)
    assert (avoid.author, avoid.trial >= 15 + 200 + 20) == ("trigger", True)


def test_with_the_schedule_off_it_is_not_met_and_on_again_it_is_met_at_once(run: Run) -> None:
    due = joined(run)[0].trial
    off = told(Run(spec(), SEED), [(due, FollowSchedule(False)), (due + 1, FollowSchedule(True))])
    assert joined(off)[0].trial == due + 1
    assert joined(told(Run(spec(), SEED), [(due, FollowSchedule(False))])) == []


def test_a_skill_that_was_removed_does_not_come_back_by_the_rule(run: Run) -> None:
    due = joined(run)[0].trial
    without = told(Run(spec(), SEED), [(due + 3, Remove("circle_clockwise"))])
    assert [event.skill for event in joined(without)] == ["circle_clockwise", "avoid"]
    assert without.present == ("approach", "avoid")
    assert awaited(without.control) is None


def test_undone_it_is_as_if_it_had_not_been_introduced_by_hand(run: Run) -> None:
    again = Run(spec(), SEED)
    again.advance(until_trial=15)
    again.apply(Introduce("circle_clockwise", 9))
    again.apply(Undo(len(again.control.history) - 2))
    assert again.present == ("approach",)
    waiting = awaited(again.control)
    assert waiting is not None
    assert (waiting.introduce, waiting.since) == (Introduce("circle_clockwise", 20), 10)
    assert [event.author for event in joined(done(again))] == ["hand", "trigger", "trigger"]


def test_what_a_rule_did_cannot_be_undone(run: Run) -> None:
    twin = run.copy()
    with pytest.raises(CommandError, match="nothing was done by hand under the number"):
        twin.apply(Undo(joined(run)[0].event.number))


def test_a_skill_may_have_a_rule_of_its_own_and_another_a_trial() -> None:
    own = spec(
        "null",
        "schedule.skills.approach.at=0",
        "schedule.skills.circle_clockwise={introduce: {by: novelty, window: 30, below: 0.7}}",
        "schedule.skills.avoid={at: 20}",
    )
    run = done(Run(own, SEED))
    avoid, circle = joined(run)
    assert (avoid.trial, avoid.author) == (20, "schedule")
    assert (circle.skill, circle.freeze, circle.author) == ("circle_clockwise", 20, "trigger")
    assert circle.trial >= 50


def test_another_rule_takes_its_place_while_the_run_goes_on() -> None:
    never = Run(spec("{by: reach, window: 20, below: 0}"), SEED)
    never.advance(until_trial=200)
    rule = TriggerSpec(by="novelty", window=5, below=1000)
    schedule = never.spec.schedule.model_copy(update={"introduce": rule})
    never.apply(SetSchedule(schedule))
    assert [event.trial for event in joined(done(never))] == [200, 225]


# --- It is a function of the rest ----------------------------------------------------------------


def test_a_rule_is_not_in_the_journal_and_replays_exactly() -> None:
    given = [(15, FollowSchedule(False)), (18, FollowSchedule(True)), (90, Remove("approach"))]
    run = told(Run(spec(), SEED), given)
    assert len(joined(run)) == 2
    assert [command for _, command in run.journal] == [command for _, command in given]
    twin = replay(spec(), SEED, run.journal, run.step)
    assert digest(twin.state) == digest(run.state)
    assert twin.control == run.control


scripts = st.lists(st.tuples(st.integers(0, 1_500), commands), max_size=12)


@given(script=scripts, cut=st.integers(1, 2_000), later=st.integers(0, 4_000))
def test_any_moment_goes_on_as_it_did(
    script: list[tuple[int, Command]], cut: int, later: int
) -> None:
    run = driven(Run(spec(), SEED), script)
    checkpoint = run.checkpoint()
    run.advance(max_steps=later)
    restored = Run.restored(checkpoint, logs_of(run.state))
    while restored.step < run.step:
        restored.advance(max_steps=min(cut, run.step - restored.step))
    twin = replay(spec(), SEED, run.journal, run.step)
    for other in (restored, twin):
        assert digest(other.state) == digest(run.state)
        assert other.control.introductions == run.control.introductions
        for name, log in logs_of(other.state)._asdict().items():
            np.testing.assert_array_equal(log[: run.trial], getattr(run.state, name)[: run.trial])


def test_a_run_can_stand_still_before_a_rule_is_met(run: Run) -> None:
    stopping = Run(spec(), SEED)
    for event in joined(run):
        stopping.advance(stops_at_rules=True)
        assert (stopping.trial, stopping.step) == (event.trial, event.event.step)
        assert stopping.joins_by_rule == event.skill
        assert event.skill not in stopping.present
    stopping.advance(stops_at_rules=True)
    assert stopping.trial == run.trial
    assert digest(stopping.state) == digest(run.state)


# --- When it will be met -------------------------------------------------------------------------


def _state_with(new_states: np.ndarray) -> LearnerState:
    """A state whose trials had so many visits of new states."""
    small = spec("{by: novelty}", f"trials={new_states.size}")
    state = new_state(small, compile_world(small.world), 1)
    state.log_new_states[:] = new_states
    state.log_steps[:] = 1
    return state


def _outlook(new_states: np.ndarray, window: int, below: float, since: int = 0) -> int | None:
    state = _state_with(new_states)
    state.tally[TRIAL] = new_states.size
    return outlook(state, watch_for(TriggerSpec(by="novelty", window=window, below=below), since))


def test_it_is_told_when_a_rule_will_be_met_at_this_rate() -> None:
    # The means of windows of 10 trials fall by 10 with each window, and are 60 before trial 100.
    falling = np.repeat(np.arange(150, 50, -10), 10)
    assert _outlook(falling, 10, 60.5) == 100
    assert _outlook(falling, 10, 50) == 111
    assert _outlook(falling, 10, 5) == 156
    # The latest windows count.
    assert _outlook(np.concatenate([np.full(500, 3), falling]), 10, 50) == 611


def test_it_is_not_told_if_nobody_can_know() -> None:
    falling = np.repeat(np.arange(150, 50, -10), 10)
    assert _outlook(falling[:9], 10, 5) is None
    assert _outlook(falling[:19], 10, 5) is None
    assert _outlook(falling, 10, 5, since=85) is None
    assert _outlook(np.full(100, 7), 10, 5) is None
    assert _outlook(falling[::-1].copy(), 10, 5) is None
    assert _outlook(np.repeat([1_000_001, 1_000_000], 200), 200, 0.5) is None
    assert MAX_TRIALS < 200 * 1_000_000
