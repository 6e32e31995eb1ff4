"""Links of the page that call the lab.

A link to `address_of(...)` in an HTML widget is a call, answered with "204 No Content", at which a
browser stays on its page. Such links are best aimed at a hidden frame (`target`), so that a call
that nobody takes, which is answered with a text, does not take the page's place either.
"""

import secrets
import threading
import urllib.parse
from collections.abc import Callable
from typing import Final

from websockets.http11 import Request

MAX_CALL_CHARACTERS: Final = 512
"""Longest words that a link may call, with the secret before them, in plain characters."""

_CALL_PATH: Final = "/call/"


def is_call(request: Request) -> bool:
    return request.path.startswith(_CALL_PATH)


def called_words(request: Request) -> str | None:
    """What a call says; None if that is too long, or no text."""
    quoted = request.path.removeprefix(_CALL_PATH).partition("?")[0]
    try:
        words = urllib.parse.unquote_to_bytes(quoted.encode("ascii")).decode()
    except UnicodeError:
        return None
    return words if len(words) <= MAX_CALL_CHARACTERS else None


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
