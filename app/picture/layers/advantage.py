"""Advantage: how much more the best option is worth than the next best."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.amounts import amount_legend, differences, draw_amount, fitted, least_difference
from app.picture.frames import in_frame
from app.picture.layer import Extras, Layer, Picture
from app.picture.look import Look
from app.picture.options import kind_of, lone_option
from app.picture.raster import Raster
from app.picture.shading import Ruler
from app.picture.value_maps import reward_of


def _advantages(values: np.ndarray) -> np.ndarray:
    """Best minus second best along the last axis, float64; 0 where there are not two."""
    best = np.full(values.shape[:-1], -np.inf)
    second = best.copy()
    for option in range(values.shape[-1]):
        value = values[..., option]
        np.maximum(second, np.minimum(best, value), out=second)
        np.maximum(best, value, out=best)
    return np.subtract(best, second, out=np.zeros_like(best), where=np.isfinite(second))


def _ruler(snapshot: Snapshot, look: Look) -> Ruler:
    is_linear = look.scale == "linear"
    fixed = Ruler(0.0, reward_of(snapshot)) if is_linear else differences(snapshot)
    if not look.fitted:
        return fixed
    return fitted(_advantages(snapshot.selection_q), fixed, least_difference(snapshot))


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    values = in_frame(snapshot.selection_q, snapshot, look)
    amount = _advantages(values).mean(axis=0)
    amount[amount < least_difference(snapshot)] = 0.0
    return draw_amount(amount, _ruler(snapshot, look), look, raster)


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    title = f"Value of the best {kind_of(snapshot)} less that of the next"
    ruler = _ruler(snapshot, look)
    return amount_legend(snapshot, look, title, ruler, "no difference")


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    lone = lone_option(snapshot)
    if lone is not None:
        return f"{lone}: there is nothing to choose from, so nothing to see."
    kind = kind_of(snapshot)
    return f"Where the choice matters: how much more the best {kind} is worth than the next best."


ADVANTAGE = Layer("advantage", "Advantage", _draw, _legend, _caption)
