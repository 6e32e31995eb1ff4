"""Marks at the curve: joins have their names, what is close is one, and nothing is cut."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from app.charts.bar.axis import axis_of
from app.charts.bar.marks import CHARACTER, Mark, marks_of
from app.live.places import Mark as Note
from app.live.places import Place
from learners.commands import (
    Command,
    Explore,
    FreezeSelection,
    Introduce,
    Remove,
    SetParameter,
    Undo,
)
from learners.run import Run
from tests.support.schedules import commands, driven, seen, small_run, to


def marks(run: Run) -> tuple[Mark, ...]:
    shot = seen(run)
    return marks_of(shot.control.history, axis_of(shot, "trials"))


def names(run: Run) -> list[str]:
    return [mark.name + mark.more for mark in marks(run)]


def test_a_skill_is_named_where_it_joins_and_one_from_the_start_is_not() -> None:
    assert names(small_run()) == []
    both = marks(to(small_run(), 210))
    # Neither name lies over the place of the other mark.
    assert [(m.name + m.more, m.is_before) for m in both] == [
        ("circle clockwise joins", True),
        ("avoid joins", False),
    ]
    assert [mark.at for mark in both] == [0.2, 0.4]
    assert both[0].hint == "trial 100: circle clockwise joins"


def test_what_changes_the_learner_is_marked_unless_it_was_taken_back() -> None:
    run = to(small_run(), 50)
    run.apply(SetParameter("learner.skill_alpha", 0.35))
    assert names(run) == ["α of skills = 0.35"]
    run.apply(Undo(run.control.history[-1].number))
    assert names(run) == []
    to(run, 300).apply(Remove("circle_clockwise"))
    assert names(run) == ["circle clockwise joins", "avoid joins", "circle clockwise removed"]


def test_what_is_a_band_or_leaves_the_learning_alone_has_no_mark() -> None:
    run = to(small_run(), 50)
    for command in (Explore("approach", 100, 0.5), FreezeSelection(True)):
        run.apply(command)
    assert names(run) == []


def test_what_is_close_is_one_mark_that_tells_of_all() -> None:
    run = to(small_run(), 50)
    for place in range(20):
        run.apply(SetParameter("learner.epsilon", place / 100))
    (mark,) = marks(run)
    assert mark.name == "20 changes"
    assert mark.hint.splitlines()[0] == "trial 50: Exploration ε = 0"
    assert mark.hint.splitlines()[-1] == "and 12 more"


def test_a_join_keeps_its_name_among_many_changes() -> None:
    run = to(small_run(), 110)
    for place in range(20):
        to(run, 110 + 10 * place).apply(SetParameter("learner.epsilon", place / 100))
    assert {"circle clockwise", "avoid joins"} & {name for name in names(run) if name}
    number = len(run.control.history)
    run.apply(Introduce("circle_counterclockwise", 0))
    assert any("counterclockwise" in mark.hint for mark in marks(run))
    run.apply(Undo(number))
    assert not any("counterclockwise" in mark.hint for mark in marks(run))


@given(script=st.lists(st.tuples(st.integers(0, 800), commands), max_size=30))
def test_no_name_is_cut_or_lies_over_another(script: list[tuple[int, Command]]) -> None:
    spans = []
    for mark in marks(driven(small_run(), script)):
        width = len(mark.name + mark.more) * CHARACTER
        assert width <= mark.room + 1e-9
        if mark.name:
            spans.append(
                (mark.at - width, mark.at) if mark.is_before else (mark.at, mark.at + width)
            )
    assert all(first >= -0.2 - 1e-9 and until <= 1 for first, until in spans)
    assert all(one[1] <= other[0] for one, other in pairwise(sorted(spans)))


def test_what_somebody_wrote_is_a_mark_of_its_own_and_as_long_as_there_is_room() -> None:
    def written(run: Run, *notes: tuple[int, str]) -> list[Mark]:
        shot = seen(run)
        noted = [Note(n, Place(1, 9), trial, text) for n, (trial, text) in enumerate(notes)]
        marks = marks_of(shot.control.history, axis_of(shot, "trials"), noted)
        return [mark for mark in marks if mark.note is not None]

    run = to(small_run(), 250)
    (mark,) = written(run, (320, "the ring has closed behind the prey"))
    assert (mark.at, mark.note, mark.name) == (0.64, 0, "the ring has closed beh…")
    assert mark.hint == "trial 320: the ring has closed behind the prey"
    # Each has its line, even where no text has room.
    many = written(run, *[(320 + n, "here") for n in range(6)])
    assert [mark.note for mark in many] == list(range(6))
    assert sum(bool(mark.name) for mark in many) == 2


def test_what_somebody_wrote_comes_before_the_name_of_a_join() -> None:
    def found(circle: int, trial: int) -> list[str]:
        shot = seen(to(small_run(f"schedule.skills.circle_clockwise.at={circle}"), 250))
        notes = [Note(1, Place(1, 9), trial, "here")]
        marks = marks_of(shot.control.history, axis_of(shot, "trials"), notes)
        return [mark.name + mark.more for mark in marks]

    assert found(100, 210) == ["circle clockwise joins", "avoid joins", "here"]
    # The lane of a skill says when it joins, too; a text stands nowhere else.
    assert found(190, 210) == ["circle clockwise joins", "", "here"]
