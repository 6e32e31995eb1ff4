"""An honest clock: what drawing costs, and how far behind each browser is.

A browser is sent its next frame only when it has answered a ping that went out behind the one
before. So no frames pile up in the buffers of a slow connection, the frame rate of each browser
is what it can take, and how far it is behind is measured and not guessed.
"""

import asyncio
import time
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import viser
from websockets.exceptions import ConnectionClosed

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
        self._on_its_way = False
        self._delivery: asyncio.Task[None] | None = None
        self._sent_at = 0.0
        self._sent: deque[float] = deque()
        self._skipped: deque[float] = deque()

    def is_ready(self, now_s: float) -> bool:
        """Whether the browser has taken in its last frame; counts a skipped frame if not."""
        if self._on_its_way:
            self._skipped.append(now_s)
        return not self._on_its_way

    def behind_s(self, now_s: float) -> float:
        """How long the last frame has been on its way."""
        return now_s - self._sent_at if self._on_its_way else 0.0

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

    def _begin(self, now_s: float) -> None:
        self._sent.append(now_s)
        self._sent_at = now_s
        self._on_its_way = True

    async def _deliver(self, frame: bytes) -> None:
        # viser does not hand out its connections.
        connection = self._server._websock_server._live_connections.get(self._client_id)
        try:
            if connection is not None:
                await connection.send(frame)
                await (await connection.ping())
        except ConnectionClosed:
            # Whoever has gone away is not waited for.
            pass
        finally:
            self._on_its_way = False


def send(server: viser.ViserServer, frames: Sequence[tuple[Pulse, bytes]], now_s: float) -> None:
    """Send each of these browsers its frame, and ask it to answer once it has taken it in."""
    for pulse, _ in frames:
        pulse._begin(now_s)
    loop = server.get_event_loop()

    def start() -> None:
        for pulse, frame in frames:
            # Kept, for the loop itself keeps no task alive.
            pulse._delivery = loop.create_task(pulse._deliver(frame))

    loop.call_soon_threadsafe(start)


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
