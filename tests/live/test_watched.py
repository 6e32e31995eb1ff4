"""What rules watched along a run, as far as it is drawn."""

import numpy as np
import pytest

from app.live.watched import MOST_POINTS, NEVER, Watched, watched_along
from learners.commands import FollowSchedule, Introduce, SetSchedule, Undo
from learners.run import Run
from learners.schedule_spec import TriggerSpec
from learners.triggers.watch import outlook, watch_for
from tests.support.schedules import RULE, ruled_spec, small_run, to


def ruled_run(*settings: str) -> Run:
    """Skills join in trials 436 and 874."""
    return Run(ruled_spec("trials=2000", *settings), seed=5)


def assert_same(one: Watched, other: Watched) -> None:
    assert one[:4] == other[:4]
    for mine, others in zip(one[4:], other[4:], strict=True):
        np.testing.assert_array_equal(mine, others)


def test_a_run_without_rules_watches_nothing() -> None:
    assert watched_along(to(small_run(), 300)) == ()


def test_each_stretch_ends_where_its_skill_joined_and_the_next_begins_after_the_freeze() -> None:
    circle, avoid = watched_along(to(ruled_run(), 1_000))
    assert (circle.skill, circle.since, circle.until) == ("circle_clockwise", 10, 436)
    assert (avoid.skill, avoid.since, avoid.until) == ("avoid", 456, 874)
    for one in (circle, avoid):
        assert one.rule == RULE
        assert one.trials[-1] == one.until
        assert one.values[-1] < RULE.below <= one.values[:-1].min()
        assert one.fires[-1] == one.until


def test_values_are_means_of_the_log_over_the_window() -> None:
    run = to(ruled_run(), 400)
    (circle,) = watched_along(run)
    assert circle.until is None
    assert (circle.trials[0], circle.trials[-1]) == (60, 400)
    for trial, value in zip(circle.trials.tolist(), circle.values.tolist(), strict=True):
        assert value == run.state.log_new_states[trial - RULE.window : trial].mean()


def test_each_place_has_the_outlook_that_was_known_there() -> None:
    (circle,) = watched_along(to(ruled_run(), 400))
    rerun = ruled_run()
    for trial, fires in list(zip(circle.trials.tolist(), circle.fires.tolist(), strict=True))[::9]:
        known = outlook(to(rerun, trial).state, watch_for(RULE, circle.since))
        assert fires == (NEVER if known is None else known)


def test_what_was_found_earlier_makes_no_difference() -> None:
    run = ruled_run()
    former: tuple[Watched, ...] = ()
    for trial in (5, 70, 71, 300, 436, 437, 900):
        former = watched_along(to(run, trial), former)
        anew = watched_along(run)
        assert len(former) == len(anew)
        for one, other in zip(former, anew, strict=True):
            assert_same(one, other)


def test_of_many_places_some_are_drawn_and_always_the_newest() -> None:
    run = to(ruled_run("schedule.introduce={by: novelty, window: 50, below: 0}"), 1_801)
    (circle,) = watched_along(run)
    assert MOST_POINTS / 2 <= circle.trials.size <= MOST_POINTS + 1
    assert circle.trials[-1] == 1_801
    assert np.unique(np.diff(circle.trials[:-1])).tolist() == [16]


def test_by_hand_a_skill_can_be_earlier_and_the_rule_goes_on_from_there() -> None:
    run = to(ruled_run(), 200)
    run.apply(Introduce("circle_clockwise", 30))
    circle, avoid = watched_along(to(run, 250))
    assert (circle.until, circle.trials[-1]) == (200, 200)
    assert circle.values[-1] >= RULE.below
    assert (avoid.skill, avoid.since, avoid.until, avoid.trials.size) == ("avoid", 230, None, 0)
    run.apply(Undo(run.control.history[-1].number - 1))
    (again,) = watched_along(to(run, 260))
    assert (again.skill, again.since, again.until, again.trials[-1]) == (
        "circle_clockwise",
        10,
        None,
        260,
    )


def test_while_the_schedule_is_off_no_rule_is_waited_for() -> None:
    run = to(ruled_run(), 200)
    run.apply(FollowSchedule(on=False))
    (circle,) = watched_along(to(run, 250))
    assert (circle.until, circle.trials[-1]) == (200, 200)


@pytest.mark.parametrize("by", ["reach", "change"])
def test_another_rule_is_another_stretch(by: str) -> None:
    run = to(ruled_run(), 200)
    other = TriggerSpec.model_validate({"by": by, "window": 40, "below": 0})
    run.apply(SetSchedule(run.spec.schedule.model_copy(update={"introduce": other})))
    novelty, later = watched_along(to(run, 250))
    assert (novelty.rule, novelty.until) == (RULE, 200)
    assert (later.rule, later.since, later.until) == (other, 10, None)
    assert later.trials[0] == 50
