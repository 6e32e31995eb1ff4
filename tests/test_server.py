"""The door, tested from outside: a real server on a free port, and pages that misbehave."""

import gc
import http.client
import logging
import math
import queue
import re
import socket
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any
from urllib.parse import quote

import msgspec
import pytest
import viser
import websockets.sync.client
import zstandard
from hypothesis import given
from hypothesis import strategies as st
from viser import _messages as wire
from websockets.exceptions import ConnectionClosed, InvalidStatus

from app.server import admission, callbacks, values
from app.server.calls import MAX_CALL_CHARACTERS, Calls, address_of
from app.server.server import MAX_MESSAGE_BYTES, open_server

PATIENCE_S = 10.0
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

    def __init__(self, port: int, name: str = "127.0.0.1", **options: Any) -> None:
        self._socket = websockets.sync.client.connect(
            f"ws://{name}:{port}",
            sock=socket.create_connection(("127.0.0.1", port)),
            subprotocols=[f"viser-v{viser.__version__}"],  # type: ignore[list-item]
            compression=None,
            max_size=None,
            max_queue=None,
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


@pytest.fixture(autouse=True)
def no_grace(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(admission, "GRACE_S", 0.0)


@pytest.fixture
def no_traceback(
    caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> Iterator[None]:
    """The test must not leave a traceback, neither in a log nor on the terminal."""
    yield
    gc.collect()  # When asyncio reports a task that failed.
    records = [*caplog.get_records("call"), *caplog.records]
    assert [record.getMessage() for record in records if record.exc_info] == []
    assert "Traceback" not in capfd.readouterr().err


@pytest.fixture
def lab() -> Iterator[Lab]:
    lab = Lab()
    yield lab
    lab.close()


@contextmanager
def lab_of(**options: Any) -> Iterator[Lab]:
    lab = Lab(**options)
    try:
        yield lab
    finally:
        lab.close()


# --- Requests ------------------------------------------------------------------------------------


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


FOREIGN_ORIGINS = (
    "http://evil.example",
    "http://evil.example:{port}",
    "http://localhost:{other}",
    "http://localhost",
    "https://localhost:{port}",
    "http://localhost:{port}.evil.example",
    "http://evil.example/@localhost:{port}",
    "http://localhost:{port}@evil.example",
    "null",
    "",
)


@pytest.mark.parametrize("origin", FOREIGN_ORIGINS)
def test_foreign_origin_is_refused(lab: Lab, origin: str) -> None:
    origin = origin.format(port=lab.port, other=lab.port - 1)
    with pytest.raises(InvalidStatus) as refusal:
        Page(lab.port, additional_headers={"Origin": origin})
    assert refusal.value.response.status_code == 403
    assert refusal.value.response.body == b"This page belongs to another site.\n"
    assert get(lab.port, Origin=origin).status == 403


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost", "[::1]", "LocalHost"])
def test_own_origin_is_accepted(lab: Lab, name: str) -> None:
    Page(lab.port, origin=f"http://{name}:{lab.port}").close()  # type: ignore[arg-type]
    Page(lab.port, "localhost", origin=f"http://{name}:{lab.port}").close()  # type: ignore[arg-type]


def test_forwarded_port_is_accepted(lab: Lab) -> None:
    assert get(lab.port, Host="localhost:9000", Origin="http://localhost:9000").status == 200
    assert get(lab.port, Host="localhost:9000", Origin="http://localhost:9001").status == 403


@pytest.mark.parametrize(
    "host", ["evil.example", "localhost.evil.example", "192.168.7.7", "localhost."]
)
def test_foreign_host_is_refused(lab: Lab, host: str) -> None:
    with pytest.raises(InvalidStatus) as refusal:
        Page(lab.port, host)
    assert refusal.value.response.status_code == 403
    # A rebound name: the browser thinks that page and server are one site.
    with pytest.raises(InvalidStatus):
        Page(lab.port, host, origin=f"http://{host}:{lab.port}")  # type: ignore[arg-type]
    answer = get(lab.port, Host=f"{host}:{lab.port}")
    assert (answer.status, answer.read()) == (403, b"This is not a name of this server.\n")


def test_host_must_be_there_once(lab: Lab) -> None:
    assert status_of_raw(lab.port, "Host: localhost") == 200
    assert status_of_raw(lab.port) == 403
    assert status_of_raw(lab.port, "Host: localhost", "Host: evil.example") == 403


@pytest.mark.parametrize("upgrade", ["websocket", "WebSocket", "WEBSOCKET"])
def test_spelling_of_upgrade_opens_no_back_door(lab: Lab, upgrade: str) -> None:
    handshake = (
        "Host: localhost",
        "Connection: Upgrade",
        f"Upgrade: {upgrade}",
        "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==",
    )
    assert status_of_raw(lab.port, *handshake) in (101, 200)
    assert status_of_raw(lab.port, *handshake, "origin: http://evil.example") == 403


def test_network_lab_goes_by_same_origin() -> None:
    with lab_of(host="0.0.0.0") as lab:
        address = f"192.168.7.7:{lab.port}"
        own_name = f"{socket.gethostname()}:{lab.port}"
        assert get(lab.port, Host=address).status == 200
        assert get(lab.port, Host=own_name, Origin=f"http://{own_name}").status == 200
        assert get(lab.port, Host=address, Origin=f"http://{address}").status == 200
        assert get(lab.port, Host=address, Origin=f"http://localhost:{lab.port}").status == 403
        assert get(lab.port, Host=address, Origin=f"http://192.168.7.8:{lab.port}").status == 403
        assert get(lab.port, Host=f"evil.example:{lab.port}").status == 403


def test_page_cannot_be_framed(lab: Lab) -> None:
    answer = get(lab.port)
    assert answer.status == 200
    assert b"<title>pounce</title>" in answer.read()
    assert answer.headers["Content-Security-Policy"] == "frame-ancestors 'none'"
    assert answer.headers["X-Frame-Options"] == "DENY"
    assert answer.headers["X-Content-Type-Options"] == "nosniff"


def test_pages_are_limited() -> None:
    with lab_of(max_clients=2) as lab:
        first, _ = lab.page()
        lab.page()
        with pytest.raises(InvalidStatus) as refusal:
            Page(lab.port)
        assert refusal.value.response.status_code == 503
        assert get(lab.port).status == 200
        first.close()
        lab.page()


def test_no_page_is_let_in_before_the_server_is_complete(monkeypatch: pytest.MonkeyPatch) -> None:
    statuses = []

    def complete_slowly(self: viser.GuiApi, **_: Any) -> None:
        statuses.append(get(self._root_server().get_port()).status)

    monkeypatch.setattr(viser.GuiApi, "configure_theme", complete_slowly)
    with lab_of() as lab:
        statuses.append(get(lab.port).status)
    assert statuses == [503, 200]


def test_busy_port_gives_the_next(lab: Lab) -> None:
    second = open_server(port=lab.port)
    try:
        assert second.get_port() > lab.port
        assert get(second.get_port()).status == 200
        # Another lab on this machine is another site.
        assert get(lab.port, Origin=f"http://localhost:{second.get_port()}").status == 403
    finally:
        second.stop()


@pytest.mark.parametrize(
    ("host", "port", "error"),
    [("127.0.0.1", 65_536, ValueError), ("127.0.0.1", -1, ValueError), ("192.0.2.1", 0, OSError)],
)
def test_impossible_address_raises(host: str, port: int, error: type[Exception]) -> None:
    with pytest.raises(error):
        open_server(host, port)


def test_ports_can_run_out() -> None:
    try:
        last = socket.create_server(("127.0.0.1", 65_535))
    except OSError:
        last = None  # Busy already, which serves as well.
    with pytest.raises(OSError, match="no free port"):
        open_server(port=65_535)
    if last is not None:
        last.close()


def test_bypassed_door_raises(monkeypatch: pytest.MonkeyPatch) -> None:
    stopped = []
    unknown = SimpleNamespace(stop=lambda: stopped.append(True))
    monkeypatch.setattr(viser, "ViserServer", lambda **_: unknown)
    with pytest.raises(RuntimeError, match="bypassed"):
        open_server(port=0)
    assert stopped == [True]


# --- Calls ---------------------------------------------------------------------------------------

OWN = {"Sec-Fetch-Site": "same-origin"}
"""What a browser adds to a request that our own page made it send."""


class Callee:
    """Takes the calls that begin with "take", and notes all."""

    def __init__(self) -> None:
        self.calls: list[str] = []

    def take(self, words: str) -> bool:
        self.calls.append(words)
        if words.startswith("fail"):
            raise ValueError("no such cell\nand more")
        return words.startswith("take")


@pytest.fixture
def callee() -> Callee:
    return Callee()


@pytest.fixture
def called(callee: Callee) -> Iterator[Lab]:
    """A lab that hands its calls to the callee."""
    with lab_of(on_call=callee.take) as lab:
        yield lab


CALLS = (
    ("take", "take"),
    ("take/this/and%20that", "take/this/and that"),
    ("take%2Fthis%2fand+that", "take/this/and+that"),
    ("take%3Fx%23y%25z%26", "take?x#y%z&"),
    ("take%E2%86%92%F0%9F%90%88%CE%B5", "take→🐈ε"),
    ("take%0A%00%5C..%5C..", "take\n\0\\..\\.."),
    ("take/../..//", "take/../..//"),
    ("take?a=query", "take"),
)


@pytest.mark.parametrize(("path", "words"), CALLS)
def test_taken_call_leaves_the_page_where_it_is(
    called: Lab, callee: Callee, path: str, words: str
) -> None:
    answer = get_path(called.port, f"/call/{path}", OWN)
    assert (answer.status, answer.read()) == (204, b"")
    assert callee.calls == [words]
    assert answer.headers["Cache-Control"] == "no-store"
    assert answer.headers["Content-Security-Policy"] == "frame-ancestors 'none'"
    assert answer.headers["X-Frame-Options"] == "DENY"
    assert answer.headers["X-Content-Type-Options"] == "nosniff"
    assert "Content-Length" not in answer.headers
    assert "Content-Type" not in answer.headers


@pytest.mark.parametrize("path", ["other", "", "other/take", "%74ak"])
def test_call_that_is_not_taken_is_not_found(called: Lab, callee: Callee, path: str) -> None:
    answer = get_path(called.port, f"/call/{path}", OWN)
    assert answer.status == 404
    assert len(callee.calls) == 1
    assert answer.headers["Cache-Control"] == "no-store"
    assert answer.headers["X-Frame-Options"] == "DENY"


def test_call_without_a_callee_is_not_found(lab: Lab) -> None:
    assert get_path(lab.port, "/call/take", OWN).status == 404


def test_calls_are_limited_in_length(called: Lab, callee: Callee) -> None:
    # What counts is what arrives: each of these characters makes six of the path.
    longest = "take" + "ε" * (MAX_CALL_CHARACTERS - 4)
    assert get_path(called.port, f"/call/{quote(longest)}", OWN).status == 204
    assert get_path(called.port, f"/call/{quote(longest)}x", OWN).status == 404
    assert callee.calls == [longest]


@pytest.mark.parametrize("path", ["take%FF", "take%C3", "take%ED%A0%80", "take\udcff", "takeε"])
def test_call_that_is_no_text_is_not_found(called: Lab, callee: Callee, path: str) -> None:
    lines = ("Host: localhost", "Sec-Fetch-Site: same-origin")
    line = first_line_for(called.port, f"GET /call/{path} HTTP/1.1", *lines)
    assert line.split()[1] == b"404"
    assert callee.calls == []


@pytest.mark.parametrize("path", ["/call", "/", "/calls/take", "//call/take", "/x/call/take"])
def test_all_other_paths_are_answered_as_before(called: Lab, callee: Callee, path: str) -> None:
    # No header says where it comes from, which only a call has to.
    assert get_path(called.port, path, {}).status == (200 if path == "/" else 404)
    assert callee.calls == []


FOREIGN_CALLERS = (
    {},
    *({"Sec-Fetch-Site": site} for site in ("cross-site", "same-site", "none", "", "Same-Origin")),
    {"Sec-Fetch-Site": "cross-site", "Referer": "http://localhost:{port}/"},
    *(
        {"Referer": referer}
        for referer in (
            "",
            "about:blank",
            "http://evil.example/",
            "http://evil.example/http://localhost:{port}/",
            "http://evil.example/?http://localhost:{port}/",
            "http://evil.example:{port}/",
            "http://localhost/",
            "http://localhost:{other}/",
            "https://localhost:{port}/",
            "http://localhost:{port}.evil.example/",
            "http://localhost:{port}@evil.example/",
            "http://evil.example?@localhost:{port}/",
            "//localhost:{port}/",
            "localhost:{port}/",
        )
    ),
    {**OWN, "Origin": "http://evil.example"},
    {**OWN, "Host": "evil.example:{port}"},
    {"Host": "evil.example:{port}", "Referer": "http://evil.example:{port}/"},
)


@pytest.mark.parametrize("headers", FOREIGN_CALLERS, ids=repr)
def test_only_our_own_page_may_call(called: Lab, callee: Callee, headers: dict[str, str]) -> None:
    headers = {"Host": "localhost:{port}", **headers}
    for name, value in headers.items():
        headers[name] = value.format(port=called.port, other=called.port - 1)
    answer = get_path(called.port, "/call/take", headers)
    assert answer.status == 403
    assert callee.calls == []
    assert answer.headers["Cache-Control"] == "no-store"
    assert answer.headers["X-Frame-Options"] == "DENY"


@pytest.mark.parametrize("name", ["Sec-Fetch-Site", "Referer"])
def test_source_of_a_call_must_be_there_once(called: Lab, callee: Callee, name: str) -> None:
    own, foreign = {
        "Sec-Fetch-Site": ("same-origin", "cross-site"),
        "Referer": (f"http://localhost:{called.port}/", "http://evil.example/"),
    }[name]
    lines = ("GET /call/take HTTP/1.1", f"Host: localhost:{called.port}", f"{name}: {own}")
    assert first_line_for(called.port, *lines, f"{name}: {foreign}").split()[1] == b"403"
    assert callee.calls == []
    assert first_line_for(called.port, *lines).split()[1] == b"204"


@pytest.mark.parametrize("page", ["/", "/?fixedDpr=1", "/index.html?a=http://evil.example/"])
def test_referer_tells_where_the_browser_says_nothing_else(called: Lab, page: str) -> None:
    for host, referer in (("127.0.0.1", "localhost"), ("localhost", "localhost")):
        headers = {
            "Host": f"{host}:{called.port}",
            "Referer": f"http://{referer}:{called.port}{page}",
        }
        assert get_path(called.port, "/call/take", headers).status == 204
    forwarded = {"Host": "localhost:9000", "Referer": f"http://localhost:9000{page}"}
    assert get_path(called.port, "/call/take", forwarded).status == 204


def test_network_lab_takes_calls_of_its_own_pages(callee: Callee) -> None:
    with lab_of(host="0.0.0.0", on_call=callee.take) as lab:
        address = f"192.168.7.7:{lab.port}"
        own = {"Host": address, "Referer": f"http://{address}/"}
        assert get_path(lab.port, "/call/take", own).status == 204
        neighbour = own | {"Referer": f"http://192.168.7.8:{lab.port}/"}
        assert get_path(lab.port, "/call/take", neighbour).status == 403
        assert get_path(lab.port, "/call/take", {"Host": address}).status == 403
    assert callee.calls == ["take"]


@pytest.mark.parametrize("method", ["POST", "HEAD", "PUT", "OPTIONS", "get"])
def test_only_get_calls(called: Lab, callee: Callee, method: str) -> None:
    lines = ("Host: localhost", "Sec-Fetch-Site: same-origin")
    line = first_line_for(called.port, f"{method} /call/take HTTP/1.1", *lines)
    assert b"204" not in line
    assert get_path(called.port, "/call/take/again", OWN).status == 204
    assert callee.calls == ["take/again"]


@pytest.mark.usefixtures("no_traceback")
def test_failing_call_is_logged_and_the_server_goes_on(
    called: Lab, caplog: pytest.LogCaptureFixture
) -> None:
    page, _ = called.page()
    for _ in range(2):
        answer = get_path(called.port, "/call/fail", OWN)
        assert answer.status == 500
        assert b"cell" not in answer.read()
        assert answer.headers["Cache-Control"] == "no-store"
    assert [record.getMessage() for record in caplog.records if record.levelname == "ERROR"] == [
        "Callee.take failed: ValueError: no such cell"
    ] * 2
    assert get_path(called.port, "/call/take", OWN).status == 204
    assert called.hears(page)


def test_each_secret_has_a_taker_of_its_own_until_it_leaves() -> None:
    calls = Calls()
    heard: list[tuple[str, str]] = []
    first = calls.enter(lambda words: heard.append(("first", words)))
    second = calls.enter(lambda words: heard.append(("second", words)))
    with lab_of(on_call=calls.take) as lab:

        def status(address: str) -> int:
            return get_path(lab.port, f"/{address}", OWN).status

        assert status(address_of(first, "cell 3/4")) == 204
        assert status(address_of(second, "ε?#%")) == 204
        assert status(address_of(second, "")) == 204
        assert status(f"call/{second}") == 204
        assert heard == [
            ("first", "cell 3/4"),
            ("second", "ε?#%"),
            ("second", ""),
            ("second", ""),
        ]
        heard.clear()
        calls.leave(first)
        calls.leave(first)
        calls.leave("never entered")
        assert status(address_of(first, "cell 3/4")) == 404
        assert status(address_of("", "cell 3/4")) == 404
        assert status(address_of(second[:-1], "cell 3/4")) == 404
        assert heard == []
        assert status(address_of(second, "cell 3/4")) == 204
        assert heard == [("second", "cell 3/4")]


def test_secrets_cannot_be_guessed() -> None:
    calls = Calls()
    entered = {calls.enter(print) for _ in range(1_000)}
    assert len(entered) == 1_000
    # 128 bits in characters of six bits each.
    assert all(re.fullmatch(r"[A-Za-z0-9_-]{22}", secret) for secret in entered)


@pytest.fixture(scope="module")
def switchboard() -> Iterator[tuple[Lab, Calls]]:
    calls = Calls()
    with lab_of(on_call=calls.take) as lab:
        yield lab, calls


MAX_WORDS = MAX_CALL_CHARACTERS - 23
"""What a secret and its slash leave."""


@given(words=st.text(max_size=MAX_WORDS).filter(lambda words: words not in (".", "..")))
def test_any_words_arrive(switchboard: tuple[Lab, Calls], words: str) -> None:
    lab, calls = switchboard
    heard: list[str] = []
    secret = calls.enter(heard.append)
    address = address_of(secret, words)
    assert re.fullmatch(r"call/[\w-]{22}/[\w.~%-]*", address, re.ASCII)
    assert get_path(lab.port, f"/{address}", OWN).status == 204
    assert heard == [words]
    calls.leave(secret)


@pytest.mark.parametrize("words", [".", "..", "x" * (MAX_WORDS + 1)])
def test_words_that_cannot_arrive_have_no_address(words: str) -> None:
    with pytest.raises(ValueError, match=r"cannot be called|at most 512"):
        address_of(Calls().enter(print), words)


def test_longest_words_have_an_address(switchboard: tuple[Lab, Calls]) -> None:
    lab, calls = switchboard
    # Each of these characters makes twelve of the address.
    address = address_of(calls.enter(lambda words: None), "🐈" * MAX_WORDS)
    assert get_path(lab.port, f"/{address}", OWN).status == 204


# --- Values --------------------------------------------------------------------------------------


def add_widgets(gui: viser.GuiApi) -> dict[str, Any]:
    widgets = {
        "slider": gui.add_slider("Slider", 0.0, 1.0, 0.1, 0.5),
        "whole slider": gui.add_slider("Whole slider", 0, 10, 1, 5),
        "number": gui.add_number("Number", 5.0),
        "whole number": gui.add_number("Whole number", 50, min=10, max=100),
        "checkbox": gui.add_checkbox("Checkbox", False),
        "text": gui.add_text("Text", "nothing"),
        "dropdown": gui.add_dropdown("Dropdown", ("flat", "timed")),
        "choice": gui.add_button_group("Choice", ("slow", "fast")),
        "marks": gui.add_multi_slider("Marks", 0, 10, 1, (2, 5, 8)),
        "ends": gui.add_multi_slider("Ends", 0.0, 1.0, 0.1, (0.0, 0.5, 1.0), fixed_endpoints=True),
        "rgb": gui.add_rgb("Colour", (1, 2, 3)),
        "rgba": gui.add_rgba("Colour with alpha", (1, 2, 3, 4)),
        "vector2": gui.add_vector2("Point", (0.0, 0.0), min=(-1.0, -2.0), max=(1.0, 2.0)),
        "vector3": gui.add_vector3("Place", (0.0, 0.0, 0.0)),
        "button": gui.add_button("Button"),
        "upload": gui.add_upload_button("File"),
        "progress": gui.add_progress_bar(10.0),
        "disabled": gui.add_slider("Disabled", 0, 10, 1, 5, disabled=True),
        "disabled choice": gui.add_button_group("Choice", ("slow", "fast"), disabled=True),
        "hidden": gui.add_checkbox("Hidden", False, visible=False),
    }
    with gui.add_folder("Folder", visible=False), gui.add_folder("Inner"):
        widgets["in hidden folder"] = gui.add_checkbox("In a hidden folder", False)
    panel = gui.add_panel(visible=False)
    with panel.add_tab("Tab"):
        widgets["in hidden panel"] = gui.add_checkbox("In a hidden panel", False)
    with gui.add_tab_group().add_tab("Tab"):
        widgets["in tab"] = gui.add_checkbox("In a tab", False)
    with gui.add_modal("Modal"):
        widgets["in modal"] = gui.add_checkbox("In a modal", False)
    return widgets


@pytest.fixture(scope="module", params=["everyone's panel", "the page's own panel"])
def stage(request: pytest.FixtureRequest) -> Iterator[tuple[Lab, Page, dict[str, Any]]]:
    """A lab, a page and widgets of each kind, which every test must leave as they were."""
    with lab_of() as lab:
        page, client = lab.page()
        gui = lab.server.gui if request.param == "everyone's panel" else client.gui
        yield lab, page, add_widgets(gui)


NAN, INFINITY = math.nan, math.inf

ILLEGAL_VALUES = (
    *(("slider", v) for v in (99, -0.1, 1.0000001, NAN, INFINITY, -INFINITY, True)),
    *(("slider", v) for v in ("0.5", None, [0.5], {"x": 1}, b"1", [])),
    *(("whole slider", v) for v in (11, -1, 2.5, NAN, True, "3")),
    *(("number", v) for v in (NAN, INFINITY, False, "1e3", None)),
    *(("whole number", v) for v in (9, 101, 10.5, 2**63)),
    *(("checkbox", v) for v in (1, 0, "true", None, [])),
    *(("text", v) for v in ("x" * 2_001, 5, None, ["a"], b"bytes")),
    *(("dropdown", v) for v in ("unknown", "Flat", "", 0, None, ["flat"], {"flat": 1})),
    *(("choice", v) for v in ("unknown", True, 1)),
    *(("marks", v) for v in ([2, 5], [2, 5, 8, 9], [2, 5, 11], [-1, 5, 8], [8, 5, 2])),
    *(("marks", v) for v in ([2, 5.5, 8], [2, NAN, 8], [2, True, 8], 5, "258", None)),
    *(("ends", v) for v in ([0.1, 0.5, 1.0], [0.0, 0.5, 0.9])),
    *(("rgb", v) for v in ([1, 2], [1, 2, 256], [-1, 2, 3], [1.5, 2, 3], [1, 2, True], "#fff")),
    *(("rgba", v) for v in ([1, 2, 3], [1, 2, 3, 300])),
    *(("vector2", v) for v in ([0, 3], [-2, 0], [0, NAN], [0], [0, 0, 0])),
    *(("vector3", v) for v in ([0, 0], [0, 0, INFINITY], [0, 0, "1"], {"0": 0, "1": 0, "2": 0})),
    *(("button", v) for v in (1, "yes", None)),
    *(("upload", v) for v in (True, "file", {"name": "x", "content": b"y"})),
    *(("progress", v) for v in (50.0, "x")),
    ("disabled", 7),
    ("disabled choice", "fast"),
    *((name, True) for name in ("hidden", "in hidden folder", "in hidden panel")),
)


@pytest.mark.parametrize(("name", "value"), ILLEGAL_VALUES, ids=repr)
def test_illegal_value_is_dropped(stage: Any, name: str, value: Any) -> None:
    lab, page, widgets = stage
    handle = widgets[name]
    before, since = handle.value, handle.update_timestamp
    page.set(handle, value)
    assert lab.hears(page)
    assert (handle.value, type(handle.value)) == (before, type(before))
    assert handle.update_timestamp == since
    assert handle._impl.props.__dict__.get("label", "This") in lab.reason()
    assert lab.refused.empty()


LEGAL_VALUES = (
    ("slider", 1, 1.0),
    ("slider", 0.25, 0.25),
    ("whole slider", 3.0, 3),
    ("whole slider", 10, 10),
    ("number", -1e300, -1e300),
    ("whole number", 15, 15),
    ("checkbox", True, True),
    ("text", "x" * 2_000, "x" * 2_000),
    ("dropdown", "timed", "timed"),
    ("choice", "fast", "fast"),
    ("marks", [0, 5, 5], (0, 5, 5)),
    ("ends", [0, 0.7, 1], (0.0, 0.7, 1.0)),
    ("rgb", [0, 255, 7], (0, 255, 7)),
    ("rgba", [0, 255, 7, 0], (0, 255, 7, 0)),
    ("vector2", [1, -2], (1.0, -2.0)),
    ("vector3", [1e9, 0, -1], (1e9, 0.0, -1.0)),
    ("button", True, True),
    ("in tab", True, True),
    ("in modal", True, True),
)


@pytest.mark.parametrize(("name", "value", "expected"), LEGAL_VALUES)
def test_legal_value_is_taken(stage: Any, name: str, value: Any, expected: Any) -> None:
    lab, page, widgets = stage
    handle = widgets[name]
    before = handle.value
    page.set(handle, value)
    assert lab.hears(page)
    taken, handle.value = handle.value, before
    assert repr(taken) == repr(expected)
    assert lab.refused.empty()


@pytest.mark.parametrize(
    "updates",
    [
        {"disabled": True},
        {"update_cb": []},
        {"removed": True},
        {"value": 0.25, "label": "<b>"},
        {"max": 99.0, "value": 0.25},
        {"props": {}},
        {"Value": 0.25},
        {0: 0.25},
        {},
    ],
    ids=repr,
)
def test_only_the_value_can_be_set(stage: Any, updates: dict[Any, Any]) -> None:
    lab, page, widgets = stage
    handle = widgets["slider"]
    before = dict(vars(handle._impl)) | {"props": dict(vars(handle._impl.props))}
    page.update(handle, updates)
    assert lab.hears(page)
    assert dict(vars(handle._impl)) | {"props": dict(vars(handle._impl.props))} == before
    assert lab.reason() == "This page tried to change more than a value."


def test_limits_are_those_of_the_moment(lab: Lab) -> None:
    page, _ = lab.page()
    slider = lab.server.gui.add_slider("Slider", 0, 10, 1, 5)
    names = ["flat", "timed"]
    menu = lab.server.gui.add_dropdown("Menu", names)
    slider.max, menu.options = 20, ("timed", "new")
    page.set(slider, 15)
    page.set(menu, "new")
    assert lab.hears(page)
    assert (slider.value, menu.value) == (15, "new")
    slider.disabled = True
    page.set(slider, 1)
    page.set(menu, "flat")
    assert lab.hears(page)
    assert (slider.value, menu.value) == (15, "new")


def test_removed_widget_is_dropped_without_a_word(lab: Lab) -> None:
    page, _ = lab.page()
    slider = lab.server.gui.add_slider("Slider", 0, 10, 1, 5)
    slider.remove()
    page.set(slider, 7)
    assert lab.hears(page)
    assert slider.value == 5
    assert lab.refused.empty()


def test_page_is_set_right_and_no_other_hears_of_it(lab: Lab) -> None:
    slider = lab.server.gui.add_slider("Slider", 0.0, 1.0, 0.1, 0.5)
    (culprit, client), (bystander, _) = lab.page(), lab.page()
    culprit.set(slider, 99)
    *_, correction = culprit.receive_until(lambda message: is_update(message, slider))
    assert correction["updates"] == {"value": 0.5}
    assert lab.refused.get(timeout=PATIENCE_S) == (client.client_id, "Slider must be at most 1.0.")
    assert lab.hears(culprit)
    heard = bystander.receive_until(lab.is_probe)
    assert not any(is_update(message, slider) for message in heard)


def test_value_that_the_page_mends_itself_is_no_refusal(
    lab: Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(admission, "GRACE_S", 0.2)
    typed = lab.server.gui.add_number("Typed", 50, min=10, max=100)
    other = lab.server.gui.add_number("Other", 50, min=10, max=100)
    page, _ = lab.page()
    page.set(typed, 1)
    page.set(typed, 15)
    page.set(other, 1)
    # The grace of the first value would have ended before that of the last.
    assert lab.reason() == "Other must be at least 10."
    assert typed.value == 15


def test_page_without_a_picture_changes_nothing(lab: Lab) -> None:
    slider = lab.server.gui.add_slider("Slider", 0, 10, 1, 5)
    page, _ = lab.page()
    silent = lab.silent_page()
    silent.set(slider, 7)
    *_, correction = silent.receive_until(lambda message: is_update(message, slider))
    assert correction["updates"] == {"value": 5}
    assert slider.value == 5
    assert lab.hears(page)


# --- Other messages ------------------------------------------------------------------------------


@pytest.mark.usefixtures("no_traceback")
@pytest.mark.parametrize(
    "frame",
    [
        b"",
        b"garbage",
        b"\xff" * 100,
        b"\x91" * 100_000,
        "text",
        *(
            msgspec.msgpack.encode(content)
            for content in (
                5,
                [],
                {},
                {"type": []},
                {"type": "NoSuchMessage"},
                {"type": "GuiUpdateMessage"},
                {"type": "GuiUpdateMessage", "uuid": "a", "updates": {}, "extra": 1},
                {"type": "ViewerCameraMessage", "wxyz": 5},
            )
        ),
    ],
    ids=lambda frame: repr(frame[:30]),
)
def test_unreadable_frame_ends_only_its_connection(lab: Lab, frame: bytes | str) -> None:
    page, _ = lab.page()
    culprit, _ = lab.page()
    culprit.send_frame(frame)
    assert culprit.close_code() == 1003
    assert lab.hears(page)


@pytest.mark.usefixtures("no_traceback")
def test_too_large_frame_ends_only_its_connection(lab: Lab) -> None:
    page, _ = lab.page()
    culprit, _ = lab.page()
    culprit.send_frame(bytes(MAX_MESSAGE_BYTES + 1))
    assert culprit.close_code() == 1009
    assert lab.hears(page)


@pytest.mark.usefixtures("no_traceback")
def test_garbage_instead_of_a_request_is_not_worth_a_traceback(lab: Lab) -> None:
    for garbage in (b"\x00\x01\r\n\r\n", b"POST / HTTP/1.1\r\nHost: localhost\r\n\r\n"):
        with socket.create_connection(("127.0.0.1", lab.port), timeout=PATIENCE_S) as raw:
            raw.sendall(garbage)
            raw.makefile("rb").read()
    assert get(lab.port).status == 200


@pytest.mark.usefixtures("no_traceback")
@pytest.mark.parametrize(
    "mapping",
    [
        {"type": "GuiUpdateMessage", "uuid": [], "updates": {"value": 1}},
        {"type": "GuiUpdateMessage", "uuid": "a", "updates": 5},
        {"type": "GuiFormDirtyMessage", "uuid": {}},
        {"type": "ViewerCameraMessage", **vars(CAMERA), "position": (NAN, 0.0, 0.0)},
        {"type": "GuiRemoveMessage", "uuid": "a"},
        {"type": "RunJavascriptMessage", "source": "alert(1)"},
        {"type": "ShareUrlRequest"},
        {"type": "ShareUrlDisconnect"},
    ],
    ids=lambda mapping: mapping["type"],
)
def test_senseless_message_is_dropped(lab: Lab, mapping: dict[str, Any]) -> None:
    page, client = lab.page()
    page.send_frame(msgspec.msgpack.encode(mapping))
    assert lab.reason() == "This page sent a message that makes no sense here."
    assert lab.hears(page)
    assert client.camera.position[0] == 0.0


def test_no_page_starts_a_share_tunnel(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    tunnels: list[Any] = []
    monkeypatch.setattr("viser._viser.ViserTunnel", lambda *address: tunnels.append(address))
    page, _ = lab.page()
    page.send(wire.ShareUrlRequest())
    assert lab.reason()
    assert lab.hears(page)
    assert tunnels == []
    # Nor is there anyone to hear such a request, were it let through.
    assert wire.ShareUrlRequest not in lab.server._websock_server._incoming_handlers
    assert wire.ShareUrlDisconnect not in lab.server._websock_server._incoming_handlers
    theme = page.receive_until(lambda message: message["type"] == "ThemeConfigurationMessage")[-1]
    assert theme["show_share_button"] is False


@pytest.mark.parametrize("message_type", admission.RULES)
def test_every_admitted_message_can_be_checked(message_type: type[wire.Message]) -> None:
    assert values.fields(message_type)


@pytest.mark.usefixtures("no_traceback")
@pytest.mark.parametrize(
    ("kind", "ray", "corners", "heard"),
    [
        ("click", (0.0, 0.0, 1.0), ((0.5, 0.5),), True),
        ("click", None, ((0.5, 0.5),), False),
        ("click", (0.0, 0.0, 1.0), (), False),
        ("click", (0.0, 0.0, NAN), ((0.5, 0.5),), False),
        ("rect-select", None, ((0.0, 0.0), (1.0, 1.0)), True),
        ("rect-select", None, ((0.0, 0.0),), False),
        ("hover", (0.0, 0.0, 1.0), ((0.5, 0.5),), False),
    ],
)
def test_incomplete_click_is_dropped(
    lab: Lab, kind: Any, ray: Any, corners: Any, heard: bool
) -> None:
    events: queue.Queue[Any] = queue.Queue()
    lab.server.scene.on_click()(events.put)
    lab.server.scene.on_rect_select()(events.put)
    page, _ = lab.page()
    page.send(wire.ScenePointerMessage(kind, ray, ray, corners, None))
    if heard:
        events.get(timeout=PATIENCE_S)
    assert lab.hears(page)
    assert events.empty()


def test_commands_and_held_buttons_must_be_enabled(lab: Lab) -> None:
    calls: queue.Queue[str] = queue.Queue()
    command = lab.server.gui.add_command("Command")
    command.on_trigger(lambda _: calls.put("command"))
    button = lab.server.gui.add_button("Button")
    button.on_hold(lambda _: calls.put("hold"), callback_hz=10.0)
    page, _ = lab.page()

    def use_both() -> None:
        page.send(wire.CommandTriggerMessage(command._impl.uuid))
        page.send(wire.GuiButtonHoldMessage(button._impl.uuid, 10.0))
        page.send(wire.GuiButtonHoldMessage(button._impl.uuid, 11.0))
        page.send(wire.CommandTriggerMessage("unknown"))
        assert lab.hears(page)

    use_both()
    assert {calls.get(timeout=PATIENCE_S) for _ in range(2)} == {"command", "hold"}
    command.disabled = button.disabled = True
    use_both()
    assert lab.reason() == "Button is not available now."
    assert calls.empty()


def test_only_forms_that_are_there_can_be_edited_and_submitted(lab: Lab) -> None:
    submitted: queue.Queue[Any] = queue.Queue()
    form = lab.server.gui.add_form("Form")
    form.on_submit(submitted.put)
    (page, _), (bystander, _) = lab.page(), lab.page()
    uuid = form._impl.uuid
    for message in (wire.GuiFormDirtyMessage, wire.GuiFormSubmitMessage):
        page.send(message("unknown"))
        page.send(message(uuid))
    submitted.get(timeout=PATIENCE_S)
    assert lab.hears(page)
    assert submitted.empty()
    heard = [m for m in bystander.receive_until(lab.is_probe) if m["type"].startswith("GuiForm")]
    assert {(m["type"], m["uuid"]) for m in heard} >= {("GuiFormDirtyMessage", uuid)}
    assert all(m["uuid"] == uuid for m in heard)
    silent = lab.silent_page()
    silent.send(wire.GuiFormDirtyMessage(uuid))
    box = lab.server.gui.add_checkbox("Box", False)
    silent.set(box, True)
    silent.receive_until(lambda message: is_update(message, box))
    assert lab.hears(page)
    heard = bystander.receive_until(lab.is_probe)
    assert not any(message["type"].startswith("GuiForm") for message in heard)
    form.visible = False
    page.send(wire.GuiFormSubmitMessage(uuid))
    assert lab.hears(page)
    assert submitted.empty()


# --- Uploads -------------------------------------------------------------------------------------


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


@pytest.fixture
def uploads() -> Iterator[UploadLab]:
    lab = UploadLab()
    yield lab
    lab.close()


@pytest.mark.parametrize("scope", ["shared", "own"])
def test_small_file_arrives(uploads: UploadLab, scope: str) -> None:
    button, page = getattr(uploads, scope), uploads.first_page
    for transfer, content in (("a", b"abc"), ("b", bytes(1024)), ("c", b"")):
        size = len(content)
        page.send(start_of(button, transfer, size_bytes=size, part_count=min(1, size)))
        if content:
            page.send(part_of(button, content, transfer))
        file = uploads.files.get(timeout=PATIENCE_S)
        assert (file.name, file.content) == ("preset.yaml", content)
    assert uploads.refused.empty()


@pytest.mark.parametrize("scope", ["shared", "own"])
@pytest.mark.parametrize(
    "changes",
    [
        {"size_bytes": 1025},
        {"size_bytes": -1},
        {"size_bytes": 0, "part_count": 1},
        {"part_count": 0},
        {"part_count": 2},
        {"part_count": 10**9},
        {"filename": "x" * 256},
        {"filename": ""},
    ],
    ids=repr,
)
def test_unfit_file_is_refused(uploads: UploadLab, scope: str, changes: dict[str, Any]) -> None:
    button, page = getattr(uploads, scope), uploads.first_page
    page.send(start_of(button, **changes))
    page.send(part_of(button, b"abc"))
    assert uploads.reason().startswith("File ")
    assert uploads.hears(page)
    assert uploads.transfers() == set()
    assert uploads.files.empty()
    # The page stops waiting, and takes back the notification that says that it is uploading.
    gone = page.receive_until(lambda message: message["type"] == "RemoveNotificationMessage")
    assert gone[-1]["uuid"] == "upload-t"
    [given_up] = [message for message in gone if message["type"] == "FileTransferPartAck"]
    assert given_up["transferred_bytes"] == given_up["total_bytes"] == 0


def test_only_enabled_upload_buttons_take_files(uploads: UploadLab) -> None:
    page = uploads.first_page
    slider = uploads.server.gui.add_slider("Slider", 0, 10, 1, 5)
    page.send(start_of(slider))
    assert uploads.reason() == "Slider takes no file."
    uploads.shared.disabled = True
    page.send(start_of(uploads.shared))
    assert uploads.reason() == "File is not available now."
    uploads.own.remove()
    page.send(start_of(uploads.own))
    assert uploads.hears(page)
    assert uploads.transfers() == set()


def test_one_file_at_a_time(uploads: UploadLab) -> None:
    page = uploads.first_page
    page.send(start_of(uploads.own, "first"))
    for second in ("second", "first"):
        page.send(start_of(uploads.shared, second))
        assert uploads.reason() == "File is busy with another file."
    other, _ = uploads.page()
    other.send(start_of(uploads.shared, "other"))
    assert uploads.hears(other)
    assert uploads.transfers() == {"first", "other"}
    page.send(part_of(uploads.own, b"abc", "first"))
    assert uploads.files.get(timeout=PATIENCE_S).content == b"abc"
    page.send(start_of(uploads.own, "third"))
    assert uploads.hears(page)
    assert uploads.transfers() == {"third", "other"}


def test_overlong_part_ends_the_transfer(uploads: UploadLab) -> None:
    page = uploads.first_page
    page.send(start_of(uploads.own))
    page.send(part_of(uploads.own, b"abcd"))
    assert uploads.reason() == "This file is longer than announced."
    assert uploads.hears(page)
    assert uploads.transfers() == set()
    page.send(start_of(uploads.own, "again"))
    page.send(part_of(uploads.own, b"abc", "again"))
    assert uploads.files.get(timeout=PATIENCE_S).content == b"abc"


def test_parts_go_to_the_widget_that_started_the_transfer(uploads: UploadLab) -> None:
    page = uploads.first_page
    slider = uploads.server.gui.add_slider("Slider", 0, 10, 1, 5)
    page.send(start_of(uploads.shared))
    page.send(part_of(slider, b"abc"))
    assert uploads.hears(page)
    assert slider.value == 5


def test_parts_of_another_page_are_dropped(uploads: UploadLab) -> None:
    page, (intruder, _) = uploads.first_page, uploads.page()
    page.send(start_of(uploads.shared))
    assert uploads.hears(page)
    intruder.send(part_of(uploads.shared, b"bad"))
    assert uploads.hears(intruder)
    page.send(part_of(uploads.shared, b"abc"))
    assert uploads.files.get(timeout=PATIENCE_S).content == b"abc"


# --- Callbacks -----------------------------------------------------------------------------------


def fail(_: Any) -> None:
    raise ValueError("no such preset\nand more")


async def fail_async(_: Any) -> None:
    raise ValueError("no such preset\nand more")


@pytest.mark.usefixtures("no_traceback")
@pytest.mark.parametrize("callback", [fail, fail_async])
def test_failure_is_told_to_the_acting_page(
    lab: Lab, caplog: pytest.LogCaptureFixture, callback: Any
) -> None:
    button = lab.server.gui.add_button("Button")
    button.on_click(callbacks.guarded(callback))
    (page, _), (bystander, _) = lab.page(), lab.page()
    page.set(button, True)
    told = page.receive_until(lambda message: message["type"] == "NotificationShowMessage")[-1]
    assert told["props"]["title"] == "That did not work"
    assert told["props"]["body"] == "ValueError: no such preset"
    assert [record.getMessage() for record in caplog.records if record.levelname == "ERROR"] == [
        f"{callback.__name__} failed: ValueError: no such preset"
    ]
    assert lab.hears(page)
    heard = bystander.receive_until(lab.is_probe)
    assert not any(message["type"] == "NotificationShowMessage" for message in heard)


def test_failure_at_connecting_is_told_to_the_new_page(lab: Lab) -> None:
    lab.server.on_client_connect(callbacks.guarded(fail))
    page, _ = lab.page()
    page.receive_until(lambda message: message["type"] == "NotificationShowMessage")


def test_failure_without_a_page_is_logged(lab: Lab, caplog: pytest.LogCaptureFixture) -> None:
    box = lab.server.gui.add_checkbox("Box", False)
    box.on_update(callbacks.guarded(fail))
    with caplog.at_level(logging.DEBUG, logger=callbacks.__name__):
        box.value = True
    assert [record.levelname for record in caplog.records] == ["ERROR", "DEBUG"]
    assert caplog.records[1].exc_info is not None


def test_guarded_callback_does_its_work() -> None:
    seen: list[int] = []
    callbacks.guarded(seen.append)(5)
    assert seen == [5]
