"""What can be asked of a learner, by its schedule or by hand: both take the same path.

A command is a value. It takes effect before the next step; a journal of (step, command) pairs
with the preset and the seed replays a run bit for bit.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Introduce:
    """Let a skill join and freeze the selection for some trials (sections 3.3.1 and 3.3.2)."""

    skill: str
    freeze_trials: int


@dataclass(frozen=True)
class Explore:
    """Take a skill with a given probability at each step, for some trials (section 3.3.3)."""

    skill: str
    duration_trials: int
    probability: float


@dataclass(frozen=True)
class StopExploring:
    """End the exploration of a skill now."""

    skill: str


@dataclass(frozen=True)
class FreezeSelection:
    """Hold the selection table still, or let it learn again."""

    frozen: bool


@dataclass(frozen=True)
class FreezeSkills:
    """Hold the tables of all skills still, or let them learn again."""

    frozen: bool


@dataclass(frozen=True)
class FollowSchedule:
    """Let the timers of the schedule act from here on, or not.

    What was due while the schedule was off stays undone.
    """

    on: bool


Command = Introduce | Explore | StopExploring | FreezeSelection | FreezeSkills | FollowSchedule


class CommandError(ValueError):
    """A command that cannot be carried out now; the message says why. Nothing has changed."""
