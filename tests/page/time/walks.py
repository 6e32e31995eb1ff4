"""Lines that are as simple as can be, for those who walk on them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from app.page.time.walk import Ground


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
