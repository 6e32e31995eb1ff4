"""A schedule a hundred times as fast as the thesis's, and what people do to its runs."""

from hypothesis import strategies as st

from app.documents import presets
from app.live import snapshot
from app.live.snapshot import Snapshot
from learners.commands import (
    Command,
    CommandError,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Remove,
    SetParameter,
    StopExploring,
    Undo,
)
from learners.run import Run
from learners.schedule_spec import TriggerSpec
from learners.spec import RunSpec

SMALL = (
    "world.size=30",
    "world.n_directions=16",
    "world.n_distances=6",
    "world.step_limit=40",
    "trials=500",
    "schedule.skills.approach.freeze=10",
    "schedule.skills.circle_clockwise={at: 100, freeze: 20}",
    "schedule.skills.avoid={at: 200, freeze: 20}",
    "schedule.episodes=[{skill: circle_clockwise, duration: 60, probability: 0.95},"
    " {skill: avoid, duration: 50, probability: 0.3},"
    " {skill: approach, at: 300, duration: 40, probability: 0.5}]",
)
"""The standard schedule, a hundred times as fast, and an exploration at a trial of its own."""

CIRCLE, AVOID = "introduction:circle_clockwise", "introduction:avoid"
CIRCLING, AVOIDING, APPROACHING = (
    "episode:0:circle_clockwise",
    "episode:1:avoid",
    "episode:2:approach",
)


def small_spec(*settings: str) -> RunSpec:
    """The preset, with some settings changed."""
    return presets.load("timed", [*SMALL, *settings])


def small_run(*settings: str) -> Run:
    """A run of it that is about to begin."""
    return Run(small_spec(*settings), seed=5)


RULE = TriggerSpec(by="novelty", window=50, below=0.2)


def ruled_spec(*settings: str) -> RunSpec:
    """The small schedule, but circle clockwise and avoid join by a rule."""
    timers = [
        "schedule.introduce={by: novelty, window: 50, below: 0.2}",
        "schedule.skills={approach: {at: 0, freeze: 10}, circle_clockwise: {freeze: 20}}",
    ]
    rest = [setting for setting in SMALL if not setting.startswith("schedule.skills")]
    return presets.load("hierarchical_3", [*rest, *timers, *settings])


def to(run: Run, trial: int) -> Run:
    """The run once it has come to a trial."""
    run.advance(until_trial=trial)
    return run


def seen(run: Run) -> Snapshot:
    """The moment that it is at."""
    return snapshot.take(run, "timed", 0)


SKILLS = ("approach", "avoid", "circle_clockwise", "circle_counterclockwise")

commands: st.SearchStrategy[Command] = st.one_of(
    st.builds(Introduce, st.sampled_from(SKILLS), st.integers(0, 30)),
    st.builds(Explore, st.sampled_from(SKILLS), st.integers(0, 60), st.floats(0, 1)),
    st.builds(StopExploring, st.sampled_from(SKILLS)),
    st.builds(FreezeSelection, st.booleans()),
    st.builds(FreezeSkills, st.booleans()),
    st.builds(FollowSchedule, st.booleans()),
    st.builds(Remove, st.sampled_from(SKILLS)),
    st.builds(SetParameter, st.just("learner.epsilon"), st.floats(0, 1)),
    st.builds(Undo, st.integers(0, 20)),
)


def driven(run: Run, script: list[tuple[int, Command]]) -> Run:
    """Make steps and give commands, leaving out what is refused."""
    for steps, command in script:
        run.advance(max_steps=steps)
        try:
            run.apply(command)
        except CommandError:
            continue
    return run
