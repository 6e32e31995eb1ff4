"""What is made beside the page's loop: it is given up when the lab ends."""

import logging
import threading
from types import SimpleNamespace
from typing import Any

import pytest

from app.live.session import Session
from app.page.inbox import Inbox, check_there
from tests.support.schedules import small_spec

PATIENCE_S = 60.0


def test_what_is_made_is_given_up_without_a_word_once_the_lab_ends(
    caplog: pytest.LogCaptureFixture,
) -> None:
    session = Session(small_spec(), "timed", 1, 1.0, playing=False)
    session.start()
    inbox, begun = Inbox(lambda: None), threading.Event()
    made: list[object] = []

    def make() -> object:
        begun.set()
        while True:
            check_there(session)

    client: Any = SimpleNamespace(client_id=1)
    with caplog.at_level(logging.DEBUG, "app.server"):
        inbox.work(client, make, made.append)
        assert begun.wait(PATIENCE_S)
        session.stop()
        inbox.shutdown()
    inbox.drain()
    assert made == []
    assert caplog.messages == []
