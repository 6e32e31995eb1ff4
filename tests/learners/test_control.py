"""What holds follows from the history alone, and undoing is leaving out."""

from collections.abc import Iterable
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.documents import presets
from learners.commands import (
    Author,
    Command,
    CommandError,
    DefineSkill,
    Event,
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
from learners.control import (
    Control,
    Effect,
    Join,
    Leave,
    MakeRoom,
    Return,
    apply,
    as_if,
    brought_by,
    evolve,
)
from learners.names import MAX_TRIALS
from learners.schedule_spec import EpisodeSpec, SkillTimer
from learners.skill_spec import SkillWeights

SPEC = presets.load(
    "timed",
    [
        "schedule.skills.circle_clockwise.at=1000000",
        "schedule.skills.avoid.at=1000000",
        "schedule.episodes=[{skill: avoid, duration: 30, probability: 0.3}]",
    ],
)
"""Of its three skills one joins by itself, and one of the others is explored as it joins."""
STEPS_OF_A_TRIAL = 100
NEW = "circle_counterclockwise"
"""A skill that the preset does not have."""


def event_of(
    control: Control, trial: int, command: Command, author: Author, cause: int | None = None
) -> Event:
    """An event at the start of a trial."""
    return Event(len(control.history), trial * STEPS_OF_A_TRIAL, trial, 0, command, author, cause)


class Told:
    """A control that is told commands by hand, and what they do to the tables."""

    def __init__(self) -> None:
        self.control = Control.at_start(SPEC)
        self.effects: list[Effect] = []
        self._give(0, Introduce("approach", 5), "schedule")
        self.control = replace(self.control, next_timer=1)

    def tell(self, trial: int, *commands: Command) -> int:
        """Give commands by hand; returns the number of the first."""
        number = len(self.control.history)
        for command in commands:
            self._give(trial, command, "hand")
        return number

    def takes(self, trial: int, command: Command) -> bool:
        """Give a command by hand; whether it was carried out."""
        try:
            self.tell(trial, command)
        except CommandError:
            return False
        return True

    def _give(self, trial: int, command: Command, author: Author) -> None:
        event = event_of(self.control, trial, command, author)
        self.control, effects = apply(self.control, event)
        self.effects.extend(effects)
        for brought in brought_by(self.control, command):
            event_brought = event_of(self.control, trial, brought, "schedule", event.number)
            self.control, _ = apply(self.control, event_brought)


def without_history(control: Control, trial: int) -> Control:
    """What holds in a trial, however it came to it."""
    return replace(control, history=(), episodes=control.running(trial))


SKILLS = ("approach", "circle_clockwise", "avoid")
PLANS = [
    SPEC.schedule,
    SPEC.schedule.model_copy(update={"safe_introduction": False}),
    SPEC.schedule.model_copy(
        update={"episodes": (EpisodeSpec(skill="approach", at=900, duration=9, probability=1.0),)}
    ),
]
commands = st.one_of(
    st.builds(Introduce, st.sampled_from(SKILLS), st.sampled_from([0, 3, 40])),
    st.builds(Explore, st.sampled_from(SKILLS), st.sampled_from([2, 60]), st.sampled_from([0, 1])),
    st.builds(StopExploring, st.sampled_from(SKILLS)),
    # The first skill stays: a removal that another skill made possible outlasts its undoing.
    st.builds(Remove, st.sampled_from(SKILLS[1:])),
    st.builds(FreezeSelection, st.booleans()),
    st.builds(FreezeSkills, st.booleans()),
    st.builds(Teach, st.just("flank"), st.sampled_from([2, 60])),
    st.just(StopTeaching()),
    st.builds(SetParameter, st.just("learner.alpha"), st.sampled_from([0.2, 0.4])),
    st.builds(SetSchedule, st.sampled_from(PLANS)),
)
scripts = st.lists(st.tuples(st.integers(0, 20), commands | st.integers(0, 4)), max_size=25)
"""Trials to wait and then a command, or how many that could be undone are passed over for one."""


def run_through(script: Iterable[tuple[int, Command | int]]) -> tuple[Told, int]:
    """Give all that is not refused; returns the trial of the last as well."""
    told, trial = Told(), 0
    for wait, wish in script:
        trial += wait
        if isinstance(wish, int):
            given = [e.number for e in told.control.history if e.author == "hand" and not e.undone]
            wish = Undo(given[-1 - wish] if wish < len(given) else -1)
        told.takes(trial, wish)
    return told, trial


@settings(max_examples=300)
@given(script=scripts)
def test_what_is_undone_is_as_if_it_had_not_been_given(
    script: list[tuple[int, Command | int]],
) -> None:
    told, trial = run_through(script)
    history = told.control.history
    other = Told()
    for event in history:
        if event.author == "hand" and not event.undone and not isinstance(event.command, Undo):
            # What is about a skill that is not there falls away.
            other.takes(event.trial, event.command)
    ours, theirs = without_history(told.control, trial), without_history(other.control, trial)
    if any(isinstance(event.command, SetSchedule) and event.undone for event in history):
        # What a plan brought stays, and what another would have brought is not made up for.
        ours, theirs = replace(ours, episodes=()), replace(theirs, episodes=())
    assert ours == theirs


@settings(max_examples=300)
@given(script=scripts)
def test_what_holds_is_what_the_history_comes_to(script: list[tuple[int, Command | int]]) -> None:
    told, trial = run_through(script)
    again = replace(Control.at_start(SPEC), next_timer=told.control.next_timer)
    for event in told.control.history:
        again = evolve(again, replace(event, undone=False))
    assert again == told.control
    again = as_if(told.control, told.control.history, trial)
    assert without_history(again, trial) == without_history(told.control, trial)


@settings(max_examples=300)
@given(script=scripts)
def test_effects_keep_the_tables_to_what_holds(script: list[tuple[int, Command | int]]) -> None:
    told, _ = run_through(script)
    columns: dict[str, bool] = dict.fromkeys(SPEC.learner.skills, False)
    for effect in told.effects:
        match effect:
            case MakeRoom(skill=skill):
                assert skill not in columns
                columns[skill] = False
            case Join(skill=skill) | Return(skill=skill):
                assert not columns[skill]
                columns[skill] = True
            case Leave(skill=skill):
                assert columns[skill]
                columns[skill] = False
    assert tuple(columns) == told.control.spec.learner.skills
    assert tuple(skill for skill in columns if columns[skill]) == told.control.present


def test_a_command_that_is_refused_says_so_and_a_reducer_changes_nothing() -> None:
    told = Told()
    before = told.control
    with pytest.raises(CommandError, match="has not joined"):
        told.tell(5, Explore("avoid", 5, 0.5))
    assert told.control is before


def test_a_skill_that_returns_gets_the_values_that_its_removal_keeps() -> None:
    told = Told()
    told.tell(10, Introduce("circle_clockwise", 0))
    removal = told.tell(20, Remove("circle_clockwise"))
    told.tell(30, Undo(removal))
    assert told.effects[-2:] == [
        Leave("circle_clockwise"),
        Return("circle_clockwise", removal),
    ]


def test_what_the_schedule_brought_falls_away_with_what_brought_it() -> None:
    told = Told()
    told.tell(10, Introduce("avoid", 0))
    removal = told.tell(20, Remove("avoid"))
    again = told.tell(30, Introduce("avoid", 0))
    told.tell(40, Undo(again), Undo(removal))
    # The exploration of the first introduction would be over, that of the second never was.
    assert told.control.running(40) == ()
    assert [e.cause for e in told.control.history if isinstance(e.command, Explore)] == [1, 4]


def test_an_exploration_by_hand_outlasts_the_undoing_of_another_introduction() -> None:
    told = Told()
    told.tell(10, Introduce("circle_clockwise", 0))
    removal = told.tell(20, Remove("circle_clockwise"))
    again = told.tell(30, Introduce("circle_clockwise", 0))
    told.tell(35, Explore("circle_clockwise", 100, 0.5))
    told.tell(40, Undo(again))
    assert told.control.running(40) == ()
    told.tell(45, Undo(removal))
    (episode,) = told.control.running(45)
    assert episode.until_trial == 135


def test_the_same_exploration_given_twice_can_be_undone_twice() -> None:
    told = Told()
    first = told.tell(10, Explore("approach", 50, 0.5))
    second = told.tell(10, Explore("approach", 50, 0.5))
    told.tell(12, Undo(second))
    assert len(told.control.episodes) == 1
    told.tell(14, Undo(first))
    assert told.control.episodes == ()


def test_room_in_the_tables_outlasts_the_undoing_of_what_made_it() -> None:
    told = Told()
    told.tell(5, DefineSkill("sneak", SkillWeights(approach=1.0)))
    first = told.tell(10, Introduce(NEW, 0))
    told.tell(10, Introduce("sneak", 0), Undo(first))
    skills = (*SPEC.learner.skills, NEW, "sneak")
    assert told.control.spec.learner.skills == skills, "columns stay in their places"
    assert told.control.spec.schedule.skills[NEW] == SkillTimer(at=MAX_TRIALS)
    assert told.control.present == ("approach", "sneak")
    assert told.effects[-5:] == [
        MakeRoom(NEW),
        Join(NEW),
        MakeRoom("sneak"),
        Join("sneak"),
        Leave(NEW),
    ]
    told.tell(20, Introduce(NEW, 0))
    assert told.effects[-1] == Join(NEW)


def test_a_removal_that_another_skill_made_possible_outlasts_its_undoing() -> None:
    told = Told()
    added = told.tell(10, Introduce("avoid", 0))
    told.tell(20, Remove("approach"))
    with pytest.raises(CommandError, match="avoid is the only skill"):
        told.tell(25, Undo(added))
    told.tell(30, Introduce("circle_clockwise", 0), Undo(added))
    assert told.control.present == ("circle_clockwise",)


def test_what_the_schedule_did_cannot_be_undone() -> None:
    told = Told()
    with pytest.raises(CommandError, match="nothing was done by hand under the number 0"):
        told.tell(5, Undo(0))


def test_following_the_schedule_again_makes_up_for_nothing() -> None:
    told = Told()
    off = told.tell(5, FollowSchedule(False))
    told.tell(10, Introduce("avoid", 0), Undo(off))
    assert told.control.schedule_on
    assert told.control.episodes == ()
