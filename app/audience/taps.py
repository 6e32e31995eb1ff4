"""What somebody may do with a learner of their own: one struct a message, with bounds."""

from typing import Annotated, Final

import msgspec
from msgspec import Meta

SPEEDS: Final = (20.0, 200.0, 2_000.0, 20_000.0, 100_000.0)
"""Steps a second, by level: from hunts that can be seen to a whole run in a minute. There is none
above, since all seats of a class share what the presenter's learner leaves."""

_Skill = Annotated[str, Meta(min_length=1, max_length=64)]


class _Tap(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="do"):
    """Something that is done; tagged by what that is."""


class PlayOwn(_Tap, frozen=True, tag="own_play"):
    """Learn on, or stand still."""

    on: bool


class StepOwn(_Tap, frozen=True, tag="own_step"):
    """Make one step, and stand still."""


class TrialOwn(_Tap, frozen=True, tag="own_trial"):
    """Go to the start of the next trial, and stand still."""


class SpeedOwn(_Tap, frozen=True, tag="own_speed"):
    """Learn so fast."""

    level: Annotated[int, Meta(ge=0, le=len(SPEEDS) - 1)]
    """Of ``SPEEDS``."""


class AddOwn(_Tap, frozen=True, tag="own_add"):
    """Let a skill join."""

    skill: _Skill


class ExploreOwn(_Tap, frozen=True, tag="own_explore"):
    """Have a skill explored, or no longer."""

    skill: _Skill
    on: bool


class FreezeOwn(_Tap, frozen=True, tag="own_freeze"):
    """Hold the selection still, or let it learn."""

    on: bool


class AgainOwn(_Tap, frozen=True, tag="own_again"):
    """Begin again, with a learner that knows nothing."""


Tap = PlayOwn | StepOwn | TrialOwn | SpeedOwn | AddOwn | ExploreOwn | FreezeOwn | AgainOwn
"""All of them."""
