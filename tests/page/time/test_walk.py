"""Where one browser looks: live or a moment, by steps, trials and events, and as it plays."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.live.places import Place
from app.page.time.walk import WHOLE, Direction, Loop, Unit, Walk, WalkError, rates_of
from tests.page.time.walks import BRANCH, LIVE, Even, ground

GROUND = ground(events=(1_000, 4_000, 9_000))


def walk_at(step: int, line: int = LIVE) -> Walk:
    walk = Walk()
    walk.look(line, step, 0.0, GROUND)
    return walk


# --- Live and past


def test_it_begins_live_and_stays_so() -> None:
    walk = Walk()
    assert walk.at(0.0, GROUND) is None
    assert walk.at(9.0, GROUND) is None
    assert walk.is_live


def test_it_stays_at_a_moment_whatever_becomes_of_the_live_run() -> None:
    live = Even()
    grounds = ground({LIVE: live})
    walk = Walk()
    walk.seek(2_345, 0.0, grounds)
    live.end_step = 90_000
    assert walk.at(60.0, grounds) == Place(LIVE, 2_345)
    walk.go_live()
    assert walk.at(61.0, grounds) is None


@pytest.mark.parametrize(("step", "found"), [(-5, 0), (0, 0), (9_999, 9_999)])
def test_a_step_is_within_the_line(step: int, found: int) -> None:
    walk = Walk()
    walk.seek(step, 0.0, GROUND)
    assert walk.at(0.0, GROUND) == Place(LIVE, found)


def test_the_end_of_the_live_line_is_live_and_that_of_a_branch_is_not() -> None:
    walk = walk_at(5)
    walk.seek(10_000, 0.0, GROUND)
    assert walk.is_live
    walk.look(BRANCH, None, 0.0, GROUND)
    assert walk.at(0.0, GROUND) == Place(BRANCH, 5_000)
    walk.seek(99_999, 0.0, GROUND)
    assert walk.at(0.0, GROUND) == Place(BRANCH, 5_000)


def test_a_trial_is_its_beginning_and_one_too_far_the_end() -> None:
    walk = Walk()
    walk.seek_trial(12, 0.0, GROUND)
    assert walk.at(0.0, GROUND) == Place(LIVE, 1_200)
    walk.seek_trial(-3, 0.0, GROUND)
    assert walk.at(0.0, GROUND) == Place(LIVE, 0)
    walk.seek_trial(101, 0.0, GROUND)
    assert walk.is_live


def test_it_is_live_again_once_its_line_is_gone_and_tells_that_once() -> None:
    walk = walk_at(400, BRANCH)
    walk.play(1, 0.0, GROUND)
    assert not walk.lost()
    assert walk.at(1.0, ground({LIVE: Even()})) is None
    assert walk.lost()
    assert not walk.lost()
    assert walk.direction == 0


def test_a_line_that_is_not_there_cannot_be_looked_at() -> None:
    walk = walk_at(300)
    with pytest.raises(WalkError, match="not there any more"):
        walk.look(99, 0, 0.0, GROUND)
    assert walk.at(0.0, GROUND) == Place(LIVE, 300)


def test_where_a_line_became_shorter_it_is_at_its_end() -> None:
    walk = walk_at(4_000, BRANCH)
    assert walk.at(0.0, ground({LIVE: Even(), BRANCH: Even(3_000)})) == Place(BRANCH, 3_000)


# --- By steps, trials and events


@pytest.mark.parametrize(
    ("unit", "n", "step"),
    [
        ("steps", 1, 4_051),
        ("steps", -1, 4_049),
        ("steps", -9_999, 0),
        ("trials", 1, 4_100),
        ("trials", -1, 3_900),
        ("events", 1, 9_000),
        ("events", -1, 4_000),
        ("events", -2, 1_000),
        ("events", -3, 0),
    ],
)
def test_it_goes_by(unit: Unit, n: int, step: int) -> None:
    walk = walk_at(4_050)
    walk.go_by(unit, n, 0.0, GROUND)
    assert walk.at(0.0, GROUND) == Place(LIVE, step)


def test_an_event_is_left_for_the_next_and_after_the_last_comes_live() -> None:
    walk = walk_at(4_000)
    walk.go_by("events", 1, 0.0, GROUND)
    assert walk.at(0.0, GROUND) == Place(LIVE, 9_000)
    walk.go_by("events", -1, 0.0, GROUND)
    assert walk.at(0.0, GROUND) == Place(LIVE, 4_000)
    walk.go_by("events", 2, 0.0, GROUND)
    assert walk.is_live


def test_by_no_events_it_stays_where_it_is() -> None:
    walk = walk_at(2_345)
    walk.go_by("events", 0, 0.0, ground())
    assert walk.at(0.0, GROUND) == Place(LIVE, 2_345)


def test_from_live_it_goes_back_from_the_end() -> None:
    by: list[tuple[Unit, int]] = [("steps", 9_999), ("trials", 9_900), ("events", 9_000)]
    for unit, step in by:
        walk = Walk()
        walk.go_by(unit, -1, 0.0, GROUND)
        assert walk.at(0.0, GROUND) == Place(LIVE, step)
        walk.go_live()
        walk.go_by(unit, 1, 0.0, GROUND)
        assert walk.is_live


def test_whoever_goes_by_something_stands_still() -> None:
    walk = walk_at(1_000)
    walk.play(1, 0.0, GROUND)
    walk.go_by("steps", 1, 1.0, GROUND)
    assert walk.at(5.0, GROUND) == Place(LIVE, 2_001)


# --- Playing


@pytest.mark.parametrize(("direction", "step"), [(1, 4_500), (-1, 3_500)])
def test_it_plays_at_the_pace_of_the_ground_both_ways(direction: Direction, step: int) -> None:
    walk = walk_at(4_000)
    walk.play(direction, 10.0, GROUND)
    assert walk.at(10.5, GROUND) == Place(LIVE, step)


def test_it_goes_as_far_in_many_frames_as_in_one() -> None:
    walk = walk_at(1_000)
    walk.play(1, 0.0, GROUND)
    for frame in range(1, 301):
        walk.at(frame / 100, GROUND)
    found = walk.at(3.0, GROUND)
    assert found is not None
    assert found.step == pytest.approx(4_000, abs=1)


def test_a_clock_that_goes_back_plays_nothing() -> None:
    walk = walk_at(1_000)
    walk.play(1, 10.0, GROUND)
    assert walk.at(9.0, GROUND) == Place(LIVE, 1_000)


def test_another_rate_holds_from_then_on() -> None:
    walk = walk_at(0)
    walk.play(1, 0.0, GROUND)
    walk.set_rate(5.0, 1.0, GROUND)
    assert walk.at(2.0, GROUND) == Place(LIVE, 6_000)
    walk.pause(2.0, GROUND)
    assert walk.at(9.0, GROUND) == Place(LIVE, 6_000)


def test_the_whole_of_a_long_line_takes_half_a_minute() -> None:
    grounds = ground({LIVE: Even(3_000_000)})
    walk = Walk()
    walk.seek(0, 0.0, grounds)
    walk.set_rate(WHOLE, 0.0, grounds)
    walk.play(1, 0.0, grounds)
    assert walk.at(15.0, grounds) == Place(LIVE, 1_500_000)
    assert walk.at(30.0, grounds) is None


@pytest.mark.parametrize("rate", [-3.0, 0.5, 1e30, 1.0])
def test_a_rate_out_of_range_is_the_nearest(rate: float) -> None:
    walk = Walk()
    walk.set_rate(rate, 0.0, GROUND)
    assert walk.rate == (1e6 if rate > 2 else 1.0)


def test_at_the_end_of_the_live_line_it_is_live_and_at_that_of_a_branch_it_stands() -> None:
    for line in (LIVE, BRANCH):
        walk = walk_at(4_000, line)
        walk.play(1, 0.0, GROUND)
        found = walk.at(60.0, GROUND)
        assert found == (None if line == LIVE else Place(BRANCH, 5_000))
        assert walk.direction == 0


def test_back_at_the_beginning_it_stands() -> None:
    walk = Walk()
    walk.play(-1, 0.0, GROUND)
    assert walk.at(4.0, GROUND) == Place(LIVE, 6_000)
    assert walk.at(60.0, GROUND) == Place(LIVE, 0)
    assert walk.direction == 0
    with pytest.raises(WalkError, match="the beginning"):
        walk.play(-1, 61.0, GROUND)


def test_on_from_the_end_there_is_nothing_to_play() -> None:
    for walk in (Walk(), walk_at(5_000, BRANCH)):
        with pytest.raises(WalkError, match="Nothing more"):
            walk.play(1, 0.0, GROUND)


@pytest.mark.parametrize(("direction", "step"), [(1, 9_000), (-1, 1_000)])
def test_it_stops_at_the_next_event_and_goes_on_from_there(direction: Direction, step: int) -> None:
    walk = walk_at(4_000)
    walk.stops = True
    walk.play(direction, 0.0, GROUND)
    assert walk.at(8.0, GROUND) == Place(LIVE, step)
    assert walk.direction == 0
    walk.play(direction, 8.0, GROUND)
    assert walk.at(8.5, GROUND) == Place(LIVE, step + 500 * direction)


# --- A loop


def looping(direction: Direction) -> Walk:
    walk = walk_at(2_000)
    walk.set_a(0.0, GROUND)
    walk.seek(3_000, 0.0, GROUND)
    walk.set_loop(on=True, marks=(), now_s=0.0, ground=GROUND)
    assert walk.loop == Loop(LIVE, 2_000, 3_000)
    walk.seek(2_500, 0.0, GROUND)
    walk.play(direction, 0.0, GROUND)
    return walk


@pytest.mark.parametrize(("direction", "step"), [(1, 2_100), (-1, 2_900)])
def test_a_loop_begins_again_at_its_other_end(direction: Direction, step: int) -> None:
    walk = looping(direction)
    assert walk.at(0.6, GROUND) == Place(LIVE, step)
    assert walk.at(5.6, GROUND) == Place(LIVE, step)
    assert walk.direction == direction


@given(st.lists(st.floats(0.0, 7.0), max_size=30))
def test_a_loop_is_never_left(spans_s: list[float]) -> None:
    walk, now_s = looping(1), 0.0
    for span_s in spans_s:
        now_s += span_s
        found = walk.at(now_s, GROUND)
        assert found is not None
        assert 2_000 <= found.step <= 3_000


def test_at_a_itself_the_loop_goes_to_the_newest_mark() -> None:
    walk = walk_at(2_000)
    walk.set_a(0.0, GROUND)
    with pytest.raises(WalkError, match="another moment than A"):
        walk.set_loop(on=True, marks=(2_000,), now_s=0.0, ground=GROUND)
    walk.set_loop(on=True, marks=(700, 1_500), now_s=0.0, ground=GROUND)
    assert walk.loop == Loop(LIVE, 1_500, 2_000)


def test_without_an_a_on_this_line_there_is_no_loop() -> None:
    walk = walk_at(2_000, BRANCH)
    walk.set_a(0.0, GROUND)
    walk.look(LIVE, 100, 0.0, GROUND)
    with pytest.raises(WalkError, match="Set A first"):
        walk.set_loop(on=True, marks=(), now_s=0.0, ground=GROUND)


def test_a_loop_ends_when_it_is_let_off_or_gets_another_a() -> None:
    ends: list[Callable[[Walk], None]] = [
        lambda walk: walk.set_loop(on=False, marks=(), now_s=0.0, ground=GROUND),
        lambda walk: walk.set_a(0.0, GROUND),
    ]
    for end in ends:
        walk = looping(1)
        end(walk)
        assert walk.loop is None


def test_a_goes_with_its_line() -> None:
    walk = walk_at(2_000, BRANCH)
    walk.set_a(0.0, GROUND)
    walk.go_live()
    walk.at(0.0, ground({LIVE: Even()}))
    assert walk.a is None


# --- The live run meanwhile


def test_the_live_run_is_held_while_something_else_is_looked_at() -> None:
    walk = Walk()
    walk.holds = True
    assert walk.hold(playing=True) is None
    walk.seek(10, 0.0, GROUND)
    assert walk.hold(playing=True) == "pause"
    assert walk.hold(playing=False) is None
    walk.go_live()
    assert walk.hold(playing=False) == "play"
    assert walk.hold(playing=True) is None


def test_who_is_back_before_it_stood_still_has_it_play_all_the_same() -> None:
    walk = walk_at(10)
    walk.holds = True
    assert walk.hold(playing=True) == "pause"
    walk.go_live()
    assert walk.hold(playing=True) == "play"


def test_what_stood_still_before_stands_still_after() -> None:
    walk = walk_at(10)
    walk.holds = True
    assert walk.hold(playing=False) is None
    walk.go_live()
    assert walk.hold(playing=False) is None


def test_it_goes_on_once_it_need_not_be_held() -> None:
    walk = walk_at(10)
    walk.holds = True
    assert walk.hold(playing=True) == "pause"
    walk.holds = False
    assert walk.hold(playing=False) == "play"


# --- Rates


def test_rates_go_up_to_the_whole_run_in_half_a_minute() -> None:
    rates = rates_of(5_500_000, 20_000.0)
    assert [rate for rate, _ in rates] == [1.0, 2.0, 5.0, WHOLE]
    assert rates[0][1] == "1 \N{MULTIPLICATION SIGN}"
    assert rates[-1][1] == "whole run in 30 s"


def test_there_is_a_rate_for_a_line_that_hardly_began() -> None:
    assert [rate for rate, _ in rates_of(0, 20_000.0)] == [1.0]
    assert [rate for rate, _ in rates_of(1_000, 20_000.0)] == [1.0, WHOLE]


@given(st.integers(0, 10**9), st.floats(1.0, 1e6))
def test_each_rate_is_one_that_can_be_had(end_step: int, pace: float) -> None:
    for rate, _ in rates_of(end_step, pace):
        walk = Walk()
        walk.set_rate(rate, 0.0, GROUND)
        assert walk.rate == rate
