"""How a finished run went: all that metrics are of, hunts without exploration among it."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np

from learners import hunts, measures
from learners.hunts import Policy
from learners.measures import Coherence
from learners.run import Run
from sim import rng
from sim.spec import WorldSpec
from sim.world import World, start_of_trial

GREEDY_HUNTS: Final = 2_000
"""Hunts by which a greedy policy is measured: a share of 0.8 is known to within 0.01 by them."""
CURVE_HUNTS: Final = 200
"""The first of these, by which a point of the greedy curve is measured: with a standard error of at
most 5 of reward in a run. With a point every 2,000 trials a run takes less than a tenth longer."""
COHERENCE_HUNTS: Final = 500
"""The first of these, whose ways say how steadily a learner goes about them: a share of 0.1 is
known to within 0.014 by them."""
GREEDY_SEED: Final = 7_331_729
"""Of the starts of these hunts: the same ones for all runs in a world."""


class Greedy(NamedTuple):
    """What hunts come to whose learner neither explores nor learns, from starts all runs share."""

    success: float
    """Share of captures."""
    reward: float
    """Mean per hunt, by the world's rewards."""


class GreedyCurve(NamedTuple):
    """Greedy reward in the course of a run."""

    trial: np.ndarray
    """(point,) int64: trials that had ended."""
    step: np.ndarray
    """(point,) int64: steps that had been made."""
    reward: np.ndarray
    """(point,) float32: mean per hunt."""
    without_progress: np.ndarray = np.zeros(0, np.float32)
    """(point,) float32: share of a hunt's steps that lead where it has been before, see
    :func:`learners.measures.coherence`; of no points where only the reward was measured."""


NO_CURVE: Final = GreedyCurve(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.float32))


def greedy_of(run: Run, n_hunts: int = GREEDY_HUNTS) -> Greedy:
    """What a learner would do now if it were greedy at both levels, and learned no more."""
    return greedy_by(run.world, hunts.policy_of(run.spec, run.state), run.spec.world, n_hunts)


def greedy_by(world: World, policy: Policy, spec: WorldSpec, n_hunts: int = GREEDY_HUNTS) -> Greedy:
    """What hunts come to by a policy, in a world with the rewards of ``spec``."""
    ends = hunts.endings(world, policy, rng.streams(GREEDY_SEED)[rng.STARTS], n_hunts)
    total = ends.captures * spec.capture_reward + ends.flights * spec.flight_reward
    return Greedy(ends.captures / n_hunts, total / n_hunts)


def coherence_of(run: Run, n_hunts: int = COHERENCE_HUNTS) -> Coherence:
    """How steadily a learner would go about its hunts now, were it greedy at both levels."""
    return coherence_by(run.world, hunts.policy_of(run.spec, run.state), n_hunts)


def coherence_by(world: World, policy: Policy, n_hunts: int = COHERENCE_HUNTS) -> Coherence:
    """How steadily hunts go by a policy, without random moves, of which each is a switch by itself.

    They start as those of :func:`greedy_by`.
    """
    stream = rng.streams(GREEDY_SEED)[rng.STARTS]
    starts = ((number, *start_of_trial(world, stream, number)) for number in range(n_hunts))
    found = (hunts.hunt(world, policy, int(c), int(h), seed) for seed, c, h in starts)
    return measures.coherence((hunt.cells, hunt.options) for hunt in found)


@dataclass(frozen=True)
class Course:
    """A run that is over, and how it went: all that metrics are of."""

    run: Run
    trials: int
    """After which it is measured: its preset's, or all where steps alone count."""
    horizon: int | None = None
    """Steps after which it is measured as well; None if its experiment states none."""
    greedy: Greedy | None = None
    """After its preset's trials, or where it ended before; None if it was not measured."""
    horizon_greedy: Greedy | None = None
    """At the horizon; None also if it did not get there."""
    greedy_curve: GreedyCurve = NO_CURVE
    """Of no points where none were asked for."""
    coherence: Coherence | None = None
    """When its final greedy reward is; None if it was not measured."""

    @cached_property
    def done(self) -> int:
        """Trials of its preset that it finished."""
        return min(measures.trials_done(self.run.state), self.trials)

    @cached_property
    def reward(self) -> np.ndarray:
        """(trial,) float64: of all that it finished, also after its preset's."""
        return self.run.state.log_reward[: measures.trials_done(self.run.state)]

    @cached_property
    def steps(self) -> np.ndarray:
        """(trial,): that each of these took."""
        return self.run.state.log_steps[: measures.trials_done(self.run.state)]

    @cached_property
    def outcome(self) -> np.ndarray:
        """(trial,): how each of these ended."""
        return self.run.state.log_outcome[: measures.trials_done(self.run.state)]
