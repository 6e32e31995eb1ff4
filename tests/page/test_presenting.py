"""Who presents, and what an audience is shown of them."""

from dataclasses import replace
from typing import Any, NamedTuple

import msgspec
import pytest

from app.live.snapshot import take
from app.live.status import Status
from app.page import presenting
from app.page.presenting import RELOADED_S, Presenting
from app.picture.layer import Extras
from app.picture.look import Look
from app.player.classroom import Card
from app.player.presented import Presented
from learners.run import Run
from tests.support.live import preset_of

MOMENT = {"line": 4, "step": 0, "live": True}


class Bar(NamedTuple):
    bar: msgspec.Raw | None = None
    moment: dict[str, Any] | None = MOMENT


class Lesson:
    told = Card("cone/1", "The cone", 1, 5, "Value is a <b>cone</b>.")


class Viewer:
    time = Bar()
    lesson = Lesson()

    def __init__(self, number: int) -> None:
        self.number, self.look = number, Look(layer="reach", option=number)


class Stand:
    """Keeps what it is shown."""

    addresses, code, n_watchers = ("http://127.0.0.1:1",), None, 0

    def __init__(self) -> None:
        self.shown: list[Presented | None] = []
        self.is_closed = False

    def show(self, live: Status, presented: Presented | None) -> None:
        self.shown.append(presented)

    def close(self) -> None:
        self.is_closed = True


def status() -> Status:
    run = Run(preset_of(), 0)
    return Status(
        snapshot=take(run, "timed", 4),
        playing=False,
        finished=False,
        exhausted=False,
        preparing=False,
        speed=1.0,
        steps_per_s=0.0,
        error=None,
        answered=0,
    )


LIVE = status()


class Scene:
    """Browsers that come and go; those below 10 are on this machine."""

    def __init__(self) -> None:
        self.stand = Stand()
        self.presenting = Presenting(self.stand, None)  # type: ignore[arg-type]
        self.viewers: dict[int, Viewer] = {}
        self.now_s = 0.0

    def come(self, *numbers: int) -> None:
        for number in numbers:
            self.viewers[number] = Viewer(number)
            self.presenting.come(number)

    def go(self, number: int) -> None:
        del self.viewers[number]
        self.presenting.go(number, self.now_s)

    def show(self, after_s: float = 0.1) -> Presented | None:
        self.now_s += after_s
        seen = dict.fromkeys(self.viewers.values(), LIVE)
        self.presenting.show(
            seen, LIVE, lambda *_: Extras(), lambda line: (line, 7), now_s=self.now_s
        )
        return self.stand.shown[-1]


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> Scene:
    monkeypatch.setattr(presenting, "is_on_this_machine", lambda _, number: number < 10)
    return Scene()


def test_before_anybody_has_come_nothing_is_shown(scene: Scene) -> None:
    assert scene.show() is None


def test_the_first_on_this_machine_presents(scene: Scene) -> None:
    scene.come(11, 3, 2)
    shown = scene.show()
    assert shown is not None
    assert shown.look.option == 3
    assert shown.events == (4, 7)
    assert shown.card == Lesson.told
    assert not shown.is_away


def test_where_there_is_none_the_first_of_all_does(scene: Scene) -> None:
    scene.come(12, 11)
    scene.show()
    assert scene.presenting.presenter == 12


def test_another_one_can_take_over(scene: Scene) -> None:
    scene.come(1, 12)
    scene.show()
    scene.presenting.take_over(12)
    shown = scene.show()
    assert shown is not None
    assert shown.look.option == 12
    scene.presenting.take_over(99)
    assert scene.presenting.presenter == 12


def test_a_page_that_is_loaded_anew_goes_on_presenting(scene: Scene) -> None:
    scene.come(1, 2)
    scene.show()
    scene.go(1)
    left = scene.show()
    assert left is not None
    assert (left.look.option, left.is_away) == (1, True)
    scene.come(3)
    shown = scene.show()
    assert shown is not None
    assert (shown.look.option, shown.is_away) == (3, False)


def test_who_does_not_come_again_is_followed_by_the_first(scene: Scene) -> None:
    scene.come(12, 1, 2)
    scene.show()
    scene.go(1)
    scene.show()
    assert scene.presenting.presenter is None
    scene.show(RELOADED_S)
    assert scene.presenting.presenter == 2


def test_while_the_presenter_is_away_what_is_live_goes_on(scene: Scene) -> None:
    scene.come(1)
    scene.show()
    scene.go(1)
    later = replace(LIVE, playing=True)
    scene.presenting.show({}, later, lambda *_: Extras(), lambda _: (), 1.0)
    shown = scene.stand.shown[-1]
    assert shown is not None
    assert shown.status is later


def test_without_an_audience_nothing_is_done() -> None:
    presenting.Presenting(None, None).show(  # type: ignore[arg-type]
        {}, LIVE, lambda *_: Extras(), lambda _: (), 0.0
    )


def test_the_end_is_the_end_of_the_audience(scene: Scene) -> None:
    scene.presenting.close()
    assert scene.stand.is_closed
