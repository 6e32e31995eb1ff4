"""What an experiment would take: runs, steps, time and disk, before any of it is spent."""

import itertools
import math
import time
from typing import NamedTuple

from app.experiments import Experiment, Variant
from learners.run import Run
from learners.spec import MAX_TRIALS, RunSpec

_BYTES_PER_RUN = 8_000
"""Of a row with its settings, of what surrounds the arrays, and of the pictures of its value."""
_BYTES_PER_TRIAL = 2.0
"""Of the arrays, compressed."""
_S_PER_RUN = 0.05
"""Time that a run takes beside its steps."""
_PILOT_S = 0.04
"""Time for which the speed of a preset is measured."""
_MOST_PILOTS = 4


class Plan(NamedTuple):
    """What an experiment would take."""

    variants: int
    runs: int
    steps: int
    """Estimated, as are the following."""
    seconds: float
    disk_bytes: int


def estimated_steps(experiment: Experiment, variant: Variant) -> int:
    """Steps that one run of a variant may take, roughly.

    By the mean lengths of trials in the standard world, which grow with the grid: long where the
    learner starts out on a random walk, and longest where it may back away from the first trial.
    """
    spec = variant.spec
    usual = 270 if not spec.learner.skills else 110
    if "avoid" in spec.learner.skills and spec.schedule.introduced_at("avoid") == 0:
        usual = 390
    usual *= spec.world.scale
    steps = experiment.trials_of(variant) * min(usual, spec.world.step_limit)
    return int(steps if experiment.steps is None else min(steps, experiment.steps))


def plan(experiment: Experiment, workers: int) -> Plan:
    """What an experiment would take; measures for a moment how fast this machine is."""
    n_seeds = len(experiment.seeds)
    steps = trials = 0
    for variant in experiment.variants:
        one = estimated_steps(experiment, variant)
        steps += one * n_seeds
        limit = experiment.trials_of(variant)
        trials += min(limit, one) * n_seeds
    n_threads = min(workers, experiment.n_runs)
    return Plan(
        variants=len(experiment.variants),
        runs=experiment.n_runs,
        steps=steps,
        seconds=(steps / _pilot(experiment) + experiment.n_runs * _S_PER_RUN) / n_threads,
        disk_bytes=int(experiment.n_runs * _BYTES_PER_RUN + trials * _BYTES_PER_TRIAL),
    )


def _pilot(experiment: Experiment) -> float:
    """Steps a second of one run, the mean over the first variant of each preset."""
    first = {variant.preset: variant for variant in reversed(experiment.variants)}
    rates = [_rate(variant.spec) for variant in itertools.islice(first.values(), _MOST_PILOTS)]
    return math.fsum(rates) / len(rates)


def _rate(spec: RunSpec) -> float:
    run = Run(spec, 0)
    run.advance(max_steps=1, until_trial=MAX_TRIALS)  # may compile
    began, made = time.perf_counter(), 0
    while (elapsed := time.perf_counter() - began) < _PILOT_S:
        made += run.advance(max_steps=50_000, until_trial=MAX_TRIALS)
    return made / elapsed
