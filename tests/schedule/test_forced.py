"""What the learner is made to do is told as long as it lasts."""

from app.documents import presets
from app.live import snapshot
from app.schedule.forced import Forced, forced_now
from learners.commands import Explore, StopExploring
from learners.run import Run

SMALL = ("world.size=30", "schedule.skills.circle_clockwise={at: 20, freeze: 5}")
EPISODES = "schedule.episodes=[{skill: circle_clockwise, duration: 30, probability: 0.95}]"
CIRCLING = Forced("circle_clockwise", 0.95, 50, value_at_most=None)


def forced(run: Run) -> list[Forced]:
    return forced_now(snapshot.take(run, "timed", 0))


def test_exploration_is_told_from_its_first_trial_to_its_last_the_newest_first() -> None:
    run = Run(presets.load("timed", [*SMALL, EPISODES]), 3)
    run.advance(until_trial=20)
    assert forced(run) == [], "trial 20 has not begun"
    run.advance(max_steps=1)
    assert forced(run) == [CIRCLING]
    run.apply(Explore("approach", 10, 0.5))
    assert forced(run) == [("approach", 0.5, 30, None), CIRCLING]
    run.advance(until_trial=30)
    assert forced(run) == [CIRCLING]
    run.advance(until_trial=50)
    assert forced(run) == []


def test_where_it_acts_is_told() -> None:
    run = Run(presets.load("timed", ["world.size=30"]), 3)
    run.apply(Explore("approach", 10, 0.5, value_at_most=-2))
    assert forced(run) == [Forced("approach", 0.5, 10, value_at_most=-2)]


def test_what_is_stopped_is_told_no_more() -> None:
    run = Run(presets.load("timed", ["world.size=30"]), 3)
    run.apply(Explore("approach", 10, 0.5))
    run.apply(StopExploring("approach"))
    assert forced(run) == []
