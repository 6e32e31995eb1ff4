"""The greedy reward of the run that is shown, measured while it learns on.

What is measured are copies of moments, as they are published, in a thread of its own: never the
tables of the learner at work. So a learner that is fast is measured where a moment was caught, and
every point says at which trial and step that was.
"""

from collections.abc import Iterable
from typing import Final, NamedTuple

import numpy as np

from app.charts.bar.tree import known_until
from app.explain.cell import policy_of
from app.live.places import LineSeen
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.metrics.course import NO_CURVE, Greedy, GreedyCurve, coherence_by, greedy_by
from app.util.background import Maker
from learners.measures import Coherence

EVERY_TRIALS: Final = 2_000
"""A run is measured as soon as a moment is published after so many more trials."""
_REST_RATIO: Final = 24.0
"""Pause after a measurement as a multiple of what it took: it gets 4 % of a core at most."""
_MOST_RUNS: Final = 16
"""Runs whose curves are kept, for those who go back to one."""


class _Moment(NamedTuple):
    generation: int
    trial: int
    step: int


def greedy_at(snapshot: Snapshot) -> Greedy:
    """What hunts come to with what was learned by a moment, from the starts all runs share."""
    return greedy_by(snapshot.world, policy_of(snapshot), snapshot.spec.world)


class _Measured(NamedTuple):
    greedy: Greedy
    coherence: Coherence


def _measured_at(snapshot: Snapshot) -> _Measured:
    return _Measured(greedy_at(snapshot), coherence_by(snapshot.world, policy_of(snapshot)))


class GreedyWatch:
    """Greedy curves of the runs of a session; one loop calls :meth:`follow`."""

    def __init__(self) -> None:
        self._measured: Maker[_Measured] = Maker(rest_ratio=_REST_RATIO)
        self._curves: dict[int, GreedyCurve] = {}
        """By the number of a run, the one that was measured last at the end."""

    def follow(self, status: Status) -> GreedyCurve:
        """The curve of the run that is shown as far as it is known; measures it where that is due.

        It is the same object until there is another point.
        """
        snapshot = status.snapshot
        self._take_measured()
        curve = self._curves.get(snapshot.generation, NO_CURVE)
        if _is_due(status, curve):
            of = _Moment(snapshot.generation, snapshot.trial, snapshot.step)
            self._measured.want(of, lambda: _measured_at(snapshot))
        return curve

    def until(self, snapshot: Snapshot, lines: Iterable[LineSeen]) -> GreedyCurve:
        """What is known of the line of a moment up to there, with what it has of those it left.

        Where that is one line's, and nothing is left out, it is the same object until there is
        another point.

        Args:
            snapshot: the moment.
            lines: the tree.
        """
        parts = [
            _until(self._curves.get(number, NO_CURVE), min(snapshot.step, step))
            for number, step in known_until(snapshot.generation, lines).items()
        ]
        known = [part for part in reversed(parts) if part.step.size]
        if len(known) < 2:
            return known[0] if known else NO_CURVE
        return GreedyCurve(*(np.concatenate(each) for each in zip(*known, strict=True)))

    def stop(self) -> None:
        """Measure nothing more, and wait for what is being measured."""
        self._measured.stop()

    def _take_measured(self) -> None:
        of, found = self._measured.latest
        if not isinstance(of, _Moment) or not isinstance(found, _Measured):
            return
        curve = self._curves.pop(of.generation, NO_CURVE)
        if not curve.step.size or curve.step[-1] < of.step:
            curve = GreedyCurve(
                np.append(curve.trial, of.trial),
                np.append(curve.step, of.step),
                np.append(curve.reward, np.float32(found.greedy.reward)),
                np.append(curve.without_progress, np.float32(found.coherence.without_progress)),
            )
        self._curves[of.generation] = curve
        for former in list(self._curves)[:-_MOST_RUNS]:
            del self._curves[former]


def _until(curve: GreedyCurve, step: float) -> GreedyCurve:
    known = int(np.searchsorted(curve.step, step, side="right"))
    if known == curve.step.size:
        return curve
    return GreedyCurve(*(column[:known] for column in curve))


def _is_due(status: Status, curve: GreedyCurve) -> bool:
    """Whether a run has had enough trials since it was measured, or has come to its end."""
    trial = status.snapshot.trial
    last = int(curve.trial[-1]) if curve.trial.size else 0
    made_again = status.opened is not None and status.opened.same is not None
    at_end = status.finished or made_again
    return trial // EVERY_TRIALS > last // EVERY_TRIALS or (at_end and trial > last)
