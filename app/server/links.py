"""Links that hold a session: they lead to the lab's page, which then asks for what is in them.

A request alone changes nothing, as programs make many that nobody has meant: of each link the lab
keeps what is in it under a ticket, and leads to its page with that. Nothing is unpacked here.
"""

import secrets
import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from http import HTTPStatus
from typing import Final
from urllib.parse import quote_plus

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from app.server.refusals import Refusal
from app.server.web_files import path_of, response

TICKET: Final = "shared"
"""The question of the page's address that has the ticket."""
NOT_WHOLE: Final = Refusal(
    HTTPStatus.NOT_FOUND,
    "This link to a session is not whole. Copy all of it, or ask for the file.",
)

_PATH: Final = "/s/"
_MOST: Final = 32
"""Links whose pages have not asked yet."""


def address_of_link(code: str) -> str:
    """What a link of the page refers to (`href`); it holds below a path as well."""
    return f"{_PATH[1:]}{code}"


def is_link(request: Request) -> bool:
    return request.path.startswith(_PATH)


def code_in(request: Request) -> str:
    """What a link holds, as it came from the network."""
    return path_of(request)[len(_PATH) :]


class Links:
    """What has come in links, until a page asks for it. From any thread."""

    def __init__(self, is_whole: Callable[[str], bool]) -> None:
        """``is_whole`` says at a glance whether a text can be what a link holds."""
        self.is_whole = is_whole
        self._codes: OrderedDict[str, str] = OrderedDict()
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return len(self._codes)

    def keep(self, code: str) -> str:
        """Keep what a link holds; returns its ticket, which is good for once."""
        ticket = secrets.token_urlsafe(12)
        with self._lock:
            self._codes[ticket] = code
            if len(self._codes) > _MOST:
                self._codes.popitem(last=False)
        return ticket

    def take(self, ticket: str) -> str | None:
        """Hand out what was kept under a ticket; None if there is nothing, or not any more."""
        with self._lock:
            return self._codes.pop(ticket, None)


def lead_to_page(ticket: str, questions: Sequence[tuple[str, str]]) -> Response:
    """Lead to the lab's page, with a ticket; what else is asked for stays so."""
    pairs = [*(pair for pair in questions if pair[0] != TICKET), (TICKET, ticket)]
    question = "&".join(f"{quote_plus(name)}={quote_plus(value)}" for name, value in pairs)
    headers = Headers({"Location": f"../?{question}", "Cache-Control": "no-store"})
    return response(b"", headers, HTTPStatus.SEE_OTHER)
