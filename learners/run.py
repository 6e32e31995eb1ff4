"""One run of one learner: a function of (spec, seed, commands with their step numbers).

The run applies commands between steps, lets the schedule give its own at the start of the
trials it names, and calls the kernel from one such event to the next.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple, Self, assert_never

import numpy as np

from learners import kernel
from learners.commands import (
    Command,
    CommandError,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    StopExploring,
)
from learners.kernel import LearnerState, Settings
from learners.rows import MAX_ACTIONS
from learners.skills import SKILLS
from learners.spec import INTRODUCTION, MAX_TRIALS, MOVES, RunSpec
from learners.state import copy_state, join_option, n_options_of, new_state, with_room_for
from sim import rng
from sim.bits import U
from sim.world import World, compile_world, start_of_trial

_NEVER = 2**62


class Episode(NamedTuple):
    """A biased exploration episode that is running."""

    skill: str
    probability: float
    until_trial: int
    """First trial after it."""


class Introduction(NamedTuple):
    """A skill that joined, and when."""

    skill: str
    trial: int
    step: int


class Timer(NamedTuple):
    """A command of the schedule and the trial before which it is given."""

    trial: int
    command: Command


@dataclass(frozen=True)
class Control:
    """What commands have set; with the state of the tables, all that a run is at a moment."""

    introductions: tuple[Introduction, ...] = ()
    episodes: tuple[Episode, ...] = ()
    """The newest first; at most one for each skill."""
    frozen_until: int = 0
    """First trial in which the freeze of an introduction is over."""
    selection_frozen: bool = False
    skills_frozen: bool = False
    schedule_on: bool = True
    next_timer: int = 0
    """Timers before this one are past."""


def timers_of(spec: RunSpec) -> tuple[Timer, ...]:
    """The schedule as commands in the order in which they are given."""
    schedule = spec.schedule
    timers = [
        Timer(schedule.introduced_at(skill), Introduce(skill, schedule.freeze_of(skill)))
        for skill in spec.learner.skills
    ]
    timers += [
        Timer(int(episode.at), Explore(episode.skill, episode.duration, episode.probability))
        for episode in schedule.episodes
        if episode.at != INTRODUCTION
    ]
    return tuple(sorted(timers, key=lambda timer: timer.trial))


def units(share: float, bits: int) -> np.uint64:
    """A probability as the number of draws, out of 2**bits, for which it comes true."""
    return U(round(share * 2**bits))


class Run:
    """A learner at work. Not safe for use from two threads at once."""

    def __init__(self, spec: RunSpec, seed: int) -> None:
        """Prepare the run; nothing has been learned yet.

        Raises:
            ValueError: the seed is not allowed.
        """
        self.spec = spec
        self.seed = seed
        self.world: World = compile_world(spec.world)
        self.state: LearnerState = new_state(spec, self.world, seed)
        self.control = Control()
        self.journal: list[tuple[int, Command]] = []
        self._timers = timers_of(spec)
        self._give_due_timers()

    def copy(self) -> Self:
        """An independent run that stands where this one does: a checkpoint."""
        twin = object.__new__(type(self))
        twin.__dict__.update(self.__dict__)
        twin.state = copy_state(self.state)
        twin.journal = list(self.journal)
        return twin

    @property
    def step(self) -> int:
        """Steps made so far."""
        return int(self.state.tally[kernel.STEP])

    @property
    def trial(self) -> int:
        """The running trial, from 0; so many trials have ended."""
        return int(self.state.tally[kernel.TRIAL])

    @property
    def present(self) -> tuple[str, ...]:
        """Skills that have joined, in the order of the options."""
        joined = {introduction.skill for introduction in self.control.introductions}
        return tuple(skill for skill in self.spec.learner.skills if skill in joined)

    @property
    def selection_is_frozen(self) -> bool:
        """Whether the selection table is held still in the running trial."""
        return self.control.selection_frozen or self.trial < self.control.frozen_until

    def start_of(self, trial: int) -> tuple[int, int]:
        """Cell and heading with which a trial starts."""
        cell, heading = start_of_trial(self.world, self.state.streams[rng.STARTS], trial)
        return int(cell), int(heading)

    def planned(self) -> tuple[Timer, ...]:
        """What the schedule will still do if it is left on."""
        return self._timers[self.control.next_timer :]

    def advance(self, max_steps: int = _NEVER, until_trial: int | None = None) -> int:
        """Learn for ``max_steps`` steps, or until a trial is about to start, whichever is first.

        ``until_trial`` is the preset's number of trials unless given. How the steps are divided
        into calls makes no difference to what is learned.

        Returns:
            The number of steps made.
        """
        until = self.spec.trials if until_trial is None else min(until_trial, MAX_TRIALS)
        self.state = with_room_for(self.state, until)
        made = 0
        while made < max_steps and self.trial < until:
            self._begin_trial()
            stop = min(until, self._next_event())
            settings = self._settings()
            made += kernel.advance(self.world, self.state, settings, max_steps - made, stop)
        return made

    def apply(self, command: Command) -> None:
        """Carry out a command given by hand, and note it in the journal.

        Raises:
            CommandError: it cannot be carried out now; nothing has changed.
        """
        self._obey(command)
        self.journal.append((self.step, command))

    def _begin_trial(self) -> None:
        if self.state.tally[kernel.TRIAL_STEP] == 0:
            trial = self.trial
            going = tuple(e for e in self.control.episodes if e.until_trial > trial)
            self.control = replace(self.control, episodes=going)
            self._give_due_timers()

    def _give_due_timers(self) -> None:
        trial = self.trial
        while (index := self.control.next_timer) < len(self._timers):
            timer = self._timers[index]
            if timer.trial > trial:
                return
            self.control = replace(self.control, next_timer=index + 1)
            if self.control.schedule_on and timer.trial == trial and self._still_wanted(timer):
                self._obey(timer.command)

    def _still_wanted(self, timer: Timer) -> bool:
        """A timer yields to what was done by hand before."""
        match timer.command:
            case Introduce(skill=skill):
                return skill not in self.present
            case Explore(skill=skill):
                return skill in self.present
        return True

    def _next_event(self) -> int:
        """Trial before which the settings of the kernel may change."""
        trial = self.trial
        events = [timer.trial for timer in self.planned()[:1]]
        events += [episode.until_trial for episode in self.control.episodes]
        events.append(self.control.frozen_until)
        return min((event for event in events if event > trial), default=_NEVER)

    def _obey(self, command: Command) -> None:
        match command:
            case Introduce():
                self._introduce(command)
            case Explore():
                self._explore(command)
            case StopExploring(skill=skill):
                if all(episode.skill != skill for episode in self.control.episodes):
                    raise CommandError(f"{skill} is not being explored")
                self._drop_episode(skill)
            case FreezeSelection(frozen=frozen):
                self.control = replace(self.control, selection_frozen=frozen)
            case FreezeSkills(frozen=frozen):
                self.control = replace(self.control, skills_frozen=frozen)
            case FollowSchedule(on=on):
                self.control = replace(self.control, schedule_on=on)
            case _:
                assert_never(command)

    def _introduce(self, command: Introduce) -> None:
        skill = command.skill
        if skill not in self.spec.learner.skills:
            raise CommandError(
                f"{skill!r} is not a skill of this learner;"
                f" allowed: {', '.join(self.spec.learner.skills) or 'none'}"
            )
        if skill in self.present:
            raise CommandError(f"{skill} has joined already")
        _check_trials("freeze", command.freeze_trials)
        trial = self.trial
        join_option(self.state, self._option(skill), self.spec.learner.initial_q)
        self.state.tally[kernel.REPERTOIRE] += 1
        self.control = replace(
            self.control,
            introductions=(*self.control.introductions, Introduction(skill, trial, self.step)),
            frozen_until=max(self.control.frozen_until, trial + command.freeze_trials),
        )
        if self.control.schedule_on:
            for episode in self.spec.schedule.episodes:
                if episode.skill == skill and episode.at == INTRODUCTION:
                    self._explore(Explore(skill, episode.duration, episode.probability))

    def _explore(self, command: Explore) -> None:
        if command.skill not in self.present:
            raise CommandError(f"{command.skill!r} has not joined, so it cannot be explored")
        _check_trials("duration", command.duration_trials)
        if not 0 <= command.probability <= 1:
            raise CommandError(
                f"probability: {command.probability} is not allowed; allowed: 0 to 1"
            )
        self._drop_episode(command.skill)
        until = self.trial + command.duration_trials
        newest = Episode(command.skill, command.probability, until)
        self.control = replace(self.control, episodes=(newest, *self.control.episodes))

    def _drop_episode(self, skill: str) -> None:
        others = tuple(episode for episode in self.control.episodes if episode.skill != skill)
        self.control = replace(self.control, episodes=others)

    def _option(self, skill: str) -> int:
        return self.spec.learner.skills.index(skill)

    def _settings(self) -> Settings:
        learner = self.spec.learner
        control = self.control
        n_options = n_options_of(self.spec)
        weights = np.zeros((max(len(learner.skills), 1), 4), np.float32)
        for skill, name in enumerate(learner.skills):
            weights[skill, :3] = SKILLS[name]
        present = (1 << n_options) - 1
        if learner.skills:
            present = sum(1 << self._option(skill) for skill in self.present)
        return Settings(
            n_options=U(n_options),
            present=U(present),
            option_skill=np.arange(MAX_ACTIONS, dtype=np.uint64),
            options_are_moves=learner.options == MOVES,
            reward_weights=weights.ravel(),
            alpha=np.float32(0.0 if self.selection_is_frozen else learner.alpha),
            skill_alpha=np.float32(0.0 if control.skills_frozen else learner.skill_alpha),
            gamma=np.float32(learner.gamma),
            epsilon16=units(learner.epsilon, 16),
            n_episodes=len(control.episodes),
            episode_option=np.array([self._option(e.skill) for e in control.episodes], np.uint64),
            episode_chance=np.array(
                [units(e.probability, 32) for e in control.episodes], np.uint64
            ),
        )


def _check_trials(what: str, trials: int) -> None:
    if not 0 <= trials <= MAX_TRIALS:
        raise CommandError(f"{what}: {trials} trials is not allowed; allowed: 0 to {MAX_TRIALS}")


def replay(spec: RunSpec, seed: int, journal: list[tuple[int, Command]], until_step: int) -> Run:
    """Run again from the start, giving each command of a journal at its step."""
    run = Run(spec, seed)
    for step, command in journal:
        if step > until_step:
            break
        run.advance(max_steps=step - run.step, until_trial=MAX_TRIALS)
        run.apply(command)
    run.advance(max_steps=until_step - run.step, until_trial=MAX_TRIALS)
    return run
