"""The token of a lab on the network: who has it may come in.

It comes in the address that the lab prints, once, and is kept by the browser as a cookie from then
on; so it is in no other address, in no `Referer` and in no log.
"""

import hashlib
import hmac
import logging
import re
import secrets
import time
from collections import OrderedDict
from http import HTTPStatus
from typing import Final, NamedTuple
from urllib.parse import parse_qsl, quote_plus

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from app.server.refusals import Refusal
from app.server.web_files import response
from app.util.html import escaped

MIN_TOKEN_CHARACTERS: Final = 12
_TOKEN: Final = re.compile(rf"[A-Za-z0-9._~-]{{{MIN_TOKEN_CHARACTERS},200}}")
"""What stands in an address and in a cookie as it is."""

_PLAIN_LETTERS: Final = "abcdefghjkmnpqrstuvwxyz23456789"
_PLAINER_LETTERS: Final = "acdefghjkmnpqrtwxy3479"
"""None of which is like another one on a projector: no b and 6, s and 5, u and v, z and 2."""
SHORT_CHARACTERS: Final = 6

WINDOW_S: Final = 60.0
MAX_GUESSES: Final = 10
"""Different wrong tokens that one address may try in `WINDOW_S`."""
_MAX_ADDRESSES: Final = 1_000

WITHOUT_TOKEN: Final = Refusal(
    HTTPStatus.UNAUTHORIZED,
    "This lab wants its token. Open the address that it printed when it was started, or enter the"
    " token from there.",
)
_WRONG_TOKEN: Final = Refusal(
    HTTPStatus.UNAUTHORIZED,
    "That is not the token of this lab. It is in the address that the lab printed when it was"
    " started, and changes when the lab is started again.",
)

log = logging.getLogger(__name__)


def new_token() -> str:
    return secrets.token_urlsafe(24)


def new_code() -> str:
    """A token that people can type who read it from a screen: 39 bits, none of them ambiguous."""
    letters = [secrets.choice(_PLAIN_LETTERS) for _ in range(8)]
    return "".join(letters[:4]) + "-" + "".join(letters[4:])


def new_short_code() -> str:
    """A code that a class types on phones: 26 bits, so only few guesses may be let through."""
    return "".join(secrets.choice(_PLAINER_LETTERS) for _ in range(SHORT_CHARACTERS))


def is_token(text: str) -> bool:
    """Whether a token that somebody chose is long enough, and of plain characters."""
    return _TOKEN.fullmatch(text) is not None


class Words(NamedTuple):
    """How a token is asked for."""

    name: str
    without: Refusal
    wrong: Refusal
    too_many: Refusal
    typed: bool = False
    """Whether it is read from a projector and typed: then it may be seen, capitals and gaps do not
    count, and the log does not say from where a wrong one came."""


_TOKEN_WORDS: Final = Words(
    "Token",
    WITHOUT_TOKEN,
    _WRONG_TOKEN,
    Refusal(
        HTTPStatus.TOO_MANY_REQUESTS,
        "Too many wrong tokens came from here; try again in a minute.",
    ),
)


class Access:
    """Asks each request for the token."""

    def __init__(
        self, token: str, max_guesses: int = MAX_GUESSES, words: Words = _TOKEN_WORDS
    ) -> None:
        """One address may try so many wrong tokens in `WINDOW_S`."""
        self._token, self._words = token, words
        self._cookie = new_token()
        """Not the token: that may be one that somebody chose, and guesses at cookies are free."""
        self._ticket: str | None = None
        self._guesses = _Guesses(max_guesses)

    def question(self) -> str:
        """What comes after the address of the page for whoever has the token."""
        return f"?token={self._token}"

    def question_for_once(self) -> str:
        """The same for a program: others may see with which words a program was started."""
        self._ticket = new_token()
        return f"?token={self._ticket}"

    def brings_token(self, request: Request, address: str) -> bool:
        """Whether the request has the token in its address."""
        given = dict(questions_of(request)).get("token")
        if given is None:
            return False
        if self._ticket is not None and _are_same(given, self._ticket):
            self._ticket = None
            return True
        if self._guesses.are_too_many(address):
            return False
        if _are_same(self._plain(given), self._plain(self._token)):
            return True
        self._guesses.note(address, given)
        return False

    def knows(self, request: Request, port: int) -> bool:
        """Whether the request has the cookie that was handed out for the token."""
        given = cookies_of(request, cookie_name(port))
        return any(_are_same(value, self._cookie) for value in given)

    def refusal(self, request: Request, address: str) -> Refusal:
        """What a request is told that has neither."""
        if "token" not in dict(questions_of(request)):
            return self._words.without
        if self._words.typed:
            log.warning("refused a wrong code")
        else:
            log.warning("refused a wrong token from %s", address)
        return self._words.too_many if self._guesses.are_too_many(address) else self._words.wrong

    def _plain(self, token: str) -> str:
        """A token as it is compared."""
        return re.sub(r"[\s-]", "", token).lower() if self._words.typed else token

    def welcome(self, request: Request, port: int) -> Response:
        """Hand out the cookie, and lead to the same page without the token in its address.

        The cookie has no `Path`: then it is for the folder of the page, wherever a proxy put that.
        A link from a letter or a chat is to find the lab open, hence `Lax` and not `Strict`; what
        has effects is asked for its origin besides.
        """
        rest = [pair for pair in questions_of(request) if pair[0] != "token"]
        question = "&".join(f"{quote_plus(name)}={quote_plus(value)}" for name, value in rest)
        cookie = f"{cookie_name(port)}={self._cookie}; HttpOnly; SameSite=Lax"
        headers = Headers({"Location": f"?{question}", "Cache-Control": "no-store"})
        headers["Set-Cookie"] = cookie
        return response(b"", headers, HTTPStatus.SEE_OTHER)

    def form(self, request: Request) -> str:
        """HTML that asks for the token; all else that is in the address stays in it."""
        kept = "".join(
            f'<input type="hidden" name="{escaped(name)}" value="{escaped(value)}" />'
            for name, value in questions_of(request)
            if name != "token"
        )
        kind = "text" if self._words.typed else "password"
        return (
            f'<form method="get"><p><label>{escaped(self._words.name)} <input type="{kind}"'
            ' name="token" required autocomplete="off" autocapitalize="none" spellcheck="false"'
            f" autofocus /></label> {kept}<button>Enter</button></p></form>"
        )


class _Guesses:
    """Which wrong tokens each address has tried of late."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._wrong: OrderedDict[str, tuple[float, set[bytes]]] = OrderedDict()

    def are_too_many(self, address: str) -> bool:
        since_s, wrong = self._wrong.get(address, (0.0, set()))
        return len(wrong) >= self._most and time.monotonic() - since_s < WINDOW_S

    def note(self, address: str, given: str) -> None:
        now_s = time.monotonic()
        since_s, wrong = self._wrong.get(address, (now_s, set()))
        if now_s - since_s >= WINDOW_S:
            self._wrong.pop(address, None)
            since_s, wrong = now_s, set()
        # A token that was tried before is no further guess.
        wrong.add(hashlib.sha256(given.encode("utf-8", "surrogateescape")).digest())
        self._wrong[address] = (since_s, wrong)
        # This address is the last, and not old: there is always a first.
        old_s = now_s - WINDOW_S
        while len(self._wrong) > _MAX_ADDRESSES or next(iter(self._wrong.values()))[0] < old_s:
            self._wrong.popitem(last=False)


def _are_same(one: str, other: str) -> bool:
    return hmac.compare_digest(one.encode("utf-8", "surrogateescape"), other.encode())


def cookie_name(port: int) -> str:
    """Of what lets in who has had the token."""
    # Cookies of a host are sent to all its ports, and several labs may be there.
    return f"pounce-{port}"


def cookies_of(request: Request, name: str) -> list[str]:
    """What a browser has kept under a name."""
    pairs = [
        part.strip().partition("=")
        for header in request.headers.get_all("Cookie")
        for part in header.split(";")
    ]
    return [value for key, _, value in pairs if key == name]


def questions_of(request: Request) -> list[tuple[str, str]]:
    """What comes after the path of an address, by name."""
    question = request.path.partition("?")[2]
    # Bytes that are no text at all can be sent as well.
    text = question.encode("utf-8", "surrogateescape").decode("utf-8", "replace")
    return parse_qsl(text, keep_blank_values=True)
