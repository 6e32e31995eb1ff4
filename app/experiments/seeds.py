"""Many seeds of one preset: an experiment with one variant, and what ``pounce run`` says of it."""

import json
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from app.analysis import estimates
from app.documents.experiments import Experiment
from app.documents.variants import Variant
from app.experiments.archive import unpacked
from app.experiments.crews import Crew
from app.experiments.record import Record
from app.experiments.runner import Progress, run_experiment
from app.experiments.task import Finished
from app.util import csv_texts
from learners import measures
from learners.spec import RunSpec

_METRICS = ("final_reward", "captures", "flights", "timeouts")


class Result(NamedTuple):
    """What is kept of a run."""

    record: Record
    curve: measures.Curve
    """Over windows of 100,000 steps."""
    phases: np.ndarray
    """(window,) float64: mean reward in each window of ``PHASE_STEPS`` of
    :mod:`app.analysis.estimates` that it went through wholly; NaN where no trial ended."""

    def as_json(self) -> dict[str, Any]:
        """As plain data, for JSON: where no trial ended in a window its reward is None."""
        record = self.record
        return {
            "seed": record.seed,
            "trials": record.trials,
            "steps": record.steps,
            "seconds": round(record.seconds, 3),
            **{name: int(record.values[name]) for name in ("captures", "flights", "timeouts")},
            "mean_reward_last_2000": record.values["final_reward"],
            "curve": {
                "steps": self.curve.steps.tolist(),
                "reward": [None if math.isnan(r) else r for r in self.curve.reward.tolist()],
            },
            "digest": record.digest,
        }


class SeedFailedError(Exception):
    """The run of a seed failed; the message says why."""


def run_seeds(
    spec: RunSpec,
    seeds: Sequence[int],
    crew: Crew,
    on_progress: Callable[[Progress], object] = lambda _: None,
    on_tables: Callable[[int, bytes], object] | None = None,
) -> list[Result]:
    """Run a preset once for each seed; results come in the order of the seeds.

    Args:
        spec: the preset.
        seeds: one for each run.
        crew: who makes the runs; the results do not depend on it.
        on_progress: called now and then in the calling thread, and once at the end.
        on_tables: called in that thread, as a run ends, with its seed and the archive of its final
            tables; these are kept nowhere else.

    Raises:
        SeedFailedError: a run failed; the others were stopped.
        CrewError: there is nobody to make them.
    """
    variant = Variant("run", "run", spec, {})
    experiment = Experiment.model_construct(
        name="run", text=b"", variants=(variant,), seeds=seeds, metrics=_METRICS, own_seeds={}
    )
    found: dict[int, Result] = {}
    failed: list[Record] = []

    def take(record: Record, finished: Finished) -> None:
        if record.error:
            failed.append(record)
            crew.switch.end()
            return
        found[record.seed] = _result(record, finished.arrays, spec)
        if on_tables is not None:
            on_tables(record.seed, finished.tables)

    kept = "log" if on_tables is None else "log and tables"
    run_experiment(experiment, None, crew, on_progress, take, kept)
    if failed:
        raise SeedFailedError(f"the run of seed {failed[0].seed} failed: {failed[0].gist}")
    return [found[seed] for seed in seeds]


def _result(record: Record, arrays: bytes, spec: RunSpec) -> Result:
    log = unpacked(arrays, record.trials, record.steps)
    reward = measures.rewards(spec.world, log.outcome)
    phases = estimates.windowed(reward, log.steps, estimates.PHASE_STEPS, "steps")
    return Result(record, measures.curve_of(reward, log.steps, record.steps), phases)


def summary(preset: str, spec: RunSpec, results: Iterable[Result]) -> str:
    """All there is to say about the runs of a preset, as one JSON object on one line."""
    document = {
        "preset": preset,
        "settings": spec.model_dump(mode="json"),
        "runs": [result.as_json() for result in results],
    }
    return json.dumps(document, allow_nan=False)


def curves_csv(results: Iterable[Result]) -> str:
    """The learning curves of runs as comma-separated values."""
    rows: list[Sequence[Any]] = [("seed", "steps", "reward")]
    for result in results:
        points = zip(result.curve.steps.tolist(), result.curve.reward.tolist(), strict=True)
        rows += [(result.record.seed, *point) for point in points]
    return csv_texts.for_programs(rows)
