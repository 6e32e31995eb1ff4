"""The layers: all that the board can show, one module each."""

from app.picture.acting import showing_where
from app.picture.layer import Layer
from app.picture.layers.advantage import ADVANTAGE
from app.picture.layers.change import CHANGE
from app.picture.layers.chosen import CHOSEN
from app.picture.layers.flow import FLOW
from app.picture.layers.now import NOW
from app.picture.layers.option import OPTION
from app.picture.layers.reach import REACH
from app.picture.layers.skill import SKILL
from app.picture.layers.stake import STAKE
from app.picture.layers.success import SUCCESS
from app.picture.layers.traces import ELIGIBLE
from app.picture.layers.value import VALUE
from app.picture.layers.visits import VISITS
from app.picture.reasons import reasoned

_ACTING = tuple(map(showing_where, (VALUE, OPTION, CHOSEN, ADVANTAGE, VISITS, REACH, NOW)))
"""Layers of what the learner knows now, and does."""
_IN_ORDER = (*_ACTING, SUCCESS, SKILL, FLOW, CHANGE, STAKE, ELIGIBLE)
"""The first ten have the hotkeys 1...9 and 0."""

LAYERS: dict[str, Layer] = {layer.key: reasoned(layer) for layer in _IN_ORDER}
"""By key, in the order of the list in the page."""
