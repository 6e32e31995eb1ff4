"""A moment as the light pages are sent it: the board, and what is read beside it."""

from typing import Any

from app.explain import sentence
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from app.player.boards import board_sent, described
from app.player.headline import readings_html


def moment_sent(of: Status | Snapshot, look: Look, extras: Extras) -> dict[str, Any]:
    """A moment, with all that is said of it; texts with markup are HTML.

    Args:
        of: a session's status, or the bare moment of a run that no session runs.
        look: how it is seen.
        extras: what the layer shows besides.
    """
    snapshot = of.snapshot if isinstance(of, Status) else of
    return {
        "board": board_sent(snapshot, look, extras, rests=not _goes_on(of)),
        **words_sent(of, look, extras),
    }


def words_sent(of: Status | Snapshot, look: Look, extras: Extras) -> dict[str, Any]:
    """What is read of a moment beside the board, as :func:`moment_sent` has it."""
    is_status = isinstance(of, Status)
    snapshot = of.snapshot if is_status else of
    layer = LAYERS[look.layer]
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


def _goes_on(of: Status | Snapshot) -> bool:
    return isinstance(of, Status) and of.playing
