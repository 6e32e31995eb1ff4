"""Opening and closing the server."""

import contextlib
import errno
import functools
import io
import logging
import socket
import threading
from collections.abc import Iterator
from typing import Any, Final

import viser
import websockets.asyncio.server
from viser import _messages as wire

from app.server.admission import CheckedConnection
from app.server.door import Door, OnCall, OnRefused, harden

MAX_MESSAGE_BYTES: Final = 4 * 2**20
"""Largest websocket message. A page uploads in parts of 0.5 MiB; a rendered picture is larger."""


def open_server(
    host: str = "127.0.0.1",
    port: int = 8080,
    *,
    label: str | None = None,
    on_refused: OnRefused | None = None,
    on_call: OnCall | None = None,
    max_clients: int = 64,
    max_upload_bytes: int = 256 * 1024,
) -> viser.ViserServer:
    """Start a viser server behind a door, on `port` or the next free one (0: any free one).

    `on_refused(client_id, reason)` is called when a page has sent something that was dropped, so
    that the page can be told (for a widget's value after `GRACE_S`, unless the page mends it
    first). It runs on the server's event loop and must return at once.
    `on_call(words)` is called when a link of the page to `/call/<words>` was followed, and says
    whether it took the call (see `Calls`). It runs there too and must return at once.
    `host` "0.0.0.0" or "::" opens the lab to the network; then it answers to any IP address and to
    the machine's own names.

    Raises:
        ValueError: `port` is not a port number.
        OSError: `host` is not an address of this machine, or no port is free.
        RuntimeError: viser did not start its server the way this module expects.
    """
    if host == "localhost":
        # The name may stand for two addresses, and port 0 would give each a port of its own.
        host = "127.0.0.1"
    door = Door(host, label or "pounce", on_refused, on_call, max_clients, max_upload_bytes)
    free_port = _first_free_port(host, port)
    # viser greets on standard output whatever `verbose` says; the lab speaks for itself.
    with _serving_through(door), contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=free_port, label=label, verbose=False)
    if not door.in_place:
        server.stop()
        raise RuntimeError("viser bypassed the door: its version is not one this module knows")
    # The door lets no such message through either; but with these gone none could start a tunnel.
    server._websock_server.unregister_handler(wire.ShareUrlRequest)
    server._websock_server.unregister_handler(wire.ShareUrlDisconnect)
    server.gui.configure_theme(show_share_button=False)
    door.server = server
    return server


def close_server(server: viser.ViserServer) -> None:
    """Stop a server without a word on standard output."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def _first_free_port(host: str, port: int) -> int:
    """First port from `port` on that `host` can be bound to; viser hangs when it finds none."""
    if not 0 <= port <= 65_535:
        raise ValueError(f"{port} is not a port number (0 to 65535)")
    family, *_ = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    for candidate in range(port, 65_536):
        try:
            socket.create_server((host, candidate), family=family).close()
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise
        else:
            return candidate
    raise OSError(errno.EADDRINUSE, f"no free port on {host} from {port} on")


_being_made = threading.Lock()


@contextlib.contextmanager
def _serving_through(door: "Door") -> Iterator[None]:
    """Have the viser server that is made inside the context put `door` before its socket."""
    with _being_made:
        serve = websockets.asyncio.server.serve

        def serve_behind_door(handler: Any, host: str, port: int, **options: Any) -> Any:
            door.in_place = True
            options.update(
                process_request=functools.partial(door.answer, options["process_request"]),
                process_response=harden,
                create_connection=functools.partial(CheckedConnection, door=door),
                max_size=MAX_MESSAGE_BYTES,
                logger=_wire_log,
            )
            return serve(handler, host, port, **options)

        websockets.asyncio.server.serve = serve_behind_door  # type: ignore[assignment]
        try:
            yield
        finally:
            websockets.asyncio.server.serve = serve


def _is_our_fault(record: logging.LogRecord) -> bool:
    # Anything that is not an HTTP GET makes websockets log a traceback under this text.
    return record.getMessage() != "opening handshake failed"


_wire_log = logging.getLogger(f"{__name__}.wire")
_wire_log.addFilter(_is_our_fault)
