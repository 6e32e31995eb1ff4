"""Amounts: what the layers share that show how much there is of something.

Each has a ramp of its own, so that they are told apart from the last row.
"""

from collections.abc import Callable

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.colours import Ramp, amount_colours, over_board, palette
from app.picture.layer import Picture, spread
from app.picture.legend import bar, bar_marks, frame_in_words, legend, limits, patch_of_board
from app.picture.look import Look
from app.picture.raster import Raster
from app.picture.shading import Ruler
from app.picture.value_maps import penalty_of, reward_of
from app.util.html import element

_LEAST = 1e-6
"""Differences of value below this share of what the end of a trial is worth are none."""


def least_difference(snapshot: Snapshot) -> float:
    """Differences of value below this are not worth showing."""
    return max(reward_of(snapshot), penalty_of(snapshot)) * _LEAST


def fitted(amounts: np.ndarray, fixed: Ruler) -> Ruler:
    """The ruler between the ends of the amounts that there are; NaN and 0 are none."""
    there = amounts[amounts > 0]
    return Ruler(float(there.min()), float(there.max()), fixed.kind) if len(there) else fixed


def draw_amount(
    amount: np.ndarray, ruler: Ruler, ramp: Ramp, look: Look, raster: Raster
) -> Picture:
    """Amounts ``(distance, direction)``, blank where 0 or NaN."""
    there = amount > 0
    colours = palette(amount_colours(ramp, look.theme), ruler.place(amount))
    return spread(over_board(colours, there, look.theme), raster)


def amount_legend(
    snapshot: Snapshot,
    look: Look,
    title: str,
    ruler: Ruler,
    ramp: Ramp,
    write: Callable[[float], str],
    nothing: str,
    each: str = "the mean over its eight headings",
) -> Markup:
    """Legend of a map of amounts.

    Args:
        snapshot: the moment.
        look: how the board is seen.
        title: what there is an amount of.
        ruler: its scale.
        ramp: its colours.
        write: an amount as people read it.
        nothing: what it means that a place is blank.
        each: what a place of a folded picture shows.
    """
    parts = [
        bar(amount_colours(ramp, look.theme), bar_marks(ruler, write)),
        limits(look, write(ruler.low), write(ruler.high)),
        element("div", patch_of_board(look, nothing)),
    ]
    frame = frame_in_words(snapshot, look, each)
    return legend(look, title, parts, frame)
