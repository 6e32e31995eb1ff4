"""Browsers that read every frame and draw nothing: ``python -m benchmarks.page_client PORT N``.

They run in a process of their own, so that what is measured is the page and not its readers. Each
line on standard input asks for so many clicks on *Play* or *Pause* by one more browser; a line on
standard output answers: a JSON list of the milliseconds until each click showed its effect.
"""

import json
import re
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import msgspec.msgpack
import viser
import zstandard
from viser import _messages as wire
from websockets.sync.client import ClientConnection, connect

from app.server.admission import DOUBLE_S

_CAMERA = wire.ViewerCameraMessage(
    wxyz=(1.0, 0.0, 0.0, 0.0),
    position=(0.0, 0.0, 10.0),
    fov=1.0,
    near=0.01,
    far=1000.0,
    image_height=768,
    image_width=1366,
    look_at=(0.0, 0.0, 0.0),
    up_direction=(0.0, 1.0, 0.0),
)
"""A browser counts as connected once it has said where its camera is."""

_HINT = "Let the learner go on, or hold it still"
"""How what the button explains itself by begins: experiments have a button of the same name, and
this one is called otherwise once a run is over."""
_PLAYING = "Pause"
"""What the button says while the learner learns."""
_STANDING = "Play"
"""What it says while the learner stands still."""
_OWN = "Layer"
"""What a page of one's own has: before it is there, clicks are not taken."""
_FRAME = re.compile(r'src="(?P<address>time/[^"]+)"')
_PATIENCE_S = 60.0
_PAUSE_S = DOUBLE_S + 0.1
"""From one click's effect to the next click, which is not to be the second of a double click."""


def opened(port: int) -> ClientConnection:
    """A connection such as a browser makes."""
    connection = connect(
        f"ws://127.0.0.1:{port}",
        subprotocols=[f"viser-v{viser.__version__}"],  # pyright: ignore[reportArgumentType]
        max_size=None,
        compression=None,
        # This machine is reached directly, whatever proxy the environment names for the rest.
        proxy=None,
    )
    connection.send(msgspec.msgpack.encode(_CAMERA.as_serializable_dict()))
    return connection


def read_for_ever(port: int) -> None:
    """Connect as a browser does, and take in whatever comes, in the page and in its frame."""
    with opened(port) as connection:
        for frame in connection:
            assert isinstance(frame, bytes)
            if any(_opens_frame(port, message) for message in messages_in(frame)):
                break
        for _ in connection:
            pass


def _opens_frame(port: int, message: dict[str, Any]) -> bool:
    """Whether a message shows the frame of the time bar, which then is read as well."""
    if message["type"] != "GuiHtmlMessage":
        return False
    found = _FRAME.search(message["props"]["content"])
    if found is not None:
        threading.Thread(target=_read_frame, args=(port, found["address"]), daemon=True).start()
    return found is not None


def _read_frame(port: int, address: str) -> None:
    place = f"127.0.0.1:{port}"
    with connect(
        f"ws://{place}/{address}socket",
        additional_headers={"Origin": f"http://{place}"},
        max_size=None,
        proxy=None,
    ) as connection:
        for _ in connection:
            pass


class Clicker:
    """A browser that clicks on *Play* or *Pause*, and sees when that has had its effect."""

    def __init__(self, port: int) -> None:
        """Open the page of a lab that stands still; returns once its button takes clicks.

        Raises:
            TimeoutError: it did not in time.
        """
        self._port = port
        self._connection = opened(port)
        self._button = self._label = ""
        self._welcome = False
        self._changed = threading.Condition()
        threading.Thread(target=self._read, daemon=True).start()
        with self._changed:
            if not self._changed.wait_for(
                lambda: self._welcome and self._label == _STANDING, _PATIENCE_S
            ):
                raise TimeoutError("the page has no button to play with")

    def click(self) -> float:
        """Click; returns the seconds until the button said so.

        Raises:
            TimeoutError: it did not in time.
        """
        with self._changed:
            was_playing = self._label == _PLAYING
            began = time.perf_counter()
            self._connection.send(
                msgspec.msgpack.encode(
                    wire.GuiUpdateMessage(self._button, {"value": True}).as_serializable_dict()
                )
            )
            if not self._changed.wait_for(
                lambda: (self._label == _PLAYING) != was_playing, _PATIENCE_S
            ):
                raise TimeoutError(f"a click had no effect: the button says {self._label!r}")
            return time.perf_counter() - began

    def close(self) -> None:
        """Leave the page."""
        self._connection.close()

    def _read(self) -> None:
        for frame in self._connection:
            assert isinstance(frame, bytes)
            for message in messages_in(frame):
                self._take(message)
                _opens_frame(self._port, message)

    def _take(self, message: dict[str, Any]) -> None:
        label = None
        if message["type"] == "GuiDropdownMessage" and message["props"]["label"] == _OWN:
            with self._changed:
                self._welcome = True
                self._changed.notify_all()
        if message["type"] == "GuiButtonMessage":
            label = message["props"]["label"]
            if (message["props"]["hint"] or "").startswith(_HINT):
                self._button = message["uuid"]
        elif message["type"] == "GuiUpdateMessage" and message["uuid"] == self._button:
            label = message["updates"].get("label")
        if label is not None and self._button == message["uuid"]:
            with self._changed:
                self._label = label
                self._changed.notify_all()


def messages_in(frame: bytes) -> Iterator[dict[str, Any]]:
    """The messages in a frame, which begins with two sizes; arrays are left where they are."""
    size, packed = (int.from_bytes(frame[at : at + 8], "little") for at in (0, 8))
    inner = zstandard.decompress(frame[16 : 16 + packed], max_output_size=size)
    yield from msgspec.msgpack.decode(inner)["messages"]


def main() -> None:
    """Read until standard input ends."""
    port, n_clients = int(sys.argv[1]), int(sys.argv[2])
    for _ in range(n_clients):
        threading.Thread(target=read_for_ever, args=(port,), daemon=True).start()
    for line in sys.stdin:
        clicker = Clicker(port)
        took_ms = []
        # Stand still as before in the end: an even number of clicks.
        for _ in range(2 * (int(line) // 2)):
            took_ms.append(round(1_000 * clicker.click(), 1))
            time.sleep(_PAUSE_S)
        clicker.close()
        sys.stdout.write(json.dumps(took_ms) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
