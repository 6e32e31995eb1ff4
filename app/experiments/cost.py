"""What an experiment would take: runs, steps, time and disk, before any of it is spent.

How long trials are hangs on what a learner has learned by then, and nothing tells that but a run.
So a few variants, spread over all of them, are run for a moment, turn by turn: most come to their
end, and the others are taken to go on as they went of late. A pilot heeds no stop condition, so
that an experiment that has one takes at most what is said.

Pilots say what runs take of a core, and that is right whatever else goes on. How long it takes
hangs on how much of the cores runs will be given beside all else: beside a learner, and a page that
is drawn without a graphics card, it was a quarter. So threads work for a moment, as many as there
will be, and what they are given is what the runs will be (``benchmarks/estimates.py`` compares).
"""

import hashlib
import heapq
import math
import threading
import time
from collections.abc import Collection, Hashable, Sequence
from concurrent.futures import ThreadPoolExecutor
from statistics import median
from typing import Final, NamedTuple

from app.documents.experiments import Experiment
from app.documents.variants import Variant
from app.experiments.task import tasks_of
from app.util.machine import available_cores
from learners.names import MAX_TRIALS
from learners.run import Run
from learners.spec import RunSpec

_BYTES_PER_RUN: Final = 8_000
"""Of a row with its settings, of what surrounds the arrays, and of the pictures of its value."""
_BYTES_PER_TRIAL: Final = 2.0
"""Of the arrays, compressed."""
_S_PER_RUN: Final = 0.01
"""Time that a run takes beside its steps."""

_PILOTS: Final = 8
"""Variants that are run."""
_PILOT_STEPS: Final = 45_000_000
"""Of all pilots together: with so many, estimates for the shipped experiments are right to within
a tenth, with 30 million to within a quarter."""
_PILOT_S: Final = 0.8
"""Processor time after which a thread of pilots ends in any case."""
_BUSY_S: Final = 4.0
"""Time after which it does where the machine is busy with something else."""
_SLICE_STEPS: Final = 50_000
_TRIED_S: Final = 0.5
"""For so long threads work, to see how much of the cores they are given, ..."""
_TRIED_KEPT_S: Final = 60.0
"""... which is good for so long, or until something else goes on."""
_TRIED_STEPS: Final = 1_000_000
"""In one go, as runs have them: in between the interpreter is waited for, which others may hold."""
_LEAST_GIVEN: Final = 0.02
"""Cores; a clock that stands for a moment would make it none."""
_MOST_TRIED: Final = 2
"""Threads that work for each core; more are given no more."""
_LATE: Final = 0.1
"""Share of its trials, the last ones, that say how a pilot would have gone on."""
_KEPT_S: Final = 600.0
"""Time for which what was measured is good."""
_MOST_KEPT: Final = 64
_ALIKE: Final = 1.25
"""Runs whose numbers of trials differ by less have trials of one length: a session that is past the
end of its preset becomes longer all the time."""


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
    drawn: int = 0
    """Of the variants, those with values that were drawn at random."""


def plan(
    experiment: Experiment,
    workers: int,
    finished: Collection[str] = frozenset(),
    beside: Hashable = None,
) -> Plan:
    """What an experiment would take; runs some of it for a moment, unless that was done of late.

    Args:
        experiment: what would be run.
        workers: runs at a time.
        finished: keys of runs that are done.
        beside: what goes on beside it; where that changes, runs will be given another share of the
            cores, which is then found out anew.
    """
    left = {v.label: len(experiment.seeds_of(v)) for v in experiment.variants}
    if finished:
        for variant, task in tasks_of(experiment):
            left[variant.label] -= task.key in finished
    n_left = sum(left.values())
    steps = trials = 0.0
    each: list[tuple[float, int]] = []
    for variant, pace in _paces(experiment) if n_left else ():
        one = _steps_of(experiment, variant, pace)
        n_trials = one / pace.steps
        steps += one * left[variant.label]
        each.append((one * pace.seconds + _S_PER_RUN, left[variant.label]))
        trials += n_trials * left[variant.label]
    n_threads = min(workers, n_left)
    seconds = 0.0
    if n_threads:
        share = _cores_for(experiment.variants[0].spec, n_threads, beside) / n_threads
        seconds = _finished_after(each, n_threads) / share
    return Plan(
        variants=len(experiment.variants),
        runs=experiment.n_runs,
        done=experiment.n_runs - n_left,
        steps=math.ceil(steps),
        seconds=seconds,
        disk_bytes=int(n_left * _BYTES_PER_RUN + trials * _BYTES_PER_TRIAL),
        at_most=experiment.stop is not None,
        drawn=experiment.n_drawn,
    )


def longest_run(experiment: Experiment) -> int:
    """Steps that the longest run may take, roughly; runs pilots as :func:`plan` does."""
    paces = _paces(experiment)
    return math.ceil(max(_steps_of(experiment, variant, pace) for variant, pace in paces))


def _steps_of(experiment: Experiment, variant: Variant, pace: "_Pace") -> float:
    """Steps that a run of a variant takes, by how it goes."""
    least, most = experiment.horizon_steps or 0, experiment.steps or math.inf
    return min(max(experiment.trials_of(variant) * pace.steps, least), most)


def _finished_after(each: Sequence[tuple[float, int]], n_threads: int) -> float:
    """When the last of several threads is through; who is free takes the next run.

    Args:
        each: seconds that a run takes, and how many such runs there are, of each variant; runs are
            made seed by seed, as :func:`app.experiments.task.tasks_of` has them.
        n_threads: that make them.
    """
    free = [0.0] * n_threads
    for turn in range(max((n for _, n in each), default=0)):
        for seconds, n in each:
            if turn < n:
                heapq.heapreplace(free, free[0] + seconds)
    return max(free)


# --- What threads are given ----------------------------------------------------------------------

_given: dict[tuple[int, Hashable], tuple[float, float]] = {}
"""When so many threads worked beside something, and how many cores they were given together."""
_given_lock = threading.Lock()


def _cores_for(spec: RunSpec, n_threads: int, beside: Hashable) -> float:
    """How many cores so many threads are given together, as was found out of late or is now."""
    n_tried = min(n_threads, _MOST_TRIED * available_cores())
    key, now = (n_tried, beside), time.monotonic()
    with _given_lock:
        found_at, found = _given.get(key, (-math.inf, 0.0))
        if now - found_at > _TRIED_KEPT_S:
            found = _tried(spec, n_tried)
            _given.clear()
            _given[key] = (now, found)
    return found


def _tried(spec: RunSpec, n_threads: int) -> float:
    """How many cores threads that work for a moment are given together."""
    runs = [Run(spec, seed) for seed in range(n_threads)]
    until = time.monotonic() + _TRIED_S

    def work(run: Run) -> float:
        began, worked = time.monotonic(), time.thread_time()
        while time.monotonic() < until:
            run.advance(max_steps=_TRIED_STEPS, until_trial=MAX_TRIALS)
        elapsed = time.monotonic() - began
        # A thread that begins late, or that is kept from its clock, was given nothing meanwhile.
        return (time.thread_time() - worked) / max(elapsed, _TRIED_S)

    with ThreadPoolExecutor(n_threads, thread_name_prefix="tried") as executor:
        given = sum(executor.map(work, runs))
    return min(max(given, _LEAST_GIVEN), float(n_threads))


# --- Pilots --------------------------------------------------------------------------------------


class _Course(NamedTuple):
    """What a pilot runs."""

    spec: RunSpec
    trials: int
    steps: int | None
    """After which it ends as well."""


class _Pace(NamedTuple):
    """How a run goes."""

    steps: float
    """Mean of a trial, over the whole run."""
    seconds: float
    """Processor time of a step."""


class _Pilot:
    """A run of a variant, as far as it has come."""

    def __init__(self, course: _Course) -> None:
        self._run = Run(course.spec, 0)
        self._trials = course.trials
        self._most_steps = math.inf if course.steps is None else course.steps
        self._run.advance(max_steps=1)  # may compile
        self._rates: list[float] = []
        """Seconds that a step took, each time that it went on."""

    @property
    def steps(self) -> int:
        """That it has taken."""
        return self._run.step

    @property
    def is_over(self) -> bool:
        """Whether it has come to its end."""
        return self._run.trial >= self._trials or self._run.step >= self._most_steps

    def advance(self) -> float:
        """Go on for a moment; returns the processor time that it took, whatever else goes on."""
        began = time.thread_time()
        steps = self._run.advance(max_steps=_SLICE_STEPS, until_trial=self._trials)
        took = time.thread_time() - began
        self._rates.append(took / steps)
        return took

    def pace(self) -> _Pace:
        """What it says of the whole run."""
        run, done = self._run, self._run.trial
        length = run.step / max(done, 1)
        if done and not self.is_over:
            late = run.state.log_steps[done - max(round(done * _LATE), 1) : done]
            length = (run.step + (self._trials - done) * float(late.mean())) / self._trials
        # Some were held up.
        return _Pace(length, median(self._rates or [0.0]))


_known: dict[str, tuple[float, Sequence[_Pace]]] = {}
"""When pilots were run, and what they say, oldest first, by what they are of."""
_known_lock = threading.Lock()


def _paces(experiment: Experiment) -> Sequence[tuple[Variant, _Pace]]:
    """How a run of each variant goes: as those of its preset that were run, or else as all."""
    chosen = _chosen(experiment)
    runs = [_Course(v.spec, experiment.trials_of(v), experiment.steps) for v in chosen]
    found = list(zip(chosen, _measured(runs), strict=True))
    own = {variant.label: pace for variant, pace in found}
    presets = {
        preset: _mean([pace for variant, pace in found if variant.preset == preset])
        for preset in {variant.preset for variant in chosen}
    }
    every = _mean([pace for _, pace in found])
    return [
        (variant, own.get(variant.label) or presets.get(variant.preset, every))
        for variant in experiment.variants
    ]


def _mean(paces: Sequence[_Pace]) -> _Pace:
    steps = [pace.steps for pace in paces]
    seconds = sum(pace.steps * pace.seconds for pace in paces) / sum(steps)
    return _Pace(sum(steps) / len(steps), seconds)


def _chosen(experiment: Experiment) -> list[Variant]:
    """Variants that speak for all, spread evenly, of each preset as many as it has a share in."""
    by_preset: dict[str, list[Variant]] = {}
    for variant in experiment.variants:
        by_preset.setdefault(variant.preset, []).append(variant)
    groups = list(by_preset.values())
    if len(groups) > _PILOTS:
        groups = [[variant for group in groups for variant in group]]
    found: list[Variant] = []
    for group in groups:
        n = math.ceil(_PILOTS * len(group) / len(experiment.variants))
        n = min(n, len(group))
        found += [group[(2 * place + 1) * len(group) // (2 * n)] for place in range(n)]
    return found


def _measured(runs: Sequence[_Course]) -> Sequence[_Pace]:
    """How some runs go, as was measured of late or is now."""
    about = hashlib.sha256()
    for spec, trials, steps in runs:
        text = spec.model_dump_json(exclude={"description", "trials"})
        about.update(f"{math.log(trials, _ALIKE):.0f} {steps} {text}\n".encode())
    key, now = about.hexdigest(), time.monotonic()
    with _known_lock:
        measured_at, found = _known.get(key, (-math.inf, ()))
        if now - measured_at > _KEPT_S:
            found = _piloted(runs)
            _known.pop(key, None)
            while len(_known) >= _MOST_KEPT:
                del _known[next(iter(_known))]
            _known[key] = (now, found)
    return found


def _piloted(runs: Sequence[_Course]) -> list[_Pace]:
    """How some runs go: they go on for a moment, always the one that has come least far."""
    pilots = [_Pilot(run) for run in runs]
    waiting, lock = [pilot for pilot in pilots if not pilot.is_over], threading.Lock()

    def work() -> None:
        elapsed, began = 0.0, time.monotonic()
        while elapsed < _PILOT_S and time.monotonic() - began < _BUSY_S:
            with lock:
                if not waiting or sum(pilot.steps for pilot in pilots) >= _PILOT_STEPS:
                    return
                pilot = min(waiting, key=lambda pilot: pilot.steps)
                waiting.remove(pilot)
            elapsed += pilot.advance()
            if not pilot.is_over:
                with lock:
                    waiting.append(pilot)

    n_threads = min(len(pilots), available_cores())
    with ThreadPoolExecutor(n_threads, thread_name_prefix="pilot") as executor:
        for working in [executor.submit(work) for _ in range(n_threads)]:
            working.result()
    return [pilot.pace() for pilot in pilots]
