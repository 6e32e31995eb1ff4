"""A channel between the lab and the page in a browser's frame, and who is kept out of it."""

import queue
import socket
from collections.abc import Iterator
from typing import Any

import msgspec
import pytest
import websockets.sync.client

from app.server.channels import Channel, Channels
from tests.support.server import PATIENCE_S, Lab, lab_of


class Seek(msgspec.Struct, tag_field="do", tag="seek", forbid_unknown_fields=True):
    """A message with something in it."""

    step: int


class Pause(msgspec.Struct, tag_field="do", tag="pause", forbid_unknown_fields=True):
    """A message that says no more than that."""


class Frame:
    """The page of a frame, as far as the server can tell."""

    def __init__(self, port: int, address: str, **headers: str) -> None:
        given = {"Origin": f"http://127.0.0.1:{port}"} | headers
        self.socket = websockets.sync.client.connect(
            f"ws://127.0.0.1:{port}/{address}socket",
            sock=socket.create_connection(("127.0.0.1", port)),
            additional_headers={name: value for name, value in given.items() if value},
        )

    def send(self, message: dict[str, Any]) -> None:
        self.socket.send(msgspec.json.encode(message).decode())

    def receive(self) -> dict[str, Any]:
        return msgspec.json.decode(self.socket.recv(timeout=PATIENCE_S))


class Host:
    """A lab with the channel of one browser."""

    def __init__(self, lab: Lab, channels: Channels) -> None:
        self.lab, self.channels = lab, channels
        self.taken: queue.Queue[Seek | Pause] = queue.Queue()
        self.opened: queue.Queue[None] = queue.Queue()
        self.channel: Channel = channels.enter(
            Seek | Pause, self.taken.put, lambda: self.opened.put(None)
        )

    def frame(self, **headers: str) -> Frame:
        frame = Frame(self.lab.port, self.channel.address, **headers)
        self.opened.get(timeout=PATIENCE_S)
        return frame


@pytest.fixture
def host() -> Iterator[Host]:
    channels = Channels()
    with lab_of(channels=channels) as lab:
        yield Host(lab, channels)


def test_messages_go_both_ways(host: Host) -> None:
    frame = host.frame()
    assert host.channel.is_open
    frame.send({"do": "seek", "step": 12})
    assert host.taken.get(timeout=PATIENCE_S) == Seek(12)
    host.channel.send("bar", {"trials": [1, 2]})
    assert frame.receive() == {"kind": "bar", "trials": [1, 2]}
