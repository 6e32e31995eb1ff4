"""Which requests the lab answers."""

import ipaddress
import logging
from collections.abc import Callable
from http import HTTPStatus
from typing import Any, Final

import viser
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from app.server import page
from app.server.callbacks import told_to
from app.server.calls import called_words, is_call
from app.server.origin import (
    authority_of,
    is_address,
    is_from_page_of,
    machine_names,
    own_names,
    same_place,
    source_of,
)

_SECURITY_HEADERS: Final = {
    # No other page may frame this one and have the user click in it unawares. Both spellings, since
    # old browsers know only the second.
    "Content-Security-Policy": "frame-ancestors 'none'",
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
}

OnRefused = Callable[[int, str], None]
OnCall = Callable[[str], bool]

log = logging.getLogger(__name__)


def harden(_: ServerConnection, request: Request, response: Response) -> None:
    for name, value in _SECURITY_HEADERS.items():
        response.headers[name] = value
    if is_call(request):
        # Each call has to arrive, however often it was made before.
        response.headers["Cache-Control"] = "no-store"


class Door:
    """What is asked of a request, and the settings for the connections that it lets in."""

    def __init__(
        self,
        host: str,
        title: str,
        on_refused: OnRefused | None,
        on_call: OnCall | None,
        max_clients: int,
        max_upload_bytes: int,
    ) -> None:
        self.on_refused = on_refused
        self.max_upload_bytes = max_upload_bytes
        self.in_place = False
        self._title = title
        self.server: viser.ViserServer | None = None
        self._on_call: OnCall = on_call or (lambda words: False)
        self._max_clients = max_clients
        self._to_network = is_address(host) and ipaddress.ip_address(host).is_unspecified
        self._names = own_names(host) | (machine_names() if self._to_network else frozenset())

    def answer(self, viser_answer: Any, connection: ServerConnection, request: Request) -> Any:
        """Refuse the request, take a call, or let viser answer (None: go on with the handshake)."""
        if self.server is None:
            # A page left open reconnects as soon as the port answers, before viser is complete.
            return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, "The lab is starting.\n")
        fault = self._fault(request)
        if fault is not None:
            log.info("refused a request: %s", fault)
            return connection.respond(HTTPStatus.FORBIDDEN, f"{fault}\n")
        if is_call(request):
            return self._answer_call(connection, request)
        file = page.own_file(request)
        if file is not None:
            return file
        answer = viser_answer(connection, request)
        if answer is not None and page.is_page(request):
            return page.dress(answer, self._title)
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
        host = authority_of(hosts[0]) if len(hosts) == 1 else None
        if host is None or not self._is_own(host.name):
            return "This is not a name of this server."
        origins = request.headers.get_all("Origin")
        for origin in origins:
            source = source_of(origin)
            if source is None or not same_place(source, host):
                return "This page belongs to another site."
        # A call has effects, so more is asked of it than of what only reads.
        if is_call(request) and not is_from_page_of(host, request):
            return "This call does not come from a page of this server."
        return None

    def _answer_call(self, connection: ServerConnection, request: Request) -> Response:
        status = HTTPStatus.INTERNAL_SERVER_ERROR
        # What the callback raises is logged, not raised again, and leaves this status as it is.
        with told_to(None, self._on_call):
            words = called_words(request)
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
        return name in self._names or (self._to_network and is_address(name))
