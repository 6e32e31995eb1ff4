"""The schedule as blocks: what lasts from one trial to another; pure functions.

Blocks of what has happened come from the run's history: what holds before and after each event.
Blocks of what is planned come from the schedule. Only the latter can be edited, and only while
they lie ahead.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

from app.live.snapshot import Snapshot
from app.words.plain import plain
from learners.commands import Event, Explore, Introduce, Teach, Undo
from learners.control import Control, Episode, Introduction, evolve
from learners.names import INTRODUCTION, MAX_TRIALS
from learners.schedule_spec import EpisodeSpec, TriggerSpec
from learners.spec import RunSpec
from learners.timers import exploration_of, timers_of

Kind = Literal[
    "presence", "introduction", "exploration", "teaching", "selection_freeze", "skills_freeze"
]
State = Literal["done", "running", "planned", "idle"]
Lane = tuple[Kind, str]
"""Of what there is one at a time: a kind and a skill, which is empty for a freeze by hand and for
teaching."""

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
    """Its lane; empty for a freeze by hand and for teaching."""
    first: int
    """First trial; ``NEVER`` of what comes by a rule, since nobody knows when."""
    until: int | None
    """First trial after it; None if it lasts until somebody ends it."""
    state: State
    """``idle`` is what is in the plan and will not happen as things stand."""
    by_hand: bool = False
    """Whether a person began it, or changed what the preset plans."""
    by_rule: bool = False
    """Whether a rule says when its skill joins, or did."""
    undone: bool = False
    """Whether the command behind it has been taken back since."""
    editable: bool = False
    probability: float | None = None
    """Of an exploration."""
    value_at_most: float | None = None
    """Of an exploration that acts only in states in which no other present skill is worth more."""

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

    What holds before an event and after it says what ends with it and what begins.
    """

    def __init__(self, preset: RunSpec) -> None:
        self.control = Control.at_start(preset)
        """What holds after all that was played."""
        self._blocks: dict[str, Block] = {}
        """By their ids, in the order in which they began."""
        self._sources: dict[str, int] = {}
        """Number of the event whose undoing takes back a block, by its id."""
        self._open: dict[Lane, str] = {}
        """Id of the latest block of each kind and lane that has not been ended."""
        self._frozen_since: dict[str, int] = {}
        """Step in which a freeze by hand began, by its id."""

    @property
    def blocks(self) -> tuple[Block, ...]:
        """What lasted from when to when so far."""
        return tuple(self._blocks.values())

    @property
    def open_ids(self) -> frozenset[str]:
        """Ids of what nobody has ended."""
        return frozenset(self._open.values())

    def play(self, event: Event) -> None:
        """Note what a command did, of which it is not known yet whether it will be undone."""
        event = replace(event, undone=False) if event.undone else event
        before = _lasting(self.control, event.trial)
        self.control = evolve(self.control, event)
        after = _lasting(self.control, event.trial)
        anew = self._begun_anew(event)
        for lane in before:
            if lane in anew or after.get(lane) != before[lane]:
                self._end(lane, event)
        if isinstance(event.command, Undo):
            self._take_back(event, event.command.number)
        if isinstance(event.command, Introduce):
            skill, freeze = event.command.skill, event.command.freeze_trials
            self._begin(event, event, ("introduction", skill), event.trial + freeze)
        for lane, what in after.items():
            if lane in anew or before.get(lane) != what:
                if isinstance(what, Episode):
                    source = self._source_of(what)
                    self._begin(event, source, lane, what.until_trial, what)
                else:
                    self._begin(event, event, lane, self._until(lane))

    def _until(self, lane: Lane) -> int | None:
        """The first trial after what has just begun, where that is known."""
        return self.control.taught_until if lane[0] == "teaching" else None

    def _begun_anew(self, event: Event) -> set[Lane]:
        """Lanes in which something ends and begins with an event, though it may be the same."""
        match event.command:
            case Explore(skill=skill):
                return {("exploration", skill)}
            case Teach():
                return {("teaching", "")}
            case Undo(number=number):
                # What was taken back ends even where another command holds still what it held.
                return {lane for lane, id in self._open.items() if self._sources[id] == number}
        return set()

    def _source_of(self, episode: Episode) -> Event:
        """The event that began an exploration which runs."""
        return next(
            event
            for event in reversed(self.control.history)
            if event.command
            == Explore(
                episode.skill,
                episode.until_trial - event.trial,
                episode.probability,
                episode.value_at_most,
            )
            and not event.undone
        )

    def _begin(
        self,
        event: Event,
        source: Event,
        lane: Lane,
        until: int | None = None,
        episode: Episode | None = None,
    ) -> None:
        kind, skill = lane
        id = f"presence:{event.number}" if kind == "presence" else f"event:{event.number}"
        self._open[lane] = id
        self._sources[id] = source.number
        if kind in FREEZES:
            self._frozen_since[id] = event.step
        self._blocks[id] = Block(
            id=id,
            kind=kind,
            skill=skill,
            first=event.trial,
            until=until,
            state="running",
            by_hand=source.author == "hand" or not self._is_of_preset(source),
            by_rule=source.author == "trigger",
            probability=None if episode is None else episode.probability,
            value_at_most=None if episode is None else episode.value_at_most,
        )

    def _is_of_preset(self, event: Event) -> bool:
        """Whether the preset has what the schedule did: it may have been edited since."""
        preset = self.control.preset
        match event.command:
            case Introduce(skill=skill, freeze_trials=freeze):
                at, rule = event.trial, None
                if event.author == "trigger":
                    at, rule = NEVER, self.control.spec.schedule.rule_of(skill)
                return (at, rule, freeze) == _timer_of(preset, skill)
            case Explore():
                starts = [event.trial] if event.cause is None else [event.trial, INTRODUCTION]
                return any(
                    exploration_of(episode) == event.command and episode.at in starts
                    for episode in preset.schedule.episodes
                )
            case Teach(duration_trials=duration):
                teach = preset.schedule.teach
                return teach is not None and (event.trial, duration) == (0, teach.trials)
        return True

    def _end(self, lane: Lane, event: Event) -> None:
        id = self._open.pop(lane)
        if self._frozen_since.get(id) == event.step:
            # Not a step was made, so nothing was held still.
            del self._blocks[id]
        else:
            self._blocks[id] = replace(self._blocks[id], until=event.trial)

    def _take_back(self, event: Event, number: int) -> None:
        """Mark what an event began, and let the freeze of an introduction end with its undoing."""
        for id, block in self._blocks.items():
            if self._sources[id] == number:
                until = block.until
                if block.kind == "introduction" and until is not None:
                    until = min(until, event.trial)
                self._blocks[id] = replace(block, until=until, undone=True)


class Past:
    """What has happened in a run, kept up with it as its history grows, and kept small."""

    def __init__(self) -> None:
        self._reel: _Reel | None = None
        self._history: tuple[Event, ...] | None = None
        self._kept: tuple[Block, ...] = ()
        self.left_out = 0
        """Blocks that are over and that nobody can tell apart any more among so many."""

    def blocks_of(self, snapshot: Snapshot) -> tuple[Block, ...]:
        """As the function of this name, but of what was done by hand and is over the newest."""
        control, reel = snapshot.control, self._reel
        if reel is None or control.history is not self._history:
            if reel is None or not _goes_on(reel.control, control):
                reel = self._reel = _Reel(control.preset)
            self._play(reel, control.history)
        return (*_as_of(self._kept, snapshot.trial), *_planned(snapshot))

    def _play(self, reel: _Reel, history: tuple[Event, ...]) -> None:
        for event in history[len(reel.control.history) :]:
            reel.play(event)
        self._history = history
        over = [block.id for block in reel.blocks if block.by_hand]
        over = [id for id in over if id not in reel.open_ids]
        lost = set(over[:-MAX_PAST])
        self.left_out = len(lost)
        self._kept = tuple(block for block in reel.blocks if block.id not in lost)


def _lasting(control: Control, trial: int) -> dict[Lane, Introduction | Episode | int]:
    """What lasts in a trial until an event ends it, or its time."""
    frozen = zip(FREEZES, (control.selection_frozen, control.skills_frozen), strict=True)
    return {
        **{("presence", entry.skill): entry for entry in control.introductions},
        **{("exploration", episode.skill): episode for episode in control.running(trial)},
        **({("teaching", ""): control.taught_until} if control.taught_until > trial else {}),
        **{(kind, ""): True for kind, is_frozen in frozen if is_frozen},
    }


def _goes_on(played: Control, control: Control) -> bool:
    """Whether a run has done at first what was played, be it that it undid some of it since."""
    return (
        played.preset is control.preset
        and len(played.history) <= len(control.history)
        and all(
            then is now or replace(then, undone=now.undone) == now
            for then, now in zip(played.history, control.history, strict=False)
        )
    )


def _timer_of(spec: RunSpec, skill: str) -> tuple[int, TriggerSpec | None, int]:
    """Trial in which a preset lets a skill join, the rule by which it does, and the freeze.

    It never joins if the preset has no such option.
    """
    if skill not in spec.learner.skills:
        return NEVER, None, 0
    schedule = spec.schedule
    return schedule.introduced_at(skill), schedule.rule_of(skill), schedule.freeze_of(skill)


def _happened(snapshot: Snapshot) -> tuple[Block, ...]:
    reel = _Reel(snapshot.preset_spec)
    for event in snapshot.control.history:
        reel.play(event)
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
        episode: EpisodeSpec | None = None,
    ) -> Block:
        by_rule = first >= NEVER and schedule.rule_of(skill) is not None
        happens = on and (first < NEVER or by_rule) and (skill in present or skill in joining)
        return Block(
            id=id,
            kind=kind,
            skill=skill,
            first=first,
            until=first + trials,
            state="planned" if happens else "idle",
            by_hand=not is_of_preset,
            by_rule=by_rule,
            editable=first > snapshot.trial,
            probability=None if episode is None else episode.probability,
            value_at_most=None if episode is None else exploration_of(episode).value_at_most,
        )

    for skill in snapshot.spec.learner.skills:
        if skill in joining:
            at, freeze = schedule.introduced_at(skill), schedule.freeze_of(skill)
            kept = (at, schedule.rule_of(skill), freeze) == _timer_of(preset, skill)
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
                episode,
            )


def planned_joins(control: Control) -> dict[str, int]:
    """Trials in which the schedule has skills join that have not, be it followed or not."""
    ahead = timers_of(control.spec)[control.next_timer :]
    return {
        timer.command.skill: timer.trial
        for timer in ahead
        if isinstance(timer.command, Introduce)
        and timer.trial < NEVER
        and timer.command.skill not in control.present
    }


def _introduction_id(skill: str) -> str:
    return f"introduction:{skill}"


def episode_id(index: int, skill: str) -> str:
    """Id of a planned exploration, by its place in the list of episodes and its skill."""
    # With the skill, so that an id which outlived a deletion never means another skill's episode.
    return f"episode:{index}:{skill}"


def described(block: Block) -> str:
    """A block in words."""
    who = "by hand" if block.by_hand else "by the schedule"
    if block.by_rule and block.kind == "introduction":
        who = "by its rule"
    skill = plain(block.skill)
    if block.kind == "presence":
        end = "on" if block.until is None else f"until trial {block.until:,}"
        return f"{skill} can be chosen from trial {block.first:,} {end}"
    if block.kind == "introduction":
        joins = f"joins at trial {block.first:,}"
        if block.first >= NEVER:
            joins = "joins" if block.by_rule else "never joins"
        freeze = f", selection frozen for {block.trials:,} trials" if block.trials else ""
        text = f"{skill} {joins}, {who}{freeze}"
    elif block.kind == "exploration":
        where = ""
        if block.value_at_most is not None:
            where = f" where nothing else is worth more than {block.value_at_most:g}"
        share = f"{block.probability:.0%} of the steps{where}"
        text = f"{skill} is explored in {share}, {_span(block)}, {who}"
    elif block.kind == "teaching":
        text = f"a script chooses the skill, {_span(block)}, {who}"
    else:
        text = f"{FROZEN[block.kind]} frozen by hand, {_span(block)}"
    if block.undone:
        text += " (taken back since)"
    return f"{text} (will not happen as things stand)" if block.state == "idle" else text


def _span(block: Block) -> str:
    if block.by_rule and block.first >= NEVER:
        return f"for {block.trials:,} trials once it joins"
    if block.last is None:
        return f"trials {block.first:,} on"
    if block.last == block.first:
        return f"trial {block.first:,}"
    return f"trials {block.first:,} to {block.last:,}"
