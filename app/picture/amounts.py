"""Amounts: what the layers share that show how much there is of something."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.colours import heat_colours, over_board, palette
from app.picture.layer import Picture, spread
from app.picture.legend import bar, bar_marks, frame_in_words, legend, limits, patch_of_board
from app.picture.look import Look
from app.picture.raster import Raster
from app.picture.shading import Ruler
from app.picture.value_maps import penalty_of, reward_of
from app.util.html import element
from app.words.numbers import of_any_size

DECADES = 6
"""Powers of ten between the ends of a logarithmic scale of amounts."""


def least_difference(snapshot: Snapshot) -> float:
    """Differences of value below this are not worth showing."""
    return max(reward_of(snapshot), penalty_of(snapshot)) * 10.0**-DECADES


def differences(snapshot: Snapshot) -> Ruler:
    """The scale of differences of value, up to what an end of a trial is worth."""
    most = max(reward_of(snapshot), penalty_of(snapshot))
    return Ruler(least_difference(snapshot), most, "log")


def fitted(amounts: np.ndarray, fixed: Ruler, least: float) -> Ruler:
    """The ruler between the ends of the amounts that are shown, those from ``least`` on."""
    there = amounts[amounts >= least]
    return Ruler(float(there.min()), float(there.max()), fixed.kind) if len(there) else fixed


def draw_amount(amount: np.ndarray, ruler: Ruler, look: Look, raster: Raster) -> Picture:
    """Amounts ``(distance, direction)``, blank where 0."""
    there = amount > 0
    level = np.where(there, ruler.place(amount), 0.0)
    colours = palette(heat_colours(look.theme), level)
    return spread(over_board(colours, there, look.theme), raster)


def amount_legend(snapshot: Snapshot, look: Look, title: str, ruler: Ruler, nothing: str) -> Markup:
    """Legend of a map of amounts.

    Args:
        snapshot: the moment.
        look: how the board is seen.
        title: what there is an amount of.
        ruler: its scale.
        nothing: what it means that a place is blank.
    """
    colours, marks = heat_colours(look.theme), bar_marks(ruler, of_any_size)
    parts = [
        bar(colours, marks),
        limits(look, of_any_size(ruler.low), of_any_size(ruler.high)),
        element("div", patch_of_board(look, nothing)),
    ]
    frame = frame_in_words(snapshot, look, "the mean over its eight headings")
    return legend(look, title, parts, frame)
