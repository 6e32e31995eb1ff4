"""Pages that take nothing of what is sent to them."""

import asyncio
import logging
import os
import socket
import struct
from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
import pytest
import viser
from viser import _messages as wire
from viser.infra._async_message_buffer import AsyncMessageBuffer

from app.server import admission, outbox
from app.server.notices import tell
from tests.support.server import CAMERA, PATIENCE_S, Lab, lab_of


class DeafPage:
    """A page that never reads, and sends nothing by itself but where its camera is."""

    def __init__(self, port: int, is_mute: bool = False) -> None:
        self._socket = socket.socket()
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self._socket.connect(("127.0.0.1", port))
        self._socket.settimeout(PATIENCE_S)
        self._socket.sendall(
            f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
            f"Sec-WebSocket-Protocol: viser-v{viser.__version__}\r\n\r\n".encode()
        )
        self._socket.recv(12)
        if not is_mute:
            self.send(CAMERA.as_serializable_dict())

    def send(self, fields: dict[str, Any], times: int = 1) -> None:
        frame = msgspec.msgpack.encode(fields)
        head = bytes([0x82, 0x80 | len(frame)])
        if len(frame) > 125:
            head = bytes([0x82, 0x80 | 126]) + struct.pack(">H", len(frame))
        self._socket.sendall((head + bytes(4) + frame) * times)

    def close(self) -> None:
        self._socket.close()


@pytest.fixture
def deaf(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A lab with more to say than fits into the buffers on the way, and a deaf page."""
    monkeypatch.setattr(admission, "WATCH_S", 0.02)
    # It is there until a test has it go, however long that takes to get there.
    monkeypatch.setattr(outbox, "STALL_S", 3_600.0)
    with lab_of() as lab:
        lab.server.gui.add_html(os.urandom(5_000_000).hex())
        page = DeafPage(lab.port)
        client = lab.connected.get(timeout=PATIENCE_S)
        yield lab, page, client
        page.close()


def comes_true(lab: Lab, condition: Callable[[], bool]) -> bool:
    """Whether something becomes so on the server's event loop, in time."""

    async def wait() -> None:
        while not condition():
            await asyncio.sleep(0.01)

    task = asyncio.run_coroutine_threadsafe(wait(), lab.server.get_event_loop())
    try:
        task.result(PATIENCE_S)
    except TimeoutError:
        task.cancel()
        return False
    return True


def is_gone(lab: Lab, client: viser.ClientHandle) -> bool:
    """Whether the server lets a page go, in time."""
    connections = lab.server._websock_server._live_connections
    return comes_true(lab, lambda: client.client_id not in connections)


def queue_of(lab: Lab, client: viser.ClientHandle) -> AsyncMessageBuffer:
    return lab.server._websock_server._client_state_from_id[client.client_id].message_buffer


def test_page_that_takes_nothing_is_let_go(
    deaf: Any, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    lab, _, client = deaf
    other, _ = lab.page()
    other.receive_until(lambda message: message["type"] == "ReplayDoneMessage")
    monkeypatch.setattr(outbox, "STALL_S", 0.3)
    assert is_gone(lab, client)
    assert "has taken nothing for 0.3 s" in caplog.text
    assert lab.hears(other)


def test_page_that_says_nothing_and_takes_nothing_is_let_go(
    deaf: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    lab, _, _ = deaf
    connections = lab.server._websock_server._live_connections
    mute = DeafPage(lab.port, is_mute=True)
    assert comes_true(lab, lambda: len(connections) == 2)
    monkeypatch.setattr(outbox, "STALL_S", 0.3)
    assert comes_true(lab, lambda: not connections)
    mute.close()


@pytest.mark.parametrize(
    ("n", "size", "reason"), [(3_000, 1, "messages wait"), (40, 2**20, "MiB wait")]
)
def test_page_for_which_too_much_waits_is_let_go(
    deaf: Any, caplog: pytest.LogCaptureFixture, n: int, size: int, reason: str
) -> None:
    lab, _, client = deaf
    queue = queue_of(lab, client)
    connection = lab.server._websock_server._live_connections[client.client_id]
    assert comes_true(lab, lambda: connection.transport.get_write_buffer_size() > 0)
    # viser takes one lot out of the queue before it waits for the page.
    queue.push(wire.FileTransferPart("a", "first", 0, b""))
    assert comes_true(lab, lambda: not queue.message_from_id)
    # It may be let go in the middle.
    with queue.sanctioned_dead_writes():
        for number in range(n):
            queue.push(wire.FileTransferPart("a", f"transfer {number}", number, bytes(size)))
    assert is_gone(lab, client)
    assert reason in caplog.text


def test_refused_messages_of_a_deaf_page_pile_up_nothing(deaf: Any) -> None:
    lab, page, client = deaf
    told = []
    queue = queue_of(lab, client)
    before = queue.message_counter

    def tell_it() -> None:
        while not lab.refused.empty():
            told.append(lab.refused.get())
            tell(client, "Not accepted", told[-1][1])

    page.send({"type": "ShareUrlRequest"}, times=2_000)
    # What a page sends is read in the end, though it reads nothing itself.
    probe = {"type": "GuiUpdateMessage", "uuid": lab._probe._impl.uuid, "updates": {"value": True}}
    lab._heard.clear()
    page.send(probe)
    assert lab._heard.wait(PATIENCE_S)
    tell_it()
    assert 1 <= len(told) < 100
    assert len(queue.message_from_id) < 50
    assert queue.message_counter - before < 500


def test_page_that_takes_what_it_is_sent_stays() -> None:
    loop = asyncio.new_event_loop()
    box = outbox.Outbox(AsyncMessageBuffer(loop, persistent_messages=False))
    for second in range(200):
        # Slowly, but it does.
        assert box.fault(100_000 - second, float(second)) is None
    assert box.fault(0, 500.0) is None
    assert box.fault(7, 501.0) is None
    assert box.fault(7, 501.0 + outbox.STALL_S - 1) is None
    assert box.fault(7, 501.0 + outbox.STALL_S) is not None
    loop.close()


def test_arrays_count_with_their_bytes() -> None:
    loop = asyncio.new_event_loop()
    buffer = AsyncMessageBuffer(loop, persistent_messages=False)
    box = outbox.Outbox(buffer)
    array = np.zeros(outbox.MAX_QUEUED_BYTES + 1, np.uint8)
    buffer.push(wire.GuiUpdateMessage("a", {"data": array}))
    assert box.fault(0, 0.0) is None
    assert box.fault(1, 1.0) == "32 MiB wait for it"
    loop.close()


@pytest.fixture(autouse=True)
def all_is_logged(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
