"""The past of one line of a session: any of its moments made again, exactly.

A run is a function of preset, seed and commands, so a moment of it is the nearest checkpoint before
it, run forward with the commands of the history. Nothing here touches the run itself: whoever
advances it tells how far it is (:meth:`Past.note`), and now and then a copy of its tables is kept.
Logs are not copied for that, since what is in them of trials that have ended never changes.

Which checkpoints are kept. What a moment costs is the way to it from the checkpoint before, so
where one is likely to look the gaps are to be small: near now, and near the places at which one
looked last. Away from these a gap may be as much wider as it is farther away; from some distance on
all gaps count alike, so that in a long run no part of the past becomes a desert. Of more than there
is memory for, that checkpoint goes first without which the gap is the least by this measure. The
beginning needs none: a run begins from its preset.

How often one is taken. Near now, not more often than every ``NEAREST_STEPS``, half a millisecond of
learning, and so seldom that it takes the learner one hundredth of its time; on the way to a moment,
where half of the way is left, a quarter, and so on, so that a hand that stays there finds one close
by, and one that draws on after the way was given up goes on from where that was.
"""

import threading
import time
import weakref
from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import numpy as np

from learners.checkpoints import Checkpoint, Logs, logs_of
from learners.commands import Event
from learners.control import Control
from learners.kernel.state import LearnerState
from learners.names import MAX_TRIALS
from learners.run import Run

MOST_BYTES: Final = 64_000_000
"""Of all checkpoints of a session, unless it is told otherwise."""
NEAREST_STEPS: Final = 20_000
"""From one checkpoint to the next at least."""

_CLOSE: Final = 5
"""Times these steps from where one looks; within, all gaps count alike."""
_FAR: Final = 50
"""Times these steps from where one looks; beyond, all gaps count alike."""
_PLACES: Final = 8
"""Places at which one looked last that are remembered."""
_SHARE: Final = 0.01
"""Of the time of whoever advances the line, for checkpoints."""
_MOST_CREDIT_S: Final = 0.002
_SLICE_STEPS: Final = 200_000
"""After which it is asked whether a moment is still wanted: some milliseconds."""
_BLOCK: Final = 256
"""Trials after which it is known at which step one began, without summing."""


class Budget:
    """The memory that the checkpoints of all lines of a session share."""

    def __init__(self, most_bytes: int = MOST_BYTES, nearest_steps: int = NEAREST_STEPS) -> None:
        """Let checkpoints take so many bytes in all, each some way from the next."""
        self.most_bytes = most_bytes
        self.nearest_steps = nearest_steps
        self.lock = threading.RLock()
        """Of all these lines, so that one may make room in another."""
        self._pasts: weakref.WeakSet[Past] = weakref.WeakSet()

    @property
    def nbytes(self) -> int:
        """Memory held."""
        with self.lock:
            return sum(past.nbytes for past in self._pasts)

    def share_with(self, past: "Past") -> None:
        """Let another line have of it, for as long as somebody holds that."""
        with self.lock:
            self._pasts.add(past)

    def keep_to(self) -> None:
        """Give up checkpoints, of the line that holds most, until no more than allowed is held."""
        with self.lock:
            while self.nbytes > self.most_bytes:
                max(self._pasts, key=lambda past: past.nbytes).thin()


class _Aim(NamedTuple):
    """A moment that somebody has begun to make, and what was known of the line then."""

    step: int
    until_trial: int
    """Trials for which there must be room on the way."""
    events: tuple[Event, ...]
    logs: Logs
    end_step: int
    era: int


def _always() -> bool:
    return True


class Past:
    """The past of one line. All methods may be called from any thread, ``note`` from one only."""

    def __init__(
        self, run: Run, budget: Budget, clock: Callable[[], float] = time.perf_counter
    ) -> None:
        """Begin with a run as it stands, which may have come far already.

        Args:
            run: the line's, or a copy of it.
            budget: that it shares with the other lines of its session.
            clock: in seconds; by it checkpoints are taken seldom enough.
        """
        self._budget = budget
        self._lock = budget.lock
        self._clock = clock
        self._noted_s = clock()
        self._credit_s = _MOST_CREDIT_S
        self._seed = run.seed
        self._control: Control = run.control
        self._state: LearnerState | None = None
        self._logs = logs_of(run.state)
        self._end_step = 0
        self._end_trial = 0
        self._era = 0
        """Counts how often moments ceased to be of this line."""
        self._steps: list[int] = []
        """Of the checkpoints, in order; no two are the same."""
        self._checkpoints: list[Checkpoint] = []
        self._nbytes = 0
        self._looked: deque[int] = deque(maxlen=_PLACES)
        self._starts = np.zeros(1, np.int64)
        """Step at which each ``_BLOCK``-th trial began."""
        budget.share_with(self)
        self.note(run)

    # What whoever advances the line tells

    def note(self, run: Run) -> None:
        """Take in how far the line is; to be called after each advance and each command.

        A run that stands at an earlier moment than the last time ends the line there.
        """
        now_s, step = self._clock(), run.step
        with self._lock:
            if step < self._end_step:
                self._cut(step)
            elif run.control is not self._control:
                # A command that takes another one's place ends what that had made.
                kept = bisect_left(self._steps, step)
                while kept < len(self._steps) and _goes_before(
                    self._checkpoints[kept].control, run.control
                ):
                    kept += 1
                self._give_up(slice(kept, None))
            if run.state is not self._state:
                self._state, self._logs = run.state, logs_of(run.state)
            self._control, self._end_step, self._end_trial = run.control, step, run.trial
            last = self._steps[-1] if self._steps else 0
        credit_s = self._credit_s + _SHARE * (now_s - self._noted_s)
        self._noted_s, self._credit_s = now_s, min(credit_s, _MOST_CREDIT_S)
        if step - last >= self._budget.nearest_steps and self._credit_s > 0:
            self._keep(run.checkpoint())
            self._credit_s -= self._clock() - now_s

    # What is known

    @property
    def end_step(self) -> int:
        """Steps of it that are known."""
        return self._end_step

    @property
    def end_trial(self) -> int:
        """Trials of it that have ended."""
        return self._end_trial

    @property
    def seed(self) -> int:
        """Of its run."""
        return self._seed

    @property
    def control(self) -> Control:
        """What holds where what is known of it ends."""
        return self._control

    @property
    def logs(self) -> Logs:
        """Those of its run, of trials up to the last that has ended; not to be written to."""
        with self._lock:
            return Logs(*(log[: self._end_trial] for log in self._logs))

    @property
    def outcomes(self) -> np.ndarray:
        """(trial,) how each trial ended, of those that have; not to be written to."""
        with self._lock:
            return self._logs.log_outcome[: self._end_trial]

    @property
    def nbytes(self) -> int:
        """Memory that its checkpoints take."""
        return self._nbytes

    @property
    def kept(self) -> tuple[int, ...]:
        """Steps at which there are checkpoints."""
        with self._lock:
            return tuple(self._steps)

    def step_of_trial(self, trial: int) -> int:
        """The step at which a trial began; of one that has not, where the line ends."""
        with self._lock:
            if trial > self._end_trial:
                return self._end_step
            return self._start_of(max(trial, 0))

    def trial_of_step(self, step: int) -> int:
        """Trials that had ended when so many steps were made; at most those that have ended."""
        with self._lock:
            starts, ended = self._known_starts(), self._logs.log_steps[: self._end_trial]
            block = max(int(np.searchsorted(starts, step, side="right")) - 1, 0)
            first = block * _BLOCK
            ends = starts[block] + np.cumsum(ended[first : first + _BLOCK], dtype=np.int64)
            return first + int(np.searchsorted(ends, step, side="right"))

    def is_still(self, step: int, control: Control) -> bool:
        """Whether what held at a step once is what holds at that moment of the line now."""
        with self._lock:
            newest, end_step = self._control, self._end_step
        later = newest.history[len(control.history) :]
        return (
            step <= end_step
            and _goes_before(control, newest)
            and not _given_before(step + 1, later)
        )

    # Moments

    def run_at(
        self, step: int, is_wanted: Callable[[], bool] = _always, quietly: bool = False
    ) -> Run | None:
        """An independent run that stands at a moment of the line, all that was given by then done.

        Args:
            step: of the moment; beyond what is known, where that ends.
            is_wanted: asked every few milliseconds; once it says no, that is the end of it.
            quietly: keep no checkpoints for it, so that whoever else looks finds what they had.

        Returns:
            The run, or None if it was not wanted any more.
        """
        with self._lock:
            aim = self._aim(step)
            if not quietly:
                self._look_at(aim.step)
            before = bisect_right(self._steps, aim.step) - 1
            checkpoint = self._checkpoints[before] if before >= 0 else None
            preset = self._control.preset
        if checkpoint is None:
            run = Run(preset, self._seed)
        else:
            # With some more, so that they need not be copied again if it goes on a little.
            room = aim.until_trial + aim.until_trial // 8 + _BLOCK
            run = Run.restored(checkpoint, aim.logs, room)
        return run if self._take_on(run, aim, is_wanted, quietly) else None

    def take_on(self, run: Run, step: int) -> bool:
        """Advance a run of this line to a later moment of it.

        Returns:
            Whether it is there; where not, the line has gone another way since the run was made, or
            ends before it, and nothing was done.
        """
        with self._lock:
            aim, control = self._aim(step), self._control
        if run.step > aim.step or not _goes_before(run.control, control):
            return False
        if _given_before(run.step, aim.events[len(run.control.history) :]):
            # The line was cut before where the run stands, and went another way from there.
            return False
        return self._take_on(run, aim, _always)

    def drop(self) -> None:
        """Give up all checkpoints; moments can still be made, all the way from the beginning."""
        with self._lock:
            self._give_up(slice(0, None))

    def thin(self) -> None:
        """Give up the checkpoint that is missed least."""
        with self._lock:
            if not self._steps:
                return
            steps = np.array([0, *self._steps, self._end_step])
            gaps, at = steps[2:] - steps[:-2], steps[1:-1]
            looked = np.array([self._end_step, *self._looked])
            away = np.abs(at[:, None] - looked).min(axis=1)
            nearest = self._budget.nearest_steps
            near = np.clip(away, _CLOSE * nearest, _FAR * nearest)
            least = int(np.argmin(gaps / near))
            self._give_up(slice(least, least + 1))

    # How

    def _aim(self, step: int) -> _Aim:
        step = min(max(step, 0), self._end_step)
        return _Aim(
            step=step,
            until_trial=min(self.trial_of_step(step) + 1, MAX_TRIALS),
            events=self._control.history,
            logs=self._logs,
            end_step=self._end_step,
            era=self._era,
        )

    def _take_on(
        self, run: Run, aim: _Aim, is_wanted: Callable[[], bool], quietly: bool = False
    ) -> bool:
        """Advance a run of this line to a moment; returns whether it was wanted to the end."""
        ahead = [
            event
            for event in aim.events[len(run.control.history) :]
            if event.author == "hand" and event.step <= aim.step
        ]
        stops = deque[int]() if quietly else self._stops(run.step, aim.step)
        for event in ahead:
            if not self._advance(run, event.step, stops, aim, is_wanted):
                return False
            run.apply(event.command)
        return self._advance(run, aim.step, stops, aim, is_wanted)

    def _stops(self, step: int, until: int) -> deque[int]:
        """Where to leave checkpoints on the way from one step to another."""
        stops: deque[int] = deque()
        nearest = self._budget.nearest_steps
        while until - step >= 2 * nearest:
            step += (until - step) // 2
            stops.append(step)
        return stops

    def _advance(
        self,
        run: Run,
        until: int,
        stops: deque[int],
        aim: _Aim,
        is_wanted: Callable[[], bool],
    ) -> bool:
        since = run.step
        while run.step < until:
            if not is_wanted():
                if run.step - since >= self._budget.nearest_steps:
                    self._leave(run, aim)
                return False
            to = min(until, run.step + _SLICE_STEPS, *list(stops)[:1])
            if run.advance(max_steps=to - run.step, until_trial=aim.until_trial) == 0:
                raise RuntimeError(f"step {until:,} of the line cannot be made again")
            if stops and run.step >= stops[0]:
                stops.popleft()
                self._leave(run, aim)
        return True

    def _leave(self, run: Run, aim: _Aim) -> None:
        """Keep a checkpoint on the way to a moment.

        Commands that are given meanwhile come later than what was known of the line, and change
        nothing before that.
        """
        checkpoint = run.checkpoint()
        with self._lock:
            if self._era == aim.era and checkpoint.step < aim.end_step:
                self._keep(checkpoint)

    def _keep(self, checkpoint: Checkpoint) -> None:
        with self._lock:
            place = bisect_left(self._steps, checkpoint.step)
            if place < len(self._steps) and self._steps[place] == checkpoint.step:
                self._give_up(slice(place, place + 1))
            self._steps.insert(place, checkpoint.step)
            self._checkpoints.insert(place, checkpoint)
            self._nbytes += checkpoint.nbytes
            self._budget.keep_to()

    def _give_up(self, which: slice) -> None:
        self._nbytes -= sum(checkpoint.nbytes for checkpoint in self._checkpoints[which])
        del self._steps[which]
        del self._checkpoints[which]

    def _cut(self, step: int) -> None:
        """Let the line end at a step."""
        self._era += 1
        self._give_up(slice(bisect_left(self._steps, step), None))
        self._starts = self._starts[: int(np.searchsorted(self._starts, step, side="right"))]

    def _look_at(self, step: int) -> None:
        close = _CLOSE * self._budget.nearest_steps
        near = [place for place in self._looked if abs(place - step) < close]
        for place in near:
            self._looked.remove(place)
        self._looked.append(step)

    def _start_of(self, trial: int) -> int:
        starts = self._known_starts()
        block = min(trial // _BLOCK, starts.size - 1)
        rest = self._logs.log_steps[block * _BLOCK : trial]
        return int(starts[block]) + int(rest.sum(dtype=np.int64))

    def _known_starts(self) -> np.ndarray:
        """Steps at which each ``_BLOCK``-th trial began, as far as trials have ended."""
        known, blocks = self._starts.size - 1, self._end_trial // _BLOCK
        if blocks > known:
            steps = self._logs.log_steps[known * _BLOCK : blocks * _BLOCK]
            new = steps.reshape(-1, _BLOCK).sum(axis=1, dtype=np.int64)
            self._starts = np.append(self._starts, self._starts[-1] + np.cumsum(new))
        return self._starts


def _goes_before(earlier: Control, later: Control) -> bool:
    """Whether a history begins with another, whatever has been undone of that since."""
    if earlier.history is later.history:
        return True
    return len(earlier.history) <= len(later.history) and all(
        one is other or _as_given(one) == _as_given(other)
        for one, other in zip(earlier.history, later.history, strict=False)
    )


def _given_before(step: int, events: Sequence[Event]) -> bool:
    """Whether one of some events was given by hand before a step."""
    return any(event.author == "hand" and event.step < step for event in events)


def _as_given(event: Event) -> tuple[object, ...]:
    return event.number, event.step, event.command, event.author, event.cause
