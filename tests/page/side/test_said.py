"""What is said of one run among others."""

from app.page.side.said import under_way
from learners.commands import Explore, FollowSchedule, Introduce, Teach
from learners.run import Run
from tests.support.schedules import ruled_spec, seen, small_run, to


def test_what_is_done_to_a_run_is_said_and_else_what_a_rule_waits_for() -> None:
    run = to(Run(ruled_spec("schedule.episodes=[]"), seed=5), 30)
    said = "Circle clockwise joins below 0.2: known from trial 60 on"
    assert under_way(seen(run), is_now=True) == said
    to(run, 120)
    assert " now; at this rate at trial " in under_way(seen(run), is_now=True)
    assert " then; at that rate at trial " in under_way(seen(run), is_now=False)
    run.apply(Introduce("circle_clockwise", 0))
    run.apply(Explore("circle_clockwise", 50, 0.9, 1.0))
    explored = "Explored: circle clockwise 90% where worth at most 1"
    assert under_way(seen(run), is_now=True) == explored
    run.apply(Introduce("avoid", 0))
    run.apply(Teach("flank", 30))
    assert under_way(seen(run), is_now=True) == "Taught until trial 150"


def test_of_a_run_that_is_left_alone_nothing_is_said() -> None:
    assert under_way(seen(to(small_run(), 30)), is_now=True) == ""
    run = to(Run(ruled_spec(), seed=5), 120)
    run.apply(FollowSchedule(False))
    assert under_way(seen(run), is_now=True) == ""
