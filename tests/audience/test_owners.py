"""Learners of those who look on, at a real port: taps are answered, and nobody else has to do with
them."""

import contextlib
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import pytest
from websockets.exceptions import ConnectionClosed

from app.audience import own_view, owners
from app.audience.audience import Audience
from app.audience.offered import Offer, offer_of
from app.audience.own import Beginning, Kept, Own
from app.audience.owners import Owners
from app.audience.seats import Seat
from app.audience.taps import AddOwn, AgainOwn, ExploreOwn, PlayOwn, SpeedOwn, Tap
from app.audience.wishes import Follow, LookOwn
from app.documents import lessons
from app.live.status import Status
from app.live.story import (
    Act,
    Answered,
    Committed,
    LongText,
    Stories,
    TookLesson,
    WentToCard,
)
from app.player.presented import FEWEST_SHOWN
from learners.commands import Introduce
from learners.kernel.state import digest
from learners.run import replay
from learners.spec import RunSpec
from tests.support.live import SEED, preset_of
from tests.support.server import PATIENCE_S
from tests.support.watching import Page

OWN = {"do": "own", "dark": False}
SPEC = preset_of("timed", "trials=3000")


class Looker:
    """A page, as far as own learners know one."""

    def __init__(self, number: int) -> None:
        self.seat = Seat(number)
        self.wish: Any = LookOwn(False)
        self.is_ready = True
        self.seen: dict[str, bytes] = {}


class Group:
    """Own learners of pages that are not there: what these are sent is what they have seen."""

    def __init__(self, n: int = 1, beginning: Beginning | None = None) -> None:
        self.pages = [Looker(number) for number in range(1, n + 1)]
        self.sent = threading.Condition()
        self.n_letters = 0
        self.owners = Owners(lambda: tuple(self.pages), self._send)  # type: ignore
        if beginning is not None:
            self.owners.offer(Offer(beginning))

    def _send(self, letters: Any) -> None:
        with self.sent:
            self.n_letters += len(list(letters))
            self.sent.notify_all()

    def part(self, page: Looker, kind: str = "own") -> dict[str, Any]:
        return msgspec.json.decode(page.seen.get(kind, b"{}"))

    def until(self, condition: Callable[[], bool]) -> None:
        """Wait until what has been sent meets a condition."""
        with self.sent:
            assert self.sent.wait_for(condition, PATIENCE_S)

    def tap(self, page: Looker, tap: Tap) -> None:
        self.owners.tap(page, tap)  # type: ignore

    def own(self, page: Looker) -> Own | None:
        found = self.owners.learner_of(page.seat)
        return found if isinstance(found, Own) else None


@contextlib.contextmanager
def group(n: int = 1, spec: RunSpec = SPEC, **changes: Any) -> Iterator[Group]:
    made = Group(n, Beginning("timed", spec, SEED, **changes))
    try:
        yield made
    finally:
        made.owners.close()


def control(told: dict[str, Any], name: str) -> dict[str, Any]:
    return next(one for one in told.get("controls", ()) if one["control"] == name)


# --- One after the other --------------------------------------------------------------------------


def test_a_tap_is_done_and_shown() -> None:
    with group(2, start=20, schedule=False) as them:
        one, other = them.pages
        them.until(lambda: "own_ground" in one.seen and "own_ground" in other.seen)
        before = other.seen["own_ground"]
        assert control(them.part(one), "play")["label"] == "Play"
        them.tap(one, AddOwn("circle_clockwise"))
        them.until(lambda: control(them.part(one), "add_skill")["options"][0][0] == "avoid")
        them.tap(one, AddOwn("circle_clockwise"))
        them.until(lambda: "has joined already" in them.part(one)["notice"])
        first = one.seen["own_ground"]
        them.tap(one, PlayOwn(True))
        them.until(lambda: them.part(one)["playing"])
        assert them.part(one)["notice"] == ""
        # It goes on by itself.
        them.until(lambda: one.seen["own_ground"] != first)
        assert other.seen["own_ground"] == before
        assert not them.part(other)["playing"]
        assert "seat 1, circle" in them.part(one)["whose"]
        assert "seat 2, triangle" in them.part(other)["whose"]


def test_whoever_taps_and_taps_is_told_what_came_of_it_and_painted_later(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    painted: list[bool] = []
    true_paint = own_view.OwnView.paint

    def paint(view: own_view.OwnView, status: Status, asked: bool, now_s: float) -> None:
        painted.append(asked)
        true_paint(view, status, asked, now_s)

    monkeypatch.setattr(own_view.OwnView, "paint", paint)
    monkeypatch.setattr(owners, "ASKED_S", 1e9)
    with group(start=20) as them:
        (page,) = them.pages
        them.until(lambda: "own_ground" in page.seen)
        painted.clear()
        for level in (0, 1, 2, 3, 4):
            them.tap(page, SpeedOwn(level))
            them.until(lambda level=level: control(them.part(page), "speed")["level"] == level)
        assert True not in painted
        first = page.seen["own_ground"]
        them.tap(page, PlayOwn(True))
        them.until(lambda: page.seen["own_ground"] != first)


def test_only_what_is_offered_can_be_done() -> None:
    with group(start=20) as them:
        (page,) = them.pages
        them.owners.offer(Offer(Beginning("timed", SPEC, SEED, start=20), ("play",)))
        them.until(lambda: len(them.part(page).get("controls", ())) == 1)
        them.tap(page, SpeedOwn(0))
        them.tap(page, AddOwn("avoid"))
        them.tap(page, ExploreOwn("approach", True))
        them.tap(page, AgainOwn())
        them.tap(page, PlayOwn(True))
        them.until(lambda: them.part(page)["playing"])
        own = them.own(page)
        assert own is not None
        assert (own.run.journal, own.level) == ([], own.beginning.level)


def test_those_that_follow_the_presenter_have_no_learner() -> None:
    with group(2) as them:
        one, other = them.pages
        other.wish = Follow(False)
        them.owners.look()
        them.until(lambda: "own_ground" in one.seen)
        them.tap(other, PlayOwn(True))
        them.tap(one, PlayOwn(True))
        them.until(lambda: them.part(one)["playing"])
        assert other.seen.keys() <= {
            "own",
            "own_world",
            "own_ground",
            "own_words",
            "own_over",
            "lab",
        }


def test_all_learn_and_each_is_what_it_would_be_alone() -> None:
    with group(6, SPEC.model_copy(update={"trials": 700}), start=10, speed=100_000) as them:
        for page in them.pages:
            them.until(lambda page=page: "own_ground" in page.seen)
            them.tap(page, PlayOwn(True))
        them.tap(them.pages[0], AddOwn("circle_clockwise"))
        for page in them.pages:
            them.until(lambda page=page: them.part(page)["controls"][0]["label"] == "Start again")
        for page in them.pages:
            own = them.own(page)
            assert own is not None
            assert own.run.trial == 700
            alone = replay(own.run.preset, SEED + page.seat.number, own.run.journal, own.run.step)
            assert digest(own.run.state) == digest(alone.state)


def test_one_that_has_gone_is_put_away_and_comes_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(owners, "GONE_S", 0.0)
    with group(start=30, schedule=False) as them:
        (page,) = them.pages
        them.until(lambda: "own_ground" in page.seen)
        them.tap(page, AddOwn("circle_clockwise"))
        them.until(lambda: len(control(them.part(page), "add_skill")["options"]) == 1)
        own = them.own(page)
        assert own is not None
        before, history = digest(own.run.state), own.run.control.history
        them.pages = []
        them.owners.look()
        wait_for(lambda: them.own(page) is None)
        page.seen.clear()
        them.pages = [page]
        them.owners.look()
        them.until(lambda: "own_ground" in page.seen)
        again = them.own(page)
        assert again is not None
        assert again is not own
        assert (digest(again.run.state), again.run.control.history) == (before, history)
        assert again.run.journal[-1][1] == Introduce("circle_clockwise", 300)


def wait_for(condition: Callable[[], bool]) -> None:
    """Wait until something holds that nobody tells of."""
    ticks = threading.Event()
    for _ in range(int(PATIENCE_S / 0.01)):
        if condition():
            return
        ticks.wait(0.01)
    raise AssertionError("it has not come to that")


def test_one_that_nobody_touches_rests_until_it_is_touched(monkeypatch: pytest.MonkeyPatch) -> None:
    with group(start=30) as them:
        (page,) = them.pages
        them.until(lambda: "own_ground" in page.seen)
        them.tap(page, PlayOwn(True))
        them.until(lambda: them.part(page)["playing"])
        monkeypatch.setattr(owners, "REST_S", 0.0)
        them.until(lambda: them.part(page)["notice"].startswith("It rests"))
        kept = them.owners.learner_of(page.seat)
        assert isinstance(kept, Kept)
        step = kept.step
        monkeypatch.setattr(owners, "REST_S", 600.0)
        them.tap(page, SpeedOwn(1))
        them.until(lambda: control(them.part(page), "speed")["level"] == 1)
        own = them.own(page)
        assert own is not None
        assert (own.run.step, own.playing) == (step, False)
        assert them.part(page)["notice"] == ""


def test_there_is_room_for_so_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(owners, "MOST_AWAKE", 2)
    with group(3) as them:
        waits = "Too many learners"
        them.until(lambda: any(waits in them.part(page).get("notice", "") for page in them.pages))
        them.until(lambda: sum("own_ground" in page.seen for page in them.pages) == 2)
        monkeypatch.setattr(owners, "BRIEF_REST_S", 0.0)
        them.until(lambda: all("own_ground" in page.seen for page in them.pages))


def test_another_lesson_begins_them_anew() -> None:
    with group(start=30) as them:
        (page,) = them.pages
        them.until(lambda: "own_ground" in page.seen)
        them.owners.offer(Offer(Beginning("timed", SPEC, 50, start=5)))
        them.until(lambda: "began anew" in them.part(page)["notice"])
        them.until(lambda: them.part(page)["busy"] == "")
        own = them.own(page)
        assert own is not None
        assert (own.seed, own.run.trial) == (51, 5)


def test_one_that_breaks_harms_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    true_advance, broken = Own.advance, set[int]()

    def advance(own: Own, steps: int) -> int:
        if own.seed == SEED + 1 and own.learns and own.seed not in broken:
            broken.add(own.seed)
            raise RuntimeError("broken")
        return true_advance(own, steps)

    monkeypatch.setattr(Own, "advance", advance)
    with group(2) as them:
        for page in them.pages:
            them.until(lambda page=page: "own_ground" in page.seen)
            them.tap(page, PlayOwn(True))
        one, other = them.pages
        them.until(lambda: "began anew" in them.part(one)["notice"])
        before = other.seen["own_ground"]
        them.until(lambda: other.seen["own_ground"] != before)


def test_the_presenter_is_told_numbers_and_no_names(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(owners, "_OVERVIEW_S", 0.0)
    with group(FEWEST_SHOWN, start=20) as them:
        last = them.pages.pop()
        for page in them.pages:
            them.until(lambda page=page: "own_ground" in page.seen)
        them.tap(them.pages[0], PlayOwn(True))
        wait_for(lambda: them.owners.overview.playing == 1)
        found = them.owners.overview
        assert (found.learners, found.rewards) == (FEWEST_SHOWN - 1, ())
        them.pages.append(last)
        them.owners.look()
        them.until(lambda: "own_ground" in last.seen)
        wait_for(lambda: len(them.owners.overview.rewards) == FEWEST_SHOWN)
        rewards = [reward for _, reward in them.owners.overview.rewards]
        assert rewards == sorted(rewards, reverse=True)


# --- In a lesson ----------------------------------------------------------------------------------


LESSON = """
title: Around
minutes: 3
setup: {preset: timed, set: {world.size: 40}, seed: 3, start: 60, schedule: "off", speed: 50000}
show: [play, layer.value, curve]
steps:
  - say: Look.
  - id: way
    ask: direction
    text: Which way?
    options: [clockwise, counter-clockwise, both ways, not at all]
    reveal: {measure: spread_direction, at: +50}
  - do: {command: introduce, skill: circle_clockwise, explore: {trials: 70, chance: 0.5}}
    text: Add it.
    unlock: [add_skill, explore]
    check: {present: circle_clockwise}
    hints: [Add it., Press it., {do: true}]
"""


def in_lesson(*acts: Act) -> Status:
    """How a lab stands that is in that lesson, once this was done in it."""
    lesson = lessons.parse(LESSON, "around.yaml")
    took = TookLesson(
        0, "around", "", lesson.digest, LongText(LESSON), "en", 60, follows=False, is_anew=True
    )
    stories = Stories().after(took)
    for act in acts:
        stories = stories.after(act)
    return replace(stood(), stories=stories)


def test_a_lesson_says_how_they_begin_and_what_they_can_do() -> None:
    first = offer_of(in_lesson())
    assert first is not None
    beginning = first.beginning
    assert (beginning.preset, beginning.seed, beginning.start) == ("timed", 3, 60)
    assert (beginning.schedule, beginning.speed, beginning.spec.world.size) == (False, 50_000.0, 40)
    assert beginning.explorations == (("circle_clockwise", 70, 0.5),)
    assert (first.controls, first.holds) == (("play",), False)
    asked = offer_of(in_lesson(WentToCard(1)))
    assert asked == first._replace(holds=True)
    answered = (WentToCard(1), Answered("way", '"clockwise"'), Committed("way", None))
    assert offer_of(in_lesson(*answered)) == first
    last = offer_of(in_lesson(*answered, WentToCard(2)))
    assert last == first._replace(controls=("play", "add_skill", "explore"))
    # Without a lesson they are like the presenter's run, but never one of results.
    plain = offer_of(stood())
    assert plain == Offer(Beginning("timed", SPEC, SEED))
    assert offer_of(replace(stood(), is_own=False)) is None


def test_while_something_is_to_be_predicted_they_stand_still() -> None:
    offered, asked = offer_of(in_lesson()), offer_of(in_lesson(WentToCard(1)))
    assert offered is not None
    assert asked is not None
    with group() as them:
        (page,) = them.pages
        them.owners.offer(offered)
        them.until(lambda: " is 4: 3 and" in them.part(page).get("whose", ""))
        them.tap(page, PlayOwn(True))
        them.until(lambda: them.part(page)["playing"])
        them.owners.offer(asked)
        them.until(lambda: them.part(page)["controls"] == [])
        assert "until that is answered" in them.part(page)["notice"]
        own = them.own(page)
        assert own is not None
        step = own.run.step
        them.owners.offer(offered)
        # It goes on as it was.
        wait_for(lambda: own.run.step > step)


# --- At the port ----------------------------------------------------------------------------------


@pytest.fixture
def audience() -> Iterator[Audience]:
    made = Audience(lambda _: None, "127.0.0.1", 0, has_own=True)
    yield made
    made.close()


def stood() -> Status:
    """How a lab stands that has just begun."""
    return Own(Beginning("timed", SPEC, SEED), SEED).status()


def until(page: Page, condition: Callable[[dict[str, dict[str, Any]]], bool]) -> None:
    while not condition(page.parts):
        page.receive()


def test_each_browser_has_one_and_all_its_pages_show_it(audience: Audience) -> None:
    audience.show(stood(), None)
    port = audience.watchers.port
    one, other = Page.seated(port), Page.seated(port)
    for page in (one, other):
        page.send(OWN)
        page.receive_until("lab", "own", "own_world", "own_ground", "own_words")
    assert one.parts["own"]["whose"] != other.parts["own"]["whose"]
    one.send({"do": "own_play", "on": True})
    until(one, lambda parts: parts["own"]["playing"])
    assert not other.parts["own"]["playing"]
    wait_for(lambda: audience.own is not None and audience.own.learners == 2)
    # Where the class ends there is none any more.
    assert audience.seats is not None
    audience.seats.forget()
    wait_for(lambda: audience.own is not None and audience.own.learners == 0)
    for page in (one, other):
        page.close()


def test_in_a_class_they_are_asked_as_well() -> None:
    audience = Audience(lambda _: None, "127.0.0.1", 0, is_class=True, has_own=True)
    try:
        audience.show(stood(), None)
        page = Page.seated(audience.watchers.port)
        page.send(OWN)
        page.receive_until("own", "lab", "stand", "lesson", "seat")
        assert f"seat {page.parts['seat']['seat']['number']}," in page.parts["own"]["whose"]
        assert audience.room is not None
        audience.room.end()
        until(page, lambda parts: parts["seat"]["seat"] is None and not parts["own"]["whose"])
        assert page.parts["own"]["notice"].startswith("You have no seat now")
        wait_for(lambda: audience.own is not None and audience.own.learners == 0)
        page.close()
    finally:
        audience.close()


def test_without_a_seat_there_is_none(audience: Audience) -> None:
    audience.show(stood(), None)
    page = Page(audience.watchers.port)
    page.send(OWN)
    page.send({"do": "own_play", "on": True})
    page.receive_until("own")
    assert page.parts["own"]["controls"] == []
    other = Page.seated(audience.watchers.port)
    other.send(OWN)
    other.receive_until("own")
    wait_for(lambda: audience.own is not None and audience.own.learners == 1)
    page.close()
    other.close()


def test_whatever_is_sent_does_nothing_to_others(audience: Audience) -> None:
    """Hostile taps: what is no tap is dropped, and what is one is done with one's own learner."""
    audience.show(stood(), None)
    port = audience.watchers.port
    calm, wild = Page.seated(port), Page.seated(port)
    for page in (calm, wild):
        page.send(OWN)
        page.receive_until("own_ground", "own_words", "own_over")
    before = dict(calm.parts)
    with contextlib.suppress(ConnectionClosed):
        for message in (
            {"do": "own_play", "on": True, "seat": 1},
            {"do": "own_add", "skill": "__import__('os')"},
            {"do": "own_add", "skill": "<script>"},
            {"do": "own_explore", "skill": "no such skill", "on": True},
            {"do": "own_explore", "skill": "approach", "on": True},
            {"do": "own_freeze", "on": True},
            {"do": "own_speed", "level": 10**9},
            {"do": "own_speed", "level": 4},
            {"do": "own_play", "on": True},
        ):
            wild.send(message)
    until(wild, lambda parts: parts["own"]["playing"])
    assert calm.parts == before
    calm.send({"do": "own_speed", "level": 0})
    until(calm, lambda parts: control(parts["own"], "speed")["level"] == 0)
    assert not calm.parts["own"]["playing"]
    for page in (calm, wild):
        page.close()


def test_they_have_nothing_to_do_with_the_session(tmp_path: Path) -> None:
    from app.live.requests import Pause, Play
    from tests.support.live import LiveLab

    live = LiveLab(preset_of(), 20_000.0, tmp_path, own=True)
    try:
        assert live.audience is not None
        live.go_to_trial(10)
        live.audience.show(live.session.status, None)
        page = Page.seated(live.audience.watchers.port)
        page.send(OWN)
        page.receive_until("own_ground")
        before = live.ask(Play())
        page.send({"do": "own_speed", "level": 4})
        page.send({"do": "own_play", "on": True})
        page.send({"do": "own_add", "skill": "avoid"})
        until(page, lambda parts: control(parts["own"], "add_skill")["options"][-1][0] != "avoid")
        first = page.parts["own_ground"]
        until(page, lambda parts: parts["own_ground"] != first)
        after = live.ask(Pause())
        assert (after.speed, after.marks) == (before.speed, before.marks)
        snapshot = after.snapshot
        past = live.session.past_of(snapshot.generation)
        assert past is not None
        made = past.run_at(snapshot.step)
        assert made is not None
        alone = replay(snapshot.preset_spec, SEED, [], snapshot.step)
        assert digest(made.state) == digest(alone.state)
        page.close()
    finally:
        live.close()


def test_nothing_that_a_page_is_sent_is_a_secret_or_anothers(audience: Audience) -> None:
    audience.show(stood(), None)
    pages = [Page.seated(audience.watchers.port) for _ in range(3)]
    for page in pages:
        page.send(OWN)
        page.receive_until(*(kind for kind in own_view.ORDER))
    for page in pages:
        assert page.parts.keys() <= {*own_view.ORDER, "lab", "stand", "lesson"}
        assert "seat" in page.parts["own"]["whose"]
        page.close()
