"""Which requests are answered, and how."""

import socket
from types import SimpleNamespace
from typing import Any

import pytest
import viser
from websockets.exceptions import InvalidStatus

from app.server.server import open_server
from tests.support.server import Lab, Page, get, lab_of, status_of_raw

FOREIGN_ORIGINS = (
    "http://evil.example",
    "http://evil.example:{port}",
    "http://localhost:{other}",
    "http://localhost",
    "https://localhost",
    "https://localhost:{other}",
    "ftp://localhost:{port}",
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
    assert refusal.value.response.body.startswith(b"This page belongs to another site")
    assert get(lab.port, Origin=origin).status == 403


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost", "[::1]", "LocalHost", "localhost."])
def test_own_origin_is_accepted(lab: Lab, name: str) -> None:
    for scheme in ("http", "https"):
        origin = f"{scheme}://{name}:{lab.port}"
        Page(lab.port, origin=origin).close()  # type: ignore[arg-type]
        Page(lab.port, "localhost", origin=origin).close()  # type: ignore[arg-type]


def test_forwarded_port_is_accepted(lab: Lab) -> None:
    assert get(lab.port, Host="localhost:9000", Origin="http://localhost:9000").status == 200
    assert get(lab.port, Host="localhost:9000", Origin="http://localhost:9001").status == 403


@pytest.mark.parametrize(
    "host", ["evil.example", "localhost.evil.example", "192.168.7.7", "localhost.."]
)
def test_foreign_host_is_refused(lab: Lab, host: str) -> None:
    with pytest.raises(InvalidStatus) as refusal:
        Page(lab.port, host)
    assert refusal.value.response.status_code == 403
    # A rebound name: the browser thinks that page and server are one site.
    with pytest.raises(InvalidStatus):
        Page(lab.port, host, origin=f"http://{host}:{lab.port}")  # type: ignore[arg-type]
    answer = get(lab.port, Host=f"{host}:{lab.port}")
    assert answer.status == 403
    assert answer.read().startswith(b"This is not a name of this server")


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
    assert b'<div id="root"></div>' in answer.read()
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
