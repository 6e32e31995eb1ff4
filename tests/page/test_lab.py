"""The lab itself, and pages that do to it what pages should not."""

import io
import re
import sys
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from http import HTTPStatus
from pathlib import Path
from typing import Any

import msgspec
import pytest
import viser
from viser import _messages as wire

from app.documents import presets
from app.live.requests import SetSpeed
from app.live.session import Session
from app.page import lab as page_lab
from app.page import widgets
from app.page.browser import Browser
from app.page.inbox import Intent
from app.page.lab import Lab
from app.server import admission
from app.server.workers import MOST_OF_ONE_PAGE
from app.util.logs import LEVELS, sparing_log
from tests.support.person import Person
from tests.support.server import CAMERA, PATIENCE_S, Page, is_update

SPEC = presets.load("timed", ["world.size=40", "trials=1000000"])


@contextmanager
def drawing(session: Session, results: Path, waits: bool = False) -> Iterator[Lab]:
    """A lab that draws this session."""
    lab = Lab(session, {"timed": SPEC}, "127.0.0.1", 0, results, waits=waits)
    loop = threading.Thread(target=lab.serve)
    loop.start()
    yield lab
    lab.close()
    loop.join()


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Lab]:
    """A lab whose learner begins when a browser has drawn the board."""
    session = Session(SPEC, "timed", 7, 100.0, playing=False)
    session.start()
    with drawing(session, tmp_path / "results", waits=True) as lab:
        yield lab


def a_page(lab: Lab) -> Page:
    return Page(lab.server.get_port())


def speed_of(lab: Lab) -> Any:
    """The slider for the speed."""
    return Person(lab.server.gui).widget("100 steps/s")


def tell_drawn(lab: Lab, page: Page) -> None:
    """Do what the page's script does when the board has been drawn."""

    def called(message: dict[str, Any]) -> re.Match[str] | None:
        return re.search('data-drawn-call="([^"]*)"', str(message.get("props", {}).get("content")))

    found = called(page.receive_until(lambda message: called(message) is not None)[-1])
    assert found is not None
    question = urllib.request.Request(
        f"{lab.url}/{found.group(1)}", headers={"Sec-Fetch-Site": "same-origin"}
    )
    with urllib.request.urlopen(question, timeout=PATIENCE_S) as answer:
        assert answer.status == HTTPStatus.NO_CONTENT


def test_learning_begins_when_a_page_has_drawn_the_board(lab: Lab) -> None:
    page = a_page(lab)
    page.send(CAMERA)
    wait_until(lambda: len(lab.browsers) == 1)
    ticket = lab.session.submit(SetSpeed(2_000.0))
    status = lab.session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)
    assert not status.playing
    tell_drawn(lab, page)
    lab.session.wait_for(lambda status: status.playing, PATIENCE_S)
    page.close()


def test_learning_does_not_wait_for_ever_for_a_page_that_says_nothing(
    lab: Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page_lab, "_UNSEEN_S", 0.0)
    page = a_page(lab)
    page.send(CAMERA)
    lab.session.wait_for(lambda status: status.playing, PATIENCE_S)
    page.close()


def test_a_change_before_the_first_picture_leaves_it_to_begin(lab: Lab) -> None:
    go_on = hold(lab)
    page = a_page(lab)
    page.send(CAMERA)
    page.set(speed_of(lab), 5.0)
    ticket = lab.session.submit(SetSpeed(2_000.0))
    lab.session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)
    assert not lab.session.status.playing
    go_on.set()
    tell_drawn(lab, page)
    lab.session.wait_for(lambda status: status.speed == 100_000.0 and status.playing, PATIENCE_S)
    page.close()


def hold(lab: Lab) -> threading.Event:
    """Keep the render loop busy until this is set."""
    busy, go_on = threading.Event(), threading.Event()
    lab.inbox.put(lambda: (busy.set(), go_on.wait(PATIENCE_S)))
    assert busy.wait(PATIENCE_S)
    return go_on


def test_what_a_page_does_is_done_in_order_and_all_of_it_by_one_thread(lab: Lab) -> None:
    threads: set[int] = set()
    done: dict[int, str] = {}

    def do(client: viser.ClientHandle, place: str) -> None:
        threads.add(threading.get_ident())
        done[client.client_id] = done.get(client.client_id, "") + place

    button = lab.server.gui.add_button_group("Do", tuple("0123"))
    button.on_click(Intent(do))
    pages = [a_page(lab) for _ in range(3)]
    for page in pages:
        page.send(CAMERA)
    wait_until(lambda: len(lab.browsers) == 3)
    go_on = hold(lab)
    for page in pages:
        for place in "0123":
            page.set(button, place)
    go_on.set()
    wait_until(lambda: sum(map(len, done.values())) == 12)
    assert [*done.values()] == ["0123"] * 3
    assert len(threads) == 1
    for page in pages:
        page.close()


def test_a_page_that_asks_faster_than_the_loop_draws_waits_and_the_others_are_heard(
    lab: Lab,
) -> None:
    done: list[int] = []
    button = lab.server.gui.add_button_group("Do", ["it"])
    button.on_click(Intent(lambda client, _: done.append(client.client_id)))
    greedy, other = a_page(lab), a_page(lab)
    for page in (greedy, other):
        page.send(CAMERA)
    wait_until(lambda: len(lab.browsers) == 2)
    first, second = (browser.client.client_id for browser in lab.browsers)
    go_on = hold(lab)
    for _ in range(200):
        greedy.set(button, "it")
    other.set(button, "it")
    wait_until(lambda: not lab.inbox.is_free_for(first))
    go_on.set()
    wait_until(lambda: second in done)
    assert done.index(second) <= MOST_OF_ONE_PAGE * 3
    wait_until(lambda: done.count(first) == 200)
    for page in (greedy, other):
        page.close()


def test_a_page_that_asks_and_asks_has_nothing_drawn_more_often(
    lab: Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[object] = []

    # No frame comes by itself, nor one for somebody who has just had one.
    monkeypatch.setattr(page_lab, "_FRAME_S", 3_600.0)
    monkeypatch.setattr(page_lab, "_ANSWER_S", 3_600.0)
    # What every frame ends with.
    monkeypatch.setattr(lab.gallery, "keep", drawn.append)

    def ask() -> None:
        heard = threading.Event()
        lab.wake()
        lab.inbox.put(heard.set)
        assert heard.wait(PATIENCE_S)

    for _ in range(40):
        ask()
    # One may have been due already.
    asked = len(drawn)
    assert asked <= 1
    monkeypatch.setattr(page_lab, "_ANSWER_S", 0.0)
    ask()
    ask()
    assert len(drawn) > asked


def test_what_an_intent_raises_is_told_to_its_page_alone_and_the_lab_goes_on(lab: Lab) -> None:
    def fail(*_: object) -> None:
        raise ValueError("no such thing")

    button = lab.server.gui.add_button("Do")
    button.on_click(Intent(fail))
    pages = [a_page(lab), a_page(lab)]
    for page in pages:
        page.send(CAMERA)
    wait_until(lambda: len(lab.browsers) == 2)
    pages[0].set(button, True)
    (*_, said) = pages[0].receive_until(
        lambda message: (message.get("props") or {}).get("title") == "That did not work"
    )
    assert said["props"]["body"] == "ValueError: no such thing"
    pages[0].set(speed_of(lab), 5.0)
    lab.session.wait_for(lambda status: status.speed == 100_000.0, PATIENCE_S)
    lab.browsers[1].client.add_notification("End", "")
    told = [
        message["props"]["title"]
        for message in pages[1].receive_until(
            lambda message: (message.get("props") or {}).get("title") == "End"
        )
        if message["type"] == "NotificationShowMessage"
    ]
    assert told == ["End"]
    for page in pages:
        page.close()


def test_a_browser_that_leaves_while_it_is_welcomed_is_forgotten(
    lab: Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    welcoming = threading.Event()
    drawn: list[int] = []

    class Hesitant(Browser):
        """Sets itself up only once the first page has left."""

        def __init__(self, *about: Any) -> None:
            welcoming.set()
            wait_until(lambda: 0 not in lab.server.get_clients())
            super().__init__(*about)

        def update(self, *moment: Any) -> None:
            drawn.append(self.client.client_id)

    monkeypatch.setattr(page_lab, "Browser", Hesitant)
    hasty, patient = a_page(lab), a_page(lab)
    hasty.send(CAMERA)
    assert welcoming.wait(PATIENCE_S)
    hasty.close()
    patient.send(CAMERA)
    wait_until(lambda: [browser.client.client_id for browser in lab.browsers] == [1])
    drawn.clear()
    wait_until(lambda: len(drawn) > 3)
    assert {*drawn} == {1}
    patient.close()


class Unanswered(Session):
    """Has no worker: what is asked for waits, and is answered when the test says so."""

    def __init__(self) -> None:
        super().__init__(SPEC, "timed", 7, 100.0, playing=False)

    def answer(self, tickets: int) -> None:
        """Say that so many requests have been answered, and that none has changed anything."""
        self._status = replace(self._status, answered=tickets)

    def stop(self) -> None:
        if self._thread.is_alive():
            super().stop()


@pytest.fixture
def unanswered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Lab]:
    """A lab where nothing is answered until the session is told to, or started."""
    monkeypatch.setattr(widgets, "TOUCHED_S", -1.0)
    monkeypatch.setattr(page_lab, "_ANSWER_S", 0.0)
    with drawing(Unanswered(), tmp_path / "results") as lab:
        yield lab


def do(lab: Lab, act: Callable[[], object]) -> None:
    """Have something done in the render loop, and a whole frame drawn after it."""
    lab.inbox.put(act)
    lab.inbox.put(lab.wake)
    # What was put last may be held before the frame; the next is not before it is drawn.
    for _ in range(2):
        hold(lab).set()


def test_nothing_is_shown_before_the_own_request_is_answered(unanswered: Lab) -> None:
    person, session = Person(unanswered.server.gui), unanswered.session
    do(unanswered, lambda: person.check("Freeze selection"))
    assert person.value("Freeze selection"), "what was asked for may be true soon"
    session.start()
    session.wait_for(lambda status: status.snapshot.control.selection_frozen, PATIENCE_S)
    do(unanswered, lambda: None)
    assert person.value("Freeze selection")


def test_of_two_requests_the_first_answer_is_not_enough(unanswered: Lab) -> None:
    person, session = Person(unanswered.server.gui), unanswered.session
    assert isinstance(session, Unanswered)
    do(unanswered, lambda: person.check("Freeze selection"))
    do(unanswered, lambda: person.check("Freeze skills"))
    do(unanswered, lambda: session.answer(1))
    assert (person.value("Freeze selection"), person.value("Freeze skills")) == (True, True)
    do(unanswered, lambda: session.answer(2))
    assert (person.value("Freeze selection"), person.value("Freeze skills")) == (False, False)


def test_the_schedule_shows_nothing_before_the_own_request_is_answered(unanswered: Lab) -> None:
    person, session = Person(unanswered.server.gui), unanswered.session
    do(unanswered, lambda: person.choose("Change", "avoid: joins"))
    at = int(person.value("At trial").replace(",", ""))
    for _ in range(2):
        # The second goes on from what the first has asked for.
        do(unanswered, lambda: person.click("+500"))
        assert person.value("At trial") == f"{at:,}"
        assert person.value("Change") == "avoid: joins"
    session.start()
    session.wait_for(lambda status: status.answered == 2, PATIENCE_S)
    do(unanswered, lambda: None)
    assert person.value("At trial") == f"{at + 1_000:,}"


def test_a_new_exploration_stays_chosen_until_it_is_there(unanswered: Lab) -> None:
    person, session = Person(unanswered.server.gui), unanswered.session
    do(unanswered, lambda: person.choose("Change", "approach: new exploration"))
    do(unanswered, lambda: person.click("Add"))
    assert person.value("Change") == "approach: new exploration"
    session.start()
    session.wait_for(lambda status: status.answered == 1, PATIENCE_S)
    do(unanswered, lambda: None)
    assert person.value("Change") == "approach: exploration"


def wait_until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def test_a_lab_that_is_asked_to_tells_what_pages_do(
    lab: Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = io.StringIO()
    monkeypatch.setattr(sys, "stderr", terminal)
    slider = speed_of(lab)
    with sparing_log(LEVELS["debug"]):
        page = a_page(lab)
        page.send(CAMERA)
        page.set(slider, 3.0)
        lab.session.wait_for(lambda status: status.speed == 1_000.0, PATIENCE_S)
        page.close()
    assert "a page has come: 1 are open\n" in terminal.getvalue()
    assert "asked for SetSpeed(" in terminal.getvalue()


def test_nothing_of_a_page_reaches_the_terminal_raw(
    lab: Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = io.StringIO()
    monkeypatch.setattr(admission, "GRACE_S", 0.0)
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(sys, "stdout", terminal)
    slider = speed_of(lab)
    with sparing_log():
        page = a_page(lab)
        page.send(CAMERA)
        for text in ("\x1b]0;mine\x07\x1b[2J", "A" * 3_000_000):
            fields = CAMERA.as_serializable_dict() | {"wxyz": [text]}
            page.send_frame(msgspec.msgpack.encode(fields))
        page.set(slider, 3.0)
        lab.session.wait_for(lambda status: status.speed == 1_000.0, PATIENCE_S)
        page.send(wire.GuiUpdateMessage(slider._impl.uuid, {"value": "\x1b[2J"}))
        page.receive_until(lambda message: is_update(message, slider))
        page.close()
    assert "\x1b" not in terminal.getvalue()
    assert len(terminal.getvalue()) < 1_000


def test_refused_messages_leave_one_notification(lab: Lab) -> None:
    page = a_page(lab)
    page.send(CAMERA)
    wait_until(lambda: len(lab.browsers) == 1)
    speed = speed_of(lab)
    for _ in range(3_000):
        page.send(wire.ShareUrlRequest())
    page.set(speed, 3.0)
    lab.session.wait_for(lambda status: status.speed == 1_000.0, PATIENCE_S)
    (browser,) = lab.browsers
    browser.client.add_notification("End", "")
    standing: set[str] = set()
    for message in page.receive_until(
        lambda message: (message.get("props") or {}).get("title") == "End"
    )[:-1]:
        if message["type"] == "NotificationShowMessage":
            standing.add(message["uuid"])
        elif message["type"] == "RemoveNotificationMessage":
            standing.discard(message["uuid"])
    assert len(standing) == 1
    page.close()
