"""One run of one learner: a function of (spec, seed, commands with their step numbers).

The run applies commands between steps, lets the schedule give its own at the start of the
trials it names, and calls the kernel from one such event to the next.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self, TypeVar, assert_never

import numpy as np
from pydantic import ValidationError

from learners import kernel, measures
from learners.commands import (
    PARAMETERS,
    Command,
    CommandError,
    DefineSkill,
    Event,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Remove,
    SetParameter,
    SetSchedule,
    StopExploring,
    Undo,
)
from learners.folding import overruled, without
from learners.kernel import LearnerState, Settings
from learners.parameters import value_of
from learners.skills import SKILLS
from learners.spec import INTRODUCTION, MAX_TRIALS, MOVES, RunSpec, ScheduleSpec, SkillTimer
from learners.state import (
    copy_state,
    join_option,
    leave_option,
    n_options_of,
    new_state,
    return_option,
    with_option,
    with_room_for,
)
from sim import rng
from sim.bits import U
from sim.spec import ProblemsError
from sim.world import World, compile_world, start_of_trial

_NEVER = 2**62
_BEFORE_ALL = -1
"""Less than the number of any event."""
_NO_TIMER = SkillTimer(at=MAX_TRIALS)
"""Of a skill that became an option by hand; without one it would have joined at the start."""

Kind = TypeVar("Kind", bound=Command)


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


class Removal(NamedTuple):
    """What a skill takes with it when it leaves."""

    introduction: Introduction
    column: np.ndarray
    """(state,) float32: its values in the selection table."""
    episode: Episode | None
    """Its exploration, if it was being explored."""


class Timer(NamedTuple):
    """A command of the schedule and the trial before which it is given."""

    trial: int
    command: Command


@dataclass(frozen=True)
class Control:
    """What commands have set; with the state of the tables, all that a run is at a moment."""

    spec: RunSpec
    """The preset as commands have changed it."""
    introductions: tuple[Introduction, ...] = ()
    """Of the skills that are present, the newest last."""
    episodes: tuple[Episode, ...] = ()
    """The newest first; at most one for each skill."""
    frozen_until: int = 0
    """First trial in which the freeze of an introduction is over."""
    selection_frozen: bool = False
    skills_frozen: bool = False
    schedule_on: bool = True
    next_timer: int = 0
    """Timers before this one are past."""
    history: tuple[Event, ...] = ()


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
        self.preset = spec
        self.seed = seed
        self.world: World = compile_world(spec.world)
        self.state: LearnerState = new_state(spec, self.world, seed)
        self.control = Control(spec)
        self._timers = timers_of(spec)
        self._memos: dict[int, Any] = {}
        self._begin_trial()

    def copy(self) -> Self:
        """An independent run that stands where this one does: a checkpoint."""
        twin = object.__new__(type(self))
        twin.__dict__.update(self.__dict__)
        twin.state = copy_state(self.state)
        twin._memos = dict(self._memos)
        return twin

    @property
    def spec(self) -> RunSpec:
        """The preset as commands have changed it."""
        return self.control.spec

    @property
    def journal(self) -> list[tuple[int, Command]]:
        """Commands given by hand and their steps: with preset and seed, the whole run."""
        return [(event.step, event.command) for event in self.control.history if event.by_hand]

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
        # No more trials than steps can end.
        self.state = with_room_for(self.state, min(until, self.trial + max_steps))
        made = 0
        while made < max_steps and self.trial < until:
            self._begin_trial()
            stop = min(until, self._next_event())
            settings, first = self._settings(), self.trial
            made += kernel.advance(self.world, self.state, settings, max_steps - made, stop)
            ended = slice(first, self.trial)
            outcomes = self.state.log_outcome[ended]
            self.state.log_reward[ended] = measures.rewards(self.spec.world, outcomes)
        return made

    def apply(self, command: Command, folding: bool = False) -> None:
        """Carry out a command given by hand, and note it in the history.

        With ``folding`` it takes the place of one that it makes void before a step was made, and
        what a command and its contrary leave as it was leaves no note. What is learned is the same.

        Raises:
            CommandError: it cannot be carried out now; nothing has changed.
        """
        self._give(command, by_hand=True, folding=folding)

    def _give(self, command: Command, by_hand: bool, folding: bool = False) -> None:
        memo = self._obey(command)
        void = overruled(self.control.history, command, self.step) if folding else None
        if void is not None:
            memo = self._forget(void)
            if self._holds_anyway(command):
                return
        number = len(self.control.history)
        self._memos[number] = memo
        event = Event(number, self.step, self.trial, command, by_hand)
        self.control = replace(self.control, history=(*self.control.history, event))
        if isinstance(command, Introduce) and self.control.schedule_on:
            self._start_episodes_of(command.skill)

    def _forget(self, number: int) -> Any:
        """Take an event out of the history; returns what was noted for its undoing.

        It is the last, or there is nothing to note for those behind it.
        """
        memo = self._memos[number]
        self.control = replace(self.control, history=without(self.control.history, number))
        del self._memos[len(self.control.history)]
        self._memos.update(dict.fromkeys(range(number, len(self.control.history))))
        return memo

    def _holds_anyway(self, command: Command) -> bool:
        """Whether what a command sets was so before it, by the history."""
        match command:
            case FreezeSelection() | FreezeSkills():
                return command == self._other(type(command)(False), _BEFORE_ALL)
            case FollowSchedule():
                return command == self._other(FollowSchedule(True), _BEFORE_ALL)
            case SetParameter(key=key, value=value):
                return value == self._value_without(key, _BEFORE_ALL)
        return False

    def _begin_trial(self) -> None:
        if self.state.tally[kernel.TRIAL_STEP] != 0:
            return
        trial = self.trial
        going = tuple(e for e in self.control.episodes if e.until_trial > trial)
        due = [timer for timer in self.planned() if timer.trial <= trial]
        past = self.control.next_timer + len(due)
        self.control = replace(self.control, episodes=going, next_timer=past)
        for timer in due:
            if self.control.schedule_on and self._still_wanted(timer):
                self._give(timer.command, by_hand=False)

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

    def _obey(self, command: Command) -> Any:
        """Carry out a command; returns what :meth:`_undo` will need besides, if anything."""
        control = self.control
        match command:
            case Introduce():
                self._introduce(command)
            case Explore():
                return self._explore(command)
            case StopExploring(skill=skill):
                return self._stop_exploring(skill)
            case FreezeSelection(frozen=frozen):
                self.control = replace(control, selection_frozen=frozen)
            case FreezeSkills(frozen=frozen):
                self.control = replace(control, skills_frozen=frozen)
            case FollowSchedule(on=on):
                self.control = replace(control, schedule_on=on)
            case DefineSkill():
                self._define(command)
            case Remove(skill=skill):
                return self._remove(skill)
            case SetParameter():
                self._set_parameter(command)
            case SetSchedule(schedule=schedule):
                self._set_schedule(schedule)
            case Undo(number=number):
                self._undo(number)
            case _:
                assert_never(command)
        return None

    def _undo(self, number: int) -> None:
        history = self.control.history
        if not 0 <= number < len(history) or not history[number].by_hand:
            raise CommandError(f"nothing was done by hand under the number {number}")
        event = history[number]
        if event.undone:
            raise CommandError("that has been undone already")
        memo = self._memos[number]
        match event.command:
            case Introduce(skill=skill):
                self._take_back_introduction(number, skill)
            case Explore(skill=skill):
                self._take_back_exploration(number, skill, memo)
            case StopExploring():
                self._resume_exploring(number, memo)
            case FreezeSelection():
                self._obey(self._other(FreezeSelection(False), number))
            case FreezeSkills():
                self._obey(self._other(FreezeSkills(False), number))
            case FollowSchedule():
                self._obey(self._other(FollowSchedule(True), number))
            case DefineSkill(skill=skill):
                raise CommandError(f"{skill} does nothing until it is added, so it may stay")
            case Remove():
                self._bring_back(number, memo)
            case SetParameter(key=key):
                self._change_spec(key, self._value_without(key, number))
            case SetSchedule():
                self._set_schedule(self._schedule_without(number))
            case Undo():
                raise CommandError("an undo cannot be undone; give the command again")
        marked = replace(event, undone=True)
        self.control = replace(
            self.control, history=(*history[:number], marked, *history[number + 1 :])
        )

    def _others(self, kind: type[Kind], number: int) -> Iterator[tuple[int, Kind]]:
        """Commands of a kind, the latest first, and their numbers.

        Those that were undone are left out, and the one of ``number``.
        """
        for event in reversed(self.control.history):
            if event.number != number and not event.undone and isinstance(event.command, kind):
                yield event.number, event.command

    def _other(self, at_first: Kind, number: int) -> Kind:
        """The command that would hold if the one of this number had not been given.

        ``at_first`` is the command that a run starts as if it had been given.
        """
        return next((command for _, command in self._others(type(at_first), number)), at_first)

    def _last_about(self, skill: str, kind: type[Introduce | Explore], number: int) -> int:
        """Number of the latest command of a kind about a skill.

        Those that were undone are left out, and the one of ``number``.
        """
        numbers = (n for n, command in self._others(kind, number) if command.skill == skill)
        return next(numbers, _BEFORE_ALL)

    def _value_without(self, key: str, number: int) -> float:
        """Value of a parameter if the command of this number had not been given."""
        for _, command in self._others(SetParameter, number):
            if command.key == key:
                return command.value
        return value_of(self.preset, key)

    def _schedule_without(self, number: int) -> ScheduleSpec:
        """The schedule if the command of this number had not been given."""
        at_first = _BEFORE_ALL, SetSchedule(self.preset.schedule)
        given, command = next(self._others(SetSchedule, number), at_first)
        # As each skill that was made room for since then got it.
        timers = dict.fromkeys(self._options_made_after(given), _NO_TIMER)
        schedule = command.schedule
        return schedule.model_copy(update={"skills": {**schedule.skills, **timers}})

    def _options_made_after(self, number: int) -> list[str]:
        """Skills that became options with an introduction later than the event of this number."""
        introduced: dict[str, int] = {}
        for event in self.control.history:
            if isinstance(event.command, Introduce):
                introduced.setdefault(event.command.skill, event.number)
        made = self.spec.learner.skills[len(self.preset.learner.skills) :]
        return [skill for skill in made if introduced[skill] > number]

    def _set_parameter(self, command: SetParameter) -> None:
        if command.key not in PARAMETERS:
            raise CommandError(
                f"{command.key!r} cannot change while a run goes on;"
                f" allowed: {', '.join(PARAMETERS)}"
            )
        self._change_spec(command.key, command.value)

    def _change_spec(self, key: str, value: float) -> None:
        section, name = key.split(".")
        document = self.spec.model_dump()
        document[section][name] = value
        self._adopt(document)
        if section == "world":
            self.world = compile_world(self.spec.world)

    def _adopt(self, document: dict[str, Any]) -> None:
        try:
            spec = RunSpec.model_validate(document)
        except ValidationError as error:
            raise CommandError(_first_problem(error)) from None
        self.control = replace(self.control, spec=spec)

    def _set_schedule(self, schedule: ScheduleSpec) -> None:
        former_timers, control = self._timers, self.control
        document = self.spec.model_dump()
        document["schedule"] = schedule.model_dump()
        self._adopt(document)
        self._timers = timers_of(self.spec)
        past = control.next_timer
        first = self.trial + (self.state.tally[kernel.TRIAL_STEP] > 0)
        if self._timers[:past] != former_timers[:past] or any(
            timer.trial < first for timer in self._timers[past:]
        ):
            self._timers, self.control = former_timers, control
            raise CommandError(
                f"what was to happen before trial {first:,} is past and cannot change;"
                f" allowed: anything from trial {first:,} on"
            )

    def _introduce(self, command: Introduce) -> None:
        skill = command.skill
        learner, schedule = self.spec.learner, self.spec.schedule
        known = {*SKILLS, *learner.custom_skills} if learner.skills else set()
        if skill not in known:
            raise CommandError(
                f"{skill!r} is not a skill of this learner;"
                f" allowed: {', '.join(sorted(known)) or 'none, because its options are moves'}"
            )
        if skill in self.present:
            raise CommandError(f"{skill} has joined already")
        _check_trials("freeze", command.freeze_trials)
        if skill not in learner.skills:
            self._make_room_for(skill)
        trial = self.trial
        join_option(
            self.state,
            self._option(skill),
            learner.initial_q,
            safely=schedule.safe_introduction,
        )
        self.state.tally[kernel.REPERTOIRE] += 1
        self.control = replace(
            self.control,
            introductions=(*self.control.introductions, Introduction(skill, trial, self.step)),
            frozen_until=max(self.control.frozen_until, trial + command.freeze_trials),
        )

    def _make_room_for(self, skill: str) -> None:
        """Let a skill that the preset does not have be an option, absent as yet."""
        former = self.spec
        document = former.model_dump()
        document["learner"]["options"] = (*former.learner.skills, skill)
        document["schedule"]["skills"][skill] = _NO_TIMER.model_dump()
        self._adopt(document)
        self.state = with_option(self.state, former)
        self._timers = timers_of(self.spec)

    def _define(self, command: DefineSkill) -> None:
        document = self.spec.model_dump()
        if command.skill in document["learner"]["custom_skills"]:
            raise CommandError(f"there is a skill named {command.skill!r}; allowed: another name")
        if self.spec.learner.options == MOVES:
            raise CommandError("the options of this learner are moves; it cannot take a skill")
        document["learner"]["custom_skills"][command.skill] = command.weights.model_dump()
        self._adopt(document)

    def _start_episodes_of(self, skill: str) -> None:
        for episode in self.spec.schedule.episodes:
            if episode.skill == skill and episode.at == INTRODUCTION:
                explore = Explore(skill, episode.duration, episode.probability)
                self._give(explore, by_hand=False)

    def _take_back_introduction(self, number: int, skill: str) -> None:
        if skill not in self.present or self._last_about(skill, Introduce, number) > number:
            raise CommandError(f"{skill} has been removed since")
        self._remove(skill)
        history = self.control.history
        freezes = [
            history[other].trial + command.freeze_trials
            for other, command in self._others(Introduce, number)
        ]
        self.control = replace(self.control, frozen_until=max(freezes, default=0))

    def _remove(self, skill: str) -> Removal:
        if skill not in self.present:
            raise CommandError(f"{skill!r} has not joined, so it cannot be removed")
        if len(self.present) == 1:
            raise CommandError(f"{skill} is the only skill, and the learner needs one")
        (left,) = (entry for entry in self.control.introductions if entry.skill == skill)
        column = leave_option(self.state, self._option(skill))
        episode = self._drop_episode(skill)
        others = tuple(entry for entry in self.control.introductions if entry.skill != skill)
        self.control = replace(self.control, introductions=others)
        self.state.tally[kernel.REPERTOIRE] += 1
        return Removal(left, column, episode)

    def _bring_back(self, number: int, removal: Removal) -> None:
        entry, column, episode = removal
        if self._last_about(entry.skill, Introduce, number) > number:
            raise CommandError(f"{entry.skill} has joined again since")
        return_option(self.state, self._option(entry.skill), column)
        self.state.tally[kernel.REPERTOIRE] += 1
        introductions = sorted(
            (*self.control.introductions, entry),
            key=lambda entry: self._last_about(entry.skill, Introduce, number),
        )
        self.control = replace(self.control, introductions=tuple(introductions))
        self._bring_back_episode(number, episode)

    def _stop_exploring(self, skill: str) -> Episode:
        episode = self._drop_episode(skill)
        if episode is None:
            raise CommandError(f"{skill} is not being explored")
        return episode

    def _resume_exploring(self, number: int, episode: Episode) -> None:
        skill = episode.skill
        # Another exploration would have taken its place, and a removal would have ended it.
        ended_since = any(
            self._last_about(skill, kind, number) > number for kind in (Explore, Introduce)
        )
        if ended_since or skill not in self.present or episode.until_trial <= self.trial:
            raise CommandError("that exploration would be over by now")
        self._bring_back_episode(number, episode)

    def _take_back_exploration(self, number: int, skill: str, former: Episode | None) -> None:
        runs = any(e.skill == skill and e.until_trial > self.trial for e in self.control.episodes)
        if not runs or self._last_about(skill, Explore, number) > number:
            raise CommandError(f"that exploration of {skill} is over")
        self._drop_episode(skill)
        self._bring_back_episode(number, former)

    def _bring_back_episode(self, number: int, episode: Episode | None) -> None:
        """Let an episode that the command of this number ended go on, unless it would be over."""
        if episode is None or episode.until_trial <= self.trial:
            return
        episodes = sorted(
            (episode, *self.control.episodes),
            key=lambda episode: self._last_about(episode.skill, Explore, number),
            reverse=True,
        )
        self.control = replace(self.control, episodes=tuple(episodes))

    def _explore(self, command: Explore) -> Episode | None:
        """Begin an episode; returns the one of the same skill that ends with it."""
        if command.skill not in self.present:
            raise CommandError(f"{command.skill!r} has not joined, so it cannot be explored")
        _check_trials("duration", command.duration_trials, fewest=1)
        if not 0 <= command.probability <= 1:
            raise CommandError(
                f"probability: {command.probability} is not allowed; allowed: 0 to 1"
            )
        former = self._drop_episode(command.skill)
        until = self.trial + command.duration_trials
        newest = Episode(command.skill, command.probability, until)
        self.control = replace(self.control, episodes=(newest, *self.control.episodes))
        return former

    def _drop_episode(self, skill: str) -> Episode | None:
        """End the episode of a skill; returns it, None if it has none."""
        episodes = self.control.episodes
        others = tuple(episode for episode in episodes if episode.skill != skill)
        self.control = replace(self.control, episodes=others)
        return next((episode for episode in episodes if episode.skill == skill), None)

    def _option(self, skill: str) -> int:
        return self.spec.learner.skills.index(skill)

    def _settings(self) -> Settings:
        learner = self.spec.learner
        control = self.control
        n_options = n_options_of(self.spec)
        weights = np.zeros((max(len(learner.skills), 1), 4), np.float32)
        for skill, name in enumerate(learner.skills):
            weights[skill, :3] = learner.reward_of(name)
        present = (1 << n_options) - 1
        if learner.skills:
            present = sum(1 << self._option(skill) for skill in self.present)
        return Settings(
            n_options=U(n_options),
            present=U(present),
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


def _check_trials(what: str, trials: int, fewest: int = 0) -> None:
    if not fewest <= trials <= MAX_TRIALS:
        raise CommandError(
            f"{what}: {trials} trials is not allowed; allowed: {fewest} to {MAX_TRIALS}"
        )


def _first_problem(error: ValidationError) -> str:
    first = error.errors()[0]
    key, value, cause = first["loc"], first["input"], first.get("ctx", {}).get("error")
    if isinstance(cause, ProblemsError):
        # Whose value is only the part that is wrong, and not all that was looked at.
        problem = cause.problems[0]
        key, value, message = (*key, *problem.key), problem.value, problem.message
    else:
        message = f"is not allowed: {first['msg']}" if cause is None else str(cause)
    return f"{'.'.join(map(str, key))}: {value!r} {message}"


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
