"""An honest clock: what drawing costs, and how far behind each browser is.

A browser is sent its next frame only when it has answered a ping that went out behind the one
before. So no frames pile up in the buffers of a slow connection, the frame rate of each browser
is what it can take, and how far it is behind is measured and not guessed.
"""

import asyncio
import time
from collections import deque
from concurrent.futures import Future
from typing import NamedTuple

import viser

_WINDOW_S = 5.0


class Reading(NamedTuple):
    """What the clock says."""

    drawing_share: float
    """Share of the time in which the page was being drawn."""
    frames_sent: int
    """In the last seconds, to this browser."""
    frames_skipped: int
    """Frames that this browser was too slow for, in the last seconds."""
    behind_s: float
    """How far behind this browser is."""
    frame_rate: float
    """Frames per second sent to this browser."""


class Pulse:
    """One browser's beat."""

    def __init__(self, server: viser.ViserServer, client_id: int) -> None:
        self._server = server
        self._client_id = client_id
        self._answer: Future[object] | None = None
        self._asked_at = 0.0
        self._sent: deque[float] = deque()
        self._skipped: deque[float] = deque()

    def is_ready(self, now_s: float) -> bool:
        """Whether the browser has taken in its last frame; counts a skipped frame if not."""
        if self._answer is None or self._answer.done():
            return True
        self._skipped.append(now_s)
        return False

    def sent(self, now_s: float) -> None:
        """Note that a frame went out, and ask to be told of its arrival."""
        self._sent.append(now_s)
        self._asked_at = now_s
        self._answer = self._ping()

    def behind_s(self, now_s: float) -> float:
        """How long the last frame has been on its way."""
        if self._answer is None or self._answer.done():
            return 0.0
        return now_s - self._asked_at

    def reading(self, now_s: float, drawing_share: float) -> Reading:
        """What the clock says of this browser now."""
        for times in (self._sent, self._skipped):
            while times and times[0] < now_s - _WINDOW_S:
                times.popleft()
        return Reading(
            drawing_share=drawing_share,
            frames_sent=len(self._sent),
            frames_skipped=len(self._skipped),
            behind_s=self.behind_s(now_s),
            frame_rate=len(self._sent) / _WINDOW_S,
        )

    def _ping(self) -> Future[object] | None:
        # viser does not hand out its connections; this is the only place that needs one.
        connection = self._server._websock_server._live_connections.get(self._client_id)  # pyright: ignore[reportPrivateUsage]
        if connection is None:
            return None

        async def ping() -> None:
            await (await connection.ping())

        return asyncio.run_coroutine_threadsafe(ping(), self._server.get_event_loop())


class Drawing:
    """How much of the time goes into drawing."""

    def __init__(self) -> None:
        self._spans: deque[tuple[float, float]] = deque()
        self._started = 0.0

    def __enter__(self) -> None:
        self._started = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        self._spans.append((self._started, time.perf_counter()))
        while self._spans[0][1] < self._spans[-1][1] - _WINDOW_S:
            self._spans.popleft()

    @property
    def share(self) -> float:
        """Share of the last seconds, 0...1."""
        if not self._spans:
            return 0.0
        length = self._spans[-1][1] - self._spans[0][0]
        return sum(end - start for start, end in self._spans) / length if length > 0 else 0.0
