"""Lanes say what happens when, and no label lies over another or over a block."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.charts.bar.axis import axis_of
from app.charts.bar.lanes import Label, Lane, lanes_of
from app.charts.bar.marks import CHARACTER
from app.schedule import blocks
from app.schedule.blocks import NEVER
from learners.commands import (
    Command,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Undo,
)
from learners.run import Run
from tests.support.schedules import AVOIDING, CIRCLING, commands, driven, seen, small_run, to


def lanes(run: Run, chosen: str = "") -> dict[str, Lane]:
    shot = seen(run)
    skills = shot.spec.learner.skills
    found = lanes_of(blocks.blocks_of(shot), skills, axis_of(shot, "trials"), chosen)
    return {lane.name: lane for lane in found}


def texts(lane: Lane) -> list[str]:
    return [label.before + label.text + label.after for label in lane.labels]


def test_each_skill_has_a_lane_and_freezes_by_hand_have_one_once_there_are_any() -> None:
    run = to(small_run(), 30)
    assert list(lanes(run)) == ["approach", "circle clockwise", "avoid"]
    run.apply(FreezeSelection(True))
    run.apply(FreezeSkills(True))
    to(run, 40)
    held = lanes(run)["frozen by hand"]
    assert texts(held) == ["selection and skills"]
    assert [(piece.half, piece.block.until) for piece in held.pieces] == [
        ("upper", None),
        ("lower", None),
    ]


def test_a_skill_is_there_from_when_it_joins_and_is_to_stay() -> None:
    shown = lanes(to(small_run(), 130))
    assert [tuple(s) for s in shown["circle clockwise"].presence] == [
        (100, None, False),
        (130, None, True),
    ]
    assert [tuple(s) for s in shown["avoid"].presence] == [(200, None, True)]


def test_what_lies_ahead_can_be_chosen_and_the_past_cannot() -> None:
    run = to(small_run(), 130)
    pieces = [piece for lane in lanes(run, AVOIDING).values() for piece in lane.pieces]
    assert [piece.block.id for piece in pieces if piece.is_chosen] == [AVOIDING]
    free = [piece.block for piece in pieces if piece.block.editable]
    assert {block.id.partition(":")[0] for block in free} == {"introduction", "episode"}
    assert all(block.first > 130 for block in free)


def test_what_was_done_by_hand_and_what_will_not_happen_is_told_apart() -> None:
    run = to(small_run(), 20)
    run.apply(Explore("approach", 30, 0.5))
    run.apply(FollowSchedule(False))
    shown = lanes(run)
    explored = [piece for piece in shown["approach"].pieces if piece.kind == "forced"]
    assert {(p.block.first, p.block.by_hand, p.is_idle) for p in explored} == {
        (20, True, False),
        (300, False, True),
    }
    assert {piece.is_idle for piece in shown["avoid"].pieces} == {True}
    assert shown["avoid"].presence == ()


@pytest.mark.parametrize("trial", [0, 5, 30, 130, 400, 1_400])
@pytest.mark.parametrize("at", [1, 8, 30, 100, 180, 450, 498])
def test_when_a_skill_joins_is_always_said(at: int, trial: int) -> None:
    run = to(small_run(f"schedule.skills.circle_clockwise.at={at}"), trial)
    joins = "joined" if trial > at else "joins"
    assert f"{joins} at {at}" in texts(lanes(run)["circle clockwise"])


def test_a_join_that_was_taken_back_is_not_said_to_have_been() -> None:
    run = to(small_run(), 40)
    number = len(run.control.history)
    run.apply(Introduce("avoid", 0))
    run.apply(Undo(number))
    assert texts(lanes(run)["avoid"]) == ["30%", "joins at 200"]


def test_how_likely_an_exploration_is_stands_within_it_beside_it_or_before_it() -> None:
    def chances(*settings: str) -> list[tuple[str, str]]:
        lane = lanes(small_run(*settings))["approach"]
        return [(label.text, label.side) for label in lane.labels if "%" in label.text]

    def episodes(*spans: tuple[int, int, float]) -> str:
        each = ", ".join(
            f"{{skill: approach, at: {at}, duration: {trials}, probability: {chance}}}"
            for at, trials, chance in spans
        )
        return f"schedule.episodes=[{each}]"

    assert chances(episodes((100, 200, 0.5))) == [("50%", "within")]
    assert chances(episodes((100, 20, 0.5))) == [("50%", "after")]
    assert chances(episodes((480, 10, 0.5))) == [("50%", "before")]
    # So close that there is no room in between: none is left out.
    close = episodes((100, 8, 0.5), (110, 8, 0.25), (120, 8, 1.0))
    assert chances(close) == [("50%, 25%, 100%", "after")]


def test_an_exploration_that_another_took_the_place_of_at_once_is_not_told() -> None:
    run = to(small_run(), 20)
    run.apply(Explore("approach", 30, 0.95))
    run.apply(Explore("approach", 30, 0.5))
    told = [text.split()[0] for text in texts(lanes(run)["approach"])]
    assert told == ["50%", "50%"], "of this one and of the one planned"


def test_what_lies_beyond_the_last_trial_is_said_at_the_edge() -> None:
    run = small_run("schedule.skills.avoid.at=9000")
    avoid = lanes(run)["avoid"]
    assert texts(avoid) == ["joins at 9,000 ▸"]
    assert (avoid.labels[0].at, avoid.labels[0].side, avoid.pieces) == (1, "before", ())
    never = small_run(f"schedule.skills.avoid.at={NEVER}")
    assert texts(lanes(never)["avoid"]) == ["not planned to join"]


def test_what_lies_beyond_an_axis_of_steps_is_said_at_its_edge() -> None:
    shot = seen(to(small_run("trials=5000", "schedule.skills.avoid.at=4000"), 20))
    found = lanes_of(blocks.blocks_of(shot), ["avoid"], axis_of(shot, "steps"))
    assert texts(found[0]) == ["joins at 4,000 ▸"]


def span_of(label: Label) -> tuple[float, float]:
    width = len(label.before + label.text + label.after) * CHARACTER
    first = {"before": label.at - width, "after": label.at, "within": label.at - width / 2}
    return first[label.side], first[label.side] + width


@given(script=st.lists(st.tuples(st.integers(0, 800), commands), max_size=30))
def test_no_label_lies_over_another_or_over_a_block_beside_it(
    script: list[tuple[int, Command]],
) -> None:
    run = driven(small_run(), script)
    axis = axis_of(seen(run), "trials")
    for lane in lanes(run).values():
        blocks = [
            (axis.of_trial(b.first), axis.now if b.until is None else axis.of_trial(b.until))
            for b in (piece.block for piece in lane.pieces)
        ]
        spans = sorted(map(span_of, lane.labels))
        assert all(one[1] <= other[0] for one, other in itertools.pairwise(spans))
        for label in lane.labels:
            first, until = span_of(label)
            assert until - first <= label.room + 1e-9
            if label.side != "within":
                inside = [b for b in blocks if b[0] < until - 1e-9 and first < b[1] - 1e-9]
                assert inside == []


def test_the_block_that_can_be_chosen_lies_over_the_longer_one() -> None:
    ids = [piece.block.id for piece in lanes(small_run())["circle clockwise"].pieces]
    assert ids == [CIRCLING, "introduction:circle_clockwise"]
