"""The numbers that the table of results holds for each run: their columns, names and units."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from learners.measures import FINAL_TRIALS


def final_trials(fewest: int, most: int) -> str:
    """Which trials are a run's final ones, in words.

    Args:
        fewest: trials that the shortest of the runs can have.
        most: trials that the longest one can have.
    """
    if fewest >= FINAL_TRIALS:
        return f"last {FINAL_TRIALS:,} trials"
    if most > FINAL_TRIALS:
        return f"last {FINAL_TRIALS:,} trials, or all of fewer"
    return f"all {most:,} trials" if fewest == most else f"all trials, at most {most:,}"


_FINAL = final_trials(FINAL_TRIALS, FINAL_TRIALS)


class Metric(NamedTuple):
    """A number that the table of results holds for each run."""

    column: str
    title: str
    unit: str = ""

    @property
    def label(self) -> str:
        """Its title with its unit, if it has one."""
        return f"{self.title} ({self.unit})" if self.unit else self.title

    def of_runs(self, fewest: int, most: int) -> "Metric":
        """The same, its unit as it is of runs of so many trials (see :func:`final_trials`)."""
        return self._replace(unit=self.unit.replace(_FINAL, final_trials(fewest, most)))


FINAL_REWARD = Metric("final_reward", "final reward", f"mean per trial, {_FINAL}")
AREA = Metric("area", "area under the curve", "mean reward per trial over all steps")
METRICS = (
    FINAL_REWARD,
    Metric("final_success", "final success as learned", f"share of captures, {_FINAL}"),
    Metric("greedy_success", "greedy success", "share of captures"),
    AREA,
    Metric("captures", "captures"),
    Metric("flights", "flights"),
    Metric("timeouts", "time-outs"),
    Metric("mean_hunt_length", "mean hunt", "steps"),
    Metric("switches_per_step", "option switches", "per step"),
    Metric("steps", "run length", "steps"),
    Metric("trials", "run length", "trials"),
)
"""In the order in which they are shown."""

PERFORMANCE = frozenset({"final_reward", "final_success", "greedy_success", "area"})
"""Columns that say how well a learner did."""
ENDINGS = frozenset({"captures", "flights", "timeouts"})
"""Columns that count how trials ended."""
BEHAVIOUR = frozenset({"mean_hunt_length", "switches_per_step"})
"""Columns that say how a learner went about it."""
LENGTH = frozenset({"steps", "trials"})
"""Columns that say how long a run was; every run has them, asked for or not."""
MILESTONES: Mapping[str, str] = {
    "steps_to_50": "steps to 50 % success",
    "steps_to_70": "steps to 70 % success",
}
"""Titles of the columns that hold the steps until something was reached, empty if it never was."""
NAMES: tuple[str, ...] = (*(metric.column for metric in METRICS), *MILESTONES)
"""All columns that an experiment may ask for."""


def shown_first(names: Sequence[str]) -> Metric:
    """The number that charts show, of those an experiment asks for: the first that is a mean."""
    by_column = {metric.column: metric for metric in METRICS}
    return next((by_column[name] for name in names if name in by_column), FINAL_REWARD)
