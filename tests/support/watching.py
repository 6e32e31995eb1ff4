"""A page of the audience, as far as the port can tell."""

import socket
import zlib
from typing import Any

import msgspec
import websockets.sync.client
from websockets.exceptions import ConnectionClosed

from tests.support.server import PATIENCE_S, get_path


class Page:
    """Connects as a page does, and sends whatever it is told to."""

    def __init__(self, port: int, headers: dict[str, str] | None = None, **options: Any) -> None:
        given = {"Origin": f"http://127.0.0.1:{port}"} | (headers or {})
        self.socket = websockets.sync.client.connect(
            f"ws://127.0.0.1:{port}/socket",
            sock=socket.create_connection(("127.0.0.1", port)),
            additional_headers={name: value for name, value in given.items() if value},
            max_size=None,
            open_timeout=PATIENCE_S,
            ping_interval=None,
            **options,
        )
        self.parts: dict[str, dict[str, Any]] = {}
        """Of each kind what came last."""

    @classmethod
    def seated(cls, port: int) -> "Page":
        """One of a browser that is new, and has been given a seat with the page."""
        cookie = get_path(port, "/", {}).headers["Set-Cookie"].partition(";")[0]
        return cls(port, {"Cookie": cookie})

    def send(self, wish: dict[str, Any]) -> None:
        """Send something as JSON."""
        self.socket.send(msgspec.json.encode(wish).decode())

    def receive(self) -> list[dict[str, Any]]:
        """The parts of the next letter."""
        letter = self.socket.recv(timeout=PATIENCE_S)
        assert isinstance(letter, bytes)
        parts = msgspec.json.decode(zlib.decompress(letter))
        self.parts |= {part["kind"]: part for part in parts}
        return parts

    def receive_until(self, *kinds: str) -> None:
        """Take in letters until there is something of each kind."""
        while not self.parts.keys() >= set(kinds):
            self.receive()

    def close_code(self) -> int:
        """The code with which the server ends this connection; letters before that are lost."""
        try:
            while True:
                self.socket.recv(timeout=PATIENCE_S)
        except ConnectionClosed as closed:
            return 1006 if closed.rcvd is None else closed.rcvd.code

    def close(self) -> None:
        """Leave."""
        self.socket.close()
