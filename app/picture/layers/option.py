"""Value of one option: what each place is worth if that one is taken next."""

from typing import Final

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.counted import counted_by
from app.picture.frames import UNTURNED, folds, in_frame
from app.picture.layer import Extras, Lack, Layer, Picture
from app.picture.look import Look
from app.picture.options import has_moves, option_names, option_shown, present
from app.picture.raster import Raster
from app.picture.value_maps import (
    VALUE_HEEDS,
    or_zero,
    value_legend,
    value_picture,
    value_shading,
)
from learners.learner_spec import LearnerSpec
from learners.names import COMMANDS
from sim.spec import N_HEADINGS

_NO_TABLE: Final = Lack(
    "no table selects",
    "A rule selects here, and no table says what a hunt is worth by one choice or the other;"
    " Skill's own value has what each expects.",
)


def _values(snapshot: Snapshot, look: Look) -> np.ndarray:
    """Values of the option that is shown, ``(heading, distance, direction)``, all headings.

    As they are; but a move is one of the picture, so that its values are those of another move
    of the world for each heading of a folded picture.
    """
    option, values = option_shown(snapshot, look), snapshot.selection_q
    if folds(look) and has_moves(snapshot):
        return or_zero(values[np.arange(N_HEADINGS), ..., UNTURNED[:, option]])
    return or_zero(values[..., option])


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    values = _values(snapshot, look)
    shading = value_shading(snapshot, look, values)
    shown = in_frame(values, snapshot, look)
    return value_picture(shown, shading, snapshot, look, raster)


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    name = option_names(snapshot)[option_shown(snapshot, look)]
    shading = value_shading(snapshot, look, _values(snapshot, look))
    return value_legend(snapshot, look, f"of {name}", shading)


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    option = option_shown(snapshot, look)
    name = option_names(snapshot)[option]
    if option not in present(snapshot):
        return f"{name} is not among the skills now, so it has no value anywhere."
    if has_moves(snapshot):
        frame = " (directions as drawn)" if folds(look) else ""
        return f"What a place is worth if the next move is {name}{frame}, and the best after that."
    if snapshot.spec.learner.options == COMMANDS:
        return f"What a place is worth if {name} is commanded there, and the best command after it."
    if snapshot.spec.learner.held is not None:
        return f"What a place is worth if {name} is chosen there and kept, and the best after that."
    return f"What a place is worth if {name} makes the next move, and the best skill those after."


def _lacks(learner: LearnerSpec) -> Lack | None:
    return None if counted_by(learner) else _NO_TABLE


OPTION = Layer(
    "option",
    "Value of one option",
    _draw,
    _legend,
    _caption,
    about="option",
    heeds=VALUE_HEEDS,
    lacks=_lacks,
)
