"""Runs that several cards and lessons begin with, or are about, made once.

Where a run is the preset's own, with nothing done to it, its moments are those of all that begin
there: checkpoints are kept on its way, and logs, which only grow, are shared.
"""

from bisect import bisect_right, insort
from collections import OrderedDict
from collections.abc import Callable
from typing import Final

from learners.checkpoints import Checkpoint, logs_of
from learners.run import Run
from learners.spec import RunSpec

SLICE_STEPS: Final = 500_000
"""After which it is asked whether it is still wanted: a hundredth of a second."""
_MOST_RUNS: Final = 12
_MOST_MOMENTS: Final = 16


class GivenUpError(Exception):
    """What was being played is not wanted any more."""


def _always() -> bool:
    return True


class _Straight:
    """A run of a preset with which nothing is done, and checkpoints on its way."""

    def __init__(self, spec: RunSpec, seed: int) -> None:
        self.farthest = Run(spec, seed)
        self._checkpoints: list[tuple[int, Checkpoint]] = []

    def at(self, trial: int, wanted: Callable[[], bool]) -> Run:
        """An independent run that is about to start a trial."""
        if self.farthest.trial <= trial:
            advance(self.farthest, trial, wanted)
            self._keep()
            return self.farthest.copy()
        place = bisect_right(self._checkpoints, trial, key=_trial_of) - 1
        if place < 0:
            run = Run(self.farthest.preset, self.farthest.seed)
        else:
            run = Run.restored(self._checkpoints[place][1], logs_of(self.farthest.state))
        advance(run, trial, wanted)
        return run

    def _keep(self) -> None:
        trial = self.farthest.trial
        if len(self._checkpoints) < _MOST_MOMENTS and all(
            at != trial for at, _ in self._checkpoints
        ):
            insort(self._checkpoints, (trial, self.farthest.checkpoint()), key=_trial_of)


def _trial_of(kept: tuple[int, Checkpoint]) -> int:
    return kept[0]


class Shared:
    """Runs that several cards and lessons begin with, or are about. For one thread at a time."""

    def __init__(self, wanted: Callable[[], bool] = _always) -> None:
        """Share nothing yet; ``wanted`` is asked every few milliseconds while a run is made."""
        self.wanted = wanted
        self._runs: OrderedDict[tuple[str, int], _Straight] = OrderedDict()

    def run_at(self, spec: RunSpec, seed: int, trial: int) -> Run:
        """An independent run of a preset that is about to start a trial.

        Raises:
            GivenUpError: it is not wanted any more.
        """
        return self._straight(spec, seed).at(trial, self.wanted)

    def finished(self, spec: RunSpec, seed: int, steps: int | None = None) -> Run:
        """A run of a preset after its trials, or after some steps if these are made before; it is
        not to be advanced."""
        run = self._straight(spec, seed).farthest
        if steps is None:
            advance(run, spec.trials, self.wanted)
        while run.trial < spec.trials and steps is not None and run.step < steps:
            most = min(steps - run.step, SLICE_STEPS)
            if not self.wanted():
                raise GivenUpError
            run.advance(most, until_trial=spec.trials)
            # It stands between two trials, so that others can go on from there.
            run.advance(until_trial=min(run.trial + 1, spec.trials))
        return run

    def _straight(self, spec: RunSpec, seed: int) -> _Straight:
        key = spec.model_dump_json(), seed
        if key not in self._runs:
            self._runs[key] = _Straight(spec, seed)
            while len(self._runs) > _MOST_RUNS:
                self._runs.popitem(last=False)
        self._runs.move_to_end(key)
        return self._runs[key]


def advance(run: Run, trial: int, wanted: Callable[[], bool] = _always) -> None:
    """Let a run learn up to the start of a trial.

    Raises:
        GivenUpError: it is not wanted any more.
    """
    while run.trial < trial:
        if not wanted():
            raise GivenUpError
        if run.advance(SLICE_STEPS, until_trial=trial) == 0:
            return
