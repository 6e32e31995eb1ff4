"""Visits: where the learner has been."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.amounts import DECADES, amount_legend, draw_amount, fitted
from app.picture.frames import in_frame
from app.picture.layer import Extras, Layer, Picture
from app.picture.look import Look
from app.picture.raster import Raster
from app.picture.shading import Ruler


def _visits(snapshot: Snapshot) -> np.ndarray:
    """(heading, distance, direction) float64."""
    return snapshot.visits.sum(axis=-1, dtype=np.float64)


def _ruler(snapshot: Snapshot, look: Look) -> Ruler:
    fixed = Ruler(1.0, 10.0**DECADES, "log")
    return fitted(_visits(snapshot), fixed, fixed.low) if look.fitted else fixed


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    mean = in_frame(_visits(snapshot), snapshot, look).mean(axis=0)
    return draw_amount(mean, _ruler(snapshot, look), look, raster)


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    title = "Learning steps made in a state, by powers of ten"
    ruler = _ruler(snapshot, look)
    return amount_legend(snapshot, look, title, ruler, "never visited")


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    return "Where the learner has been: how many of its steps started in each place."


VISITS = Layer("visits", "Visits", _draw, _legend, _caption)
