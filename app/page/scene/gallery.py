"""What is looked at: boards and texts, made once for all browsers that want to see the same.

Those that look at what is live share a board if they agree how it is to look; one that looks at a
moment of the past has its own.
"""

from collections.abc import Container
from functools import partial
from typing import NamedTuple

import viser

from app.live.status import Status
from app.metrics.course import GreedyCurve
from app.page.scene.board import BoardView
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import ALL, Look
from app.picture.multiples import all_headings
from app.player.moments import manner_of
from app.player.texts import Texts
from app.server.stage import Stage

_TEXTS_S = 0.25
_SETTLED_S = 1.5
"""After so long there is nothing more to draw of a moment that stays: lines are drawn less often
than colours."""


class Seen(NamedTuple):
    """What is seen of a board, by one browser or by many."""

    look: Look
    viewer: int | None = None
    """The browser that has something of its own to see, such as a moment of the past; None for all
    that look at what is live."""


class Exhibit:
    """A board that is drawn in one way, and what is read beside it."""

    def __init__(self, server: viser.ViserServer, status: Status, look: Look) -> None:
        self.look = look
        self.stage = Stage(server)
        """Where it is drawn."""
        self.board = BoardView(self.stage.scene, status.snapshot, look)
        self.texts: Texts | None = None
        """Of a quarter of a second ago at most; None before the first moment."""
        self._read_at = 0.0
        self._drawn: tuple[object, ...] | None = None
        """What was drawn last, and kept, so that its parts are told by what they are."""
        self._drawn_s = 0.0
        """Since when."""

    def update(
        self, status: Status, extras: Extras, greedy: GreedyCurve, n_viewers: int, now_s: float
    ) -> Texts:
        """Draw a moment; returns what is read beside it."""
        self._draw(status, extras, now_s)
        former = self.texts
        is_other = status.behind is not None and (
            former is None or former.status.snapshot is not status.snapshot
        )
        if self.texts is None or is_other or now_s - self._read_at >= _TEXTS_S:
            self.texts = Texts(status, self.look, extras, n_viewers, greedy)
            self._read_at = now_s
        return self.texts

    def _draw(self, status: Status, extras: Extras, now_s: float) -> None:
        look, layer = self.look, LAYERS[self.look.layer]
        manner = manner_of(status)
        drawn = (status.snapshot, extras.success, extras.since, *manner)
        former = self._drawn
        if former is None or not all(a is b for a, b in zip(drawn, former, strict=True)):
            self._drawn, self._drawn_s = drawn, now_s
        elif now_s - self._drawn_s > _SETTLED_S:
            return
        paint = partial(all_headings, layer=layer) if look.frame == ALL else layer.paint
        picture = paint(status.snapshot, look, extras=extras)
        self.board.update(status.snapshot, picture, self.look, now_s, *manner)


class Gallery:
    """The boards that are looked at, by what is seen of them. Changed by one thread."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._exhibits: dict[Seen, Exhibit] = {}

    def of(self, status: Status, seen: Seen) -> Exhibit:
        """The board of which this is seen, which is made if there is none yet."""
        if seen not in self._exhibits:
            self._exhibits[seen] = Exhibit(self._server, status, seen.look)
        return self._exhibits[seen]

    def keep(self, seen: Container[Seen]) -> None:
        """Forget the boards that nobody looks at any more."""
        for one in [one for one in self._exhibits if one not in seen]:
            del self._exhibits[one]
