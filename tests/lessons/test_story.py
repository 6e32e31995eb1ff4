"""What a lesson makes of where somebody is in it: controls, what may be done, what is told."""

import pytest

from app.lessons.story import (
    Sureness,
    has,
    is_done,
    layers_of,
    may_go_on,
    open_guesses,
    revealed_on,
    shown,
    sound,
    sureness,
    sureness_in_words,
)
from app.lessons.words import IN_ENGLISH
from app.live.story import (
    Act,
    Answered,
    Committed,
    LongText,
    Passed,
    Revealed,
    Stories,
    Story,
    TookLesson,
    WentToCard,
    after,
)
from tests.support.lessons import small_lesson

LESSON = small_lesson()
SPEC = LESSON.spec
FIRST, GUESS, ADD, SEEN, WHY, FREE = range(6)


def taken(name: str = "small") -> TookLesson:
    return TookLesson(0, name, "", LESSON.digest, LongText(""), "en", 200, True, False)


def told(*many: Act) -> Story:
    story = Story(taken())
    for act in many:
        story = after(story, act)
    return story


def to(card: int, *many: Act) -> Story:
    return told(*(WentToCard(n) for n in range(card + 1)), *many)


def answered(question: str, value: str = '"yes"', confidence: int | None = None) -> list[Act]:
    return [Answered(question, value), Committed(question, confidence)]


def test_controls_are_those_of_the_beginning_and_what_has_been_unlocked() -> None:
    assert shown(to(GUESS), SPEC) == {"play", "speed", "layer.value"}
    unlocked = {"play", "speed", "layer.value", "layer.reach", "add_skill", "undo"}
    assert shown(to(ADD), SPEC) == unlocked
    # What is unlocked stays when one goes back.
    assert shown(to(ADD, WentToCard(FIRST)), SPEC) == unlocked
    everything = shown(to(FREE), SPEC)
    assert has(everything, "side")
    assert not has(frozenset(unlocked), "side")


def test_layers_come_in_the_order_of_the_list() -> None:
    assert layers_of(frozenset({"layer.reach", "play", "layer.value"})) == ("value", "reach")
    assert len(layers_of(frozenset({"all"}))) > 8


def test_one_goes_on_once_what_the_card_asks_for_is_done() -> None:
    assert may_go_on(to(FIRST), SPEC)
    assert not may_go_on(to(GUESS), SPEC)
    assert not may_go_on(to(GUESS, Answered("guess", '"no"')), SPEC)
    assert may_go_on(to(GUESS, *answered("guess")), SPEC)
    assert not may_go_on(to(ADD), SPEC)
    assert may_go_on(to(ADD, Passed(ADD)), SPEC)
    assert is_done(FREE, to(FREE), SPEC)
    assert not may_go_on(to(FREE), SPEC)


def test_what_came_of_a_guess_is_told_after_what_was_seen_is_asked() -> None:
    guessed = to(SEEN, *answered("guess"))
    assert all(revealed_on(card, guessed, SPEC) is None for card in range(6))
    seen = to(SEEN, *answered("guess"), *answered("seen"))
    for card in (GUESS, SEEN):
        found = revealed_on(card, seen, SPEC)
        assert found is not None
        assert (found.card.id, found.place) == ("guess", GUESS)
    assert all(revealed_on(card, seen, SPEC) is None for card in (FIRST, ADD, WHY, FREE))


def test_where_nothing_asks_what_was_seen_it_is_told_on_the_cards_after_the_guess() -> None:
    text = SPEC.model_copy(update={"steps": tuple(c for c in SPEC.steps if c.see is None)})
    story = to(2, *answered("guess"))
    places = [found and found.place for found in (revealed_on(n, story, text) for n in range(5))]
    assert places == [None, 1, 1, 1, 1]


def test_guesses_wait_for_what_comes_of_them_once_they_stand() -> None:
    assert open_guesses(to(GUESS, Answered("guess", '"no"')), SPEC) == ()
    (guess,) = open_guesses(to(SEEN, *answered("guess"), *answered("seen")), SPEC)
    assert guess.card.id == "guess"
    done = to(SEEN, *answered("guess"), Revealed("guess", LongText('"no"'), False))
    assert open_guesses(done, SPEC) == ()


@pytest.mark.parametrize("n_right", [0, 2])
def test_how_sure_people_were_is_counted_over_all_lessons(n_right: int) -> None:
    stories = Stories()
    for lesson in range(2):
        for record in (
            taken(f"lesson {lesson}"),
            WentToCard(0),
            *answered("a", confidence=90),
            *answered("b", confidence=50),
            *answered("c"),
            Revealed("a", LongText('"yes"'), lesson < n_right),
            Revealed("b", LongText('"yes"'), None),
            Revealed("c", LongText('"yes"'), True),
        ):
            stories = stories.after(record)
    assert sureness(stories) == (Sureness(90, n_right, 2),)
    assert (
        sureness_in_words(stories, IN_ENGLISH)
        == f"When you said 90\u00a0%, you were right in {n_right} of 2."
    )
    assert sureness_in_words(Stories(), IN_ENGLISH) == ""


@pytest.mark.parametrize(
    ("question", "value"),
    [
        ("guess", "perhaps"),
        ("guess", '"perhaps"'),
        ("guess", "[" * 900),
        ("guess", '{"a": 1}'),
        ("guess", "NaN"),
        ("first", '"yes"'),
        ("nobody asks", '"yes"'),
    ],
)
def test_answers_that_are_none_are_left_out(question: str, value: str) -> None:
    story = to(SEEN, *answered(question, value), *answered("seen", '"no"'))
    assert set(sound(story, SPEC).answers) == {"seen"}


def test_what_a_run_cannot_have_answered_is_left_out() -> None:
    for shown_by_run in ("[", '{"a": 1}', '[["a"]]'):
        story = to(SEEN, *answered("guess"), Revealed("guess", LongText(shown_by_run), True))
        given = sound(story, SPEC).answers["guess"]
        assert (given.shown, given.is_within, given.locked) == (None, None, True)
    whole = to(SEEN, *answered("guess"), Revealed("guess", LongText('"no"'), True))
    assert sound(whole, SPEC) is whole
