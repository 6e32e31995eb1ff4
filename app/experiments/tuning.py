"""Weights of skills, tuned in one at a time by the global reward; for the command line alone.

Where a rule selects and nothing learns to, each skill's local reward has to be weighed against the
others' (section 3.2). The thesis proposes to *tune in* the weights (section 5.2), as its timed
learner lets skills in: the first skill alone, with a weight of 1; then the next one beside it, with
each weight of a grid in turn, while the weights found so far are held still; and so on.

The problem: of n skills and g weights, find the weights with the largest global reward, the mean
reward per trial up to a horizon (``horizon_area`` of :mod:`app.metrics`), averaged over seeds. The
operator: for skill k, argmax over the grid of w of the reward of (w_1, ..., w_{k-1}, w), where only
the first k skills are there. It stops when the last skill is in: 1 + g (n - 1) sets of weights are
tried, where all combinations would be g to the power of n - 1. Only ratios of weights matter to the
rules, so that the first one is 1 takes nothing away.

What is best on a few seeds owes that to chance in part. So the weights that were found are judged
by other seeds, beside weights of 1.
"""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from app.analysis import estimates
from app.analysis.estimates import Estimate
from app.documents.experiments import Experiment
from app.documents.variants import Variant
from app.experiments.crews import Crew
from app.experiments.record import Record
from app.experiments.runner import Progress, run_experiment
from app.experiments.seeds import SeedFailedError
from app.experiments.task import Finished
from learners.names import MAX_TRIALS
from learners.spec import RunSpec

GRID: Final = (0.0, *(2.0**power for power in range(-4, 5)))
"""Weights that are tried: 0, with which a skill is there and wants nothing, and from a sixteenth to
16, each twice the one before."""
HORIZON: Final = 4_000_000
"""Steps over which the reward is taken."""

AREA: Final = "horizon_area"
"""What the search goes by: mean reward per trial up to the horizon."""
END: Final = "horizon_reward"
"""Mean reward of the last 2,000 trials before it."""
_METRICS: Final = (AREA, END)

Weights = Mapping[str, float]
"""Of the skills that are there, in their order."""
BySeed = Mapping[int, float]


class TuningError(Exception):
    """The weights of a preset cannot be tuned; the message says why, and what would be allowed."""


class Plan(NamedTuple):
    """What is tried, and by what it is judged."""

    grid: Sequence[float]
    seeds: Sequence[int]
    """That the search sees."""
    judge_seeds: Sequence[int]
    """That it does not."""
    horizon: int
    """In steps."""


class Tried(NamedTuple):
    """A weight, and what came of it."""

    weight: float
    rewards: BySeed
    """NaN where no trial was over by the horizon."""

    @property
    def mean(self) -> float:
        """Over the seeds that have a reward; NaN where none has."""
        there = list(estimates.known(self.rewards).values())
        return sum(there) / len(there) if there else math.nan


class Stage(NamedTuple):
    """A skill that was let in."""

    skill: str
    tried: Sequence[Tried]
    weight: float
    """That was best, and is kept."""

    @property
    def is_at_an_end(self) -> bool:
        """Whether weights beyond those that were tried may be better still."""
        tried = [each.weight for each in self.tried if each.weight]
        return len(tried) > 1 and self.weight in (min(tried), max(tried))


@dataclass(frozen=True)
class Tuned:
    """Weights that were found, and what they are worth."""

    spec: RunSpec
    """The preset with them."""
    stages: Sequence[Stage]
    weights: Weights
    judged: Mapping[str, Mapping[str, Estimate]]
    """By metric: of the weights that were found (``tuned``), of weights of 1 (``ones``), and how
    much more the first are worth, seed by seed (``difference``)."""


# --- The search ----------------------------------------------------------------------------------


def search(
    skills: Sequence[str],
    grid: Sequence[float],
    rewards_of: Callable[[Sequence[Weights]], Sequence[BySeed]],
) -> list[Stage]:
    """Let skills in one at a time, each with the best weight beside those before it.

    Of weights that are equally good the one nearest to 1 is taken, by their ratio.

    Args:
        skills: in the order in which they are let in.
        grid: weights that are tried of each but the first.
        rewards_of: rewards that sets of weights get, by seed.

    Raises:
        TuningError: no set of weights has a reward.
    """
    kept: dict[str, float] = {}
    stages: list[Stage] = []
    for skill in skills:
        wanted = grid if kept else (1.0,)
        rewards = rewards_of([kept | {skill: weight} for weight in wanted])
        tried = [Tried(*each) for each in zip(wanted, rewards, strict=True)]
        best = min(tried, key=_rank)
        if math.isnan(best.mean):
            raise TuningError(
                f"ends no trial within the horizon, or all {MAX_TRIALS:,} that there may be;"
                " allowed: another --horizon"
            )
        kept[skill] = best.weight
        stages.append(Stage(skill, tried, best.weight))
    return stages


def _rank(tried: Tried) -> tuple[float, float, float]:
    """Less is better."""
    reward = -math.inf if math.isnan(tried.mean) else tried.mean
    return -reward, abs(math.log(tried.weight)) if tried.weight else math.inf, tried.weight


# --- Presets -------------------------------------------------------------------------------------


def check(spec: RunSpec) -> None:
    """Refuse a preset that has no weights to be tuned.

    Raises:
        TuningError: it has none.
    """
    learner, schedule = spec.learner, spec.schedule
    if not learner.skills:
        raise TuningError(
            f"has no skills to be weighed: its options are {learner.options};"
            " allowed: a preset with skills"
        )
    if learner.selection == "learned":
        raise TuningError(
            "learns its selection, which has no weights; allowed: another learner.selection"
        )
    first = learner.skills[0]
    if len(learner.skills) == 1:
        raise TuningError(f"has only {first} to be weighed; allowed: two skills or more")
    if schedule.rule_of(first) is None and schedule.introduced_at(first) > 0:
        raise TuningError(
            f"begins without {first}, the skill that is let in first, which joins in trial"
            f" {schedule.introduced_at(first)}; allowed: options that begin with a skill that is"
            " there from trial 0"
        )


def with_weights(spec: RunSpec, weights: Weights) -> RunSpec:
    """A preset with these skills alone, and all that it says of them, and these weights."""
    document = spec.model_dump(mode="json")
    learner, schedule = document["learner"], document["schedule"]
    timers: dict[str, Any] = schedule["skills"]
    learner |= {
        "options": [*weights],
        "weights": {**weights},
        "templates": [each for each in learner["templates"] if each["table"] in weights],
    }
    schedule |= {
        "skills": {skill: timer for skill, timer in timers.items() if skill in weights},
        "episodes": [each for each in schedule["episodes"] if each["skill"] in weights],
    }
    return RunSpec.model_validate_json(json.dumps(document))


def n_runs(spec: RunSpec, plan: Plan) -> int:
    """Runs that it takes to tune a preset and to judge it."""
    n_sets = 1 + len(plan.grid) * (len(spec.learner.skills) - 1)
    return n_sets * len(plan.seeds) + 2 * len(plan.judge_seeds)


# --- The runs ------------------------------------------------------------------------------------


def tune(
    spec: RunSpec,
    plan: Plan,
    crew: Callable[[], Crew],
    on_progress: Callable[[float, Progress], object] = lambda _done, _progress: None,
) -> Tuned:
    """Find the weights of a preset's skills, and judge them.

    Args:
        spec: the preset; weights that it has do not count.
        plan: what is tried.
        crew: makes those who make the runs; the results do not depend on them.
        on_progress: called now and then with how many of all runs are done, and how the experiment
            goes that is under way.

    Raises:
        TuningError: it has no weights to be tuned, or nothing happens within the horizon.
        SeedFailedError: a run failed; the others were stopped.
        CrewError: there is nobody to make them.
    """
    check(spec)
    runs_before = 0

    def measured(sets: Sequence[Weights], seeds: Sequence[int]) -> list[Mapping[int, Record]]:
        nonlocal runs_before
        n, before = len(sets) * len(seeds), runs_before
        specs = [with_weights(spec, weights) for weights in sets]
        found = _records_of(
            specs, seeds, plan.horizon, crew(), lambda p: on_progress(before + n * p.share, p)
        )
        runs_before += n
        return found

    def rewards_of(sets: Sequence[Weights]) -> list[BySeed]:
        return [_values(AREA, found) for found in measured(sets, plan.seeds)]

    stages = search(spec.learner.skills, plan.grid, rewards_of)
    weights = {stage.skill: stage.weight for stage in stages}
    tuned, ones = measured([weights, dict.fromkeys(weights, 1.0)], plan.judge_seeds)
    judged = {name: _judged(_values(name, tuned), _values(name, ones)) for name in _METRICS}
    return Tuned(with_weights(spec, weights), stages, weights, judged)


def _records_of(
    specs: Sequence[RunSpec],
    seeds: Sequence[int],
    horizon: int,
    crew: Crew,
    on_progress: Callable[[Progress], object],
) -> list[Mapping[int, Record]]:
    """The runs of presets up to a horizon, of each by seed."""
    variants = tuple(Variant(str(place), "tune", spec, {}) for place, spec in enumerate(specs))
    experiment = Experiment.model_construct(
        name="tune",
        text=b"",
        variants=variants,
        seeds=seeds,
        metrics=_METRICS,
        own_seeds={},
        steps=horizon,
    )
    found: dict[str, dict[int, Record]] = {variant.label: {} for variant in variants}
    failed: list[Record] = []

    def take(record: Record, finished: Finished) -> None:
        del finished  # Its log, of which the record has the numbers.
        if record.error:
            failed.append(record)
            crew.switch.end()
        found[record.variant][record.seed] = record

    run_experiment(experiment, None, crew, on_progress, take, "log")
    if failed:
        raise SeedFailedError(f"the run of seed {failed[0].seed} failed: {failed[0].gist}")
    # They came back in whatever order they were over.
    return [{seed: runs[seed] for seed in seeds} for runs in found.values()]


def _values(metric: str, records: Mapping[int, Record]) -> BySeed:
    return {seed: record.values[metric] for seed, record in records.items()}


def _judged(tuned: BySeed, ones: BySeed) -> Mapping[str, Estimate]:
    rng = estimates.bootstrap_rng
    return {
        "tuned": estimates.mean([*tuned.values()], rng()),
        "ones": estimates.mean([*ones.values()], rng()),
        "difference": estimates.compare(tuned, ones, rng()).difference,
    }
