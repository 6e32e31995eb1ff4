"""How a request is refused: in words for programs, on a page for people."""

from http import HTTPStatus
from typing import NamedTuple

from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from app.server.web_files import response
from app.util.html import escaped

_STYLE = (
    ":root { color-scheme: light dark } body { font: 1rem/1.5 system-ui, sans-serif;"
    " max-width: 40rem; margin: 3rem auto; padding: 0 1rem; overflow-wrap: anywhere }"
)


class Refusal(NamedTuple):
    """Why a request is not answered."""

    status: HTTPStatus
    words: str


def refuse(
    connection: ServerConnection, request: Request, refusal: Refusal, form: str = ""
) -> Response:
    """The answer to a request that is refused; `form` is HTML that may help a person."""
    if "text/html" not in request.headers.get("Accept", ""):
        return connection.respond(refusal.status, refusal.words + "\n")
    # Who has only to type a code has done nothing wrong.
    title = "A code, please" if form else refusal.status.phrase
    document = (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8" />'
        '<meta name="viewport" content="width=device-width, initial-scale=1" />'
        f"<title>{title}</title><style>{_STYLE}</style></head>"
        f"<body><h1>{title}</h1><p>{escaped(refusal.words)}</p>{form}"
        "</body></html>\n"
    )
    headers = Headers({"Content-Type": "text/html; charset=utf-8", "Cache-Control": "no-store"})
    return response(document.encode(), headers, refusal.status)
