"""Which requests the lab answers."""

import logging
import os
from collections.abc import Callable, Sequence
from http import HTTPStatus
from typing import Any, Final
from urllib.parse import parse_qs

import viser
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from app.server import channels, links, web_files
from app.server.access import WITHOUT_TOKEN, Access, questions_of
from app.server.callbacks import told_to
from app.server.calls import called_words, is_call
from app.server.channels import Channels, is_of_channel, is_socket
from app.server.links import Links, is_link
from app.server.origin import (
    Authority,
    Names,
    authority_of,
    declared_name,
    is_from_own_page,
    names_of_workspace,
    source_of,
)
from app.server.refusals import Refusal, refuse

_SECURITY_HEADERS: Final = {
    # No other page may frame this one and have the user click in it unawares. Both spellings, since
    # old browsers know only the second.
    "Content-Security-Policy": "frame-ancestors 'none'",
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    # Calls of our own pages are known by it where browsers send nothing else.
    "Referrer-Policy": "same-origin",
}
_WHY_PATH: Final = "/why"
_MAX_QUOTED_CHARACTERS: Final = 100

OnRefused = Callable[[int, str], None]
OnCall = Callable[[str], bool]

log = logging.getLogger(__name__)


def harden(_: ServerConnection, request: Request, response: Response) -> None:
    for name, value in _SECURITY_HEADERS.items():
        # The page of a channel says itself that ours may frame it.
        response.headers.setdefault(name, value)
    if is_call(request):
        # Each call has to arrive, however often it was made before.
        response.headers["Cache-Control"] = "no-store"


class Door:
    """What is asked of a request, and the settings for the connections that it lets in."""

    def __init__(
        self,
        host: str,
        *,
        names: Sequence[Authority],
        title: str,
        access: Access | None,
        on_refused: OnRefused | None,
        on_call: OnCall | None,
        channels: Channels | None,
        links: Links | None,
        max_clients: int,
        max_upload_bytes: int,
    ) -> None:
        self.on_refused = on_refused
        self.max_upload_bytes = max_upload_bytes
        self._max_clients = max_clients
        self.in_place = False
        self.server: viser.ViserServer | None = None
        self._access = access
        self._title = title
        self._on_call: OnCall = on_call or (lambda words: False)
        self.channels = channels or Channels()
        self._links = links
        self._host = host
        self._declared = names

    def open_for(self, server: viser.ViserServer) -> None:
        """Begin to let in, since the server is complete and its port is known."""
        self._port = server.get_port()
        forwarded = names_of_workspace(os.environ, self._port)
        self._names = Names(self._host, (*self._declared, *forwarded))
        self.server = server

    def answer(self, viser_answer: Any, connection: ServerConnection, request: Request) -> Any:
        """Refuse the request, take a call, or let viser answer (None: go on with the handshake)."""
        if self.server is None:
            # A page left open reconnects as soon as the port answers, before viser is complete.
            return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, "The lab is starting.\n")
        asks_why = web_files.path_of(request) == _WHY_PATH
        # A page behind a proxy has to get what it needs to say that it is refused; some browsers
        # send an origin with scripts.
        is_harmless = asks_why or web_files.is_own_file(request)
        origins = () if is_harmless else request.headers.get_all("Origin")
        refusal = self._stranger(request, origins)
        if refusal is not None:
            return refuse(connection, request, refusal)
        if asks_why:
            return self._say_why(connection, request)
        if self._access is not None:
            address = str(connection.remote_address[0])
            if self._access.brings_token(request, address):
                if web_files.is_page(request):
                    return self._access.welcome(request, self._port)
            elif not self._access.knows(request, self._port):
                refusal = self._access.refusal(request, address)
                return refuse(connection, request, refusal, self._access.form(request))
        if is_link(request):
            return self._answer_link(connection, request)
        if is_call(request):
            return self._answer_call(connection, request)
        if is_of_channel(request):
            return self._answer_channel(connection, request)
        return self._show(viser_answer, connection, request)

    def _show(self, viser_answer: Any, connection: ServerConnection, request: Request) -> Any:
        if web_files.is_own_file(request):
            return web_files.own_file(request)
        try:
            answer = viser_answer(connection, request)
        except (OSError, ValueError):
            # No file can have such a name.
            return connection.respond(HTTPStatus.NOT_FOUND, "Not found.\n")
        if answer is not None:
            return web_files.dress(answer, self._title) if web_files.is_page(request) else answer
        refusal = self._crowded(connection)
        return None if refusal is None else refuse(connection, request, refusal)

    def _answer_link(self, connection: ServerConnection, request: Request) -> Response:
        code = links.code_in(request)
        if self._links is None or not self._links.is_whole(code):
            return refuse(connection, request, links.NOT_WHOLE)
        return links.lead_to_page(self._links.keep(code), questions_of(request))

    def _answer_channel(self, connection: ServerConnection, request: Request) -> Response | None:
        channel = self.channels.find(request)
        if channel is None:
            return connection.respond(HTTPStatus.NOT_FOUND, "Not found.\n")
        if not is_socket(request):
            return channels.frame_page(channel.page)
        # How many there are is bounded by that of their secrets.
        channels.prepare(connection)
        return None

    def _stranger(self, request: Request, origins: Sequence[str]) -> Refusal | None:
        """What is wrong with where the request is addressed to, or where it comes from."""
        refusal = stranger(self._names, request, origins, is_socket(request))
        if refusal is not None:
            return refusal
        # A call has effects, so more is asked of it than of what only reads.
        host = authority_of(request.headers["Host"])
        if is_call(request) and not (host and is_from_own_page(self._names, host, request)):
            log.warning("refused a call that comes from no page of this lab")
            return Refusal(
                HTTPStatus.FORBIDDEN, "This call does not come from a page of this server."
            )
        return None

    def _crowded(self, connection: ServerConnection) -> Refusal | None:
        if n_pages(connection) < self._max_clients:
            return None
        log.warning("refused a page: %d are open, and no more can be", self._max_clients)
        return Refusal(HTTPStatus.SERVICE_UNAVAILABLE, "Too many open pages.")

    def _say_why(self, connection: ServerConnection, request: Request) -> Response:
        """Tell a page of ours that asks what keeps its websocket out."""
        # A browser sends no origin with what its page reads, and always one with a websocket.
        origins = parse_qs(request.path.partition("?")[2]).get("origin", [])
        knows_token = self._access is None or self._access.knows(request, self._port)
        refusal = (
            self._stranger(request, origins)
            or (None if knows_token else WITHOUT_TOKEN)
            or self._crowded(connection)
        )
        if refusal is None:
            return _nothing(connection)
        answer = connection.respond(HTTPStatus.OK, refusal.words + "\n")
        answer.headers["Cache-Control"] = "no-store"
        return answer

    def _answer_call(self, connection: ServerConnection, request: Request) -> Response:
        status = HTTPStatus.INTERNAL_SERVER_ERROR
        # What the callback raises is logged, not raised again, and leaves this status as it is.
        with told_to(None, self._on_call):
            words = called_words(request)
            taken = words is not None and self._on_call(words)
            status = HTTPStatus.NO_CONTENT if taken else HTTPStatus.NOT_FOUND
        if status != HTTPStatus.NO_CONTENT:
            return connection.respond(status, f"{status.phrase}.\n")
        return _nothing(connection)


def stranger(
    names: Names, request: Request, origins: Sequence[str], asks_for_socket: bool
) -> Refusal | None:
    """What is wrong with where a request is addressed to, or where it comes from.

    `Origin` must speak of this server on every request that has one and does more than read a
    file, so nothing hangs on telling a handshake from a page load; a browser writes both
    headers itself.
    """
    hosts = request.headers.get_all("Host")
    host = authority_of(hosts[0]) if len(hosts) == 1 else None
    if host is None or not names.have(host):
        remedy = _remedy(None if host is None else Authority(host.name, None))
        log.warning("refused a request to %s%s", _quoted(", ".join(hosts)), remedy)
        return Refusal(HTTPStatus.FORBIDDEN, f"This is not a name of this server{remedy}.")
    for origin in origins:
        source = source_of(origin)
        if not names.are_of(source, host):
            remedy = _remedy(None if source is None else source.place)
            log.warning("refused a page of %s%s", _quoted(origin), remedy)
            return Refusal(HTTPStatus.FORBIDDEN, f"This page belongs to another site{remedy}.")
    if asks_for_socket and not origins:
        log.warning("refused a websocket that comes from no page")
        return Refusal(HTTPStatus.FORBIDDEN, "This websocket is for a page of this server.")
    return None


def n_pages(connection: ServerConnection) -> int:
    """How many of viser's pages are open at the server of a connection."""
    requests = (one.request for one in connection.server.connections)
    return sum(request is not None and not is_of_channel(request) for request in requests)


def _remedy(place: Authority | None) -> str:
    """What the owner of the lab can do about a name that was refused; nothing if it is none."""
    try:
        name = None if place is None else declared_name(str(place))
    except ValueError:
        name = None
    if name is None:
        return ""
    return f": if the lab is to be reached under that name, start it with --name {name}"


def _quoted(text: str) -> str:
    """What a stranger wrote, as a log line can have it."""
    return ascii(text[:_MAX_QUOTED_CHARACTERS])


def _nothing(connection: ServerConnection) -> Response:
    response = connection.respond(HTTPStatus.NO_CONTENT, "")
    # HTTP allows no length of what is not there (RFC 9110, section 8.6).
    del response.headers["Content-Length"]
    del response.headers["Content-Type"]
    return response
