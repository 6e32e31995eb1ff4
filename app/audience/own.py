"""The learner of one seat of a class: what is done with it, and how it is put away.

It is a run like any other, a function of (preset, seed, commands with their steps). So one that
nobody looks at is kept as these and the step that it stands at, and is made again from its
beginning, exactly, when somebody comes back. Whoever advances it says by how much: nothing here
knows a clock.
"""

from collections import deque
from dataclasses import dataclass
from typing import Final, NamedTuple, Self

from app.audience.taps import (
    SPEEDS,
    AddOwn,
    AgainOwn,
    ExploreOwn,
    FreezeOwn,
    PlayOwn,
    SpeedOwn,
    StepOwn,
    Tap,
    TrialOwn,
)
from app.lessons.doing import EXPLORED
from app.live import snapshot
from app.live.snapshot import Snapshot
from app.live.status import Status
from learners import measures
from learners.commands import (
    Command,
    CommandError,
    Explore,
    FollowSchedule,
    FreezeSelection,
    Introduce,
    StopExploring,
)
from learners.names import MAX_TRIALS
from learners.run import Run
from learners.spec import RunSpec
from sim.rng import MAX_SEED

MOST_COMMANDS: Final = 200
"""That one learner is given: so what is kept of it has a bound, and so has making it again."""
MOST_TRIALS: Final = 100_000
"""That one learner has, whatever its preset has."""
FREEZE_TRIALS: Final = 300


@dataclass(frozen=True)
class Beginning:
    """How the learners of all seats begin, but for their seeds."""

    preset: str
    """As shown."""
    spec: RunSpec
    seed: int
    """The number of a seat is added to it."""
    start: int = 0
    """Trial up to which each has learned when it is handed over."""
    schedule: bool = True
    """Whether the schedule is followed."""
    speed: float = SPEEDS[3]
    """Steps a second, of which the nearest level is set."""
    explorations: tuple[tuple[str, int, float], ...] = ()
    """For how many trials a skill is explored, and how often it is taken, where the lesson says."""

    def seed_of(self, number: int) -> int:
        """Seed of the learner of a seat."""
        return (self.seed + number) % (MAX_SEED + 1)

    @property
    def level(self) -> int:
        """The level of speed nearest to the one that is stated."""
        return min(range(len(SPEEDS)), key=lambda level: abs(_ratio(SPEEDS[level], self.speed)))

    @property
    def trials(self) -> int:
        """After so many a learner is at its end."""
        return min(self.spec.trials, MOST_TRIALS)


def _ratio(one: float, other: float) -> float:
    return max(one / other, other / one)


class Kept(NamedTuple):
    """A learner that is put away."""

    beginning: Beginning
    seed: int
    journal: tuple[tuple[int, Command], ...]
    """What it was asked for, and after how many steps."""
    step: int | None
    """None if it was not handed over yet."""
    playing: bool
    level: int


class Own:
    """A learner at work. Not safe for use from two threads at once."""

    def __init__(self, beginning: Beginning, seed: int) -> None:
        """Prepare one that knows nothing, and is on its way to where it is handed over."""
        self.beginning, self.seed = beginning, seed
        self.playing = False
        self.level = beginning.level
        self._begin()

    def _begin(self) -> None:
        self.run = Run(self.beginning.spec, self.seed)
        self.is_on_its_way = True
        """Whether it is not yet where it can be used."""
        self._goal_step: int | None = None
        """Where it was put away; None where it has not been handed over before."""
        self._ahead: deque[tuple[int, Command]] = deque()
        """What it is yet to be given on its way there."""
        self._seen: Snapshot | None = None

    @classmethod
    def taken_up(cls, kept: Kept) -> Self:
        """One that was put away, on its way to where it was."""
        own = cls(kept.beginning, kept.seed)
        own.playing, own.level = kept.playing, kept.level
        own._goal_step = kept.step
        own._ahead.extend(kept.journal)
        return own

    def put_away(self) -> Kept:
        """What is kept of it. One that is on its way is kept as it will be there."""
        journal = (*self.run.journal, *self._ahead)
        step = self._goal_step if self.is_on_its_way else self.run.step
        return Kept(self.beginning, self.seed, journal, step, self.playing, self.level)

    # How it stands

    @property
    def is_new(self) -> bool:
        """Whether it has not been handed over yet."""
        return self.is_on_its_way and self._goal_step is None

    @property
    def is_over(self) -> bool:
        """Whether its trials are over."""
        return self.run.trial >= self.beginning.trials and not self.is_on_its_way

    @property
    def learns(self) -> bool:
        """Whether it goes on by itself."""
        return self.playing and not self.is_over and not self.is_on_its_way

    @property
    def speed(self) -> float:
        """Steps a second that are set."""
        return SPEEDS[self.level]

    @property
    def reward(self) -> float:
        """Mean per trial over the last ones; NaN before the first has ended."""
        return measures.recent_reward(self.run.state)

    def status(self) -> Status:
        """How it stands, as sentences and boards read it; the same moment is copied once."""
        seen, run = self._seen, self.run
        if seen is None or seen.step != run.step or seen.control is not run.control:
            # Nobody is shown its curves, which cost most.
            seen = snapshot.take(run, self.beginning.preset, 0, seen, new_curve=seen is None)
            self._seen = seen
        return Status(
            snapshot=seen,
            playing=self.learns,
            finished=self.is_over,
            exhausted=self.is_over,
            preparing=False,
            speed=self.speed,
            steps_per_s=0.0,
            error=None,
            answered=0,
        )

    # What it does

    def advance(self, steps: int) -> int:
        """Make so many steps at most, and none beyond its end or where it is on its way to.

        Returns:
            The number of steps made.
        """
        if not self.is_on_its_way:
            return self.run.advance(steps, self.beginning.trials)
        made = 0
        while True:
            if self._ahead and self._ahead[0][0] <= self.run.step:
                self.run.apply(self._ahead.popleft()[1])
            elif self._has_come():
                self._hand_over()
                return made
            elif made >= steps:
                return made
            else:
                made += self._go_on(steps - made)

    def _has_come(self) -> bool:
        if self._goal_step is None:
            return self.run.trial >= min(self.beginning.start, self.beginning.trials)
        return self.run.step >= self._goal_step and not self._ahead

    def _go_on(self, steps: int) -> int:
        if self._goal_step is None:
            return self.run.advance(steps, self.beginning.start)
        until = self._ahead[0][0] if self._ahead else self._goal_step
        return self.run.advance(min(steps, until - self.run.step), MAX_TRIALS)

    def _hand_over(self) -> None:
        if self._goal_step is None and not self.beginning.schedule:
            self.run.apply(FollowSchedule(False))
        self.is_on_its_way, self._goal_step = False, None

    def carry_out(self, tap: Tap) -> None:
        """Do what somebody has asked for; not while it is on its way.

        Raises:
            CommandError: it cannot be done now; nothing has changed.
        """
        match tap:
            case PlayOwn(on=on):
                self.playing = on
            case StepOwn():
                self.playing = False
                self.advance(1)
            case TrialOwn():
                self.playing = False
                until = min(self.run.trial + 1, self.beginning.trials)
                self.run.advance(until_trial=until)
            case SpeedOwn(level=level):
                self.level = level
            case AddOwn(skill=skill):
                self._apply(Introduce(skill, self._freeze_of(skill)))
            case ExploreOwn(skill=skill, on=True):
                self._apply(Explore(skill, *self._exploration_of(skill)))
            case ExploreOwn(skill=skill):
                self._apply(StopExploring(skill))
            case FreezeOwn(on=on):
                self._apply(FreezeSelection(on))
            case AgainOwn():
                self._begin()

    def _apply(self, command: Command) -> None:
        if len(self.run.journal) >= MOST_COMMANDS:
            raise CommandError(f"it has been changed {MOST_COMMANDS} times, and can only play on")
        if self.is_over:
            raise CommandError("its trials are over")
        self.run.apply(command)

    def _freeze_of(self, skill: str) -> int:
        """Trials for which the selection is frozen when a skill joins now."""
        timer = self.run.spec.schedule.skills.get(skill)
        return FREEZE_TRIALS if timer is None or timer.at == MAX_TRIALS else timer.freeze

    def _exploration_of(self, skill: str) -> tuple[int, float]:
        """For how many trials a skill is explored from now on, and how often it is taken."""
        for name, trials, chance in self.beginning.explorations:
            if name == skill:
                return trials, chance
        for episode in self.run.spec.schedule.episodes:
            if episode.skill == skill:
                return episode.duration, episode.probability
        return EXPLORED
