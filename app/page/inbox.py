"""What people do at their pages waits here, in order, until the render loop comes to it.

viser calls back for each click, key and value by way of an executor, and this is that executor. So
whatever is registered with viser runs in the render loop, one after the other, and nothing that the
page is made of needs a lock. What may wait of one page is bounded as for any :class:`Workers`: the
messages of one that asks faster stay in the network.
"""

import contextlib
import logging
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import Any, TypeVar

import viser

from app.live.requests import Request
from app.live.session import Session
from app.live.status import Status
from app.server.callbacks import told_to
from app.server.workers import Workers

log = logging.getLogger(__name__)

Made = TypeVar("Made")

Act = Callable[[viser.ClientHandle, Any], object]
"""Does what somebody wants, given their browser and the value of what they used."""
Ask = Callable[[viser.ClientHandle, Request], object]
"""Asks the session for something; the browser is told if it cannot be done."""
StatusOf = Callable[[viser.ClientHandle], Status]
"""How things stand for a browser: at the moment that it looks at."""
Work = Callable[[viser.ClientHandle, Callable[[], Any], Callable[[Any], object]], object]
""":meth:`Inbox.work`."""


class EndingError(Exception):
    """The lab ends, so nobody waits for what was being made."""


def check_there(session: Session) -> None:
    """Asked now and then by what is made in another thread, for whose end the program waits.

    Raises:
        EndingError: the session's worker has ended.
    """
    if session.is_gone:
        raise EndingError


class Intent:
    """What is to be done when a widget is used, as viser takes it: ``on_click(Intent(act))``.

    It takes along what the widget holds at that moment, not when its turn has come. What it raises
    is told to the page that caused it. A change by the program has no page, and is no intent.
    """

    def __init__(self, act: Act) -> None:
        self._act = act

    def __call__(self, event: Any) -> None:
        """Do it now."""
        self.of(event)()

    def of(self, event: Any) -> Callable[[], None]:
        """What this event asks for, to be done later; of an event without a value, itself is it."""
        return partial(self._do, event, getattr(getattr(event, "target", None), "value", event))

    def _do(self, event: Any, value: Any) -> None:
        if event.client is not None:
            with told_to(event, self._act):
                self._act(event.client, value)


class Inbox(Workers):
    """Callbacks that wait for the render loop, which alone calls :meth:`drain`."""

    def __init__(self, wake: Callable[[], object]) -> None:
        """``wake`` is called when there is something; in any thread, and it must return at once."""
        super().__init__()
        self._waiting: deque[tuple[Future[Any], Callable[[], Any]]] = deque()
        self._wake = wake

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Enqueue a callback: viser calls this, in the order of a page's messages."""
        act = fn.of(*args) if isinstance(fn, Intent) else partial(fn, *args, **kwargs)
        future: Future[Any] = Future()
        self.count(future, *args)
        self._enqueue(future, act)
        return future

    def put(self, act: Callable[[], object]) -> None:
        """Enqueue what no callback of viser tells of. May be called from any thread."""
        self._enqueue(Future(), act)

    def work(
        self,
        client: viser.ClientHandle,
        make: Callable[[], Made],
        then: Callable[[Made], object],
    ) -> None:
        """Have something made in another thread, since it would hold up the loop; then go on.

        ``make`` must read nothing that changes. The browser is told what either of the two raises.
        """

        def go_on(found: Made) -> None:
            with told_to(client, then):
                then(found)

        def begin(_: viser.ClientHandle) -> None:
            with told_to(client, make), contextlib.suppress(EndingError):
                self.put(partial(go_on, make()))

        super().submit(begin, client)

    def drain(self) -> None:
        """Do all that waits by now."""
        for _ in range(len(self._waiting)):
            future, act = self._waiting.popleft()
            try:
                act()
            except Exception:
                # One that was not guarded: nobody's page is to stand still for that.
                log.exception("a callback failed")
            finally:
                future.set_result(None)

    def _enqueue(self, future: Future[Any], act: Callable[[], Any]) -> None:
        self._waiting.append((future, act))
        self._wake()
