"""Visits: where the learner has been."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.amounts import amount_legend, draw_amount, fitted
from app.picture.colours import TRACES
from app.picture.frames import in_frame
from app.picture.layer import Extras, Layer, Picture
from app.picture.look import Look
from app.picture.raster import Raster, raster
from app.picture.shading import Ruler

_TIMES = 8.0
"""The scale goes from so many times less than the average to so many times more."""


def _density(snapshot: Snapshot) -> np.ndarray:
    """Visits of a cell as a multiple of what it would have if all of its heading had as many.

    By cells and not by states, of which the outer ones have many cells. How many a state has
    depends a little on its direction, too; the mean of its ring stands for it, which all headings
    have in common.

    Returns:
        ``(heading, distance, direction) float64``.
    """
    visits = snapshot.visits.sum(axis=-1, dtype=np.float64)
    _, n_distances, n_directions = visits.shape
    board = raster(snapshot.spec.world)
    of_state = np.bincount(board.states, minlength=n_distances * n_directions)
    cells = of_state.reshape(n_distances, n_directions).mean(axis=1)[:, None]
    mean = visits.sum(axis=(1, 2), keepdims=True) / len(board.states)
    return visits / np.maximum(cells, 1.0) / np.maximum(mean, 1e-12)


def _ruler(snapshot: Snapshot, look: Look) -> Ruler:
    fixed = Ruler(1 / _TIMES, _TIMES, "log")
    return fitted(_density(snapshot), fixed) if look.fitted else fixed


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    mean = in_frame(_density(snapshot), snapshot, look).mean(axis=0)
    return draw_amount(mean, _ruler(snapshot, look), TRACES, look, raster)


def _times(multiple: float) -> str:
    """A multiple of the average, as people say it."""
    if multiple < 1:
        return f"1/{1 / multiple:,.0f}"
    return f"{multiple:,.0f}" if multiple >= 10 else f"{multiple:.2g}"


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    title = "Visits of a cell, as a multiple of the average"
    ruler = _ruler(snapshot, look)
    return amount_legend(snapshot, look, title, ruler, TRACES, _times, "never visited")


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    return (
        "Where the predator has been since the run began: the stronger the colour, the more often."
    )


VISITS = Layer("visits", "Visits", _draw, _legend, _caption)
