"""Moments of a session, and the lines that they lie on.

A session is a tree of runs. Each is a line: the one that is live, and branches, which begin at a
moment of another line and go their own way from there by what was done at it. A line is told from
others by its number, which is the ``generation`` of its snapshots.
"""

from dataclasses import dataclass
from typing import NamedTuple


class Place(NamedTuple):
    """A moment: so many steps of a line are made, and all that was given by then has been done."""

    line: int
    step: int


@dataclass(frozen=True)
class Mark:
    """A moment that somebody gave a line of text."""

    number: int
    """By which it is told from others."""
    place: Place
    trial: int
    text: str


@dataclass(frozen=True)
class LineSeen:
    """What is known of a line when a status is published."""

    number: int
    parent: int | None
    """The line that it branched off; None for one that began by itself."""
    fork_step: int
    """Steps made when it branched off, 0 for one that began by itself."""
    fork_trial: int
    name: str
    until_step: int
    """Steps of it that are known."""
    until_trial: int
    reward: float
    """Mean per trial over the last trials of what is known; NaN before the first has ended."""
    digest: str
    """Of its tables where what is known of it ends; "" while that goes on."""
    is_live: bool
    is_growing: bool = False
    """Whether it is being made up to where the live run is."""


class Behind(NamedTuple):
    """That a status shows a moment of the past, or of a branch, and not of now."""

    branch: str
    """Name of the line that it is on; "" for the live run's own past."""
    trials: int
    """By so many it is behind the live run; below 0 if it is ahead of it."""
    steps: int
