"""What a place is worth in words: in the unit of the colours first, and as a value."""

import math
from typing import NamedTuple

import numpy as np

from app.live.snapshot import Snapshot
from app.picture.counted import counted_by
from app.picture.shading import FARTHEST_STEPS
from app.picture.value_maps import reward_of
from app.words.numbers import NONE, significant
from learners.measures import equivalent_distance


class Unit(NamedTuple):
    """What turns a value into steps from a certain capture."""

    reward: float
    """Of a capture."""
    gamma: float
    noun: str = "step"
    """What is counted on the way to a capture."""
    counts: bool = True
    """Whether anything is: where a rule selects, values are what skills expect for themselves."""

    @classmethod
    def of(cls, snapshot: Snapshot) -> "Unit":
        """That of the colours at a moment."""
        learner = snapshot.spec.learner
        counted = counted_by(learner)
        noun = "step" if counted is None else counted.noun
        return cls(reward_of(snapshot), learner.gamma, noun, counted is not None)

    def steps(self, value: float) -> float:
        """Steps from a certain capture that is worth as much; NaN where there is none."""
        return float(equivalent_distance(np.array([value]), self.reward, self.gamma)[0])

    def steps_in_words(self, value: float) -> str:
        """The same, for a table."""
        if not self.counts:
            return NONE
        steps = self.steps(value)
        if math.isnan(steps):
            return NONE
        return f"{steps:.0f}" if steps <= FARTHEST_STEPS else f"> {FARTHEST_STEPS:.0f}"

    def in_words(self, value: float) -> str:
        """How good a place of this value is."""
        if not self.counts:
            if value == 0:
                return "no skill expects anything here"
            return f"the happiest skill expects {significant(value)} of its own reward"
        said = f"(value {significant(value)})"
        if value < 0:
            return f"the predator expects to be seen {said}"
        if value == 0:
            return "nothing is known yet (value 0)"
        steps = self.steps_in_words(value)
        unit = self.noun if steps == "1" else f"{self.noun}s"
        about = "more than " if steps.startswith("> ") else "about "
        return f"{about}{steps.removeprefix('> ')} {unit} from a capture {said}"
