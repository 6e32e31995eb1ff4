"""Who may talk to the lab's web server, and which of their messages are let through.

viser serves a page and a websocket to anyone who can reach the port: it looks neither at the `Host`
nor at the `Origin` of a request, and it stores whatever a page sends as a widget's value.
`open_server` puts a door in front of it, at three places:

- *the request*: `Host` must be a name of this server (a foreign name that resolves to it is DNS
  rebinding), a page must come from this very server, and there is a limit on open pages;
- *the frame*: what is not a viser message ends its connection, quietly;
- *the message*: only what a page has reason to send, for a widget that is there, shown and enabled,
  with a value that this very widget allows. All else is dropped before viser sees it.

The door is also a way back out of HTML, which viser does not have: a link to `address_of(...)` in
an HTML widget is a call, answered here with "204 No Content", at which a browser stays on its page.
Such links are best aimed at a hidden frame (`target`), so that a call that nobody takes, which is
answered with a text, does not take the page's place either.

Private parts of viser are used in this module alone (viser>=1.1.1,<1.2). The one function that it
replaces, while a server is being made, is `websockets.asyncio.server.serve`: viser passes its
request handler and size limit through that call, and offers no other way in.
"""

import asyncio
import contextlib
import errno
import functools
import inspect
import io
import ipaddress
import itertools
import logging
import math
import numbers
import re
import secrets
import socket
import threading
import types
import typing
import urllib.parse
from collections.abc import Callable, Iterator, Sequence
from http import HTTPStatus
from typing import Any, Final, Literal, NamedTuple, TypeVar

import viser
import websockets.asyncio.server
from viser import _messages as wire
from viser._gui_handles import GuiFormHandle
from websockets.asyncio.server import ServerConnection
from websockets.frames import CloseCode
from websockets.http11 import Request, Response

MAX_MESSAGE_BYTES: Final = 4 * 2**20
"""Largest websocket message. A page uploads in parts of 0.5 MiB; a rendered picture is larger."""

MAX_TEXT_CHARACTERS: Final = 2_000
MAX_FILE_NAME_CHARACTERS: Final = 255

MAX_CALL_CHARACTERS: Final = 512
"""Longest words that a link may call, with the secret before them, in plain characters."""

GRACE_S: Final = 1.5
"""How long a page may take to mend a wrong value itself before it is set right and told.

A number field sends every keystroke, so 15 typed into a field for 10 to 100 arrives as 1 and then
as 15; putting the old value back in between would make typing impossible.
"""

_LOOPBACK: Final = frozenset({"127.0.0.1", "localhost", "[::1]"})
_AUTHORITY: Final = re.compile(r"(?P<name>\[[0-9a-f:.]+\]|[^\[\]:/@?#\s]+)(:(?P<port>\d{1,5}))?")
_DEFAULT_HTTP_PORT: Final = 80
_CALL_PATH: Final = "/call/"

_SECURITY_HEADERS: Final = {
    # No other page may frame this one and have the user click in it unawares. Both spellings, since
    # old browsers know only the second.
    "Content-Security-Policy": "frame-ancestors 'none'",
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
}

Event = TypeVar("Event")
OnRefused = Callable[[int, str], None]
OnCall = Callable[[str], bool]

log = logging.getLogger(__name__)


# --- Opening -------------------------------------------------------------------------------------


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
    door = _Door(host, on_refused, on_call, max_clients, max_upload_bytes)
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
def _serving_through(door: "_Door") -> Iterator[None]:
    """Have the viser server that is made inside the context put `door` before its socket."""
    with _being_made:
        serve = websockets.asyncio.server.serve

        def serve_behind_door(handler: Any, host: str, port: int, **options: Any) -> Any:
            door.in_place = True
            options.update(
                process_request=functools.partial(door.answer, options["process_request"]),
                process_response=_harden,
                create_connection=functools.partial(_CheckedConnection, door=door),
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


# --- Requests ------------------------------------------------------------------------------------


class _Authority(NamedTuple):
    """The name and port that a `Host` header or an origin speaks of; IPv6 addresses in brackets."""

    name: str
    port: int


def _authority(text: str) -> _Authority | None:
    match = _AUTHORITY.fullmatch(text.lower())
    if match is None:
        return None
    return _Authority(match["name"], int(match["port"] or _DEFAULT_HTTP_PORT))


def _same_place(one: _Authority, other: _Authority) -> bool:
    """Whether both speak of one server; the names of the loopback interface count as one."""
    same_name = one.name == other.name or {one.name, other.name} <= _LOOPBACK
    return same_name and one.port == other.port


def _source(origin: str) -> _Authority | None:
    """The place that an origin speaks of; None if it is none that the lab's page can have."""
    scheme, _, rest = origin.partition("://")
    return _authority(rest) if scheme == "http" else None


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name.strip("[]"))
    except ValueError:
        return False
    return True


def _own_names(host: str) -> frozenset[str]:
    bracketed = f"[{host}]" if ":" in host else host
    return _LOOPBACK | {bracketed.lower()}


def _machine_names() -> frozenset[str]:
    name = socket.gethostname().lower()
    return frozenset({name, f"{name}.local", socket.getfqdn().lower()})


def _harden(_: ServerConnection, request: Request, response: Response) -> None:
    for name, value in _SECURITY_HEADERS.items():
        response.headers[name] = value
    if _is_call(request):
        # Each call has to arrive, however often it was made before.
        response.headers["Cache-Control"] = "no-store"


def _is_call(request: Request) -> bool:
    return request.path.startswith(_CALL_PATH)


def _called_words(request: Request) -> str | None:
    """What a call says; None if that is too long, or no text."""
    quoted = request.path.removeprefix(_CALL_PATH).partition("?")[0]
    try:
        words = urllib.parse.unquote_to_bytes(quoted.encode("ascii")).decode()
    except UnicodeError:
        return None
    return words if len(words) <= MAX_CALL_CHARACTERS else None


def _is_from_page_of(host: _Authority, request: Request) -> bool:
    """Whether a page of `host` made the browser send this request; in doubt, it did not.

    A picture or a link on a foreign page has no `Origin`. Browsers send `Sec-Fetch-Site` to https
    and to the loopback interface alone; in a lab on the network the `Referer` has to tell. A page
    can withhold the latter, and forge neither.
    """
    sites = request.headers.get_all("Sec-Fetch-Site")
    if sites:
        return set(sites) == {"same-origin"}
    referers = request.headers.get_all("Referer")
    if len(referers) != 1:
        return False
    source = _source("/".join(referers[0].split("/")[:3]))
    return source is not None and _same_place(source, host)


class _Door:
    """What is asked of a request, and the settings for the connections that it lets in."""

    def __init__(
        self,
        host: str,
        on_refused: OnRefused | None,
        on_call: OnCall | None,
        max_clients: int,
        max_upload_bytes: int,
    ) -> None:
        self.on_refused = on_refused
        self.max_upload_bytes = max_upload_bytes
        self.in_place = False
        self.server: viser.ViserServer | None = None
        self._on_call: OnCall = on_call or (lambda words: False)
        self._max_clients = max_clients
        self._to_network = _is_address(host) and ipaddress.ip_address(host).is_unspecified
        self._names = _own_names(host) | (_machine_names() if self._to_network else frozenset())

    def answer(self, viser_answer: Any, connection: ServerConnection, request: Request) -> Any:
        """Refuse the request, take a call, or let viser answer (None: go on with the handshake)."""
        if self.server is None:
            # A page left open reconnects as soon as the port answers, before viser is complete.
            return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, "The lab is starting.\n")
        fault = self._fault(request)
        if fault is not None:
            log.info("refused a request: %s", fault)
            return connection.respond(HTTPStatus.FORBIDDEN, f"{fault}\n")
        if _is_call(request):
            return self._answer_call(connection, request)
        answer = viser_answer(connection, request)
        if answer is None and len(connection.server.connections) >= self._max_clients:
            return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, "Too many open pages.\n")
        return answer

    def _fault(self, request: Request) -> str | None:
        """What is wrong with where the request is addressed to, or where it comes from.

        `Origin` must speak of the same server as `Host` on every request that has one, so nothing
        hangs on telling a handshake from a page load. Only names are held against our own, not the
        port, which differs behind a forwarded port; a browser writes both headers itself.
        """
        hosts = request.headers.get_all("Host")
        host = _authority(hosts[0]) if len(hosts) == 1 else None
        if host is None or not self._is_own(host.name):
            return "This is not a name of this server."
        origins = request.headers.get_all("Origin")
        for origin in origins:
            source = _source(origin)
            if source is None or not _same_place(source, host):
                return "This page belongs to another site."
        # A call has effects, so more is asked of it than of what only reads.
        if _is_call(request) and not _is_from_page_of(host, request):
            return "This call does not come from a page of this server."
        return None

    def _answer_call(self, connection: ServerConnection, request: Request) -> Response:
        status = HTTPStatus.INTERNAL_SERVER_ERROR
        # What the callback raises is logged, not raised again, and leaves this status as it is.
        with _told_to(None, self._on_call):
            words = _called_words(request)
            taken = words is not None and self._on_call(words)
            status = HTTPStatus.NO_CONTENT if taken else HTTPStatus.NOT_FOUND
        if status != HTTPStatus.NO_CONTENT:
            return connection.respond(status, f"{status.phrase}.\n")
        response = connection.respond(status, "")
        # HTTP allows no length of what is not there (RFC 9110, section 8.6).
        del response.headers["Content-Length"]
        del response.headers["Content-Type"]
        return response

    def _is_own(self, name: str) -> bool:
        return name in self._names or (self._to_network and _is_address(name))


# --- Calls ---------------------------------------------------------------------------------------


class Calls:
    """Addresses that a page's links may call, each good for one browser only.

    Its `take` is what `open_server` wants as `on_call`. All methods may be called on any thread.
    """

    def __init__(self) -> None:
        self._takers: dict[str, Callable[[str], object]] = {}
        self._lock = threading.Lock()

    def enter(self, take: Callable[[str], object]) -> str:
        """Have `take(words)` called for whoever knows the secret that this returns.

        It runs on the server's event loop and must return at once.
        """
        secret = secrets.token_urlsafe(16)
        with self._lock:
            self._takers[secret] = take
        return secret

    def leave(self, secret: str) -> None:
        """Take no more calls under a secret; nothing happens if there is none."""
        with self._lock:
            self._takers.pop(secret, None)

    def take(self, words: str) -> bool:
        """Hand on what follows the secret; whether there was somebody to hand it to."""
        secret, _, rest = words.partition("/")
        with self._lock:
            take = self._takers.get(secret)
        if take is None:
            return False
        take(rest)
        return True


def address_of(secret: str, words: str) -> str:
    """What a link of the page refers to (`href`) to call these words; needs no escaping in HTML.

    It is relative to the page, so it holds behind a forwarded port and below a path as well.
    A click is lost when the HTML around the link is replaced while the mouse button is down, so
    links belong in a widget whose content rests.

    Raises:
        ValueError: No such call could arrive.
    """
    if len(secret) + 1 + len(words) > MAX_CALL_CHARACTERS:
        raise ValueError(f"with its secret a call has at most {MAX_CALL_CHARACTERS} characters")
    if words in (".", ".."):
        # A browser takes them for steps along the path, even when they are percent-encoded.
        raise ValueError(f"{words!r} cannot be called")
    return f"call/{secret}/{urllib.parse.quote(words, safe='')}"


# --- Frames --------------------------------------------------------------------------------------


class _CheckedConnection(ServerConnection):
    """A websocket connection from which only admissible messages are received."""

    def __init__(self, *args: Any, door: _Door, **options: Any) -> None:
        super().__init__(*args, **options)
        self._door = door

    @functools.cached_property
    def _desk(self) -> "_Desk":
        # viser enters the connection in this table before it first receives from it.
        server = self._door.server
        assert server is not None
        table = server._websock_server._live_connections
        client_id = next(number for number, other in table.items() if other is self)
        return _Desk(server, client_id, self._door)

    async def recv(self, decode: bool | None = None) -> Any:
        while True:
            frame = await super().recv(decode)
            # Frames that wait in the queue come without a pause. With one, viser has acted on the
            # message before, and this one is judged by the state that it left.
            await asyncio.sleep(0)
            message = _decoded(frame)
            if message is None:
                log.info("closed a connection that sent something else than messages")
                await self.close(CloseCode.UNSUPPORTED_DATA, "not a message")
                # What viser takes for an ordinary end, unlike the decoder's own errors.
                raise self.protocol.close_exc
            if self._desk.admits(message):
                return frame


def _decoded(frame: Any) -> wire.Message | None:
    """The message in a frame, None if there is none. viser decodes it once more: it is short."""
    if not isinstance(frame, bytes):
        return None
    try:
        return typing.cast(wire.Message, wire.Message.deserialize(frame))
    except Exception:
        # The bytes are a stranger's: what the decoder trips over (a wrong type, a missing key, too
        # deep a nest) differs, what follows does not. No list of errors would be complete.
        log.debug("not a message", exc_info=True)
        return None


# --- Messages ------------------------------------------------------------------------------------


class _Transfer(NamedTuple):
    """A file that is on its way from one page."""

    gui: viser.GuiApi
    transfer_uuid: str
    source_uuid: str


class _Desk:
    """Judges the messages of one page, and sets the page right when one was dropped."""

    def __init__(self, server: viser.ViserServer, client_id: int, door: _Door) -> None:
        self._server = server
        self._client_id = client_id
        self._door = door
        self._loop = asyncio.get_running_loop()
        self._transfer: _Transfer | None = None
        self._corrections: dict[str, asyncio.TimerHandle] = {}

    def admits(self, message: wire.Message) -> bool:
        """Whether viser may see this message; if not, what has to follow is under way."""
        rule = _RULES.get(type(message))
        if rule is None or not _is_well_typed(message):
            self._refuse("This page sent a message that makes no sense here.")
            return False
        if self._client is None and not isinstance(message, _MESSAGES_BEFORE_THE_FIRST_PICTURE):
            return False
        return rule(self, message)

    # Each rule says whether the message may pass. Messages for something that is not there (any
    # more) are dropped without a word: removing a widget while it is in use is nobody's fault.

    def _pass(self, message: wire.Message) -> bool:
        return True

    def _click_or_box(self, message: wire.ScenePointerMessage) -> bool:
        # viser takes these fields for granted.
        if message.event_type == "click":
            ray = (message.ray_origin, message.ray_direction)
            return None not in ray and len(message.screen_pos) == 1
        return len(message.screen_pos) == 2

    def _update(self, message: wire.GuiUpdateMessage) -> bool:
        handle = self._input(message.uuid)
        if handle is None:
            return False
        correction = self._corrections.pop(message.uuid, None)
        if correction is not None:
            correction.cancel()
        fault = self._unavailable(handle) or _update_fault(handle, message.updates)
        if fault is not None:
            self._corrections[message.uuid] = self._loop.call_later(
                GRACE_S, self._correct, handle, fault
            )
        return fault is None

    def _hold(self, message: wire.GuiButtonHoldMessage) -> bool:
        handle = self._input(message.uuid)
        if handle is None:
            return False
        fault = self._unavailable(handle)
        if fault is not None:
            self._refuse(fault)
        return fault is None

    def _form(self, message: wire.GuiFormSubmitMessage | wire.GuiFormDirtyMessage) -> bool:
        for gui in self._guis:
            form = gui._container_handle_from_uuid.get(message.uuid)
            if isinstance(form, GuiFormHandle):
                return not _is_hidden(form)
        return False

    def _upload(self, message: wire.FileTransferStartUpload) -> bool:
        handle = self._input(message.source_component_uuid)
        if handle is None:
            return False
        fault = self._unavailable(handle) or self._upload_fault(handle, message)
        if fault is not None:
            self._end_upload(message.source_component_uuid, message.transfer_uuid)
            self._refuse(fault)
            return False
        self._transfer = _Transfer(
            handle._impl.gui_api, message.transfer_uuid, message.source_component_uuid
        )
        return True

    def _upload_fault(self, handle: Any, message: wire.FileTransferStartUpload) -> str | None:
        name = _name(handle)
        if not isinstance(handle, viser.GuiUploadButtonHandle):
            return f"{name} takes no file."
        if not 0 <= message.size_bytes <= self._door.max_upload_bytes:
            return f"{name} takes files of at most {self._door.max_upload_bytes // 1024} KiB."
        # The page sends parts of 512 KiB; tiny ones would cost far more memory than they carry.
        if not min(1, message.size_bytes) <= message.part_count <= -(-message.size_bytes // 2**16):
            return f"{name} got a file in a strange number of parts."
        if not 0 < len(message.filename) <= MAX_FILE_NAME_CHARACTERS:
            return f"{name} takes file names of at most {MAX_FILE_NAME_CHARACTERS} characters."
        # Also no second transfer under a name in use, which would take the first one's place.
        names = {message.transfer_uuid}
        if self._transfer is not None:
            names.add(self._transfer.transfer_uuid)
        if any(names & gui._current_file_upload_states.keys() for gui in self._guis):
            return f"{name} is busy with another file."
        return None

    def _upload_part(self, message: wire.FileTransferPart) -> bool:
        transfer = self._transfer
        # viser neither asks whose transfer a part is for, nor which widget started it.
        wanted = (message.transfer_uuid, message.source_component_uuid)
        if transfer is None or wanted != transfer[1:]:
            return False
        states = transfer.gui._current_file_upload_states
        state = states.get(transfer.transfer_uuid)
        if state is None:
            return False
        if state["transferred_bytes"] + len(message.content) > state["total_bytes"]:
            states.pop(transfer.transfer_uuid, None)
            self._end_upload(transfer.source_uuid, transfer.transfer_uuid)
            self._refuse("This file is longer than announced.")
            return False
        return True

    @property
    def _client(self) -> viser.ClientHandle | None:
        """The page's handle; None before its first camera message, when it shows nothing yet."""
        return self._server._connected_clients.get(self._client_id)

    @property
    def _guis(self) -> tuple[viser.GuiApi, ...]:
        """The panels that the page shows: everyone's, and its own."""
        client = self._client
        return (self._server.gui,) if client is None else (self._server.gui, client.gui)

    def _input(self, uuid: str) -> Any:
        for gui in self._guis:
            handle = gui._gui_input_handle_from_uuid.get(uuid)
            if handle is not None and not handle._impl.removed:
                return handle
        return None

    def _unavailable(self, handle: Any) -> str | None:
        # The props, because a button group's handle always says that it is enabled.
        disabled = getattr(handle._impl.props, "disabled", False)
        if self._client is None or disabled or _is_hidden(handle):
            return f"{_name(handle)} is not available now."
        return None

    def _refuse(self, reason: str) -> None:
        log.info("dropped a message of client %d: %s", self._client_id, reason)
        if self._door.on_refused is not None and self._client is not None:
            # Not at once: what the callback raises is not to end the connection.
            self._loop.call_soon(self._door.on_refused, self._client_id, reason)

    def _correct(self, handle: Any, reason: str) -> None:
        """Put the true value back into the page's widget, and say why."""
        state = handle._impl
        self._corrections.pop(state.uuid, None)
        if not (state.removed or state.is_button):
            self._send(wire.GuiUpdateMessage(state.uuid, {"value": state.value}))
        self._refuse(reason)

    def _end_upload(self, source_uuid: str, transfer_uuid: str) -> None:
        """Have the page give up an upload: it disables the button until all is acknowledged."""
        self._send(wire.FileTransferPartAck(source_uuid, transfer_uuid, 0, 0))
        self._send(wire.RemoveNotificationMessage(f"upload-{transfer_uuid}"))

    def _send(self, message: wire.Message) -> None:
        # The page's own queue: nobody else hears of it. It is gone once the page is.
        state = self._server._websock_server._client_state_from_id.get(self._client_id)
        if state is not None:
            state.message_buffer.push(message)


_RULES: Final[dict[type[wire.Message], Callable[[_Desk, Any], bool]]] = {
    wire.ViewerCameraMessage: _Desk._pass,
    wire.GetRenderResponseMessage: _Desk._pass,
    wire.LocalStorageGetItemResponseMessage: _Desk._pass,
    wire.SceneNodeClickMessage: _Desk._pass,
    wire.SceneNodeDragMessage: _Desk._pass,
    wire.TransformControlsUpdateMessage: _Desk._pass,
    wire.TransformControlsDragStartMessage: _Desk._pass,
    wire.TransformControlsDragEndMessage: _Desk._pass,
    wire.ScenePointerMessage: _Desk._click_or_box,
    wire.GuiUpdateMessage: _Desk._update,
    wire.GuiButtonHoldMessage: _Desk._hold,
    wire.GuiFormSubmitMessage: _Desk._form,
    wire.GuiFormDirtyMessage: _Desk._form,
    wire.CommandTriggerMessage: _Desk._pass,  # viser itself asks whether it is enabled
    wire.FileTransferStartUpload: _Desk._upload,
    wire.FileTransferPart: _Desk._upload_part,
}
"""Everything that viser's page sends by itself, but for the requests for a share tunnel."""

_MESSAGES_BEFORE_THE_FIRST_PICTURE: Final = (
    wire.ViewerCameraMessage,  # makes it a client, in viser's eyes
    wire.GuiUpdateMessage,  # refused then, but with the true value in return
)


def _name(handle: Any) -> str:
    return getattr(handle._impl.props, "label", None) or "This"


def _is_hidden(handle: Any) -> bool:
    """Whether the widget or anything that it lies in is not shown."""
    state = handle._impl
    while state is not None:
        if not getattr(state.props, "visible", True):
            return True
        uuid = getattr(state, "parent_container_id", "root")
        if uuid == "root":
            return False
        try:
            container = state.gui_api._resolve_container_handle(uuid)
        except KeyError:
            return True  # Removed by another thread just now.
        # A tab is shown with the tab group or panel that it belongs to; a modal always is.
        state = getattr(getattr(container, "_parent", container), "_impl", None)
    return False


# --- Values --------------------------------------------------------------------------------------


@functools.cache
def _fields(message_type: type[wire.Message]) -> tuple[tuple[str, Any], ...]:
    hints = typing.get_type_hints(message_type)
    return tuple((name, hints[name]) for name in message_type.__dataclass_fields__)  # type: ignore


def _is_well_typed(message: wire.Message) -> bool:
    """Whether every field holds what its annotation says; viser's decoder only converts numbers."""
    return all(_fits(getattr(message, name), hint) for name, hint in _fields(type(message)))


def _fits(value: Any, hint: Any) -> bool:
    """Whether a decoded value is of the annotated type; numbers must be finite."""
    kind, parts = typing.get_origin(hint), typing.get_args(hint)
    if hint is Any:
        return True
    if hint in (int, float):
        return _is_real(value) and (hint is float or isinstance(value, int))
    if kind in (typing.Union, types.UnionType):
        return any(_fits(value, part) for part in parts)
    if kind is Literal:
        return value in parts
    if kind is tuple:
        if not isinstance(value, tuple):
            return False
        if parts[1:] == (...,):
            parts = parts[:1] * len(value)
        return len(value) == len(parts) and all(map(_fits, value, parts))
    return isinstance(value, kind or hint)


def _is_real(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _update_fault(handle: Any, updates: dict[Any, Any]) -> str | None:
    """Why the widget may not be updated so; None if it may. A page only ever sets `value`."""
    if updates.keys() != {"value"}:
        return "This page tried to change more than a value."
    complaint_about = _COMPLAINTS.get(type(handle))
    name = _name(handle)
    if complaint_about is None:
        return f"{name} takes no value."
    complaint = complaint_about(handle, updates["value"])
    return None if complaint is None else f"{name} {complaint}."


def _number_complaint(value: Any, like: Any, low: Any, high: Any) -> str | None:
    """What is wrong with a number for a widget that now holds the number `like`.

    A page has one kind of number and sends 3.0 as an integer, so a widget of floats takes both, and
    a widget of integers takes a float that is whole.
    """
    if not _is_real(value):
        return "needs a number"
    if isinstance(like, numbers.Integral) and value != int(value):
        return "needs a whole number"
    if low is not None and value < low:
        return f"must be at least {low}"
    if high is not None and value > high:
        return f"must be at most {high}"
    return None


def _list_complaint(values: Any, like: Sequence[Any], lows: Any, highs: Any) -> str | None:
    """The first complaint about a list of numbers; limits are a sequence, or None."""
    size = len(like)
    if not isinstance(values, list | tuple) or len(values) != size:
        return f"needs {size} numbers"
    nothing = (None,) * size
    complaints = map(_number_complaint, values, like, lows or nothing, highs or nothing)
    return next((complaint for complaint in complaints if complaint is not None), None)


def _slider_complaint(handle: Any, value: Any) -> str | None:
    return _number_complaint(value, handle.value, handle.min, handle.max)


def _multi_slider_complaint(handle: Any, values: Any) -> str | None:
    now = handle.value
    complaint = _list_complaint(values, now, [handle.min] * len(now), [handle.max] * len(now))
    if complaint is not None:
        return complaint
    if any(later < earlier for earlier, later in itertools.pairwise(values)):
        return "needs its marks in order"
    if handle.fixed_endpoints and (values[0], values[-1]) != (now[0], now[-1]):
        return "has fixed ends"
    return None


def _vector_complaint(handle: Any, values: Any) -> str | None:
    return _list_complaint(values, handle.value, handle.min, handle.max)


def _color_complaint(handle: Any, values: Any) -> str | None:
    size = len(handle.value)
    return _list_complaint(values, [0] * size, [0] * size, [255] * size)


def _choice_complaint(handle: Any, value: Any) -> str | None:
    return None if isinstance(value, str) and value in handle.options else "has no such choice"


def _flag_complaint(handle: Any, value: Any) -> str | None:
    return None if isinstance(value, bool) else "is either on or off"


def _text_complaint(handle: Any, value: Any) -> str | None:
    if not isinstance(value, str):
        return "needs a text"
    if len(value) > MAX_TEXT_CHARACTERS:
        return f"takes at most {MAX_TEXT_CHARACTERS} characters"
    return None


_COMPLAINTS: Final[dict[type, Callable[[Any, Any], str | None]]] = {
    viser.GuiSliderHandle: _slider_complaint,
    viser.GuiNumberHandle: _slider_complaint,
    viser.GuiMultiSliderHandle: _multi_slider_complaint,
    viser.GuiVector2Handle: _vector_complaint,
    viser.GuiVector3Handle: _vector_complaint,
    viser.GuiRgbHandle: _color_complaint,
    viser.GuiRgbaHandle: _color_complaint,
    viser.GuiDropdownHandle: _choice_complaint,
    viser.GuiButtonGroupHandle: _choice_complaint,
    viser.GuiCheckboxHandle: _flag_complaint,
    viser.GuiButtonHandle: _flag_complaint,
    viser.GuiTextHandle: _text_complaint,
}
"""For each kind of widget that a page may set: what is wrong with a value, None if nothing is."""


# --- Callbacks -----------------------------------------------------------------------------------


class RefusedError(ValueError):
    """What somebody asked for makes no sense; the message says why, and what would."""


def guarded(callback: Callable[[Event], Any]) -> Callable[[Event], Any]:
    """Make a viser callback, plain or async, tell the acting page when it fails.

    What it raises becomes a notification there and one line in the log (the traceback is logged at
    DEBUG). A failure that no page caused is only logged. Never raises an `Exception`.
    """
    if inspect.iscoroutinefunction(callback):

        @functools.wraps(callback)
        async def guarded_async(event: Event) -> None:
            with _told_to(event, callback):
                await callback(event)

        return guarded_async

    @functools.wraps(callback)
    def guarded_plain(event: Event) -> None:
        with _told_to(event, callback):
            callback(event)

    return guarded_plain


@contextlib.contextmanager
def _told_to(event: Any, callback: Callable[..., Any]) -> Iterator[None]:
    client = event if isinstance(event, viser.ClientHandle) else getattr(event, "client", None)
    try:
        yield
    except RefusedError as error:
        # What was asked for makes no sense; that is between the page and its user.
        if client is not None:
            client.add_notification(
                "That cannot be done now", str(error)[:400], auto_close_seconds=8.0
            )
    except Exception as error:
        # The last place that can tell the user: beyond it lie viser's threads, which print to a
        # terminal that nobody watches. So it takes every error, whatever the callback may raise.
        text = f"{type(error).__name__}: {error}".splitlines()[0][:200]
        log.error("%s failed: %s", getattr(callback, "__qualname__", callback), text)
        log.debug("the failure above", exc_info=True)
        if client is not None:
            client.add_notification("That did not work", text, color="red", auto_close_seconds=10.0)
