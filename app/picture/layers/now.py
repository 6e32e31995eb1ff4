"""Learning now: where values are changing."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.amounts import amount_legend, draw_amount, fitted, least_difference
from app.picture.colours import GLOW
from app.picture.frames import facing, in_frame, is_of_one
from app.picture.layer import Extras, Layer, Picture
from app.picture.look import Look
from app.picture.raster import Raster
from app.picture.shading import Ruler
from app.picture.value_maps import or_zero

_FIXED = Ruler(0.0, 0.5)
"""What is learned already wavers by some hundredths; where value arrives all of it is new."""
_LEAST = 0.03
"""Less than this share of a value is no change that anybody should look at."""


def _changes(snapshot: Snapshot) -> np.ndarray:
    """Change of values lately as a share of the values, at most 1; 0 where it is over.

    As a share, because values fall with distance: the far end of what is known would show as
    nothing beside the wavering near the prey.

    Returns:
        ``(heading, distance, direction) float64``.
    """
    change = snapshot.learning_now.astype(np.float64)
    size = np.maximum(np.abs(or_zero(snapshot.value)), change)
    share = np.divide(change, size, out=np.zeros_like(change), where=size > 0)
    share[(share < _LEAST) | (change < least_difference(snapshot))] = 0.0
    return share


def _ruler(snapshot: Snapshot, look: Look) -> Ruler:
    return fitted(_changes(snapshot), _FIXED) if look.fitted else _FIXED


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    mean = in_frame(_changes(snapshot), snapshot, look).mean(axis=0)
    return draw_amount(mean, _ruler(snapshot, look), GLOW, look, raster)


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    title = "Change of the value in the last moments, as a share of it"
    ruler = _ruler(snapshot, look)
    return amount_legend(snapshot, look, title, ruler, GLOW, "{:.0%}".format, "no change")


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    if in_frame(_changes(snapshot), snapshot, look).any():
        return (
            "Where values are changing at this moment: the more it glows, the more of the value is"
            " new."
        )
    if not is_of_one(look):
        return "Where values are changing: nowhere at this moment."
    return f"Where values are changing: nowhere while the prey looks {facing(snapshot, look)}."


NOW = Layer("now", "Learning now", _draw, _legend, _caption)
