"""The schedule as blocks: what lasts from one trial to another; pure functions.

Blocks of what has happened come from the run's history, which is played through again; blocks of
what is planned come from the schedule. Only the latter can be edited, and only while they lie
ahead.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from app.snapshot import Snapshot
from app.words import plain
from learners.commands import (
    Event,
    Explore,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Remove,
    StopExploring,
    Undo,
)
from learners.control import timers_of
from learners.spec import INTRODUCTION, MAX_TRIALS, RunSpec

Kind = Literal["presence", "introduction", "exploration", "selection_freeze", "skills_freeze"]
State = Literal["done", "running", "planned", "idle"]

FREEZES: tuple[Kind, Kind] = ("selection_freeze", "skills_freeze")
"""Kinds that only a person begins; they share the last lane."""

FROZEN: dict[Kind, str] = {"selection_freeze": "selection", "skills_freeze": "skills"}
"""What they hold still."""

MAX_PAST = 100
"""Blocks by hand that are drawn once they are over: a held key makes thousands."""

NEVER = MAX_TRIALS
"""Trial of a timer that never comes: a run ends before it."""


@dataclass(frozen=True)
class Block:
    """Something on the timeline."""

    id: str
    """What it is edited by: it stays the same while time passes, and while blocks change."""
    kind: Kind
    skill: str
    """Its lane; empty for a freeze by hand."""
    first: int
    """First trial."""
    until: int | None
    """First trial after it; None if it lasts until somebody ends it."""
    state: State
    """``idle`` is what is in the plan and will not happen as things stand."""
    by_hand: bool = False
    """Whether a person began it, or changed what the preset plans."""
    undone: bool = False
    """Whether the command behind it has been taken back since."""
    editable: bool = False
    probability: float | None = None
    """Of an exploration."""

    @property
    def trials(self) -> int:
        """How long it lasts: the freeze of an introduction, the duration of an exploration."""
        return 0 if self.until is None else self.until - self.first

    @property
    def last(self) -> int | None:
        """Last trial; an introduction without a freeze takes place in its first."""
        return None if self.until is None else max(self.until - 1, self.first)


def blocks_of(snapshot: Snapshot) -> tuple[Block, ...]:
    """All that has happened to the repertoire, in the order it began, and then what is planned."""
    return (*_happened(snapshot), *_planned(snapshot))


class _Reel:
    """Plays the history of a run through, and notes what lasted from when to when.

    It follows what :class:`learners.run.Run` does with each command.
    """

    def __init__(self, preset: RunSpec) -> None:
        self._preset = preset
        self._blocks: dict[str, Block] = {}
        """By their ids, in the order in which they began."""
        self._open: dict[tuple[Kind, str], str] = {}
        """Id of the latest block of each kind and lane that has not been ended."""
        self._former: dict[int, Block | None] = {}
        """Exploration that a command ended and its undoing brings back, by its event's number."""
        self._freezes: dict[Kind, dict[int, bool]] = {kind: {} for kind in FREEZES}
        """What was asked for by hand and not taken back, by the number of its event."""
        self._frozen_since: dict[Kind, int] = {}
        """Step in which the latest freeze by hand of each kind began."""

    @property
    def blocks(self) -> tuple[Block, ...]:
        """What lasted from when to when so far."""
        return tuple(self._blocks.values())

    @property
    def open_ids(self) -> frozenset[str]:
        """Ids of what nobody has ended."""
        return frozenset(self._open.values())

    def play(self, event: Event, history: Sequence[Event]) -> None:
        """Note what a command did."""
        match event.command:
            case Introduce(skill=skill, freeze_trials=freeze):
                self._begin(event, "introduction", skill, freeze)
                self._begin(event, "presence", skill, None)
            case Explore(skill=skill, duration_trials=duration, probability=probability):
                self._former[event.number] = self._end("exploration", skill, event.trial)
                self._begin(event, "exploration", skill, duration, probability)
            case StopExploring(skill=skill):
                self._former[event.number] = self._end("exploration", skill, event.trial)
            case Remove(skill=skill):
                self._former[event.number] = self._remove(skill, event.trial)
            case FreezeSelection(frozen=frozen):
                self._freezes["selection_freeze"][event.number] = frozen
                self._freeze(event, "selection_freeze", frozen)
            case FreezeSkills(frozen=frozen):
                self._freezes["skills_freeze"][event.number] = frozen
                self._freeze(event, "skills_freeze", frozen)
            case Undo(number=number):
                self._undo(event, history[number])

    def _undo(self, event: Event, undone: Event) -> None:
        match undone.command:
            case Introduce(skill=skill):
                self._remove(skill, event.trial)
                joined = self._blocks[_id_of(undone, "introduction")]
                if joined.until is not None and joined.until > event.trial:
                    self._blocks[joined.id] = replace(joined, until=event.trial)
            case Explore(skill=skill):
                self._end("exploration", skill, event.trial)
                self._resume(event, undone)
            case StopExploring():
                self._resume(event, undone)
            case Remove(skill=skill):
                self._begin(event, "presence", skill, None)
                self._resume(event, undone)
            case FreezeSelection():
                self._undo_freeze(event, "selection_freeze", undone)
            case FreezeSkills():
                self._undo_freeze(event, "skills_freeze", undone)

    def _begin(
        self,
        event: Event,
        kind: Kind,
        skill: str,
        trials: int | None,
        probability: float | None = None,
    ) -> None:
        self._add(
            Block(
                id=_id_of(event, kind),
                kind=kind,
                skill=skill,
                first=event.trial,
                until=None if trials is None else event.trial + trials,
                state="running",
                by_hand=event.author == "hand" or not self._is_of_preset(event),
                undone=event.undone,
                probability=probability,
            )
        )

    def _add(self, block: Block) -> None:
        self._open[block.kind, block.skill] = block.id
        self._blocks[block.id] = block

    def _is_of_preset(self, event: Event) -> bool:
        """Whether the preset has what the schedule did: it may have been edited since."""
        match event.command:
            case Introduce(skill=skill, freeze_trials=freeze):
                return (event.trial, freeze) == _timer_of(self._preset, skill)
            case Explore(skill=skill, duration_trials=duration, probability=probability):
                starts: list[int | str] = [event.trial]
                joined = self._open.get(("presence", skill))
                if joined is not None and self._blocks[joined].first == event.trial:
                    starts.append(INTRODUCTION)
                return any(
                    (episode.skill, episode.duration, episode.probability)
                    == (skill, duration, probability)
                    and episode.at in starts
                    for episode in self._preset.schedule.episodes
                )
        return True

    def _end(self, kind: Kind, skill: str, trial: int) -> Block | None:
        """End what is open in a lane; returns it as it was, None if there is nothing to end."""
        id = self._open.pop((kind, skill), None)
        if id is None:
            return None
        block = self._blocks[id]
        if block.until is not None and block.until <= trial:
            return None
        self._blocks[id] = replace(block, until=trial)
        return block

    def _resume(self, event: Event, undone: Event) -> None:
        """Let the exploration that a command ended go on, unless it would be over."""
        former = self._former[undone.number]
        if former is not None and former.first + former.trials > event.trial:
            self._add(replace(former, id=_id_of(event, "exploration"), first=event.trial))

    def _remove(self, skill: str, trial: int) -> Block | None:
        """Take a skill out; returns its exploration, if it was being explored."""
        # The freeze of its introduction goes on.
        self._end("presence", skill, trial)
        return self._end("exploration", skill, trial)

    def _freeze(self, event: Event, kind: Kind, frozen: bool) -> None:
        was_frozen = (kind, "") in self._open
        if frozen and not was_frozen:
            self._frozen_since[kind] = event.step
            self._begin(event, kind, "", None)
        elif was_frozen and not frozen:
            self._thaw(event, kind)

    def _thaw(self, event: Event, kind: Kind) -> None:
        if self._frozen_since[kind] == event.step:
            # Not a step was made, so nothing was held still.
            del self._blocks[self._open.pop((kind, ""))]
        else:
            self._end(kind, "", event.trial)

    def _undo_freeze(self, event: Event, kind: Kind, undone: Event) -> None:
        asked = self._freezes[kind]
        del asked[undone.number]
        # What was taken back ends even where another command holds still what it held still.
        if self._open.get((kind, "")) == _id_of(undone, kind):
            self._thaw(event, kind)
        self._freeze(event, kind, next(reversed(asked.values()), False))


class Past:
    """What has happened in a run, kept up with it as its history grows, and kept small."""

    def __init__(self) -> None:
        self._preset: RunSpec | None = None
        self._history: tuple[Event, ...] = ()
        self._reel: _Reel | None = None
        self._kept: tuple[Block, ...] = ()
        self.left_out = 0
        """Blocks that are over and that nobody can tell apart any more among so many."""

    def blocks_of(self, snapshot: Snapshot) -> tuple[Block, ...]:
        """As the function of this name, but of what was done by hand and is over the newest."""
        history = snapshot.control.history
        if history is not self._history or snapshot.preset_spec is not self._preset:
            self._play(snapshot.preset_spec, history)
        return (*_as_of(self._kept, snapshot.trial), *_planned(snapshot))

    def _play(self, preset: RunSpec, history: tuple[Event, ...]) -> None:
        known = len(self._history)
        is_longer = known and len(history) > known and history[known - 1] is self._history[-1]
        # An undo changes what was noted before it.
        undone = any(isinstance(event.command, Undo) for event in history[known:])
        if self._reel is None or preset is not self._preset or not is_longer or undone:
            self._reel, known = _Reel(preset), 0
        for event in history[known:]:
            self._reel.play(event, history)
        self._preset, self._history = preset, history
        over = [block.id for block in self._reel.blocks if block.by_hand]
        over = [id for id in over if id not in self._reel.open_ids]
        lost = set(over[:-MAX_PAST])
        self.left_out = len(lost)
        self._kept = tuple(block for block in self._reel.blocks if block.id not in lost)


def _id_of(event: Event, kind: Kind) -> str:
    """Id of the block of a kind that a command began."""
    return f"presence:{event.number}" if kind == "presence" else f"event:{event.number}"


def _timer_of(spec: RunSpec, skill: str) -> tuple[int, int]:
    """Trial in which a preset lets a skill join, and the freeze; never if it has no such option."""
    if skill not in spec.learner.skills:
        return NEVER, 0
    return spec.schedule.introduced_at(skill), spec.schedule.freeze_of(skill)


def _happened(snapshot: Snapshot) -> tuple[Block, ...]:
    history = snapshot.control.history
    reel = _Reel(snapshot.preset_spec)
    for event in history:
        reel.play(event, history)
    return _as_of(reel.blocks, snapshot.trial)


def _as_of(blocks: Iterable[Block], trial: int) -> tuple[Block, ...]:
    """Blocks as they are in a trial: done where they are over."""
    return tuple(
        block if block.until is None or block.until > trial else replace(block, state="done")
        for block in blocks
    )


def _planned(snapshot: Snapshot) -> Iterable[Block]:
    """What the schedule still has ahead, by skill and then by its list of episodes."""
    schedule, present = snapshot.spec.schedule, snapshot.present
    preset = snapshot.preset_spec
    ahead = timers_of(snapshot.spec)[snapshot.control.next_timer :]
    joining = {
        timer.command.skill
        for timer in ahead
        if isinstance(timer.command, Introduce) and timer.command.skill not in present
    }
    exploring = {
        (timer.trial, timer.command.skill) for timer in ahead if isinstance(timer.command, Explore)
    }
    on = snapshot.control.schedule_on

    def block(
        id: str,
        kind: Kind,
        skill: str,
        first: int,
        trials: int,
        is_of_preset: bool,
        probability: float | None = None,
    ) -> Block:
        happens = on and first < NEVER and (skill in present or skill in joining)
        return Block(
            id=id,
            kind=kind,
            skill=skill,
            first=first,
            until=first + trials,
            state="planned" if happens else "idle",
            by_hand=not is_of_preset,
            editable=first > snapshot.trial,
            probability=probability,
        )

    for skill in snapshot.spec.learner.skills:
        if skill in joining:
            at, freeze = schedule.introduced_at(skill), schedule.freeze_of(skill)
            kept = (at, freeze) == _timer_of(preset, skill)
            yield block(_introduction_id(skill), "introduction", skill, at, freeze, kept)
    for index, episode in enumerate(schedule.episodes):
        skill, first = episode.skill, schedule.starts_at(episode)
        bound = episode.at == INTRODUCTION
        if (skill in joining) if bound else ((first, skill) in exploring):
            yield block(
                episode_id(index, skill),
                "exploration",
                skill,
                first,
                episode.duration,
                episode in preset.schedule.episodes,
                episode.probability,
            )


def _introduction_id(skill: str) -> str:
    return f"introduction:{skill}"


def episode_id(index: int, skill: str) -> str:
    """Id of a planned exploration, by its place in the list of episodes and its skill."""
    # With the skill, so that an id which outlived a deletion never means another skill's episode.
    return f"episode:{index}:{skill}"


def described(block: Block) -> str:
    """A block in words."""
    who = "by hand" if block.by_hand else "by the schedule"
    skill = plain(block.skill)
    if block.kind == "presence":
        end = "on" if block.until is None else f"until trial {block.until:,}"
        return f"{skill} is among the options from trial {block.first:,} {end}"
    if block.kind == "introduction":
        joins = "never joins" if block.first >= NEVER else f"joins at trial {block.first:,}"
        freeze = f", selection frozen for {block.trials:,} trials" if block.trials else ""
        text = f"{skill} {joins}, {who}{freeze}"
    elif block.kind == "exploration":
        text = f"{skill} is explored in {block.probability:.0%} of the steps, {_span(block)}, {who}"
    else:
        text = f"{FROZEN[block.kind]} frozen by hand, {_span(block)}"
    if block.undone:
        text += " (taken back since)"
    return f"{text} (will not happen as things stand)" if block.state == "idle" else text


def _span(block: Block) -> str:
    if block.last is None:
        return f"trials {block.first:,} on"
    if block.last == block.first:
        return f"trial {block.first:,}"
    return f"trials {block.first:,} to {block.last:,}"
