"""What the frame with runs side by side sends: one struct a message, with bounds.

What the time bar sends as well is as there. Whatever fits none of these comes from no hand on our
page, and is dropped by whoever decodes :data:`FromSide`.
"""

from typing import Annotated, Final, Literal

import msgspec
from msgspec import Meta

from app.live.race import FEWEST, MOST
from app.page.time.messages import Count, Difference, Live, Pause, Play, Seek, SetRate
from sim.rng import MAX_SEED

_MOST_CHARACTERS: Final = 200
_MOST_CELLS: Final = 10_000

Place = Annotated[int, Meta(ge=0, lt=MOST)]
"""One of the runs, by its place among them."""
Name = Annotated[str, Meta(min_length=1, max_length=_MOST_CHARACTERS)]
Seed = Annotated[int, Meta(ge=0, le=MAX_SEED)]
Cell = Annotated[int, Meta(ge=-_MOST_CELLS, le=_MOST_CELLS)]
"""East or north of the prey, in cells."""


class _Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="do"):
    """Something that a hand did; tagged by what is to be done."""


# --- Which runs ----------------------------------------------------------------------------------


class Chosen(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A run that is to stand there: a line of the tree, or a preset with a seed."""

    line: Count | None = None
    preset: Name | None = None
    seed: Seed | None = None


class Start(_Message, frozen=True, tag="start"):
    """Let these runs go side by side, each from its beginning."""

    runs: Annotated[tuple[Chosen, ...], Meta(min_length=FEWEST, max_length=MOST)]


class StartFour(_Message, frozen=True, tag="four"):
    """Race the thesis's four learners."""


class End(_Message, frozen=True, tag="end"):
    """Put these runs away, for all browsers."""


class Close(_Message, frozen=True, tag="close"):
    """Look at one board again, in this browser."""


# --- How they go on ------------------------------------------------------------------------------


class StepOnce(_Message, frozen=True, tag="step"):
    """Let each run make one step, and stand still."""


class Faster(_Message, frozen=True, tag="faster"):
    """Let the runs be faster by so many tenths of the slider of speeds, or slower below 0."""

    by: Annotated[int, Meta(ge=-70, le=70)]


class SetSpeed(_Message, frozen=True, tag="speed"):
    """Let the runs make so many steps a second, each; 0 is as fast as it goes."""

    steps_per_s: Annotated[float, Meta(ge=0.0, le=1e7)]


# --- Where to look -------------------------------------------------------------------------------


class GoBy(_Message, frozen=True, tag="by"):
    """Go on, or back if it is below 0, by so many steps or events."""

    unit: Literal["steps", "events"]
    n: Difference


# --- What to compare -----------------------------------------------------------------------------


class Compare(_Message, frozen=True, tag="compare"):
    """Compare two of the runs; with ``shown`` there is a map of what is different."""

    one: Place
    other: Place
    shown: bool


class Point(_Message, frozen=True, tag="point"):
    """Read a cell in all runs, by where it is on a board of one heading or of all as one."""

    east: Cell
    north: Cell
    heading: Annotated[int, Meta(ge=0, le=7)] | None = None
    """Of a board with all headings side by side, the one that is pointed at."""


class Unpoint(_Message, frozen=True, tag="unpoint"):
    """Read no cell any more."""


FromSide = (
    Start
    | StartFour
    | End
    | Close
    | Play
    | Pause
    | StepOnce
    | Faster
    | SetSpeed
    | Seek
    | Live
    | GoBy
    | SetRate
    | Compare
    | Point
    | Unpoint
)
"""All of them."""
