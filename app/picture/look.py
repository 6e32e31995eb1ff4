"""How one browser wants to see the board: a value, made from its widgets and nothing else."""

from typing import NamedTuple

from app.picture.shading import Scale
from app.picture.theme import LIGHT, Theme

FOLDED = -1
"""Frame: the mean over the eight headings, each turned so that the prey faces east."""
OF_TRIAL = -2
"""Frame: the heading of the running trial, as the world is."""
ALL = -3
"""Frame: each heading by itself, side by side."""


class Look(NamedTuple):
    """One way of drawing a snapshot. Hashable, so that browsers which agree share the work."""

    theme: Theme = LIGHT
    layer: str = "value"
    """Key of a layer."""
    option: int = 0
    """Option, or skill, that the layers about one of them show."""
    frame: int = FOLDED
    """``FOLDED``, ``OF_TRIAL``, ``ALL``, or a heading 0...7."""
    scale: Scale = "steps"
    fitted: bool = False
    """Whether the limits of colours are fitted to what is there, and not fixed."""
    flight: bool = False
    """Whether maps of value hatch the places that expect flight."""
    field: bool = True
    grid: bool = False
    sensors: bool = False
    """Rings and sectors of the predator's sensors."""
    start_zone: bool = False
    trail: bool = True
    paths: bool = False
    """Paths of the last trials, by how they ended."""
    hunts: bool = True
    """Whether the learner's own hunts are drawn, as they are unless another one is watched."""


def heading_shown(look: Look, trial_heading: int) -> int:
    """The way the prey faces in the picture: east where the map is folded.

    Where all headings are side by side, it is that of the trial that counts.
    """
    if look.frame == FOLDED:
        return 0
    return look.frame if look.frame >= 0 else trial_heading
