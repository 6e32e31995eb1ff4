"""A port of its own for those who only look: a page, what it loads, and a websocket.

Nothing of the lab's own page is there. A thread of its own has all connections, so that what comes
over them waits for nobody. Of what a watcher sends, the newest wish is kept that fits the type its
reader states; all else is dropped. Whoever sends too much is read slowly, and whoever sends far too
much is let go. What goes out is bytes, the same for all who are to see the same.
"""

import asyncio
import contextlib
import logging
import socket
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from http import HTTPStatus
from typing import Any, Final, Protocol, cast

import msgspec
from websockets.asyncio.server import Server, ServerConnection, broadcast, serve
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode
from websockets.http11 import Request, Response
from websockets.protocol import State

from app.server import web_files
from app.server.access import Access, Words, cookie_name, cookies_of
from app.server.addresses import answering_addresses
from app.server.connections import HANDSHAKE_S, room_for, tell_of_error
from app.server.door import stranger
from app.server.origin import Authority, Names
from app.server.refusals import Refusal, refuse
from app.server.turnstile import Turnstile

MOST_WATCHERS: Final = 300
MAX_MESSAGE_BYTES: Final = 1_024
"""Largest message of a watcher; a longer one ends its connection before it is read."""
WISHES_PER_S: Final = 10.0
"""So many messages of a watcher are read in the long run: the rest waits in its network."""
WISHES_AT_ONCE: Final = 20.0
MOST_UNANSWERED: Final = 2
"""Messages that may be on their way to a watcher; while there are more it is sent nothing."""
FULL: Final = 4_003
"""The code with which a connection ends because there are too many."""

_BYTES_PER_S: Final = 4_096.0
_BYTES_AT_ONCE: Final = 65_536.0
"""What a watcher's browser may send, pings, answers and all; a page of ours sends a tenth."""
_REQUESTS_PER_S: Final = 150.0
_REQUESTS_AT_ONCE: Final = 1_500.0
"""Of all who come. A class comes at once, and each phone asks for some twenty files."""
_MOST_UNFINISHED: Final = 200
"""Connections that have not said what they want, or wait for an answer."""
_CLOSE_S: Final = 2.0
_ASKS_WHY: Final = "/why"
_SOCKET: Final = "/socket"
_POLICY: Final = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:;"
    " connect-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
)
_HEADERS: Final = {
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}
_REFUSAL_POLICY: Final = (
    "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'self';"
    " frame-ancestors 'none'"
)
"""What a refusal is has no scripts, and its style in it."""
_NOT_FOUND: Final = Refusal(HTTPStatus.NOT_FOUND, "Nothing is here. The page of the audience is /.")
_CODE: Final = Words(
    "Code",
    Refusal(
        HTTPStatus.UNAUTHORIZED,
        "This page asks for a code, which the presenter shows. Load it again to enter the code.",
    ),
    Refusal(HTTPStatus.UNAUTHORIZED, "That is not the code which the presenter shows."),
    Refusal(
        HTTPStatus.TOO_MANY_REQUESTS,
        "Too many wrong codes came from here; try again in a minute.",
    ),
    typed=True,
)
MOST_GUESSES: Final = 1_000
"""Wrong codes that one address may try in a minute: a class may have but one, and one of its
members is not to keep the others out. So many are none of the 10**11 that there are."""
MOST_SHORT_GUESSES: Final = 5
"""The same where the code is short: those who are in already stay in."""
_FULL: Final = Refusal(HTTPStatus.SERVICE_UNAVAILABLE, "Too many look already.")

log = logging.getLogger(__name__)


class _Seat(Protocol):
    """What a ticket stands for."""

    @property
    def is_taken(self) -> bool:
        """Whether it is still theirs."""
        ...


class Seats(Protocol):
    """Who is who from one visit to the next, without any name: a ticket is kept as a cookie."""

    def new_ticket(self) -> str:
        """For a browser that has none."""
        ...

    def is_ticket(self, text: str) -> bool:
        """Whether it is one that is good."""
        ...

    def sit(self, ticket: str) -> _Seat | None:
        """The seat of who has opened one more page; None if there is none for them."""
        ...

    def leave(self, seat: Any) -> None:
        """Note that one of its pages was closed."""
        ...


class Watcher:
    """One page that looks. What it wishes may be read in any thread."""

    def __init__(self, connection: "_Connection", seat: Any = None) -> None:
        self.wish: Any = None
        """The newest that came; None before the first."""
        self._seat = seat
        self.seen: dict[str, object] = {}
        """For whoever sends: what this one has been sent last, of each kind."""
        self.n_dropped = 0
        """Messages that were no wish."""
        self.connection = connection
        """Only for the thread of the port."""
        self._unanswered = 0

    @property
    def seat(self) -> Any:
        """What its browser's ticket stands for; None if it has no seat, or no more."""
        return self._seat if self._seat is not None and self._seat.is_taken else None

    @property
    def is_ready(self) -> bool:
        """Whether it has taken in what it was sent, or nearly so."""
        return self._unanswered < MOST_UNANSWERED

    def note_sent(self) -> None:
        """A message is on its way to it: it counts until it has been taken in."""
        self._unanswered += 1
        asyncio.get_running_loop().create_task(self._wait())

    async def _wait(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            await (await self.connection.ping())
        self._unanswered -= 1


class _Connection(ServerConnection):
    """A connection that is counted from its first moment on, and by the bytes that come over it."""

    def __init__(self, *args: Any, crowd: "_Crowd", **options: Any) -> None:
        super().__init__(*args, **options)
        self._crowd = crowd
        self._bytes = Turnstile(_BYTES_PER_S, _BYTES_AT_ONCE)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self._crowd.enter(self)

    def data_received(self, data: bytes) -> None:
        if self._bytes.wait_s(self.loop.time(), len(data)) > 0:
            # Not a word is read of it, nor an answer sent to each of its pings.
            log.warning("let a watcher go that sent far too much")
            self.transport.abort()
            return
        super().data_received(data)

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        self._crowd.leave(self)


class _Crowd:
    """Connections that are not open yet, in the order in which they came."""

    def __init__(self) -> None:
        self._waiting: dict[_Connection, None] = {}

    def enter(self, connection: _Connection) -> None:
        """Take in a connection; if too many have not got their answer, the oldest has to go."""
        self._waiting[connection] = None
        if len(self._waiting) > _MOST_UNFINISHED:
            for one in [one for one in self._waiting if one.protocol.state is State.OPEN]:
                self.leave(one)
            for one in list(self._waiting)[:-_MOST_UNFINISHED]:
                self.leave(one)
                one.transport.abort()

    def leave(self, connection: _Connection) -> None:
        self._waiting.pop(connection, None)


class Watchers:
    """All who look, and the port at which they do. Methods may be called from any thread."""

    def __init__(
        self,
        host: str,
        port: int,
        wish: Any,
        changed: Callable[[], object],
        *,
        names: Sequence[Authority] = (),
        code: str | None = None,
        most: int = MOST_WATCHERS,
        most_guesses: int = MOST_GUESSES,
        seats: Seats | None = None,
        acts: Any = None,
        act: Callable[[Watcher, Any], object] = lambda watcher, act: None,
    ) -> None:
        """Listen at once.

        Args:
            host: address to listen on.
            port: port to listen on; 0 is any free one.
            wish: the type of what is read, a ``msgspec.Struct`` or a union of such with tags, each
                of which forbids unknown fields.
            changed: called on the event loop when somebody has come, gone or wished; it must
                return at once.
            names: under which the port is reached besides.
            code: without which nobody is let in; None if whoever comes is.
            most: so many may look.
            most_guesses: wrong codes that one address may try in a minute.
            seats: of those who look; None if nobody is to be told from others.
            acts: the type of what is read besides, of which each counts and not the newest alone.
            act: called on the event loop with each of them; it must return at once.

        Raises:
            OSError: the host is not an address of this machine, or the port is not free.
        """
        self.access = None if code is None else Access(code, most_guesses, _CODE)
        self._host = "127.0.0.1" if host == "localhost" else host
        self._names = Names(self._host, names)
        self._decoder = msgspec.json.Decoder(wish if acts is None else wish | acts)
        self._acts, self._act = acts, act
        self._seats = seats
        self._changed = changed
        self._most = room_for(most).pages
        self._watchers: dict[Watcher, None] = {}
        self._requests = Turnstile(_REQUESTS_PER_S, _REQUESTS_AT_ONCE)
        # Not in its thread: who starts the lab is to be told why it cannot be.
        family, *_ = socket.getaddrinfo(self._host, port, type=socket.SOCK_STREAM)[0]
        self._socket = socket.create_server((self._host, port), family=family)
        self.port: int = self._socket.getsockname()[1]
        self._loop = asyncio.new_event_loop()
        self._loop.set_exception_handler(tell_of_error)
        self._ends = asyncio.Event()
        self._thread = threading.Thread(target=self._run, name="watchers", daemon=True)
        self._thread.start()

    @property
    def addresses(self) -> tuple[str, ...]:
        """Addresses under which it has just answered, without a token; this machine's first."""
        return answering_addresses(self._host, self.port)

    @property
    def all(self) -> tuple[Watcher, ...]:
        """Those who look now."""
        return tuple(self._watchers)

    def send(self, letters: Iterable[tuple[bytes, Sequence[Watcher]]]) -> None:
        """Send each of these what all who stand beside it are to get."""
        # It fails where the server has ended, and with it all connections.
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._send, tuple(letters))

    def close(self) -> None:
        """End all connections and the port."""
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._ends.set)
        self._thread.join(timeout=2 * _CLOSE_S)

    # --- In the thread ----------------------------------------------------------------------------

    async def _listen(self) -> Server:
        crowd = _Crowd()
        return await serve(
            self._handle,
            sock=self._socket,
            process_request=self._answer,
            process_response=_harden,
            create_connection=cast("type[_Connection]", partial(_Connection, crowd=crowd)),
            open_timeout=HANDSHAKE_S,
            close_timeout=_CLOSE_S,
            compression=None,
            max_size=MAX_MESSAGE_BYTES,
            max_queue=4,
            server_header=None,
            logger=_wire_log,
        )

    async def _serve(self) -> None:
        """Be there until the end, which may have come before it has begun."""
        server = await self._listen()
        await self._ends.wait()
        server.close(code=CloseCode.GOING_AWAY, reason="the lab has ended")
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(server.wait_closed(), _CLOSE_S)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._serve())
        finally:
            for task in asyncio.all_tasks(self._loop):
                task.cancel()
            self._loop.run_until_complete(asyncio.sleep(0))
            self._loop.close()

    def _send(self, letters: Sequence[tuple[bytes, Sequence[Watcher]]]) -> None:
        for letter, watchers in letters:
            there = [watcher for watcher in watchers if watcher in self._watchers]
            broadcast([watcher.connection for watcher in there], letter, text=False)
            for watcher in there:
                watcher.note_sent()

    async def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        wait_s = self._requests.wait_s(self._loop.time())
        if wait_s > 0:
            await asyncio.sleep(wait_s)
        is_socket = web_files.path_of(request) == _SOCKET
        refusal = stranger(
            self._names, request, request.headers.get_all("Origin") if is_socket else (), is_socket
        )
        if refusal is not None:
            return refuse(connection, request, refusal)
        form = ""
        if self.access is not None:
            address = str(connection.remote_address[0])
            if self.access.brings_token(request, address):
                if web_files.is_page(request):
                    return self.access.welcome(request, self.port)
            elif not self.access.knows(request, self.port):
                refusal, form = self.access.refusal(request, address), self.access.form(request)
        if web_files.path_of(request) == _ASKS_WHY:
            full = _FULL if len(self._watchers) >= self._most else None
            words = "" if (why := refusal or full) is None else why.words
            return connection.respond(HTTPStatus.OK, words)
        if refusal is not None:
            return refuse(connection, request, refusal, form)
        if is_socket:
            return None
        found = web_files.audience_file(request)
        if found is not None and web_files.is_page(request):
            self._give_ticket(request, found)
        return found or refuse(connection, request, _NOT_FOUND)

    # Seats

    def _give_ticket(self, request: Request, page: Response) -> None:
        """Hand out a ticket with the page, unless the browser has a good one."""
        if self._seats is not None and self._ticket(request) is None:
            ticket = self._seats.new_ticket()
            page.headers["Set-Cookie"] = f"{self._ticket_name}={ticket}; HttpOnly; SameSite=Lax"

    def _ticket(self, request: Request | None) -> str | None:
        if self._seats is None or request is None:
            return None
        given = cookies_of(request, self._ticket_name)
        return next((text for text in given if self._seats.is_ticket(text)), None)

    @property
    def _ticket_name(self) -> str:
        return f"{cookie_name(self.port)}-seat"

    @contextlib.contextmanager
    def _seated(self, connection: ServerConnection) -> Iterator[Any]:
        """The seat of a page as long as it is open; None if it has none."""
        ticket = self._ticket(connection.request)
        seat = None if self._seats is None or ticket is None else self._seats.sit(ticket)
        try:
            yield seat
        finally:
            if self._seats is not None and seat is not None:
                self._seats.leave(seat)

    # Pages

    async def _handle(self, connection: ServerConnection) -> None:
        assert isinstance(connection, _Connection)
        if len(self._watchers) >= self._most:
            await connection.close(FULL, "too many look already")
            return
        with self._seated(connection) as seat:
            watcher = Watcher(connection, seat)
            self._watchers[watcher] = None
            self._changed()
            try:
                await self._read(watcher, connection)
            except ConnectionClosed:
                # Pages go away; nobody has to be told.
                pass
            finally:
                self._watchers.pop(watcher, None)
                self._changed()

    async def _read(self, watcher: Watcher, connection: ServerConnection) -> None:
        wishes = Turnstile(WISHES_PER_S, WISHES_AT_ONCE)
        while True:
            message = await connection.recv()
            wait_s = wishes.wait_s(self._loop.time())
            if wait_s > 0:
                await asyncio.sleep(wait_s)
            try:
                told = self._decoder.decode(message)
            except (msgspec.MsgspecError, RecursionError, UnicodeError):
                if watcher.n_dropped == 0:
                    # Not what is wrong with it: that can have words of its sender in it.
                    log.info("dropped a message of a watcher")
                watcher.n_dropped += 1
                continue
            if self._acts is not None and isinstance(told, self._acts):
                self._act(watcher, told)
            else:
                watcher.wish = told
                self._changed()


def _harden(_: ServerConnection, request: Request, response: Response) -> None:
    for name, value in _HEADERS.items():
        response.headers.setdefault(name, value)
    is_refusal = response.status_code >= HTTPStatus.BAD_REQUEST
    policy = _REFUSAL_POLICY if is_refusal else _POLICY
    response.headers.setdefault("Content-Security-Policy", policy)
    response.headers.setdefault("Cache-Control", "no-store")


_wire_log = logging.getLogger(f"{__name__}.wire")
# Whoever comes with what is no request is let go without a word; what it says below are whole
# requests, with cookies and tokens.
_wire_log.setLevel(logging.CRITICAL)
