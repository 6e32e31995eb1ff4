"""What can be asked of a learner, by its schedule or by hand: both take the same path.

A command is a value. It takes effect before the next step; a journal of (step, command) pairs
with the preset and the seed replays a run bit for bit.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from learners.names import Script
from learners.schedule_spec import ScheduleSpec
from learners.skill_spec import SkillWeights


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
    value_at_most: float | None = None
    """Only in states in which no other present skill is worth more than this (section 5.2)."""


@dataclass(frozen=True)
class StopExploring:
    """End the exploration of a skill now."""

    skill: str


@dataclass(frozen=True)
class Teach:
    """Let a script choose the skill for some trials, while the learner learns (section 3.2)."""

    script: Script
    duration_trials: int


@dataclass(frozen=True)
class StopTeaching:
    """Let the learner choose for itself again, from now on."""


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


@dataclass(frozen=True)
class DefineSkill:
    """Name a skill whose local reward is a weighted sum of the four skills' rewards."""

    skill: str
    weights: SkillWeights


@dataclass(frozen=True)
class Remove:
    """Take a skill out of the repertoire; what the selection knew of it is put aside."""

    skill: str


@dataclass(frozen=True)
class SetParameter:
    """Change a number of the preset from here on, by its dotted key.

    ``learners.parameters.parameters_of`` says which may.
    """

    key: str
    value: float


@dataclass(frozen=True)
class SetSchedule:
    """Put another plan in the place of the schedule; what is past must stay as it was."""

    schedule: ScheduleSpec


@dataclass(frozen=True)
class Undo:
    """Take back a command given by hand, by its number in the run's history.

    What commands have set is then as if it had not been given; what was learned meanwhile stays,
    and what the schedule would have done meanwhile is not made up for. Refused where what the
    command made has ended since.
    """

    number: int


Command = (
    Introduce
    | Explore
    | StopExploring
    | Teach
    | StopTeaching
    | FreezeSelection
    | FreezeSkills
    | FollowSchedule
    | DefineSkill
    | Remove
    | SetParameter
    | SetSchedule
    | Undo
)


Author = Literal["schedule", "trigger", "hand"]
"""Who gives a command; a trigger is the rule by which a skill joins."""


@dataclass(frozen=True)
class Event:
    """A command that was carried out."""

    number: int
    """Its place in the history."""
    step: int
    """Steps made before it."""
    trial: int
    trial_step: int
    """Steps made before it in its trial."""
    command: Command
    author: Author
    cause: int | None = None
    """Number of the event because of which the schedule gave it, and with which it is undone."""
    undone: bool = False
    taken_out: np.ndarray | None = field(default=None, compare=False, repr=False)
    """(state,) float32: values of the skill that left the selection table with it, if one did."""


class CommandError(ValueError):
    """A command that cannot be carried out now; the message says why. Nothing has changed."""
