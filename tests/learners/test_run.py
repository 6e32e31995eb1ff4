"""A run depends on its preset, its seed and its commands, and on nothing else."""

import hashlib
import math
import os
import subprocess
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from app.documents import presets
from learners import measures
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
from learners.control import Control
from learners.kernel import loop, rows
from learners.kernel.layout import regions_of
from learners.kernel.state import (
    CELL,
    NOT_REACHED,
    REPERTOIRE,
    TRAIL_LENGTH,
    TRIAL_NEW_STATES,
    TRIAL_STEP,
    LearnerState,
    copy_state,
    join_option,
    new_state,
    tables,
)
from learners.names import MAX_TRIALS
from learners.run import Run, replay
from learners.schedule_spec import ScheduleSpec, SkillTimer
from learners.skill_spec import SkillWeights
from learners.skills import LocalReward
from learners.spec import RunSpec
from sim.world import CAPTURE, TIMEOUT, compile_world

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = tuple(presets.shipped())
SMALL_WORLD = (
    "world.size=30",
    "world.n_directions=16",
    "world.n_distances=6",
    "world.step_limit=60",
)
# The standard schedule, three hundred times as fast.
QUICK_SCHEDULE = (
    "schedule.skills.approach.freeze=2",
    "schedule.skills.circle_clockwise.at=40",
    "schedule.skills.circle_clockwise.freeze=5",
    "schedule.skills.avoid.at=60",
    "schedule.skills.avoid.freeze=5",
    "schedule.episodes=[{skill: circle_clockwise, duration: 30, probability: 0.95},"
    " {skill: avoid, duration: 15, probability: 0.3}]",
)
BY_HAND = "schedule.skills.circle_clockwise.at=1000000", "schedule.skills.avoid.at=1000000"
"""Skills that join when they are told to."""
UNSAFE = "schedule.safe_introduction=false"

COMMANDS: Sequence[tuple[int, Command]] = (
    (700, Introduce("circle_clockwise", 20)),
    (1_301, Explore("approach", 10, 0.5)),
    (2_000, FreezeSkills(True)),
    (2_000, Explore("circle_clockwise", 100_000, 0.2)),
    (4_444, FollowSchedule(False)),
    (6_001, FreezeSkills(False)),
    (9_999, Introduce("avoid", 0)),
    (10_000, StopExploring("circle_clockwise")),
    (15_000, FreezeSelection(True)),
    (20_000, FreezeSelection(False)),
    (30_000, Explore("avoid", 100, 0.9)),
)
"""Commands by hand and the steps before which they are given."""

LATER = SkillTimer(at=1_000_000)
STEERING: Sequence[tuple[int, Command]] = (
    (500, DefineSkill("sneak", SkillWeights(approach=0.5, circle_clockwise=1.0))),
    (801, Introduce("sneak", 5)),
    (1_500, SetParameter("learner.epsilon", 0.3)),
    (2_000, Introduce("circle_clockwise", 10)),
    (2_503, SetParameter("world.vision_radius", 15.0)),
    (3_000, StopExploring("circle_clockwise")),
    (4_000, Remove("approach")),
    (5_000, Undo(3)),
    (6_000, Introduce("approach", 0)),
    (7_777, Remove("sneak")),
    (9_000, Undo(11)),
    (10_500, SetParameter("learner.alpha", 0.4)),
    (12_000, SetParameter("learner.alpha", 0.05)),
    (20_000, Undo(14)),
)
"""Commands that change the preset on the way; ``Undo`` counts from the run's first event, and the
exploration that comes with circling is one."""

SCRIPTS = {"commands": COMMANDS, "steering": STEERING}


def small(preset: str, *settings: str) -> RunSpec:
    return presets.load(preset, [*SMALL_WORLD, *settings])


def quick_timed(*settings: str) -> RunSpec:
    return small("timed", *QUICK_SCHEDULE, *settings)


def advance_to(run: Run, step: int) -> None:
    run.advance(max_steps=step - run.step, until_trial=MAX_TRIALS)


def drive(run: Run, cuts: Iterable[int], commands: Sequence[tuple[int, Command]] = ()) -> Run:
    """Advance from cut to cut, giving commands at their steps."""
    waiting = list(commands)
    for cut in cuts:
        while waiting and waiting[0][0] <= cut:
            step, command = waiting.pop(0)
            advance_to(run, step)
            run.apply(command)
        advance_to(run, cut)
    return run


def everything(run: Run) -> dict[str, bytes]:
    """All that a run knows, by name; of the logs, what has been written."""
    known = {
        name: (array[: run.trial] if name.startswith("log_") else array).tobytes()
        for name, array in run.state._asdict().items()
    }
    return known | {"control": repr(run.control).encode(), "journal": repr(run.journal).encode()}


def assert_same(run: Run, other: Run) -> None:
    known, expected = everything(run), everything(other)
    assert [name for name in known if known[name] != expected[name]] == []


def option_counts(run: Run) -> np.ndarray:
    """How often each option was taken."""
    return tables(run.spec, run.state)["visits"].sum(axis=(0, 1, 2), dtype=np.int64)


# --- The division into calls ---------------------------------------------------------------------

STEPS = 100_000


def random_cuts(seed: int) -> list[int]:
    cuts = np.random.default_rng(seed).integers(0, STEPS, 200)
    return [*sorted(cuts.tolist()), STEPS]


@pytest.mark.parametrize("preset", SHIPPED)
def test_the_division_into_calls_makes_no_difference(preset: str) -> None:
    spec = presets.load(preset)
    whole = drive(Run(spec, 3), [STEPS])
    assert whole.step == STEPS
    assert_same(drive(Run(spec, 3), range(100, STEPS + 1, 100)), whole)
    assert_same(drive(Run(spec, 3), random_cuts(1)), whole)


@pytest.mark.parametrize("script", SCRIPTS)
@pytest.mark.parametrize("cuts", [range(100, STEPS + 1, 100), random_cuts(2), random_cuts(3)])
def test_the_division_into_calls_makes_no_difference_to_commands(
    cuts: Sequence[int], script: str
) -> None:
    spec = presets.load("timed", BY_HAND)
    whole = drive(Run(spec, 3), [STEPS], SCRIPTS[script])
    assert len(whole.journal) == len(SCRIPTS[script])
    assert_same(drive(Run(spec, 3), cuts, SCRIPTS[script]), whole)


def test_the_division_into_calls_makes_no_difference_to_the_schedule() -> None:
    whole = drive(Run(quick_timed(), 3), [20_000])
    assert whole.trial > 100, "all of the schedule is to be past"
    assert_same(drive(Run(quick_timed(), 3), range(1, 20_001)), whole)


def test_advancing_stops_where_it_is_told_to() -> None:
    run = Run(quick_timed("trials=70"), 1)
    assert run.advance(max_steps=0) == 0
    assert run.advance(max_steps=123) == 123 == run.step
    made = run.advance(until_trial=50)
    assert (run.step, run.trial) == (123 + made, 50)
    run.advance()
    assert run.trial == 70
    assert run.advance() == 0
    run.advance(until_trial=100)
    assert run.trial == 100


def test_seeds_differ() -> None:
    runs = [drive(Run(quick_timed(), seed), [5_000]) for seed in (0, 1, 2**63 - 1)]
    assert len({everything(run)["selection"] for run in runs}) == len(runs)


@pytest.mark.parametrize("seed", [-1, 2**63])
def test_a_seed_out_of_range_is_refused(seed: int) -> None:
    with pytest.raises(ValueError, match=rf"seed: {seed} is not allowed; allowed: 0 to "):
        Run(quick_timed(), seed)


# --- Checkpoints and journals --------------------------------------------------------------------


@given(step=st.integers(0, 12_000))
@settings(max_examples=20)
def test_a_copy_resumes_bit_for_bit(step: int) -> None:
    run = drive(Run(quick_timed(), 5), [step])
    checkpoint = run.copy()
    before = everything(checkpoint)
    drive(run, [15_000])
    assert everything(checkpoint) == before, "a checkpoint is to be independent"
    assert_same(drive(checkpoint, [15_000]), run)


def test_a_copy_has_a_journal_of_its_own() -> None:
    run = Run(small("timed", *BY_HAND), 5)
    checkpoint = run.copy()
    run.apply(Introduce("avoid", 0))
    assert checkpoint.journal == []
    assert checkpoint.present == ("approach",)


@pytest.mark.parametrize("safety", [(), (UNSAFE,)], ids=["safe", "unsafe"])
@pytest.mark.parametrize("script", SCRIPTS)
def test_a_journal_replays_bit_for_bit(script: str, safety: Sequence[str]) -> None:
    spec = small("timed", *BY_HAND, *safety)
    run = drive(Run(spec, 8), [40_000], SCRIPTS[script])
    assert_same(replay(spec, 8, run.journal, 40_000), run)


def test_a_journal_replays_beside_a_schedule() -> None:
    commands = [
        (max(step, 5_000), command)
        for step, command in COMMANDS
        if not isinstance(command, Introduce)
    ]
    run = drive(Run(quick_timed(), 8), [40_000], commands)
    assert len(run.journal) == len(commands)
    assert_same(replay(quick_timed(), 8, run.journal, 40_000), run)


@given(step=st.integers(0, 25_000))
@settings(max_examples=20)
def test_a_copy_can_be_steered_on_bit_for_bit(step: int) -> None:
    spec = small("timed", *BY_HAND)
    whole = drive(Run(spec, 8), [30_000], STEERING)
    past = [(at, command) for at, command in STEERING if at <= step]
    checkpoint = drive(Run(spec, 8), [step], past).copy()
    assert_same(drive(checkpoint, [30_000], STEERING[len(past) :]), whole)


def test_a_replay_stops_before_later_commands() -> None:
    spec = small("timed", *BY_HAND)
    run = drive(Run(spec, 8), [40_000], COMMANDS)
    moment = drive(Run(spec, 8), [9_998], COMMANDS)
    assert_same(replay(spec, 8, run.journal, 9_998), moment)


# --- Skill timers --------------------------------------------------------------------------------


def greedy_sets(state: LearnerState) -> np.ndarray:
    """What the selection table keeps as each row's set of greedy options, as bits."""
    return state.selection_words.reshape(-1, rows.WORDS)[:, rows.GREEDY]


def assert_rows_are_up_to_date(state: LearnerState) -> None:
    """What the selection table keeps of each row is what a look at all of its values finds."""
    values = rows.values(state.selection)
    best = values.max(axis=1)
    is_greedy = values == best[:, None]
    members = (is_greedy << np.arange(rows.MAX_ACTIONS)).sum(axis=1)
    np.testing.assert_array_equal(rows.best(state.selection), best)
    np.testing.assert_array_equal(greedy_sets(state), members)
    others = np.max(values, axis=1, where=~is_greedy, initial=rows.NO_VALUE)
    assert (state.selection.reshape(-1, rows.WORDS)[:, rows.SECOND] >= others).all()


def assert_same_selection(run: Run, expected: Run) -> None:
    """Values and utilities are those of another run, though a bound may be nearer."""
    ours, theirs = run.state.selection, expected.state.selection
    np.testing.assert_array_equal(rows.values(ours), rows.values(theirs))
    assert_rows_are_up_to_date(run.state)


KNOWN = {0: (-5.0, -2.0), 1: (-5.0, 0.0), 2: (3.0, 7.0), 3: (0.0, 0.0)}
"""Values of the first two options, by state; those of all other states are the initial ones."""


@pytest.mark.parametrize(
    ("safely", "initial_q", "joined", "best", "greedy"),
    [
        (True, 0.0, [-2, 0, 0, 0], [-2, 0, 7, 0], [0b110, 0b110, 0b010, 0b111]),
        (False, 0.0, [0, 0, 0, 0], [0, 0, 7, 0], [0b100, 0b110, 0b010, 0b111]),
        (True, 5.0, [-2, 0, 5, 0], [-2, 0, 7, 0], [0b110, 0b110, 0b010, 0b111]),
        (False, 5.0, [5, 5, 5, 5], [5, 5, 7, 5], [0b100, 0b100, 0b010, 0b100]),
    ],
)
def test_the_first_values_of_an_option_and_the_maxima_that_follow(
    safely: bool, initial_q: float, joined: list[float], best: list[float], greedy: list[int]
) -> None:
    spec = small("timed", f"learner.initial_q={initial_q}")
    state = new_state(spec, compile_world(spec.world), 1)
    for option in (0, 1):
        join_option(state, option, initial_q, safely=safely)
    assert (rows.values(state.selection)[:, :2] == initial_q).all(), "there was nothing to go by"
    for row, known in KNOWN.items():
        rows.values(state.selection)[row, :2] = known
    rows.rescan_all(state.selection, state.selection_words)

    join_option(state, 2, initial_q, safely=safely)

    column = rows.values(state.selection)[:, 2]
    assert column[: len(KNOWN)].tolist() == joined
    assert (column[len(KNOWN) :] == initial_q).all()
    assert rows.best(state.selection)[: len(KNOWN)].tolist() == best
    assert greedy_sets(state)[: len(KNOWN)].tolist() == greedy
    assert_rows_are_up_to_date(state)


@given(step=st.integers(0, 30_000), initial_q=st.sampled_from([0.0, -3.5, 40.0]))
@settings(max_examples=40)
def test_a_skill_that_joins_changes_no_utility(step: int, initial_q: float) -> None:
    run = Run(small("timed", *BY_HAND, f"learner.initial_q={initial_q}"), 6)
    advance_to(run, step)
    before = rows.best(run.state.selection).copy()
    old = tables(run.spec, run.state)["selection_q"]
    run.apply(Introduce("circle_clockwise", 10))
    new = tables(run.spec, run.state)["selection_q"]

    assert_rows_are_up_to_date(run.state)
    np.testing.assert_array_equal(rows.best(run.state.selection), before)
    np.testing.assert_array_equal(new[..., 0], old[..., 0])
    joined = new[..., run.spec.learner.skills.index("circle_clockwise")]
    np.testing.assert_array_equal(joined, np.minimum(np.float32(initial_q), old[..., 0]))
    absent = run.spec.learner.skills.index("avoid")
    assert np.isnan(new[..., absent]).all()


@given(step=st.integers(0, 30_000), initial_q=st.sampled_from([0.0, -3.5, 40.0]))
@settings(max_examples=40)
def test_without_safe_introduction_utility_rises_to_the_initial_value(
    step: int, initial_q: float
) -> None:
    run = Run(small("timed", *BY_HAND, UNSAFE, f"learner.initial_q={initial_q}"), 6)
    safe = Run(small("timed", *BY_HAND, f"learner.initial_q={initial_q}"), 6)
    for each in (run, safe):
        advance_to(each, step)
    np.testing.assert_array_equal(run.state.selection, safe.state.selection)
    before = rows.best(run.state.selection).copy()
    run.apply(Introduce("circle_clockwise", 10))

    joined = tables(run.spec, run.state)["selection_q"][..., 1]
    assert (joined == np.float32(initial_q)).all()
    expected = np.maximum(before, np.float32(initial_q))
    np.testing.assert_array_equal(rows.best(run.state.selection), expected)
    assert_rows_are_up_to_date(run.state)


def test_an_introduction_that_is_not_safe_is_taken_back_and_repeated() -> None:
    run = drive(Run(small("timed", *BY_HAND, UNSAFE), 6), [20_000])
    before = run.copy()
    introduction = len(run.control.history)
    run.apply(Introduce("avoid", 0))
    assert (rows.best(run.state.selection) > rows.best(before.state.selection)).sum() > 20
    run.apply(Undo(introduction))
    assert_same_selection(run, before)

    run.apply(Introduce("avoid", 0))
    advance_to(run, 30_000)
    learned = run.copy()
    removal = len(run.control.history)
    run.apply(Remove("avoid"))
    returned = run.copy()
    returned.apply(Undo(removal))
    assert_same_selection(returned, learned)
    run.apply(Introduce("avoid", 0))
    assert not tables(run.spec, run.state)["selection_q"][..., 2].any()
    assert_rows_are_up_to_date(run.state)


def test_another_plan_says_whether_the_introductions_ahead_are_safe() -> None:
    run = drive(Run(small("timed", *BY_HAND), 6), [20_000])
    before = rows.best(run.state.selection).copy()
    plan = run.spec.schedule
    change = len(run.control.history)
    run.apply(SetSchedule(plan.model_copy(update={"safe_introduction": False})))
    np.testing.assert_array_equal(rows.best(run.state.selection), before)
    unsafe, safe = run.copy(), run.copy()
    unsafe.apply(Introduce("avoid", 0))
    assert (rows.best(unsafe.state.selection) > before).any()
    safe.apply(Undo(change))
    safe.apply(Introduce("avoid", 0))
    assert safe.spec.schedule == plan
    np.testing.assert_array_equal(rows.best(safe.state.selection), before)


def test_a_skill_that_the_preset_does_not_have_joins_as_the_schedule_says() -> None:
    run = drive(Run(small("timed", *BY_HAND, UNSAFE), 6), [20_000])
    before = rows.best(run.state.selection).copy()
    run.apply(Introduce("circle_counterclockwise", 0))
    assert not run.spec.schedule.safe_introduction
    np.testing.assert_array_equal(rows.best(run.state.selection), np.maximum(before, 0))


def test_the_selection_rests_while_it_is_frozen_and_the_skills_learn_on() -> None:
    run = Run(small("timed", *BY_HAND, "schedule.skills.approach.freeze=0"), 7)
    run.advance(until_trial=50)
    run.apply(Introduce("circle_clockwise", 20))
    assert run.selection_is_frozen
    before = copy_state(run.state)
    run.advance(until_trial=70)
    assert not run.selection_is_frozen
    np.testing.assert_array_equal(run.state.selection, before.selection)
    assert (run.state.skills != before.skills).any()
    assert not run.state.log_change[50:70].any()
    run.advance(until_trial=80)
    assert (run.state.selection != before.selection).any()


def test_a_freeze_given_within_a_trial_counts_that_trial() -> None:
    run = Run(small("timed", *BY_HAND, "schedule.skills.approach.freeze=0"), 7)
    run.advance(until_trial=50)
    run.advance(max_steps=1)
    run.apply(Introduce("circle_clockwise", 1))
    assert (run.trial, run.selection_is_frozen) == (50, True)
    run.advance(until_trial=51)
    assert not run.selection_is_frozen


def test_the_skills_rest_while_they_are_frozen_and_the_selection_learns_on() -> None:
    run = Run(small("hierarchical_3"), 7)
    run.advance(until_trial=50)
    run.apply(FreezeSkills(True))
    before = copy_state(run.state)
    run.advance(until_trial=80)
    np.testing.assert_array_equal(run.state.skills, before.skills)
    assert (run.state.selection != before.selection).any()
    run.apply(FreezeSkills(False))
    run.advance(until_trial=90)
    assert (run.state.skills != before.skills).any()


def test_both_rest_while_both_are_frozen() -> None:
    run = Run(small("hierarchical_3"), 7)
    run.advance(until_trial=50)
    run.apply(FreezeSelection(True))
    run.apply(FreezeSkills(True))
    before = copy_state(run.state)
    run.advance(until_trial=80)
    np.testing.assert_array_equal(run.state.selection, before.selection)
    np.testing.assert_array_equal(run.state.skills, before.skills)
    np.testing.assert_array_equal(run.state.first_reach, before.first_reach)
    assert run.state.visits.sum() > before.visits.sum()


def test_timers_and_commands_given_at_the_same_moments_do_the_same() -> None:
    scheduled = Run(quick_timed(), 9)
    scheduled.advance(until_trial=200)

    by_hand = Run(small("timed", *BY_HAND, "schedule.skills.approach.freeze=2"), 9)
    by_hand.apply(FollowSchedule(False))
    by_hand.advance(until_trial=40)
    by_hand.apply(Introduce("circle_clockwise", 5))
    by_hand.apply(Explore("circle_clockwise", 30, 0.95))
    by_hand.advance(until_trial=60)
    by_hand.apply(Introduce("avoid", 5))
    by_hand.apply(Explore("avoid", 15, 0.3))
    by_hand.advance(until_trial=200)

    assert scheduled.control.introductions == by_hand.control.introductions
    ignored = {"control", "journal"}
    ours, theirs = everything(by_hand), everything(scheduled)
    assert [name for name in ours if name not in ignored and ours[name] != theirs[name]] == []


def test_another_plan_is_as_good_as_having_had_it_from_the_start() -> None:
    planned = Run(quick_timed("schedule.skills.avoid.at=80"), 9)
    planned.advance(until_trial=200)

    changed = Run(quick_timed(), 9)
    changed.advance(until_trial=50)
    changed.apply(SetSchedule(planned.spec.schedule))
    changed.advance(until_trial=200)

    assert changed.control.introductions == planned.control.introductions
    assert [entry.trial for entry in changed.control.introductions] == [0, 40, 80]
    ignored = {"control", "journal"}
    ours, theirs = everything(changed), everything(planned)
    assert [name for name in ours if name not in ignored and ours[name] != theirs[name]] == []


def test_an_episode_at_introduction_comes_with_a_skill_that_is_introduced_by_hand() -> None:
    run = Run(quick_timed(), 9)
    run.advance(until_trial=10)
    run.apply(Introduce("circle_clockwise", 0))
    (episode,) = run.control.episodes
    assert (episode.skill, episode.until_trial) == ("circle_clockwise", 40)
    run.advance(until_trial=50)
    assert [i.skill for i in run.control.introductions] == ["approach", "circle_clockwise"]


def test_a_timer_that_was_due_while_the_schedule_was_off_stays_undone() -> None:
    run = Run(quick_timed(), 9)
    run.apply(FollowSchedule(False))
    run.advance(until_trial=50)
    run.apply(FollowSchedule(True))
    run.advance(until_trial=100)
    assert run.present == ("approach", "avoid")


# --- Undoing what was set ------------------------------------------------------------------------


@pytest.mark.parametrize("undone", [(2, 1), (1, 2)], ids=["last first", "first first"])
@pytest.mark.parametrize(
    ("there", "back"),
    [
        (FreezeSelection(True), FreezeSelection(False)),
        (FreezeSkills(True), FreezeSkills(False)),
        (FollowSchedule(False), FollowSchedule(True)),
    ],
)
def test_a_setting_is_as_at_first_once_all_its_changes_are_undone(
    there: Command, back: Command, undone: tuple[int, int]
) -> None:
    run = Run(small("timed", *BY_HAND), 9)
    before = run.control
    run.apply(there)
    run.apply(back)
    for number in undone:
        run.apply(Undo(number))
    assert replace(run.control, history=before.history) == before


def plan_with(plan: ScheduleSpec, **ats: int) -> ScheduleSpec:
    """A plan with timers of some skills at other trials."""
    timers = {skill: SkillTimer(at=at, freeze=5) for skill, at in ats.items()}
    return plan.model_copy(update={"skills": {**plan.skills, **timers}})


def test_undoing_a_plan_leaves_the_plan_that_came_after_it() -> None:
    run = Run(quick_timed(), 9)
    first = plan_with(run.spec.schedule, avoid=80)
    second = plan_with(first, circle_clockwise=50)
    run.apply(SetSchedule(first))
    run.apply(SetSchedule(second))
    run.apply(Undo(1))
    assert run.spec.schedule == second
    run.apply(Undo(2))
    assert run.spec.schedule == run.preset.schedule
    run.advance(until_trial=70)
    assert [entry.trial for entry in run.control.introductions] == [0, 40, 60]


def test_a_plan_can_be_undone_after_a_skill_that_it_does_not_know_has_joined() -> None:
    run = Run(quick_timed(), 9)
    run.advance(until_trial=20)
    run.apply(SetSchedule(plan_with(run.spec.schedule, avoid=80)))
    run.apply(Introduce("circle_counterclockwise", 0))
    run.advance(until_trial=30)
    run.apply(Undo(1))
    timers = run.spec.schedule.skills
    assert timers.pop("circle_counterclockwise").at == MAX_TRIALS
    assert timers == run.preset.schedule.skills
    run.advance(until_trial=70)
    assert [entry.trial for entry in run.control.introductions] == [0, 20, 40, 60]


def test_a_plan_cannot_be_undone_once_the_one_before_it_has_missed_its_time() -> None:
    run = Run(quick_timed(), 9)
    run.apply(SetSchedule(plan_with(run.spec.schedule, circle_clockwise=50)))
    run.advance(until_trial=45)
    before = everything(run)
    with pytest.raises(CommandError, match="is past and cannot change"):
        run.apply(Undo(1))
    assert everything(run) == before


JOINING = "circle_counterclockwise"
"""A skill that the preset does not have."""


ats = st.sampled_from([5, 20, 30, 40])
plans = st.builds(plan_with, st.just(quick_timed().schedule), circle_clockwise=ats, avoid=ats)
later_plans = st.builds(plan_with, plans, **{JOINING: ats})
"""Plans that know of the skill that the preset does not have."""
changes = st.one_of(
    st.builds(FreezeSelection, st.booleans()),
    st.builds(FreezeSkills, st.booleans()),
    st.builds(Teach, st.just("flank"), st.integers(0, 60)),
    st.just(StopTeaching()),
    st.builds(FollowSchedule, st.booleans()),
    st.builds(SetParameter, st.just("learner.alpha"), st.sampled_from([0.2, 0.4])),
    st.builds(SetSchedule, plans),
    st.builds(SetSchedule, later_plans),
    st.just(Introduce(JOINING, 0)),
)


def is_carried_out(run: Run, command: Command) -> bool:
    try:
        run.apply(command)
    except CommandError:
        return False
    return True


def settings_of(run: Run) -> Control:
    """What commands have set, without what has happened meanwhile."""
    return replace(run.control, introductions=(), episodes=(), frozen_until=0, history=())


@given(
    script=st.lists(st.tuples(st.integers(0, 2), changes), min_size=2, max_size=12),
    numbers=st.lists(st.integers(1, 13), unique=True),
    wait=st.sampled_from([0, 3]),
)
@settings(max_examples=150)
def test_what_is_undone_is_as_if_it_had_not_been_given(
    script: list[tuple[int, Command]], numbers: list[int], wait: int
) -> None:
    run = Run(quick_timed(), 9)
    given_at: dict[int, tuple[int, Command]] = {}
    for trials, command in script:
        run.advance(until_trial=run.trial + trials)
        number = len(run.control.history)
        if is_carried_out(run, command):
            given_at[number] = run.trial, command
    run.advance(until_trial=run.trial + wait)
    can_be_undone = {n for n, (_, given) in given_at.items() if not isinstance(given, Introduce)}
    undone = [n for n in numbers if n in can_be_undone and is_carried_out(run, Undo(n))]

    other = Run(quick_timed(), 9)
    for number, (trial, command) in given_at.items():
        other.advance(until_trial=trial)
        if number not in undone:
            assume(is_carried_out(other, command))
    other.advance(until_trial=run.trial)
    assert settings_of(run) == settings_of(other)
    assert run.planned() == other.planned()


# --- Undoing what was done to the repertoire -----------------------------------------------------


def three_skills(*settings: str) -> Run:
    """A run in which three skills learn from the first trial on."""
    run = Run(small("hierarchical_3", *settings), 9)
    run.advance(until_trial=20)
    return run


def by_hand(run: Run, command: Command) -> int:
    """Give a command; returns its number."""
    number = len(run.control.history)
    run.apply(command)
    return number


def assert_refused(run: Run, command: Command, message: str) -> None:
    before = everything(run)
    with pytest.raises(CommandError) as refusal:
        run.apply(command)
    assert str(refusal.value) == message
    assert everything(run) == before


def test_undoing_an_exploration_that_is_over_leaves_the_one_that_came_after_it() -> None:
    run = Run(quick_timed(), 9)
    run.advance(until_trial=41)
    short = by_hand(run, Explore("approach", 5, 0.5))
    run.advance(until_trial=50)
    run.apply(Explore("approach", 30, 0.7))
    assert_refused(run, Undo(short), "that exploration of approach is over")


def test_an_exploration_that_another_replaced_cannot_be_undone_before_that_one() -> None:
    run = three_skills()
    first = by_hand(run, Explore("avoid", 50, 0.5))
    second = by_hand(run, Explore("avoid", 30, 0.7))
    assert_refused(run, Undo(first), "that exploration of avoid is over")
    run.apply(Undo(second))
    run.apply(Undo(first))
    assert run.control.episodes == ()


def test_undoing_an_exploration_lets_the_one_that_it_replaced_go_on() -> None:
    run = three_skills()
    run.apply(Explore("avoid", 50, 0.5))
    run.apply(Explore("approach", 50, 0.4))
    before = run.control.episodes
    replacing = by_hand(run, Explore("avoid", 30, 0.7))
    run.advance(until_trial=30)
    run.apply(Undo(replacing))
    assert run.control.episodes == before, "in their order: the newest is asked first"


def test_undoing_an_exploration_does_not_bring_back_one_that_would_be_over() -> None:
    run = three_skills()
    run.apply(Explore("avoid", 5, 0.5))
    replacing = by_hand(run, Explore("avoid", 30, 0.7))
    run.advance(until_trial=25)
    run.apply(Undo(replacing))
    assert run.control.episodes == ()


def test_an_exploration_that_was_stopped_goes_on_in_its_place() -> None:
    run = three_skills()
    run.apply(Explore("avoid", 50, 0.5))
    run.apply(Explore("approach", 50, 0.4))
    before = run.control.episodes
    stop = by_hand(run, StopExploring("avoid"))
    run.apply(Undo(stop))
    assert run.control.episodes == before


@pytest.mark.parametrize(
    "since",
    [[Explore("avoid", 30, 0.7)], [Remove("avoid"), Introduce("avoid", 0)]],
    ids=["explored again", "removed and introduced"],
)
def test_a_stop_cannot_be_undone_once_the_exploration_would_have_ended(
    since: list[Command],
) -> None:
    run = three_skills()
    run.apply(Explore("avoid", 50, 0.5))
    stop = by_hand(run, StopExploring("avoid"))
    for command in since:
        run.apply(command)
    assert_refused(run, Undo(stop), "that exploration would be over by now")


def test_the_freeze_of_an_introduction_ends_with_its_undoing() -> None:
    run = three_skills()
    introduction = by_hand(run, Introduce("circle_counterclockwise", 300))
    run.advance(until_trial=30)
    assert run.selection_is_frozen
    run.apply(Undo(introduction))
    assert not run.selection_is_frozen
    assert "circle_counterclockwise" not in run.present
    before = copy_state(run.state)
    run.advance(until_trial=40)
    assert (run.state.selection != before.selection).any()


def test_the_freezes_of_other_introductions_outlast_an_undoing() -> None:
    run = Run(small("timed", *BY_HAND), 9)
    run.advance(until_trial=20)
    run.apply(Introduce("circle_clockwise", 400))
    long = by_hand(run, Introduce("avoid", 900))
    until = [entry.trial for entry in run.control.introductions][1] + 400
    run.apply(Undo(long))
    assert run.control.frozen_until == until
    run.apply(Remove("circle_clockwise"))
    assert run.control.frozen_until == until, "a freeze goes on when its skill leaves"


def test_undoing_an_introduction_leaves_a_later_one_of_the_same_skill() -> None:
    run = three_skills()
    first = by_hand(run, Introduce("circle_counterclockwise", 0))
    removal = by_hand(run, Remove("circle_counterclockwise"))
    gone = "circle_counterclockwise has been removed since"
    assert_refused(run, Undo(first), gone)
    second = by_hand(run, Introduce("circle_counterclockwise", 0))
    assert_refused(run, Undo(first), gone)
    assert_refused(run, Undo(removal), "circle_counterclockwise has joined again since")
    for number in (second, removal, first):
        run.apply(Undo(number))
    assert run.present == run.preset.learner.skills


def test_a_removal_cannot_be_undone_in_the_place_of_a_later_one() -> None:
    run = three_skills()
    removal = by_hand(run, Remove("avoid"))
    run.apply(Introduce("avoid", 0))
    run.apply(Remove("avoid"))
    assert_refused(run, Undo(removal), "avoid has joined again since")


@pytest.mark.parametrize(("back_at", "goes_on"), [(39, True), (40, False)])
def test_a_skill_that_returns_is_explored_as_before_unless_that_would_be_over(
    back_at: int, goes_on: bool
) -> None:
    run = three_skills()
    run.apply(Explore("avoid", 20, 0.5))
    run.apply(Explore("approach", 100, 0.4))
    before = run.control
    removal = by_hand(run, Remove("avoid"))
    run.advance(until_trial=back_at)
    run.apply(Undo(removal))
    assert run.control.introductions == before.introductions, "the newest is last"
    assert run.control.episodes == (before.episodes if goes_on else before.episodes[:1])


THREE_SKILLS = ("approach", "circle_clockwise", "avoid")
repertoire_changes = st.one_of(
    st.builds(Introduce, st.sampled_from(THREE_SKILLS[1:]), st.sampled_from([0, 3, 40])),
    st.builds(Explore, st.sampled_from(THREE_SKILLS), st.sampled_from([2, 5, 60]), st.just(0.5)),
    st.builds(StopExploring, st.sampled_from(THREE_SKILLS)),
    # The first skill stays: a removal that another skill made possible would outlast its undoing.
    st.builds(Remove, st.sampled_from(THREE_SKILLS[1:])),
)
undoings = st.integers(0, 3)
"""How many commands that could be undone are passed over before one is."""


def undoing(run: Run, passed_over: int) -> Undo:
    """The undoing of a command given by hand and not undone, counted from the latest."""
    open_numbers = [
        event.number
        for event in reversed(run.control.history)
        if event.author == "hand" and not event.undone and not isinstance(event.command, Undo)
    ]
    return Undo(open_numbers[passed_over] if passed_over < len(open_numbers) else -1)


def repertoire_of(run: Run) -> tuple[object, ...]:
    """Which skills joined when, in which order they are explored, and how long it is frozen."""
    joined = [(entry.skill, entry.trial) for entry in run.control.introductions]
    explored = [episode for episode in run.control.episodes if episode.until_trial > run.trial]
    return joined, explored, run.control.frozen_until


@given(script=st.lists(st.tuples(st.integers(0, 2), repertoire_changes | undoings), max_size=14))
@settings(max_examples=200)
def test_what_was_done_to_the_repertoire_and_undone_is_as_if_it_had_not_been(
    script: list[tuple[int, Command | int]],
) -> None:
    spec = small("timed", *BY_HAND)
    run = Run(spec, 9)
    for trials, change in script:
        run.advance(until_trial=run.trial + trials)
        is_carried_out(run, undoing(run, change) if isinstance(change, int) else change)

    other = Run(spec, 9)
    for event in run.control.history:
        if event.author == "hand" and not event.undone and not isinstance(event.command, Undo):
            other.advance(until_trial=event.trial)
            # What is about a skill that never joined falls away with its introduction.
            is_carried_out(other, event.command)
    other.advance(until_trial=run.trial)
    assert repertoire_of(run) == repertoire_of(other)


# --- Biased exploration episodes -----------------------------------------------------------------

EXPLORED_STEPS = 40_000
# Five standard deviations of a share over so many independent steps.
WIDE = 5 * 0.5 / EXPLORED_STEPS**0.5


def explored_shares(*episodes: tuple[str, float]) -> dict[str, float]:
    """Share of each skill in the choices while episodes run, the last being the newest."""
    run = Run(small("hierarchical_3"), 4)
    advance_to(run, 5_000)
    for skill, probability in episodes:
        run.apply(Explore(skill, MAX_TRIALS, probability))
    before = option_counts(run)
    advance_to(run, run.step + EXPLORED_STEPS)
    shares = (option_counts(run) - before) / EXPLORED_STEPS
    return dict(zip(run.spec.learner.skills, shares, strict=True))


@pytest.mark.parametrize("probability", [0.0, 0.3, 0.95, 1.0])
def test_an_explored_skill_is_taken_with_the_probability_and_not_otherwise(
    probability: float,
) -> None:
    shares = explored_shares(("avoid", probability))
    assert shares["avoid"] == pytest.approx(probability, abs=WIDE * (0 < probability < 1))
    if probability < 1:
        assert min(shares["approach"], shares["circle_clockwise"]) > 0


def test_the_newest_episode_is_asked_first() -> None:
    shares = explored_shares(("avoid", 0.5), ("approach", 0.4))
    assert shares["approach"] == pytest.approx(0.4, abs=WIDE)
    assert shares["avoid"] == pytest.approx(0.6 * 0.5, abs=WIDE)
    assert shares["circle_clockwise"] == pytest.approx(0.6 * 0.5, abs=WIDE)


def test_where_every_skill_is_explored_the_ordinary_choice_is_among_all() -> None:
    shares = explored_shares(("avoid", 0.0), ("approach", 0.0), ("circle_clockwise", 0.0))
    assert sum(shares.values()) == pytest.approx(1.0)
    assert min(shares.values()) > 0


def test_a_new_episode_of_a_skill_takes_the_place_of_its_old_one() -> None:
    shares = explored_shares(("avoid", 1.0), ("avoid", 0.2))
    assert shares["avoid"] == pytest.approx(0.2, abs=WIDE)


def test_an_episode_lasts_for_its_trials() -> None:
    run = Run(small("hierarchical_3"), 4)
    run.advance(until_trial=20)
    run.apply(Explore("avoid", 10, 1.0))
    before = option_counts(run)
    run.advance(until_trial=30)
    during = option_counts(run) - before
    assert during.tolist() == [0, 0, int(run.state.log_steps[20:30].sum())]
    run.advance(until_trial=60)
    assert run.control.episodes == ()
    assert (option_counts(run) - before)[:2].min() > 0


def test_an_exploration_that_is_stopped_ends_at_once() -> None:
    run = Run(small("hierarchical_3"), 4)
    run.apply(Explore("avoid", 1_000, 1.0))
    advance_to(run, 500)
    run.apply(StopExploring("avoid"))
    before = option_counts(run)
    advance_to(run, 3_000)
    assert (option_counts(run) - before)[:2].min() > 0


# --- Commands that cannot be carried out ---------------------------------------------------------

REFUSED: Sequence[tuple[Command, str]] = (
    (Introduce("approach", 0), "approach has joined already"),
    (Introduce("pounce", 0), "'pounce' is not a skill of this learner; allowed: appetite, "),
    (Introduce("avoid", -1), "freeze: -1 trials is not allowed; allowed: 0 to "),
    (Introduce("avoid", MAX_TRIALS + 1), "freeze: 2000001 trials is not allowed"),
    (Explore("avoid", 10, 0.5), "'avoid' has not joined, so it cannot be explored"),
    (Explore("pounce", 10, 0.5), "'pounce' has not joined"),
    (Explore("approach", 10, -0.1), "probability: -0.1 is not allowed; allowed: 0 to 1"),
    (Explore("approach", 10, 1.1), "probability: 1.1 is not allowed"),
    (Explore("approach", 10, float("nan")), "probability: nan is not allowed"),
    (Explore("approach", -1, 0.5), "duration: -1 trials is not allowed"),
    (Explore("approach", MAX_TRIALS + 1, 0.5), "duration: 2000001 trials is not allowed"),
    (StopExploring("circle_clockwise"), "circle_clockwise is not being explored"),
    (Remove("avoid"), "'avoid' has not joined, so it cannot be removed"),
    (Remove("approach"), "approach is the only skill, and the learner needs one"),
    (SetParameter("world.size", 60), "'world.size' cannot change while a run goes on; allowed: "),
    (SetParameter("learner.epsilon", 1.5), "learner.epsilon: 1.5 is not allowed"),
    (SetParameter("learner.epsilon", float("nan")), "learner.epsilon: nan is not allowed"),
    (DefineSkill("avoid", SkillWeights()), "'avoid' is the name of a built-in skill; allowed: "),
    (DefineSkill("Not a name", SkillWeights()), "Not a name"),
    (StopTeaching(), "no script is teaching"),
    (Teach("flank", 0), "duration: 0 trials is not allowed; allowed: 1 to 2000000"),
    (Undo(0), "nothing was done by hand under the number 0"),
    (Undo(-1), "nothing was done by hand under the number -1"),
    (Undo(2), "nothing was done by hand under the number 2"),
    (
        SetSchedule(ScheduleSpec(skills={"circle_clockwise": SkillTimer(at=3), "avoid": LATER})),
        "is past and cannot change",
    ),
    (SetSchedule(ScheduleSpec(skills={"approach": LATER})), "is past and cannot change"),
    (
        SetSchedule(ScheduleSpec(pretrain=5)),
        "pretrain: 5 is not allowed, since pre-training comes before the first step of a run",
    ),
    (
        SetSchedule(ScheduleSpec(skills={"sneak": LATER})),
        "schedule.skills.sneak: 'sneak' is not among the learner's options; allowed: approach, ",
    ),
)


@pytest.mark.parametrize(("command", "message"), REFUSED, ids=[str(c)[:60] for c, _ in REFUSED])
def test_a_command_that_cannot_be_carried_out_changes_nothing(
    command: Command, message: str
) -> None:
    run = Run(small("timed", *BY_HAND), 2)
    run.apply(Explore("approach", 500, 0.2))
    advance_to(run, 1_000)
    before = everything(run)
    with pytest.raises(CommandError) as refusal:
        run.apply(command)
    assert message in str(refusal.value)
    assert len(str(refusal.value)) < 200, "a refusal is to quote what is wrong and no more"
    assert everything(run) == before


def test_a_learner_of_moves_has_no_skill_to_introduce() -> None:
    run = Run(small("standard_q"), 2)
    with pytest.raises(CommandError, match=r"not a skill of this learner; allowed: none"):
        run.apply(Introduce("approach", 0))


# --- Bookkeeping ---------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=[*SHIPPED, *SCRIPTS])
def kept(request: pytest.FixtureRequest) -> Run:
    """A run that has kept books for a while and stands within a trial."""
    if request.param in SCRIPTS:
        run = drive(Run(small("timed", *BY_HAND), 11), [60_000], SCRIPTS[request.param])
    else:
        settings = QUICK_SCHEDULE if request.param == "timed" else ()
        run = drive(Run(small(request.param, *settings), 11), [60_000])
    while run.state.tally[TRIAL_STEP] == 0:
        run.advance(max_steps=1)
    return run


def test_visits_and_logs_account_for_every_step(kept: Run) -> None:
    state, done = kept.state, kept.trial
    assert done > 100
    assert int(state.visits.sum()) == kept.step
    assert int(state.log_steps[:done].sum() + state.tally[TRIAL_STEP]) == kept.step
    assert not state.log_steps[done:].any()
    assert not state.log_outcome[done:].any()
    assert sum(measures.endings(state)) == done
    assert sum(measures.endings(state, recent=50)) == 50


def test_trials_end_as_logged(kept: Run) -> None:
    state, done = kept.state, kept.trial
    limit = kept.spec.world.step_limit
    outcome, steps = state.log_outcome[:done], state.log_steps[:done]
    assert set(outcome.tolist()) == {1, 2, 3}
    assert steps.min() >= 1
    assert steps.max() == limit
    assert (steps[outcome == TIMEOUT] == limit).all()
    assert (state.log_cell[:done][outcome == CAPTURE] == kept.world.prey_cell).all()
    np.testing.assert_array_equal(
        state.log_reward[:done], measures.rewards(kept.spec.world, outcome)
    )
    assert (state.log_switches[:done] <= steps).all()
    assert (state.log_switches[:done] >= 1).all(), "the first option of a trial counts"
    assert (state.log_new_states[:done] <= steps).all()


def test_new_states_are_those_not_visited_with_the_repertoire(kept: Run) -> None:
    state, done = kept.state, kept.trial
    found = int(state.log_new_states[:done].sum() + state.tally[TRIAL_NEW_STATES])
    visited = tables(kept.spec, state)["visits"].sum(axis=-1) > 0
    repertoires = int(state.tally[REPERTOIRE])
    if len(kept.control.introductions) == 0:
        assert found == visited.sum()
    assert visited.sum() <= found <= visited.sum() * repertoires
    np.testing.assert_array_equal(state.seen > 0, visited.ravel())


def test_first_reach_is_where_value_has_risen(kept: Run) -> None:
    known = tables(kept.spec, kept.state)
    value = np.nanmax(known["selection_q"], axis=-1)
    reached = known["first_reach"]
    assert (reached[value > 0] >= 0).all()
    assert (value[reached < 0] <= 0).all()
    assert reached.max() <= kept.trial
    if regions_of(kept.spec) is None:
        # All places of a region are worth what it is, also those that were never visited.
        assert (known["visits"].sum(axis=-1)[reached >= 0] > 0).all()
    assert (reached >= 0).sum() > 50


def test_first_reach_names_the_trial() -> None:
    run = Run(small("standard_q"), 11)
    expected = np.full(run.state.first_reach.size, NOT_REACHED)
    while run.trial < 2_000:
        trial = run.trial
        run.advance(until_trial=trial + 1)
        risen = (rows.best(run.state.selection) > 0) & (expected == NOT_REACHED)
        expected[risen] = trial
    # A value may rise and fall again within one trial, which only the run itself sees.
    seen = expected != NOT_REACHED
    assert seen.sum() > 50
    assert (run.state.first_reach[seen] <= expected[seen]).all()
    assert (run.state.first_reach[seen] == expected[seen]).mean() > 0.9


def test_an_initial_value_above_0_was_there_from_the_first_trial_on() -> None:
    run = drive(Run(small("standard_q", "learner.initial_q=1"), 11), [1_000])
    assert not run.state.first_reach.any()


@pytest.mark.parametrize("initial_q", ["-0.0", "-1e-60", "1e-60"])
def test_what_tables_hold_as_0_is_0(initial_q: str) -> None:
    runs = [Run(small("timed", f"learner.initial_q={value}"), 11) for value in ("0", initial_q)]
    assert math.copysign(1, runs[1].spec.learner.initial_q) == 1
    for run in runs:
        run.advance(max_steps=2_000)
    assert_same(*runs)


def test_the_trail_remembers_where_the_predator_has_been(kept: Run) -> None:
    if kept.state.tally[TRIAL_STEP] > 0:
        here = kept.state.trail[kept.step % TRAIL_LENGTH]
        assert here == kept.state.place[CELL]
    run = kept.copy()
    trail = {}
    for _ in range(200):
        trial = run.trial
        run.advance(max_steps=1, until_trial=MAX_TRIALS)
        ended = run.trial > trial
        place = run.state.log_cell[trial] if ended else run.state.place[CELL]
        trail[run.step % TRAIL_LENGTH] = int(place)
    assert {slot: int(run.state.trail[slot]) for slot in trail} == trail


def test_the_curve_is_the_mean_over_trials_that_ended_in_each_window(kept: Run) -> None:
    window = 7_000
    curve = measures.curve(kept.state, window)
    ended_at = np.cumsum(kept.state.log_steps[: kept.trial])
    rewards = np.array([0.0, 100.0, -50.0, 0.0])[kept.state.log_outcome[: kept.trial]]
    for index, (end, reward) in enumerate(zip(curve.steps, curve.reward, strict=True)):
        inside = (ended_at > index * window) & (ended_at <= (index + 1) * window)
        assert reward == pytest.approx(rewards[inside].mean())
        assert end == min((index + 1) * window, kept.step)


def test_a_window_in_which_no_trial_ended_has_no_reward() -> None:
    run = drive(Run(small("standard_q"), 11), [10_000])
    curve = measures.curve(run.state, 5)
    assert np.isnan(curve.reward).any()
    assert np.isfinite(curve.reward).sum() <= run.trial


def test_tables_are_copies() -> None:
    run = drive(Run(quick_timed(), 11), [5_000])
    before = everything(run)
    for table in tables(run.spec, run.state).values():
        table.fill(7)
    assert everything(run) == before


# --- Skills that see, earn and learn otherwise ---------------------------------------------------


def test_a_skill_of_ones_own_joins_where_skills_see_otherwise_and_all_of_them_learn() -> None:
    finer = ("world.skill_n_directions=24", "world.skill_n_distances=9")
    run = Run(small("timed", *BY_HAND, *finer, "learner.skills_that_learn=all"), 5)
    run.advance(max_steps=2_000)
    run.apply(DefineSkill("nearer", SkillWeights(approach=0.5, circle_clockwise=1.0)))
    run.apply(Introduce("nearer", 10))
    before = tables(run.spec, run.state)["skill_q"]
    assert before.shape == (4, 9, 24, 9)
    assert not before[3].any()
    run.apply(Explore("approach", 1_000, 1.0))
    run.advance(max_steps=2_000)
    after = tables(run.spec, run.state)["skill_q"]
    assert after[3].any(), "it learned, though approach made every move"
    assert not np.array_equal(after[0], before[0])
    assert not after[[1, 2]].any(), "those that are not present learned nothing"


def test_binary_local_rewards_are_worth_one_at_most_and_never_less_than_nothing() -> None:
    found: dict[str, np.ndarray] = {}
    for rewards in ("signed", "binary"):
        run = Run(small("hierarchical_3", f"learner.local_rewards={rewards}"), 6)
        run.advance(max_steps=20_000)
        found[rewards] = tables(run.spec, run.state)["skill_q"]
    assert found["signed"].min() < 0
    assert found["binary"].min() == 0
    # One at every step, discounted by 0.9.
    assert 5 < found["binary"].max() <= 10 + 1e-4


def test_the_penalty_of_circles_is_part_of_a_skill_of_ones_own() -> None:
    weights = SkillWeights(approach=0.5, circle_clockwise=1.0)
    learner = small("timed", "learner.spiral_penalty=0.75").learner
    own = learner.model_copy(update={"custom_skills": {"nearer": weights}})
    assert own.reward_of("nearer") == LocalReward(0.5, -1.0, -0.75)
    assert own.reward_of("circle_counterclockwise") == LocalReward(0.0, 1.0, -0.75)
    assert own.reward_of("avoid") == LocalReward(-1.0, 0.0, 0.0)


# --- What it is compiled from, and what it takes -------------------------------------------------

PLAIN_STEPS = 4_000
OPEN_POINTS = {
    "skills see finer": ("world.skill_n_directions=24", "world.skill_n_distances=18"),
    "all learn": ("learner.skills_that_learn=all", "learner.spiral_penalty=0"),
    "binary": ("learner.local_rewards=binary", "world.ring_exponent=2.2"),
    **{
        f"by {by}": (
            f"schedule.introduce={{by: {by}, window: 9, below: {below}}}",
            "schedule.skills.circle_clockwise.at=null",
            "schedule.skills.avoid.at=null",
            "schedule.episodes=[{skill: circle_clockwise, duration: 20, probability: 0.5,"
            " where: {value_at_most: 0.5}}, {skill: avoid, duration: 9, probability: 0.5}]",
        )
        for by, below in (("novelty", 1), ("reach", 0.01), ("change", 0.4))
    },
}


def _plain_run(name: str) -> Run:
    """A short run that gets to every piece of the loop; also what the subprocess runs."""
    if name in SCRIPTS:
        commands = [(step // 12, command) for step, command in SCRIPTS[name]]
        return drive(Run(small("timed", *BY_HAND), 12), [PLAIN_STEPS], commands)
    if name in OPEN_POINTS:
        return drive(Run(small("timed", *QUICK_SCHEDULE, *OPEN_POINTS[name]), 12), [PLAIN_STEPS])
    settings = QUICK_SCHEDULE if name == "timed" else ()
    return drive(Run(small(name, *settings), 12), [PLAIN_STEPS])


def _fingerprint(run: Run) -> str:
    known = everything(run)
    return hashlib.sha256(b"".join(known[name] for name in sorted(known))).hexdigest()


PLAIN_CASES = (*SHIPPED, *SCRIPTS, *OPEN_POINTS)


def test_compiled_and_plain_python_agree_bit_for_bit() -> None:
    # Unsigned words that wrap around are meant to; only plain Python warns of them.
    plain = subprocess.run(
        [sys.executable, "-W", "ignore", __file__, *PLAIN_CASES],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    compiled = [f"{name} {_fingerprint(_plain_run(name))}" for name in PLAIN_CASES]
    assert plain.stdout.splitlines() == ["plain", *compiled]


def _megabytes(arrays: Iterable[object]) -> float:
    """Memory of arrays, each piece of it counted once."""
    owners: dict[int, int] = {}
    for array in arrays:
        if isinstance(array, np.ndarray):
            owners[array.ctypes.data] = array.nbytes
    return sum(owners.values()) / 1e6


@pytest.mark.parametrize("preset", SHIPPED)
@pytest.mark.parametrize("until_trial", [0, 3_000])
def test_a_learner_fits_into_5_megabytes(preset: str, until_trial: int) -> None:
    run = Run(presets.load(preset, ("trials=48000",)), 0)
    run.advance(until_trial=until_trial)
    assert 0.2 < _megabytes([*run.state, *run.world]) < 5


def main(names: Sequence[str], say: Callable[[str], object] = sys.stdout.write) -> None:
    """Run as plain Python, for the comparison with what is compiled."""
    is_plain = not hasattr(loop.advance, "py_func")
    say("plain\n" if is_plain else "compiled\n")
    for name in names:
        say(f"{name} {_fingerprint(_plain_run(name))}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
