"""Lines that are as simple as can be, for those who walk on them."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from app.live import snapshot
from app.live.places import Place
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page.time.walk import Ground
from learners.run import Run


@dataclass
class Even:
    """A line all of whose trials have as many steps."""

    end_step: int = 10_000
    steps: int = 100
    """Of a trial."""

    @property
    def end_trial(self) -> int:
        return self.end_step // self.steps

    def step_of_trial(self, trial: int) -> int:
        return trial * self.steps

    def trial_of_step(self, step: int) -> int:
        return step // self.steps


LIVE, BRANCH = 0, 7


def ground(
    lines: Mapping[int, Even] | None = None, events: Sequence[int] = (), pace: float = 1_000.0
) -> Ground:
    """A live line of ten thousand steps and a branch of half as many, with events on both."""
    known = {LIVE: Even(), BRANCH: Even(5_000)} if lines is None else lines

    def events_of(line: int) -> Sequence[int]:
        return events

    return Ground(LIVE, known.get, events_of, pace)


class Makes:
    """Who makes moments when a test says so."""

    def __init__(self) -> None:
        self.wishes: dict[Hashable, Place] = {}
        self.made: dict[Hashable, Snapshot] = {}

    def want(self, viewer: Hashable, place: Place) -> None:
        self.wishes[viewer] = place

    def found(self, viewer: Hashable) -> Snapshot | None:
        return self.made.get(viewer)

    def fault(self, viewer: Hashable) -> str | None:
        return None

    def forget(self, viewer: Hashable) -> None:
        self.wishes.pop(viewer, None)
        self.made.pop(viewer, None)

    def make(self, viewer: Hashable, run: Run) -> Snapshot:
        """Make what a viewer wishes, of a run that stands there."""
        place = self.wishes[viewer]
        assert run.step == place.step
        self.made[viewer] = shot = snapshot.take(run, "timed", place.line)
        return shot


def status_at(run: Run, number: int = LIVE, **changes: Any) -> Status:
    """How a session stands whose live run is this one, playing at a set speed."""
    return Status(
        snapshot=snapshot.take(run, "timed", number),
        playing=True,
        finished=False,
        exhausted=False,
        preparing=False,
        speed=1_000.0,
        steps_per_s=1_000.0,
        error=None,
        answered=0,
        **changes,
    )
