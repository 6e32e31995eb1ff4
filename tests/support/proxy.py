"""A proxy on a port of its own, as far as it matters to what stands behind it."""

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Header = tuple[str, str]
Rewrite = Callable[[list[Header], str], list[Header]]
"""Takes the headers of a request, and the place that the proxy asks in its turn."""


def keeps(headers: list[Header], upstream: str) -> list[Header]:
    """Leave the name that the browser knows."""
    return headers


def plain(headers: list[Header], upstream: str) -> list[Header]:
    """Put the name of what is asked in its place, as proxies do that are told nothing else."""
    return [*((name, value) for name, value in headers if name != "host"), ("host", upstream)]


def forged(headers: list[Header], upstream: str) -> list[Header]:
    """Claim that the page came from there as well."""
    others = [pair for pair in plain(headers, upstream) if pair[0] != "origin"]
    return [*others, ("origin", f"http://{upstream}")]


def deaf(headers: list[Header], upstream: str) -> list[Header]:
    """Know nothing of websockets."""
    return [pair for pair in headers if pair[0] not in ("upgrade", "connection")]


REWRITES: dict[str, Rewrite] = {"keeps": keeps, "plain": plain, "forged": forged, "deaf": deaf}


@contextmanager
def proxy_to(port: int) -> Iterator[int]:
    """Serve what is at a port of this machine below `/keeps/`, `/plain/` and so on.

    Yields the proxy's own port. A path without its last slash is asked for with it, and a request
    for anything else is hung up on.
    """
    with socket.create_server(("127.0.0.1", 0)) as listening:
        threading.Thread(target=_accept, args=(listening, port), daemon=True).start()
        yield listening.getsockname()[1]
        # What waits in `accept` is not woken by closing alone.
        listening.shutdown(socket.SHUT_RDWR)


def _accept(listening: socket.socket, port: int) -> None:
    while True:
        try:
            browser, _ = listening.accept()
        except OSError:
            return
        threading.Thread(target=_serve, args=(browser, port), daemon=True).start()


def _serve(browser: socket.socket, port: int) -> None:
    with browser, browser.makefile("rb") as reading:
        request_line = reading.readline().decode("latin-1").split(" ")
        headers: list[Header] = []
        while line := reading.readline().decode("latin-1").strip():
            name, _, value = line.partition(":")
            headers.append((name.lower(), value.strip()))
        if len(request_line) != 3:
            return
        _, folder, rest = (request_line[1] + "/").split("/", 2)
        path = "/" + rest.removesuffix("/")
        rewrite = REWRITES.get(folder.partition("?")[0])
        if rewrite is None:
            return
        if "?" in folder:
            path = "/?" + folder.partition("?")[2]
        headers = rewrite(headers, f"127.0.0.1:{port}")
        lines = [f"GET {path} HTTP/1.1", *(f"{name}: {value}" for name, value in headers), "", ""]
        try:
            lab = socket.create_connection(("127.0.0.1", port))
        except OSError:
            return
        with lab:
            lab.sendall("\r\n".join(lines).encode("latin-1"))
            threading.Thread(target=_pass_on, args=(browser, lab), daemon=True).start()
            _pass_on(lab, browser)


def _pass_on(source: socket.socket, sink: socket.socket) -> None:
    try:
        while data := source.recv(2**16):
            sink.sendall(data)
        sink.shutdown(socket.SHUT_WR)
    except OSError:
        # Either side may hang up.
        return
