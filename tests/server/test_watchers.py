"""A port for those who only look: what it answers, what it reads, and whom it lets go."""

import contextlib
import http.client
import logging
import random
import re
import socket
import threading
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import pytest
from websockets.exceptions import InvalidStatus

from app.server import access
from app.server import watchers as watchers_module
from app.server.access import new_code, new_short_code
from app.server.watchers import FULL, MAX_MESSAGE_BYTES, MOST_SHORT_GUESSES, Watcher, Watchers
from tests.support.server import PATIENCE_S, get_path
from tests.support.watching import Page


class Wish(msgspec.Struct, tag_field="do", tag="see", forbid_unknown_fields=True):
    """What is read."""

    n: int


class Rest(msgspec.Struct, tag_field="do", tag="rest", forbid_unknown_fields=True):
    """What is read as well."""


class Act(msgspec.Struct, tag_field="do", tag="act", forbid_unknown_fields=True):
    """What is done."""

    n: int


class Port:
    """A port, and when something changed there."""

    def __init__(self, **options: Any) -> None:
        self._changed = threading.Condition()
        self.watchers = Watchers("127.0.0.1", 0, Wish | Rest, self._note, **options)
        self.port = self.watchers.port

    def _note(self) -> None:
        with self._changed:
            self._changed.notify_all()

    def wait_for(self, condition: Callable[[], bool]) -> None:
        """Wait until that is so."""
        with self._changed:
            assert self._changed.wait_for(condition, PATIENCE_S)

    def page(self, **options: Any) -> Page:
        """One more that looks."""
        former = set(self.watchers.all)
        page = Page(self.port, **options)
        self.wait_for(lambda: bool(set(self.watchers.all) - former))
        return page

    def hears(self, page: Page) -> bool:
        """Whether it still reads what a page wishes: all that came before has been dealt with."""
        n = random.randrange(2**30)
        page.send({"do": "see", "n": n})
        self.wait_for(lambda: any(one.wish == Wish(n) for one in self.watchers.all))
        return True


@pytest.fixture
def port() -> Iterator[Port]:
    port = Port()
    yield port
    port.watchers.close()


@contextlib.contextmanager
def opened(**options: Any) -> Iterator[Port]:
    port = Port(**options)
    try:
        yield port
    finally:
        port.watchers.close()


# --- What it answers ------------------------------------------------------------------------------


def test_the_page_and_all_that_it_loads_are_there(port: Port) -> None:
    answer = get_path(port.port, "/", {})
    page = answer.read().decode()
    assert answer.status == 200
    named = re.findall(r'(?:href|src)="(web/[^"]+)"', page)
    assert "web/audience/audience.js" in named
    assert "web/player/board.js" in named
    for name in named:
        found = get_path(port.port, f"/{name}", {})
        assert found.status == 200, name
        assert found.read()


@pytest.mark.parametrize(
    "path",
    [
        "/time/",
        "/time/secret/",
        "/time/secret/socket",
        "/side/secret/",
        "/s/abc",
        "/call/abc",
        "/web/first.js",
        "/web/lab.js",
        "/web/time/channel.js",
        "/web/time/hand.js",
        "/web/audience/index.html",
        "/web/../server/access.py",
        "/web/audience/../lab.js",
        "/web/audience/%2e%2e/lab.js",
        "/assets/index.js",
        "/index.htm",
        "//",
        "/socket/",
        "/..",
    ],
)
def test_nothing_else_is_there(port: Port, path: str) -> None:
    assert get_path(port.port, path, {}).status == 404


def test_no_page_may_frame_it_and_it_loads_nothing_from_elsewhere(port: Port) -> None:
    headers = get_path(port.port, "/", {}).headers
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "frame-ancestors 'none'" in policy
    assert "unsafe" not in policy
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Referrer-Policy"] == "no-referrer"


@pytest.mark.parametrize("host", ["evil.example", "192.168.7.7", "localhost.evil.example"])
def test_a_foreign_name_is_refused(port: Port, host: str) -> None:
    assert get_path(port.port, "/", {"Host": host}).status == 403


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "", "http://localhost:1"])
def test_a_page_of_another_site_gets_no_websocket(port: Port, origin: str) -> None:
    with pytest.raises(InvalidStatus) as refused:
        Page(port.port, {"Origin": origin})
    assert refused.value.response.status_code == 403


HELLO_OF_TLS = b"\x16\x03\x01" + bytes(200)
"""Of a browser that wants it encrypted; to a server of HTTP the beginning of a line."""


def test_what_is_no_get_is_let_go(port: Port) -> None:
    for line in (b"POST / HTTP/1.1\r\n\r\n", HELLO_OF_TLS, b"GET\r\n\r\n"):
        with socket.create_connection(("127.0.0.1", port.port), timeout=PATIENCE_S) as raw:
            raw.sendall(line)
            raw.shutdown(socket.SHUT_WR)
            assert not raw.recv(1_000).startswith(b"HTTP/1.1 200")
    assert get_path(port.port, "/", {}).status == 200


def test_whoever_says_nothing_more_is_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.server.watchers.HANDSHAKE_S", 0.05)
    with (
        opened() as port,
        socket.create_connection(("127.0.0.1", port.port), timeout=PATIENCE_S) as raw,
    ):
        raw.sendall(HELLO_OF_TLS)
        assert not raw.recv(1_000).startswith(b"HTTP/1.1 200")


# --- Who is let in --------------------------------------------------------------------------------


def test_without_its_code_nobody_is_let_in() -> None:
    code = new_code()
    with opened(code=code) as port:
        refused = get_path(port.port, "/", {"Accept": "text/html"})
        assert refused.status == 401
        assert code not in refused.read().decode()
        assert get_path(port.port, "/web/audience/audience.js", {}).status == 401
        assert b"asks for a code" in get_path(port.port, "/why", {}).read()
        with pytest.raises(InvalidStatus):
            Page(port.port)
        welcome = get_path(port.port, f"/?token={code}", {})
        assert welcome.status == 303
        cookie = welcome.headers["Set-Cookie"].partition(";")[0]
        assert code not in cookie
        assert get_path(port.port, "/", {"Cookie": cookie}).status == 200
        assert port.hears(port.page(headers={"Cookie": cookie}))


def test_a_code_can_be_typed() -> None:
    codes = {new_code() for _ in range(200)}
    assert len(codes) == 200
    assert all(re.fullmatch("[a-hjkmnp-z2-9]{4}-[a-hjkmnp-z2-9]{4}", code) for code in codes)


def test_of_a_short_code_few_guesses_are_let_through(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    caplog.set_level(logging.DEBUG)
    code = new_short_code()
    with opened(code=code, most_guesses=MOST_SHORT_GUESSES) as port:

        def tried(text: str) -> tuple[int, str]:
            answer = get_path(port.port, f"/?token={text}", {"Accept": "text/html"})
            return answer.status, answer.read().decode()

        cookie = get_path(port.port, f"/?token={code}", {}).headers["Set-Cookie"].partition(";")[0]
        statuses = [tried(f"guess{guess}")[0] for guess in range(5)]
        assert statuses == [401] * 4 + [429]
        status, page = tried(code)
        assert status == 429
        assert "Too many wrong codes" in page
        # Whoever is in stays in.
        assert get_path(port.port, "/", {"Cookie": cookie}).status == 200
        monkeypatch.setattr(access, "WINDOW_S", 0.0)
        assert tried(code)[0] == 303
    assert "wrong code" in caplog.text
    assert "127.0.0.1" not in caplog.text
    assert "guess" not in caplog.text


def test_how_a_code_is_typed_does_not_matter() -> None:
    code = new_short_code()
    with opened(code=code) as port:
        for typed in (code.upper(), f"{code[:3]}%20{code[3:]}%20", f"{code[:2]}-{code[2:]}"):
            assert get_path(port.port, f"/?token={typed}", {}).status == 303


def test_a_short_code_has_no_letter_that_is_like_another() -> None:
    codes = {new_short_code() for _ in range(200)}
    assert len(codes) == 200
    assert all(re.fullmatch("[acdefghjkmnpqrtwxy3479]{6}", code) for code in codes)


# --- Who is who -----------------------------------------------------------------------------------


class Seats:
    """Tickets that say whose they are."""

    def __init__(self) -> None:
        self.n_given = 0
        self.sat: list[Seat] = []

    def new_ticket(self) -> str:
        self.n_given += 1
        return f"ticket-{self.n_given}"

    def is_ticket(self, text: str) -> bool:
        return text.startswith("ticket-")

    def sit(self, ticket: str) -> "Seat":
        self.sat.append(Seat(ticket))
        return self.sat[-1]

    def leave(self, seat: "Seat") -> None:
        seat.has_left = True


class Seat:
    """One for each page."""

    def __init__(self, ticket: str) -> None:
        self.ticket, self.is_taken, self.has_left = ticket, True, False


def test_a_browser_is_given_a_ticket_once_and_comes_with_it() -> None:
    seats = Seats()
    with opened(seats=seats) as port:
        answer = get_path(port.port, "/", {})
        cookie, *attributes = answer.headers["Set-Cookie"].split("; ")
        assert cookie == f"pounce-{port.port}-seat=ticket-1"
        assert set(attributes) == {"HttpOnly", "SameSite=Lax"}
        again = get_path(port.port, "/", {"Cookie": f"other=1; {cookie}"})
        assert again.headers["Set-Cookie"] is None
        assert get_path(port.port, "/web/audience/audience.js", {}).headers["Set-Cookie"] is None
        page = port.page(headers={"Cookie": cookie})
        (watcher,) = port.watchers.all
        (seat,) = seats.sat
        assert (watcher.seat, seat.ticket) == (seat, "ticket-1")
        seat.is_taken = False
        assert watcher.seat is None
        page.close()
        port.wait_for(lambda: not port.watchers.all)
        port.wait_for(lambda: seat.has_left)


@pytest.mark.parametrize("cookie", ["", "pounce-1-seat=ticket-1", "seat=ticket-1", "{}=other"])
def test_who_brings_no_ticket_has_no_seat(cookie: str) -> None:
    with opened(seats=Seats()) as port:
        port.page(headers={"Cookie": cookie.format(f"pounce-{port.port}-seat")})
        assert [one.seat for one in port.watchers.all] == [None]


def test_what_is_done_counts_each_time_and_in_turn() -> None:
    done: list[tuple[Watcher, Any]] = []

    def act(watcher: Watcher, told: Any) -> None:
        done.append((watcher, told))

    with opened(acts=Act, act=act) as port:
        page = port.page()
        for n in range(10):
            page.send({"do": "act", "n": n})
        assert port.hears(page)
        (watcher,) = port.watchers.all
        assert done == [(watcher, Act(n)) for n in range(10)]


def test_when_there_are_too_many_that_is_said() -> None:
    with opened(most=2) as port:
        pages = [port.page(), port.page()]
        assert Page(port.port).close_code() == FULL
        assert b"Too many" in get_path(port.port, "/why", {}).read()
        pages[0].close()
        port.wait_for(lambda: len(port.watchers.all) == 1)
        assert get_path(port.port, "/why", {}).read() == b""
        assert port.hears(port.page())


# --- What it reads --------------------------------------------------------------------------------


def test_of_wishes_the_newest_counts(port: Port) -> None:
    page = port.page()
    for n in range(10):
        page.send({"do": "see", "n": n})
    port.wait_for(lambda: [one.wish for one in port.watchers.all] == [Wish(9)])


def test_what_is_no_wish_is_dropped(port: Port) -> None:
    page = port.page()
    strange: list[str | bytes] = [
        "",
        "null",
        "[]",
        "{}",
        '{"do": "see"}',
        '{"do": "see", "n": "1"}',
        '{"do": "see", "n": 1, "more": 2}',
        '{"do": "play"}',
        '{"n": 1}',
        "[" * 500,
        '{"do": "see", "n": 1e400}',
        b"\x00\xff",
        b"\x81\xa4type",
        "\ud7ff" * 100,
    ]
    for message in strange:
        page.socket.send(message)
    assert port.hears(page)
    (watcher,) = port.watchers.all
    assert watcher.n_dropped == len(strange)


def test_a_long_message_ends_the_connection(port: Port) -> None:
    page = port.page()
    page.socket.send("x" * (MAX_MESSAGE_BYTES + 1))
    assert page.close_code() == 1009
    assert port.hears(port.page())


def test_random_bytes_end_but_their_own_connection(port: Port) -> None:
    other = port.page()
    chance = random.Random(1)
    for _ in range(20):
        page = Page(port.port)
        with contextlib.suppress(OSError):
            page.socket.socket.sendall(chance.randbytes(chance.randrange(1, 3_000)))
        page.socket.socket.close()
    assert port.hears(other)


def test_a_flood_is_let_go_and_others_are_heard(port: Port) -> None:
    other, page = port.page(), port.page()
    with contextlib.suppress(OSError):
        for _ in range(200_000):
            page.socket.socket.sendall(b"\x89\x80abcd" * 20)
    port.wait_for(lambda: len(port.watchers.all) == 1)
    assert port.hears(other)


def test_wishes_that_come_too_fast_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    waited: list[float] = []
    true_sleep = watchers_module.asyncio.sleep

    async def sleep(seconds: float) -> None:
        waited.append(seconds)
        await true_sleep(0)

    with opened() as port:
        page = port.page()
        monkeypatch.setattr(watchers_module.asyncio, "sleep", sleep)
        for n in range(60):
            page.send({"do": "see", "n": n})
        port.wait_for(lambda: [one.wish for one in port.watchers.all] == [Wish(59)])
        monkeypatch.undo()
    assert max(waited) > 1.0


# --- What it sends --------------------------------------------------------------------------------


def test_all_get_the_same_and_who_is_slow_gets_no_more(port: Port) -> None:
    pages = [port.page() for _ in range(3)]
    port.watchers.send([(b"one", port.watchers.all)])
    assert [page.socket.recv(timeout=PATIENCE_S) for page in pages] == [b"one"] * 3
    # It reads nothing, and so answers no ping.
    with socket.create_connection(("127.0.0.1", port.port)) as raw:
        raw.sendall(
            f"GET /socket HTTP/1.1\r\nHost: 127.0.0.1:{port.port}\r\n"
            f"Origin: http://127.0.0.1:{port.port}\r\nUpgrade: websocket\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
            "Sec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        port.wait_for(lambda: len(port.watchers.all) == 4)
        for _ in range(2):
            port.watchers.send([(b"two", port.watchers.all)])
        for page in pages:
            assert [page.socket.recv(timeout=PATIENCE_S) for _ in range(2)] == [b"two"] * 2
        slow = port.watchers.all[-1]
        assert port.hears(pages[0])
        assert not slow.is_ready


def test_the_end_is_told() -> None:
    with opened() as port:
        page = port.page()
        port.watchers.close()
        assert page.close_code() == 1001
        with pytest.raises(OSError, match="refused"):
            http.client.HTTPConnection("127.0.0.1", port.port).request("GET", "/")


def test_a_busy_port_is_told(port: Port) -> None:
    with pytest.raises(OSError, match="in use"):
        Watchers("127.0.0.1", port.port, Wish, lambda: None)
