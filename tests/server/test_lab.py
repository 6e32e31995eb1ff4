"""The lab itself, and pages that do to it what pages should not."""

import io
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
from viser import _messages as wire

from app.documents import presets
from app.live.session import Session
from app.page.lab import Lab
from app.util.logs import LEVELS, sparing_log
from tests.support.server import CAMERA, PATIENCE_S, Page, is_update

SPEC = presets.load("timed", ["world.size=40", "trials=1000000"])


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Lab]:
    """A lab whose learner begins when the first browser has come."""
    session = Session(SPEC, "timed", 7, 100.0, playing=False)
    lab = Lab(session, {"timed": SPEC}, "127.0.0.1", 0, tmp_path / "results", waits=True)
    session.start()
    yield lab
    lab.close()


def a_page(lab: Lab) -> Page:
    return Page(lab.server.get_port())


def test_a_change_before_the_first_welcome_leaves_it_to_begin(
    lab: Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    speed: Any = lab._controls._speed
    welcome = lab._welcome
    page = a_page(lab)

    def slowly(client: Any) -> None:
        page.set(speed, 5.0)
        lab.session.wait_for(lambda status: status.answered > 0, PATIENCE_S)
        welcome(client)

    lab.server._client_connect_cb[:] = [slowly]
    page.send(CAMERA)
    status = lab.session.wait_for(lambda status: status.playing, PATIENCE_S)
    assert status.speed == 100_000.0
    page.close()


def test_a_lab_that_is_asked_to_tells_what_pages_do(
    lab: Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = io.StringIO()
    monkeypatch.setattr(sys, "stderr", terminal)
    slider: Any = lab._controls._speed
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
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(sys, "stdout", terminal)
    slider: Any = lab._controls._speed
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
    lab.session.wait_for(lambda status: status.playing, PATIENCE_S)
    speed: Any = lab._controls._speed
    for _ in range(3_000):
        page.send(wire.ShareUrlRequest())
    page.set(speed, 2.0)
    lab.session.wait_for(lambda status: status.speed == 100.0, PATIENCE_S)
    browser = next(iter(lab._browsers.values()))
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
