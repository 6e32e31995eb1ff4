"""The thread that advances: it answers requests in order, makes steps between, and publishes.

Only this thread touches the learner. Everybody else enqueues a request and reads the latest status,
of which there is one at a time and never a queue.
"""

import logging
import math
import queue
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from typing import Any, Final, Generic, NamedTuple, TypeVar

from learners.commands import CommandError

Stand = TypeVar("Stand")
"""How it stands, as it is published."""

log = logging.getLogger(__name__)

FULL_SPEED: Final = math.inf
"""A speed in steps per second: as fast as it goes."""

MOST_WAITING = 1_000
"""Requests that may wait while the worker is deaf."""

SLICE_S = 0.005
"""How long the learner may keep the worker from its requests."""
_PUBLISH_S = 1 / 15
_TICK_S = 1 / 60
"""How often learning at a set speed is worth waking up for."""
_MAX_DEBT_S = 0.1
"""Learning that is owed after a stall is forgiven beyond this, so that speed never bursts."""
_RATE_WINDOW_S = 1.0
_FAREWELL_S = 2.0

Reply = Callable[[str], None]
"""Told why a request could not be carried out."""


class Pace:
    """How many steps are to be made now, and how many were made in the last second."""

    def __init__(self, slice_s: float = SLICE_S) -> None:
        """Prepare it; a slice is to take about so long."""
        self._slice_s = slice_s
        self._slice_steps = 1_000
        self._made = 0
        self.restart()

    def restart(self) -> None:
        """Owe nothing, and know nothing of what was made before."""
        self._paced_from = time.perf_counter()
        self._owed = 0.0
        self._made_at: deque[tuple[float, int]] = deque()

    def wait_s(self, speed: float) -> float:
        """How long until it is worth making steps at a speed."""
        if speed == FULL_SPEED:
            return 0.0
        self._accrue(speed)
        return max((max(speed * _TICK_S, 1.0) - self._owed) / speed, 0.0)

    def steps(self, speed: float) -> int:
        """The steps of the next slice, which are owed no more."""
        if speed == FULL_SPEED:
            return self._slice_steps
        self._accrue(speed)
        steps = min(int(self._owed), self._slice_steps)
        self._owed -= steps
        return steps

    def note(self, made: int, took_s: float) -> None:
        """Let a slice take about as long as the worker may be deaf, by what the last one took."""
        self._made += made
        self._made_at.append((time.perf_counter(), self._made))
        if made == self._slice_steps and took_s > 0:
            wanted = made * self._slice_s / took_s
            self._slice_steps = int(min(max(wanted, self._slice_steps / 2, 1), made * 2))

    def rate(self) -> float:
        """Steps per second made, over the last second."""
        horizon = time.perf_counter() - _RATE_WINDOW_S
        while len(self._made_at) > 2 and self._made_at[1][0] < horizon:
            self._made_at.popleft()
        if len(self._made_at) < 2:
            return 0.0
        (first_s, first), (last_s, last) = self._made_at[0], self._made_at[-1]
        return (last - first) / (last_s - first_s) if last_s > first_s else 0.0

    def _accrue(self, speed: float) -> None:
        now = time.perf_counter()
        limit = max(speed * _MAX_DEBT_S, 1.0)
        self._owed = min(self._owed + (now - self._paced_from) * speed, limit)
        self._paced_from = now


class _Envelope(NamedTuple):
    request: Any
    run: int | None
    reply: Reply | None
    ticket: int


class Worker(ABC, Generic[Stand]):
    """The thread, whatever it advances. All public methods may be called from any thread."""

    _status: Stand

    def __init__(
        self, name: str = "learner", publish_s: float = _PUBLISH_S, slice_s: float = SLICE_S
    ) -> None:
        """Prepare it.

        Args:
            name: of the thread.
            publish_s: how long it may go on before how it stands is published anew.
            slice_s: how long it may be deaf to requests.
        """
        self._publish_s = publish_s
        self._requests: queue.SimpleQueue[_Envelope | None] = queue.SimpleQueue()
        self._newest_ticket = 0
        self._answered = 0
        self._thread = threading.Thread(target=self._work, name=name, daemon=True)
        self._published = threading.Condition()
        self._submitting = threading.Lock()
        self._stopping = False
        self._preparing = True
        """Whether no step has been made yet: the first one compiles."""
        self._pace = Pace(slice_s)
        self._published_at = -math.inf
        self._on_answer: Callable[[], object] = lambda: None
        self._told = 0

    # What it advances

    @abstractmethod
    def _aim(self) -> float | None:
        """Steps per second to make now; None to stand still."""

    @abstractmethod
    def _advance(self, steps: int) -> int:
        """Make at most so many steps; returns how many were made."""

    @abstractmethod
    def _carry_out(self, request: Any, run: int | None, reply: Reply | None = None) -> None:
        """Do what is asked for. Raises `CommandError` if it cannot be done.

        What takes longer than a moment may be begun here; ``reply`` is told later if it fails.
        """

    @abstractmethod
    def _break_off(self, error: str) -> None:
        """Stand still after an error, the state kept."""

    @abstractmethod
    def _take_status(self, now_s: float) -> Stand:
        """How it stands; ``now_s`` is of the clock ``time.perf_counter``."""

    # What others do

    @property
    def status(self) -> Stand:
        """The latest published moment."""
        return self._status

    def call_when_answered(self, callback: Callable[[], object]) -> None:
        """Have this called, in the worker's thread, when a status tells of answered requests."""
        self._on_answer = callback

    def start(self) -> None:
        """Begin to work."""
        self._thread.start()

    @property
    def is_gone(self) -> bool:
        """Whether the worker has ended, be it that it was told to."""
        return self._thread.ident is not None and not self._thread.is_alive()

    def stop(self) -> None:
        """End the worker and wait for it, unless it is deaf because it compiles."""
        self._requests.put(None)
        self._thread.join(timeout=_FAREWELL_S)

    def submit(self, request: Any, reply: Reply | None = None, run: int | None = None) -> int:
        """Ask for something; it is done before the next slice of learning.

        Where too much is asked for already, because the learner's code is being compiled, it is
        refused.

        Args:
            request: what is asked for.
            reply: told if it cannot be done.
            run: number of the run that is meant; None for the one that is shown.

        Returns:
            A ticket; the request has been answered once ``status.answered`` has reached it.
        """
        envelope = None
        with self._submitting:
            if self._requests.qsize() < MOST_WAITING:
                self._newest_ticket += 1
                envelope = _Envelope(request, run, reply, self._newest_ticket)
                self._requests.put(envelope)
            ticket = self._newest_ticket
        if envelope is None and reply is not None:
            reply(f"{MOST_WAITING:,} requests wait for the learner; ask again once it is ready")
        return ticket

    def wait_for(self, condition: Callable[[Stand], bool], timeout_s: float) -> Stand:
        """The first published status that meets a condition.

        Raises:
            TimeoutError: none did in time.
        """
        with self._published:
            if not self._published.wait_for(lambda: condition(self._status), timeout_s):
                raise TimeoutError("the session did not get there in time")
            return self._status

    # What the thread does

    def _work(self) -> None:
        while not self._stopping:
            try:
                self._answer_requests()
                if self._aim() is not None and not self._stopping:
                    self._learn()
            except Exception as error:
                # Whatever went wrong, the page must say so and the state must be kept.
                log.exception("the learner stopped")
                self._break_off(f"{type(error).__name__}: {error}")
                self._publish()

    def _answer_requests(self) -> None:
        """Wait for requests until it is time to learn, for ever if it stands still."""
        aim = self._aim()
        wait_s = None if aim is None else self._pace.wait_s(aim)
        try:
            envelope = self._requests.get(block=wait_s != 0.0, timeout=wait_s)
            while True:
                if envelope is None:
                    self._stopping = True
                    return
                self._answer(envelope)
                envelope = self._requests.get_nowait()
        except queue.Empty:
            return
        finally:
            if self._aim() is None:
                self._publish()

    def _answer(self, envelope: _Envelope) -> None:
        log.debug("asked for %s", envelope.request)
        try:
            self._carry_out(envelope.request, envelope.run, envelope.reply)
        except CommandError as error:
            self._reply(envelope, str(error))
        finally:
            self._answered = envelope.ticket
            self._published_at = -math.inf

    def _reply(self, envelope: _Envelope, reason: str) -> None:
        if envelope.reply is None:
            return
        try:
            envelope.reply(reason)
        except Exception:
            # Whoever asked may be gone; that is no reason for the learner to stop.
            log.exception("a refusal could not be told")

    def _learn(self) -> None:
        if self._preparing:
            # The first call compiles, or loads what was compiled before.
            self._publish()
            self._advance(1)
            self._pace.restart()
        else:
            # The time that the worker itself needed: it also waits while others draw.
            started = time.thread_time()
            steps = self._pace.steps(self._aim() or FULL_SPEED)
            if steps > 0:
                made = self._advance(steps)
                self._pace.note(made, time.thread_time() - started)
        stands = self._aim() is None
        if stands or time.perf_counter() - self._published_at >= self._publish_s:
            self._publish()

    def _publish(self) -> None:
        now_s = time.perf_counter()
        # A session also writes to its disk here, for which nobody else has to wait.
        status = self._take_status(now_s)
        with self._published:
            self._status = status
            self._published_at = time.perf_counter()
            self._published.notify_all()
        if self._told != self._answered:
            self._told = self._answered
            self._on_answer()
