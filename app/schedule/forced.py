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


def forced_now(snapshot: Snapshot) -> list[Forced]:
    """The forced exploration of the running trial, the newest first; empty where there is none."""
    return [Forced(*episode) for episode in snapshot.control.running(snapshot.trial)]
