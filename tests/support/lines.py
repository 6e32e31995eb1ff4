"""Lines of a session that are made up: what is done on them at random, and how they stand."""

from collections.abc import Iterable
from typing import Any

from hypothesis import strategies as st

from app.documents import presets
from app.live.past import Past
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
from learners.run import Run
from learners.schedule_spec import SkillTimer
from learners.skill_spec import SkillWeights

SPEC = presets.load(
    "timed",
    [
        "world.size=30",
        "world.n_directions=16",
        "world.n_distances=6",
        "world.step_limit=60",
        "schedule.skills.approach.freeze=2",
        "schedule.skills.circle_clockwise.at=20",
        "schedule.skills.circle_clockwise.freeze=5",
        "schedule.skills.avoid.at=45",
        "schedule.skills.avoid.freeze=5",
        "schedule.episodes=[{skill: circle_clockwise, duration: 30, probability: 0.95},"
        " {skill: avoid, duration: 15, probability: 0.3}]",
        "trials=100",
    ],
)
"""The standard schedule in a small world, some hundred times as fast."""
SEED = 5
SKILLS = ("approach", "circle_clockwise", "avoid")
NEW = "sneak"
"""A skill that somebody defines."""


def _plan(avoid: int) -> SetSchedule:
    timers = SPEC.schedule.skills | {"avoid": SkillTimer(at=avoid, freeze=3)}
    return SetSchedule(SPEC.schedule.model_copy(update={"skills": timers}))


commands = st.one_of(
    st.builds(Introduce, st.sampled_from((*SKILLS, NEW)), st.sampled_from([0, 3])),
    st.builds(
        Explore, st.sampled_from(SKILLS), st.sampled_from([2, 30]), st.sampled_from([0.0, 0.5])
    ),
    st.builds(StopExploring, st.sampled_from(SKILLS)),
    st.builds(Remove, st.sampled_from((*SKILLS[1:], NEW))),
    st.builds(FreezeSelection, st.booleans()),
    st.builds(FreezeSkills, st.booleans()),
    st.builds(Teach, st.just("flank"), st.sampled_from([2, 30])),
    st.just(StopTeaching()),
    st.builds(FollowSchedule, st.booleans()),
    st.builds(SetParameter, st.just("learner.alpha"), st.sampled_from([0.2, 0.4])),
    st.builds(SetParameter, st.just("world.vision_radius"), st.sampled_from([3.0, 6.0])),
    st.builds(SetParameter, st.just("world.capture_reward"), st.sampled_from([50.0, 80.0])),
    st.builds(_plan, st.sampled_from([30, 60, 90])),
    st.just(DefineSkill(NEW, SkillWeights(approach=0.5, circle_clockwise=1.0))),
)
Wish = Command | int
"""A command, or how many that could be undone are passed over for one that is."""
Script = list[tuple[int, Wish]]
"""Steps that are made, and what is wished then."""
scripts: st.SearchStrategy[Script] = st.lists(
    st.tuples(st.sampled_from([0, 0, 1, 40, 333, 900]), commands | st.integers(0, 3)), max_size=14
)


def tell(run: Run, wish: Wish) -> None:
    """Give a command as a session does; what is refused changes nothing."""
    if isinstance(wish, int):
        given = [e.number for e in run.control.history if e.author == "hand" and not e.undone]
        wish = Undo(given[-1 - wish] if wish < len(given) else -1)
    try:
        run.apply(wish, replacing=True)
    except CommandError:
        return


def play(run: Run, past: Past, script: Iterable[tuple[int, Wish]], rest: int = 0) -> None:
    """Let a line go on as a script has it, and some steps more; its past is told of all."""
    for steps, wish in script:
        run.advance(max_steps=steps)
        past.note(run)
        tell(run, wish)
        past.note(run)
    run.advance(max_steps=rest)
    past.note(run)


def stands(run: Run) -> dict[str, Any]:
    """All that a run is at a moment, so that two are equal if they are the same."""
    state = run.state._asdict()
    arrays = {
        name: (array[: run.trial] if name.startswith("log_") else array).tobytes()
        for name, array in state.items()
    }
    kept = [
        None if event.taken_out is None else event.taken_out.tobytes()
        for event in run.control.history
    ]
    return {**arrays, "control": run.control, "planned": run.planned(), "taken out": kept}
