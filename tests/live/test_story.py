"""Where somebody is in a lesson: whatever is done, it holds together; and a session keeps it."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.live.journal import Journal
from app.live.made_again import made_again
from app.live.past import Budget
from app.live.places import Place
from app.live.replayed import replayed
from app.live.requests import GoBack, LeaveLesson, RunTo, StartAgain, Tell, TrialOnce
from app.live.session import Session
from app.live.story import (
    MOST_CARDS,
    MOST_CHARACTERS,
    MOST_HINTS,
    MOST_STORIES,
    Act,
    Answered,
    Began,
    Committed,
    Given,
    Hinted,
    LeftLesson,
    LongText,
    Passed,
    Revealed,
    Stories,
    Story,
    TookLesson,
    WentToCard,
    after,
)
from app.live.worker import FULL_SPEED
from app.live.written import read
from learners.kernel.state import digest
from learners.run import replay
from tests.support.journals import HEADER, acts
from tests.support.lines import SEED, SPEC
from tests.support.sessions import settle, taking


def took(name: str = "cone", digest: str = "1", is_anew: bool = False) -> TookLesson:
    text = LongText("title: Cone\n")
    return TookLesson(0, name, f"{name}.yaml", digest, text, "en", 0, True, is_anew)


def told(*many: Act) -> Story:
    story = Story(took())
    for act in many:
        story = after(story, act)
    return story


some_acts = acts(st.integers(-2, 45), st.sampled_from(["a", "b", ""]))


@given(st.lists(some_acts, max_size=40))
def test_any_sequence_of_acts_leaves_a_story_that_holds_together(many: Sequence[Act]) -> None:
    story = Story(took())
    for act in many:
        before, story = story, after(story, act)
        for question, was in before.answers.items():
            now = story.answers[question]
            if was.locked:
                assert (now.value, now.confidence, now.locked) == (was.value, was.confidence, True)
            if was.shown is not None:
                assert now == was
        assert before.furthest <= story.furthest <= before.furthest + 1
    assert 0 <= story.card <= story.furthest < MOST_CARDS
    assert set(story.began) <= set(range(story.furthest + 1))
    assert all(0 <= card <= story.furthest for card in (*story.passed, *story.hints))
    assert all(1 <= n <= MOST_HINTS for n in story.hints.values())
    assert all(one.locked for one in story.answers.values() if one.shown is not None)


def test_one_goes_to_the_next_card_and_to_those_before_and_no_farther() -> None:
    assert told(WentToCard(2)).card == 0
    story = told(WentToCard(0, 4, 10, 1, 2), WentToCard(1, 4, 90, 3, 2), WentToCard(0, 4, 99, 9, 2))
    assert (story.card, story.furthest) == (0, 1)
    assert story.began == {0: Began(Place(4, 10), 1, 2), 1: Began(Place(4, 90), 3, 2)}


def test_a_card_that_is_begun_again_is_not_passed_any_more() -> None:
    story = told(WentToCard(0, 4, 10, 1, 2), Passed(0), WentToCard(0, 5, 8, 1, 3, is_again=True))
    assert story.passed == frozenset()
    assert story.began == {0: Began(Place(5, 8), 1, 3)}


def test_an_answer_can_be_changed_until_it_is_committed() -> None:
    assert told(Committed("a", 90)).answers == {}
    story = told(Answered("a", "1"), Answered("a", "2"), Committed("a", 70), Answered("a", "3"))
    assert story.answers == {"a": Given("2", 70, locked=True)}
    assert after(story, Committed("a", 90)) is story
    assert told(Answered("a", "1"), Revealed("a", LongText("1"), True)).answers["a"].shown is None
    shown = after(story, Revealed("a", LongText("5"), False))
    assert shown.answers == {"a": Given("2", 70, locked=True, shown="5", is_within=False)}


def test_a_lesson_is_gone_on_with_unless_its_text_is_another_or_it_is_to_be_anew() -> None:
    stories = Stories()
    for record in (took(), WentToCard(0), WentToCard(1), LeftLesson(), Hinted(1), took("ring")):
        stories = stories.after(record)
    assert stories.on is not None
    assert (stories.on.name, stories.on.card) == ("ring", 0)
    again = stories.after(took()).on
    assert again is not None
    assert (again.name, again.card, again.hints) == ("cone", 1, {})
    for other in (took(digest="2"), took(is_anew=True)):
        anew = stories.after(other).on
        assert anew is not None
        assert (anew.card, anew.furthest) == (0, 0)


def test_so_many_lessons_are_kept_the_latest() -> None:
    stories = Stories()
    for number in range(MOST_STORIES + 3):
        stories = stories.after(took(f"lesson {number}"))
    assert len(stories.kept) == MOST_STORIES
    assert stories.of("lesson 2") is None
    assert stories.of("lesson 3") is not None


# --- In a session ---------------------------------------------------------------------------------


@pytest.fixture
def session() -> Iterator[Session]:
    session = Session(SPEC, "timed", SEED, FULL_SPEED, False)
    session.start()
    yield session
    session.stop()


def ask(session: Session, *many: object) -> list[str]:
    refused: list[str] = []
    for request in many:
        session.submit(request, refused.append)  # pyright: ignore[reportArgumentType]
    settle(session)
    return refused


def story_of(session: Session) -> Story:
    story = session.status.story
    assert story is not None
    return story


def test_a_lesson_brings_its_run_to_where_it_begins_and_back_takes_up_what_was_before(
    session: Session,
) -> None:
    assert ask(session, TrialOnce(), taking("cone", 9, 12)) == []
    status = session.status
    assert (status.snapshot.trial, status.snapshot.seed, status.playing) == (12, 9, False)
    assert digest(session._tree.family.held.run.state) == digest(
        replay(SPEC, 9, [], status.snapshot.step).state
    )
    assert status.aside == "timed, trial 1"
    assert ask(session, GoBack()) == []
    assert session.status.snapshot.seed == SEED
    assert story_of(session).took.run not in {line.number for line in session.status.lines}


def test_a_lesson_that_is_taken_again_is_at_the_same_card_with_the_same_run(
    session: Session,
) -> None:
    ask(session, taking("cone", 9, 12), Tell(WentToCard(0), "cone"), Tell(WentToCard(1), "cone"))
    ask(session, RunTo(20))
    was = session.status.snapshot
    begin = StartAgain(SPEC, "timed", 3, paused=True)
    # Of runs that were set aside only the latest is kept, but a lesson's own is kept with it.
    ask(session, LeaveLesson(), begin, TrialOnce(), begin, TrialOnce(), taking("ring", 7, 3))
    assert session.status.snapshot.seed == 7
    assert ask(session, taking("cone", 9, 12)) == []
    now = session.status.snapshot
    assert (now.generation, now.step, now.trial) == (was.generation, was.step, was.trial)
    assert (story_of(session).name, story_of(session).card) == ("cone", 1)
    assert ask(session, taking("cone", 9, 12, is_anew=True)) == []
    assert (session.status.snapshot.trial, story_of(session).card) == (12, 0)


def test_what_is_told_of_a_lesson_that_is_not_on_or_is_too_long_is_refused(
    session: Session,
) -> None:
    assert ask(session, Tell(Hinted(0), "cone")) == ["that lesson is not on any more"]
    ask(session, taking("cone", 9, 1))
    assert ask(session, Tell(Hinted(0), "ring")) == ["that lesson is not on any more"]
    long = "1" * (MOST_CHARACTERS + 1)
    assert ask(session, Tell(Answered("a", long), "cone")) == ["value has at most 1,000 characters"]
    assert ask(session, Tell(WentToCard(0), "cone"), Tell(Hinted(0), "cone")) == []
    snapshot = session.status.snapshot
    assert story_of(session).began[0].place == Place(snapshot.generation, snapshot.step)
    assert story_of(session).began[0].trial == snapshot.trial == 1


def test_a_lesson_is_at_the_same_card_after_a_restart(tmp_path: Path) -> None:
    path = tmp_path / "one.pounce"
    journal = Journal(path, HEADER)
    session = Session(SPEC, "timed", SEED, FULL_SPEED, False, journal=journal)
    session.start()
    ask(session, taking("cone", 9, 12), Tell(WentToCard(0), "cone"), Tell(WentToCard(1), "cone"))
    ask(session, RunTo(15), Tell(Answered("a", "1"), "cone"), Tell(Committed("a", 90), "cone"))
    ask(session, Tell(WentToCard(2), "cone"))
    left, stood = session.status.stories, session.status.snapshot
    session.stop()
    found = read(path)
    assert replayed(found.records).is_same
    remade = made_again(found, Budget(), lambda *_: "branch")
    session = Session(
        SPEC,
        "timed",
        SEED,
        FULL_SPEED,
        False,
        journal=Journal.going_on(found),
        made_again=remade.made,
    )
    session.start()
    settle(session)
    status = session.status
    assert status.stories == left
    assert (status.snapshot.step, status.playing) == (stood.step, False)
    assert ask(session, LeaveLesson(), taking("cone", 9, 12)) == []
    assert story_of(session).card == 2
    assert session.status.snapshot.step == stood.step
    session.stop()
    assert made_again(read(path), Budget(), lambda *_: "branch").made.stories.is_on
