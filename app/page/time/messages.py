"""What the frame of the time bar sends: one struct a message, with bounds.

Whatever fits none of these (of another kind, with a field too many, a number or a text out of
bounds) comes from no hand on our bar, and is dropped by whoever decodes :data:`FromFrame`.
"""

from typing import Annotated, Final, Literal

import msgspec
from msgspec import Meta

from app.analysis.estimates import Axis
from app.documents.lesson_questions import HANDLES
from app.live.lines import MOST_CHARACTERS
from app.page.time.walk import Unit

_MOST: Final = 2**53
"""Numbers up to here are whole in a browser."""

Count = Annotated[int, Meta(ge=0, le=_MOST)]
"""A number of steps or trials, or that of a line or a mark."""
Difference = Annotated[int, Meta(ge=-_MOST, le=_MOST)]
Text = Annotated[str, Meta(min_length=1, max_length=MOST_CHARACTERS)]
"""An id, or the text of a mark."""
Share = Annotated[float, Meta(ge=0.0, le=1.0)]
"""A probability."""
Rate = Annotated[float, Meta(ge=0.0, le=1e6)]
Reward = Annotated[float, Meta(ge=-1e6, le=1e6)]
"""Of a trial."""


class _Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="do"):
    """Something that a hand did; tagged by what is to be done."""


# --- Where to look -------------------------------------------------------------------------------


class Seek(_Message, frozen=True, tag="seek"):
    """Look at the moment at which so many steps of the line that is looked at are made."""

    step: Count


class SeekTrial(_Message, frozen=True, tag="seek_trial"):
    """Look at the beginning of a trial."""

    trial: Count


class Live(_Message, frozen=True, tag="live"):
    """Look at what happens now."""


class Look(_Message, frozen=True, tag="look"):
    """Look at another line."""

    line: Count


# --- Going through the past ----------------------------------------------------------------------


class Play(_Message, frozen=True, tag="play"):
    """Play what is looked at, forwards (1) or backwards (-1)."""

    direction: Literal[-1, 1]


class Pause(_Message, frozen=True, tag="pause"):
    """Stand still."""


class SetRate(_Message, frozen=True, tag="rate"):
    """How fast to play: one of the rates that the moment named."""

    rate: Rate


class GoBy(_Message, frozen=True, tag="by"):
    """Go on, or back if it is below 0, by so many steps, trials or events."""

    unit: Unit
    n: Difference


class SetLoop(_Message, frozen=True, tag="loop"):
    """Whether to play what lies between A and B again and again."""

    on: bool


class SetA(_Message, frozen=True, tag="set_a"):
    """The moment that is looked at is A from now on."""


class SetStops(_Message, frozen=True, tag="stops"):
    """Whether playing stops at events."""

    on: bool


class SetHolds(_Message, frozen=True, tag="holds"):
    """Whether the learner stands still while this browser looks at the past."""

    on: bool


class SetUnit(_Message, frozen=True, tag="unit"):
    """What the axis is of."""

    unit: Axis


# --- The schedule --------------------------------------------------------------------------------


class EditBlock(_Message, frozen=True, tag="edit"):
    """Let a block begin, last or weigh otherwise; what is None stays."""

    id: Text
    at: Count | None = None
    """Trial in which it begins."""
    trials: Count | None = None
    """How long it lasts, or, of an introduction, the freeze after it."""
    probability: Share | None = None


class AddExploration(_Message, frozen=True, tag="add"):
    """Explore a skill from a trial on."""

    skill: Text
    at: Count
    trials: Count
    probability: Share


class DeleteBlock(_Message, frozen=True, tag="delete"):
    """Take an exploration out of the plan."""

    id: Text


class ChooseBlock(_Message, frozen=True, tag="choose"):
    """Show this block in the fields of the plan."""

    id: Text


# --- Marks and lines -----------------------------------------------------------------------------


class AddMark(_Message, frozen=True, tag="mark"):
    """Give the moment a line of text at which somebody began to write that."""

    text: Text
    line: Count
    step: Count


class RemoveMark(_Message, frozen=True, tag="unmark"):
    """Take a mark away."""

    number: Count


class NameLine(_Message, frozen=True, tag="name"):
    """Give a line a name; by none it is called as it was at first."""

    line: Count
    name: Annotated[str, Meta(max_length=MOST_CHARACTERS)]


class DeleteLine(_Message, frozen=True, tag="delete_line"):
    """Take a branch out of the tree."""

    line: Count


class BringBack(_Message, frozen=True, tag="bring_back"):
    """Put back a branch that was deleted."""

    line: Count


class MakeLive(_Message, frozen=True, tag="make_live"):
    """Let a branch go on as the live run."""

    line: Count


class TryOverSeeds(_Message, frozen=True, tag="test"):
    """Run what a line does over many seeds."""

    line: Count


# --- What is asked on the bar ---------------------------------------------------------------------


class Guess(_Message, frozen=True, tag="guess"):
    """It will be at this trial."""

    trial: Count


class Sketch(_Message, frozen=True, tag="sketch"):
    """The curve will go like this: trials and rewards of the handles, from left to right."""

    points: Annotated[
        tuple[tuple[Count, Reward], ...], Meta(min_length=HANDLES, max_length=HANDLES)
    ]


FromFrame = (
    Seek
    | SeekTrial
    | Live
    | Look
    | Play
    | Pause
    | SetRate
    | GoBy
    | SetLoop
    | SetA
    | SetStops
    | SetHolds
    | SetUnit
    | EditBlock
    | AddExploration
    | DeleteBlock
    | ChooseBlock
    | AddMark
    | RemoveMark
    | NameLine
    | DeleteLine
    | BringBack
    | MakeLive
    | TryOverSeeds
    | Guess
    | Sketch
)
"""All of them."""
