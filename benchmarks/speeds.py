"""How fast each learner is beside the timed one, and what it costs that a rule is watched.

All in one process, each run next to one of the timed learner, before it and after it by turns;
rates are steps per second of the thread's own processor time, and the median of the ratios is
given.
"""

import statistics
import time
from collections.abc import Callable, Mapping
from typing import Final, TypedDict, get_args

from app.documents import presets
from learners.kernel.state import digest
from learners.names import MAX_TRIALS
from learners.run import Run
from learners.schedule_spec import TriggerSpec
from learners.spec import RunSpec

STEPS: Final = 5_500_000
"""Of each run, as at the common horizon of experiments."""
RULES: Final[tuple[str, ...]] = get_args(TriggerSpec.model_fields["by"].annotation)
"""What a rule can watch."""


class Speed(TypedDict):
    """How fast a learner is."""

    steps_per_s: float
    ratio_to_timed: float


class Speeds(TypedDict):
    """What :func:`measure_speeds` finds."""

    learners: dict[str, Speed]
    watching: dict[str, float]
    """By what a rule watches: the rate while it does, as a share of the rate without it."""


def measure_speeds(
    specs: Mapping[str, RunSpec], repetitions: int, progress: Callable[[str], None]
) -> Speeds:
    """Time learners beside the timed one, and the timed one with a rule that is never met.

    Args:
        specs: presets by name.
        repetitions: how often each is run, with a seed of its own each time.
        progress: is told what is being done.

    Raises:
        RuntimeError: something else was learned while a rule was watched.
    """
    timed = presets.load("timed")
    learners: dict[str, Speed] = {}
    for name, spec in specs.items():
        pairs = _side_by_side(name, spec, timed, repetitions, progress)
        learners[name] = {
            "steps_per_s": statistics.median(rate for rate, _ in pairs),
            "ratio_to_timed": statistics.median(rate / beside for rate, beside in pairs),
        }
    alone = _of_approach_alone(f"{{at: {MAX_TRIALS}}}")
    watching: dict[str, float] = {}
    for by in RULES:
        rule = _of_approach_alone(f"{{at: null, introduce: {{by: {by}, below: 0}}}}")
        _check_same(by, rule, alone)
        pairs = _side_by_side(f"watching {by}", rule, alone, repetitions, progress)
        watching[by] = statistics.median(rate / beside for rate, beside in pairs)
    return {"learners": learners, "watching": watching}


def _of_approach_alone(timer: str) -> RunSpec:
    """The timed learner whose other skills join never; their timers are as given."""
    others = (f"schedule.skills.{skill}={timer}" for skill in ("circle_clockwise", "avoid"))
    return presets.load("timed", [*others, "schedule.episodes=[]"])


def _check_same(by: str, rule: RunSpec, alone: RunSpec) -> None:
    found: list[str] = []
    for spec in (rule, alone):
        run = Run(spec, 0)
        run.advance(until_trial=1_000)
        found.append(digest(run.state))
    if found[0] != found[1]:
        raise RuntimeError(f"while {by} was watched, something else was learned")


def _side_by_side(
    name: str, spec: RunSpec, other: RunSpec, repetitions: int, progress: Callable[[str], None]
) -> list[tuple[float, float]]:
    """Rates of two learners, in pairs of runs next to each other in time."""
    progress(f"{name}: warming up")
    for each in (spec, other):
        Run(each, 0).advance(max_steps=STEPS // 10, until_trial=MAX_TRIALS)
    pairs: list[tuple[float, float]] = []
    for repetition in range(repetitions):
        progress(f"{name}: repetition {repetition + 1} of {repetitions}")
        if repetition % 2 == 0:
            first, second = _rate(spec, repetition), _rate(other, repetition)
        else:
            second, first = _rate(other, repetition), _rate(spec, repetition)
        pairs.append((first, second))
    return pairs


def _rate(spec: RunSpec, seed: int) -> float:
    run = Run(spec, seed)
    start = time.thread_time()
    made = run.advance(max_steps=STEPS, until_trial=MAX_TRIALS)
    return made / (time.thread_time() - start)
