"""What commands make of a run: a pure function of its history, which is the truth.

An event is a command that was carried out, with its moment. From the preset on, event by event,
:func:`evolve` says what holds; once a command is taken back, what holds is what the history comes
to without it. :func:`apply` is the same for a command that is given now: it refuses what cannot be
carried out, and says besides what is to be done to the tables. With their state, control is all
that a run is at a moment.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self, assert_never

from pydantic import ValidationError

from learners.commands import (
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
    StopTeaching,
    Teach,
    Undo,
)
from learners.misfits import not_for_script
from learners.names import INTRODUCTION, MAX_TRIALS, MAX_VALUE, Script
from learners.parameters import parameters_of, with_value
from learners.schedule_spec import SkillTimer
from learners.spec import RunSpec
from learners.timers import Awaited, exploration_of, timers_of
from sim.spec import ProblemsError

_NO_TIMER = SkillTimer(at=MAX_TRIALS)
"""Of a skill that became an option by hand; without one it would have joined at the start."""


class Episode(NamedTuple):
    """A biased exploration episode that is running."""

    skill: str
    probability: float
    until_trial: int
    """First trial after it."""
    value_at_most: float | None = None
    """Where it acts, see :class:`learners.commands.Explore`."""


class Introduction(NamedTuple):
    """A skill that joined, and when."""

    skill: str
    trial: int
    step: int


@dataclass(frozen=True)
class Control:
    """What commands have set; with the state of the tables, all that a run is at a moment."""

    preset: RunSpec
    """As the run started with it."""
    spec: RunSpec
    """The preset as commands have changed it."""
    introductions: tuple[Introduction, ...] = ()
    """Of the skills that are present, the newest last."""
    removed: tuple[str, ...] = ()
    """Skills that are not present since they were taken out: no rule lets them join again."""
    episodes: tuple[Episode, ...] = ()
    """The newest first; at most one for each skill."""
    frozen_until: int = 0
    """First trial in which the freeze of an introduction is over."""
    taught_until: int = 0
    """First trial in which no script chooses."""
    script: Script = "flank"
    """Which does until then."""
    selection_frozen: bool = False
    skills_frozen: bool = False
    schedule_on: bool = True
    next_timer: int = 0
    """Timers before this one are past."""
    history: tuple[Event, ...] = ()

    @classmethod
    def at_start(cls, preset: RunSpec) -> Self:
        """Before any command."""
        return cls(preset, preset)

    @property
    def present(self) -> tuple[str, ...]:
        """Skills that have joined, in the order of the options."""
        joined = {introduction.skill for introduction in self.introductions}
        return tuple(skill for skill in self.spec.learner.skills if skill in joined)

    def running(self, trial: int) -> tuple[Episode, ...]:
        """Episodes that are not over in a trial, the newest first."""
        return tuple(episode for episode in self.episodes if episode.until_trial > trial)


class MakeRoom(NamedTuple):
    """The tables get room for one more skill, absent as yet."""

    skill: str


class Join(NamedTuple):
    """A skill gets its first values in the selection table."""

    skill: str


class Leave(NamedTuple):
    """A skill's values are taken out of the selection table; the event keeps them."""

    skill: str


class Return(NamedTuple):
    """A skill gets the values back that an event keeps."""

    skill: str
    number: int
    """Of the event with which it left."""


Effect = MakeRoom | Join | Leave | Return


def awaited(control: Control) -> Awaited | None:
    """The first of the skills listed that is to join by a rule; None if none is, or by the schedule
    nothing happens."""
    schedule = control.spec.schedule
    gone = {*control.present, *control.removed}
    for skill in control.spec.learner.skills if control.schedule_on else ():
        rule = schedule.rule_of(skill)
        if rule is not None and skill not in gone:
            return Awaited(Introduce(skill, schedule.freeze_of(skill)), rule, control.frozen_until)
    return None


def is_still_wanted(control: Control, command: Command) -> bool:
    """Whether a timer's command is to be given: it yields to what was done before."""
    match command:
        case Introduce(skill=skill):
            return control.schedule_on and skill not in control.present
        case Explore(skill=skill):
            return control.schedule_on and skill in control.present
    return control.schedule_on


def brought_by(control: Control, command: Command) -> tuple[Command, ...]:
    """What the schedule gives right after a command: the explorations of a skill that joins."""
    if not isinstance(command, Introduce) or not control.schedule_on:
        return ()
    return tuple(
        exploration_of(episode)
        for episode in control.spec.schedule.episodes
        if episode.skill == command.skill and episode.at == INTRODUCTION
    )


def apply(control: Control, event: Event) -> tuple[Control, tuple[Effect, ...]]:
    """Carry out a command that is given now, and note it in the history.

    Args:
        control: what holds before it.
        event: the command and its moment; its number is the length of the history.

    Returns:
        What holds after it, and what it does to the tables, in this order.

    Raises:
        CommandError: it cannot be carried out now.
    """
    _check(control, event)
    after = evolve(control, event)
    if isinstance(event.command, Undo):
        _check_stop(control, after, event.command.number, event.trial)
    if after.spec.schedule != control.spec.schedule:
        _check_past_is_kept(control, after, event)
    return after, tuple(_effects(control, after, event))


def evolve(control: Control, event: Event) -> Control:
    """What holds after an event, noted in the history; it could be carried out at its moment."""
    if isinstance(event.command, Undo):
        history, number = control.history, event.command.number
        marked = replace(history[number], undone=True)
        history = (*history[:number], marked, *history[number + 1 :])
        after = as_if(control, history, event.trial)
    else:
        after = _changed(control, event)
    return replace(after, history=(*after.history, event))


def as_if(
    control: Control, history: tuple[Event, ...], trial: int, since: Control | None = None
) -> Control:
    """What would hold in a trial if this had been the history of a run.

    Nothing holds of an event that is undone, nor of what the schedule gave because of it; only the
    room in the tables stays, since what was learned stays. What is about a skill that is not there
    then falls away, and what the schedule would have done meanwhile is not made up for.

    Args:
        control: what holds, for the preset and for where the schedule stands.
        history: what is to have happened.
        trial: the running trial.
        since: what held at a moment up to which the history is the same, to go on from there.
    """
    after = Control.at_start(control.preset) if since is None else since
    later = history[len(after.history) :]
    undone = {event.number for event in later if event.undone}
    for event in later:
        if event.number not in undone and event.cause not in undone:
            after = _changed(after, event)
        elif isinstance(event.command, Introduce):
            after = _with_room_for(after, event.command.skill)
    return replace(
        after, episodes=after.running(trial), next_timer=control.next_timer, history=history
    )


def _changed(control: Control, event: Event) -> Control:
    """What holds after a command, without a note of it."""
    match event.command:
        case Introduce(skill=skill, freeze_trials=freeze):
            control = _with_room_for(control, skill)
            entry = Introduction(skill, event.trial, event.step)
            return replace(
                control,
                introductions=(*control.introductions, entry),
                removed=tuple(gone for gone in control.removed if gone != skill),
                frozen_until=max(control.frozen_until, event.trial + freeze),
            )
        case Explore(skill=skill, duration_trials=duration, probability=probability) as explore:
            if skill not in control.present:
                return control
            until = event.trial + duration
            newest = Episode(skill, probability, until, explore.value_at_most)
            return replace(control, episodes=(newest, *_without(skill, control.episodes)))
        case StopExploring(skill=skill):
            return replace(control, episodes=_without(skill, control.episodes))
        case Teach(script=script, duration_trials=duration):
            return replace(control, taught_until=event.trial + duration, script=script)
        case StopTeaching():
            return replace(control, taught_until=0)
        case FreezeSelection(frozen=frozen):
            return replace(control, selection_frozen=frozen)
        case FreezeSkills(frozen=frozen):
            return replace(control, skills_frozen=frozen)
        case FollowSchedule(on=on):
            return replace(control, schedule_on=on)
        case DefineSkill(skill=skill, weights=weights):
            own = control.spec.learner.custom_skills | {skill: weights}
            return replace(control, spec=_with(control.spec, "learner", custom_skills=own))
        case Remove(skill=skill):
            # The freeze of its introduction goes on.
            return replace(
                control,
                introductions=_without(skill, control.introductions),
                removed=(*control.removed, skill),
                episodes=_without(skill, control.episodes),
            )
        case SetParameter(key=key, value=value):
            return replace(control, spec=with_value(control.spec, key, value))
        case SetSchedule(schedule=schedule):
            return replace(control, spec=control.spec.model_copy(update={"schedule": schedule}))
        case Undo():
            return control
        case _:
            assert_never(event.command)


def _without(skill: str, entries: tuple[Any, ...]) -> tuple[Any, ...]:
    return tuple(entry for entry in entries if entry.skill != skill)


def _with(spec: RunSpec, section: str, **values: object) -> RunSpec:
    part = getattr(spec, section).model_copy(update=values)
    return spec.model_copy(update={section: part})


def _with_room_for(control: Control, skill: str) -> Control:
    """Let a skill that the preset does not have be an option, absent as yet."""
    spec = control.spec
    if skill in spec.learner.skills:
        return control
    spec = _with(spec, "learner", options=(*spec.learner.skills, skill))
    spec = _with(spec, "schedule", skills=spec.schedule.skills | {skill: _NO_TIMER})
    return replace(control, spec=spec)


def _effects(before: Control, after: Control, event: Event) -> Iterable[Effect]:
    yield from map(MakeRoom, after.spec.learner.skills[len(before.spec.learner.skills) :])
    for skill in after.present:
        if skill not in before.present:
            undo = event.command if isinstance(event.command, Undo) else None
            yield Join(skill) if undo is None else Return(skill, undo.number)
    yield from (Leave(skill) for skill in before.present if skill not in after.present)


def _check(control: Control, event: Event) -> None:
    match event.command:
        case Introduce():
            _check_introduction(control, event.command)
        case Explore():
            _check_exploration(control, event.command)
        case StopExploring(skill=skill):
            if all(episode.skill != skill for episode in control.episodes):
                raise CommandError(f"{skill} is not being explored")
        case Teach():
            _check_teaching(control, event.command)
        case StopTeaching():
            if control.taught_until <= event.trial:
                raise CommandError("no script is teaching")
        case DefineSkill(skill=skill, weights=weights):
            document = control.spec.model_dump()
            if skill in document["learner"]["custom_skills"]:
                raise CommandError(f"there is a skill named {skill!r}; allowed: another name")
            if not control.spec.learner.skills:
                what = control.spec.learner.options
                raise CommandError(
                    f"the options of this learner are {what}; it cannot take a skill"
                )
            document["learner"]["custom_skills"][skill] = weights.model_dump()
            _check_spec(document)
        case Remove(skill=skill):
            if skill not in control.present:
                raise CommandError(f"{skill!r} has not joined, so it cannot be removed")
            if len(control.present) == 1:
                raise CommandError(_only(skill))
        case SetParameter(key=key, value=value):
            allowed = parameters_of(control.spec)
            if key not in allowed:
                raise CommandError(
                    f"{key!r} cannot change while a run goes on; allowed: {', '.join(allowed)}"
                )
            _check_spec(with_value(control.spec, key, value).model_dump())
        case SetSchedule(schedule=schedule):
            _check_spec(control.spec.model_dump() | {"schedule": schedule.model_dump()})
        case Undo(number=number):
            _check_undoing(control, number, event.trial)
        case FreezeSelection() | FreezeSkills() | FollowSchedule():
            pass
        case _:
            assert_never(event.command)


def _check_introduction(control: Control, command: Introduce) -> None:
    skill, learner = command.skill, control.spec.learner
    known = {*learner.known_skills} if learner.skills else set[str]()
    options = learner.options
    if skill not in known:
        raise CommandError(
            f"{skill!r} is not a skill of this learner;"
            f" allowed: {', '.join(sorted(known)) or f'none, because its options are {options}'}"
        )
    if skill in control.present:
        raise CommandError(f"{skill} has joined already")
    _check_trials("freeze", command.freeze_trials)
    if skill not in learner.skills:
        _check_spec(_with_room_for(control, skill).spec.model_dump())


def _check_exploration(control: Control, command: Explore) -> None:
    if command.skill not in control.present:
        raise CommandError(f"{command.skill!r} has not joined, so it cannot be explored")
    _check_trials("duration", command.duration_trials, fewest=1)
    if not 0 <= command.probability <= 1:
        raise CommandError(f"probability: {command.probability} is not allowed; allowed: 0 to 1")
    value = command.value_at_most
    if value is not None and control.spec.learner.selection != "learned":
        raise CommandError(
            "value_at_most: what a state is worth is not learned by this selection; allowed: none"
        )
    if value is not None and not abs(value) <= MAX_VALUE:
        raise CommandError(
            f"value_at_most: {value} is not allowed; allowed: {-MAX_VALUE:g} to {MAX_VALUE:g}"
        )


def _check_teaching(control: Control, command: Teach) -> None:
    reason = not_for_script(control.spec.learner)
    if reason is not None:
        raise CommandError(f"{command.script} {reason}")
    _check_trials("duration", command.duration_trials, fewest=1)


def _check_trials(what: str, trials: int, fewest: int = 0) -> None:
    if not fewest <= trials <= MAX_TRIALS:
        raise CommandError(
            f"{what}: {trials} trials is not allowed; allowed: {fewest} to {MAX_TRIALS}"
        )


def _check_spec(document: dict[str, Any]) -> None:
    try:
        RunSpec.model_validate(document)
    except ValidationError as error:
        raise CommandError(_first_problem(error)) from None


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


def _check_past_is_kept(control: Control, after: Control, event: Event) -> None:
    steps, steps_after = (each.spec.schedule.pretrain for each in (control, after))
    if steps != steps_after:
        raise CommandError(
            f"pretrain: {steps_after} is not allowed, since pre-training comes before the first"
            f" step of a run; allowed: {steps}"
        )
    past, timers = control.next_timer, timers_of(after.spec)
    first = event.trial + (event.trial_step > 0)
    if timers[:past] != timers_of(control.spec)[:past] or any(
        timer.trial < first for timer in timers[past:]
    ):
        raise CommandError(
            f"what was to happen before trial {first:,} is past and cannot change;"
            f" allowed: anything from trial {first:,} on"
        )


def _check_undoing(control: Control, number: int, trial: int) -> None:
    history = control.history
    if not 0 <= number < len(history) or history[number].author != "hand":
        raise CommandError(f"nothing was done by hand under the number {number}")
    if history[number].undone:
        raise CommandError("that has been undone already")
    match history[number].command:
        case DefineSkill(skill=skill):
            raise CommandError(f"{skill} does nothing until it is added, so it may stay")
        case Undo():
            raise CommandError("an undo cannot be undone; give the command again")
        case Introduce(skill=skill):
            if _is_followed(control, number, Remove, skill):
                raise CommandError(f"{skill} has been removed since")
            if control.present == (skill,):
                raise CommandError(_only(skill))
        case Remove(skill=skill):
            if _is_followed(control, number, Introduce, skill):
                raise CommandError(f"{skill} has joined again since")
        case Explore(skill=skill):
            runs = any(episode.skill == skill for episode in control.running(trial))
            if not runs or _is_followed(control, number, Explore, skill):
                raise CommandError(f"that exploration of {skill} is over")
        case Teach():
            later = (event.command for event in history[number + 1 :] if not event.undone)
            if control.taught_until <= trial or any(isinstance(one, Teach) for one in later):
                raise CommandError("that teaching is over")


def _check_stop(control: Control, after: Control, number: int, trial: int) -> None:
    """If the end of an exploration or of teaching is undone, that must go on with it."""
    command = control.history[number].command
    if isinstance(command, StopExploring) and after.episodes == control.running(trial):
        raise CommandError("that exploration would be over by now")
    if isinstance(command, StopTeaching) and after.taught_until <= trial:
        raise CommandError("that teaching would be over by now")


def _is_followed(
    control: Control, number: int, kind: type[Introduce | Remove | Explore], skill: str
) -> bool:
    """Whether a command of a kind about a skill holds that was given after another event."""
    history = control.history
    return any(
        isinstance(event.command, kind) and event.command.skill == skill
        for event in history[number + 1 :]
        if not event.undone and (event.cause is None or not history[event.cause].undone)
    )


def _only(skill: str) -> str:
    return f"{skill} is the only skill, and the learner needs one"
