"""Seats of a class: a number and a shape for each browser, known by its cookie alone.

A browser is given a ticket, which its cookie holds; with the first page that it opens the ticket
has a seat, and whoever comes again with it has the same one. All of it is in memory, and forgotten
when the class ends: no ticket of before is good any more then.
"""

import hmac
import secrets
import threading
from typing import Final

SHAPES: Final = ("circle", "triangle", "square", "star", "diamond", "cross")
"""Neighbours have different ones, so that a class can be asked to talk with another shape."""
MOST_SEATS: Final = 300
_NONCE_CHARACTERS: Final = 16
_MOST_CHARACTERS: Final = 100
"""Of a ticket; what is longer is none, and is not looked at."""


class Seat:
    """Where somebody sits: pages of one browser have the same seat."""

    def __init__(self, number: int) -> None:
        self.number = number
        """From 1 on."""
        self.shape = SHAPES[(number - 1) % len(SHAPES)]
        self.is_taken = True
        """Until it is forgotten; from then on it is nobody's, and nothing of it counts."""
        self.n_pages = 0
        """Pages of it that are open."""

    def clear(self) -> None:
        """Be nobody's; pages that are open may still have it."""
        self.number, self.shape, self.is_taken = 0, "", False


class Seats:
    """Of one class. Methods may be called from any thread."""

    def __init__(self, most: int = MOST_SEATS) -> None:
        """``most``: so many seats there are."""
        self._most = most
        self._lock = threading.Lock()
        self._key = secrets.token_bytes(32)
        self._taken: dict[str, Seat] = {}
        """By what comes first in a ticket, in the order in which they were taken."""

    @property
    def all(self) -> tuple[Seat, ...]:
        """Seats that are somebody's, who may be away."""
        with self._lock:
            return tuple(self._taken.values())

    def new_ticket(self) -> str:
        """What the cookie of a new browser holds. Nothing of it is kept before it comes back."""
        nonce = secrets.token_hex(_NONCE_CHARACTERS // 2)
        return nonce + self._seal(nonce)

    def is_ticket(self, text: str) -> bool:
        """Whether it was given out, and since the last time that all was forgotten."""
        if len(text) > _MOST_CHARACTERS or not text.isascii():
            return False
        nonce, seal = text[:_NONCE_CHARACTERS], text[_NONCE_CHARACTERS:]
        return hmac.compare_digest(seal, self._seal(nonce))

    def sit(self, ticket: str) -> Seat | None:
        """The seat of who has opened one more page; None if there is none for them."""
        with self._lock:
            if not self.is_ticket(ticket):
                return None
            nonce = ticket[:_NONCE_CHARACTERS]
            seat = self._taken.get(nonce) or self._free()
            if seat is not None:
                self._taken[nonce] = seat
                seat.n_pages += 1
            return seat

    def leave(self, seat: Seat) -> None:
        """Note that a page of a seat was closed; the seat stays theirs."""
        with self._lock:
            seat.n_pages -= 1

    def forget(self) -> None:
        """Forget all seats, and who has had them."""
        with self._lock:
            self._key = secrets.token_bytes(32)
            for seat in self._taken.values():
                seat.clear()
            self._taken = {}

    def _seal(self, nonce: str) -> str:
        return hmac.digest(self._key, nonce.encode(), "sha256").hex()

    def _free(self) -> Seat | None:
        """A seat that is nobody's: if need be, that of who has been away and came first."""
        if len(self._taken) >= self._most:
            away = next((nonce for nonce, seat in self._taken.items() if not seat.n_pages), None)
            if away is None:
                return None
            self._taken.pop(away).clear()
        numbers = {seat.number for seat in self._taken.values()}
        return Seat(next(number for number in range(1, self._most + 1) if number not in numbers))
