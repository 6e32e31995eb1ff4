"""What the learner is made to do now: forced exploration, by the schedule or by hand."""

from typing import NamedTuple

from app.live.snapshot import Snapshot


class Forced(NamedTuple):
    """A skill that the learner is made to take for some trials."""

    skill: str
    probability: float
    """That a step takes it; of several at once, in the order of the list, that of those steps
    which the ones before leave."""
    until_trial: int
    """First trial after it."""
    value_at_most: float | None
    """Only in states in which no other present skill is worth more; None if it is in all."""


def forced_now(snapshot: Snapshot) -> list[Forced]:
    """The forced exploration of the running trial, the newest first; empty where there is none."""
    return [Forced(*episode) for episode in snapshot.control.running(snapshot.trial)]


def forced_until(snapshot: Snapshot) -> int:
    """The first trial after the forced exploration that ended last, 0 if none is known.

    It is known until the next command is given, which puts away what is over.
    """
    ends = (episode.until_trial for episode in snapshot.control.episodes)
    return max((end for end in ends if end <= snapshot.trial), default=0)


def where_in_short(value_at_most: float | None) -> str:
    """Where an exploration acts, to be said after how often; empty if it is everywhere."""
    return "" if value_at_most is None else f" where worth at most {value_at_most:g}"
