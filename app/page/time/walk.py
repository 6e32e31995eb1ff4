"""Where one browser looks: at what is live, or at a moment of a line, which may be playing.

Pure: the clock and what is known of the lines are given from outside. A walk moves only when it is
asked where it is, and nothing happens between two such times.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from typing import Final, Literal, NamedTuple, Protocol

from app.live.places import Place

Unit = Literal["steps", "trials", "events"]
"""What a walk goes by."""
Direction = Literal[-1, 0, 1]
"""Back, standing still, on."""

WHOLE: Final = 0.0
"""The rate at which the whole line takes :data:`WHOLE_S`."""
WHOLE_S: Final = 30.0
_MOST_RATE: Final = 1e6
_FACTORS: Final = (1.0, 2.0, 5.0)


class Course(Protocol):
    """How steps and trials of one line go together, as far as it is known."""

    @property
    def end_step(self) -> int:
        """Steps of it that are known."""
        ...

    @property
    def end_trial(self) -> int:
        """The trial that runs where it ends."""
        ...

    def step_of_trial(self, trial: int) -> int:
        """Steps made when a trial begins."""
        ...

    def trial_of_step(self, step: int) -> int:
        """The trial that runs when so many steps are made."""
        ...


class Ground(NamedTuple):
    """What is known of the lines at a time."""

    live: int
    """Number of the line that is live."""
    course_of: Callable[[int], Course | None]
    """None of a line that is not there any more."""
    events_of: Callable[[int], Sequence[int]]
    """Steps of what happened in a line, ascending."""
    pace: float
    """Steps a second at the rate 1."""


class Loop(NamedTuple):
    """What is played again and again."""

    line: int
    first: int
    """Step at which it begins."""
    until: int
    """Step at which it ends, after its first."""


class WalkError(ValueError):
    """What cannot be done from here; the message says why."""


class Walk:
    """One browser's walk."""

    def __init__(self) -> None:
        self._line: int | None = None
        """None for what is live."""
        self._step = 0.0
        """Exactly, as it plays."""
        self._moved_s = 0.0
        """When it was last known to be there."""
        self.direction: Direction = 0
        """Which way it plays."""
        self.rate = 1.0
        """How fast, as a multiple of the pace of the ground, or :data:`WHOLE`."""
        self.stops = False
        """Whether it stands still at events that it comes to."""
        self.a: Place | None = None
        """The moment that others are compared with, and at which a loop begins."""
        self.loop: Loop | None = None
        self.holds = False
        """Whether the live run is to stand still while this looks at something else."""
        self._holding = False
        """Whether it stands still for this."""
        self._lost = False

    @property
    def is_live(self) -> bool:
        """Whether it shows what is live."""
        return self._line is None

    def at(self, now_s: float, ground: Ground) -> Place | None:
        """Where it is now; None for what is live.

        It goes there as it plays. Where it comes to the end of the live line it is live again;
        where its line is gone, too, which :meth:`lost` tells.
        """
        if self.a is not None and ground.course_of(self.a.line) is None:
            self.a = self.loop = None
        line = self._line
        if line is None:
            return None
        course = ground.course_of(line)
        if course is None:
            self._lost = True
            self.go_live()
            return None
        passed_s = max(now_s - self._moved_s, 0.0)
        self._moved_s += passed_s
        if self.direction:
            self._play_on(line, course, passed_s * self._speed(course, ground), ground)
        self._step = min(self._step, float(course.end_step))
        return None if self.is_live else Place(line, int(self._step))

    def lost(self) -> bool:
        """Whether what it looked at has gone, since this was asked last."""
        lost, self._lost = self._lost, False
        return lost

    # Going somewhere

    def go_live(self) -> None:
        """Look at what is live."""
        self._line, self.direction = None, 0

    def look(self, line: int, step: int | None, now_s: float, ground: Ground) -> None:
        """Look at a moment of a line, by default at its end; the end of the live line is live.

        A step out of range is the nearest there is. What plays goes on from there.

        Raises:
            WalkError: the line is not there.
        """
        course = ground.course_of(line)
        if course is None:
            raise WalkError("That line is not there any more.")
        step = course.end_step if step is None else min(max(step, 0), course.end_step)
        if line == ground.live and step >= course.end_step:
            self.go_live()
        else:
            self._line, self._step, self._moved_s = line, float(step), now_s

    def seek(self, step: int, now_s: float, ground: Ground) -> None:
        """Go to a step of the line that is looked at."""
        self.look(self.line(ground), step, now_s, ground)

    def seek_trial(self, trial: int, now_s: float, ground: Ground) -> None:
        """Go to the beginning of a trial of the line that is looked at; past the last, to the end.

        Raises:
            WalkError: the line is not there.
        """
        course = self._course(ground)
        step = None
        if trial <= course.end_trial:
            step = course.step_of_trial(max(trial, 0))
        self.look(self.line(ground), step, now_s, ground)

    def go_by(self, unit: Unit, n: int, now_s: float, ground: Ground) -> None:
        """Stand still so many steps, trials or events further on, or back.

        Raises:
            WalkError: the line is not there.
        """
        self.at(now_s, ground)
        self.direction = 0
        course, step = self._course(ground), self._here(ground)
        if unit == "steps":
            self.seek(step + n, now_s, ground)
        elif unit == "trials":
            self.seek_trial(course.trial_of_step(step) + n, now_s, ground)
        else:
            line = self.line(ground)
            self.look(line, _event_by(ground.events_of(line), step, n), now_s, ground)

    # Playing

    def play(self, direction: Direction, now_s: float, ground: Ground) -> None:
        """Play on or back from where it is; what is live can be played back alone.

        Raises:
            WalkError: there is nothing more in that direction.
        """
        self.at(now_s, ground)
        course, step = self._course(ground), self._here(ground)
        if direction > 0 and step >= course.end_step:
            raise WalkError("Nothing more is known of this line.")
        if direction < 0 and step <= 0:
            raise WalkError("This is the beginning.")
        self._line, self._step, self._moved_s = self.line(ground), float(step), now_s
        self.direction = direction

    def pause(self, now_s: float, ground: Ground) -> None:
        """Stand still where it is."""
        self.at(now_s, ground)
        self.direction = 0

    def set_rate(self, rate: float, now_s: float, ground: Ground) -> None:
        """Play as fast as that from here on; a number out of range is the nearest allowed one."""
        self.at(now_s, ground)
        self.rate = rate if rate == WHOLE else min(max(rate, 1.0), _MOST_RATE)

    def set_a(self, now_s: float, ground: Ground) -> None:
        """Let A be where it is; of a loop it is the beginning from here on.

        Raises:
            WalkError: the line is not there.
        """
        self.at(now_s, ground)
        self._course(ground)
        self.a, self.loop = Place(self.line(ground), self._here(ground)), None

    def set_loop(self, on: bool, marks: Sequence[int], now_s: float, ground: Ground) -> None:
        """Play what lies between A and here again and again, or no longer.

        Where this is A itself, it lies between A and the last of the ``marks``.

        Args:
            on: whether it is to.
            marks: steps of the line that somebody has marked, the newest last.
            now_s: the time.
            ground: what is known of the lines.

        Raises:
            WalkError: there is no A on this line, or no other moment.
        """
        self.at(now_s, ground)
        self.loop = None
        if not on:
            return
        line, here = self.line(ground), self._here(ground)
        if self.a is None or self.a.line != line:
            raise WalkError("Set A first, at the moment at which the loop is to begin.")
        others = [step for step in (*marks, here) if step != self.a.step]
        if not others:
            raise WalkError("Go to another moment than A: the loop is to end there.")
        first, until = sorted((self.a.step, others[-1]))
        self.loop = Loop(line, first, until)

    # The live run meanwhile

    def hold(self, playing: bool) -> Literal["pause", "play"] | None:
        """What is to be asked of the live run now, given whether it plays.

        To pause when this has left it, and to play again when this is back, but only if it is this
        that paused it.
        """
        wanted = self.holds and not self.is_live
        if wanted and not self._holding and playing:
            self._holding = True
            return "pause"
        if not wanted and self._holding:
            self._holding = False
            # Even if it seems to play: it may be about to pause.
            return "play"
        return None

    # Where it is

    def line(self, ground: Ground) -> int:
        """The line that it looks at."""
        return ground.live if self._line is None else self._line

    def _course(self, ground: Ground) -> Course:
        course = ground.course_of(self.line(ground))
        if course is None:
            raise WalkError("That line is not there any more.")
        return course

    def _here(self, ground: Ground) -> int:
        return self._course(ground).end_step if self._line is None else int(self._step)

    def _speed(self, course: Course, ground: Ground) -> float:
        if self.rate == WHOLE:
            return max(course.end_step / WHOLE_S, ground.pace)
        return self.rate * ground.pace

    def _play_on(self, line: int, course: Course, steps: float, ground: Ground) -> None:
        before, after = self._step, self._step + self.direction * steps
        event = _passed(ground.events_of(line), before, after) if self.stops else None
        if event is not None:
            self._step, self.direction = float(event), 0
            return
        if self.loop is not None and self.loop.line == line:
            after = _looped(self.loop, before, after)
        self._step = after
        if after <= 0.0:
            self._step, self.direction = 0.0, 0
        elif after >= course.end_step:
            self._step, self.direction = float(course.end_step), 0
            if line == ground.live:
                self.go_live()


def rates_of(end_step: int, pace: float) -> tuple[tuple[float, str], ...]:
    """Rates that there are to choose from for a line, and what they are called."""
    factors = (factor * 10.0**power for power in range(6) for factor in _FACTORS)
    slower = [rate for rate in factors if rate == 1.0 or rate * pace < end_step / WHOLE_S]
    rates = [(rate, f"{rate:,.0f} \N{MULTIPLICATION SIGN}") for rate in slower]
    if end_step:
        rates.append((WHOLE, f"whole run in {WHOLE_S:.0f} s"))
    return tuple(rates)


def _event_by(events: Sequence[int], step: int, n: int) -> int | None:
    """The n-th event after a step, or before it; the beginning if there is none, or None."""
    if n == 0:
        return step
    if n > 0:
        index = bisect_right(events, step) + n - 1
        return None if index >= len(events) else events[index]
    index = bisect_left(events, step) + n
    return 0 if index < 0 else events[index]


def _passed(events: Sequence[int], before: float, after: float) -> int | None:
    """The first event on the way from one step to another, that where it begins left out."""
    if after >= before:
        index = bisect_right(events, before)
        found = events[index] if index < len(events) else None
        return found if found is not None and found <= after else None
    index = bisect_left(events, before) - 1
    found = events[index] if index >= 0 else None
    return found if found is not None and found >= after else None


def _looped(loop: Loop, before: float, after: float) -> float:
    """Where one comes to in a loop, whichever end of it is passed."""
    length = loop.until - loop.first
    if after > before and after >= loop.until:
        return loop.first + (after - loop.until) % length
    if after < before and after <= loop.first:
        return loop.until - (loop.first - after) % length
    return after
