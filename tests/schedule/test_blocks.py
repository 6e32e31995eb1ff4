"""The timeline tells what happened, edits only what is ahead, and survives being saved."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.documents import presets
from app.live.snapshot import Snapshot
from app.schedule import blocks, carried
from app.schedule.blocks import NEVER, Block
from app.schedule.edits import Now, changed, moved, newest_episode_id, now_of, with_episode, without
from learners.commands import (
    Command,
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
    Undo,
)
from learners.kernel import rows
from learners.names import INTRODUCTION, MAX_TRIALS
from learners.run import Run
from learners.schedule_spec import EpisodeSpec, ScheduleSpec, SkillTimer
from learners.skill_spec import SkillWeights
from tests.support.schedules import (
    APPROACHING,
    AVOID,
    AVOIDING,
    CIRCLE,
    CIRCLING,
    commands,
    driven,
    seen,
    small_run,
    small_spec,
    to,
)


def blocks_of(run: Run) -> tuple[Block, ...]:
    return blocks.blocks_of(seen(run))


def block(run: Run, id: str) -> Block:
    (found,) = (block for block in blocks_of(run) if block.id == id)
    return found


def of_kind(run: Run, kind: str, skill: str = "") -> list[Block]:
    return [block for block in blocks_of(run) if block.kind == kind and block.skill == skill]


def spans(blocks: list[Block]) -> list[tuple[int, int | None]]:
    return [(block.first, block.until) for block in blocks]


# --- Blocks --------------------------------------------------------------------------------------


def test_before_the_first_step_all_but_the_first_introduction_is_planned() -> None:
    run = small_run()
    assert [block.id for block in blocks_of(run) if block.state == "planned"] == [
        CIRCLE,
        AVOID,
        CIRCLING,
        AVOIDING,
        APPROACHING,
    ]
    assert all(block.editable for block in blocks_of(run) if block.state == "planned")
    approach = block(run, "event:0")
    assert (approach.kind, approach.first, approach.until) == ("introduction", 0, 10)
    assert (approach.state, approach.editable, approach.by_hand) == ("running", False, False)


def test_a_block_goes_from_planned_to_running_to_done() -> None:
    run = small_run()
    planned = block(run, CIRCLING)
    assert (planned.first, planned.until, planned.last) == (100, 160, 159)
    assert planned.probability == 0.95
    to(run, 130)
    (running,) = of_kind(run, "exploration", "circle_clockwise")
    assert (running.state, running.first, running.until) == ("running", 100, 160)
    assert not running.editable
    to(run, 160)
    (done,) = of_kind(run, "exploration", "circle_clockwise")
    assert (done.state, done.first, done.until) == ("done", 100, 160)
    assert not done.by_hand


def test_ids_stay_while_time_passes_and_blocks_are_changed() -> None:
    run = small_run()
    ahead = [block.id for block in blocks_of(run) if block.editable]
    to(run, 150)
    assert [block.id for block in blocks_of(run) if block.editable] == [
        id for id in ahead if id not in (CIRCLE, CIRCLING)
    ]
    plan = moved(run.spec.schedule, AVOID, 30, Now(150, run.present))
    plan = changed(plan, AVOIDING, Now(150, run.present), probability=0.7)
    run.apply(SetSchedule(plan))
    assert (block(run, AVOID).first, block(run, AVOIDING).first) == (230, 230)
    assert block(run, AVOIDING).probability == 0.7
    assert len({block.id for block in blocks_of(run)}) == len(blocks_of(run))


def test_what_starts_in_the_running_trial_is_locked() -> None:
    run = to(small_run(), 100)
    assert run.planned()[0].trial == 100
    assert not block(run, CIRCLE).editable
    assert block(run, AVOID).editable


def test_what_is_done_by_hand_appears_as_it_happens() -> None:
    run = to(small_run(), 50)
    run.apply(Introduce("avoid", 7))
    (joined,) = of_kind(run, "introduction", "avoid")
    assert (joined.first, joined.until, joined.by_hand) == (50, 57, True)
    (explored,) = of_kind(run, "exploration", "avoid")
    assert spans([explored]) == [(50, 100)]
    assert not explored.by_hand  # The schedule's answer to the introduction.
    to(run, 60)
    run.apply(Explore("approach", 100, 0.25))
    to(run, 75)
    run.apply(StopExploring("approach"))
    by_hand = of_kind(run, "exploration", "approach")[0]
    assert (by_hand.first, by_hand.until, by_hand.state) == (60, 75, "done")
    assert (by_hand.by_hand, by_hand.probability) == (True, 0.25)


def test_an_exploration_ends_when_its_skill_is_explored_anew() -> None:
    run = to(small_run(), 10)
    run.apply(Explore("approach", 100, 0.5))
    to(run, 30)
    run.apply(Explore("approach", 20, 0.9))
    ran = [block for block in of_kind(run, "exploration", "approach") if block.by_hand]
    assert spans(ran) == [(10, 30), (30, 50)]
    assert [block.state for block in ran] == ["done", "running"]


def test_freezes_by_hand_have_no_skill_and_last_until_they_are_ended() -> None:
    run = to(small_run(), 20)
    run.apply(FreezeSelection(True))
    run.apply(FreezeSkills(True))
    run.apply(FreezeSelection(True))
    (selection,), (skills,) = of_kind(run, "selection_freeze"), of_kind(run, "skills_freeze")
    assert (selection.first, selection.until, selection.state) == (20, None, "running")
    assert selection.last is None
    assert skills.by_hand
    to(run, 40)
    run.apply(FreezeSelection(False))
    assert spans(of_kind(run, "selection_freeze")) == [(20, 40)]
    assert spans(of_kind(run, "skills_freeze")) == [(20, None)]


def test_a_freeze_that_ends_before_the_next_step_was_none() -> None:
    run = to(small_run(), 20)
    run.apply(FreezeSelection(True))
    run.apply(FreezeSelection(False))
    assert of_kind(run, "selection_freeze") == []
    run.apply(FreezeSkills(True))
    run.apply(Undo(run.control.history[-1].number))
    assert of_kind(run, "skills_freeze") == []
    assert carried.schedule_of(seen(run)).left_out == ()


def test_a_freeze_within_a_trial_is_one_of_that_trial() -> None:
    run = to(small_run(), 20)
    run.apply(FreezeSelection(True))
    run.advance(max_steps=1)
    run.apply(FreezeSelection(False))
    assert run.trial == 20
    (frozen,) = of_kind(run, "selection_freeze")
    assert blocks.described(frozen) == "selection frozen by hand, trial 20"


def test_a_freeze_that_was_taken_back_ends_as_if_it_had_not_been_given() -> None:
    run = to(small_run(), 20)
    run.apply(FreezeSelection(True))
    first = run.control.history[-1].number
    to(run, 30).apply(FreezeSelection(False))
    second = run.control.history[-1].number
    run.apply(Undo(first))
    to(run, 40).apply(Undo(second))
    assert not run.control.selection_frozen
    (frozen,) = of_kind(run, "selection_freeze")
    assert (frozen.first, frozen.until, frozen.undone) == (20, 30, True)


def test_a_freeze_asked_for_twice_and_taken_back_once_goes_on() -> None:
    run = to(small_run(), 20)
    run.apply(FreezeSkills(True))
    first = run.control.history[-1].number
    to(run, 30).apply(FreezeSkills(True))
    to(run, 40).apply(Undo(first))
    assert run.control.skills_frozen
    frozen = of_kind(run, "skills_freeze")
    assert spans(frozen) == [(20, 40), (40, None)]
    assert [block.undone for block in frozen] == [True, False]


def test_what_an_edit_moved_changed_or_added_is_by_hand_planned_and_done() -> None:
    run = to(small_run(), 20)
    now = Now(20, run.present)
    plan = moved(run.spec.schedule, CIRCLE, -40, now)
    plan = changed(plan, AVOIDING, now, probability=0.6)
    plan = with_episode(plan, "approach", 250, 20, 0.5, now)
    run.apply(SetSchedule(plan))
    by_hand = [(60, "introduction"), (200, "exploration"), (250, "exploration")]

    def marked() -> list[tuple[int, str]]:
        seen = [block for block in blocks_of(run) if block.by_hand and block.kind != "presence"]
        return sorted((block.first, block.kind) for block in seen)

    assert marked() == by_hand
    assert "joins at trial 60, by hand" in blocks.described(block(run, CIRCLE))
    to(run, 400)
    assert marked() == by_hand


def test_what_an_edit_put_back_is_not_by_hand() -> None:
    run = to(small_run(), 20)
    now = Now(20, run.present)
    run.apply(SetSchedule(moved(run.spec.schedule, CIRCLE, -40, now)))
    run.apply(SetSchedule(moved(run.spec.schedule, CIRCLE, 40, now)))
    assert not any(block.by_hand for block in blocks_of(run))
    run.apply(SetSchedule(moved(run.spec.schedule, AVOID, 40, now)))
    run.apply(Undo(run.control.history[-1].number))
    assert not any(block.by_hand for block in blocks_of(to(run, 400)))


def test_a_skill_without_a_timer_of_the_preset_joins_by_hand() -> None:
    run = to(small_run(), 20)
    run.apply(Introduce("circle_counterclockwise", 0))
    run.apply(Remove("circle_counterclockwise"))
    id = "introduction:circle_counterclockwise"
    assert not block(run, id).by_hand
    now = Now(20, run.present)
    run.apply(SetSchedule(changed(run.spec.schedule, id, now, at=90)))
    assert block(run, id).by_hand


def test_a_skill_is_present_from_when_it_joins_until_it_is_removed() -> None:
    run = to(small_run(), 120)
    run.apply(Remove("circle_clockwise"))
    assert spans(of_kind(run, "presence", "circle_clockwise")) == [(100, 120)]
    assert spans(of_kind(run, "exploration", "circle_clockwise")) == [(100, 120)]
    removal = run.control.history[-1].number
    to(run, 130)
    run.apply(Undo(removal))
    assert spans(of_kind(run, "presence", "circle_clockwise")) == [(100, 120), (130, None)]


def test_undone_commands_are_marked_and_their_ends_shown() -> None:
    run = to(small_run(), 20)
    run.apply(Introduce("avoid", 5))
    number = run.control.history[-2].number
    assert isinstance(run.control.history[number].command, Introduce)
    to(run, 30)
    run.apply(Undo(number))
    joined = of_kind(run, "introduction", "avoid")
    assert [(block.first, block.undone) for block in joined] == [(20, True), (200, False)]
    assert spans(of_kind(run, "presence", "avoid")) == [(20, 30)]
    assert spans(of_kind(run, "exploration", "avoid")) == [(20, 30), (200, 250)]


def test_an_undone_stop_lets_the_exploration_go_on() -> None:
    run = to(small_run(), 20)
    run.apply(Explore("approach", 100, 0.5))
    to(run, 40)
    run.apply(StopExploring("approach"))
    stop = run.control.history[-1].number
    to(run, 60)
    run.apply(Undo(stop))
    ran = [block for block in of_kind(run, "exploration", "approach") if block.by_hand]
    assert spans(ran) == [(20, 40), (60, 120)]


def test_an_undone_exploration_lets_the_one_go_on_that_it_replaced() -> None:
    run = to(small_run(), 20)
    run.apply(Explore("approach", 100, 0.5))
    to(run, 40).apply(Explore("approach", 10, 0.9))
    newest = run.control.history[-1].number
    to(run, 45).apply(Undo(newest))
    ran = [block for block in of_kind(run, "exploration", "approach") if block.by_hand]
    assert spans(ran) == [(20, 40), (40, 45), (45, 120)]
    assert [block.probability for block in ran] == [0.5, 0.9, 0.5]


def test_an_undone_removal_brings_the_exploration_back() -> None:
    run = to(small_run(), 120)
    run.apply(Remove("circle_clockwise"))
    removal = run.control.history[-1].number
    to(run, 130).apply(Undo(removal))
    assert spans(of_kind(run, "exploration", "circle_clockwise")) == [(100, 120), (130, 160)]
    to(run, 150).apply(Remove("circle_clockwise"))
    removal = run.control.history[-1].number
    to(run, 170).apply(Undo(removal))
    assert spans(of_kind(run, "exploration", "circle_clockwise"))[-1] == (130, 150)


def test_the_freeze_of_an_undone_introduction_is_over() -> None:
    run = to(small_run(), 20)
    run.apply(Introduce("avoid", 100))
    number = next(e.number for e in run.control.history if e.command == Introduce("avoid", 100))
    to(run, 30).apply(Undo(number))
    (joined, _) = of_kind(run, "introduction", "avoid")
    assert (joined.first, joined.until, joined.state) == (20, 30, "done")
    assert not run.selection_is_frozen


def test_what_will_not_happen_is_idle() -> None:
    run = to(small_run(), 20)
    run.apply(FollowSchedule(False))
    assert {block.state for block in blocks_of(run) if block.editable} == {"idle"}
    run.apply(FollowSchedule(True))
    to(run, 250)
    run.apply(Remove("approach"))
    assert block(run, APPROACHING).state == "idle"
    assert "will not happen" in blocks.described(block(run, APPROACHING))


def test_a_timer_yields_to_an_introduction_by_hand() -> None:
    run = to(small_run(), 20)
    run.apply(Introduce("circle_clockwise", 0))
    ahead = {block.id for block in blocks_of(run) if block.editable}
    assert not {CIRCLE, CIRCLING} & ahead


def test_primitive_moves_have_no_blocks() -> None:
    run = Run(presets.load("standard_q", ["world.size=30", "trials=20"]), 1)
    assert blocks_of(to(run, 5)) == ()


def words(shown: tuple[Block, ...]) -> str:
    return "\n".join(blocks.described(block) for block in shown)


def test_blocks_are_described_in_words() -> None:
    run = to(small_run(), 120)
    run.apply(FreezeSkills(True))
    assert words(blocks_of(run)).splitlines() == [
        "approach joins at trial 0, by the schedule, selection frozen for 10 trials",
        "approach can be chosen from trial 0 on",
        "circle clockwise joins at trial 100, by the schedule, selection frozen for 20 trials",
        "circle clockwise can be chosen from trial 100 on",
        "circle clockwise is explored in 95% of the steps, trials 100 to 159, by the schedule",
        "skills frozen by hand, trials 120 on",
        "avoid joins at trial 200, by the schedule, selection frozen for 20 trials",
        "avoid is explored in 30% of the steps, trials 200 to 249, by the schedule",
        "approach is explored in 50% of the steps, trials 300 to 339, by the schedule",
    ]


@given(script=st.lists(st.tuples(st.integers(0, 800), commands), max_size=20))
def test_blocks_agree_with_what_the_run_says_of_itself(script: list[tuple[int, Command]]) -> None:
    run = driven(small_run(), script)
    control, trial = run.control, run.trial
    running = [block for block in blocks_of(run) if block.state == "running"]
    assert {b.skill for b in running if b.kind == "presence"} == set(run.present)
    explored = [b for b in running if b.kind == "exploration"]
    assert {(b.skill, b.probability, b.until, b.value_at_most) for b in explored} == {
        tuple(episode) for episode in control.episodes if episode.until_trial > trial
    }
    assert any(b.kind == "selection_freeze" for b in running) == control.selection_frozen
    assert any(b.kind == "skills_freeze" for b in running) == control.skills_frozen
    frozen = [b.until for b in running if b.kind == "introduction"]
    assert max(frozen, default=trial) == max(control.frozen_until, trial)


@given(script=st.lists(st.tuples(st.integers(0, 800), commands), max_size=20))
def test_whatever_was_done_makes_a_valid_preset(
    script: list[tuple[int, Command]],
) -> None:
    shot = seen(driven(small_run(), script))
    spec, _ = carried.preset_of(shot)
    assert presets.parse(presets.dump(spec), "saved") == spec
    for skill, (first, undone) in first_joins(shot).items():
        if not undone:
            assert spec.schedule.introduced_at(skill) == first


def first_joins(shot: Snapshot) -> dict[str, tuple[int, bool]]:
    """Trial in which each skill first joined, and whether that was undone."""
    joins: dict[str, tuple[int, bool]] = {}
    for event in shot.control.history:
        if isinstance(event.command, Introduce):
            joins.setdefault(event.command.skill, (event.trial, event.undone))
    return joins


# --- Edits ---------------------------------------------------------------------------------------

AT_START = Now(0, ("approach",))
PLAN = small_spec().schedule


def starts(plan: ScheduleSpec) -> list[int]:
    return [plan.starts_at(episode) for episode in plan.episodes]


def test_moving_an_introduction_takes_what_starts_with_it_along() -> None:
    plan = moved(PLAN, CIRCLE, -50, AT_START)
    assert plan.introduced_at("circle_clockwise") == 50
    assert plan.freeze_of("circle_clockwise") == 20
    assert starts(plan) == [50, 200, 300]
    assert plan.episodes == PLAN.episodes


def test_an_exploration_that_is_moved_leaves_its_introduction_and_can_come_back() -> None:
    plan = moved(PLAN, CIRCLING, 25, AT_START)
    assert plan.episodes[0].at == 125
    assert moved(plan, CIRCLE, 10, AT_START).episodes[0].at == 125
    assert moved(plan, CIRCLING, -25, AT_START) == PLAN


def test_numbers_are_clamped_to_what_is_allowed() -> None:
    now = Now(90, ("approach",))
    assert moved(PLAN, CIRCLE, -1_000, now).introduced_at("circle_clockwise") == 91
    far = moved(PLAN, CIRCLE, 10 * MAX_TRIALS, now)
    assert far.introduced_at("circle_clockwise") == MAX_TRIALS
    # An exploration cannot start before its skill joins.
    late = moved(PLAN, CIRCLING, 5, AT_START)
    assert moved(late, CIRCLING, -1_000, AT_START) == PLAN
    assert changed(PLAN, CIRCLE, now, trials=-5).freeze_of("circle_clockwise") == 0
    assert changed(PLAN, CIRCLING, now, trials=0).episodes[0].duration == 1
    assert changed(PLAN, CIRCLING, now, trials=10**9).episodes[0].duration == MAX_TRIALS
    assert changed(PLAN, CIRCLING, now, probability=1.5).episodes[0].probability == 1
    assert changed(PLAN, CIRCLING, now, probability=-1).episodes[0].probability == 0


def test_lengths_and_probabilities_change() -> None:
    assert changed(PLAN, AVOID, AT_START, trials=33).freeze_of("avoid") == 33
    assert changed(PLAN, AVOIDING, AT_START, trials=33).episodes[1].duration == 33
    assert changed(PLAN, AVOIDING, AT_START, probability=0.9).episodes[1].probability == 0.9


def test_several_things_change_at_once_where_one_after_the_other_would_not_fit() -> None:
    plan = with_episode(PLAN, "approach", 345, 40, 0.5, AT_START)
    with pytest.raises(ValueError, match="overlap"):
        moved(plan, APPROACHING, 20, AT_START)
    plan = changed(plan, APPROACHING, AT_START, at=320, trials=10)
    assert plan.episodes[2].at == 320


def test_explorations_are_added_and_taken_out() -> None:
    plan = with_episode(PLAN, "avoid", 400, 30, 0.8, AT_START)
    assert plan.episodes[-1] == EpisodeSpec(skill="avoid", at=400, duration=30, probability=0.8)
    assert newest_episode_id(plan) == "episode:3:avoid"
    assert without(plan, "episode:3:avoid", AT_START) == PLAN
    assert starts(without(PLAN, AVOIDING, AT_START)) == [100, 300]


def test_an_exploration_of_a_skill_that_is_yet_to_join_waits_for_it() -> None:
    plan = without(PLAN, AVOIDING, AT_START)
    plan = with_episode(plan, "avoid", 5, 30, 0.8, AT_START)
    assert plan.episodes[-1].at == INTRODUCTION


Edit = Callable[[ScheduleSpec], Any]


@pytest.mark.parametrize(
    ("edit", "why"),
    [
        (lambda p: moved(p, CIRCLE, 100, Now(100, ())), "Trial 100 is past"),
        (
            lambda p: changed(p, CIRCLING, Now(150, ()), trials=100),
            "Trial 100 is past",
        ),
        (lambda p: changed(p, CIRCLING, Now(150, ()), probability=0), "is past"),
        (lambda p: without(p, CIRCLING, Now(100, ())), "is past"),
        (lambda p: without(p, CIRCLE, AT_START), "cannot be deleted"),
        (lambda p: moved(p, "event:3", 100, AT_START), "has happened"),
        (lambda p: moved(p, "episode:7:avoid", 100, AT_START), "any more"),
        (lambda p: moved(p, "episode:0:avoid", 100, AT_START), "any more"),
        (lambda p: moved(p, "introduction:other", 100, AT_START), "any more"),
        (lambda p: without(p, "episode:-1:avoid", AT_START), "has happened"),
        (
            lambda p: changed(p, CIRCLE, AT_START, probability=0.5),
            "has no probability",
        ),
        (
            lambda p: changed(p, CIRCLING, AT_START, probability=float("nan")),
            "from 0 to 1",
        ),
        (lambda p: moved(p, CIRCLING, -1, AT_START), "any earlier than trial 100"),
        (lambda p: moved(p, CIRCLE, -1, Now(99, ())), "any earlier than trial 100"),
        (lambda p: with_episode(p, "approach", 290, 20, 0.5, AT_START), "overlap"),
        (
            lambda p: with_episode(p, "avoid", 500, 20, 0.5, Now(300, ())),
            "will not join",
        ),
        (lambda p: moved(p, APPROACHING, 1, Now(300, ("approach",))), "is past"),
    ],
)
def test_edits_that_cannot_be_made_say_why(edit: Edit, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        edit(PLAN)


def test_an_introduction_cannot_be_moved_behind_an_exploration() -> None:
    plan = moved(PLAN, CIRCLING, 30, AT_START)
    with pytest.raises(ValueError, match=r"Circle clockwise is to be explored at trial 130"):
        moved(plan, CIRCLE, 50, AT_START)


def test_edits_leave_the_schedule_that_they_are_given_alone() -> None:
    before = PLAN.model_dump()
    moved(PLAN, CIRCLE, 10, AT_START)
    with_episode(PLAN, "avoid", 400, 30, 0.8, AT_START)
    without(PLAN, AVOIDING, AT_START)
    assert PLAN.model_dump() == before


def test_a_run_takes_an_edited_schedule_and_does_it_when_its_time_comes() -> None:
    run = to(small_run(), 150)
    now = now_of(seen(run))
    plan = moved(run.spec.schedule, AVOID, 50, now)
    plan = with_episode(plan, "circle_clockwise", 180, 10, 1.0, now)
    run.apply(SetSchedule(plan))
    to(run, 300)
    joined = {entry.skill: entry.trial for entry in run.control.introductions}
    assert joined["avoid"] == 250
    assert spans(of_kind(run, "exploration", "circle_clockwise")) == [(100, 160), (180, 190)]


def test_a_skill_added_by_hand_can_be_planned_to_be_explored_before_its_timer() -> None:
    run = to(small_run(), 20)
    run.apply(Introduce("avoid", 0))
    run.apply(DefineSkill("sneak", SkillWeights(approach=1.0, avoid=0.5)))
    run.apply(Introduce("sneak", 0))
    to(run, 80)
    for skill in ("avoid", "sneak"):
        plan = run.spec.schedule
        run.apply(SetSchedule(with_episode(plan, skill, 90, 15, 0.5, Now(80, run.present))))
    to(run, 400)
    assert spans(of_kind(run, "exploration", "avoid")) == [(20, 70), (90, 105)]
    assert spans(of_kind(run, "exploration", "sneak")) == [(90, 105)]
    assert [entry.skill for entry in run.control.introductions].count("avoid") == 1


@given(
    edits=st.lists(
        st.tuples(
            st.sampled_from([CIRCLE, AVOID, CIRCLING, AVOIDING, APPROACHING]),
            st.integers(-400, 400),
            st.integers(-10, 200),
        ),
        max_size=12,
    ),
    trial=st.integers(0, 350),
)
def test_no_chain_of_edits_is_refused_by_the_run(
    edits: list[tuple[str, int, int]], trial: int
) -> None:
    run = to(small_run(), trial)
    now = now_of(seen(run))
    plan = run.spec.schedule
    for id, by, trials in edits:
        try:
            plan = moved(plan, id, by, now)
            plan = changed(plan, id, now, trials=trials)
        except ValueError:
            continue
    run.apply(SetSchedule(plan))


# --- What a preset can carry ---------------------------------------------------------------------


def test_an_untouched_run_carries_its_own_schedule() -> None:
    for trial in (0, 150, 499):
        kept = carried.schedule_of(seen(to(small_run(), trial)))
        assert kept.left_out == ()
        plan = small_spec().schedule
        assert kept.schedule.skills == plan.skills
        assert set(kept.schedule.episodes) == set(plan.episodes)


def test_what_was_done_by_hand_is_carried() -> None:
    run = to(small_run(), 50)
    run.apply(Introduce("avoid", 7))
    to(run, 70)
    run.apply(StopExploring("avoid"))
    to(run, 140)
    run.apply(Explore("circle_clockwise", 30, 0.4))
    to(run, 145)
    kept = carried.schedule_of(seen(run))
    assert kept.left_out == ()
    assert kept.schedule == ScheduleSpec(
        skills={
            "approach": SkillTimer(at=0, freeze=10),
            "circle_clockwise": SkillTimer(at=100, freeze=20),
            "avoid": SkillTimer(at=50, freeze=7),
        },
        episodes=(
            EpisodeSpec(skill="avoid", at=INTRODUCTION, duration=20, probability=0.3),
            EpisodeSpec(skill="circle_clockwise", at=INTRODUCTION, duration=40, probability=0.95),
            EpisodeSpec(skill="circle_clockwise", at=140, duration=30, probability=0.4),
            EpisodeSpec(skill="approach", at=300, duration=40, probability=0.5),
        ),
    )


def test_a_running_exploration_is_shortened_where_the_next_one_is_planned() -> None:
    run = to(small_run(), 290)
    run.apply(Explore("approach", 100, 0.9))
    run.advance(max_steps=3)
    spec, _ = carried.preset_of(seen(run))
    mine = [episode for episode in spec.schedule.episodes if episode.skill == "approach"]
    assert [(e.at, e.duration) for e in mine] == [(290, 10), (300, 40)]


def test_an_exploration_of_less_than_a_trial_is_dropped() -> None:
    run = to(small_run(), 20)
    run.apply(Explore("approach", 30, 0.9))
    run.apply(StopExploring("approach"))
    assert (
        carried.schedule_of(seen(run)).schedule == carried.schedule_of(seen(small_run())).schedule
    )


def test_the_preset_is_as_long_as_the_run_has_been() -> None:
    run = small_run()
    run.advance(until_trial=600)
    spec, _ = carried.preset_of(seen(run))
    assert spec.trials == 600
    assert carried.preset_of(seen(to(small_run(), 20))).spec.trials == 500


def by_hand(run: Run) -> Run:
    """Do by hand, between trials, what a schedule can say; to trial 450."""
    to(run, 30).apply(Introduce("circle_clockwise", 15))
    to(run, 45).apply(StopExploring("circle_clockwise"))
    to(run, 60).apply(Explore("approach", 40, 0.6))
    to(run, 80).apply(Explore("approach", 100, 0.2))
    to(run, 120).apply(Introduce("circle_counterclockwise", 5))
    to(run, 130).apply(Explore("circle_counterclockwise", 30, 0.8))
    to(run, 150).apply(StopExploring("approach"))
    return to(run, 450)


def test_a_saved_run_does_the_same_again() -> None:
    run = by_hand(small_run())
    spec, left_out = carried.preset_of(seen(run))
    assert left_out == ()
    again = to(Run(presets.parse(presets.dump(spec), "saved"), seed=5), 450)
    assert [(e.skill, e.trial) for e in again.control.introductions] == [
        (e.skill, e.trial) for e in run.control.introductions
    ]
    assert not any(event.author == "hand" for event in again.control.history)
    # What was done between trials is repeated to the last bit.
    assert again.step == run.step
    np.testing.assert_array_equal(
        rows.values(again.state.selection), rows.values(run.state.selection)
    )
    np.testing.assert_array_equal(rows.values(again.state.skills), rows.values(run.state.skills))


def test_what_was_done_within_a_trial_is_done_at_its_start() -> None:
    run = to(small_run(), 30)
    run.advance(max_steps=2)
    assert run.trial == 30
    run.apply(Introduce("avoid", 0))
    spec, _ = carried.preset_of(seen(run))
    assert spec.schedule.introduced_at("avoid") == 30
    assert to(Run(spec, seed=5), 100).control.introductions[1].trial == 30


def test_what_a_schedule_cannot_say_is_said_in_sentences() -> None:
    run = to(small_run(), 20)
    run.apply(FreezeSelection(True))
    run.apply(SetParameter("learner.epsilon", 0.2))
    to(run, 40)
    run.apply(FreezeSelection(False))
    run.apply(Introduce("avoid", 0))
    run.apply(Undo(run.control.history[-2].number))
    to(run, 120)
    run.apply(Remove("circle_clockwise"))
    run.apply(FollowSchedule(False))
    kept = carried.preset_of(seen(run))
    assert kept.left_out == (
        "Selection frozen by hand, trials 20 to 39.",
        "Avoid was added at trial 40; that was taken back.",
        "Exploration ε was set to 0.2 at trial 20: it is 0.2, the latest value, from the start.",
        "Circle clockwise was removed at trial 120: it joins and stays.",
        "Avoid has not joined and is not planned to: it never joins.",
        "What the schedule has ahead: it is not being followed.",
    )
    assert kept.spec.schedule.introduced_at("avoid") == NEVER
    assert kept.spec.schedule.introduced_at("circle_clockwise") == 100
    assert [episode.skill for episode in kept.spec.schedule.episodes] == ["circle_clockwise"]
    assert kept.spec.learner.epsilon == 0.2


def test_what_was_taken_back_is_not_said_to_have_been_done() -> None:
    run = to(small_run(), 120)
    for command in (SetParameter("learner.epsilon", 0.3), Remove("circle_clockwise")):
        run.apply(command)
        run.apply(Undo(run.control.history[-1].number))
    assert carried.preset_of(seen(run)).left_out == ()


def test_primitive_moves_carry_an_empty_schedule() -> None:
    spec = presets.load("standard_q", ["world.size=30", "trials=20"])
    assert carried.preset_of(seen(to(Run(spec, 1), 5))).spec == spec
