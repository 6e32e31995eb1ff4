"""What is read of a moment beside the board, made once for all browsers that look alike."""

from functools import cached_property

from markupsafe import Markup

from app.explain import sentence
from app.live.status import Status
from app.metrics.course import NO_CURVE, GreedyCurve
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from app.player.boards import described
from app.player.headline import numbers_html, readings_html, sentence_html
from app.util.html import element


class Texts:
    """What is read of a moment by those who look alike: found when it is first asked for."""

    def __init__(
        self,
        status: Status,
        look: Look,
        extras: Extras,
        n_viewers: int,
        greedy: GreedyCurve = NO_CURVE,
    ) -> None:
        self.status = status
        self.look = look
        self.extras = extras
        self.greedy = greedy
        self._n_viewers = n_viewers
        self._layer = LAYERS[look.layer]

    @cached_property
    def sentence(self) -> str:
        """The sentence, and where a run of an experiment is from, as HTML."""
        return sentence_html(self.status, self._said)

    @cached_property
    def numbers(self) -> str:
        """The readings, as HTML."""
        return numbers_html(self.status, self._n_viewers, self.greedy)

    @cached_property
    def readings(self) -> str:
        """The few of them that stand beside the board, as HTML."""
        return readings_html(self.status.snapshot)

    @cached_property
    def caption(self) -> str:
        """What the layer shows, as HTML."""
        caption = self._layer.caption(self.status.snapshot, self.look, self.extras)
        return _captioned(caption, self._board)

    @cached_property
    def legend(self) -> str:
        """The layer's legend, as HTML."""
        return self._layer.legend(self.status.snapshot, self.look, self.extras)

    @cached_property
    def _said(self) -> Markup:
        return sentence.said(self.status)

    @property
    def _board(self) -> str:
        """What the board is for those who cannot see it."""
        return f"{described(self.status.snapshot, self.look)} {self._said.striptags()}"


def _captioned(caption: str, board: str) -> str:
    style = "padding:0 0.7em;font-size:0.85em;line-height:1.35"
    return element("div", caption, **{"data-board": board}, style=style)
