"""The way that runs side by side go, by steps, for those who walk on it."""

from collections.abc import Sequence
from typing import Final, NamedTuple

from app.page.time.walk import Ground

RACE: Final = 0
"""The number of the one line that there is: all runs go along it, each with its own trials."""


class Steps(NamedTuple):
    """A course that knows steps alone: no trial is that of all runs."""

    end_step: int
    end_trial: int = 0

    def step_of_trial(self, trial: int) -> int:
        """The beginning: there is but one trial."""
        return 0

    def trial_of_step(self, step: int) -> int:
        """The one trial."""
        return 0


def ground_of(step: int, events: Sequence[int], pace: float) -> Ground:
    """What is known of the way.

    Args:
        step: steps that each run has made.
        events: steps at which something happened to one of them, ascending.
        pace: steps a second at which the past plays at the rate 1.
    """

    def course_of(line: int) -> Steps | None:
        return Steps(step) if line == RACE else None

    def events_of(line: int) -> Sequence[int]:
        return events

    return Ground(RACE, course_of, events_of, pace)
