"""One run of one learner: a function of (spec, seed, commands with their step numbers).

The run applies commands between steps, lets the schedule give its own at the start of the
trials it names, and a rule its own before the trial in which it is met, and calls the kernel from
one such event to the next.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import lru_cache, partial
from typing import NamedTuple, Self

import numpy as np

from learners import control, measures
from learners.checkpoints import Checkpoint, Logs, with_logs, without_logs
from learners.commands import Author, Command, Event, Undo
from learners.comparators import feudal, q_lambda
from learners.control import (
    Control,
    Effect,
    Join,
    Leave,
    MakeRoom,
    Return,
    awaited,
    brought_by,
    is_still_wanted,
)
from learners.kernel import loop
from learners.kernel.forms import forms_of
from learners.kernel.layout import regions_of
from learners.kernel.loop import Settings
from learners.kernel.state import (
    CELL,
    EXERCISES,
    HEADING,
    NO_OPTION,
    OPTION,
    REPERTOIRE,
    STEP,
    TRIAL,
    TRIAL_NEW_STATES,
    TRIAL_REACHED,
    TRIAL_STEP,
    TRIAL_SWITCHES,
    LearnerState,
    copy_state,
    join_option,
    leave_option,
    n_options_of,
    new_state,
    return_option,
    with_option,
    with_room_for,
)
from learners.kernel.templates import seed_option
from learners.learner_spec import HeldSpec
from learners.names import COMMANDS, MAX_TRIALS, MOVES
from learners.policies import taught
from learners.policies.alone import Alone, alone_at, start_number
from learners.policies.held import Held
from learners.policies.static import static_of
from learners.repeats import in_its_place
from learners.spec import RunSpec
from learners.timers import Timer, timers_of
from learners.triggers.watch import is_met, watch_for
from sim import rng
from sim.bits import U
from sim.spec import WorldSpec
from sim.world import World, compile_world, start_of_trial

_NEVER = 2**62


def units(share: float, bits: int) -> np.uint64:
    """A probability as the number of draws, out of 2**bits, for which it comes true."""
    return U(round(share * 2**bits))


def loop_of(spec: RunSpec) -> Callable[[World, LearnerState, Settings, int, int], int]:
    """The loop by which a learner learns; see :func:`learners.kernel.loop.advance`."""
    if spec.learner.options == COMMANDS:
        return feudal.advance
    return loop.advance if spec.learner.trace_decay is None else q_lambda.advance


def _world_of(spec: WorldSpec) -> World:
    """A compiled world; nothing writes into one, so runs and all their moments share it."""
    return _compiled(spec.model_dump_json())


@lru_cache(maxsize=8)
def _compiled(document: str) -> World:
    # By its text, since as numbers 0.0 and -0.0 would be the same.
    return compile_world(WorldSpec.model_validate_json(document))


class _Regime(NamedTuple):
    """All that the settings of the kernel depend on."""

    control: Control
    is_frozen: bool
    is_taught: bool
    alone: Alone | None

    def is_that_of(self, other: "_Regime") -> bool:
        """Whether another is the same; control is compared as the one value it is."""
        return self.control is other.control and self[1:] == other[1:]


class Run:
    """A learner at work. Not safe for use from two threads at once."""

    _settled: tuple[_Regime, Settings] | None = None
    """What held when the settings of the kernel were worked out, and these."""

    def __init__(self, spec: RunSpec, seed: int) -> None:
        """Prepare the run; nothing has been learned yet.

        Raises:
            ValueError: the seed is not allowed.
        """
        self.seed = seed
        self.world: World = _world_of(spec.world)
        self.state: LearnerState = new_state(spec, self.world, seed)
        self.control = Control.at_start(spec)
        self._timers = timers_of(spec)
        self._since = self.control
        """What held when the last step had been made or, if that is later, after an undoing; with
        it, what is made void need not be played from the start."""
        self._begin_trial()

    def copy(self) -> Self:
        """An independent run that stands where this one does."""
        twin = object.__new__(type(self))
        twin.__dict__.update(self.__dict__)
        twin.state = copy_state(self.state)
        return twin

    def checkpoint(self) -> Checkpoint:
        """All that it is now but its logs, which later ones have as well."""
        tables = without_logs(self.state)
        return Checkpoint(self.seed, self.control, self._since, self._timers, tables)

    @classmethod
    def restored(cls, checkpoint: Checkpoint, logs: Logs, room: int = 0) -> Self:
        """An independent run that stands where one stood.

        Args:
            checkpoint: of that run.
            logs: that run's, at that moment or later; they are copied.
            room: trials for which the copy has room at once.
        """
        run = object.__new__(cls)
        run.seed = checkpoint.seed
        run.world = _world_of(checkpoint.control.spec.world)
        run.state = with_logs(checkpoint.state, logs, room)
        run.control = checkpoint.control
        run._timers = checkpoint.timers
        run._since = checkpoint.since
        return run

    @property
    def preset(self) -> RunSpec:
        """The preset as the run started with it."""
        return self.control.preset

    @property
    def spec(self) -> RunSpec:
        """The preset as commands have changed it."""
        return self.control.spec

    @property
    def journal(self) -> list[tuple[int, Command]]:
        """Commands given by hand and their steps: with preset and seed, the whole run."""
        history = self.control.history
        return [(event.step, event.command) for event in history if event.author == "hand"]

    @property
    def step(self) -> int:
        """Steps made so far."""
        return int(self.state.tally[STEP])

    @property
    def trial(self) -> int:
        """The running trial, from 0; so many trials have ended."""
        return int(self.state.tally[TRIAL])

    @property
    def present(self) -> tuple[str, ...]:
        """Skills that have joined, in the order of the options."""
        return self.control.present

    @property
    def selection_is_frozen(self) -> bool:
        """Whether the selection table is held still in the running trial."""
        return self.control.selection_frozen or self.trial < self.control.frozen_until

    @property
    def is_taught(self) -> bool:
        """Whether a script chooses in the running trial."""
        return self.trial < self.control.taught_until

    @property
    def alone(self) -> Alone | None:
        """The skill that is being pre-trained and makes the next step; None once trials began."""
        preset = self.preset
        return alone_at(self.step, preset.schedule.pretrain, preset.learner.skills)

    @property
    def pretrained_steps(self) -> int:
        """Steps of all skills before trials begin."""
        return self.preset.schedule.pretrain * len(self.preset.learner.skills)

    @property
    def start(self) -> tuple[int, int]:
        """Cell and heading with which the running trial, or exercise of a skill, started."""
        if self.alone is None:
            return self.start_of(self.trial)
        return self.start_of(start_number(int(self.state.tally[EXERCISES]) - 1))

    def start_of(self, trial: int) -> tuple[int, int]:
        """Cell and heading with which a trial starts."""
        cell, heading = start_of_trial(self.world, self.state.streams[rng.STARTS], trial)
        return int(cell), int(heading)

    def planned(self) -> tuple[Timer, ...]:
        """What the schedule will still do if it is left on."""
        return self._timers[self.control.next_timer :]

    @property
    def joins_by_rule(self) -> str | None:
        """The skill that a rule lets join with the next step, before a trial; None if none does."""
        joining = awaited(self.control)
        if joining is None or self.state.tally[TRIAL_STEP] != 0:
            return None
        is_due = is_met(self.state, watch_for(joining.rule, joining.since))
        return joining.introduce.skill if is_due else None

    def advance(
        self,
        max_steps: int = _NEVER,
        until_trial: int | None = None,
        stops_at_rules: bool = False,
    ) -> int:
        """Learn for ``max_steps`` steps, or until a trial is about to start, whichever is first.

        ``until_trial`` is the preset's number of trials unless given; with ``stops_at_rules`` it is
        at most the trial before which a rule lets a skill join, unless the run stands there. How
        the steps are divided into calls makes no difference to what is learned.

        Returns:
            The number of steps made.
        """
        until = self.spec.trials if until_trial is None else min(until_trial, MAX_TRIALS)
        # No more trials than steps can end.
        self.state = with_room_for(self.state, min(until, self.trial + max_steps))
        made = 0
        while made < max_steps and self.trial < until:
            if stops_at_rules and made and self.joins_by_rule:
                break
            self._begin_trial()
            stop = min(until, self._next_event())
            settings, first, alone = self._settings(), self.trial, self.alone
            learn, most = loop_of(self.spec), max_steps - made
            if alone is not None:
                most = min(most, alone.until_step - self.step)
            made += learn(self.world, self.state, settings, most, stop)
            if alone is not None and self.step == alone.until_step:
                self._end_of(alone)
            ended = slice(first, self.trial)
            outcomes = self.state.log_outcome[ended]
            self.state.log_reward[ended] = measures.rewards(self.spec.world, outcomes)
            self._since = self.control
        return made

    def apply(self, command: Command, replacing: bool = False) -> None:
        """Carry out a command given by hand, and note it in the history.

        With ``replacing`` it takes the place of one that it makes void before a step was made, and
        what a command and its contrary leave as it was leaves no note. What is learned is the same.

        Raises:
            CommandError: it cannot be carried out now; nothing has changed.
        """
        former, event = self.control, self._event(command, "hand")
        after, effects = control.apply(former, event)
        if replacing:
            after = in_its_place(former, event, self._since) or after
        self._adopt(after, effects)
        self._bring(event)
        if isinstance(command, Undo):
            self._since = self.control

    def check(self, command: Command) -> None:
        """Judge a command by hand without carrying it out.

        Raises:
            CommandError: it cannot be carried out now.
        """
        control.apply(self.control, self._event(command, "hand"))

    def _event(self, command: Command, author: Author, cause: int | None = None) -> Event:
        number, trial_step = len(self.control.history), int(self.state.tally[TRIAL_STEP])
        return Event(number, self.step, self.trial, trial_step, command, author, cause)

    def _bring(self, event: Event) -> None:
        """Let the schedule give what comes with an event that has just been noted."""
        for command in brought_by(self.control, event.command):
            brought = self._event(command, "schedule", cause=event.number)
            self._adopt(*control.apply(self.control, brought))

    def _adopt(self, after: Control, effects: Iterable[Effect]) -> None:
        """Let something hold from here on, and do to the tables what that takes."""
        former, self.control = self.control, after
        if after.spec is not former.spec:
            self._timers = timers_of(after.spec)
        if after.spec.world != former.spec.world:
            self.world = _world_of(after.spec.world)
        for effect in effects:
            if isinstance(effect, MakeRoom):
                self.state = with_option(self.state, former.spec, after.spec)
                continue
            option, learner = self._option(effect.skill), after.spec.learner
            match effect:
                case Join():
                    safely = after.spec.schedule.safe_introduction
                    seed = partial(seed_option, after.spec, effect.skill)
                    join_option(self.state, option, learner.initial_q, safely=safely, seed=seed)
                case Leave():
                    self._keep(leave_option(self.state, option))
                case Return(number=number):
                    column = after.history[number].taken_out
                    assert column is not None
                    return_option(self.state, option, column)
            self.state.tally[REPERTOIRE] += 1

    def _keep(self, column: np.ndarray) -> None:
        """Let the latest event keep the values of the skill that left with it."""
        *earlier, latest = self.control.history
        latest = replace(latest, taken_out=column)
        self.control = replace(self.control, history=(*earlier, latest))

    def _begin_trial(self) -> None:
        if self.state.tally[TRIAL_STEP] != 0:
            return
        trial = self.trial
        due = [timer.command for timer in self.planned() if timer.trial <= trial]
        past = self.control.next_timer + len(due)
        going = self.control.running(trial)
        self.control = replace(self.control, episodes=going, next_timer=past)
        for command in due:
            if is_still_wanted(self.control, command):
                self._give(command, "schedule")
        joining = awaited(self.control)
        if joining is not None and self.joins_by_rule:
            self._give(joining.introduce, "trigger")

    def _give(self, command: Command, author: Author) -> None:
        """Carry out a command that is given at the start of a trial."""
        event = self._event(command, author)
        self._adopt(*control.apply(self.control, event))
        self._bring(event)

    def _end_of(self, alone: Alone) -> None:
        """Place the predator where the next skill begins to learn by itself, or the first trial."""
        tally, place = self.state.tally, self.state.place
        if alone.is_last:
            cell, heading = self.start_of(0)
            # What a skill saw by itself is new to the selection.
            tally[REPERTOIRE] += 1
        else:
            cell, heading = self.start_of(start_number(int(tally[EXERCISES])))
            tally[EXERCISES] += 1
        place[CELL], place[HEADING], place[OPTION] = cell, heading, NO_OPTION
        tally[[TRIAL_STEP, TRIAL_NEW_STATES, TRIAL_REACHED, TRIAL_SWITCHES]] = 0

    def _next_event(self) -> int:
        """Trial before which the settings of the kernel may change."""
        trial = self.trial
        events = [timer.trial for timer in self.planned()[:1]]
        events += [episode.until_trial for episode in self.control.episodes]
        events += [self.control.frozen_until, self.control.taught_until]
        return min((event for event in events if event > trial), default=_NEVER)

    def _option(self, skill: str) -> int:
        return self.spec.learner.skills.index(skill)

    def _settings(self) -> Settings:
        """What the kernel goes by; worked out anew where something else holds than before."""
        now = _Regime(self.control, self.selection_is_frozen, self.is_taught, self.alone)
        if self._settled is None or not self._settled[0].is_that_of(now):
            self._settled = now, self._settings_now(now)
        return self._settled[1]

    def _settings_now(self, regime: _Regime) -> Settings:
        learner, alone = self.spec.learner, regime.alone
        episodes = self.control.episodes if alone is None else ()
        n_options = n_options_of(self.spec)
        weights = np.zeros((max(len(learner.skills), 1), 4), np.float32)
        for skill, name in enumerate(learner.skills):
            weights[skill, :3] = learner.reward_of(name)
        present = (1 << n_options) - 1
        if learner.skills:
            present = sum(1 << self._option(skill) for skill in self.present)
        skill_alpha = 0.0 if self.control.skills_frozen else learner.skill_alpha
        script = None
        if regime.is_taught and alone is None:
            name = self.control.script
            script = taught.table_of(name, self.spec.world, learner.skills, self.present)
        learns_from_all = learner.skills_that_learn == "all" and alone is None
        values = [e.value_at_most for e in episodes]
        at_most = np.array([np.inf if value is None else value for value in values], np.float32)
        joining = awaited(self.control) if alone is None else None
        return Settings(
            n_options=U(n_options),
            present=U(present),
            options_are_moves=learner.options == MOVES,
            reward_weights=weights.ravel(),
            rewards_are_binary=True if learner.local_rewards == "binary" else None,
            all_skills_learn=True if learns_from_all else None,
            alpha=np.float32(0.0 if regime.is_frozen else learner.alpha),
            skill_alpha=np.float32(skill_alpha),
            gamma=np.float32(learner.gamma),
            epsilon16=units(learner.epsilon, 16),
            n_episodes=len(episodes),
            episode_option=np.array([self._option(e.skill) for e in episodes], np.uint64),
            episode_chance=np.array([units(e.probability, 32) for e in episodes], np.uint64),
            script=script,
            held=None if alone is not None else _held(learner.held),
            applicable=None if learner.applicable is None else np.float32(learner.applicable),
            alone=None if alone is None else U(self._option(alone.skill)),
            episode_value_at_most=at_most if any(v is not None for v in values) else None,
            watch=None if joining is None else watch_for(joining.rule, joining.since),
            trace_decay=None if learner.trace_decay is None else np.float32(learner.trace_decay),
            regions=regions_of(self.spec),
            forms=forms_of(self.spec, skills_learn=not self.control.skills_frozen),
            static=None if alone is not None else static_of(learner),
        )


def _held(spec: HeldSpec | None) -> Held | None:
    if spec is None:
        return None
    return Held(spec.until == "change", spec.most, spec.discount == "choice")


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
