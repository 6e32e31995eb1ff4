"""The schedule as a picture, as edits, and as what a preset can carry: pure functions.

A :class:`Block` is something that lasts from one trial to another. Blocks of what has happened
come from the run's history, which is played through again; blocks of what is planned come from
the schedule. Only the latter can be edited, and only while they lie ahead.
"""

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from html import escape
from typing import Literal, NamedTuple

from app.narrate import plain
from app.pictures import DARK, LIGHT, Theme, css
from app.snapshot import Snapshot
from learners.commands import (
    Explore,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Remove,
    SetParameter,
    StopExploring,
    Undo,
)
from learners.run import Event, timers_of
from learners.spec import (
    INTRODUCTION,
    MAX_TRIALS,
    EpisodeSpec,
    RunSpec,
    ScheduleSpec,
    SkillTimer,
)

# --- Blocks --------------------------------------------------------------------------------------

Kind = Literal["presence", "introduction", "exploration", "selection_freeze", "skills_freeze"]
State = Literal["done", "running", "planned", "idle"]

FREEZES: tuple[Kind, Kind] = ("selection_freeze", "skills_freeze")
"""Kinds that only a person begins; they share the last lane."""

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

    def __init__(self) -> None:
        self.blocks: list[Block] = []
        self._open: dict[tuple[Kind, str], int] = {}
        """Place of the latest block of each kind and lane that has not been ended."""
        self._former: dict[int, Block | bool | None] = {}
        """What undoing a command brings back, by the number of its event."""

    def play(self, event: Event, history: Sequence[Event]) -> None:
        """Note what a command did."""
        match event.command:
            case Introduce(skill=skill, freeze_trials=freeze):
                self._begin(event, "introduction", skill, freeze)
                self._begin(event, "presence", skill, None)
            case Explore(skill=skill, duration_trials=duration, probability=probability):
                self._end("exploration", skill, event.trial)
                self._begin(event, "exploration", skill, duration, probability)
            case StopExploring(skill=skill):
                self._former[event.number] = self._end("exploration", skill, event.trial)
            case Remove(skill=skill):
                self._remove(skill, event.trial)
            case FreezeSelection(frozen=frozen):
                self._freeze(event, "selection_freeze", frozen)
            case FreezeSkills(frozen=frozen):
                self._freeze(event, "skills_freeze", frozen)
            case Undo(number=number):
                self._undo(event, history[number])

    def _undo(self, event: Event, undone: Event) -> None:
        former = self._former.get(undone.number)
        match undone.command:
            case Introduce(skill=skill):
                self._remove(skill, event.trial)
            case Explore(skill=skill):
                self._end("exploration", skill, event.trial)
            case StopExploring(skill=skill) if isinstance(former, Block):
                self._end("exploration", skill, event.trial)
                rest = replace(former, id=f"event:{event.number}", first=event.trial)
                self._add(rest)
            case Remove(skill=skill):
                self._begin(event, "presence", skill, None)
            case FreezeSelection():
                self._freeze(event, "selection_freeze", bool(former))
            case FreezeSkills():
                self._freeze(event, "skills_freeze", bool(former))

    def _begin(
        self,
        event: Event,
        kind: Kind,
        skill: str,
        trials: int | None,
        probability: float | None = None,
    ) -> None:
        prefix = "presence" if kind == "presence" else "event"
        self._add(
            Block(
                id=f"{prefix}:{event.number}",
                kind=kind,
                skill=skill,
                first=event.trial,
                until=None if trials is None else event.trial + trials,
                state="running",
                by_hand=event.by_hand,
                undone=event.undone,
                probability=probability,
            )
        )

    def _add(self, block: Block) -> None:
        self._open[block.kind, block.skill] = len(self.blocks)
        self.blocks.append(block)

    def _end(self, kind: Kind, skill: str, trial: int) -> Block | None:
        """End what is open in a lane; returns it as it was, None if there is nothing to end."""
        place = self._open.pop((kind, skill), None)
        if place is None:
            return None
        block = self.blocks[place]
        if block.until is not None and block.until <= trial:
            return None
        self.blocks[place] = replace(block, until=trial)
        return block

    def _remove(self, skill: str, trial: int) -> None:
        # The freeze of an introduction goes on when its skill leaves.
        self._end("exploration", skill, trial)
        self._end("presence", skill, trial)

    def _freeze(self, event: Event, kind: Kind, frozen: bool) -> None:
        was_frozen = (kind, "") in self._open
        self._former[event.number] = was_frozen
        if frozen and not was_frozen:
            self._begin(event, kind, "", None)
        elif was_frozen and not frozen:
            self._end(kind, "", event.trial)


def _happened(snapshot: Snapshot) -> tuple[Block, ...]:
    history = snapshot.control.history
    reel = _Reel()
    for event in history:
        reel.play(event, history)
    return tuple(
        block
        if block.until is None or block.until > snapshot.trial
        else replace(block, state="done")
        for block in reel.blocks
    )


def _planned(snapshot: Snapshot) -> Iterable[Block]:
    """What the schedule still has ahead, by skill and then by its list of episodes."""
    schedule, present = snapshot.spec.schedule, snapshot.present
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
        id: str, kind: Kind, skill: str, first: int, trials: int, probability: float | None
    ) -> Block:
        happens = on and first < NEVER and (skill in present or skill in joining)
        return Block(
            id=id,
            kind=kind,
            skill=skill,
            first=first,
            until=first + trials,
            state="planned" if happens else "idle",
            editable=first > snapshot.trial,
            probability=probability,
        )

    for skill in snapshot.spec.learner.skills:
        if skill in joining:
            at, freeze = schedule.introduced_at(skill), schedule.freeze_of(skill)
            yield block(_introduction_id(skill), "introduction", skill, at, freeze, None)
    for index, episode in enumerate(schedule.episodes):
        skill, first = episode.skill, schedule.starts_at(episode)
        bound = episode.at == INTRODUCTION
        if (skill in joining) if bound else ((first, skill) in exploring):
            name = _episode_id(index, skill)
            yield block(name, "exploration", skill, first, episode.duration, episode.probability)


def _introduction_id(skill: str) -> str:
    return f"introduction:{skill}"


def _episode_id(index: int, skill: str) -> str:
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
        text = (
            f"{skill} is explored in {block.probability:.0%} of the steps,"
            f" trials {block.first:,} to {block.last:,}, {who}"
        )
    else:
        end = "on" if block.last is None else f"to {block.last:,}"
        text = f"{_FROZEN[block.kind]} frozen by hand, trials {block.first:,} {end}"
    if block.undone:
        text += " (taken back since)"
    return f"{text} (will not happen as things stand)" if block.state == "idle" else text


# --- Edits ---------------------------------------------------------------------------------------


class Now(NamedTuple):
    """What an edit must know of the run that it is made for."""

    trial: int
    """The running trial: whatever starts in it or before it is past, and locked."""
    present: tuple[str, ...]
    """Skills that have joined, be it by hand or by their timers."""


def now_of(snapshot: Snapshot) -> Now:
    """The moment at which edits of a run's schedule are made."""
    return Now(snapshot.trial, snapshot.present)


def moved(schedule: ScheduleSpec, block_id: str, by_trials: int, now: Now) -> ScheduleSpec:
    """Let a block start earlier or later, as far as is allowed.

    Explorations that start with an introduction move with it. Raises ValueError: see
    :func:`changed`.
    """
    at = _start_of(schedule, block_id)
    after = changed(schedule, block_id, now, at=at + by_trials)
    if by_trials and after == schedule:
        edge = "later" if by_trials > 0 else "earlier"
        raise ValueError(f"It cannot start any {edge} than trial {at:,}.")
    return after


def changed(
    schedule: ScheduleSpec,
    block_id: str,
    now: Now,
    *,
    at: int | None = None,
    trials: int | None = None,
    probability: float | None = None,
) -> ScheduleSpec:
    """Change a block's start, length and probability at once; what is None stays.

    Numbers out of range become the nearest allowed one.

    Raises:
        ValueError: there is no such block, it is past, an introduction was given a probability,
            or an exploration would overlap another of its skill or start before that joins.
    """
    _check_ahead(schedule, block_id, now)
    kind, skill, index = _parts(block_id)
    if kind == "episode":
        after = _changed_episode(schedule, index, now, at, trials, probability)
    elif probability is not None:
        raise ValueError("An introduction has no probability; its explorations have.")
    else:
        timer = schedule.skills[skill]
        new = SkillTimer(
            at=timer.at if at is None else _clamped(at, now.trial + 1, MAX_TRIALS),
            freeze=timer.freeze if trials is None else _clamped(trials, 0, MAX_TRIALS),
        )
        after = schedule.model_copy(update={"skills": {**schedule.skills, skill: new}})
    return _fitting(after, skill, now)


def without(schedule: ScheduleSpec, block_id: str, now: Now) -> ScheduleSpec:
    """Take an exploration out of the plan.

    Raises:
        ValueError: there is no such exploration, it is past, or it is an introduction: a skill
            without a timer is present from the start, which cannot be had any more.
    """
    kind, _, index = _parts(block_id)
    if kind == "introduction":
        raise ValueError("An introduction cannot be deleted; it can be moved past the last trial.")
    _check_ahead(schedule, block_id, now)
    episodes = schedule.episodes
    return schedule.model_copy(update={"episodes": (*episodes[:index], *episodes[index + 1 :])})


def with_episode(
    schedule: ScheduleSpec, skill: str, at: int, duration: int, probability: float, now: Now
) -> ScheduleSpec:
    """Plan an exploration; it comes last in the list. Numbers become the nearest allowed ones.

    Raises:
        ValueError: it would overlap another of the skill, or the skill is not there then.
    """
    joins = schedule.introduced_at(skill)
    if skill not in now.present and (joins <= now.trial or joins >= NEVER):
        raise ValueError(
            f"{_named(skill)} is not among the options and will not join;"
            " add it or plan when it joins first."
        )
    earliest = now.trial + 1 if skill in now.present else joins
    new = EpisodeSpec(
        skill=skill,
        at=_bound_start(schedule, skill, _clamped(at, earliest, MAX_TRIALS), now),
        duration=_clamped(duration, 1, MAX_TRIALS),
        probability=_probability(probability),
    )
    after = schedule.model_copy(update={"episodes": (*schedule.episodes, new)})
    return _fitting(after, skill, now)


def newest_episode_id(schedule: ScheduleSpec) -> str:
    """Id of the exploration that :func:`with_episode` has just planned."""
    return _episode_id(len(schedule.episodes) - 1, schedule.episodes[-1].skill)


def _parts(block_id: str) -> tuple[str, str, int]:
    """Kind, skill and place in the list of a block that can be edited."""
    kind, _, rest = block_id.partition(":")
    if kind == "introduction":
        return kind, rest, 0
    index, _, skill = rest.partition(":")
    if kind == "episode" and index.isdecimal():
        return kind, skill, int(index)
    raise ValueError("What has happened cannot be changed.")


def _start_of(schedule: ScheduleSpec, block_id: str) -> int:
    kind, skill, index = _parts(block_id)
    if kind == "introduction" and skill in schedule.skills:
        return schedule.introduced_at(skill)
    episodes = schedule.episodes
    if kind == "episode" and index < len(episodes) and episodes[index].skill == skill:
        return schedule.starts_at(episodes[index])
    raise ValueError("That is not in the schedule any more.")


def _check_ahead(schedule: ScheduleSpec, block_id: str, now: Now) -> None:
    first = _start_of(schedule, block_id)
    if first <= now.trial:
        raise ValueError(f"Trial {first:,} is past, so what starts there cannot be changed.")


def _clamped(number: int, low: int, high: int) -> int:
    return min(max(int(number), low), high)


def _probability(number: float) -> float:
    if math.isnan(number):
        raise ValueError("A probability is a number from 0 to 1.")
    return min(max(float(number), 0.0), 1.0)


def _named(skill: str) -> str:
    name = plain(skill)
    return name[:1].upper() + name[1:]


def _bound_start(
    schedule: ScheduleSpec, skill: str, at: int, now: Now
) -> int | Literal["introduction"]:
    """Start of an episode; one that starts when its skill joins stays with that."""
    joins = schedule.introduced_at(skill)
    return INTRODUCTION if at == joins and skill not in now.present else at


def _changed_episode(
    schedule: ScheduleSpec,
    index: int,
    now: Now,
    at: int | None,
    trials: int | None,
    probability: float | None,
) -> ScheduleSpec:
    former = schedule.episodes[index]
    start = former.at
    if at is not None:
        joins = 0 if former.skill in now.present else schedule.introduced_at(former.skill)
        start = _clamped(at, max(now.trial + 1, joins), MAX_TRIALS)
        start = _bound_start(schedule, former.skill, start, now)
    new = EpisodeSpec(
        skill=former.skill,
        at=start,
        duration=former.duration if trials is None else _clamped(trials, 1, MAX_TRIALS),
        probability=former.probability if probability is None else _probability(probability),
    )
    episodes = schedule.episodes
    return schedule.model_copy(
        update={"episodes": (*episodes[:index], new, *episodes[index + 1 :])}
    )


def _fitting(schedule: ScheduleSpec, skill: str, now: Now) -> ScheduleSpec:
    """A schedule after an edit of a skill's blocks, if these go together."""
    if skill in now.present:
        schedule = _with_timer_out_of_the_way(schedule, skill, now)
    joins = schedule.introduced_at(skill)
    spans = sorted(
        (schedule.starts_at(e), schedule.starts_at(e) + e.duration)
        for e in schedule.episodes
        if e.skill == skill
    )
    for first, _ in spans:
        if first < joins:
            raise ValueError(
                f"{_named(skill)} is to be explored at trial {first:,}, so it cannot join at"
                f" {joins:,}. Move or delete that exploration first."
            )
    for (first, until), (later, _) in itertools.pairwise(spans):
        if later < until:
            raise ValueError(
                f"Explorations of {plain(skill)} would overlap: one from trial {first:,} to"
                f" {until:,}, the other from {later:,}."
            )
    return schedule


def _with_timer_out_of_the_way(schedule: ScheduleSpec, skill: str, now: Now) -> ScheduleSpec:
    """Let a skill that was added by hand be explored before its timer.

    Its timer has nothing left to do, but a schedule in which a skill is explored before it joins
    is not valid. So the timer comes forward to the first exploration ahead, and what was to start
    with it, and did start when the skill was added, goes.
    """
    timer = schedule.skills.get(skill)
    starts = [e.at for e in schedule.episodes if e.skill == skill and isinstance(e.at, int)]
    first = min((at for at in starts if at > now.trial), default=NEVER)
    if timer is None or timer.at <= first:
        return schedule
    kept = [e for e in schedule.episodes if e.skill != skill or e.at != INTRODUCTION]
    skills = {**schedule.skills, skill: SkillTimer(at=first, freeze=timer.freeze)}
    return schedule.model_copy(update={"skills": skills, "episodes": tuple(kept)})


# --- What a preset can carry ---------------------------------------------------------------------


class Carried(NamedTuple):
    """A schedule that repeats what was done, and what it cannot repeat."""

    schedule: ScheduleSpec
    left_out: tuple[str, ...]
    """Plain sentences."""


def schedule_of(snapshot: Snapshot) -> Carried:
    """What was done so far, by hand and by the schedule, and what is still planned.

    Introductions keep the trial in which they happened and their freeze; explorations keep their
    start, the duration they really had, and their probability. What a schedule has no words for
    is said in sentences: freezes by hand, removals, changes of parameters. Besides, a command
    given in the middle of a trial is given at its start; of several explorations that began in
    one trial the order may change; one that lasted less than a trial is dropped.
    """
    blocks = blocks_of(snapshot)
    skills = {skill: _timer_of(blocks, skill) for skill in snapshot.spec.learner.skills}
    episodes = [e for skill, timer in skills.items() for e in _episodes_of(blocks, skill, timer)]
    places = {skill: place for place, skill in enumerate(skills)}
    episodes.sort(
        key=lambda e: (skills[e.skill].at if e.at == INTRODUCTION else e.at, places[e.skill])
    )
    schedule = ScheduleSpec(
        safe_introduction=snapshot.spec.schedule.safe_introduction,
        skills=skills,
        episodes=tuple(episodes),
    )
    return Carried(schedule, tuple(_left_out(snapshot, blocks, skills)))


class CarriedRun(NamedTuple):
    """A preset that repeats what was done, and what it cannot repeat."""

    spec: RunSpec
    left_out: tuple[str, ...]
    """Plain sentences."""


def preset_of(snapshot: Snapshot) -> CarriedRun:
    """A run with the schedule of :func:`schedule_of`, as long as this one at least."""
    schedule, left_out = schedule_of(snapshot)
    document = snapshot.spec.model_dump()
    document["schedule"] = schedule.model_dump()
    document["trials"] = min(max(snapshot.spec.trials, snapshot.trial), MAX_TRIALS)
    return CarriedRun(RunSpec.model_validate(document), left_out)


def _happens(block: Block) -> bool:
    return block.state != "idle"


def _timer_of(blocks: Sequence[Block], skill: str) -> SkillTimer:
    """When a skill joined to stay, or will; the end of time if neither."""
    joins = [
        block
        for block in blocks
        if block.kind == "introduction" and block.skill == skill and _happens(block)
    ]
    kept = [block for block in joins if not block.undone]
    if not kept:
        return SkillTimer(at=NEVER)
    return SkillTimer(at=kept[0].first, freeze=min(kept[0].trials, MAX_TRIALS))


def _episodes_of(blocks: Sequence[Block], skill: str, timer: SkillTimer) -> list[EpisodeSpec]:
    """Explorations of a skill, none before it joins, each over before the next begins."""
    spans = sorted(
        (block for block in blocks if _is_exploration_of(block, skill) and block.first < NEVER),
        key=lambda block: block.first,
    )
    episodes = []
    for block, following in itertools.zip_longest(spans, spans[1:]):
        first = max(block.first, timer.at)
        until = block.first + block.trials
        if following is not None:
            until = min(until, following.first)
        if until > first and block.probability is not None:
            episodes.append(
                EpisodeSpec(
                    skill=skill,
                    at=INTRODUCTION if first == timer.at else first,
                    duration=min(until - first, MAX_TRIALS),
                    probability=block.probability,
                )
            )
    return episodes


def _is_exploration_of(block: Block, skill: str) -> bool:
    return block.kind == "exploration" and block.skill == skill and _happens(block)


def _left_out(
    snapshot: Snapshot, blocks: Sequence[Block], skills: dict[str, SkillTimer]
) -> Iterable[str]:
    for block in blocks:
        if block.kind in FREEZES:
            sentence = described(block)
            yield f"{sentence[:1].upper()}{sentence[1:]}: a preset cannot say so."
        elif block.kind == "introduction" and block.undone:
            yield (
                f"{_named(block.skill)} was added at trial {block.first:,}, which was taken back:"
                " the preset does not add it there."
            )
    for event in snapshot.control.history:
        match event.command:
            case Remove(skill=skill):
                yield (
                    f"{_named(skill)} was removed at trial {event.trial:,}:"
                    " in the preset it stays from when it first joins."
                )
            case SetParameter(key=key, value=value):
                yield (
                    f"{key} was set to {value:g} at trial {event.trial:,}: the preset has its"
                    f" latest value, {_parameter(snapshot.spec, key):g}, from the start."
                )
    for skill, timer in skills.items():
        if timer.at == NEVER:
            yield f"{_named(skill)} has not joined and is not going to: nor does it in the preset."
    if not snapshot.control.schedule_on and any(block.state == "idle" for block in blocks):
        yield "The schedule is not being followed, so what it has ahead is left out."


def _parameter(spec: RunSpec, key: str) -> float:
    section, name = key.split(".")
    return float(getattr(getattr(spec, section), name))


# --- The picture ---------------------------------------------------------------------------------

_FONT_PX = 12
_CHARACTER_PX = 6.6
"""Width of a character of the labels, on the safe side."""
_TOP_PX, _AXIS_PX = 17, 17
"""Height of the caption above the lanes, and of the numbers below them."""
_LANE_PX, _LOW_LANE_PX = 17, 15
_MANY_LANES = 6
"""With more lanes than this each is lower."""
_LARGEST_GUTTER = 0.26
"""Share of the width that the names of the lanes may take."""
_RIGHT = 0.985
"""Where the trials end, as a share of the width."""

_ROLES = {
    "ink": "ink",
    "page": "unknown",
    "line": "lines",
    "explore": "capture",
    "freeze": "field",
    "hand": "predator",
    "now": "ink",
    "idle": "timeout",
}
"""What the colours of a theme are used for here."""


def _solid(colour: str) -> str:
    return f'fill="{colour}" fill-opacity="0.85"'


def _dashed(colour: str) -> str:
    return (
        f'fill="{colour}" fill-opacity="0.12" stroke="{colour}" stroke-width="1.5"'
        ' stroke-dasharray="4 2.5"'
    )


_DOTTED = 'stroke-width="1.5" stroke-dasharray="2 4"'
"""Lines of skills that are to stay."""
_BOX = "M0 0H12V9H0Z"
_NOTCH = "M0 0H9L0 9Z"
_LEGEND = (
    ("by hand", _NOTCH, 'fill="var(--hand)"'),
    ("frozen", _BOX, _solid("var(--freeze)")),
    ("planned", _BOX, _dashed("var(--explore)")),
    ("explored", _BOX, _solid("var(--explore)")),
)
"""Text, shape and style of each swatch, the last one first."""
_FROZEN: dict[Kind, str] = {"selection_freeze": "selection", "skills_freeze": "skills"}


def ticks(end: int, most: int = 8) -> tuple[int, ...]:
    """Round trials from 0 to an end, at most so many after 0."""
    rough = max(end, 1) / most
    power = 10 ** max(math.ceil(math.log10(rough)) - 1, 0)
    width = next(power * k for k in (1, 2, 5, 10) if power * k >= rough)
    return tuple(range(0, max(end, 1) + 1, width))


def tick_label(trial: int) -> str:
    """A round trial, short enough for the axis."""
    if trial >= 1_000_000:
        return f"{trial / 1e6:g} M"
    return f"{trial / 1e3:g} k" if trial >= 100_000 else f"{trial:,}"


def axis_end(snapshot: Snapshot) -> int:
    """Last trial on the timeline: the run's last, or, once it goes on, that of the next stretch."""
    trials = snapshot.spec.trials
    return trials * max(math.ceil(snapshot.trial / trials), 1)


def timeline_svg(
    blocks: Sequence[Block],
    snapshot: Snapshot,
    theme: Theme | None,
    width: float,
    chosen: str = "",
    caption: str = "",
) -> str:
    """The timeline as one SVG element.

    Places along the trials are shares of the width, so that the picture fills whatever it is put
    into and its texts stay as large as they are.

    Args:
        blocks: what to draw, from :func:`blocks_of`.
        snapshot: the moment.
        theme: colours; None to take those that fit the page that it is shown in.
        width: pixels that there are at least, by which labels are judged to fit.
        chosen: id of the block that is highlighted.
        caption: a line of text above it.
    """
    picture = _Picture(snapshot, width)
    for block in blocks:
        if block.kind == "presence":
            picture.add_presence(block)
    for block in blocks:
        if block.kind == "introduction":
            picture.add_join_line(block)
    for kind in ("exploration", "introduction", *FREEZES):
        for block in blocks:
            if block.kind == kind:
                picture.add_block(block, chosen=block.id == chosen)
    picture.add_playhead()
    picture.add_labels(blocks)
    return picture.svg(theme, caption)


def _share(number: float) -> str:
    return f"{100 * number:.3f}%"


def _safe(text: str) -> str:
    """A text as XML may hold it."""
    printable = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
    return escape(printable)


def _shortened(text: str, characters: int) -> str:
    return text if len(text) <= characters else text[: max(characters - 1, 1)] + "…"


def _colours(theme: Theme) -> str:
    return ";".join(f"--{role}:{css(getattr(theme, name))}" for role, name in _ROLES.items())


_PAGE_STYLE = (
    f"<style>.pounce-timeline{{{_colours(LIGHT)}}}"
    f'[data-mantine-color-scheme="dark"] .pounce-timeline{{{_colours(DARK)}}}</style>'
)
"""Colours that follow the page: each browser has its own theme, and all are sent one picture."""


class _Picture:
    """Collects the elements of a timeline."""

    def __init__(self, snapshot: Snapshot, width: float) -> None:
        self._snapshot = snapshot
        self._width = width
        self._end = axis_end(snapshot)
        self._skills = snapshot.spec.learner.skills
        names = [plain(skill) for skill in self._skills] + ["frozen by hand"]
        wanted = (max(map(len, names)) * _CHARACTER_PX + 14) / width
        self._left = min(wanted, _LARGEST_GUTTER)
        self._lane = _LANE_PX if len(names) <= _MANY_LANES else _LOW_LANE_PX
        self._bottom = _TOP_PX + self._lane * len(names)
        self._parts: list[str] = []
        self._add_lanes(names)
        self._add_axis()

    @property
    def _lane_characters(self) -> int:
        return int((self._left * self._width - 12) / _CHARACTER_PX)

    def _x(self, trial: float) -> float:
        """Place of a trial, as a share of the width."""
        along = min(max(trial / self._end, 0.0), 1.0)
        return self._left + along * (_RIGHT - self._left)

    def _px(self, share: float) -> float:
        return share * self._width

    def _lane_top(self, skill: str) -> int:
        """Top of a skill's lane; that of freezes by hand has no skill and comes last."""
        lanes = [*self._skills, ""]
        return _TOP_PX + self._lane * lanes.index(skill)

    def _body(self, block: Block) -> tuple[float, float]:
        """Top and height of what is drawn for a block."""
        top, lane = self._lane_top(block.skill), self._lane
        if block.kind == "introduction":
            return top + 2, lane * 0.3
        if block.kind == "selection_freeze":
            return top + 2, (lane - 5) / 2
        if block.kind == "skills_freeze":
            return top + 3 + (lane - 5) / 2, (lane - 5) / 2
        return top + 2, lane - 4

    def _add_lanes(self, names: Sequence[str]) -> None:
        for place, name in enumerate(names):
            top = _TOP_PX + place * self._lane
            middle = top + self._lane / 2
            self._parts.append(
                f'<line x1="0" x2="{_share(_RIGHT)}" y1="{top}" y2="{top}" stroke="var(--line)"/>'
                f'<text x="4" y="{middle:g}" dominant-baseline="central">'
                f"<title>{_safe(name)}</title>"
                f"{_safe(_shortened(name, self._lane_characters))}</text>"
            )

    def _add_axis(self) -> None:
        bottom = self._bottom
        self._parts.append(
            f'<line x1="{_share(self._left)}" x2="{_share(_RIGHT)}" y1="{bottom}" y2="{bottom}"'
            ' stroke="var(--ink)"/>'
            f'<text x="4" y="{bottom + 13}" opacity="0.75">trial</text>'
        )
        here = self._x(self._snapshot.trial)
        for tick in ticks(self._end):
            at = self._x(tick)
            self._parts.append(
                f'<line x1="{_share(at)}" x2="{_share(at)}" y1="{_TOP_PX}" y2="{bottom + 3}"'
                ' stroke="var(--line)"/>'
            )
            # The playhead's own number takes the place of those that it would cover.
            if self._px(abs(at - here)) > 58:
                anchor = "end" if at > 0.95 else "middle"
                self._parts.append(
                    f'<text x="{_share(at)}" y="{bottom + 14}" text-anchor="{anchor}"'
                    f' opacity="0.75">{tick_label(tick)}</text>'
                )

    def add_presence(self, block: Block) -> None:
        """Draw that a skill is among the options, as a line through its lane."""
        middle = self._lane_top(block.skill) + self._lane / 2
        until = self._snapshot.trial if block.until is None else block.until
        self._line(self._x(block.first), self._x(until), middle, 'stroke-width="2"', 0.45)
        if block.until is None:
            self._line(self._x(until), _RIGHT, middle, _DOTTED, 0.4)

    def _line(self, x1: float, x2: float, y: float, style: str, opacity: float) -> None:
        self._parts.append(
            f'<line x1="{_share(x1)}" x2="{_share(x2)}" y1="{y:g}" y2="{y:g}" stroke="var(--ink)"'
            f' opacity="{opacity:g}" {style}/>'
        )

    def add_join_line(self, block: Block) -> None:
        """Mark where a skill joins, across its lane; and that it is to stay, if that is ahead."""
        if block.first > self._end:
            return
        top, at = self._lane_top(block.skill), self._x(block.first)
        ahead = block.state in ("planned", "idle")
        if block.state == "planned":
            self._line(at, _RIGHT, top + self._lane / 2, _DOTTED, 0.4)
        self._parts.append(
            f'<line x1="{_share(at)}" x2="{_share(at)}" y1="{top + 1}" y2="{top + self._lane - 1}"'
            f' stroke="var(--{self._role(block)})" stroke-width="{1.5 if ahead else 2.5}"'
            + (' stroke-dasharray="3 2"/>' if ahead else "/>")
        )

    @staticmethod
    def _role(block: Block) -> str:
        if block.state == "idle":
            return "idle"
        return "explore" if block.kind == "exploration" else "freeze"

    def add_block(self, block: Block, chosen: bool) -> None:
        """Draw a block: solid as far as it has come, dashed from there on."""
        if block.first > self._end:
            return
        now = self._snapshot.trial
        until = now if block.until is None else block.until
        begun = block.state in ("done", "running")
        self._parts.append(f"<g><title>{_safe(described(block))}</title>")
        if begun:
            self._rect(block, block.first, min(until, max(now, block.first)), solid=True)
        if until > now or not begun:
            self._rect(
                block, block.first if not begun else max(now, block.first), until, solid=False
            )
        if block.by_hand:
            self._notch(block)
        if chosen:
            self._halo(block, until)
        self._parts.append("</g>")

    def _rect(self, block: Block, first: float, until: float, solid: bool) -> None:
        top, height = self._body(block)
        colour = f"var(--{self._role(block)})"
        style = _solid(colour) if solid else _dashed(colour)
        least = 3 if block.kind == "introduction" and block.trials == 0 else 2
        self._parts.append(
            f'<rect x="{_share(self._x(first))}" y="{top:g}" height="{height:g}"'
            f' style="width:max({least}px,{_share(self._x(until) - self._x(first))})" {style}/>'
        )

    def _notch(self, block: Block) -> None:
        top, _ = self._body(block)
        self._parts.append(
            f'<svg x="{_share(self._x(block.first))}" y="{top:g}" overflow="visible">'
            f'<path d="{_NOTCH}" fill="var(--hand)"/></svg>'
        )

    def _halo(self, block: Block, until: float) -> None:
        top, lane = self._lane_top(block.skill), self._lane
        wide = _share(self._x(until) - self._x(block.first))
        self._parts.append(
            f'<rect x="{_share(self._x(block.first))}" y="{top + 0.5:g}" height="{lane - 1}"'
            f' style="width:max(7px,{wide})" fill="none" stroke="var(--ink)" stroke-width="2.5"'
            ' rx="2" class="chosen"/>'
        )

    def add_labels(self, blocks: Sequence[Block]) -> None:
        """Write on the lanes where there is room."""
        for skill in self._skills:
            mine = [b for b in blocks if b.skill == skill and b.kind != "presence"]
            for block in mine:
                if block.first > self._end:
                    self._label_beyond(block)
                elif block.kind == "exploration":
                    self._label_exploration(block, mine)
                elif block.kind == "introduction":
                    self._label_introduction(block, mine)
        self._label_freezes([block for block in blocks if block.kind in FREEZES])

    def _text(
        self, skill: str, share: float, text: str, anchor: str = "start", dx: float = 0.0
    ) -> None:
        """Write on a lane; with a rim, so that lines below do not make it hard to read."""
        middle = self._lane_top(skill) + self._lane / 2
        self._parts.append(
            f'<text x="{_share(share)}" dx="{dx:g}" y="{middle:g}" dominant-baseline="central"'
            f' text-anchor="{anchor}" font-size="11" stroke="var(--page)" stroke-width="3"'
            f' paint-order="stroke" pointer-events="none">{_safe(text)}</text>'
        )

    def _label_beyond(self, block: Block) -> None:
        if block.kind == "introduction":
            never = block.first >= NEVER
            text = "not planned to join" if never else f"joins at {block.first:,} ▸"
            self._text(block.skill, _RIGHT, text, "end", -4)

    def _label_exploration(self, block: Block, mine: Sequence[Block]) -> None:
        text = f"{block.probability:.0%}"
        first, until = self._x(block.first), self._x(block.first + block.trials)
        needed = len(text) * _CHARACTER_PX + 8
        if self._px(until - first) >= needed:
            self._text(block.skill, (first + until) / 2, text, "middle")
        elif self._px(self._room_after(until, block.first, mine)) >= needed:
            self._text(block.skill, until, text, "start", 5)

    def _label_introduction(self, block: Block, mine: Sequence[Block]) -> None:
        joins = "joins" if block.state in ("planned", "idle") else "joined"
        text = f"{joins} at {block.first:,}"
        at = self._x(block.first)
        ends = [self._x(b.first + b.trials) for b in mine if b.first < block.first]
        # What is written after the block before it takes some room, too.
        taken = 40 if ends else 0
        if self._px(at - max(ends, default=self._left)) >= len(text) * _CHARACTER_PX + 8 + taken:
            self._text(block.skill, at, text, "end", -6)

    def _label_freezes(self, freezes: Sequence[Block]) -> None:
        """Say of each stretch of freezes by hand what was frozen in it."""
        stretches: list[list[Block]] = []
        for block in sorted(freezes, key=lambda block: block.first):
            if stretches and block.first <= self._end_of(stretches[-1]):
                stretches[-1].append(block)
            else:
                stretches.append([block])
        for stretch in stretches:
            kinds = {block.kind for block in stretch}
            text = " and ".join(_FROZEN[kind] for kind in FREEZES if kind in kinds)
            at = self._x(self._end_of(stretch))
            free = self._room_after(at, stretch[-1].first, freezes)
            if self._px(free) >= len(text) * _CHARACTER_PX + 8:
                self._text("", at, text, "start", 6)

    def _end_of(self, blocks: Iterable[Block]) -> int:
        now = self._snapshot.trial
        return max(now if block.until is None else block.until for block in blocks)

    def _room_after(self, share: float, first: int, others: Iterable[Block]) -> float:
        """Room from a place to where the next block of the lane begins, or the trials end."""
        nexts = [self._x(block.first) for block in others if block.first > first]
        return min(nexts, default=_RIGHT) - share

    def add_playhead(self) -> None:
        """Draw where the run is."""
        at = self._x(self._snapshot.trial)
        anchor = "end" if at > 0.93 else "middle"
        self._parts.append(
            f'<line x1="{_share(at)}" x2="{_share(at)}" y1="{_TOP_PX}" y2="{self._bottom + 3}"'
            ' stroke="var(--now)" stroke-width="2" class="playhead"/>'
            f'<svg x="{_share(at)}" y="{_TOP_PX}" overflow="visible">'
            '<path d="M-5 0H5L0 7Z" fill="var(--now)"/></svg>'
            f'<text x="{_share(at)}" y="{self._bottom + 14}" text-anchor="{anchor}"'
            f' font-weight="700">{self._snapshot.trial:,}</text>'
        )

    def _legend(self) -> str:
        """Swatches, from the right edge inwards."""
        x, parts = 0.0, []
        for text, path, style in _LEGEND:
            x -= len(text) * 6.2 + 28
            parts.append(
                f'<path transform="translate({x:g} 3)" d="{path}" {style}/>'
                f'<text x="{x + 16:g}" y="12">{text}</text>'
            )
        return f'<svg x="{_share(_RIGHT)}" overflow="visible" font-size="11">{"".join(parts)}</svg>'

    def svg(self, theme: Theme | None, caption: str) -> str:
        """The whole picture."""
        height = self._bottom + _AXIS_PX
        colours = "" if theme is None else _colours(theme)
        characters = int((self._width - 300) / _CHARACTER_PX)
        title = f"<title>{_safe(caption)}</title>" if len(caption) > characters else ""
        return (
            '<svg xmlns="http://www.w3.org/2000/svg" class="pounce-timeline" role="img"'
            f' aria-label="Timeline of the schedule" width="100%" height="{height}"'
            f' font-size="{_FONT_PX}" font-family="system-ui, sans-serif" fill="var(--ink)"'
            f' style="display:block;{colours}">'
            f"{_PAGE_STYLE if theme is None else ''}"
            f'<text x="4" y="12">{title}{_safe(_shortened(caption, characters))}</text>'
            f"{self._legend()}{''.join(self._parts)}</svg>"
        )
