"""Learning now: where values are changing."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.amounts import amount_legend, differences, draw_amount, fitted, least_difference
from app.picture.frames import facing, folds, in_frame
from app.picture.layer import Extras, Layer, Picture
from app.picture.look import Look
from app.picture.raster import Raster
from app.picture.shading import Ruler


def _ruler(snapshot: Snapshot, look: Look) -> Ruler:
    fixed = differences(snapshot)
    return fitted(snapshot.learning_now, fixed, fixed.low) if look.fitted else fixed


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    mean = in_frame(snapshot.learning_now, snapshot, look).mean(axis=0, dtype=np.float64)
    # What fades never ends; below the scale it counts as over.
    mean[mean < least_difference(snapshot)] = 0.0
    return draw_amount(mean, _ruler(snapshot, look), look, raster)


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    title = "Change of value lately, by powers of ten, fading"
    ruler = _ruler(snapshot, look)
    return amount_legend(snapshot, look, title, ruler, "no change lately")


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    if in_frame(snapshot.learning_now, snapshot, look).any():
        return (
            "Where values are changing right now; while it learns, the glow fades within seconds."
        )
    if folds(look):
        return "Where values are changing right now: nowhere."
    where = f"nowhere while the prey looks {facing(snapshot, look)}"
    return f"Where values are changing right now: {where}."


NOW = Layer("now", "Learning now", _draw, _legend, _caption)
