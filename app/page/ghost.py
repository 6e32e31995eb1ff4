"""The run that stands behind the one that is shown, where there is one to compare it with.

Behind a run that was changed by hand it is the preset's own: the same seed with nothing done, made
again in a thread of its own, which takes a fraction of a second for a whole timed run. Behind a run
that was started again it is the run before, and behind a branch the line that it left.
"""

from collections.abc import Callable
from typing import Final, NamedTuple

from app.charts.bar.axis import last_trial
from app.charts.bar.model import Ghost
from app.live.places import LineSeen
from app.live.snapshot import Snapshot, curve_window, curve_window_trials
from app.live.status import Status
from app.util.background import Maker
from learners import measures
from learners.commands import Event, Undo
from learners.run import Run
from learners.spec import RunSpec

_SLICE_STEPS: Final = 200_000
"""Between two looks at whether it is still wanted."""
_MOST_STEPS: Final = 40_000_000
"""A longer run is made again up to there: that takes seconds, once."""
_MOST_RUNS: Final = 16
"""Runs whose predecessors are kept, for those who go back to one."""
_LEAST_TRIALS: Final = 100

OWN_NAME: Final = "the preset's own run"
FORMER_NAME: Final = "the run before"


def ghost_run(
    spec: RunSpec, seed: int, until_trial: int, is_wanted: Callable[[], bool]
) -> Ghost | None:
    """A run in which nothing is done by hand; None if it was not wanted to its end."""
    run = Run(spec, seed)
    while run.trial < until_trial and run.step < _MOST_STEPS:
        if not is_wanted():
            return None
        run.advance(max_steps=_SLICE_STEPS, until_trial=until_trial)
    return Ghost(
        OWN_NAME,
        f"With seed {seed} as well, but nothing done by hand",
        measures.curve(run.state, curve_window(run.step)),
        measures.curve_over_trials(run.state, curve_window_trials(run.trial)),
        measures.progress(run.state),
    )


def is_changed_by_hand(history: tuple[Event, ...]) -> bool:
    """Whether a run may differ from its preset's own.

    What was taken back before another step was made has left no trace.
    """
    taken_back = {
        event.command.number
        for event in history
        if isinstance(event.command, Undo) and history[event.command.number].step == event.step
    }
    return any(
        event.author == "hand"
        and event.number not in taken_back
        and not isinstance(event.command, Undo)
        for event in history
    )


class _Wish(NamedTuple):
    generation: int
    until_trial: int


class GhostWatch:
    """Ghosts of the runs of a session; one loop calls :meth:`follow`."""

    def __init__(self) -> None:
        self._made: Maker[Ghost | None] = Maker()
        self._closed = False
        self.latest: Ghost | None = None
        """What :meth:`follow` found last."""
        self._last: Snapshot | None = None
        """Of the run that was shown last."""
        self._before: dict[int, Ghost | None] = {}
        """What was shown before each run that began here, by its number."""

    def follow(self, status: Status) -> Ghost | None:
        """What the run that is shown is to be compared with, if there is anything yet.

        It is the same object until it is another.
        """
        snapshot = status.snapshot
        self._note(status)
        if status.story is not None:
            # A curve that went on for longer would answer what a lesson asks.
            self.latest = None
        elif is_changed_by_hand(snapshot.control.history):
            self.latest = self._own(snapshot)
        else:
            self.latest = self._before.get(snapshot.generation)
        return self.latest

    def stop(self) -> None:
        """Make nothing more."""
        self._closed = True
        self._made.stop()

    def _note(self, status: Status) -> None:
        """Keep the curves of the run before, once another has begun."""
        last, snapshot = self._last, status.snapshot
        number = snapshot.generation
        if last is not None and number not in self._before and last.generation != number:
            is_new = status.opened is None and last.generation < number
            self._before[number] = self._behind_new(last) if is_new else None
            for old in list(self._before)[:-_MOST_RUNS]:
                del self._before[old]
        self._last = snapshot

    def _behind_new(self, last: Snapshot) -> Ghost | None:
        """What is to be compared with a run that begins; one that hardly began is no example."""
        if last.trial < _LEAST_TRIALS:
            return self._before.get(last.generation)
        return _former(last)

    def _own(self, snapshot: Snapshot) -> Ghost | None:
        spec, seed, until = snapshot.preset_spec, snapshot.seed, last_trial(snapshot)
        # A specification can be long to compare, and is the same object for the whole of a run.
        of = _Wish(snapshot.generation, until)
        self._made.want(of, lambda: ghost_run(spec, seed, until, lambda: not self._closed))
        made_of, found = self._made.latest
        is_of_run = isinstance(made_of, _Wish) and made_of.generation == snapshot.generation
        return found if is_of_run and isinstance(found, Ghost) else None


def ghost_of_line(line: LineSeen, end: Snapshot) -> Ghost:
    """A line, given the last moment that is known of it, behind one that branched off it."""
    name = "the live run" if line.is_live else line.name or "the run it left"
    hint = f"Which this one left, as far as it is known: trial {end.trial:,}"
    return Ghost(name, hint, end.curve, end.trial_curve, end.progress)


def _former(snapshot: Snapshot) -> Ghost:
    return Ghost(
        FORMER_NAME,
        f"{snapshot.preset}, seed {snapshot.seed}, as far as it had come: trial {snapshot.trial:,}",
        snapshot.curve,
        snapshot.trial_curve,
        snapshot.progress,
    )
