"""What of a page's messages is acted on, and when. Times are seconds on a clock of the test."""

from typing import Any

from viser import _messages as wire

from app.server.pace import (
    BURST_S,
    REPEAT_S,
    SECOND_PRESS_S,
    VALUE_S,
    Pace,
)
from app.server.shapes import Shaped

KEY_HZ = 30
"""How often a key that is held down comes."""


def message(name: Any) -> Shaped:
    return Shaped(b"", wire.GuiUpdateMessage, name)


def taken(pace: Pace, now_s: float) -> list[Any]:
    """What is acted on by a time."""
    found = []
    while (next_one := pace.next(now_s)) is not None:
        found.append(next_one.content)
    return found


def test_of_values_that_come_too_fast_the_newest_counts() -> None:
    pace = Pace()
    found = []
    for place in range(1_000):
        now_s = 10 + place / 1_000
        pace.take_value("slider", message(place), now_s)
        found += taken(pace, now_s)
    assert pace.wait_s(11.0) is not None
    found += taken(pace, 11.0 + VALUE_S)
    assert found[0] == 0
    assert found[-1] == 999
    assert found == sorted(found)
    assert len(found) <= 1 / VALUE_S + 2
    assert pace.wait_s(12.0) is None


def test_slow_values_are_all_taken_at_once() -> None:
    pace = Pace()
    for place in range(10):
        pace.take_value("slider", message(place), place * 2 * VALUE_S)
        assert taken(pace, place * 2 * VALUE_S) == [place]


def test_order_stays_whatever_is_held() -> None:
    pace = Pace()
    pace.take_value("slider", message("first"), 1.0)
    pace.take_value("slider", message("second"), 1.001)
    pace.take_value("slider", message("third"), 1.002)
    pace.take_act(message("click"))
    pace.take_value("slider", message("fourth"), 1.003)
    pace.take_value("other", message("other"), 1.004)
    assert taken(pace, 1.005) == ["first", "third", "click", "fourth", "other"]


def test_held_key_acts_once() -> None:
    for delay_s in (0.25, 0.5, 0.66):
        pace = Pace()
        times_s = [0.0, *(delay_s + n / KEY_HZ for n in range(300))]
        found = []
        for number, now_s in enumerate(times_s):
            found += taken(pace, now_s)
            pace.take_press("F", message(number), now_s)
        assert [*found, *taken(pace, 100.0)] == [0]


def test_held_key_that_moves_the_camera_acts_once() -> None:
    pace = Pace()
    found = []
    for frame in range(300):
        now_s = frame / 60
        found += taken(pace, now_s)
        if frame == 0 or (frame >= 30 and frame % 2 == 0):
            pace.take_press("S", message("step"), now_s)
        pace.take_value("camera", message("camera"), now_s, apart=True)
    found += taken(pace, 10.0)
    assert found.count("step") == 1
    assert 100 < found.count("camera") < 200


def test_what_is_held_is_not_lost_with_the_page() -> None:
    pace = Pace()
    assert not pace.release()
    pace.take_value("slider", message("first"), 1.0)
    pace.take_value("slider", message("second"), 1.001)
    assert pace.release()
    assert taken(pace, 1.002) == ["first", "second"]


def test_presses_of_a_person_all_act() -> None:
    pace = Pace()
    found = []
    times_s = [0.0, 0.15, 0.3, 0.45, 1.0, 3.0, 3.2]
    for number, now_s in enumerate(times_s):
        found += taken(pace, now_s)
        pace.take_press("S", message(number), now_s)
    found += taken(pace, times_s[-1] + REPEAT_S)
    assert found == list(range(len(times_s)))


def test_first_press_acts_at_once() -> None:
    pace = Pace()
    pace.take_press("S", message(1), 5.0)
    assert taken(pace, 5.0) == [1]
    later_s = 5.1 + SECOND_PRESS_S
    pace.take_press("S", message(2), later_s)
    assert taken(pace, later_s) == [2]
    pace.take_press("T", message(3), later_s)
    assert taken(pace, later_s) == [3]


def test_who_sends_too_much_waits_and_is_forgiven() -> None:
    pace = Pace()
    waits_s = [pace.charge(0.01, 50.0) for _ in range(300)]
    assert waits_s[: int(BURST_S / 0.01) - 1] == [0.0] * (int(BURST_S / 0.01) - 1)
    assert waits_s[-1] > 1.9
    assert pace.charge(0.01, 60.0) == 0.0
