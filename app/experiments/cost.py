"""What an experiment would take: runs, steps, time and disk, before any of it is spent.

Steps are estimated by mean lengths of trials that were measured in the shipped experiments. They
hang on which skills there are, on which of them are explored, and on how long the learner has had
them: a selection that has two skills at most settles soon, one of approaching, circling and
avoiding takes tens of thousands of trials unless it came to know them one after the other.
"""

import math
import threading
import time
from collections.abc import Collection, Sequence
from itertools import islice, pairwise
from statistics import fmean
from typing import Final, NamedTuple

import numpy as np

from app.documents.experiments import Experiment
from app.documents.variants import Variant
from app.experiments.task import tasks_of
from learners.run import Run
from learners.spec import MAX_TRIALS, RunSpec, ScheduleSpec

_BYTES_PER_RUN: Final = 8_000
"""Of a row with its settings, of what surrounds the arrays, and of the pictures of its value."""
_BYTES_PER_TRIAL: Final = 2.0
"""Of the arrays, compressed."""
_STEPS_OF_A_TRIAL: Final = 25
"""Of the shortest trials on average, where steps alone end a run."""
_MOST_EPISODES: Final = 50
"""Explorations of a schedule that are looked at: a guess is not worth more."""

_OTHERS: Final = ("approach", "avoid")
"""Skills that do not circle."""

_S_PER_RUN: Final = 0.01
"""Time that a run takes beside its steps."""
_PILOTS: Final = 3
"""Times that the speed of a preset is measured; the best counts, which nothing else held up."""
_PILOT_STEPS: Final = 3_000_000
"""Of a pilot at most. The first hundred thousand steps of a run take up to twice as long as later
ones: a run that has no others takes less than what comes beside its steps."""
_PILOT_S: Final = 0.2
"""Processor time after which a pilot ends in any case."""
_SLICE_STEPS: Final = 50_000
_MOST_PILOTS: Final = 4
"""Presets of an experiment whose speed is measured."""
_KEPT_S: Final = 600.0
"""Time for which a speed that was measured is good."""
_MOST_KEPT: Final = 64


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
    at_most: bool = False
    """Whether runs end as soon as they are good enough, so that it may be far less than that."""


class _Course(NamedTuple):
    """Mean length of trials while the learner learns with what it has: an exponential."""

    first: float
    """Steps of the first trial."""
    last: float
    """Steps of a trial once everything is learned."""
    trials: float
    """Trials in which the difference becomes e times smaller."""

    def steps(self, begin: int, end: int) -> float:
        """Steps of the trials from ``begin`` up to, but not including, ``end``."""
        learning = math.exp(-begin / self.trials) - math.exp(-end / self.trials)
        return self.last * (end - begin) + (self.first - self.last) * self.trials * learning


# Mean lengths in the world of 120 x 120 cells, in steps: first of trials in which nothing changes.
_APPROACHING: Final = 25.0
_CIRCLING: Final = 70.0
_AVOIDING: Final = 280.0
# The same while a skill is explored, over the probability of taking it.
_PROBABILITY: Final = (0.0, 0.1, 0.3, 0.5, 0.7, 0.95)
_CIRCLING_EXPLORED: Final = (25, 26, 35, 47, 72, 365)
_AVOIDING_EXPLORED: Final = (70, 75, 185, 385, 425, 455)
_AVOIDING_EXPLORED_ALONE: Final = (25, 28, 50, 265, 405, 440)
"""Without a skill that circles."""
# Of what goes on being learned.
_MOVES: Final = _Course(400, 190, 9_000)
_ALL_AT_ONCE: Final = _Course(460, 110, 60_000)
_ALL_EXPLORED_AT_ONCE: Final = _Course(440, 110, 30_000)
_IN_CLOSE_ORDER: Final = _Course(300, 110, 20_000)
_ONE_BY_ONE: Final = _Course(190, 110, 15_000)
_ONE_BY_ONE_SLOWLY: Final = _Course(245, 110, 60_000)
"""After avoiding was explored so much that little else was learned."""
_MUCH: Final = 0.5
_CLOSE_TRIALS: Final = 2_000
"""Between two introductions; the first skill is not known yet when the second joins."""


def estimated_steps(experiment: Experiment, variant: Variant) -> int:
    """Steps that one run of a variant may take, roughly, if no stop condition ends it."""
    trials = experiment.trials_of(variant)
    spec = variant.spec
    phases = _phases(spec.schedule, spec.learner.skills, trials)
    steps = sum(_steps_of_phase(spec, begin, end) for begin, end in pairwise(phases))
    return math.ceil(steps if experiment.steps is None else min(steps, experiment.steps))


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
        seconds=(steps * _pilot(experiment) + n_left * _S_PER_RUN) / n_threads if n_left else 0.0,
        disk_bytes=int(n_left * _BYTES_PER_RUN + trials * _BYTES_PER_TRIAL),
        at_most=experiment.stop is not None,
    )


# --- Steps ---------------------------------------------------------------------------------------


def _phases(schedule: ScheduleSpec, skills: Sequence[str], trials: int) -> list[int]:
    """Trials in which something begins or ends, from 0 to the end of the run."""
    cuts = {schedule.introduced_at(skill) for skill in skills}
    for episode in schedule.episodes[:_MOST_EPISODES]:
        first = schedule.starts_at(episode)
        cuts |= {first, first + episode.duration}
    return [0, *sorted(cut for cut in cuts if 0 < cut < trials), trials]


def _steps_of_phase(spec: RunSpec, begin: int, end: int) -> float:
    """Steps of trials in all of which the same skills are there, and the same ones explored."""
    scale, limit = spec.world.scale, spec.world.step_limit
    if not spec.learner.skills:
        since, (first, last, trials) = 0, _MOVES
        last, trials = last * scale**2, trials * scale**2
    else:
        since, (first, last, trials) = _course(spec, begin)
        # Whoever has not learned anything yet is as slow in a small world.
        first = first * scale if first == last else first
        last, trials = last * scale, trials * scale**3
    course = _Course(min(first, limit), min(last, limit), trials)
    return course.steps(begin - since, end - since)


def _course(spec: RunSpec, trial: int) -> tuple[int, _Course]:
    """How long trials of a selection of skills are from a trial on, and since when so."""
    schedule = spec.schedule
    joined = {
        skill: at for skill in spec.learner.skills if (at := schedule.introduced_at(skill)) <= trial
    }
    avoiding_at = joined.get("avoid")
    # Skills of one's own are taken for such as circle.
    circling_at = min((at for skill, at in joined.items() if skill not in _OTHERS), default=None)
    begun = [e for e in schedule.episodes[:_MOST_EPISODES] if schedule.starts_at(e) <= trial]
    now = [e for e in begun if trial < schedule.starts_at(e) + e.duration]
    avoiding = max((e.probability for e in now if e.skill == "avoid"), default=None)
    circling = max((e.probability for e in now if e.skill not in _OTHERS), default=None)
    if avoiding_at is None or circling_at is None:
        if circling_at is not None:
            length = _CIRCLING if circling is None else _explored(circling, _CIRCLING_EXPLORED)
        elif avoiding_at is not None:
            alone = _AVOIDING_EXPLORED_ALONE
            length = _AVOIDING if avoiding is None else _explored(avoiding, alone)
        else:
            length = _APPROACHING
        return trial, _steady(length)
    if avoiding is not None or circling is not None:
        lengths = (
            _explored(circling or 0.0, _CIRCLING_EXPLORED),
            _explored(avoiding or 0.0, _AVOIDING_EXPLORED),
        )
        return trial, _steady(max(lengths))
    since = max(avoiding_at, circling_at)
    is_close = 0 <= avoiding_at - circling_at <= _CLOSE_TRIALS
    if not is_close:
        is_slow = any(e.skill == "avoid" and e.probability >= _MUCH for e in begun)
        return since, _ONE_BY_ONE_SLOWLY if is_slow else _ONE_BY_ONE
    if circling_at > 0:
        return since, _IN_CLOSE_ORDER
    return since, _ALL_EXPLORED_AT_ONCE if begun else _ALL_AT_ONCE


def _steady(length: float) -> _Course:
    return _Course(length, length, 1.0)


def _explored(probability: float, lengths: Sequence[float]) -> float:
    return float(np.interp(probability, _PROBABILITY, lengths))


# --- Time ----------------------------------------------------------------------------------------

_speeds: dict[str, tuple[float, float]] = {}
"""When the speed of a world and a learner was measured, and seconds that a step takes; oldest
first."""
_speeds_lock = threading.Lock()


def _pilot(experiment: Experiment) -> float:
    """Seconds that a step of one run takes, the mean over the first variant of each preset."""
    first = {variant.preset: variant for variant in reversed(experiment.variants)}
    pilots = islice(first.values(), _MOST_PILOTS)
    return fmean(_seconds_of_a_step(variant.spec) for variant in pilots)


def _seconds_of_a_step(spec: RunSpec) -> float:
    """Processor time of a step, as it was a while ago or is measured now."""
    # What a run does in its trials, and how many there are, hardly changes how fast it is.
    key, now = spec.model_dump_json(include={"world", "learner"}), time.monotonic()
    with _speeds_lock:
        measured_at, found = _speeds.get(key, (-math.inf, 0.0))
        if now - measured_at > _KEPT_S:
            found = min(_measured(spec) for _ in range(_PILOTS))
            _speeds.pop(key, None)
            while len(_speeds) >= _MOST_KEPT:
                del _speeds[next(iter(_speeds))]
            _speeds[key] = (now, found)
    return found


def _measured(spec: RunSpec) -> float:
    """Processor time of a step in a pilot, whatever else the machine is at."""
    run = Run(spec, 0)
    run.advance(max_steps=1, until_trial=MAX_TRIALS)  # may compile
    began, made, elapsed = time.thread_time(), 0, 0.0
    # A clock may stand for a moment.
    while elapsed == 0.0 or (made < _PILOT_STEPS and elapsed < _PILOT_S):
        made += run.advance(max_steps=_SLICE_STEPS, until_trial=MAX_TRIALS)
        elapsed = time.thread_time() - began
    return elapsed / made
