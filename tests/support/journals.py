"""Records as a session might write them down, for tests of what is made of files of them."""

from hypothesis import strategies as st

from app.live.records import (
    Began,
    Branched,
    BroughtBack,
    Deleted,
    Gave,
    Marked,
    NamedLine,
    Record,
    Stood,
    Unmarked,
    WentLive,
)
from app.live.story import (
    Act,
    Answered,
    Committed,
    Hinted,
    LeftLesson,
    LongText,
    Passed,
    Revealed,
    Spoke,
    TookLesson,
    WentToCard,
)
from app.live.written import Header
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
    StopTeaching,
    Teach,
    Undo,
)
from learners.skill_spec import SkillWeights
from sim.rng import MAX_SEED
from tests.support.schedules import small_spec

HEADER = Header("1.2.3", "timed, my own", 5, "2026-11-29T15:00:00+00:00")
SPEC = small_spec()

COMMANDS: tuple[Command, ...] = (
    Introduce("avoid", 300),
    Explore("avoid", 2_000, 0.3),
    Explore("avoid", 2_000, 0.3, value_at_most=-1.5),
    StopExploring("avoid"),
    Teach("flank", 300),
    StopTeaching(),
    FreezeSelection(True),
    FreezeSkills(False),
    FollowSchedule(False),
    DefineSkill("spiral_in", SkillWeights(approach=0.5, avoid=-0.1)),
    Remove("avoid"),
    SetParameter("learner.epsilon", 0.1 + 0.2),
    SetSchedule(SPEC.schedule),
    Undo(3),
)
RECORDS: tuple[Record, ...] = (
    Began(0, "timed", SPEC, MAX_SEED),
    *(Gave(0, 100 * place, command) for place, command in enumerate(COMMANDS)),
    Branched(1, 0, 500, COMMANDS),
    Branched(2, 0, 500, (Undo(0),), instead_of=1),
    NamedLine(2, "früher, „avoid“\n\x00\u2028"),
    WentLive(2),
    Stood(2, 700, 12, "ab" * 32, 500),
    WentLive(0, 300),
    Deleted(2),
    BroughtBack(2),
    Marked(0, 2, 600, 11, '{"kind":"gave"}'),
    Unmarked(0),
    TookLesson(
        2, "cone", "cone.yaml", "ab" * 32, LongText("title: ü\n" * 900), "en", 9, True, False
    ),
    WentToCard(1, 2, 700, 12, 3, True),
    Answered("where", '["w","nw"]'),
    Committed("where", None),
    Committed("where", 90),
    Revealed("where", LongText('["w"]'), None),
    Revealed("where", LongText('["w"]'), False),
    Passed(1),
    Hinted(1),
    Spoke("de"),
    LeftLesson(),
)

_numbers = st.integers(0, MAX_SEED)
_texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=80)


def acts(numbers: st.SearchStrategy[int], texts: st.SearchStrategy[str]) -> st.SearchStrategy[Act]:
    """Anything that may be done in a lesson; it need not make sense there."""
    return st.one_of(
        st.builds(
            WentToCard,
            card=numbers,
            run=numbers,
            step=numbers,
            trial=numbers,
            events=numbers,
            is_again=st.booleans(),
        ),
        st.builds(Answered, question=texts, value=texts),
        st.builds(Committed, question=texts, confidence=st.none() | numbers),
        st.builds(
            Revealed, question=texts, value=texts, is_within=st.sampled_from([None, True, False])
        ),
        st.builds(Passed, card=numbers),
        st.builds(Hinted, card=numbers),
        st.builds(Spoke, language=texts),
    )


def records() -> st.SearchStrategy[Record]:
    """Any record there may be; what they say need not go together."""
    commands = st.sampled_from(COMMANDS)
    return st.one_of(
        st.builds(Began, run=_numbers, preset=_texts, spec=st.just(SPEC), seed=_numbers),
        st.builds(Gave, run=_numbers, step=_numbers, command=commands),
        st.builds(
            Branched,
            run=_numbers,
            parent=_numbers,
            step=_numbers,
            commands=st.lists(commands, max_size=3).map(tuple),
            instead_of=st.none() | _numbers,
        ),
        st.builds(WentLive, run=_numbers, step=st.none() | _numbers),
        st.builds(
            Stood,
            run=_numbers,
            step=_numbers,
            trial=_numbers,
            digest=_texts,
            until_trial=_numbers,
        ),
        st.builds(NamedLine, run=_numbers, name=_texts),
        st.builds(Deleted, run=_numbers),
        st.builds(BroughtBack, run=_numbers),
        st.builds(
            Marked, number=_numbers, run=_numbers, step=_numbers, trial=_numbers, text=_texts
        ),
        st.builds(Unmarked, number=_numbers),
        st.builds(
            TookLesson,
            run=_numbers,
            name=_texts,
            source=_texts,
            digest=_texts,
            text=st.text(st.characters(exclude_categories=["Cs"]), max_size=2_000),
            language=_texts,
            start=_numbers,
            follows=st.booleans(),
            is_anew=st.booleans(),
        ),
        acts(_numbers, _texts),
        st.just(LeftLesson()),
    )
