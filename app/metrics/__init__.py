"""What is measured of a finished run: the registry from which all that is said of runs derives.

The table of results has a column for each metric, an experiment may ask for any of them, and
reports and the page show them by their titles. To add one, add an entry to :data:`_REGISTRY` and
say in ``presets/experiments/README.md`` what it is.

Success is a share, 0 to 1. What is *final* is of the last 2,000 of the preset's trials; a run may
go on after them, until a horizon that all runs of an experiment have in common.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Final, Literal, NamedTuple

import numpy as np

from app.metrics.course import Course
from app.words.numbers import NONE, in_millions, in_short, shown_number
from learners import measures
from learners.measures import FINAL_TRIALS
from sim.world import CAPTURE, FLIGHT, TIMEOUT

Kind = Literal["performance", "endings", "behaviour", "length", "passage"]
"""What a metric says: how well a learner did, how trials ended, how it went about it, how long the
run was (every run has these, asked for or not), or after how many steps something was reached."""


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


AT_HORIZON: Final = "at the horizon"
"""In the words of a metric: when it is of, as long as the horizon has no number."""


def at_steps(horizon: int) -> str:
    """A horizon in words, wherever something is said of it.

    Args:
        horizon: in steps.
    """
    return f"at {in_short(horizon)} steps"


class InTable(NamedTuple):
    """How the page's table of runs shows a metric, and what a choice of metrics calls it."""

    title: str
    hint: str
    width: int
    """In pixels."""
    text: Callable[[float], str]
    """Of a value: NaN where there is none; of a passage, the steps at which it was reached, or at
    which the run ended before."""


class Metric(NamedTuple):
    """A number that the table of results holds for each run."""

    column: str
    title: str
    unit: str
    kind: Kind
    measure: Callable[[Course], float | int | None]
    """Finds it in a run that is over; None where there is nothing to say, or it was not reached."""
    whole: bool = False
    """Whether it is a whole number."""
    in_table: InTable | None = None
    """How the page's table of runs shows it; None if it has no column there of its own."""

    @property
    def label(self) -> str:
        """Its title with its unit, if it has one."""
        return f"{self.title} ({self.unit})" if self.unit else self.title

    @property
    def is_at_horizon(self) -> bool:
        """Whether it is of the moment of a horizon, which an experiment may not have."""
        return AT_HORIZON in self.title

    def of_runs(self, fewest: int, most: int) -> "Metric":
        """The same, its words as they are of runs of so many trials (see :func:`final_trials`)."""
        final, table = final_trials(fewest, most), self.in_table
        return self._replace(
            unit=self.unit.replace(_FINAL, final),
            in_table=table and table._replace(hint=table.hint.replace(_FINAL, final)),
        )

    def at(self, horizon: int | None) -> "Metric":
        """The same, its words as they are with a horizon of so many steps, if there is one."""
        if horizon is None:
            return self
        when, table = at_steps(horizon), self.in_table
        return self._replace(
            title=self.title.replace(AT_HORIZON, when),
            in_table=table
            and table._replace(
                title=table.title.replace(AT_HORIZON, f"at {in_short(horizon)}"),
                hint=table.hint.replace(AT_HORIZON, when),
            ),
        )


# --- How each is measured ------------------------------------------------------------------------


def area_of(reward: np.ndarray, steps: np.ndarray, n_steps: int) -> float | None:
    """Area under the learning curve of some trials, over windows of 100,000 steps.

    Args:
        reward: (trial,) of each trial.
        steps: (trial,) that each trial took.
        n_steps: where the last window ends in any case.

    Returns:
        Mean reward per trial over the steps; None where no trial ended.
    """
    return _there(measures.area_under(measures.curve_of(reward, steps, n_steps)))


def reward_at(reward: np.ndarray, steps: np.ndarray, horizon: int) -> float | None:
    """Mean reward of the last 2,000 trials that had ended at a horizon.

    Args:
        reward: (trial,) of each trial of a run that got there.
        steps: (trial,) that each trial took.
        horizon: in steps.
    """
    return _there(measures.final_mean(reward[: measures.ended_by(steps, horizon)]))


def area_at(reward: np.ndarray, steps: np.ndarray, horizon: int) -> float | None:
    """Area under the learning curve up to a horizon; arguments as :func:`reward_at` has them."""
    n_ended = measures.ended_by(steps, horizon)
    return area_of(reward[:n_ended], steps[:n_ended], horizon)


def _there(value: float) -> float | None:
    return None if math.isnan(value) else value


def _steps(course: Course) -> int:
    return course.run.step


def _trials(course: Course) -> int:
    return measures.trials_done(course.run.state)


def _final_reward(course: Course) -> float | None:
    return _there(measures.final_mean(course.reward[: course.done]))


def _final_greedy(course: Course) -> float | None:
    return None if course.greedy is None else course.greedy.reward


def _final_success(course: Course) -> float | None:
    return _there(measures.final_mean(course.outcome[: course.done] == CAPTURE))


def _greedy_success(course: Course) -> float | None:
    return None if course.greedy is None else course.greedy.success


def _area(course: Course) -> float | None:
    steps = course.steps[: course.done]
    # A run that its steps ended is measured to its end, though no trial ended there.
    is_over = course.done == course.trials
    n_steps = int(steps.sum(dtype=np.int64)) if is_over else course.run.step
    return area_of(course.reward[: course.done], steps, n_steps)


def _horizon_reward(course: Course) -> float | None:
    return _at_horizon(course, reward_at)


def _horizon_greedy(course: Course) -> float | None:
    return None if course.horizon_greedy is None else course.horizon_greedy.reward


def _horizon_area(course: Course) -> float | None:
    return _at_horizon(course, area_at)


def _at_horizon(
    course: Course, measure: Callable[[np.ndarray, np.ndarray, int], float | None]
) -> float | None:
    """Something at the horizon of a run; None if it has none or did not get there."""
    if course.horizon is None or course.run.step < course.horizon:
        return None
    return measure(course.reward, course.steps, course.horizon)


def _switches_per_step(course: Course) -> float:
    switches = course.run.state.log_switches[: course.done]
    return measures.switches_per_step(course.steps[: course.done], switches)


def _mean_hunt_length(course: Course) -> float | None:
    return _there(measures.final_mean(course.steps[: course.done]))


def _mean_choice(course: Course) -> float | None:
    return None if course.coherence is None else course.coherence.mean_choice


def _without_progress(course: Course) -> float | None:
    return None if course.coherence is None else course.coherence.without_progress


def _ending_in(outcome: int) -> Callable[[Course], int]:
    """How many trials ended so."""
    return lambda course: int(np.count_nonzero(course.outcome == outcome))


def _first_to(level: float) -> Callable[[Course], int | None]:
    """Steps until a mean reward was first reached."""
    return lambda course: measures.first_passage(course.reward, course.steps, level)


def _steps_to(level: float) -> Callable[[Course], int | None]:
    """Steps until a mean reward was reached for good."""
    return lambda course: measures.kept_passage(course.reward, course.steps, level)


# --- How the table of runs shows some ------------------------------------------------------------


def _per_cent(share: float) -> str:
    return NONE if math.isnan(share) else f"{100 * share:.0f} %"


def _reward(value: float) -> str:
    return shown_number(value, ".1f")


_SUCCESS = InTable("success", f"captures in per cent, {_FINAL}", 60, _per_cent)
_LENGTH = InTable("M steps", "simulation steps in millions", 62, in_millions)
_TO_70 = InTable(
    "M steps to 70",
    "steps until a mean reward of 70 is reached and kept, in millions",
    82,
    in_millions,
)
_GREEDILY = "without random moves, nothing learned"


def _rewards_in_table(title: str, hint: str) -> InTable:
    return InTable(title, hint, 62, _reward)


# --- The registry --------------------------------------------------------------------------------

_PER_TRIAL, _CAPTURES = f"mean per trial, {_FINAL}", f"share of captures, {_FINAL}"
_BY_THEN = "mean per trial, last 2,000 trials by then"
_PER_HUNT = "mean per hunt, nothing explored or learned"
_ALL_STEPS = "mean reward per trial over all steps"
_STEPS_BY_THEN = "mean reward per trial over the steps by then"

_REGISTRY: Final[Sequence[Metric]] = (
    Metric(
        "final_reward",
        "final reward",
        _PER_TRIAL,
        "performance",
        _final_reward,
        in_table=_rewards_in_table("reward", f"mean reward per trial, {_FINAL}"),
    ),
    Metric(
        "final_greedy",
        "final greedy reward",
        _PER_HUNT,
        "performance",
        _final_greedy,
        in_table=_rewards_in_table("greedy", f"mean reward per hunt in the end, {_GREEDILY}"),
    ),
    Metric(
        "final_success",
        "final success as learned",
        _CAPTURES,
        "performance",
        _final_success,
        in_table=_SUCCESS,
    ),
    Metric("greedy_success", "greedy success", "share of captures", "performance", _greedy_success),
    Metric(
        "area",
        "area under the curve",
        _ALL_STEPS,
        "performance",
        _area,
        in_table=_rewards_in_table("area", f"under the curve: {_ALL_STEPS}"),
    ),
    Metric(
        "horizon_reward",
        f"reward {AT_HORIZON}",
        _BY_THEN,
        "performance",
        _horizon_reward,
        in_table=_rewards_in_table(
            f"reward {AT_HORIZON}", f"mean reward per trial, last 2,000 trials {AT_HORIZON}"
        ),
    ),
    Metric(
        "horizon_greedy",
        f"greedy reward {AT_HORIZON}",
        _PER_HUNT,
        "performance",
        _horizon_greedy,
        in_table=_rewards_in_table(
            f"greedy {AT_HORIZON}", f"mean reward per hunt {AT_HORIZON}, {_GREEDILY}"
        ),
    ),
    Metric(
        "horizon_area",
        f"area under the curve {AT_HORIZON}",
        _STEPS_BY_THEN,
        "performance",
        _horizon_area,
        in_table=_rewards_in_table(
            f"area {AT_HORIZON}", f"under the curve {AT_HORIZON}: {_STEPS_BY_THEN}"
        ),
    ),
    Metric("captures", "captures", "", "endings", _ending_in(CAPTURE), whole=True),
    Metric("flights", "flights", "", "endings", _ending_in(FLIGHT), whole=True),
    Metric("timeouts", "time-outs", "", "endings", _ending_in(TIMEOUT), whole=True),
    Metric("mean_hunt_length", "mean hunt", "steps", "behaviour", _mean_hunt_length),
    Metric("switches_per_step", "option switches", "per step", "behaviour", _switches_per_step),
    Metric("mean_choice", "mean run of a choice", "steps", "behaviour", _mean_choice),
    Metric(
        "without_progress",
        "visits without progress",
        "share of steps",
        "behaviour",
        _without_progress,
    ),
    Metric("steps", "run length", "steps", "length", _steps, whole=True, in_table=_LENGTH),
    Metric("trials", "run length", "trials", "length", _trials, whole=True),
    Metric("steps_to_50", "steps to a reward of 50", "", "passage", _steps_to(50), whole=True),
    Metric(
        "steps_to_70",
        "steps to a reward of 70",
        "",
        "passage",
        _steps_to(70),
        whole=True,
        in_table=_TO_70,
    ),
    Metric("first_to_50", "steps to the first 50", "", "passage", _first_to(50), whole=True),
    Metric("first_to_70", "steps to the first 70", "", "passage", _first_to(70), whole=True),
)
"""All metrics, those of a kind in the order in which they are shown."""


def of_kind(*kinds: Kind) -> tuple[Metric, ...]:
    """The metrics of some kinds, kind by kind, in the order in which they are shown."""
    return tuple(metric for kind in kinds for metric in _REGISTRY if metric.kind == kind)


METRICS: Final = of_kind("performance", "endings", "behaviour", "length")
"""Those that have a mean over runs, in the order in which they are shown."""
PASSAGES: Final[Mapping[str, str]] = {metric.column: metric.title for metric in of_kind("passage")}
"""Titles of the columns that hold the steps until something was reached, empty if it never was."""
NAMES: Final = (*(metric.column for metric in METRICS), *PASSAGES)
"""All columns that an experiment may ask for."""
BY_COLUMN: Final[Mapping[str, Metric]] = {metric.column: metric for metric in _REGISTRY}
IN_TABLE: Final = tuple(
    metric
    for metric in of_kind("performance", "endings", "behaviour", "passage", "length")
    if metric.in_table is not None
)
"""Those that have a column of the page's table of runs, in its order."""
FINAL_REWARD: Final = BY_COLUMN["final_reward"]
AREA: Final = BY_COLUMN["area"]
SHARES: Final = frozenset({"final_success", "greedy_success"})
"""Of the columns that say how well a learner did, those that are shares of captures; the others are
rewards."""
AT_THE_HORIZON: Final = BY_COLUMN["horizon_area"], BY_COLUMN["horizon_reward"]
"""Those that compare runs of equal experience, first the one that says most."""


def shown_first(names: Sequence[str], is_stated: bool = False) -> Metric:
    """The number that charts show, of those an experiment asks for: the first that is a mean.

    Where that is the final reward and the experiment states a horizon, it is the area up to there,
    or the reward there: runs of equal experience can be compared, runs of equal trials cannot. A
    horizon that is not stated moves as runs come in, and what is charted is not to move with it.

    Args:
        names: columns that are asked for, in their order.
        is_stated: whether the experiment states a horizon.
    """
    first = next((BY_COLUMN[name] for name in names if name not in PASSAGES), FINAL_REWARD)
    if first is not FINAL_REWARD or not is_stated:
        return first
    return next((metric for metric in AT_THE_HORIZON if metric.column in names), first)


def shown_means(names: Sequence[str], is_stated: bool, has_horizon: bool) -> Sequence[Metric]:
    """The numbers that maps of settings are drawn of, each once.

    Args:
        names: columns that are asked for, in their order.
        is_stated: whether the experiment states a horizon.
        has_horizon: whether the runs have one in common, be it stated or not.
    """
    others = (*(AT_THE_HORIZON if has_horizon else ()), FINAL_REWARD, AREA)
    return [*dict.fromkeys((shown_first(names, is_stated), *others))]


_GREEDY: Final = frozenset({"final_greedy", "greedy_success", "horizon_greedy"})
"""Columns for which a run is to be measured greedily."""


def wants_greedy(names: Sequence[str]) -> bool:
    """Whether any of some columns takes greedy hunts."""
    return not _GREEDY.isdisjoint(names)


_COHERENCE: Final = frozenset({"mean_choice", "without_progress"})
"""Columns for which the ways of greedy hunts are to be looked at."""


def wants_coherence(names: Sequence[str]) -> bool:
    """Whether any of some columns takes the ways of greedy hunts."""
    return not _COHERENCE.isdisjoint(names)


def measured(course: Course, names: Sequence[str] = NAMES) -> dict[str, float | int | None]:
    """What was measured of a run that is over, by column.

    Args:
        course: how it went.
        names: columns that are wanted; how long it was is always there.
    """
    wanted = {*names, *(metric.column for metric in of_kind("length"))}
    return {m.column: m.measure(course) for m in _REGISTRY if m.column in wanted}
