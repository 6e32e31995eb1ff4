"""Success from here: how hunts without exploration end, by where they start."""

import functools

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.colours import css, over_board
from app.picture.frames import folds
from app.picture.layer import Extras, Layer, Picture, SuccessMap, blank
from app.picture.legend import bar, frame_in_words, legend, swatch
from app.picture.look import Look, heading_shown
from app.picture.raster import Raster
from app.picture.theme import Theme
from app.util.html import element, joined
from sim import geometry
from sim.spec import N_HEADINGS, WorldSpec
from sim.world import CAPTURE, FLIGHT, TIMEOUT

_SOFT = 0.75
"""How strongly an outcome covers the board, so that dots of the same colour stand out."""


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
    if not folds(look):
        heading = heading_shown(look, snapshot.heading)
        outcome = success.outcomes[heading].ravel()[raster.cells]
        return Picture(_outcome_colours(look.theme)[outcome])
    # One more element, not known, stands for all that lies off the board.
    flat = np.append(success.outcomes.ravel(), np.int8(0))
    outcome = flat.take(_turned_cells(snapshot.spec.world.size)[:, raster.cells])
    caught = np.count_nonzero(outcome == CAPTURE, axis=0)
    share = caught / np.maximum(np.count_nonzero(outcome, axis=0), 1)
    return Picture(over_board(np.array(look.theme.capture), share, look.theme))


def _outcome_colours(theme: Theme) -> np.ndarray:
    """(outcome, 3) uint8, the first for what is not known."""
    colours = np.array([theme.of_outcome(outcome) for outcome in range(4)])
    return over_board(colours, _SOFT, theme)


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
    if folds(look):
        board, full = np.array(theme.unknown), np.array(theme.capture)
        shades = board + (full - board) * np.linspace(0, 1, 12)[:, None]
        marks = [(k / N_HEADINGS, str(k)) for k in range(0, N_HEADINGS + 1, 2)]
        ends = f"Limits fixed: 0 to {N_HEADINGS} of the {N_HEADINGS} headings."
        parts = [bar(shades, marks), element("div", ends)]
        title = "Headings for which a hunt from here ends in capture"
    else:
        colours = _outcome_colours(theme)
        kinds = {CAPTURE: "capture", FLIGHT: "flight", TIMEOUT: "time-out", 0: "not known"}
        key = joined((swatch(css(colours[kind]), text) for kind, text in kinds.items()), "")
        parts = [element("div", key)]
        title = "How a hunt from here ends"
    frame = frame_in_words(snapshot, look, "for how many of its eight headings")
    return legend(look, title, parts, frame)


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    success = _success(snapshot, extras)
    if success is None:
        return "How a hunt without exploration would end from each place: being worked out."
    when = f"with what was learned by trial {success.trial:,}"
    if folds(look):
        return (
            "For how many of the eight headings a hunt without exploration from here ends in"
            f" capture, {when}."
        )
    return f"How a hunt without exploration from here ends, {when}."


SUCCESS = Layer(
    "success", "Success from here", _draw, _legend, _caption, heeds=frozenset({"frame"})
)
