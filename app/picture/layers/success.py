"""Success from here: how hunts without exploration end, by where they start."""

import functools

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.colours import css, gradient_css, over_board
from app.picture.frames import folds
from app.picture.layer import Extras, Layer, Picture, SuccessMap, blank
from app.picture.legend import frame_in_words, hatch, legend, patch_of_board, swatch
from app.picture.look import Look, heading_shown
from app.picture.raster import Raster
from app.util.html import element, joined
from sim import geometry
from sim.spec import N_HEADINGS, WorldSpec
from sim.world import CAPTURE, FLIGHT, TIMEOUT

_SOFT = 0.75
"""How strongly captures cover the board, so that dots of the same colour stand out."""
_FEWEST = 0.3
"""The same where captures are hardly more than what else happens."""
_WORDS = {
    CAPTURE: "caught",
    FLIGHT: "noticed",
    TIMEOUT: "out of time",
}


def _success(snapshot: Snapshot, extras: Extras) -> SuccessMap | None:
    """The success map, if there is one of this run and of this board."""
    success = extras.success
    shape = (N_HEADINGS, snapshot.spec.world.size, snapshot.spec.world.size)
    if success is None or success.generation != snapshot.generation:
        return None
    return success if success.outcomes.shape == shape else None


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    success = _success(snapshot, extras)
    if success is None:
        return blank(look, raster)
    # One more element, not known, stands for all that lies off the board.
    flat = np.append(success.outcomes.ravel(), np.int8(0))
    size = snapshot.spec.world.size
    if folds(look):
        outcomes = flat.take(_turned_cells(size)[:, raster.cells])
    else:
        heading = heading_shown(look, snapshot.heading)
        outcomes = flat.take(heading * size**2 + raster.cells[None])
    counts = np.stack([np.count_nonzero(outcomes == kind, axis=0) for kind in _WORDS])
    known = counts.sum(axis=0)
    # Where as many hunts end otherwise, a capture is the first of the kinds, and wins.
    commonest = np.where(known > 0, np.array([*_WORDS])[counts.argmax(axis=0)], 0)
    share = counts.max(axis=0) / np.maximum(known, 1)
    theme = look.theme
    picture = blank(look, raster)
    caught = commonest == CAPTURE
    cover = _FEWEST + (_SOFT - _FEWEST) * np.clip(2 * share[caught] - 1, 0, 1)
    picture.colours[caught] = over_board(np.array(theme.capture), cover, theme)
    picture.colours[(commonest == FLIGHT) & raster.rising] = theme.flight
    picture.colours[(commonest == TIMEOUT) & raster.falling] = theme.timeout
    return picture


@functools.lru_cache(maxsize=4)
def _turned_cells(size: int) -> np.ndarray:
    """(heading, y * x) int32: cell of ``(heading, y, x)`` under a cell of the turned picture.

    The nearest; one past the last where the board does not reach.
    """
    world = WorldSpec(size=size)
    px, py = geometry.prey_xy(world)
    east, north = (part.ravel() for part in geometry.offsets(world))
    cells = np.full((N_HEADINGS, size * size), N_HEADINGS * size * size, np.int32)
    for heading in range(N_HEADINGS):
        turn = heading * np.pi / 4
        x = np.rint(east * np.cos(turn) - north * np.sin(turn)).astype(np.int64) + px
        y = np.rint(east * np.sin(turn) + north * np.cos(turn)).astype(np.int64) + py
        inside = (x >= 0) & (x < size) & (y >= 0) & (y < size)
        cells[heading, inside] = ((heading * size + y) * size + x)[inside]
    return cells


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    theme = look.theme
    cover = np.array([_SOFT] if not folds(look) else [_FEWEST, _SOFT])
    captures = gradient_css(over_board(np.array(theme.capture), np.repeat(cover, 2), theme))
    key = [
        swatch(captures, _WORDS[CAPTURE], width="2em"),
        hatch(css(theme.flight), _WORDS[FLIGHT]),
        hatch(css(theme.timeout), _WORDS[TIMEOUT], falls=True),
        patch_of_board(look, "not known"),
    ]
    title = "How a hunt from here would end, without random moves"
    if folds(look):
        title = "How most hunts from here would end, without random moves"
    note = (
        "Out of time: without random moves a predator can go round in the same circle for ever."
        " The learner's own random moves break such circles, so it can catch more while this shows"
        " less."
    )
    each = "what happens for most of its headings, in a fuller colour where for more"
    return legend(
        look,
        title,
        [element("div", joined(key, "")), element("div", note)],
        frame_in_words(snapshot, look, each),
    )


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    success = _success(snapshot, extras)
    if success is None:
        return "How a hunt without random moves would end from each place: being worked out."
    most = "most hunts" if folds(look) else "a hunt"
    return (
        f"How {most} would end from each place if all random moves were left out, with what was"
        f" learned by trial {success.trial:,}."
    )


SUCCESS = Layer(
    "success",
    "Success from here",
    _draw,
    _legend,
    _caption,
    heeds=frozenset({"frame"}),
    by="cell",
)
