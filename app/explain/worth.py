"""What a place is worth in words: in the unit of the colours first, and as a value."""

import math
from typing import NamedTuple

import numpy as np

from app.live.snapshot import Snapshot
from app.picture.shading import FARTHEST_STEPS
from app.picture.value_maps import reward_of
from app.words.numbers import NONE, significant
from learners.measures import equivalent_distance


class Unit(NamedTuple):
    """What turns a value into steps from a certain capture."""

    reward: float
    """Of a capture."""
    gamma: float

    @classmethod
    def of(cls, snapshot: Snapshot) -> "Unit":
        """That of the colours at a moment."""
        return cls(reward_of(snapshot), snapshot.spec.learner.gamma)

    def steps(self, value: float) -> float:
        """Steps from a certain capture that is worth as much; NaN where there is none."""
        return float(equivalent_distance(np.array([value]), self.reward, self.gamma)[0])

    def steps_in_words(self, value: float) -> str:
        """The same, for a table."""
        steps = self.steps(value)
        if math.isnan(steps):
            return NONE
        return f"{steps:.0f}" if steps <= FARTHEST_STEPS else f"> {FARTHEST_STEPS:.0f}"

    def in_words(self, value: float) -> str:
        """How good a place of this value is."""
        said = f"(value {significant(value)})"
        if value < 0:
            return f"the predator expects to be seen {said}"
        if value == 0:
            return "nothing is known yet (value 0)"
        steps = self.steps_in_words(value)
        unit = "step" if steps == "1" else "steps"
        about = "more than " if steps.startswith("> ") else "about "
        return f"{about}{steps.removeprefix('> ')} {unit} from a capture {said}"
