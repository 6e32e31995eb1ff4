"""What is made beside the render loop: one thing at a time, and not again without need."""

import math
import queue
import threading
from collections.abc import Callable

import pytest

from app.util import background
from app.util.background import Maker

PATIENCE_S = 60.0


class Workshop:
    """A maker, and what it has come to."""

    def __init__(self, rest_s: float = 0.0, rest_ratio: float = 0.0) -> None:
        self.done: queue.SimpleQueue[None] = queue.SimpleQueue()
        self.maker: Maker[str] = Maker(lambda: self.done.put(None), rest_s, rest_ratio)
        self.asked: list[str] = []

    def want(self, of: str, make: Callable[[], str] = lambda: "a thing") -> None:
        def make_it() -> str:
            self.asked.append(of)
            return make()

        self.maker.want(of, make_it)

    def wait(self) -> None:
        """Until one more thing is there."""
        self.done.get(timeout=PATIENCE_S)


def fails() -> str:
    raise OSError("the table is locked")


def test_a_thing_that_is_there_is_not_made_again_and_another_one_is() -> None:
    workshop = Workshop()
    workshop.want("first", lambda: "one")
    workshop.wait()
    workshop.want("first", lambda: "one again")
    assert workshop.maker.latest == ("first", "one")
    workshop.want("second", lambda: "two")
    workshop.wait()
    assert workshop.maker.latest == ("second", "two")
    assert workshop.asked == ["first", "second"]


def test_while_one_thing_is_made_the_former_stays_and_no_other_is_begun() -> None:
    workshop, goes_on = Workshop(), threading.Event()
    workshop.want("first")
    workshop.wait()
    workshop.want("second", lambda: str(goes_on.wait(PATIENCE_S)))
    workshop.want("third")
    assert workshop.maker.latest == ("first", "a thing")
    goes_on.set()
    workshop.wait()
    assert workshop.asked == ["first", "second"]


def test_what_could_not_be_made_is_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(background, "_RETRY_S", 0.0)
    workshop = Workshop()
    workshop.want("it", fails)
    workshop.wait()
    assert isinstance(workshop.maker.found, OSError)
    workshop.want("it", lambda: "made after all")
    workshop.wait()
    assert workshop.maker.found == "made after all"


def test_what_could_not_be_made_is_not_tried_again_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(background, "_RETRY_S", math.inf)
    workshop = Workshop()
    workshop.want("it", fails)
    workshop.wait()
    workshop.want("it", fails)
    workshop.want("something else")
    workshop.wait()
    assert workshop.asked == ["it", "something else"]


def test_without_a_thread_a_thing_could_not_be_made_and_is_tried_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def start(thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(background, "_RETRY_S", 0.0)
    workshop = Workshop()
    with monkeypatch.context() as full:
        full.setattr(threading.Thread, "start", start)
        workshop.want("it")
    workshop.wait()
    of, error = workshop.maker.latest
    assert of == "it"
    assert isinstance(error, RuntimeError)
    workshop.want("it")
    workshop.wait()
    assert workshop.maker.latest == ("it", "a thing")
    workshop.maker.stop()


@pytest.mark.parametrize("rests", [{"rest_s": math.inf}, {"rest_ratio": math.inf}])
def test_a_maker_rests_between_two_things(rests: dict[str, float]) -> None:
    workshop = Workshop(**rests)
    workshop.want("first")
    workshop.wait()
    workshop.want("second")
    workshop.maker.stop()
    assert workshop.asked == ["first"]


def test_a_maker_that_is_stopped_has_ended_its_work_and_begins_none() -> None:
    workshop = Workshop()
    workshop.want("first")
    workshop.maker.stop()
    assert workshop.maker.found == "a thing"
    workshop.want("second")
    workshop.maker.stop()
    assert workshop.asked == ["first"]
