"""Opening and closing the server."""

import asyncio
import contextlib
import errno
import functools
import io
import logging
import socket
import threading
from collections.abc import Iterator, Sequence
from typing import Any, Final

import viser
import websockets.asyncio.server
from viser import _messages as wire
from websockets.asyncio.server import ServerConnection
from websockets.frames import CloseCode

from app.server.access import Access
from app.server.addresses import answering_addresses
from app.server.buffers import make_safe
from app.server.channels import Channels, is_of_channel
from app.server.connections import (
    HANDSHAKE_S,
    Connection,
    Crowd,
    Room,
    room_for,
    tell_of_error,
)
from app.server.door import Door, OnCall, OnRefused, harden, n_pages
from app.server.icons import keep_icons
from app.server.links import Links
from app.server.origin import Authority, is_loopback
from app.server.workers import Workers

MAX_MESSAGE_BYTES: Final = 4 * 2**20
"""Largest websocket message. A page uploads in parts of 0.5 MiB; a rendered picture is larger."""

log = logging.getLogger(__name__)


def open_server(
    host: str = "127.0.0.1",
    port: int = 8080,
    *,
    label: str | None = None,
    names: Sequence[Authority] = (),
    access: Access | None = None,
    on_refused: OnRefused | None = None,
    on_call: OnCall | None = None,
    channels: Channels | None = None,
    links: Links | None = None,
    workers: Workers | None = None,
    max_clients: int = 64,
    max_upload_bytes: int = 256 * 1024,
) -> viser.ViserServer:
    """Start a viser server behind a door, on `port` or the next free one (0: any free one).

    `on_refused(client_id, reason)` is called when a page has sent something that was dropped, so
    that the page can be told (for a widget's value after `GRACE_S`, unless the page mends it
    first). It runs on the server's event loop and must return at once.
    `on_call(words)` is called when a link of the page to `/call/<words>` was followed, and says
    whether it took the call (see `Calls`). It runs there too and must return at once.
    Frames of the page talk through `channels`. Links to sessions are kept in `links`.
    `host` "0.0.0.0" or "::" opens the lab to the network; then it answers to any IP address and to
    the machine's own names. It answers to `names` besides, and takes pages of theirs for its own.
    With `access` it lets in only who has the token. Callbacks are run by `workers`.

    Raises:
        ValueError: `port` is not a port number.
        OSError: `host` is not an address of this machine, or no port is free.
        RuntimeError: viser did not start its server the way this module expects.
    """
    if host == "localhost":
        # The name may stand for two addresses, and port 0 would give each a port of its own.
        host = "127.0.0.1"
    free_port = _first_free_port(host, port)
    room = room_for(max_clients)
    door = Door(
        host,
        names=names,
        title=label or "viser",
        access=access,
        on_refused=on_refused,
        on_call=on_call,
        channels=channels,
        links=links,
        max_clients=room.pages,
        max_upload_bytes=max_upload_bytes,
    )
    # viser greets on standard output whatever `verbose` says; the lab speaks for itself.
    with _serving_through(door, room), contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=free_port, label=label, verbose=False)
    if not door.in_place:
        server.stop()
        raise RuntimeError("viser bypassed the door: its version is not one this module knows")
    # The door lets no such message through either; but with these gone none could start a tunnel.
    server._websock_server.unregister_handler(wire.ShareUrlRequest)
    server._websock_server.unregister_handler(wire.ShareUrlDisconnect)
    server.gui.configure_theme(show_share_button=False)
    make_safe(server)
    keep_icons()
    _employ(workers or Workers(), server)
    door.open_for(server)
    return server


def _employ(workers: Workers, server: viser.ViserServer) -> None:
    """Have callbacks run by threads that know whose they are; there is no page as yet."""
    server._thread_executor.shutdown()
    for employer in (server, server.gui, server.scene):
        employer._thread_executor = workers


def close_server(server: viser.ViserServer) -> None:
    """Stop a server without a word on standard output."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def is_serving(server: viser.ViserServer) -> bool:
    """Whether the server's thread, which has every connection, is alive."""
    thread = server._websock_server._server_thread
    return thread is not None and thread.is_alive()


def is_on_this_machine(server: viser.ViserServer, client_id: int) -> bool:
    """Whether a page is open in a browser on the server's own machine, as far as one can tell.

    Behind a proxy on this machine all are.
    """
    # viser does not hand out its connections.
    pages = server._websock_server  # pyright: ignore[reportPrivateUsage]
    connection = pages._live_connections.get(client_id)  # pyright: ignore[reportPrivateUsage]
    if connection is None:
        return False
    remote, local = connection.remote_address, connection.local_address
    return remote is not None and (is_loopback(str(remote[0])) or remote[0] == local[0])


def addresses_of(server: viser.ViserServer) -> tuple[str, ...]:
    """Addresses under which the server has just answered, that of this machine first."""
    return answering_addresses(server.get_host(), server.get_port())


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
def _serving_through(door: Door, room: Room) -> Iterator[None]:
    """Have the viser server that is made inside the context put `door` before its socket."""
    with _being_made:
        serve = websockets.asyncio.server.serve

        def serve_behind_door(handler: Any, host: str, port: int, **options: Any) -> Any:
            door.in_place = True
            options.update(
                process_request=functools.partial(door.answer, options["process_request"]),
                process_response=harden,
                create_connection=functools.partial(Connection, door=door, crowd=Crowd(room.pages)),
                open_timeout=HANDSHAKE_S,
                max_size=MAX_MESSAGE_BYTES,
                backlog=room.backlog,
                logger=_wire_log,
            )
            asyncio.get_running_loop().set_exception_handler(tell_of_error)
            return serve(functools.partial(_handle, door, handler), host, port, **options)

        websockets.asyncio.server.serve = serve_behind_door  # type: ignore[assignment]
        try:
            yield
        finally:
            websockets.asyncio.server.serve = serve


async def _handle(door: Door, viser_handler: Any, connection: ServerConnection) -> None:
    """Handle a connection that was let in: that of a channel, or one of viser's page."""
    if connection.request is not None and is_of_channel(connection.request):
        await door.channels.serve(connection)
    else:
        await _of_this_version(viser_handler, connection)


async def _of_this_version(handler: Any, connection: ServerConnection) -> None:
    """Let viser handle a connection of its page; it prints what another one calls itself."""
    if connection.subprotocol == f"viser-v{viser.__version__}":
        log.info("a page has come: %d are open", n_pages(connection))
        try:
            await handler(connection)
        finally:
            log.info("a page is going")
        return
    log.info("closed a connection of a page of another version")
    # With this code the page says what is wrong.
    await connection.close(CloseCode.PROTOCOL_ERROR, "another version")


def _is_our_fault(record: logging.LogRecord) -> bool:
    # Anything that is not an HTTP GET makes websockets log a traceback under this text.
    return record.getMessage() != "opening handshake failed"


_wire_log = logging.getLogger(f"{__name__}.wire")
_wire_log.addFilter(_is_our_fault)
# What it says below that are whole requests, with cookies and tokens.
_wire_log.setLevel(logging.WARNING)
