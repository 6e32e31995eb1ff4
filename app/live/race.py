"""Runs side by side: learners that are compared advance in lockstep, by steps.

Each racer is a run of its own, from its beginning, or a line of the session's tree. Of a line it
has a copy, made of the line's past and followed as far as that is known; the line itself never has
anything to do with a race. Where seed and world are the same, so are the starts of trials, however
differently the learners go about them.

In one thread all racers make the same steps, a slice each, and what is published of them is of one
step. One whose trials are over stands at its end while the others go on, and so does a line as far
as it is known, until more is.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

from app.live.past import Budget, Past
from app.live.racer import Entry, RaceMoments, Racer, Stand
from app.live.snapshot import Snapshot
from app.live.worker import FULL_SPEED, Reply, Worker
from learners.commands import CommandError
from learners.spec import RunSpec

FEWEST: Final = 2
MOST: Final = 4
"""Entries of a race."""
THESIS_FOUR: Final = ("standard_q", "hierarchical_3", "timed", "hierarchical_2")
"""The presets of Figure 4.1, in its order."""


@dataclass(frozen=True)
class RaceStatus:
    """How a race stands, and the moment that was last published. Tuples are in order of entries."""

    entries: tuple[Entry, ...]
    step: int
    """Steps that all have made but those that stand at an earlier end."""
    trials: tuple[int, ...]
    """That have ended, of each."""
    playing: bool
    finished: bool
    """Nobody can go on any more."""
    error: str | None
    """What stopped it; the moment before that is kept."""
    snapshots: tuple[Snapshot, ...]
    """At ``step``, or at an earlier end."""
    stands: tuple[Stand, ...]
    speed: float
    """Steps per second that are set, of each."""
    steps_per_s: float
    """Steps per second made, of each, over the last second."""
    runs_to: int | None
    """Step at which it is to stand still, on its way there at full speed."""
    digests: tuple[str, ...]
    """Of their tables; empty while it goes on."""
    common_starts: bool
    """Whether trials of the same number start alike for all."""
    preparing: bool
    """The learner's code is being compiled, once on each machine."""
    answered: int
    """Requests answered so far: the ticket of the last one."""


def thesis_four(spec_of: Callable[[str], RunSpec], seed: int) -> tuple[Entry, ...]:
    """The four learners of Figure 4.1, for a race with common starts.

    Args:
        spec_of: a preset by its name.
        seed: of all four.
    """
    return tuple(Entry(name, name, seed, spec_of(name)) for name in THESIS_FOUR)


def common_starts(entries: Sequence[Entry]) -> bool:
    """Whether trials of the same number start alike for all of them."""
    worlds = [(entry.seed, entry.spec.world) for entry in entries]
    return len({(seed, world.size, world.start_radius) for seed, world in worlds}) == 1


def _no_line(line: int) -> None:
    """The past of a line where there are none."""


class _Play(NamedTuple):
    pass


class _Pause(NamedTuple):
    pass


class _RunTo(NamedTuple):
    step: int


class _SetSpeed(NamedTuple):
    steps_per_s: float


class _Heed(NamedTuple):
    """More of a line may be known."""


_Asked = _Play | _Pause | _RunTo | _SetSpeed | _Heed

_PUBLISH_S: Final = 1 / 33
_SLICE_S: Final = 0.008
"""Of all together. Whose turn it is finds its tables gone from the cache, so short ones cost much;
with what is published in between, they leave time for 25 pictures a second."""
_CURVE_S: Final = 0.4


class Race(Worker[RaceStatus]):
    """Two to four racers. Public methods may be called from any thread."""

    def __init__(
        self,
        entries: Sequence[Entry],
        budget: Budget,
        past_of: Callable[[int], Past | None] = _no_line,
        speed: float = FULL_SPEED,
        playing: bool = False,
    ) -> None:
        """Prepare them at their beginnings; :meth:`start` sets them going.

        Args:
            entries: two to four, of different names.
            budget: memory for checkpoints, which they share with the lines of a session.
            past_of: past of a line by its number, None if it is not here; needed for lines alone.
            speed: steps per second of each.
            playing: whether they go on at once.

        Raises:
            CommandError: there are too few entries, or too many; two have one name; a line is not
                here; or a seed is not allowed.
        """
        super().__init__("race", _PUBLISH_S, _SLICE_S)
        _check(entries)
        self._past_of = past_of
        self._racers = [self._racer(entry, budget) for entry in entries]
        self._common_starts = common_starts(entries)
        self._speed, self._playing = speed, playing
        self._error: str | None = None
        self._runs_to: int | None = None
        self._step = 0
        self._advancing: Racer | None = None
        self._curve_at_s = float("-inf")
        self._closing = False
        self._status = self._take_status(0.0)
        self.paused_live: int | None = None
        """Trial in which the live run has been made to stand still for it; None if it did already.
        """
        self.moments = RaceMoments(self._racers, lambda: self._status.step)
        """Makes moments of all, wished by their step, and can be asked for other things of their
        pasts."""

    # What others do

    def play(self, reply: Reply | None = None) -> int:
        """Let all learn on; returns a ticket, as :meth:`Worker.submit`."""
        return self.submit(_Play(), reply)

    def pause(self) -> int:
        """Let all stand still."""
        return self.submit(_Pause())

    def run_to(self, step: int, reply: Reply | None = None) -> int:
        """Let all learn up to a step at full speed, and stand still there."""
        return self.submit(_RunTo(step), reply)

    def set_speed(self, steps_per_s: float) -> int:
        """Aim at so many steps per second of each."""
        return self.submit(_SetSpeed(steps_per_s))

    def heed(self) -> None:
        """Look whether more is known of lines that are followed."""
        if any(racer.follows for racer in self._racers):
            self.submit(_Heed())

    def past(self, place: int) -> Past:
        """The past of a racer, by its place among the entries."""
        return self._racers[place].past

    def close(self) -> None:
        """End the race, and wait for that."""
        self._closing = True
        self.stop()
        self.moments.stop()
        for racer in self._racers:
            if not racer.follows:
                racer.past.drop()

    # What its thread does

    def _aim(self) -> float | None:
        if self._error is not None:
            return None
        if any(racer.is_behind(self._step) for racer in self._racers):
            return FULL_SPEED
        if not self._playing or all(racer.is_at_end() for racer in self._racers):
            return None
        return FULL_SPEED if self._runs_to is not None else self._speed

    def _advance(self, steps: int) -> int:
        before = self._step
        goal = before
        if self._playing:
            goal += steps if self._runs_to is None else min(steps, self._runs_to - before)
        for racer in self._racers:
            self._advancing = racer
            racer.go_to(goal, lambda: not self._closing)
        self._advancing = None
        self._preparing = False
        self._step = max(racer.run.step for racer in self._racers)
        if self._step == self._runs_to or self._is_finished():
            self._stand_still()
        return max(self._step - before, 0)

    def _break_off(self, error: str) -> None:
        racer = self._advancing
        self._error = error if racer is None else f"{racer.entry.name}: {error}"
        self._stand_still()

    def _carry_out(self, request: _Asked, run: int | None, reply: Reply | None = None) -> None:
        match request:
            case _Play():
                self._check_goes_on()
                self._playing, self._runs_to = True, None
            case _Pause():
                self._stand_still()
            case _RunTo(step=step):
                self._check_goes_on()
                if step <= self._step:
                    raise CommandError(
                        f"step {step:,} is past, the race is at step {self._step:,}; its bar shows"
                        " what is past"
                    )
                self._playing, self._runs_to = True, step
            case _SetSpeed(steps_per_s=speed):
                self._speed = speed
            case _Heed():
                self._look_for_lines()
                return
        self._pace.restart()

    def _take_status(self, now_s: float) -> RaceStatus:
        if self._error is not None:
            # Some may have made steps that others have not: the moment before stays.
            return replace(
                self._status,
                playing=False,
                runs_to=None,
                error=self._error,
                steps_per_s=0.0,
                answered=self._answered,
            )
        aim = self._aim()
        new_curve = aim is None or now_s - self._curve_at_s >= _CURVE_S
        if new_curve:
            self._curve_at_s = now_s
        snapshots = tuple(racer.seen(self._step, new_curve) for racer in self._racers)
        rests = aim is None
        return RaceStatus(
            entries=tuple(racer.entry for racer in self._racers),
            step=self._step,
            trials=tuple(snapshot.trial for snapshot in snapshots),
            playing=self._playing,
            finished=self._is_finished(),
            error=None,
            snapshots=snapshots,
            stands=tuple(racer.stand() for racer in self._racers),
            speed=self._speed,
            steps_per_s=0.0 if rests else self._pace.rate(),
            runs_to=self._runs_to,
            digests=tuple(racer.digest() for racer in self._racers) if rests else (),
            common_starts=self._common_starts,
            preparing=self._preparing and self._playing,
            answered=self._answered,
        )

    # How

    def _racer(self, entry: Entry, budget: Budget) -> Racer:
        if entry.line is None:
            try:
                return Racer(entry, None, budget)
            except ValueError as error:
                raise CommandError(f"{entry.name}: {error}") from error
        past = self._past_of(entry.line)
        if past is None:
            raise CommandError(f"{entry.name} is not in the tree any more")
        return Racer(entry, past, budget)

    def _check_goes_on(self) -> None:
        if self._error is not None:
            raise CommandError(f"the race has stopped: {self._error}")
        if self._is_finished():
            raise CommandError("the trials of all are over; start the race again")

    def _is_finished(self) -> bool:
        return all(racer.stand() in ("finished", "gone") for racer in self._racers)

    def _stand_still(self) -> None:
        self._playing, self._runs_to = False, None

    def _look_for_lines(self) -> None:
        for racer in self._racers:
            if racer.entry.line is not None:
                racer.is_gone = self._past_of(racer.entry.line) is not racer.past


def _check(entries: Sequence[Entry]) -> None:
    if not FEWEST <= len(entries) <= MOST:
        raise CommandError(f"a race is of {FEWEST} to {MOST} runs, and not of {len(entries)}")
    names = [entry.name for entry in entries]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise CommandError(f"two runs are called {twice}; give one another name")
    if any(not name.strip() for name in names):
        raise CommandError("a run in a race needs a name")
