"""One of those that learn side by side: its run, its past, and moments of all of them."""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Literal

from app.live import snapshot
from app.live.moments import moment_at
from app.live.past import Budget, Past
from app.live.places import Place
from app.live.snapshot import Snapshot, curve_window
from app.live.wishes import Wishes
from learners.control import Control
from learners.kernel.state import digest
from learners.run import Run
from learners.spec import RunSpec

Stand = Literal["", "finished", "known", "gone"]
"""Where a racer stands: it goes on with the others, its trials are over, its line is known up to
there, or its line is not in the tree any more."""


_CATCH_UP_STEPS: Final = 400_000
"""Made at once by a racer that stands farther back than its line is known: some 20 ms."""
_numbers = itertools.count(-1, -1)
"""Of racers that are no line: so they are told from all lines, and from those of earlier races."""


@dataclass(frozen=True)
class Entry:
    """One that is to be in a race."""

    name: str
    """By which it is told from the others."""
    preset: str
    """As shown."""
    seed: int
    spec: RunSpec
    line: int | None = None
    """Number of a line of the tree, which it follows; None for a run of its own."""


class Racer:
    """One of a race. The race's thread alone has to do with it, but for its past."""

    def __init__(self, entry: Entry, past: Past | None, budget: Budget) -> None:
        """Prepare it at its beginning.

        Raises:
            ValueError: the seed is not allowed.
        """
        self.entry = entry
        self.follows = past is not None
        """Whether it is a line of the tree."""
        self.number = next(_numbers) if entry.line is None else entry.line
        self.is_gone = False
        """Whether its line is not in the tree any more."""
        self._snapshot: Snapshot | None = None
        """The last one that was taken."""
        self._curve_of = (-1, 0)
        """Step at which its curve was made, and how wide the windows were."""
        self._digested: tuple[Run | None, int, Control | None, str] = (None, 0, None, "")
        if past is None:
            self.run = Run(entry.spec, entry.seed)
            self.past = Past(self.run, budget)
        else:
            beginning = past.run_at(0, quietly=True)
            assert beginning is not None
            self.run, self.past = beginning, past

    @property
    def end(self) -> int | None:
        """The step at which it stands; None if it goes on."""
        if self.is_gone:
            return self.run.step
        if self.follows:
            return self.past.end_step
        return self.run.step if self.run.trial >= self.entry.spec.trials else None

    def is_at_end(self) -> bool:
        """Whether it can make no step now."""
        end = self.end
        return end is not None and end <= self.run.step

    def is_behind(self, step: int) -> bool:
        """Whether it is to catch up with the others, or to do again what was done otherwise."""
        if not self.follows or self.is_gone:
            return False
        past, run = self.past, self.run
        return run.step < min(step, past.end_step) or not past.is_still(run.step, run.control)

    def stand(self) -> Stand:
        """Where it stands."""
        if not self.is_at_end():
            return ""
        if self.is_gone:
            return "gone"
        return "known" if self.follows else "finished"

    def seen(self, step: int, new_curve: bool) -> Snapshot:
        """What it looks like: the same object as long as nothing is to be seen that is other.

        Args:
            step: of the race, by which the windows of its curve are chosen.
            new_curve: whether the curve is to be as new as the rest.
        """
        former, run, curve_of = self._snapshot, self.run, (self.run.step, curve_window(step))
        is_there = former is not None and former.step == run.step and former.control is run.control
        if former is None or not is_there or (new_curve and self._curve_of != curve_of):
            preset = self.entry.preset
            former = snapshot.take(run, preset, self.number, former, new_curve, step)
            self._snapshot = former
            if new_curve:
                self._curve_of = curve_of
        return former

    def digest(self) -> str:
        """Digest of its tables, made anew only if they can be others."""
        run, step, control, found = self._digested
        if run is not self.run or step != self.run.step or control is not self.run.control:
            found = digest(self.run.state)
            self._digested = (self.run, self.run.step, self.run.control, found)
        return found

    def go_to(self, step: int, is_wanted: Callable[[], bool]) -> None:
        """Stand at a step, or at its end if that comes before."""
        if self.is_gone:
            return
        if not self.follows:
            if step > self.run.step:
                self.run.advance(step - self.run.step, self.entry.spec.trials)
                self.past.note(self.run)
            return
        step = min(step, self.past.end_step)
        to = min(step, self.run.step + _CATCH_UP_STEPS)
        if not self.past.take_on(self.run, to):
            made_again = self.past.run_at(step, is_wanted)
            if made_again is not None:
                self.run = made_again


class RaceMoments(Wishes[int, tuple[Snapshot, ...]]):
    """Makes moments of a race, each wished by its step: what all were like there."""

    def __init__(self, racers: Sequence[Racer], step: Callable[[], int]) -> None:
        """Prepare; the thread begins with the first wish.

        Args:
            racers: whose moments they are.
            step: where the race is.
        """
        super().__init__("moments of a race")
        self._racers = racers
        self._step = step

    def made(
        self, step: int, is_wanted: Callable[[], bool] = lambda: True
    ) -> tuple[Snapshot, ...] | None:
        """All at one step, or at an earlier end, exactly.

        Args:
            step: of the moment; beyond where the race is, that.
            is_wanted: asked every few milliseconds; once it says no, that is the end of it.

        Returns:
            The snapshots; None if they were not wanted any more.
        """
        step = min(max(step, 0), self._step())
        found: list[Snapshot] = []
        for racer in self._racers:
            place, preset = Place(racer.number, step), racer.entry.preset
            of_one = moment_at(racer.past, place, preset, is_wanted, curve_steps=step)
            if of_one is None:
                return None
            found.append(of_one)
        return tuple(found)

    def _made(self, wish: int, is_wanted: Callable[[], bool]) -> tuple[Snapshot, ...] | None:
        return self.made(wish, is_wanted)

    def _is_still(self, wish: int, made: tuple[Snapshot, ...]) -> bool:
        step = min(wish, self._step())
        return all(
            of_one.step == min(step, racer.past.end_step)
            and racer.past.is_still(of_one.step, of_one.control)
            for racer, of_one in zip(self._racers, made, strict=True)
        )
