"""What waits to be sent to one page, and when that is too much."""

from collections.abc import Iterable
from typing import Any, Final

from viser.infra import Message
from viser.infra._async_message_buffer import AsyncMessageBuffer

WATCH_S = 1.0
"""How often a connection is looked at."""

STALL_S = 30.0
"""How long a page may take nothing of what is sent to it: a laptop that sleeps, a stopped tab."""

MAX_QUEUED_MESSAGES: Final = 2_000
"""A page is drawn with some hundreds, which is the most that comes at once."""

MAX_QUEUED_BYTES: Final = 32 * 2**20


class Outbox:
    """Watches what waits for one page. Times are in seconds."""

    def __init__(self, buffer: AsyncMessageBuffer) -> None:
        self._buffer = buffer
        self._unsent = 0
        self._since: float | None = None

    def fault(self, unsent_bytes: int, now_s: float) -> str | None:
        """Why the page is to be let go; None while it keeps up.

        ``unsent_bytes`` have left the buffer and wait for the network. viser puts no more there
        before the page has taken those, so as long as it takes nothing their number stays.
        """
        if unsent_bytes == 0:
            self._since = None
            return None
        if self._since is None or unsent_bytes != self._unsent:
            self._unsent, self._since = unsent_bytes, now_s
        if now_s - self._since >= STALL_S:
            return f"it has taken nothing for {STALL_S:g} s"
        queued = list(self._buffer.message_from_id.copy().values())
        if len(queued) > MAX_QUEUED_MESSAGES:
            return f"{len(queued):,} messages wait for it"
        size = unsent_bytes + sum(map(_size_of, queued))
        return f"{size // 2**20} MiB wait for it" if size > MAX_QUEUED_BYTES else None


def _size_of(message: Message) -> int:
    """Bytes of what a message carries; all that is small counts as nothing."""
    return _bytes_in(vars(message).values())


def _bytes_in(values: Iterable[Any]) -> int:
    total = 0
    for value in values:
        if isinstance(value, bytes | str):
            total += len(value)
        elif isinstance(value, dict):
            total += _bytes_in(value.values())
        else:
            total += getattr(value, "nbytes", 0)
    return total
