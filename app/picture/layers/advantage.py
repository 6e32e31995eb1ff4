"""Advantage: how much more the best option is worth than the next best."""

from functools import partial
from typing import Final

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.amounts import amount_legend, draw_amount, fitted, least_difference
from app.picture.colours import STAKES
from app.picture.counted import counted_by
from app.picture.frames import in_frame
from app.picture.layer import Extras, Label, Lack, Layer, Over, Picture
from app.picture.look import Look
from app.picture.options import kind_of, lone_option
from app.picture.raster import Raster
from app.picture.shading import Ruler, equivalent_steps, mean_of
from app.picture.value_maps import VALUE_HEEDS, counted_of, reward_of
from app.words.numbers import of_any_size
from learners.learner_spec import LearnerSpec

_NO_TABLE: Final = Lack(
    "no table selects",
    "A rule selects here, and no table says what a hunt is worth by another choice; Cost of giving"
    " way has what it costs a skill.",
)
_LEAST_STEPS = 0.05
_NOTE_NORTH = 0.36
"""Where a note stands, as a share of the board's side north of the prey."""


def _best_two(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Best and second best along the last axis; minus infinity where there is none."""
    best = np.full(values.shape[:-1], -np.inf)
    second = best.copy()
    for option in range(values.shape[-1]):
        value = values[..., option]
        np.maximum(second, np.minimum(best, value), out=second)
        np.maximum(best, value, out=best)
    return best, second


def _advantages(snapshot: Snapshot, look: Look) -> np.ndarray:
    """What is lost by taking the next best option, ``(heading, distance, direction) float64``.

    In steps to capture, so many at most, as where the next best knows no way at all; NaN
    where not even the best does. On a linear scale the difference of the values, NaN where there
    are not two.
    """
    best, second = _best_two(snapshot.selection_q)
    two = np.isfinite(second)
    if look.scale == "linear":
        lost = np.subtract(best, second, out=np.full_like(best, np.nan), where=two)
        return np.where(lost < least_difference(snapshot), 0.0, lost)
    reward, gamma = reward_of(snapshot), snapshot.spec.learner.gamma
    steps = equivalent_steps(second, reward, gamma) - equivalent_steps(best, reward, gamma)
    most = counted_of(snapshot).most_lost
    lost = np.where(second > 0, np.minimum(steps, most), most)
    lost = np.where(lost < _LEAST_STEPS, 0.0, lost)
    return np.where(two & (best > 0), lost, np.nan)


def _ruler(snapshot: Snapshot, look: Look) -> Ruler:
    fixed = Ruler(0.0, counted_of(snapshot).most_lost, "root")
    if look.scale == "linear":
        fixed = Ruler(0.0, reward_of(snapshot))
    return fitted(_advantages(snapshot, look), fixed) if look.fitted else fixed


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    each = in_frame(_advantages(snapshot, look), snapshot, look)
    there = ~np.isnan(each)
    count = there.sum(axis=0)
    amount = mean_of(np.where(there, each, 0.0), count, np.nan)
    amount[2 * count < len(each)] = np.nan
    picture = draw_amount(amount, _ruler(snapshot, look), STAKES, look, raster)
    lone = lone_option(snapshot)
    if lone is None:
        return picture
    note = Label(f"{lone}: no choice yet", 0.0, _NOTE_NORTH * snapshot.spec.world.size)
    return picture._replace(within=lambda: Over(labels=(note,)))


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    kind, ruler = kind_of(snapshot), _ruler(snapshot, look)
    if look.scale == "linear":
        title = f"Value of the best {kind} less that of the next best"
        return amount_legend(snapshot, look, title, ruler, STAKES, of_any_size, "no difference")
    nouns = counted_of(snapshot).nouns
    title = f"{nouns.capitalize()} that are lost by taking the next best {kind}"
    most, blank = counted_of(snapshot).most_lost, "none, or no way to a capture is known"
    return amount_legend(snapshot, look, title, ruler, STAKES, partial(_steps, most), blank)


def _steps(most: float, steps: float) -> str:
    more = " or more" if steps >= most else ""
    return f"{steps:.2g}{more}"


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    lone = lone_option(snapshot)
    if lone is not None:
        return f"{lone}: there is nothing to choose from, so nothing to see."
    kind = kind_of(snapshot)
    return (
        f"Where the choice of {kind} matters: the stronger the colour, the more the next best one"
        " would cost."
    )


def _lacks(learner: LearnerSpec) -> Lack | None:
    return None if counted_by(learner) else _NO_TABLE


ADVANTAGE = Layer(
    "advantage",
    "Advantage",
    _draw,
    _legend,
    _caption,
    heeds=VALUE_HEEDS,
    lacks=_lacks,
)
