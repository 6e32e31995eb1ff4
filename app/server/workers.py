"""The threads that run callbacks, and how many of them one page may keep busy."""

import threading
from collections import Counter
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, Final

import viser

N_THREADS: Final = 32
MOST_OF_ONE_PAGE: Final = 4
"""Callbacks of one page that may be under way; for further ones the page has to wait.

So a page that asks faster than it can be answered fills no queue, and takes no other page's turn.
"""


class Workers(ThreadPoolExecutor):
    """viser's pool of threads, with a count of what each page keeps it busy with."""

    def __init__(self) -> None:
        super().__init__(N_THREADS, "callback")
        self._under_way: Counter[int] = Counter()
        self._counting = threading.Lock()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """As an executor does; viser hands each callback its event as the only argument."""
        future = super().submit(fn, *args, **kwargs)
        self.count(future, *args)
        return future

    def count(self, future: Future[Any], *args: Any) -> None:
        """Count a call with these arguments as under way until its future is done."""
        client_id = _client_of(args[0]) if args else None
        if client_id is not None:
            with self._counting:
                self._under_way[client_id] += 1
            future.add_done_callback(lambda _: self._count_down(client_id))

    def is_free_for(self, client_id: int) -> bool:
        """Whether a page may have another callback run."""
        return self._under_way[client_id] < MOST_OF_ONE_PAGE

    def _count_down(self, client_id: int) -> None:
        with self._counting:
            self._under_way[client_id] -= 1
            if self._under_way[client_id] == 0:
                del self._under_way[client_id]


def _client_of(event: Any) -> int | None:
    if isinstance(event, viser.ClientHandle):
        return event.client_id
    client = getattr(event, "client", None)
    return None if client is None else client.client_id
