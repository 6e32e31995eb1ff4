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
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from app.documents.experiment_spec import Stop
from app.documents.experiments import Experiment
from app.documents.variants import Variant
from app.experiments.archive import packed
from app.metrics import greedy_success, measured
from learners import measures
from learners.kernel.state import TRIAL_STEP, digest, tables
from learners.run import Run
from learners.spec import RunSpec

_SLICE_STEPS = 2_000_000
"""Steps between two looks at whether to stop: a twentieth of a second."""
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


class Pictures(NamedTuple):
    """The folded value at some moments of a run."""

    moments: list[int]
    """Trials that were about to start."""
    share: list[np.ndarray]
    """(ring, direction) for each."""
    distance: list[np.ndarray]


# --- What is to be done --------------------------------------------------------------------------


def identity_of(experiment: Experiment, variant: Variant) -> str:
    """All that the runs of a variant are a function of, but for the seed, as a short text."""
    stop = experiment.stop
    about = [
        variant.label,
        variant.spec.model_dump(mode="json"),
        experiment.trials_of(variant),
        experiment.steps,
        None if stop is None else [stop.success, stop.trials, stop.every],
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
    if "greedy_success" in metrics:
        greedy_success(run)


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
        pictures = Pictures([], [], [])
        wanted_pictures = pictures if task.kept == "results" else None
        limits = task.trials, task.steps, task.stop
        run = made_run(spec, task.seed, *limits, on_progress, still_wanted, wanted_pictures)
        if run is None:
            return None
        values, known = measured(run, task.metrics), digest(run.state)
        arrays = packed(arrays_of(run, pictures), compressed=task.kept == "results")
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
    trials: int,
    steps: int | None = None,
    stop: Stop | None = None,
    on_progress: Callable[[Run], object] = lambda _: None,
    wanted: Callable[[], bool] = lambda: True,
    pictures: Pictures | None = None,
) -> Run | None:
    """Run a preset until its trials or steps are over, or it is good enough.

    Where it ends does not depend on how often it is looked at. Its value is added to ``pictures``,
    if there are any, at the moments of :func:`moments_of` and at the end.

    Returns:
        The run; None if it was no longer wanted.
    """
    run = Run(spec, seed)
    moments = [] if pictures is None else [*moments_of(spec, trials)]
    while run.trial < trials and (steps is None or run.step < steps):
        if not wanted():
            return None
        left = _SLICE_STEPS if steps is None else min(_SLICE_STEPS, steps - run.step)
        until = min([trials, *moments[:1]])
        if stop is not None:
            until = min(until, (run.trial // stop.every + 1) * stop.every)
        run.advance(max_steps=left, until_trial=until)
        on_progress(run)
        if pictures is not None and moments and run.trial == moments[0]:
            _add_picture(pictures, run)
            moments.pop(0)
        if stop is not None and run.trial % stop.every == 0 and _is_good_enough(run, stop):
            break
    if pictures is not None and run.trial not in pictures.moments:
        _add_picture(pictures, run)
    return run


def moments_of(spec: RunSpec, trials: int) -> Sequence[int]:
    """Trials before which a picture of the value is taken: introductions, and half way."""
    joins = {spec.schedule.introduced_at(skill) for skill in spec.learner.skills}
    half = {trials // 2} if trials == spec.trials else set()
    return sorted(trial for trial in joins | half if 0 < trial < trials)


def _add_picture(pictures: Pictures, run: Run) -> None:
    utility = np.nan_to_num(tables(run.spec, run.state)["selection_q"], nan=-np.inf).max(axis=-1)
    found = measures.folded_value(utility, run.spec.world.capture_reward, run.spec.learner.gamma)
    pictures.moments.append(run.trial)
    pictures.share.append(found.share)
    pictures.distance.append(found.distance)


def _is_good_enough(run: Run, stop: Stop) -> bool:
    is_between_trials = run.state.tally[TRIAL_STEP] == 0
    if run.trial < stop.trials or not is_between_trials:
        return False
    captures = measures.endings(run.state, stop.trials).captures
    return captures >= stop.success * stop.trials


# --- What is kept of it --------------------------------------------------------------------------


def arrays_of(run: Run, pictures: Pictures) -> dict[str, np.ndarray]:
    """What is kept of a run beside its row.

    ``outcome (trial,) int8``, ``steps (trial,) int32``, ``introductions (skill, [trial, step])
    int64``, and the names of these skills, ``introduced (skill,)``. Of the pictures of its value:
    ``moments (moment,) int64``, ``value_share`` and ``value_distance (moment, ring, direction)
    float32``, as :func:`learners.measures.folded_value` has them.
    """
    done = measures.trials_done(run.state)
    joined = run.control.introductions
    shape = -1, run.spec.world.n_distances, run.spec.world.n_directions
    moments = np.array([[entry.trial, entry.step] for entry in joined], np.int64)
    return {
        "outcome": run.state.log_outcome[:done],
        "steps": run.state.log_steps[:done],
        "introductions": moments.reshape(-1, 2),
        "introduced": np.array([entry.skill for entry in joined], "U32"),
        "moments": np.array(pictures.moments, np.int64),
        "value_share": np.array(pictures.share, np.float32).reshape(shape),
        "value_distance": np.array(pictures.distance, np.float32).reshape(shape),
    }
