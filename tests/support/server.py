"""A real server on a free port, and pages that misbehave."""

import http.client
import queue
import socket
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import msgspec
import pytest
import viser
import websockets.sync.client
import zstandard
from viser import _messages as wire
from websockets.exceptions import ConnectionClosed

from app.server.server import open_server

PATIENCE_S = 60.0
"""How long to wait for what must happen; reaching it is a failure."""

CAMERA = wire.ViewerCameraMessage(
    wxyz=(1.0, 0.0, 0.0, 0.0),
    position=(0.0, 0.0, 5.0),
    fov=1.0,
    near=0.1,
    far=100.0,
    image_height=600,
    image_width=900,
    look_at=(0.0, 0.0, 0.0),
    up_direction=(0.0, 1.0, 0.0),
)


class Page:
    """One browser page, as far as the server can tell."""

    def __init__(
        self, port: int, name: str = "127.0.0.1", port_in_name: bool = True, **options: Any
    ) -> None:
        self._socket = websockets.sync.client.connect(
            f"ws://{name}:{port}" if port_in_name else f"ws://{name}",
            sock=socket.create_connection(("127.0.0.1", port)),
            subprotocols=[f"viser-v{viser.__version__}"],  # type: ignore[list-item]
            compression=None,
            max_size=None,
            max_queue=None,
            open_timeout=PATIENCE_S,
            ping_interval=None,
            **options,
        )

    def send(self, message: wire.Message) -> None:
        self.send_frame(msgspec.msgpack.encode(message.as_serializable_dict()))

    def send_frame(self, frame: bytes | str) -> None:
        self._socket.send(frame)

    def set(self, handle: Any, value: Any) -> None:
        self.update(handle, {"value": value})

    def update(self, handle: Any, updates: dict[Any, Any]) -> None:
        self.send(wire.GuiUpdateMessage(handle._impl.uuid, updates))

    def receive_until(self, wanted: Callable[[dict[str, Any]], bool]) -> list[dict[str, Any]]:
        """All messages up to and with the first that is wanted."""
        received: list[dict[str, Any]] = []
        while True:
            frame = self._socket.recv(timeout=PATIENCE_S)
            assert isinstance(frame, bytes)
            size, packed_size = (int.from_bytes(frame[i : i + 8], "little") for i in (0, 8))
            content = zstandard.decompress(frame[16 : 16 + packed_size], max_output_size=size)
            for message in msgspec.msgpack.decode(content)["messages"]:
                received.append(message)
                if wanted(message):
                    return received

    def close_code(self) -> int:
        """The code with which the server ends this connection."""
        with pytest.raises(ConnectionClosed) as closed:
            self.receive_until(lambda _: False)
        assert closed.value.rcvd is not None
        return closed.value.rcvd.code

    def close(self) -> None:
        self._socket.close()


class Lab:
    """A server, what it refused, and a widget that shows that it still listens."""

    def __init__(self, **options: Any) -> None:
        self.refused: queue.Queue[tuple[int, str]] = queue.Queue()
        self.connected: queue.Queue[viser.ClientHandle] = queue.Queue()
        self.server = open_server(
            port=0, on_refused=lambda *refusal: self.refused.put(refusal), **options
        )
        self.port = self.server.get_port()
        self.server.on_client_connect(self.connected.put)
        self._probe = self.server.gui.add_checkbox("Probe", False)
        self._heard = threading.Event()
        self._probe.on_update(lambda _: self._heard.set())
        self._pages: list[Page] = []

    def page(self) -> tuple[Page, viser.ClientHandle]:
        page = self.silent_page()
        page.send(CAMERA)
        return page, self.connected.get(timeout=PATIENCE_S)

    def silent_page(self) -> Page:
        """A page that has not drawn its first picture."""
        page = Page(self.port)
        self._pages.append(page)
        return page

    def hears(self, page: Page) -> bool:
        """Send a legal message and wait for its callback: all before it has then been handled."""
        self._heard.clear()
        page.set(self._probe, not self._probe.value)
        return self._heard.wait(PATIENCE_S)

    def reason(self) -> str:
        return self.refused.get(timeout=PATIENCE_S)[1]

    def is_probe(self, message: dict[str, Any]) -> bool:
        return is_update(message, self._probe)

    def close(self) -> None:
        for page in self._pages:
            page.close()
        self.server.stop()


def is_update(message: dict[str, Any], handle: Any) -> bool:
    return message["type"] == "GuiUpdateMessage" and message["uuid"] == handle._impl.uuid


@contextmanager
def lab_of(**options: Any) -> Iterator[Lab]:
    lab = Lab(**options)
    try:
        yield lab
    finally:
        lab.close()


OWN = {"Sec-Fetch-Site": "same-origin"}
"""What a browser adds to a request that our own page made it send."""


def get(port: int, **headers: str) -> http.client.HTTPResponse:
    return get_path(port, "/", headers)


def get_path(port: int, path: str, headers: Mapping[str, str]) -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE_S)
    connection.request("GET", path, headers=dict(headers))
    return connection.getresponse()


def status_of_raw(port: int, *lines: str) -> int:
    """The status with which a request of exactly these header lines is answered."""
    return int(first_line_for(port, "GET / HTTP/1.1", *lines).split()[1])


def first_line_for(port: int, *lines: str) -> bytes:
    """How the answer to a request of exactly these lines begins; nothing if there is none."""
    request = "\r\n".join((*lines, "", ""))
    with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S) as raw:
        raw.sendall(request.encode("utf-8", "surrogateescape"))
        return raw.makefile("rb").readline()


def start_of(handle: Any, transfer: str = "t", **changes: Any) -> wire.FileTransferStartUpload:
    fields = {"filename": "preset.yaml", "mime_type": "", "part_count": 1, "size_bytes": 3}
    return wire.FileTransferStartUpload(handle._impl.uuid, transfer, **(fields | changes))


def part_of(handle: Any, content: bytes, transfer: str = "t") -> wire.FileTransferPart:
    return wire.FileTransferPart(handle._impl.uuid, transfer, 0, content)


class UploadLab(Lab):
    """A lab with an upload button in everyone's panel, and a page with one in its own."""

    def __init__(self) -> None:
        super().__init__(max_upload_bytes=1024)
        self.files: queue.Queue[viser.UploadedFile] = queue.Queue()
        self.first_page, client = self.page()
        self.shared = self.server.gui.add_upload_button("File")
        self.own = client.gui.add_upload_button("File")
        self.guis = (self.server.gui, client.gui)
        for button in (self.shared, self.own):
            button.on_upload(lambda event: self.files.put(event.target.value))

    def transfers(self) -> set[str]:
        return {name for gui in self.guis for name in gui._current_file_upload_states}
