"""Branches are begun, and made up to where the live run is; in the thread that makes moments.

A branch is worth as much as it can be compared: so it is made up to the live run's trial, and at
least ``LEAST_TRIALS`` beyond where it branched off, whether or not somebody looks at it. That is
the least urgent of all that is made: a slice at a time, and only while no moment is wanted.
"""

import logging
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from app.live.lines import Family, Line, known_of
from app.live.past import Budget, Past
from app.live.places import Place
from app.live.records import MOST_COMMANDS
from learners.commands import Command, CommandError
from learners.control import Control
from learners.kernel.state import digest
from learners.names import MAX_TRIALS
from learners.repeats import without_repeats
from learners.run import Run

log = logging.getLogger(__name__)

LEAST_TRIALS: Final = 3_000
"""That a branch is made beyond where it branched off."""
MOST_STEPS: Final = 40_000_000
"""Of a branch; beyond, it is made only as the live run."""

_LAG_TRIALS: Final = 500
"""By which a live run that goes on may be ahead before the branches follow."""
_SLICE_STEPS: Final = 50_000
"""Made before it is asked whether a moment is wanted: some two milliseconds."""
_TELL_S: Final = 0.25

NameOf = Callable[[Control, int, Sequence[Command]], str]
"""A name for a branch: of what held before its commands, the running trial there, and these."""


def plain_name(before: Control, trial: int, commands: Sequence[Command]) -> str:
    """A name for whoever knows none that says more."""
    return "branch"


@dataclass(frozen=True)
class Begun:
    """A branch that has been begun, and is to be put into the tree."""

    family: Family
    parent: int
    step: int
    """Of the parent, at which it branches off."""
    run: Run
    before: Control
    """What held there before its commands."""
    commands: tuple[Command, ...]
    name: str
    """Computed of these."""
    instead_of: Line | None = None
    """The branch whose place it takes."""
    viewer: int | None = None
    """Who gave the last of its commands."""

    def line(self, number: int, budget: Budget) -> Line:
        """The line that comes of it."""
        return Line(
            number=number,
            past=Past(self.run, budget),
            known=known_of(self.run),
            parent=self.parent,
            fork_step=self.step,
            fork_trial=self.run.trial,
            before=self.before,
            commands=self.commands,
            plain_name=self.name,
        )


def begin(
    family: Family, place: Place, commands: Sequence[Command], amends: bool, name_of: NameOf
) -> Begun:
    """Begin a branch by commands at a moment of a line.

    Args:
        family: the tree.
        place: the moment, on the line that it is of.
        commands: that are given there.
        amends: whether they are more of those by which that line branched off.
        name_of: computes its name.

    Raises:
        CommandError: one of them cannot be carried out there.
    """
    line = family.line(place.line)
    run = run_at(line.past, place.step)
    before, parent, earlier = run.control, line.number, ()
    if amends:
        assert line.before is not None
        assert line.parent is not None
        before, parent, earlier = line.before, line.parent, line.commands
    for command in commands:
        run.apply(command, replacing=True)
    all_of_them = _that_hold(before, run.control) or (*earlier, *commands)
    fewer = without_repeats(all_of_them)
    if fewer != all_of_them and _lead(family.line(parent).past, place.step, fewer) == run.control:
        all_of_them = fewer
    if len(all_of_them) > MOST_COMMANDS:
        raise CommandError(
            f"{MOST_COMMANDS:,} things were done at that very moment, as many as may be; go a step"
            " on"
        )
    return Begun(
        family=family,
        parent=parent,
        step=place.step,
        run=run,
        before=before,
        commands=all_of_them,
        name=name_of(before, run.trial, all_of_them),
        instead_of=line if amends else None,
    )


def _lead(past: Past, step: int, commands: Sequence[Command]) -> Control:
    """What holds at a moment of a line once some commands have been given there."""
    run = run_at(past, step)
    for command in commands:
        run.apply(command, replacing=True)
    return run.control


def _that_hold(before: Control, after: Control) -> tuple[Command, ...]:
    """Commands by hand that lead from one moment of control to another, if it is by them alone.

    Of those that were given there, the ones that later ones made void are no more.
    """
    known = len(before.history)
    if after.history[:known] != before.history:
        return ()
    return tuple(event.command for event in after.history[known:] if event.author == "hand")


def run_at(past: Past, step: int) -> Run:
    """A run of its own that stands at a moment of a line, however long it takes."""
    run = past.run_at(step)
    assert run is not None
    return run


class Growth:
    """Makes branches up to where the live run is."""

    def __init__(
        self,
        do_meanwhile: Callable[[Callable[[], bool], Callable[[str], object]], object],
        tell: Callable[[], object],
    ) -> None:
        """Prepare it.

        Args:
            do_meanwhile: as :meth:`app.live.moments.Moments.do_meanwhile`.
            tell: called in the thread of moments, some times a second, when more is known.
        """
        self._do_meanwhile = do_meanwhile
        self._tell = tell
        self._told_s = 0.0
        self._lines: tuple[Line, ...] = ()
        self._goal = 0
        self._starting = threading.Lock()
        self._is_going = False
        self._runs: dict[Line, Run] = {}
        """Of the lines that are not where they are to be yet."""
        self._making: Line | None = None

    def follow(self, lines: Sequence[Line], trial: int, stands: bool) -> None:
        """Make these up to a trial that the live run is in, and in which it may stand still."""
        if stands or not 0 <= trial - self._goal < _LAG_TRIALS:
            self._goal = trial
        self._lines = tuple(lines)
        with self._starting:
            if self._is_going or not any(map(self.is_behind, self._lines)):
                return
            self._is_going = True
        self._do_meanwhile(self._grow, self._broke_off)

    def is_behind(self, line: Line) -> bool:
        """Whether a line that is followed is not where it is to be yet."""
        known = line.known
        return not line.is_broken and known.trial < self._until(line) and known.step < MOST_STEPS

    def leave(self, line: Line) -> None:
        """Make no more of a line that is followed no more; in the thread of moments alone."""
        self._runs.pop(line, None)
        self._lines = tuple(other for other in self._lines if other is not line)

    # What the thread of moments does

    def _grow(self) -> bool:
        """Make a slice of the branch of which least is known; returns whether there is more."""
        with self._starting:
            # What is said meanwhile is either seen here, or begins anew.
            lines = self._lines
            behind = [line for line in lines if self.is_behind(line)]
            self._is_going = bool(behind)
        for line in [line for line in self._runs if line not in lines]:
            del self._runs[line]
        if not behind:
            return False
        line = min(behind, key=lambda line: line.known.trial - line.fork_trial)
        self._making = line
        run = self._runs.get(line) or run_at(line.past, line.known.step)
        self._runs[line] = run
        until = self._until(line)
        run.advance(min(_SLICE_STEPS, MOST_STEPS - run.step), until)
        line.past.note(run)
        rests = run.trial >= until or run.step >= MOST_STEPS
        line.known = known_of(run, digest(run.state) if rests else "")
        if rests:
            del self._runs[line]
        now_s = time.perf_counter()
        if rests or now_s - self._told_s >= _TELL_S:
            self._told_s = now_s
            self._tell()
        return True

    def _broke_off(self, reason: str) -> None:
        """Leave a line as it is; the others go on."""
        line = self._making
        log.error("a branch could not be made: %s", reason)
        if line is not None:
            line.is_broken = True
        with self._starting:
            self._is_going = False
        self._tell()

    def _until(self, line: Line) -> int:
        return min(max(self._goal, line.fork_trial + LEAST_TRIALS), MAX_TRIALS)
