"""A moment as the light pages are sent it: the board, and what is read beside it."""

from typing import Any, NamedTuple

from app.explain import sentence
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from app.player.boards import board_sent, described
from app.player.headline import readings_html


class Manner(NamedTuple):
    """How the hunt of a moment is drawn."""

    rests: bool
    """The learner stands still: a trial that has just ended is still shown."""
    named: bool
    """There are names on prey and predator, as long as they are to be met."""


def manner_of(of: Status | Snapshot) -> Manner:
    """How the hunt is drawn of how a session stands, or of a moment that stands by itself."""
    if isinstance(of, Snapshot):
        return Manner(rests=True, named=False)
    opens = of.opening is not None and not of.opening.rising
    return Manner(rests=opens or not of.playing, named=opens)


def moment_sent(of: Status | Snapshot, look: Look, extras: Extras) -> dict[str, Any]:
    """A moment, with all that is said of it.

    Args:
        of: a session's status, or the bare moment of a run that no session runs.
        look: how it is seen.
        extras: what the layer shows besides.

    Returns:
        ``board`` (:func:`board_sent`), and all of :func:`words_sent`.
    """
    snapshot = of.snapshot if isinstance(of, Status) else of
    board = board_sent(snapshot, look, extras, *manner_of(of))
    return {"board": board, **words_sent(of, look, extras)}


def words_sent(of: Status | Snapshot, look: Look, extras: Extras) -> dict[str, Any]:
    """What is read of a moment beside the board.

    Returns:
        ``step`` and ``trial``; ``sentence``, ``legend`` and ``readings`` as HTML; ``caption``, and
        what the board is for those who cannot see it, ``described``, as plain texts.
    """
    is_status = isinstance(of, Status)
    snapshot = of.snapshot if is_status else of
    layer = LAYERS[look.layer]
    look = layer.heeded(look, snapshot.spec.learner)
    said = sentence.said(of) if is_status else sentence.said_of(snapshot)
    return {
        "step": snapshot.step,
        "trial": snapshot.trial,
        "sentence": str(said),
        "caption": layer.caption(snapshot, look, extras),
        "legend": str(layer.legend(snapshot, look, extras)),
        "readings": readings_html(snapshot),
        "described": f"{described(snapshot, look)} {said.striptags()}",
    }
