"""One run of an experiment, from what it is a function of to what is kept of it.

A task is made of plain values, and so is what comes back: both can go to a thread, or to another
machine. Nothing here knows where results are kept.
"""

import hashlib
import json
import math
import re
import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from app.documents.experiment_spec import Stop
from app.documents.experiments import Experiment
from app.documents.variants import Variant
from app.experiments.archive import packed
from app.experiments.facts import Facts
from app.experiments.probes import Agenda, GreedyNotes, Pictures, Probe
from app.metrics import measured, wants_coherence, wants_greedy
from app.metrics.course import Course, coherence_of, greedy_of
from learners import behaviour, measures
from learners.kernel.state import TRIAL_STEP, digest, tables
from learners.names import MAX_TRIALS
from learners.run import Run
from learners.spec import RunSpec

_SLICE_STEPS = 2_000_000
"""Steps between two looks at whether to stop: a twentieth of a second."""
_NEVER = 2**62
_LONGEST_ERROR = 4_000


Kept = Literal["results", "log", "log and tables"]
"""What is kept of a run beside its numbers: all that a folder of results holds; or for a moment,
and so not compressed, how its trials went alone; or this and its final tables."""


@dataclass(frozen=True)
class Task:
    """All that one run, and what is kept of it, is a function of."""

    key: str
    """Of its row and of its arrays."""
    settings: str
    """The preset with what the experiment sets in it, as JSON."""
    seed: int
    trials: int
    steps: int | None
    stop: Stop | None
    metrics: tuple[str, ...]
    horizon: int | None = None
    """Steps until which it goes on at least, and at which it is measured."""
    greedy_every: int = 0
    """Trials from one point of its greedy curve to the next; 0 where it has none."""
    kept: Kept = "results"


class Finished(NamedTuple):
    """What is kept of a run that is over, or has failed."""

    key: str
    error: str
    """Why it failed, with a traceback; empty if it did not."""
    seconds: float
    """That it took; NaN where that is not known."""
    digest: str = ""
    values: Mapping[str, float | int | None] = {}
    """Of the metrics that were asked for, and of its length, by column."""
    arrays: bytes = b""
    """A NumPy archive; empty if it has failed."""
    tables: bytes = b""
    """The same of its final tables; empty if they were not asked for."""


class Limits(NamedTuple):
    """Where a run ends."""

    trials: int
    """After which it is over, unless it is to go on until a horizon."""
    steps: int | None = None
    """After which it is over in any case."""
    horizon: int | None = None
    """Steps until which it goes on at least, beyond its trials if these are over before."""
    stop: Stop | None = None
    """When it has learned enough."""

    def are_over(self, run: Run) -> bool:
        """Whether a run has come to its end, by trials and steps."""
        if self.steps is not None and run.step >= self.steps:
            return True
        is_before = self.horizon is not None and run.step < self.horizon
        return run.trial >= (MAX_TRIALS if is_before else self.trials)

    def next_trial(self, run: Run) -> int:
        """Trial before which a run may end next."""
        trial = self.trials if run.trial < self.trials else MAX_TRIALS
        if self.stop is None:
            return trial
        return min(trial, (run.trial // self.stop.every + 1) * self.stop.every)

    def next_step(self, run: Run) -> int:
        """Step after which a run may end next."""
        ends = [end for end in (self.steps, self.horizon) if end is not None and end > run.step]
        return min(ends, default=_NEVER)


# --- What is to be done --------------------------------------------------------------------------


def identity_of(experiment: Experiment, variant: Variant) -> str:
    """What a variant's runs and what is kept of them hang on, but for seeds, as a short text."""
    stop = experiment.stop
    about = [
        variant.label,
        variant.spec.model_dump(mode="json"),
        experiment.trials_of(variant),
        experiment.steps,
        None if stop is None else [stop.success, stop.trials, stop.every],
        experiment.horizon_steps,
        experiment.greedy_every,
    ]
    return hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()


def key_of(label: str, identity: str, seed: int) -> str:
    """Name of a run's row and of its arrays: safe in any file system, and readable."""
    word = re.sub(r"[^a-z0-9]+", "-", label.lower()).strip("-")[:40].strip("-") or "run"
    found = hashlib.sha256(f"{identity} {seed}".encode()).hexdigest()
    return f"{word}-{seed}-{found[:16]}"


def settings_of(variant: Variant) -> str:
    """All settings of a variant, as JSON."""
    return json.dumps(variant.spec.model_dump(mode="json"))


def tasks_of(experiment: Experiment) -> Iterator[tuple[Variant, Task]]:
    """Every run of an experiment: first all variants with the first seed."""
    identities = {v.label: identity_of(experiment, v) for v in experiment.variants}
    settings = {v.label: settings_of(v) for v in experiment.variants}
    for variant, seed in experiment.runs():
        label = variant.label
        yield (
            variant,
            Task(
                key=key_of(label, identities[label], seed),
                settings=settings[label],
                seed=seed,
                trials=experiment.trials_of(variant),
                steps=experiment.steps,
                stop=experiment.stop,
                metrics=experiment.metrics,
                horizon=experiment.horizon_steps,
                greedy_every=experiment.greedy_every,
            ),
        )


# --- One run -------------------------------------------------------------------------------------


def prepare(metrics: Sequence[str] = ()) -> None:
    """Compile what runs take, or load what was compiled before, ahead of the first one.

    Args:
        metrics: columns of :mod:`app.metrics` that are wanted of them.
    """
    spec = {
        "world": {"size": 20, "step_limit": 1},
        "learner": {"options": ["approach"], "alpha": 0},
        "schedule": {"skills": {"approach": {"at": 0}}},
        "trials": 1,
    }
    run = Run(RunSpec.model_validate(spec), seed=0)
    run.advance(max_steps=1)
    behaviour.prepare(run)
    if wants_greedy(metrics):
        greedy_of(run)
    if wants_coherence(metrics):
        coherence_of(run)


def perform(
    task: Task,
    on_progress: Callable[[Run], object] = lambda _: None,
    wanted: Callable[[], bool] = lambda: True,
) -> Finished | None:
    """Make a run and measure it; an error in it is what comes back, and not raised.

    Args:
        task: what to do.
        on_progress: called every twentieth of a second or so.
        wanted: asked as often; may wait, as while an experiment is paused.

    Returns:
        What is kept of it; None if it was no longer wanted.
    """
    began, waited = time.perf_counter(), 0.0

    def still_wanted() -> bool:
        nonlocal waited
        asked = time.perf_counter()
        answer = wanted()
        waited += time.perf_counter() - asked
        return answer

    try:
        spec = RunSpec.model_validate_json(task.settings)
        limits = Limits(task.trials, task.steps, task.horizon, task.stop)
        pictures, facts, greedy = Pictures(), Facts(), GreedyNotes()
        probes = _probes_of(task, spec, pictures, facts, greedy)
        run = made_run(spec, task.seed, limits, probes, on_progress, still_wanted)
        if run is None:
            return None
        notes = greedy.final, greedy.at_horizon, greedy.curve, greedy.coherence
        course = Course(run, task.trials, task.horizon, *notes)
        values, known = measured(course, task.metrics), digest(run.state)
        arrays = packed(arrays_of(course, pictures, facts), compressed=task.kept == "results")
        final = packed(tables(run.spec, run.state)) if task.kept == "log and tables" else b""
    except Exception as error:  # noqa: BLE001 - whatever it is, it is noted, and others go on
        return failed(task.key, error, time.perf_counter() - began - waited)
    # A pause is no part of how long it took.
    seconds = time.perf_counter() - began - waited
    return Finished(task.key, "", seconds, known, values, arrays, final)


def failed(key: str, error: BaseException, seconds: float = math.nan) -> Finished:
    """What is kept of a run that came to nothing."""
    text = "".join(traceback.format_exception(error))
    return Finished(key, text[-_LONGEST_ERROR:], seconds)


def made_run(
    spec: RunSpec,
    seed: int,
    limits: Limits,
    probes: Iterable[Probe] = (),
    on_progress: Callable[[Run], object] = lambda _: None,
    wanted: Callable[[], bool] = lambda: True,
) -> Run | None:
    """Run a preset until its trials are over and its horizon is reached, or what ends it before.

    Where it ends does not depend on how often it is looked at.

    Args:
        spec: the preset.
        seed: of the run.
        limits: where it ends.
        probes: what looks at it on the way.
        on_progress: called every twentieth of a second or so.
        wanted: asked as often.

    Returns:
        The run; None if it was no longer wanted.
    """
    run, stop = Run(spec, seed), limits.stop
    agenda = Agenda(probes)
    agenda.look(run)
    while not limits.are_over(run):
        if not wanted():
            return None
        step = min(limits.next_step(run), agenda.next_step, run.step + _SLICE_STEPS)
        trial = min(limits.next_trial(run), agenda.next_trial)
        run.advance(max_steps=step - run.step, until_trial=trial)
        on_progress(run)
        agenda.look(run)
        if stop is not None and run.trial % stop.every == 0 and _is_good_enough(run, stop):
            break
    agenda.end(run)
    return run


def _probes_of(
    task: Task, spec: RunSpec, pictures: Pictures, facts: Facts, greedy: GreedyNotes
) -> Iterator[Probe]:
    """What looks at the run of a task on its way."""
    if task.kept == "results":
        yield pictures.probe(spec, task.trials)
        yield from facts.probes(spec, task.trials)
    if wants_coherence(task.metrics):
        yield greedy.coherence_probe(task.trials)
    if wants_greedy(task.metrics):
        yield greedy.final_probe(task.trials)
        if task.horizon is not None:
            yield greedy.horizon_probe(task.horizon)
        if task.kept == "results" and task.greedy_every:
            yield greedy.curve_probe(task.greedy_every)


def _is_good_enough(run: Run, stop: Stop) -> bool:
    is_between_trials = run.state.tally[TRIAL_STEP] == 0
    if run.trial < stop.trials or not is_between_trials:
        return False
    captures = measures.endings(run.state, stop.trials).captures
    return captures >= stop.success * stop.trials


# --- What is kept of it --------------------------------------------------------------------------


def arrays_of(course: Course, pictures: Pictures, facts: Facts) -> dict[str, np.ndarray]:
    """What is kept of a run beside its row.

    ``outcome (trial,) int8``, ``steps (trial,) int32``, ``introductions (skill, [trial, step])
    int64``, and the names of these skills, ``introduced (skill,)``. Of the pictures of its value:
    ``moments (moment,) int64``, ``value_share`` and ``value_distance (moment, ring, direction)
    float32``, as :func:`learners.measures.folded_value` has them. Of its greedy curve:
    ``greedy_trial`` and ``greedy_step (point,) int64``, ``greedy_reward (point,) float32``. And of
    the facts that its log does not say ``probe_names`` and ``probe_values (fact,) float64``.
    """
    run = course.run
    joined = run.control.introductions
    shape = -1, run.spec.world.n_distances, run.spec.world.n_directions
    moments = np.array([[entry.trial, entry.step] for entry in joined], np.int64)
    return {
        "outcome": course.outcome,
        "steps": course.steps,
        "introductions": moments.reshape(-1, 2),
        "introduced": np.array([entry.skill for entry in joined], "U32"),
        "moments": np.array(pictures.moments, np.int64),
        "value_share": np.array(pictures.share, np.float32).reshape(shape),
        "value_distance": np.array(pictures.distance, np.float32).reshape(shape),
        "greedy_trial": course.greedy_curve.trial,
        "greedy_step": course.greedy_curve.step,
        "greedy_reward": course.greedy_curve.reward,
        "probe_names": np.array([*facts.found], np.str_),
        "probe_values": np.array([*facts.found.values()], np.float64),
    }
