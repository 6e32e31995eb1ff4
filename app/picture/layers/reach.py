"""First reach: when value came to each place, with a line every so many trials."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.colours import css, gain_colours, over_board, palette
from app.picture.frames import in_frame
from app.picture.layer import Extras, Layer, Picture, spread
from app.picture.legend import (
    bar,
    bar_marks,
    frame_in_words,
    legend,
    limits,
    patch_of_board,
    swatch,
)
from app.picture.look import Look
from app.picture.raster import Raster
from app.picture.shading import Ruler, mean_of
from app.util.html import element
from app.words.numbers import round_numbers

MOST_LINES = 10
"""Isochrones that a picture has at most."""
_FEWEST_BETWEEN_LINES = 500
"""Trials from an isochrone to the next at least."""
_LINE_SHADE = 0.3
"""Brightness of an isochrone as a share of what it runs through."""


def _ruler(snapshot: Snapshot, look: Look) -> Ruler:
    """Trials; by the square root, because value spreads fast at first and slowly later."""
    reached = snapshot.first_reach[snapshot.first_reach >= 0]
    if look.fitted and len(reached):
        return Ruler(float(reached.min()), float(reached.max()), "root")
    return Ruler(0.0, float(max(snapshot.spec.trials, snapshot.trial, 1)), "root")


def line_step(first_reach: np.ndarray) -> int:
    """Trials between isochrones, so that there are at most ``MOST_LINES`` of them."""
    reached = first_reach[first_reach >= 0]
    first, last = (int(reached.min()), int(reached.max())) if len(reached) else (0, 0)
    steps = map(int, round_numbers(_FEWEST_BETWEEN_LINES))
    return next(step for step in steps if last // step - first // step <= MOST_LINES)


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    turned = in_frame(snapshot.first_reach, snapshot, look)
    reached = turned >= 0
    count = reached.sum(axis=0)
    trial = mean_of(np.where(reached, turned, 0), count, np.nan)
    level = 1.0 - _ruler(snapshot, look).place(trial)
    share = count / len(turned)
    gain = palette(gain_colours(), level)
    picture = spread(over_board(gain, share, look.theme), raster)
    line = _isochrones(trial, line_step(snapshot.first_reach), raster)
    dark = over_board(gain * _LINE_SHADE, share, look.theme).reshape(-1, 3)
    picture.colours[line] = dark[raster.states[line]]
    return picture


def _isochrones(trial: np.ndarray, step: int, raster: Raster) -> np.ndarray:
    """Pixels of the lines: the later of two neighbours with a multiple of ``step`` between them.

    Args:
        trial: ``(distance, direction)``: when value came, NaN where it has not.
        step: trials from line to line.
        raster: where the lines are drawn.
    """
    band = np.where(np.isnan(trial), -1, np.nan_to_num(trial) // step).astype(np.int64).ravel()
    first, second = band[raster.states[raster.seams]].T
    crossed = (first != second) & (first >= 0) & (second >= 0)
    later = np.where(second > first, raster.seams[:, 1], raster.seams[:, 0])
    return later[crossed]


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    ruler, colours = _ruler(snapshot, look), gain_colours()
    step = f"a line every {line_step(snapshot.first_reach):,} trials"
    line = swatch(css(colours[128] * _LINE_SHADE), step)
    parts = [
        bar(colours[::-1], bar_marks(ruler, "{:,.0f}".format)),
        limits(look, f"trial {ruler.low:,.0f}", f"{ruler.high:,.0f}"),
        element("div", line + patch_of_board(look, "not yet")),
    ]
    each = "the mean over the headings that value has reached, paler where few"
    frame = frame_in_words(snapshot, look, each)
    return legend(look, "Trial in which value first rose", parts, frame)


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    if not (snapshot.first_reach >= 0).any():
        return "When value came to each place: it has not come to any yet."
    return (
        "When value came to each place: bright early, dark late; from one dark line to the next"
        f" it took {line_step(snapshot.first_reach):,} trials."
    )


REACH = Layer("reach", "First reach", _draw, _legend, _caption)
