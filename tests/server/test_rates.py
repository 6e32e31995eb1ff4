"""Pages that ask for more than can be done: what is in their queues, and that others are heard."""

import logging
import queue
import threading
from collections.abc import Iterator
from typing import Any

import msgspec
import pytest
import viser
import websockets.sync.client
from viser import _messages as wire
from websockets.exceptions import ConnectionClosed

from app.server import admission, callbacks
from app.server.workers import MOST_OF_ONE_PAGE, Workers
from tests.support.server import (
    CAMERA,
    PATIENCE_S,
    Lab,
    UploadLab,
    lab_of,
    part_of,
    start_of,
)


@pytest.fixture(scope="module")
def lab() -> Iterator[Lab]:
    with lab_of() as lab:
        yield lab


def pool_of(lab: Lab) -> Workers:
    pool = lab.server._thread_executor
    assert isinstance(pool, Workers)
    return pool


def test_held_key_triggers_its_command_once(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    # However slowly they come, these are repeats of one press.
    monkeypatch.setattr("app.server.pace.REPEAT_S", 1_000.0)
    calls: queue.Queue[None] = queue.Queue()
    command = lab.server.gui.add_command("Freeze")
    command.on_trigger(lambda _: calls.put(None))
    page, _ = lab.page()
    for _ in range(2_000):
        page.send(wire.CommandTriggerMessage(command._impl.uuid))
    assert lab.hears(page)
    assert calls.qsize() == 1


def test_of_values_that_come_too_fast_the_newest_is_taken(
    lab: Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    # However slowly they come, they come too fast.
    monkeypatch.setattr("app.server.pace.VALUE_S", 1.0)
    seen: list[int] = []
    slider = lab.server.gui.add_slider("Slider", 0, 5_000, 1, 0)
    slider.on_update(lambda event: seen.append(event.target.value))
    page, _ = lab.page()
    for place in range(1, 1_001):
        page.set(slider, place)
    assert lab.hears(page)
    assert slider.value == 1_000
    assert len(seen) < 500


def test_of_camera_positions_the_newest_is_taken(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.server.pace.VALUE_S", 1.0)
    page, client = lab.page()
    moves: list[float] = []
    client.camera.on_update(lambda camera: moves.append(camera.position[0]))
    fields = CAMERA.as_serializable_dict()
    for place in range(1_000):
        page.send_frame(msgspec.msgpack.encode({**fields, "position": (float(place), 0.0, 5.0)}))
    assert lab.hears(page)
    assert client.camera.position[0] == 999.0
    assert len(moves) < 500


def test_slow_callbacks_of_a_page_fill_no_queue(lab: Lab) -> None:
    hold, started = threading.Event(), queue.Queue[None]()

    def wait(_: Any) -> None:
        started.put(None)
        hold.wait(PATIENCE_S)

    button = lab.server.gui.add_button("Slow")
    button.on_click(wait)
    (greedy, _), (other, _) = lab.page(), lab.page()
    for _ in range(200):
        greedy.set(button, True)
    for _ in range(MOST_OF_ONE_PAGE):
        started.get(timeout=PATIENCE_S)
    # The others are heard, and no more waits for a thread than a page may ask for.
    assert lab.hears(other)
    assert pool_of(lab)._work_queue.qsize() == 0
    assert started.empty()
    hold.set()
    for _ in range(200 - MOST_OF_ONE_PAGE):
        started.get(timeout=PATIENCE_S)


def test_pages_that_are_gone_are_not_counted(lab: Lab) -> None:
    page, client = lab.page()
    assert lab.hears(page)
    page.close()
    lab.page()
    assert pool_of(lab).is_free_for(client.client_id)


def test_refusals_are_told_at_a_bounded_rate(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    # However long it takes to send them.
    monkeypatch.setattr(admission, "TELL_S", 3_600.0)
    page, _ = lab.page()
    for _ in range(2_000):
        page.send(wire.ShareUrlRequest())
    assert lab.hears(page)
    told = lab.refused.qsize()
    assert 1 <= told <= 20
    # The last reason is told as well, though later; of another page, which need not wait as long.
    slider = lab.server.gui.add_slider("Late", 0, 10, 1, 5, disabled=True)
    monkeypatch.setattr(admission, "TELL_S", 0.25)
    monkeypatch.setattr(admission, "GRACE_S", 0.0)
    other, _ = lab.page()
    for _ in range(2):
        other.send(wire.ShareUrlRequest())
    other.set(slider, 7)
    reasons = [lab.reason()]
    while reasons[-1] != "Late is not available now.":
        reasons.append(lab.reason())


def test_page_of_another_version_is_sent_away_in_silence(
    lab: Lab, capfd: pytest.CaptureFixture[str]
) -> None:
    page = websockets.sync.client.connect(
        f"ws://127.0.0.1:{lab.port}",
        subprotocols=["viser-v0.0.x"],
        proxy=None,
        open_timeout=PATIENCE_S,
        ping_interval=None,
    )
    with pytest.raises(ConnectionClosed) as closed:
        page.recv(timeout=PATIENCE_S)
    # By this code the page knows what to say.
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 1002
    assert capfd.readouterr().out == ""


# Uploads


@pytest.fixture
def uploads() -> Iterator[UploadLab]:
    lab = UploadLab()
    yield lab
    lab.close()


def test_a_thousand_uploads_begun_are_one(
    uploads: UploadLab, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(admission, "TELL_S", 3_600.0)
    page = uploads.first_page
    for number in range(1_000):
        page.send(start_of(uploads.own, f"transfer {number}"))
    assert uploads.hears(page)
    assert uploads.transfers() == {"transfer 0"}
    assert uploads.reason() == "File is busy with another file."
    assert uploads.refused.qsize() < 20


def test_an_upload_that_never_ends_makes_room(
    uploads: UploadLab, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = uploads.first_page
    page.send(start_of(uploads.own, "first"))
    assert uploads.hears(page)
    monkeypatch.setattr(admission, "UPLOAD_S", 0.0)
    page.send(start_of(uploads.shared, "second"))
    page.send(part_of(uploads.shared, b"abc", "second"))
    assert uploads.files.get(timeout=PATIENCE_S).content == b"abc"
    assert uploads.transfers() == set()


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ([(0, b"ab"), (1, b"")], "This file is shorter than announced."),
        ([(0, b"abc"), (1, b"d")], "This file is longer than announced."),
    ],
)
def test_a_file_is_as_long_as_announced(
    uploads: UploadLab,
    monkeypatch: pytest.MonkeyPatch,
    recwarn: pytest.WarningsRecorder,
    parts: list[tuple[int, bytes]],
    said: str,
) -> None:
    monkeypatch.setattr(admission._Desk, "_upload_fault", lambda *_: None)
    page = uploads.first_page
    page.send(start_of(uploads.own, part_count=2, filename="\x1b[2J.yaml"))
    for index, content in parts:
        page.send(wire.FileTransferPart(uploads.own._impl.uuid, "t", index, content))
    assert uploads.reason() == said
    assert uploads.hears(page)
    assert uploads.transfers() == set()
    assert uploads.files.empty()
    assert [w for w in recwarn if "viser" in str(w.message)] == []


def test_parts_that_came_or_do_not_exist_are_dropped(uploads: UploadLab) -> None:
    page = uploads.first_page
    page.send(start_of(uploads.own))
    for index in (1, -1, 2**40):
        page.send(wire.FileTransferPart(uploads.own._impl.uuid, "t", index, b"abc"))
    page.send(part_of(uploads.own, b"abc"))
    assert uploads.files.get(timeout=PATIENCE_S).content == b"abc"


def test_failures_of_callbacks_are_told_and_logged_as_texts(
    lab: Lab, caplog: pytest.LogCaptureFixture
) -> None:
    page, client = lab.page()

    def fail(_: viser.ClientHandle) -> None:
        raise ValueError("x" * 1_000_000)

    with caplog.at_level(logging.ERROR):
        callbacks.guarded(fail)(client)
    assert max(len(record.getMessage()) for record in caplog.records) < 400
    assert lab.hears(page)


def test_a_text_that_is_finished_is_taken_though_its_keystrokes_come_behind_it(lab: Lab) -> None:
    seen: list[str] = []
    text = lab.server.gui.add_text("Number", "")

    @text.on_update
    async def _(event: viser.GuiEvent[viser.GuiTextHandle]) -> None:
        # On the event loop: in a thread it might be read after the next one has come.
        seen.append(event.target.value)

    page, _ = lab.page()
    for value in ("14", "14.0", "14.000", "14.000\n", "14.000"):
        page.set(text, value)
    assert lab.hears(page)
    assert "14.000\n" in seen
