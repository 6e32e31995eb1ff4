"""What is measured of a finished run: the registry from which all that is said of runs derives.

The table of results has a column for each metric, an experiment may ask for any of them, and
reports and the page show them by their titles. To add one, add an entry to :data:`_REGISTRY` and
say in ``presets/experiments/README.md`` what it is.

Success is a share, 0 to 1. What is *final* is of the last 2,000 trials.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Final, Literal, NamedTuple

import numpy as np

from app.words.numbers import NONE, shown_number
from learners import hunts, measures
from learners.kernel.state import tables
from learners.measures import FINAL_TRIALS
from learners.run import Run
from sim import rng
from sim.world import CAPTURE, FLIGHT, TIMEOUT

GREEDY_HUNTS: Final = 2_000
"""Hunts by which greedy success is measured: a share of 0.8 is known to within 0.01 by them."""
GREEDY_SEED: Final = 7_331_729
"""Of the starts of these hunts: the same ones for all runs in a world."""

Kind = Literal["performance", "endings", "behaviour", "length", "milestone"]
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


class InTable(NamedTuple):
    """How the page's table of runs shows a metric."""

    title: str
    hint: str
    width: int
    """In pixels."""
    text: Callable[[float], str]
    """Of a value: NaN where there is none, infinite for a milestone that was never reached."""


class Metric(NamedTuple):
    """A number that the table of results holds for each run."""

    column: str
    title: str
    unit: str
    kind: Kind
    measure: Callable[[Run], float | int | None]
    """Finds it in a run that is over; None where there is nothing to say, or it was not reached."""
    whole: bool = False
    """Whether it is a whole number."""
    in_table: InTable | None = None
    """How the page's table of runs shows it; None if it has no column there of its own."""

    @property
    def label(self) -> str:
        """Its title with its unit, if it has one."""
        return f"{self.title} ({self.unit})" if self.unit else self.title

    def of_runs(self, fewest: int, most: int) -> "Metric":
        """The same, its words as they are of runs of so many trials (see :func:`final_trials`)."""
        final, table = final_trials(fewest, most), self.in_table
        return self._replace(
            unit=self.unit.replace(_FINAL, final),
            in_table=table and table._replace(hint=table.hint.replace(_FINAL, final)),
        )


# --- How each is measured ------------------------------------------------------------------------


def greedy_success(run: Run) -> float:
    """Share of captures of hunts of pure greed, over starts drawn as those of trials are."""
    found = tables(run.spec, run.state)
    selection_q = np.nan_to_num(found["selection_q"], nan=-np.inf)
    policy = hunts.greedy_moves(selection_q, found["skill_q"])
    starts = rng.streams(GREEDY_SEED)[rng.STARTS]
    return hunts.success_share(run.world, policy, starts, GREEDY_HUNTS)


def area_under(curve: measures.Curve) -> float | None:
    """Mean of a learning curve over its steps: the area under it, on the scale of rewards."""
    widths = np.diff(curve.steps, prepend=0)
    there = np.isfinite(curve.reward)
    if not widths[there].sum():
        return None
    return float(np.average(curve.reward[there], weights=widths[there]))


def steps_to(outcomes: np.ndarray, steps: np.ndarray, success: float) -> int | None:
    """Steps after which the share of captures in the last 500 trials first was so high.

    Args:
        outcomes: how trials ended, ``(trial,)``.
        steps: how long they took, ``(trial,)``.
        success: the share.
    """
    window = measures.RECENT_TRIALS
    if len(outcomes) < window:
        return None
    captures = np.concatenate([[0], np.cumsum(outcomes == CAPTURE)])
    there = np.flatnonzero(captures[window:] - captures[:-window] >= success * window)
    return int(np.sum(steps[: there[0] + window], dtype=np.int64)) if there.size else None


def _steps(run: Run) -> int:
    return run.step


def _trials(run: Run) -> int:
    return measures.trials_done(run.state)


def _final_reward(run: Run) -> float | None:
    return measures.mean_reward(run.state) if _trials(run) else None


def _final_success(run: Run) -> float | None:
    final = measures.endings(run.state, FINAL_TRIALS)
    return final.captures / sum(final) if sum(final) else None


def _area(run: Run) -> float | None:
    return area_under(measures.curve(run.state))


def _switches_per_step(run: Run) -> float:
    return measures.switches_per_step(run.state)


def _mean_hunt_length(run: Run) -> float | None:
    done = _trials(run)
    steps = run.state.log_steps[max(done - FINAL_TRIALS, 0) : done]
    return float(steps.mean()) if done else None


def _ending_in(outcome: int) -> Callable[[Run], int]:
    """How many trials ended so."""

    def measure(run: Run) -> int:
        done = _trials(run)
        return int(np.count_nonzero(run.state.log_outcome[:done] == outcome))

    return measure


def _reaching(success: float) -> Callable[[Run], int | None]:
    """Steps until a share of captures was reached."""

    def measure(run: Run) -> int | None:
        done = _trials(run)
        return steps_to(run.state.log_outcome[:done], run.state.log_steps[:done], success)

    return measure


# --- How the table of runs shows some ------------------------------------------------------------


def _per_cent(share: float) -> str:
    return NONE if math.isnan(share) else f"{100 * share:.0f} %"


def _millions(steps: float) -> str:
    return NONE if math.isnan(steps) else f"{steps / 1e6:.2f}"


def _millions_or_never(steps: float) -> str:
    return shown_number(steps / 1e6, ".2f")


_SUCCESS = InTable("success", f"captures in per cent, {_FINAL}", 60, _per_cent)
_LENGTH = InTable("M steps", "simulation steps in millions", 62, _millions)
_TO_70 = InTable(
    "M steps to 70\N{NO-BREAK SPACE}%",
    "steps until 70 % of the last 500 trials end in a capture, in millions",
    82,
    _millions_or_never,
)

# --- The registry --------------------------------------------------------------------------------

_PER_TRIAL, _CAPTURES = f"mean per trial, {_FINAL}", f"share of captures, {_FINAL}"
_ALL_STEPS = "mean reward per trial over all steps"

_REGISTRY: Final[Sequence[Metric]] = (
    Metric("final_reward", "final reward", _PER_TRIAL, "performance", _final_reward),
    Metric(
        "final_success",
        "final success as learned",
        _CAPTURES,
        "performance",
        _final_success,
        in_table=_SUCCESS,
    ),
    Metric("greedy_success", "greedy success", "share of captures", "performance", greedy_success),
    Metric("area", "area under the curve", _ALL_STEPS, "performance", _area),
    Metric("captures", "captures", "", "endings", _ending_in(CAPTURE), whole=True),
    Metric("flights", "flights", "", "endings", _ending_in(FLIGHT), whole=True),
    Metric("timeouts", "time-outs", "", "endings", _ending_in(TIMEOUT), whole=True),
    Metric("mean_hunt_length", "mean hunt", "steps", "behaviour", _mean_hunt_length),
    Metric("switches_per_step", "option switches", "per step", "behaviour", _switches_per_step),
    Metric("steps", "run length", "steps", "length", _steps, whole=True, in_table=_LENGTH),
    Metric("trials", "run length", "trials", "length", _trials, whole=True),
    Metric("steps_to_50", "steps to 50 % success", "", "milestone", _reaching(0.5), whole=True),
    Metric(
        "steps_to_70",
        "steps to 70 % success",
        "",
        "milestone",
        _reaching(0.7),
        whole=True,
        in_table=_TO_70,
    ),
)
"""All metrics, those of a kind in the order in which they are shown."""


def of_kind(*kinds: Kind) -> tuple[Metric, ...]:
    """The metrics of some kinds, kind by kind, in the order in which they are shown."""
    return tuple(metric for kind in kinds for metric in _REGISTRY if metric.kind == kind)


METRICS: Final = of_kind("performance", "endings", "behaviour", "length")
"""Those that have a mean over runs, in the order in which they are shown."""
MILESTONES: Final[Mapping[str, str]] = {
    metric.column: metric.title for metric in of_kind("milestone")
}
"""Titles of the columns that hold the steps until something was reached, empty if it never was."""
NAMES: Final = (*(metric.column for metric in METRICS), *MILESTONES)
"""All columns that an experiment may ask for."""
BY_COLUMN: Final[Mapping[str, Metric]] = {metric.column: metric for metric in _REGISTRY}
IN_TABLE: Final = tuple(
    metric
    for metric in of_kind("performance", "endings", "behaviour", "milestone", "length")
    if metric.in_table is not None
)
"""Those that have a column of the page's table of runs, in its order."""
FINAL_REWARD: Final = BY_COLUMN["final_reward"]
AREA: Final = BY_COLUMN["area"]


def shown_first(names: Sequence[str]) -> Metric:
    """The number that charts show, of those an experiment asks for: the first that is a mean."""
    return next((BY_COLUMN[name] for name in names if name not in MILESTONES), FINAL_REWARD)


def measured(run: Run, names: Sequence[str] = NAMES) -> dict[str, float | int | None]:
    """What was measured of a run that is over, by column.

    Args:
        run: that is over.
        names: columns that are wanted; how long it was is always there.
    """
    wanted = {*names, *(metric.column for metric in of_kind("length"))}
    return {metric.column: metric.measure(run) for metric in _REGISTRY if metric.column in wanted}
