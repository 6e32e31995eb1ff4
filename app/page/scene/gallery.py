"""What is looked at: boards and texts, made once for all browsers that want to see the same."""

from collections.abc import Container
from functools import partial

import viser

from app.live.session import Status
from app.metrics.course import GreedyCurve
from app.page.scene.board import BoardView
from app.page.texts import Texts
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import ALL, Look
from app.picture.multiples import all_headings
from app.server.stage import Stage

_TEXTS_S = 0.25


class Exhibit:
    """A board that is drawn in one way, and what is read beside it."""

    def __init__(self, server: viser.ViserServer, status: Status, look: Look) -> None:
        self._look = look
        self.stage = Stage(server)
        """Where it is drawn."""
        self.board = BoardView(self.stage.scene, status.snapshot, look)
        self.texts: Texts | None = None
        """Of a quarter of a second ago at most; None before the first moment."""
        self._read_at = 0.0

    def update(
        self, status: Status, extras: Extras, greedy: GreedyCurve, n_viewers: int, now_s: float
    ) -> Texts:
        """Draw a moment; returns what is read beside it."""
        look, layer = self._look, LAYERS[self._look.layer]
        paint = partial(all_headings, layer=layer) if look.frame == ALL else layer.paint
        picture = paint(status.snapshot, look, extras=extras)
        opens = status.opening is not None and not status.opening.rising
        rests = opens or not status.playing
        self.board.update(status.snapshot, picture, self._look, now_s, rests, named=opens)
        if self.texts is None or now_s - self._read_at >= _TEXTS_S:
            self.texts = Texts(status, self._look, extras, n_viewers, greedy)
            self._read_at = now_s
        return self.texts


class Gallery:
    """The boards that are looked at, by how they look. Changed by one thread."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._exhibits: dict[Look, Exhibit] = {}

    def of(self, status: Status, look: Look) -> Exhibit:
        """The board that looks so, which is made if there is none yet."""
        if look not in self._exhibits:
            self._exhibits[look] = Exhibit(self._server, status, look)
        return self._exhibits[look]

    def board(self, look: Look) -> BoardView | None:
        """The board that looks so, None if there is none. May be called from any thread."""
        exhibit = self._exhibits.get(look)
        return None if exhibit is None else exhibit.board

    def keep(self, looks: Container[Look]) -> None:
        """Forget the boards that nobody looks at any more."""
        for look in [look for look in self._exhibits if look not in looks]:
            del self._exhibits[look]
