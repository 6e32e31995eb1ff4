"""How many connections there may be, and what is said when one ends for no reason of its page's."""

import asyncio
import errno
import logging
import os
import re
import sys
from http import HTTPStatus
from typing import Any, Final, NamedTuple

from websockets.exceptions import SecurityError
from websockets.frames import CloseCode
from websockets.protocol import State

from app.server.admission import CheckedConnection

HANDSHAKE_S: Final = 5.0
"""A connection that has not said in this time what it wants is ended."""

CONNECTIONS_OF_A_PAGE: Final = 2
"""Its own, and that of its frame."""

MIN_UNFINISHED: Final = 8
"""Connections that may be on their way in or out however many pages are open."""

_SPARE_DESCRIPTORS: Final = 24
"""Kept for what else the lab opens: results of experiments, files to save."""
_MAX_BACKLOG: Final = 100
_MAX_SOFT_LIMIT: Final = 4_096
_MAX_FAULT_CHARACTERS: Final = 200
_TOKEN: Final = re.compile(r"token=[^&\s]*")

log = logging.getLogger(__name__)


class Room(NamedTuple):
    """What the process's file descriptors leave room for."""

    pages: int
    backlog: int
    """Connections that may wait to be accepted; asyncio accepts so many before it handles any."""


def room_for(max_pages: int) -> Room:
    """Room for at most so many pages.

    Where the system allows it, the limit of the process is raised first, as servers do.
    """
    limit = _raised_limit()
    if limit is None:
        return Room(max_pages, _MAX_BACKLOG)
    free = limit - _open_descriptors() - _SPARE_DESCRIPTORS
    backlog = max(4, min(_MAX_BACKLOG, free // 4))
    for_pages = (free - backlog - MIN_UNFINISHED) // CONNECTIONS_OF_A_PAGE
    return Room(max(1, min(max_pages, for_pages)), backlog)


def _raised_limit() -> int | None:
    if sys.platform == "win32":
        return None
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    aim = _MAX_SOFT_LIMIT if hard == resource.RLIM_INFINITY else min(hard, _MAX_SOFT_LIMIT)
    if soft == resource.RLIM_INFINITY:
        return None
    if soft < aim:
        try:
            resource.setrlimit(resource.RLIMIT_NOFILE, (aim, hard))
        except (OSError, ValueError):
            # macOS refuses more than another limit of its own.
            return soft
        return aim
    return soft


def _open_descriptors() -> int:
    return len(os.listdir("/dev/fd"))


class Crowd:
    """All connections of a server, in the order in which they came."""

    def __init__(self, max_pages: int) -> None:
        self._max_open = max_pages * CONNECTIONS_OF_A_PAGE
        self._connections: dict[Connection, None] = {}

    def enter(self, connection: "Connection") -> None:
        """Take in a connection; if too many have not said what they want, the oldest has to go.

        A browser says it at once, so whoever keeps silent makes room for whoever does not.
        """
        self._connections[connection] = None
        unfinished = [one for one in self._connections if one.protocol.state is not State.OPEN]
        n_open = len(self._connections) - len(unfinished)
        surplus = len(unfinished) - max(MIN_UNFINISHED, self._max_open - n_open)
        for one in unfinished[: max(surplus, 0)]:
            log.warning("ended a connection that said nothing: too many came at once")
            self.leave(one)
            one.transport.abort()

    def leave(self, connection: "Connection") -> None:
        self._connections.pop(connection, None)


class Connection(CheckedConnection):
    """A connection that is counted from its first moment on."""

    def __init__(self, *args: Any, crowd: Crowd, **options: Any) -> None:
        super().__init__(*args, **options)
        self._crowd = crowd
        self._is_refused = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self._crowd.enter(self)

    def send_data(self) -> None:
        fault = (
            None if self.protocol.handshake_exc is None else self.protocol.handshake_exc.__cause__
        )
        # Nothing is to be said once it is the other side that has hung up.
        if self.request is None and fault is not None and not isinstance(fault, EOFError):
            self._refuse_once(fault)
        super().send_data()

    def _refuse_once(self, fault: BaseException) -> None:
        """Say what is wrong with bytes that are no request.

        websockets hangs up on them without a word, which a proxy shows as a fault of its own.
        """
        if self._is_refused:
            return
        self._is_refused = True
        words = _TOKEN.sub("token=...", ascii(str(fault))[1:-1][:_MAX_FAULT_CHARACTERS])
        log.warning("refused what is no GET request of HTTP/1.1: %s", words)
        status = (
            HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE
            if isinstance(fault, SecurityError)
            else HTTPStatus.BAD_REQUEST
        )
        text = f"Only GET requests of HTTP/1.1 are answered here: {words}\n"
        self.transport.write(self.respond(status, text).serialize())

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        self._crowd.leave(self)
        sent = self.protocol.close_sent
        if sent is not None and sent.code == CloseCode.INTERNAL_ERROR:
            # By the server itself, for instance because no answer came to a ping.
            log.warning("the connection of a page was ended: %s", sent.reason or "internal error")


def tell_of_error(_: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Say what went wrong in the server's event loop in a line, and not as a traceback."""
    error = context.get("exception")
    if isinstance(error, OSError) and error.errno in (errno.EMFILE, errno.ENFILE):
        log.warning("no page can be let in: this process has no file descriptor left")
        return
    cause = context["message"] if error is None else f"{type(error).__name__}: {error}"
    log.error("the page's server: %s", cause)
    log.debug("the failure above: %s", context["message"], exc_info=error)
