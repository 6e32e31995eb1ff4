"""How fast the messages of one page are acted on: newer values replace older ones, held keys rest.

A page of ours sends some tens of messages a second. What sends more is a key that is held down, a
stuck mouse or a stranger; the lab is to do no more work for it than for the others.
"""

import math
from collections import deque
from collections.abc import Hashable
from typing import Final

from app.server.shapes import Shaped

VALUE_S = 1 / 30
"""A widget's values are taken in this often; of those that come between, the newest counts."""

REPEAT_S = 0.1
"""A key that comes again within this time is being held down; nobody presses as fast."""

SECOND_PRESS_S = 0.8
"""A held key repeats for the first time after at most this time, and from then on quickly."""

RECEIVED_S, ACTED_S = 1 / 3_000, 1 / 1_000
"""What a message costs its page: in time, in the long run."""

BURST_S = 1.0
"""So much time may be owed before messages have to wait."""

_MOST_SUBJECTS: Final = 500
"""Widgets that a page may have touched before it is forgotten when."""


class Pace:
    """The messages of one page that came and have not been acted on. Times are in seconds."""

    def __init__(self) -> None:
        self._ready: deque[Shaped] = deque()
        self._held: dict[Hashable, tuple[float, Shaped]] = {}
        """By its subject: when it is due, unless something of the same subject takes its place."""
        self._taken_s: dict[Hashable, float] = {}
        """When a value of a subject was taken last."""
        self._pressed_s: dict[Hashable, float] = {}
        """When a key came last, held down or not."""
        self._paid_until = -math.inf

    def take_value(
        self, subject: Hashable, message: Shaped, now_s: float, apart: bool = False
    ) -> None:
        """Note a new value of something: it takes the place of one that waits.

        What is ``apart`` may come before what came before it: the camera, which some keys move.
        """
        due_s = self._taken_s.get(subject, -math.inf) + VALUE_S
        if not apart:
            self.release(but=subject)
        if due_s <= now_s and subject not in self._held:
            self._ready.append(message)
            _enter(self._taken_s, subject, now_s)
        else:
            self._held[subject] = (due_s, message)

    def take_press(self, subject: Hashable, message: Shaped, now_s: float) -> None:
        """Note that a key was pressed, unless it is one that is held down.

        The second press in a row may be the first repeat of a held key, which the next one tells.
        """
        since_s = now_s - self._pressed_s.get(subject, -math.inf)
        _enter(self._pressed_s, subject, now_s)
        if since_s < REPEAT_S:
            self._held.pop(subject, None)
        elif since_s < SECOND_PRESS_S:
            self.release()
            self._held[subject] = (now_s + REPEAT_S, message)
        else:
            self.take_act(message)

    def take_act(self, message: Shaped) -> None:
        """Note a message that counts whatever comes next; what came before it comes first."""
        self.release()
        self._ready.append(message)

    def next(self, now_s: float) -> Shaped | None:
        """The next message to act on, if its time has come."""
        for subject, (due_s, message) in tuple(self._held.items()):
            if due_s <= now_s:
                del self._held[subject]
                if subject in self._taken_s:
                    self._taken_s[subject] = now_s
                self._ready.append(message)
        return self._ready.popleft() if self._ready else None

    def wait_s(self, now_s: float) -> float | None:
        """How long until a message that is held becomes due; None if there is none."""
        dues = [due_s for due_s, _ in self._held.values()]
        return max(min(dues) - now_s, 0.0) if dues else None

    def charge(self, cost_s: float, now_s: float) -> float:
        """Count the cost of a message; returns for how long the page has to wait for the next."""
        self._paid_until = max(self._paid_until, now_s) + cost_s
        return max(self._paid_until - now_s - BURST_S, 0.0)

    def release(self, but: Hashable = None) -> bool:
        """Let what is held go before what comes next; returns whether anything is ready."""
        kept = self._held.pop(but, None)
        self._ready.extend(message for _, message in self._held.values())
        self._held.clear()
        if kept is not None:
            self._held[but] = kept
        return bool(self._ready)


def _enter(times_s: dict[Hashable, float], subject: Hashable, now_s: float) -> None:
    if len(times_s) >= _MOST_SUBJECTS:
        times_s.clear()
    times_s[subject] = now_s
