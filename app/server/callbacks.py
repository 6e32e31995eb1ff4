"""What a callback of the page raises is told to the page that caused it."""

import contextlib
import functools
import inspect
import logging
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

import viser

from app.server.notices import tell

Event = TypeVar("Event")

log = logging.getLogger(__name__)


class RefusedError(ValueError):
    """What somebody asked for makes no sense; the message says why, and what would."""


def guarded(callback: Callable[[Event], Any]) -> Callable[[Event], Any]:
    """Make a viser callback, plain or async, tell the acting page when it fails.

    What it raises becomes a notification there and one line in the log (the traceback is logged at
    DEBUG). A failure that no page caused is only logged. Never raises an `Exception`.
    """
    if inspect.iscoroutinefunction(callback):

        @functools.wraps(callback)
        async def guarded_async(event: Event) -> None:
            with told_to(event, callback):
                await callback(event)

        return guarded_async

    @functools.wraps(callback)
    def guarded_plain(event: Event) -> None:
        with told_to(event, callback):
            callback(event)

    return guarded_plain


@contextlib.contextmanager
def told_to(event: Any, callback: Callable[..., Any]) -> Iterator[None]:
    client = event if isinstance(event, viser.ClientHandle) else getattr(event, "client", None)
    try:
        yield
    except RefusedError as error:
        # What was asked for makes no sense; that is between the page and its user.
        if client is not None:
            tell(client, "That cannot be done now", str(error)[:400])
    except Exception as error:
        # The last place that can tell the user: beyond it lie viser's threads, which print to a
        # terminal that nobody watches. So it takes every error, whatever the callback may raise.
        text = f"{type(error).__name__}: {error}".splitlines()[0][:200]
        log.error("%s failed: %s", getattr(callback, "__qualname__", callback), text)
        log.debug("the failure above", exc_info=True)
        if client is not None:
            tell(client, "That did not work", text, color="red", auto_close_seconds=10.0)
