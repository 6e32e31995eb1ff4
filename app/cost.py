"""What an experiment would take: runs, steps, time and disk, before any of it is spent."""

import itertools
import math
import time
from collections.abc import Collection
from typing import NamedTuple

from app.experiments import Experiment, Variant
from app.replicate import tasks_of
from learners.run import Run
from learners.spec import MAX_TRIALS, RunSpec

_BYTES_PER_RUN = 8_000
"""Of a row with its settings, of what surrounds the arrays, and of the pictures of its value."""
_BYTES_PER_TRIAL = 2.0
"""Of the arrays, compressed."""
_STEPS_OF_A_TRIAL = 25
"""Of the shortest trials on average, where steps alone end a run."""
_S_PER_RUN = 0.01
"""Time that a run takes beside its steps."""
_PILOT_S = 0.04
"""Time for which the speed of a preset is measured."""
_MOST_PILOTS = 4


class Plan(NamedTuple):
    """What an experiment would take, beyond what is done."""

    variants: int
    runs: int
    """In all."""
    done: int
    steps: int
    """Of the runs that are left, estimated, as are the following."""
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


def plan(experiment: Experiment, workers: int, finished: Collection[str] = frozenset()) -> Plan:
    """What an experiment would take; measures for a moment how fast this machine is.

    Args:
        experiment: what would be run.
        workers: runs at a time.
        finished: keys of runs that are done.
    """
    left = dict.fromkeys((v.label for v in experiment.variants), len(experiment.seeds))
    if finished:
        for variant, task in tasks_of(experiment):
            left[variant.label] -= task.key in finished
    n_left = sum(left.values())
    steps = trials = 0
    for variant in experiment.variants:
        one = estimated_steps(experiment, variant)
        steps += one * left[variant.label]
        shortest = max(one // _STEPS_OF_A_TRIAL, 1)
        trials += min(experiment.trials_of(variant), shortest) * left[variant.label]
    n_threads = max(min(workers, n_left), 1)
    return Plan(
        variants=len(experiment.variants),
        runs=experiment.n_runs,
        done=experiment.n_runs - n_left,
        steps=steps,
        seconds=(steps / _pilot(experiment) + n_left * _S_PER_RUN) / n_threads if n_left else 0.0,
        disk_bytes=int(n_left * _BYTES_PER_RUN + trials * _BYTES_PER_TRIAL),
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
