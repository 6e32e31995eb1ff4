"""What takes a while to find of runs side by side, found beside them: one thing at a time."""

from collections.abc import Hashable
from typing import Final, NamedTuple

from app.explain.cell import moment_of
from app.live.divergence import Divergence, first_divergence
from app.live.race import Race
from app.live.snapshot import Snapshot
from app.metrics.course import Greedy
from app.page.greedy import greedy_at
from app.page.success import success_of
from app.picture.layer import SuccessMap
from app.util.background import Maker
from learners.control import Control

_GREEDY_REST: Final = 12.0
"""Pause after a measurement as a multiple of what it took."""
_APART_REST_S: Final = 1.0
_MAP_REST_S: Final = 1.5
_EVERY_STEPS: Final = 20_000
"""A run is measured again after so many more steps at the earliest."""


class _Of(NamedTuple):
    place: int
    step: int
    trial: int


class _Pair(NamedTuple):
    one: int
    other: int
    step: int
    controls: tuple[Control, Control]


class GreedyRuns:
    """The greedy reward of each run, measured in turn."""

    def __init__(self, n_runs: int) -> None:
        self._maker: Maker[Greedy] = Maker(rest_ratio=_GREEDY_REST)
        self._known: list[list[tuple[int, float]]] = [[] for _ in range(n_runs)]
        """Step and reward of each measurement, of each run."""
        self._taken: Hashable = None
        """What the last one that was taken in is of."""

    def follow(self, snapshots: tuple[Snapshot, ...]) -> None:
        """Measure of those that are due the one whose last measurement is farthest back."""
        of, found = self._maker.latest
        if isinstance(of, _Of) and isinstance(found, Greedy) and of is not self._taken:
            self._taken = of
            known = self._known[of.place]
            if not known or known[-1][0] < of.step:
                known.append((of.step, found.reward))
        for known, snapshot in zip(self._known, snapshots, strict=True):
            # A line that is followed may have been taken back.
            while known and known[-1][0] > snapshot.step:
                known.pop()
        due = [place for place, one in enumerate(snapshots) if self._is_due(place, one)]
        if due:
            place = min(due, key=self._last)
            snapshot = snapshots[place]
            this = _Of(place, snapshot.step, snapshot.trial)
            self._maker.want(this, lambda: greedy_at(snapshot))

    def at(self, place: int, step: int) -> tuple[int, float] | None:
        """The newest measurement of a run up to a step: its own step, and the reward per trial."""
        return next((one for one in reversed(self._known[place]) if one[0] <= step), None)

    def stop(self) -> None:
        """Measure nothing more, and wait for what is being measured."""
        self._maker.stop()

    def _is_due(self, place: int, snapshot: Snapshot) -> bool:
        ended = snapshot.trial >= snapshot.spec.trials
        least = 1 if ended else _EVERY_STEPS
        return snapshot.trial > 0 and snapshot.step >= self._last(place) + least

    def _last(self, place: int) -> int:
        known = self._known[place]
        return known[-1][0] if known else -_EVERY_STEPS


class Apart:
    """Where two of the runs first went different ways, once that is known."""

    def __init__(self) -> None:
        self._maker: Maker[Divergence | None] = Maker(rest_s=_APART_REST_S)
        self._found: dict[tuple[int, int], Divergence] = {}

    def of(self, race: Race, one: int, other: int, step: int) -> Divergence | None:
        """The first difference of two; None as long as none is known.

        Args:
            race: in which they are.
            one: place of one of them.
            other: that of the other.
            step: steps that are made.
        """
        of, found = self._maker.latest
        if isinstance(of, _Pair) and isinstance(found, Divergence):
            self._found[of.one, of.other] = found
        known = self._found.get((one, other))
        pasts = race.past(one), race.past(other)
        # A line that is followed may have been taken back, and gone another way since.
        if known is not None and not all(
            past.is_still(known.step, did.control)
            for past, did in zip(pasts, known.did, strict=True)
        ):
            known = None
        if known is None and step:
            controls = pasts[0].control, pasts[1].control
            self._maker.want(
                _Pair(one, other, step, controls), lambda: first_divergence(*pasts, until=step)
            )
        return known

    def stop(self) -> None:
        """Look for nothing more, and wait for what is being looked for."""
        self._maker.stop()


class Successes:
    """Success maps of the runs, for those who look at them: of a moment ago while they go on."""

    def __init__(self) -> None:
        self._makers: dict[int, Maker[SuccessMap | None]] = {}
        """By the number of a run."""
        self._stopped = False

    def of(self, snapshot: Snapshot) -> SuccessMap | None:
        """The latest map of a run, if there is one; has it made anew."""
        maker = self._makers.setdefault(snapshot.generation, Maker(rest_s=_MAP_REST_S))
        maker.want(moment_of(snapshot), lambda: success_of(snapshot, lambda: not self._stopped))
        found = maker.found
        return found if isinstance(found, SuccessMap) else None

    def stop(self) -> None:
        """Make nothing more, and wait for what is being made."""
        self._stopped = True
        for maker in self._makers.values():
            maker.stop()
