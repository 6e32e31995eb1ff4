"""What is written down of a session: with these records, in their order, all of it is made again.

Runs are meant by their numbers (:class:`app.live.places.Place`).
"""

from dataclasses import dataclass
from typing import Final, Protocol

from app.live.story import Act, LeftLesson, TookLesson
from learners.commands import Command
from learners.spec import RunSpec

MOST_COMMANDS: Final = 1_000
"""By which a run branches off."""


@dataclass(frozen=True)
class Began:
    """A run began, and is the live one from here on."""

    run: int
    preset: str
    """As shown."""
    spec: RunSpec
    seed: int
    is_own: bool = True
    """Whether it began here, and was not made again from the results of an experiment."""


@dataclass(frozen=True)
class Gave:
    """A command by hand, and the step before which it took effect."""

    run: int
    step: int
    command: Command


@dataclass(frozen=True)
class Branched:
    """A run branched off another one at a step, by a command given there."""

    run: int
    parent: int
    step: int
    commands: tuple[Command, ...]
    instead_of: int | None = None
    """A branch whose place it takes: more was done at the moment at which that began."""


@dataclass(frozen=True)
class WentLive:
    """A run became the live one, at a step; where it is None, where it stood."""

    run: int
    step: int | None = None


@dataclass(frozen=True)
class Stood:
    """How far the live run had come, and the digest of its tables there."""

    run: int
    step: int
    trial: int
    digest: str
    until_trial: int
    """Where it is to stand still by itself."""


@dataclass(frozen=True)
class NamedLine:
    """A branch was given a name."""

    run: int
    name: str


@dataclass(frozen=True)
class Deleted:
    """A branch was taken out of the tree."""

    run: int


@dataclass(frozen=True)
class BroughtBack:
    """A branch that had been deleted was put back."""

    run: int


@dataclass(frozen=True)
class Marked:
    """A moment was given a line of text."""

    number: int
    run: int
    step: int
    trial: int
    text: str


@dataclass(frozen=True)
class Unmarked:
    """A mark was taken away."""

    number: int


Record = (
    Began
    | Gave
    | Branched
    | WentLive
    | Stood
    | NamedLine
    | Deleted
    | BroughtBack
    | Marked
    | Unmarked
    | TookLesson
    | LeftLesson
    | Act
)


class Journal(Protocol):
    """Where records are written down. It never raises, and what it cannot write it says."""

    @property
    def fault(self) -> str | None:
        """Why what is done cannot be written down; None while it is."""

    def note(self, record: Record) -> None:
        """Write down what is about to take effect; once it returns, it is there."""

    def stood(self, record: Stood, at_rest: bool = False) -> None:
        """Write down how far the live run is; ``at_rest`` if it goes no farther for now."""

    def close(self) -> None:
        """Write down what waits, if that can be; nothing is written after that."""
