"""Skills that join by a rule are planned without a trial, and can be told to join by hand."""

import pytest

from app.documents import presets
from app.schedule import blocks, carried
from app.schedule.blocks import NEVER, Block, described
from app.schedule.edits import changed, now_of, with_episode
from learners.commands import FollowSchedule, SetSchedule
from learners.kernel.state import digest
from learners.run import Run
from learners.schedule_spec import SkillTimer, TriggerSpec
from tests.support.schedules import AVOID, CIRCLE, CIRCLING, RULE, ruled_spec, seen, small_run, to


def block(run: Run, id: str) -> Block:
    (found,) = (block for block in blocks.blocks_of(seen(run)) if block.id == id)
    return found


def test_what_a_rule_has_ahead_is_planned_without_a_trial() -> None:
    run = Run(ruled_spec(), seed=5)
    joins, explored = block(run, CIRCLE), block(run, CIRCLING)
    assert (joins.state, joins.first, joins.trials, joins.by_rule) == ("planned", NEVER, 20, True)
    assert described(joins) == "circle clockwise joins, by its rule, selection frozen for 20 trials"
    assert (explored.state, explored.first, explored.trials) == ("planned", NEVER, 60)
    assert "for 60 trials once it joins" in described(explored)


def test_without_the_schedule_no_rule_acts() -> None:
    run = Run(ruled_spec(), seed=5)
    run.apply(FollowSchedule(on=False))
    assert block(run, CIRCLE).state == "idle"


def test_a_trial_by_hand_takes_the_place_of_the_rule() -> None:
    run = to(Run(ruled_spec(), seed=5), 2)
    for id in (CIRCLE, AVOID):
        skill = id.partition(":")[2]
        plan = changed(run.spec.schedule, id, now_of(seen(run)), at=30)
        assert plan.skills[skill].at == 30
        assert plan.rule_of(skill) is None
        run.apply(SetSchedule(plan))
        assert (block(run, id).first, block(run, id).by_hand) == (30, True)


def test_another_freeze_leaves_the_rule() -> None:
    run = Run(ruled_spec(), seed=5)
    plan = changed(run.spec.schedule, CIRCLE, now_of(seen(run)), trials=7)
    assert plan.skills["circle_clockwise"] == SkillTimer(freeze=7)
    assert plan.rule_of("circle_clockwise") == RULE


def test_an_exploration_can_be_planned_for_when_a_rule_is_met() -> None:
    run = Run(ruled_spec("schedule.episodes=[]"), seed=5)
    plan = with_episode(run.spec.schedule, "avoid", 5, 40, 0.5, now_of(seen(run)))
    assert plan.episodes[-1].at == "introduction"
    run.apply(SetSchedule(plan))
    assert block(run, "episode:0:avoid").state == "planned"


def test_a_preset_that_repeats_the_run_keeps_the_rule_for_what_has_not_joined() -> None:
    run = to(Run(ruled_spec(), seed=5), 2)
    spec, left_out = carried.preset_of(seen(run))
    assert spec.schedule.rule_of("circle_clockwise") == RULE
    assert spec.schedule.freeze_of("circle_clockwise") == 20
    assert [(e.skill, e.at) for e in spec.schedule.episodes if e.at == "introduction"] == [
        ("circle_clockwise", "introduction"),
        ("avoid", "introduction"),
    ]
    assert left_out == ()
    assert Run(spec, seed=5).planned()[-1].trial == NEVER


@pytest.fixture(scope="module")
def joined() -> Run:
    """A run in which both have joined by their rule, and which explores the second by context."""
    where = "where: {value_at_most: 1}"
    episodes = f"schedule.episodes=[{{skill: avoid, duration: 900, probability: 0.3, {where}}}]"
    run = Run(ruled_spec(episodes, "trials=3000"), seed=5)
    run.advance()
    assert len(run.present) == 3
    return run


def test_what_joined_by_a_rule_says_so(joined: Run) -> None:
    happened = [one for one in blocks.blocks_of(seen(joined)) if one.kind == "introduction"]
    assert [one.by_rule for one in happened] == [False, True, True]
    assert not any(one.by_hand for one in happened)
    *_, avoid = happened
    assert described(avoid).startswith(f"avoid joins at trial {avoid.first:,}, by its rule")
    (explored,) = [one for one in blocks.blocks_of(seen(joined)) if one.kind == "exploration"]
    assert (explored.first, explored.by_rule, explored.by_hand) == (avoid.first, False, False)
    assert described(explored) == (
        "avoid is explored in 30% of the steps where nothing else is worth more than 1, trials"
        f" {avoid.first:,} to {avoid.first + 899:,}, by the schedule"
    )


def test_a_rule_that_was_set_by_hand_is_said_to_be(joined: Run) -> None:
    run = Run(joined.preset, seed=5)
    rule = TriggerSpec(by="reach", window=5, below=100)
    run.apply(SetSchedule(run.spec.schedule.model_copy(update={"introduce": rule})))
    run.advance(until_trial=40)
    circle = [one for one in blocks.blocks_of(seen(run)) if one.kind == "introduction"][1]
    assert (circle.skill, circle.by_rule, circle.by_hand) == ("circle_clockwise", True, True)


def test_a_preset_that_repeats_the_run_has_the_trials_that_the_rule_found(joined: Run) -> None:
    spec, left_out = carried.preset_of(seen(joined))
    assert left_out == ()
    assert spec.schedule.introduce is None
    again = Run(presets.parse(presets.dump(spec), "mine.yaml"), seed=5)
    again.advance(until_trial=joined.trial)
    assert digest(again.state) == digest(joined.state)


@pytest.mark.parametrize("skill", ["circle_clockwise", "avoid"])
def test_a_rule_that_is_switched_off_is_not_repeated(skill: str) -> None:
    run = to(Run(ruled_spec(), seed=5), 2)
    run.apply(FollowSchedule(on=False))
    schedule, left_out = carried.schedule_of(seen(run))
    assert schedule.introduced_at(skill) == NEVER
    assert schedule.rule_of(skill) is None
    assert "What the schedule has ahead: it is not being followed." in left_out


def test_a_rule_takes_the_place_of_a_trial() -> None:
    run = to(Run(ruled_spec(), seed=5), 2)
    own = TriggerSpec(by="reach", window=30, below=0.5)
    for rule, kept in ((RULE, None), (own, own)):
        at_trial = changed(run.spec.schedule, CIRCLE, now_of(seen(run)), at=30)
        plan = changed(at_trial, CIRCLE, now_of(seen(run)), rule=rule, trials=9)
        assert plan.skills["circle_clockwise"] == SkillTimer(introduce=kept, freeze=9)
        assert plan.rule_of("circle_clockwise") == rule
        run.apply(SetSchedule(plan))


def test_a_skill_that_is_explored_at_a_trial_cannot_join_by_a_rule() -> None:
    run = to(small_run(), 2)
    plan = changed(run.spec.schedule, CIRCLING, now_of(seen(run)), at=150)
    with pytest.raises(ValueError, match="at trial 150, so it cannot join by a rule"):
        changed(plan, CIRCLE, now_of(seen(run)), rule=RULE)
