"""What the values of a learner count: in what it is told how far off a capture is.

A value falls by the discount with each step in most learners; with each command in one that has a
manager, and with each choice where a choice that is held is discounted once. Where a rule selects,
values are what skills expect of their own rewards, and say nothing of how far a capture is.
"""

from typing import Final, NamedTuple

from learners.learner_spec import LearnerSpec
from learners.names import COMMANDS


class Counted(NamedTuple):
    """What lies between a place and a capture, as far as its value says."""

    noun: str
    """One of them."""
    farthest: float
    """So many are the far end of the scale of colours."""
    lines: tuple[float, float, float]
    """At so many of them a map of values has a line."""
    most_lost: float
    """Beyond so many of them a choice is the wrong one, and by how much does not matter."""
    most_changed: float
    """Beyond so many of them it does not matter by how much a capture has come nearer."""

    @property
    def nouns(self) -> str:
        """Several of them."""
        return f"{self.noun}s"


STEPS_COUNTED: Final = Counted("step", 200.0, (20.0, 50.0, 100.0), 20.0, 50.0)
CHOICES_COUNTED: Final = Counted("choice", 50.0, (5.0, 10.0, 20.0), 10.0, 20.0)
COMMANDS_COUNTED: Final = Counted("command", 20.0, (2.0, 5.0, 10.0), 10.0, 10.0)


def counted_by(learner: LearnerSpec) -> Counted | None:
    """What the values of a learner count; None if they are no distance from a capture."""
    if learner.selection != "learned":
        return None
    if learner.options == COMMANDS:
        return COMMANDS_COUNTED
    if learner.held is not None and learner.held.discount == "choice":
        return CHOICES_COUNTED
    return STEPS_COUNTED
