"""Facts of a run that its log does not say, to be kept beside the log.

Each has a name, which says what it is of and when; a run has those whose moments it came to. All
are of the run's beginning, its preset's trials at most, so that a run that goes on for longer has
the same ones.
"""

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from app.experiments.probes import Probe
from learners import behaviour, measures
from learners.kernel.state import TRAIL_LENGTH
from learners.measures import FINAL_TRIALS
from learners.run import Run
from learners.spec import RunSpec
from sim.world import CAPTURE, FLIGHT

EARLY_STEPS = 100_000
"""What is early: the trials that end within so many steps, and the trail there."""
PRACTICE_STEPS = (50_000, 1_000_000)
"""At which skills are looked at: where the thesis has them do well (4.2.2), and much later."""
SOON_STEPS = 1_000_000
"""At which is looked how far value has spread."""
SOON_TRIALS = 4_000
"""In which the thesis has value spread to all states that can be reached (section 4.3.3)."""

GAINED = "early gain per step"
"""Cells by which a step of the early trials brought the predator closer."""
STAYED = "early stays"
"""Share of the steps on the early trail that ended in the reading that they started in."""
SEEN_FLEE = "starts in view that end in flight"
"""Share of these among the final trials of the preset."""
FLIGHTS_SEEN = "flights that start in view"
"""Share of the flights among those trials."""
FLIGHTS_UNSEEN = "flights that start out of view"
"""Share of the flights among those trials."""
LOST_TO_FLIGHT = "losses that are flights"
"""Share of what is no capture among those trials."""
VALUED_SOON = "states with a value at 1 M steps"
"""Share of all states whose value had risen above 0 by then."""
VALUED_A_TRIAL = "states a trial that get a value"
"""In each of the first 4,000 trials, on average."""
VALUED_EARLY = "states with a value that have it early"
"""Share of those that have one when the second skill joins, who had it after 4,000 trials."""


def progress(skill: str, step: int) -> str:
    """Name of the share of a skill's steps that make progress after so many steps of the run."""
    return f"{skill}: progress at {step:,} steps"


def distance(skill: str) -> str:
    """Name of the mean distance from the prey as the exploration of a skill ends, in cells."""
    return f"{skill}: distance as explored"


def far(skill: str) -> str:
    """Name of the share of these steps that are farther from the prey than any start."""
    return f"{skill}: far off as explored"


class Facts:
    """The facts of one run, found while it goes on."""

    def __init__(self) -> None:
        self._found: dict[str, float] = {}

    @property
    def found(self) -> dict[str, float]:
        """Those that there are so far; none of them is NaN."""
        return {name: value for name, value in self._found.items() if not math.isnan(value)}

    def probes(self, spec: RunSpec, trials: int) -> list[Probe]:
        """What looks at a run of a preset that is over after so many trials."""
        second = min(_joins(spec), default=0)
        looks: list[tuple[Callable[[Run], None], list[int], list[int]]] = [
            *((partial(self._skills, step), [], [step]) for step in PRACTICE_STEPS),
            (self._early, [], [EARLY_STEPS]),
            (self._valued_soon, [], [SOON_STEPS]),
            (self._endings, [trials] if trials >= FINAL_TRIALS else [], []),
            (partial(self._valued, second), [second] if second > SOON_TRIALS else [], []),
            *(
                (partial(self._explored, skill), [trial], [])
                for skill, trial in _explorations(spec).items()
            ),
        ]
        return [Probe(look, trials=at, steps=after) for look, at, after in looks if at or after]

    def _skills(self, step: int, run: Run) -> None:
        for skill in run.present:
            self._found[progress(skill, step)] = behaviour.progress(run, skill)

    def _early(self, run: Run) -> None:
        ended = measures.trials_done(run.state)
        if ended:
            gained = behaviour.trials(run, 0, ended).gained
            self._found[GAINED] = float(gained.sum() / run.state.log_steps[:ended].sum())
        self._found[STAYED] = behaviour.travel(run).stayed

    def _explored(self, skill: str, run: Run) -> None:
        if run.step < TRAIL_LENGTH:
            return
        found = behaviour.travel(run).distance
        self._found[distance(skill)] = float(found.mean())
        self._found[far(skill)] = float((found > run.world.start_farthest).mean())

    def _endings(self, run: Run) -> None:
        first, last = run.trial - FINAL_TRIALS, run.trial
        seen = behaviour.trials(run, first, last).seen
        outcome = run.state.log_outcome[first:last]
        fled = outcome == FLIGHT
        self._found[SEEN_FLEE] = _share(fled[seen])
        self._found[FLIGHTS_SEEN] = _share(seen[fled])
        self._found[FLIGHTS_UNSEEN] = _share(~seen[fled])
        self._found[LOST_TO_FLIGHT] = _share(fled[outcome != CAPTURE])

    def _valued_soon(self, run: Run) -> None:
        self._found[VALUED_SOON] = _share(run.state.first_reach >= 0)

    def _valued(self, second: int, run: Run) -> None:
        first_reach = run.state.first_reach
        early = int(((first_reach >= 0) & (first_reach < SOON_TRIALS)).sum())
        total = int(((first_reach >= 0) & (first_reach < second)).sum())
        self._found[VALUED_A_TRIAL] = early / SOON_TRIALS
        self._found[VALUED_EARLY] = early / total if total else math.nan


def _joins(spec: RunSpec) -> list[int]:
    """Trials before which skills join after the start."""
    found = [spec.schedule.introduced_at(skill) for skill in spec.learner.skills]
    return sorted(trial for trial in found if trial > 0)


def _explorations(spec: RunSpec) -> dict[str, int]:
    """Trials by which the explorations of the schedule are over, the last of each skill."""
    found: dict[str, int] = {}
    for episode in spec.schedule.episodes:
        end = spec.schedule.starts_at(episode) + episode.duration
        if end <= spec.trials:
            found[episode.skill] = max(found.get(episode.skill, 0), end)
    return found


def _share(of: np.ndarray) -> float:
    return float(of.mean()) if of.size else math.nan
