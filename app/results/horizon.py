"""Steps at which runs are compared, so that all have had equal experience.

An experiment may state its horizon, and its runs are then measured there. Where it states none, or
several are compared that do not state the same one, it is the length of the shortest of all runs,
rounded down to a whole 100,000 steps where it is longer than that: there every run can be measured
afterwards, from the log of its trials.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np

from app.experiments.record import Record
from app.metrics import area_at, at_steps, reward_at
from learners import measures

GRID_STEPS: Final = measures.CURVE_WINDOW_STEPS
"""What a horizon that nobody states is a multiple of, where it is longer than that."""
_COLUMNS: Final = ("horizon_reward", "horizon_greedy", "horizon_area")


class Horizon(NamedTuple):
    """Steps at which runs are compared."""

    steps: int
    is_stated: bool
    """Whether their experiments state it; otherwise the shortest run says what it is."""

    @property
    def words(self) -> str:
        """When that is."""
        return at_steps(self.steps)

    @property
    def reason(self) -> str:
        """Why there, as a sentence."""
        if self.is_stated:
            return f"All runs are compared {self.words}, the horizon that is stated."
        return f"All runs are compared {self.words}, which the shortest of them gets to."


def common(runs: Iterable[Record]) -> Horizon | None:
    """Where runs are compared; None where there are none, or some ended when they were good enough.

    Those that end by what they have learned are as good as one another there, and in the midst of
    learning.
    """
    done = [run for run in runs if not run.error]
    stated = {run.origin.horizon for run in done}
    if not done or any(run.origin.stop is not None for run in done):
        return None
    if len(stated) == 1 and None not in stated:
        (steps,) = stated
        assert steps is not None
        return Horizon(steps, is_stated=True)
    return of_shortest(min(min(run.steps, run.origin.horizon or run.steps) for run in done))


def of_shortest(steps: int) -> Horizon | None:
    """Where runs are compared of which the shortest took so many steps; None if it took none."""
    if not steps:
        return None
    return Horizon(steps - steps % GRID_STEPS if steps > GRID_STEPS else steps, is_stated=False)


@dataclass(frozen=True)
class UpTo:
    """What a run came to up to each step at which a horizon that nobody states can be."""

    reward: np.ndarray
    """(multiple,) float64: mean of the last 2,000 trials that had ended at each multiple of
    :data:`GRID_STEPS`; NaN where none had."""
    area: np.ndarray
    """(multiple,) float64: mean of the learning curve up to there."""
    first_reward: np.ndarray
    """(trial,) float64: of each trial that had ended at the first of these multiples."""
    first_steps: np.ndarray
    """(trial,): that each of these took."""

    def values(self, horizon: int) -> tuple[float, float]:
        """Reward and area at a horizon that the run got to; NaN where no trial had ended."""
        if horizon > GRID_STEPS:
            place = horizon // GRID_STEPS - 1
            return float(self.reward[place]), float(self.area[place])
        found = (
            measure(self.first_reward, self.first_steps, horizon)
            for measure in (reward_at, area_at)
        )
        reward, area = (np.nan if value is None else value for value in found)
        return reward, area


def up_to(reward: np.ndarray, steps: np.ndarray, n_steps: int) -> UpTo:
    """What a run came to, step by step.

    Args:
        reward: (trial,) of each trial.
        steps: (trial,) that each trial took.
        n_steps: of the run, with those of a trial that has not ended.
    """
    ends = np.cumsum(steps, dtype=np.int64)
    multiples = np.arange(1, n_steps // GRID_STEPS + 1) * GRID_STEPS
    n_ended = np.searchsorted(ends, multiples, side="right")
    totals = np.concatenate([[0.0], np.cumsum(reward)])
    n_final = np.minimum(n_ended, measures.FINAL_TRIALS)
    final = _ratio(totals[n_ended] - totals[n_ended - n_final], n_final)
    in_window, before = np.diff(n_ended, prepend=0), np.diff(totals[n_ended], prepend=0.0)
    window = _ratio(before, in_window)
    area = _ratio(np.nancumsum(window), np.cumsum(in_window > 0))
    n_first = int(np.searchsorted(ends, GRID_STEPS, side="right"))
    return UpTo(final, area, reward[:n_first].copy(), steps[:n_first].copy())


def _ratio(totals: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Means; NaN of nothing."""
    return np.divide(totals, counts, out=np.full(totals.shape, np.nan), where=counts > 0)


def is_measured(run: Record, horizon: Horizon) -> bool:
    """Whether the values of a run at a horizon are those that were measured of it."""
    return run.origin.horizon == horizon.steps


def with_values(run: Record, horizon: Horizon | None, known: UpTo | None) -> Record:
    """A run with its values at a horizon, of those that its experiment asks for.

    Args:
        run: that is over.
        horizon: that it has in common with others; None if there is none.
        known: of the run; None where its log cannot be read.

    Returns:
        The run itself where its values were measured there. No greedy hunts were made elsewhere.
    """
    if horizon is None or run.error or is_measured(run, horizon):
        return run
    values = dict.fromkeys(_COLUMNS, np.nan)
    if known is not None:
        values["horizon_reward"], values["horizon_area"] = known.values(horizon.steps)
    wanted: Mapping[str, float] = {
        name: value for name, value in values.items() if name in run.origin.metrics
    }
    return replace(run, values={**run.values, **wanted})
