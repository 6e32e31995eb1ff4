"""What looks at a run on its way: at which moments, and what it notes down.

A run is led from one moment to the next (:class:`Agenda`). That it is looked at changes nothing of
it: a probe reads its tables, and learns nothing into them.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from app.metrics.course import CURVE_HUNTS, Greedy, GreedyCurve, coherence_of, greedy_of
from learners import measures
from learners.kernel.state import tables
from learners.measures import Coherence
from learners.names import MAX_TRIALS
from learners.run import Run
from learners.spec import RunSpec

_NEVER = 2**62


class Probe(NamedTuple):
    """Something that looks at a run at some of its moments."""

    look: Callable[[Run], object]
    trials: Iterable[int] = ()
    """Trials before the start of which it looks, from 0, upwards."""
    steps: Iterable[int] = ()
    """Steps after which it looks, upwards, be it in the midst of a trial."""
    or_end: bool = False
    """Whether it looks at the end of a run that does not come to all of these."""


class Agenda:
    """The moments of a run at which any of some probes looks."""

    def __init__(self, probes: Iterable[Probe]) -> None:
        self._watches = [_Watch(probe) for probe in probes]

    @property
    def next_trial(self) -> int:
        """Trial before which a probe looks next."""
        return min((watch.trial for watch in self._watches), default=_NEVER)

    @property
    def next_step(self) -> int:
        """Step after which a probe looks next."""
        return min((watch.step for watch in self._watches), default=_NEVER)

    def look(self, run: Run) -> None:
        """Let look what is due, in the order of the probes."""
        for watch in self._watches:
            if watch.passes(run):
                watch.probe.look(run)

    def end(self, run: Run) -> None:
        """Let look what wanted to see more of a run that is over."""
        for watch in self._watches:
            if watch.probe.or_end and min(watch.trial, watch.step) < _NEVER:
                watch.probe.look(run)


class _Watch:
    """A probe, and when it looks next."""

    def __init__(self, probe: Probe) -> None:
        self.probe = probe
        self._trials, self._steps = iter(probe.trials), iter(probe.steps)
        self.trial, self.step = next(self._trials, _NEVER), next(self._steps, _NEVER)

    def passes(self, run: Run) -> bool:
        """Whether a run has come to a moment of it; each is passed once."""
        is_due = False
        while self.trial <= run.trial:
            self.trial, is_due = next(self._trials, _NEVER), True
        while self.step <= run.step:
            self.step, is_due = next(self._steps, _NEVER), True
        return is_due


# --- Pictures of the value -----------------------------------------------------------------------


class Pictures:
    """The folded value at some moments of a run."""

    def __init__(self) -> None:
        self.moments: list[int] = []
        """Trials that were about to start."""
        self.share: list[np.ndarray] = []
        """(ring, direction) for each."""
        self.distance: list[np.ndarray] = []

    def probe(self, spec: RunSpec, trials: int) -> Probe:
        """What takes them: at introductions, half way, and after so many trials or at the end."""
        return Probe(self._take, [*moments_of(spec, trials), trials], or_end=True)

    def _take(self, run: Run) -> None:
        if run.trial in self.moments:
            return
        q = np.nan_to_num(tables(run.spec, run.state)["selection_q"], nan=-np.inf)
        reward, gamma = run.spec.world.capture_reward, run.spec.learner.gamma
        found = measures.folded_value(q.max(axis=-1), reward, gamma)
        self.moments.append(run.trial)
        self.share.append(found.share)
        self.distance.append(found.distance)


def moments_of(spec: RunSpec, trials: int) -> Sequence[int]:
    """Trials before which a picture of the value is taken: introductions, and half way."""
    joins = {spec.schedule.introduced_at(skill) for skill in spec.learner.skills}
    half = [trials // 2] if trials == spec.trials else []
    return sorted(trial for trial in {*joins, *half} if 0 < trial < trials)


# --- Greedy reward -------------------------------------------------------------------------------


class GreedyNotes:
    """What a learner would have come to, greedily, at some moments of its run."""

    def __init__(self) -> None:
        self.final: Greedy | None = None
        self.at_horizon: Greedy | None = None
        self.coherence: Coherence | None = None
        self._points: list[tuple[int, int, float]] = []
        self._latest: tuple[int, Greedy] | None = None

    @property
    def curve(self) -> GreedyCurve:
        """Its points so far."""
        trial, step, reward = zip(*self._points, strict=True) if self._points else ((), (), ())
        return GreedyCurve(
            np.array(trial, np.int64), np.array(step, np.int64), np.array(reward, np.float32)
        )

    def final_probe(self, trials: int) -> Probe:
        """What measures after so many trials, or where a run ends before."""
        return Probe(self._measure_final, [trials], or_end=True)

    def coherence_probe(self, trials: int) -> Probe:
        """What says how steadily it hunts, when the final measurement is made."""
        return Probe(self._measure_coherence, [trials], or_end=True)

    def horizon_probe(self, horizon: int) -> Probe:
        """What measures after so many steps; a run that ends before has nothing there."""
        return Probe(self._measure_at_horizon, steps=[horizon])

    def curve_probe(self, every: int) -> Probe:
        """What adds a point to the curve every so many trials, and at the end."""
        return Probe(self._add_point, range(every, MAX_TRIALS + every, every), or_end=True)

    def _measure_final(self, run: Run) -> None:
        self.final = self._greedy_of(run)

    def _measure_coherence(self, run: Run) -> None:
        self.coherence = coherence_of(run)

    def _measure_at_horizon(self, run: Run) -> None:
        self.at_horizon = self._greedy_of(run)

    def _greedy_of(self, run: Run) -> Greedy:
        if self._latest is None or self._latest[0] != run.step:
            self._latest = run.step, greedy_of(run)
        return self._latest[1]

    def _add_point(self, run: Run) -> None:
        if not self._points or self._points[-1][1] != run.step:
            found = greedy_of(run, CURVE_HUNTS)
            self._points.append((run.trial, run.step, found.reward))
