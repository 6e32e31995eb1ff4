"""How many connections there may be, and what is no request."""

import asyncio
import errno
import logging
import socket
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from app.server import connections
from app.server.connections import (
    CONNECTIONS_OF_A_PAGE,
    MIN_UNFINISHED,
    room_for,
    tell_of_error,
)
from tests.support.server import PATIENCE_S, Lab, first_line_for, get, get_path, lab_of

STRANGE = (
    ("POST / HTTP/1.1", 400),
    ("HEAD / HTTP/1.1", 400),
    ("BREW\x1b[31m / HTTP/1.1", 400),
    # What nginx speaks unless it is told otherwise.
    ("GET / HTTP/1.0", 400),
    ("PRI * HTTP/2.0", 400),
    ("GET", 400),
    ("GET /" + "a" * 9_000 + " HTTP/1.1", 431),
    ("GET /" + "a" * 4_000 + " HTTP/1.1", 404),
    ("GET /" + "a" * 300 + " HTTP/1.1", 404),
    ("GET /" + "a/" * 2_000 + " HTTP/1.1", 404),
    ("GET /%00 HTTP/1.1", 404),
    ("GET /%2e%2e/%2e%2e/etc/passwd HTTP/1.1", 404),
    ("GET /..\\..\\etc HTTP/1.1", 404),
    ("GET /\udcff\udcfe HTTP/1.1", 404),
    ("GET /%ed%a0%80 HTTP/1.1", 404),
    ("GET /ä HTTP/1.1", 404),
    ("GET http://localhost/ HTTP/1.1", 404),
    ("GET * HTTP/1.1", 404),
)


@pytest.mark.usefixtures("no_traceback")
@pytest.mark.parametrize(("line", "status"), STRANGE, ids=lambda value: repr(value)[:40])
def test_strange_requests_are_refused_in_words(
    lab: Lab, caplog: pytest.LogCaptureFixture, line: str, status: int
) -> None:
    assert first_line_for(lab.port, line, "Host: localhost").split()[1] == b"%d" % status
    assert get(lab.port).status == 200
    for record in caplog.get_records("call"):
        assert record.getMessage().isprintable()


@pytest.mark.usefixtures("no_traceback")
def test_many_headers_are_refused_in_words(lab: Lab) -> None:
    many = [f"X-{number}: y" for number in range(1_000)]
    assert b"431" in first_line_for(lab.port, "GET / HTTP/1.1", "Host: localhost", *many)


def test_a_path_that_no_file_can_have_is_not_found_whatever_the_file_system_says(
    lab: Lab,
) -> None:
    answer = get_path(lab.port, "/" + "ab" * 2_000, {})
    assert (answer.status, answer.read()) == (404, b"Not found.\n")


def is_ended(silent: socket.socket) -> bool:
    """Whether the other side ends a connection."""
    try:
        return silent.recv(1) == b""
    except ConnectionError:
        return True


@pytest.mark.usefixtures("no_traceback")
def test_silent_connections_make_room_for_those_that_speak(
    caplog: pytest.LogCaptureFixture,
) -> None:
    with lab_of(max_clients=2) as lab, ExitStack() as stack:
        page, _ = lab.page()
        silent = [
            stack.enter_context(socket.create_connection(("127.0.0.1", lab.port), PATIENCE_S))
            for _ in range(MIN_UNFINISHED + 5)
        ]
        # The oldest go; who is in, and who speaks, is not concerned.
        assert all(map(is_ended, silent[:5]))
        assert get(lab.port).status == 200
        assert lab.hears(page)
        second, _ = lab.page()
        assert lab.hears(second)
    said = {record.getMessage() for record in caplog.records if record.levelname == "WARNING"}
    assert "ended a connection that said nothing: too many came at once" in said


def test_silence_ends_a_connection(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.server.server.HANDSHAKE_S", 0.05)
    with lab_of() as lab, socket.create_connection(("127.0.0.1", lab.port), PATIENCE_S) as silent:
        silent.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\nX-Slow: ")
        assert is_ended(silent)


@pytest.mark.parametrize(("limit", "in_use"), [(64, 12), (64, 30), (256, 20), (1_024, 100)])
def test_descriptors_are_left_for_everything_else(
    monkeypatch: pytest.MonkeyPatch, limit: int, in_use: int
) -> None:
    monkeypatch.setattr(connections, "_raised_limit", lambda: limit)
    monkeypatch.setattr(connections, "_open_descriptors", lambda: in_use)
    room = room_for(64)
    assert 1 <= room.pages <= 64
    assert room.backlog >= 1
    # Besides the pages: connections on their way in or out, and those that come in one go.
    pages = room.pages * CONNECTIONS_OF_A_PAGE
    assert in_use + pages + MIN_UNFINISHED + room.backlog <= limit


def test_an_ample_limit_limits_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connections, "_raised_limit", lambda: 4_096)
    assert room_for(64) == (64, 100)


def test_the_limit_of_the_process_is_raised_as_far_as_it_may_be(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    resource = pytest.importorskip("resource")
    limits = [64, 512]

    def set_limits(_: int, new: tuple[int, int]) -> None:
        limits[:] = new

    monkeypatch.setattr(resource, "getrlimit", lambda _: tuple(limits))
    monkeypatch.setattr(resource, "setrlimit", set_limits)
    room_for(8)
    assert limits == [512, 512]


FEW_DESCRIPTORS = """
import resource, sys
resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))
from app.server.server import close_server, open_server
server = open_server(port=0)
print(server.get_port(), flush=True)
sys.stdin.readline()
# What an experiment would do meanwhile.
files = [open("/dev/null") for _ in range(20)]
print("opened", flush=True)
sys.stdin.readline()
close_server(server)
"""


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="limits are Linux's")
def test_many_silent_connections_take_no_descriptor_from_the_rest() -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", FEW_DESCRIPTORS],
        cwd=Path(__file__).parents[2],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    port = int(process.stdout.readline())
    with ExitStack() as stack:
        for _ in range(40):
            # No more than may wait to be let in: one that must come again does so a second later.
            for _ in range(3):
                stack.enter_context(socket.create_connection(("127.0.0.1", port), PATIENCE_S))
            assert get(port).status == 200
        process.stdin.write("\n")
        process.stdin.flush()
        assert process.stdout.readline() == "opened\n"
    _, said = process.communicate("\n", timeout=60)
    assert process.returncode == 0
    assert "Traceback" not in said
    assert "no file descriptor left" not in said


def test_no_descriptor_left_is_said_in_words(caplog: pytest.LogCaptureFixture) -> None:
    loop = asyncio.new_event_loop()
    error = OSError(errno.EMFILE, "Too many open files")
    tell_of_error(loop, {"message": "socket.accept() out of system resource", "exception": error})
    tell_of_error(loop, {"message": "Task exception was never retrieved", "exception": KeyError(3)})
    tell_of_error(loop, {"message": "Task was destroyed but it is pending!"})
    loop.close()
    assert [(record.levelno, record.getMessage()) for record in caplog.records] == [
        (logging.WARNING, "no page can be let in: this process has no file descriptor left"),
        (logging.ERROR, "the page's server: KeyError: 3"),
        (logging.ERROR, "the page's server: Task was destroyed but it is pending!"),
    ]


def test_errors_in_the_servers_loop_reach_the_log(
    lab: Lab, caplog: pytest.LogCaptureFixture
) -> None:
    loop = lab.server._websock_server._background_event_loop
    assert loop is not None

    def fail() -> None:
        raise ValueError("nothing to do with a page")

    loop.call_soon_threadsafe(fail)
    page, _ = lab.page()
    assert lab.hears(page)
    assert "the page's server: ValueError: nothing to do with a page" in caplog.text
