"""Where the learner of one seat is kept, at work or put away, and what its pages are sent."""

from collections import deque
from typing import Final

from app.audience.own import Beginning, Kept, Own
from app.audience.own_view import OwnView, Seat
from app.audience.pictures import Parts
from app.audience.taps import Tap
from app.server.turnstile import Turnstile
from app.server.watchers import Watcher

_BYTES_PER_S: Final = 8_000.0
"""What a page is sent in the long run while its learner goes on."""
_BYTES_AT_ONCE: Final = 16_000.0


class Desk:
    """What there is of one seat. The thread of own learners alone has to do with it."""

    def __init__(self, seat: Seat, beginning: Beginning, now_s: float) -> None:
        self.seat = seat
        self.beginning = beginning
        self.own: Own | None = None
        self.kept: Kept | None = None
        """While it is put away."""
        self.rests = False
        """Whether it is put away until somebody touches it."""
        self.held: deque[Tap] = deque()
        """What is done once it is there."""
        self.notice = ""
        self.stand: bytes = b""
        """The part that says how it stands."""
        self.views: dict[bool, OwnView] = {}
        self.looking: list[Watcher] = []
        """Pages that show it."""
        self.used_s = self.there_s = now_s
        """When it was touched last, and when a page of its seat was open last."""
        self.owed, self.learned_s = 0.0, now_s
        self.is_stale = True
        """Whether there may be something to paint."""
        self.is_behind = False
        """Whether some page may not have been sent all that there is."""
        self.shown_s = -10.0
        """When it was painted last because somebody had done something."""
        self.made_s = 0.0
        """What it has taken to make it again, of a processor."""
        self.due_s = 0.0
        self.pace = Turnstile(_BYTES_PER_S, _BYTES_AT_ONCE)
        self.came_to: tuple[int, float] | None = None
        """Its trial and its reward, when they were looked at last."""
        self.learns = False

    def begin(self, beginning: Beginning) -> None:
        """Have a learner that knows nothing."""
        self.beginning = beginning
        self.own, self.kept = Own(beginning, beginning.seed_of(self.seat.number)), None
        self.rests, self.is_stale = False, True
        self.held.clear()

    def put_away(self, rests: bool) -> None:
        """Keep no more of it than it takes to make it again."""
        if self.own is not None:
            self.kept, self.own = self.own.put_away(), None
        self.rests, self.learns = rests, False
        if not rests:
            self.views.clear()

    def parts(self, dark: bool) -> Parts:
        """What there is to be sent."""
        view = self.views.get(dark)
        parts = {} if view is None else dict(view.parts)
        if self.stand:
            parts["own"] = self.stand
        return parts
