"""A question on the bar: what the frame is told, what part is seen, and what answers are taken."""

from typing import Any

import pytest

from app.charts.bar.model import View
from app.page.time.asked import Asked, Asking, Band, MomentAsked, SketchAsked, handles_at
from app.page.time.messages import HANDLES, Guess, Sketch

LAST, REWARDS = 48_000, (-50.0, 100.0)
MOMENT, SKETCH = MomentAsked("closed"), SketchAsked("dip", 11_500, 17_000)
TRIALS = (11_500, 12_600, 13_700, 14_800, 15_900, 17_000)


class Desk:
    """A question, and what has come of it."""

    def __init__(self, asked: Asked | None) -> None:
        self.asking = Asking()
        self.heard: list[Any] = []
        self.asking.ask(asked, self.heard.append)

    def take(self, answer: Guess | Sketch) -> list[Any]:
        self.asking.take(answer, LAST, REWARDS)
        return self.heard


def drawn(*rewards: float, trials: tuple[int, ...] = TRIALS) -> Sketch:
    return Sketch(tuple(zip(trials, rewards, strict=True)))


def test_the_points_of_a_curve_are_evenly_spread_and_at_both_ends() -> None:
    assert handles_at(11_500, 17_000) == TRIALS
    for first, last in ((0, 1), (0, 7), (3, 48_000)):
        at = handles_at(first, last)
        assert len(at) == HANDLES
        assert (at[0], at[-1]) == (first, last)
        assert list(at) == sorted(at)


def test_a_moment_leaves_the_bar_as_it_is_and_a_curve_shows_its_part_closely() -> None:
    assert Desk(None).asking.view is None
    assert Desk(MOMENT).asking.view is None
    assert Desk(SKETCH).asking.view == View(9_850, 17_220, hides_after=11_500)
    assert Desk(SKETCH._replace(locked=True)).asking.view == View(9_850, 17_220)
    assert SketchAsked("all", 0, 1_000).view == View(0, 1_040, hides_after=0)


def test_the_frame_is_told_what_is_new_once() -> None:
    asking = Asking()
    assert asking.news() is None
    asking.ask(MOMENT, None)
    told = asking.news()
    assert told is not None
    assert told["ask"] == {
        "kind": "moment",
        "id": "closed",
        "language": "en",
        "from": 0,
        "to": None,
        "guess": None,
        "locked": False,
        "run": None,
        "twenty": (),
        "runs": 20,
    }
    asking.ask(MomentAsked("closed"), None)
    assert asking.news() is None
    asking.forget()
    assert asking.news() == told
    band = Band((11_500, 17_000), (10.0, 50.0), (15.0, 64.0))
    asking.ask(SKETCH._replace(locked=True, run=((11_500, 13.0),), band=band), None)
    told = asking.news()
    assert told is not None
    assert told["ask"]["at"] == TRIALS
    assert told["ask"]["handles"] is None
    assert told["ask"]["band"] == {"at": band.at, "low": band.low, "high": band.high}
    asking.ask(None, None)
    assert asking.news() == {"ask": None}
    assert asking.news() is None


def test_answers_to_what_is_asked_are_handed_on() -> None:
    assert Desk(MOMENT).take(Guess(24_000)) == [Guess(24_000)]
    sketch = drawn(13, -21, -5, 65, 46, 59)
    assert Desk(SKETCH).take(sketch) == [sketch]


@pytest.mark.parametrize(
    ("asked", "answer"),
    [
        (None, Guess(1)),
        (MOMENT, Guess(LAST + 1)),
        (MOMENT, drawn(1, 2, 3, 4, 5, 6)),
        (MOMENT._replace(locked=True), Guess(1)),
        (MOMENT._replace(first=24_000), Guess(23_999)),
        (MOMENT._replace(last=30_000), Guess(30_001)),
        (SKETCH, Guess(1)),
        (SKETCH, drawn(1, 2, 3, 4, 5, 6, trials=(11_500, 12_600, 13_700, 14_800, 15_900, 17_001))),
        (SKETCH, drawn(1, 2, 3, 4, 5, 6, trials=TRIALS[::-1])),
        (SKETCH._replace(locked=True), drawn(1, 2, 3, 4, 5, 6)),
    ],
)
def test_others_are_dropped(asked: Asked | None, answer: Guess | Sketch) -> None:
    assert Desk(asked).take(answer) == []


def test_no_reward_is_beyond_what_a_trial_can_come_to() -> None:
    taken = Desk(SKETCH).take(drawn(-1e6, -50, 0, 100, 101, 1e6))
    assert [reward for _, reward in taken[0].points] == [-50, -50, 0, 100, 100, 100]
