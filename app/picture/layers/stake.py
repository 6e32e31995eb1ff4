"""Cost of giving way: what it is worth to a skill that another makes the move."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.amounts import amount_legend, draw_amount, fitted
from app.picture.colours import STAKES
from app.picture.frames import in_frame
from app.picture.giving_way import W_LEARNING, costs, learned_w, stakes
from app.picture.layer import Extras, Lack, Layer, Picture
from app.picture.look import Look
from app.picture.options import option_names, option_shown
from app.picture.raster import Raster
from app.picture.shading import Ruler
from app.words.numbers import of_any_size
from learners.learner_spec import LearnerSpec

_LEAST = 0.01
"""Less than this share of what is at stake is nothing that anybody should look at."""


def _amount(snapshot: Snapshot, look: Look) -> np.ndarray:
    """``(heading, distance, direction) float64``, 0 where it is next to nothing."""
    skill, w_values = option_shown(snapshot, look), learned_w(snapshot)
    amount = costs(snapshot)[skill] if w_values is None else w_values[skill].astype(np.float64)
    return np.where(amount < _LEAST * _most(snapshot, look), 0.0, amount)


def _most(snapshot: Snapshot, look: Look) -> float:
    return float(stakes(snapshot)[option_shown(snapshot, look)]) or 1.0


def _ruler(snapshot: Snapshot, look: Look) -> Ruler:
    fixed = Ruler(0.0, _most(snapshot, look), "root")
    return fitted(_amount(snapshot, look), fixed) if look.fitted else fixed


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    mean = in_frame(_amount(snapshot, look), snapshot, look).mean(axis=0)
    return draw_amount(mean, _ruler(snapshot, look), STAKES, look, raster)


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    name = option_names(snapshot)[option_shown(snapshot, look)]
    title = f"What it costs {name} that the move is not its own"
    if learned_w(snapshot) is not None:
        title = f"W of {name}: what it has learned that losing costs it"
    ruler = _ruler(snapshot, look)
    return amount_legend(snapshot, look, title, ruler, STAKES, of_any_size, "nothing")


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    name = option_names(snapshot)[option_shown(snapshot, look)]
    there = in_frame(_amount(snapshot, look), snapshot, look).any()
    if learned_w(snapshot) is not None:
        if not there:
            return f"What {name} has learned that it costs to let others move: nothing so far."
        return (
            f"What {name} has learned that it costs to let others move; the skill of the largest W"
            " moves."
        )
    if not there:
        return f"Where {name} gives way to another skill, and what that costs: nowhere now."
    return (
        f"Where {name} gives way to another skill: the stronger, the more of its own reward that"
        " costs."
    )


def _lacks(learner: LearnerSpec) -> Lack | None:
    if learner.selection != "learned":
        return None
    return Lack(
        "no rule selects",
        "Nobody gives way here: a table says what each choice is worth to the hunt. Only where a"
        " rule selects do skills set reward against reward.",
    )


def _title(learner: LearnerSpec) -> str | None:
    return "W values" if learner.selection == W_LEARNING else None


STAKE = Layer(
    "stake",
    "Cost of giving way",
    _draw,
    _legend,
    _caption,
    about="skill",
    lacks=_lacks,
    titled=_title,
)
