"""A websocket of one's own for a part of the page that is a page itself, shown in a frame.

viser's page can show a frame, and scripts run in it. Such a page is served below an address with a
secret of the browser that it belongs to; next to it is its websocket, on the same port and behind
the same door. What goes out is JSON, of each kind of message the newest, as fast as the page takes
it in. What comes in is JSON as well, and is checked against the types that its receiver states;
whatever is none of them is dropped.
"""

import asyncio
import contextlib
import logging
import secrets
import threading
from collections import deque
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from typing import Any, Final, get_args

import msgspec
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.extensions.permessage_deflate import ServerPerMessageDeflateFactory
from websockets.frames import CloseCode
from websockets.http11 import Request, Response

from app.server import web_files
from app.server.callbacks import told_to
from app.server.pace import RECEIVED_S, Pace
from app.server.web_files import Frame
from app.util.html import element

MAX_MESSAGE_BYTES: Final = 4 * 1024
"""Largest message of a page; a longer one ends its connection before it is read."""

MESSAGES_PER_S: Final = 120
"""So many messages are taken in the long run: twice what a hand sends that drags something."""
MOST_AT_ONCE: Final = 120
"""So many may come at once, after a rest."""

MOST_UNANSWERED: Final = 2
"""Frames that may be on their way to a page: of a slow one the network's buffers hold no more."""

REPLACED: Final = 4001
"""The code with which a connection ends whose page was opened once more."""

_SOCKET: Final = "socket"
_PATHS: Final = tuple(f"/{page}/" for page in web_files.FRAMES)
_PAGE_HEADERS: Final = {
    "Content-Type": "text/html; charset=utf-8",
    "Cache-Control": "no-store",
    # The secret in its address is for nobody else, and nothing is loaded from elsewhere.
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:;"
        " connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
    ),
    "X-Frame-Options": "SAMEORIGIN",
}

log = logging.getLogger(__name__)


def is_of_channel(request: Request) -> bool:
    return request.path.startswith(_PATHS)


def is_socket(request: Request) -> bool:
    """Whether it is a channel's websocket that is asked for."""
    return is_of_channel(request) and web_files.path_of(request).endswith(f"/{_SOCKET}")


def prepare(connection: ServerConnection) -> None:
    """Set the bounds of a channel for a connection that is about to be let in."""
    protocol = connection.protocol
    protocol.max_message_size = MAX_MESSAGE_BYTES
    # Quick and small: what repeats from one message to the next is most of them.
    protocol.available_extensions = [
        ServerPerMessageDeflateFactory(
            server_max_window_bits=12,
            client_max_window_bits=12,
            compress_settings={"level": 1, "memLevel": 5},
        )
    ]


class Channel:
    """What goes to and fro between the lab and one browser's frame. Made by :class:`Channels`."""

    def __init__(
        self,
        page: Frame,
        secret: str,
        decoder: msgspec.json.Decoder[Any],
        take: Callable[[Any], object],
        opened: Callable[[], object],
        leave: Callable[[], None],
    ) -> None:
        self.page: Frame = page
        """Which page it is the channel of."""
        self.address = f"{page}/{secret}/"
        """Of the frame's page, relative to the lab's: it holds below a path as well."""
        self.n_dropped = 0
        """Messages of the page that were too many, or made no sense."""
        self._decoder, self._take, self._opened = decoder, take, opened
        self._leave = leave
        self._lock = threading.Lock()
        self._waiting: dict[str, bytes] = {}
        """Of each kind the newest message, in the order in which they came."""
        self._delivery: _Delivery | None = None
        self._has_left = False

    @property
    def is_open(self) -> bool:
        """Whether the frame is connected."""
        return self._delivery is not None

    def frame_html(self, title: str) -> str:
        """The frame as HTML for a slot of the stage, with room for what is said if it fails.

        ``web/frame.js`` gives it its height, and forwards keys both ways.
        """
        frame = element("iframe", "", class_=f"pounce-{self.page}", src=self.address, title=title)
        return frame + element("p", "", class_=f"pounce-no-{self.page}", role="status")

    def send(self, kind: str, content: dict[str, Any]) -> None:
        """Send ``{"kind": kind, ...content}`` in place of what waits of that kind; any thread.

        Without a connection it waits for one. Parts that go to many browsers may be
        ``msgspec.Raw`` of JSON.
        """
        message = msgspec.json.encode({"kind": kind, **content})
        with self._lock:
            self._waiting.pop(kind, None)
            self._waiting[kind] = message
            delivery = self._delivery
        if delivery is not None:
            delivery.wake()

    def waits(self, kind: str) -> bool:
        """Whether the newest of a kind has not gone out yet: one more would be for nothing."""
        with self._lock:
            return kind in self._waiting

    def leave(self) -> None:
        """End the connection and the address; may be called from any thread, and again."""
        self._leave()
        with self._lock:
            self._has_left = True
            delivery = self._delivery
        if delivery is not None:
            delivery.end(CloseCode.GOING_AWAY, "the browser has gone")

    async def serve(self, connection: ServerConnection) -> None:
        """Send and take messages for as long as the connection lasts."""
        delivery = _Delivery(connection, self._next_messages)
        with self._lock:
            if self._has_left:
                return
            former, self._delivery = self._delivery, delivery
        if former is not None:
            former.end(REPLACED, "opened elsewhere")
        sending = asyncio.create_task(delivery.run())
        try:
            with told_to(None, self._opened):
                self._opened()
            await self._receive(connection)
        except ConnectionClosed:
            # Pages go away; nobody has to be told.
            pass
        finally:
            with self._lock:
                if self._delivery is delivery:
                    self._delivery = None
            sending.cancel()
            await asyncio.gather(sending, return_exceptions=True)

    def _next_messages(self) -> list[bytes]:
        with self._lock:
            messages = list(self._waiting.values())
            self._waiting.clear()
        return messages

    async def _receive(self, connection: ServerConnection) -> None:
        allowance, pace = _Allowance(), Pace()
        loop = asyncio.get_running_loop()
        while True:
            # Not as the connection of a page of viser's does, which would look for its messages.
            message = await ServerConnection.recv(connection)
            # Whoever sends far too much has to wait with the rest of it.
            wait_s = pace.charge(RECEIVED_S, loop.time())
            if wait_s > 0:
                await asyncio.sleep(wait_s)
            if not isinstance(message, str) or not allowance.has_one(loop.time()):
                self._drop("too many, or no text")
                continue
            try:
                content = self._decoder.decode(message)
            except (msgspec.MsgspecError, RecursionError, UnicodeError) as error:
                self._drop(str(error))
                continue
            with told_to(None, self._take):
                self._take(content)

    def _drop(self, reason: str) -> None:
        if self.n_dropped == 0:
            log.info("dropped a message of a frame: %s", ascii(reason[:100]))
        self.n_dropped += 1


class _Delivery:
    """Brings what waits to one connection, each thing once there is nothing newer of its kind.

    The next goes out only when the last but one has been taken in, which the answer to a ping
    behind it tells. So nothing old piles up on the way to a slow page.
    """

    def __init__(
        self, connection: ServerConnection, next_messages: Callable[[], list[bytes]]
    ) -> None:
        self._connection = connection
        self._next_messages = next_messages
        self._loop = asyncio.get_running_loop()
        self._awake = asyncio.Event()
        self._awake.set()
        self._is_called = False
        """Whether it has been woken, and has not looked since."""
        self._farewell: asyncio.Task[None] | None = None

    def wake(self) -> None:
        """Look at once at what waits; may be called from any thread."""
        # Of a frame's many parts one wakes it: a call from another thread is dear.
        if not self._is_called:
            self._is_called = True
            self._call(self._awake.set)

    def end(self, code: int, reason: str) -> None:
        """End the connection; may be called from any thread."""
        self._call(lambda: self._say_farewell(code, reason))

    async def run(self) -> None:
        answers: deque[Awaitable[float]] = deque()
        try:
            while True:
                await self._awake.wait()
                if len(answers) >= MOST_UNANSWERED:
                    await answers.popleft()
                self._awake.clear()
                # Before it looks, so that whatever comes from here on wakes it again.
                self._is_called = False
                messages = self._next_messages()
                for message in messages:
                    await self._connection.send(message, text=True)
                if messages:
                    answers.append(await self._connection.ping())
        except ConnectionClosed:
            # What was meant for a page that has gone is rightly lost.
            pass

    def _call(self, act: Callable[[], object]) -> None:
        # It fails where the server has ended, and with it all connections.
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(act)

    def _say_farewell(self, code: int, reason: str) -> None:
        if self._farewell is None:
            self._farewell = asyncio.create_task(self._connection.close(code, reason))


class _Allowance:
    """How many messages a page may send by now. Times are in seconds."""

    def __init__(self) -> None:
        self._left, self._counted_s = float(MOST_AT_ONCE), 0.0

    def has_one(self, now_s: float) -> bool:
        """Take one if there is one."""
        grown = self._left + (now_s - self._counted_s) * MESSAGES_PER_S
        self._left, self._counted_s = min(grown, MOST_AT_ONCE), now_s
        if self._left < 1:
            return False
        self._left -= 1
        return True


class Channels:
    """All channels of a server, each below an address of its own. Used by any thread."""

    def __init__(self) -> None:
        self._channels: dict[str, Channel] = {}
        self._lock = threading.Lock()

    def enter(
        self,
        kind: Any,
        take: Callable[[Any], object],
        opened: Callable[[], object],
        page: Frame = "time",
    ) -> Channel:
        """A channel for another browser, of one of the pages that may be shown in a frame.

        `take(message)` is called for each message of its frame, which is one of `kind`: a
        `msgspec.Struct` or a union of such with tags, each of which forbids unknown fields.
        `opened()` is called whenever the frame has connected, and knows nothing yet. Both run on
        the server's event loop and must return at once.

        Raises:
            TypeError: a type of `kind` would take fields that it does not know.
        """
        for struct in get_args(kind) or (kind,):
            if not struct.__struct_config__.forbid_unknown_fields:
                raise TypeError(f"{struct.__name__} does not forbid unknown fields")
        secret = secrets.token_urlsafe(16)
        channel = Channel(
            page, secret, msgspec.json.Decoder(kind), take, opened, lambda: self._forget(secret)
        )
        with self._lock:
            self._channels[secret] = channel
        return channel

    def find(self, request: Request) -> Channel | None:
        """Whose page or websocket is asked for; None if it is nobody's."""
        page, _, below = web_files.path_of(request).removeprefix("/").partition("/")
        secret, slash, rest = below.partition("/")
        # Without the slash what the page loads would be looked for in another folder.
        if not slash or rest not in ("", _SOCKET):
            return None
        with self._lock:
            channel = self._channels.get(secret)
        return channel if channel is not None and channel.page == page else None

    async def serve(self, connection: ServerConnection) -> None:
        """Handle a connection that the door has let in as a channel's."""
        request = connection.request
        channel = None if request is None else self.find(request)
        if channel is not None:
            await channel.serve(connection)
        # The browser may have gone in the meantime.
        await connection.close(CloseCode.NORMAL_CLOSURE)

    def _forget(self, secret: str) -> None:
        with self._lock:
            self._channels.pop(secret, None)


def frame_page(page: Frame) -> Response:
    """The page in a frame: the same for all, since its address says whose it is."""
    document = web_files.frame_document(page)
    return web_files.response(document, Headers(_PAGE_HEADERS), HTTPStatus.OK)
