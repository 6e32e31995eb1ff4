"""What of a run a preset can carry: a schedule that repeats it, and what that cannot repeat."""

import itertools
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from app.live.snapshot import Snapshot
from app.schedule.blocks import FREEZES, NEVER, Block, blocks_of, described
from app.words.plain import named, parameter_name
from learners.commands import Remove, SetParameter
from learners.names import INTRODUCTION, MAX_TRIALS
from learners.parameters import value_of
from learners.schedule_spec import EpisodeSpec, ScheduleSpec, SkillTimer, TeachSpec, WhereSpec
from learners.spec import RunSpec


class Carried(NamedTuple):
    """A schedule that repeats what was done, and what it cannot repeat."""

    schedule: ScheduleSpec
    left_out: tuple[str, ...]
    """Plain sentences, as a list of what will not be repeated has them."""


def schedule_of(snapshot: Snapshot) -> Carried:
    """What was done so far, by hand and by the schedule, and what is still planned.

    Introductions keep the trial in which they happened and their freeze, and those that are to come
    by a rule keep that; explorations keep their start, the duration they really had, their
    probability and where they act. What a schedule has no words for
    is said in sentences: freezes by hand, removals, changes of parameters. Besides, a command
    given in the middle of a trial is given at its start; of several explorations that began in
    one trial the order may change; one that lasted less than a trial is dropped.
    """
    blocks = blocks_of(snapshot)
    former = snapshot.spec.schedule
    skills = {skill: _timer_of(blocks, skill, former) for skill in snapshot.spec.learner.skills}
    schedule = former.model_copy(update={"introduce": None, "skills": skills})
    joins = {skill: schedule.introduced_at(skill) for skill in skills}
    episodes = [e for skill, at in joins.items() for e in _episodes_of(blocks, skill, at)]
    places = {skill: place for place, skill in enumerate(skills)}
    episodes.sort(key=lambda e: (schedule.starts_at(e), places[e.skill]))
    taught = {"episodes": tuple(episodes), "teach": _teach_of(blocks, former)}
    schedule = schedule.model_copy(update=taught)
    return Carried(schedule, tuple(_left_out(snapshot, blocks, skills)))


class CarriedRun(NamedTuple):
    """A preset that repeats what was done, and what it cannot repeat."""

    spec: RunSpec
    left_out: tuple[str, ...]
    """Plain sentences, as a list of what will not be repeated has them."""


def preset_of(snapshot: Snapshot) -> CarriedRun:
    """A run with the schedule of :func:`schedule_of`, as long as this one at least."""
    schedule, left_out = schedule_of(snapshot)
    document = snapshot.spec.model_dump()
    document["schedule"] = schedule.model_dump()
    document["trials"] = min(max(snapshot.spec.trials, snapshot.trial), MAX_TRIALS)
    return CarriedRun(RunSpec.model_validate(document), left_out)


def drawn_schedule(snapshot: Snapshot) -> ScheduleSpec | None:
    """The schedule as it was edited, for the same preset to be started again with.

    What was done by hand is not in it, nor are the plans for skills that the preset does not have:
    they are options of this run alone. None where it is the preset's own.
    """
    own, mine = snapshot.preset_spec.schedule, snapshot.spec.schedule
    skills = snapshot.preset_spec.learner.skills
    drawn = mine.model_copy(
        update={
            "skills": {skill: timer for skill, timer in mine.skills.items() if skill in skills},
            "episodes": tuple(episode for episode in mine.episodes if episode.skill in skills),
        }
    )
    return None if drawn == own else drawn


def _happens(block: Block) -> bool:
    return block.state != "idle"


def _timer_of(blocks: Sequence[Block], skill: str, former: ScheduleSpec) -> SkillTimer:
    """When a skill joined to stay, or will, or by which rule; the end of time if none of these."""
    joins = [
        block
        for block in blocks
        if block.kind == "introduction" and block.skill == skill and _happens(block)
    ]
    kept = [block for block in joins if not block.undone]
    if not kept:
        return SkillTimer(at=NEVER)
    freeze = min(kept[0].trials, MAX_TRIALS)
    if kept[0].first >= NEVER:
        return SkillTimer(introduce=former.rule_of(skill), freeze=freeze)
    return SkillTimer(at=kept[0].first, freeze=freeze)


def _teach_of(blocks: Sequence[Block], former: ScheduleSpec) -> TeachSpec | None:
    """The teaching at the start, for as long as it really was; None if there was none."""
    first = next((block for block in blocks if _is_teaching(block) and block.first == 0), None)
    if first is None or not first.trials:
        return None
    teach = former.teach or TeachSpec(trials=MAX_TRIALS)
    return teach.model_copy(update={"trials": min(first.trials, MAX_TRIALS)})


def _is_teaching(block: Block) -> bool:
    return block.kind == "teaching" and not block.undone


def _episodes_of(blocks: Sequence[Block], skill: str, joins: int) -> list[EpisodeSpec]:
    """Explorations of a skill, none before it joins, each over before the next begins."""
    spans = sorted(
        (block for block in blocks if _is_exploration_of(block, skill)),
        key=lambda block: block.first,
    )
    episodes = []
    for block, following in itertools.zip_longest(spans, spans[1:]):
        first = max(block.first, joins)
        until = block.first + block.trials
        if following is not None:
            until = min(until, following.first)
        if until > first and block.probability is not None:
            episodes.append(
                EpisodeSpec(
                    skill=skill,
                    at=INTRODUCTION if first == joins else first,
                    duration=min(until - first, MAX_TRIALS),
                    probability=block.probability,
                    where=_where(block),
                )
            )
    return episodes


def _where(block: Block) -> WhereSpec | None:
    at_most = block.value_at_most
    return None if at_most is None else WhereSpec(value_at_most=at_most)


def _is_exploration_of(block: Block, skill: str) -> bool:
    return block.kind == "exploration" and block.skill == skill and _happens(block)


def _left_out(
    snapshot: Snapshot, blocks: Sequence[Block], skills: dict[str, SkillTimer]
) -> Iterable[str]:
    for block in blocks:
        if block.kind in FREEZES or (_is_teaching(block) and block.first > 0):
            sentence = described(block)
            yield f"{sentence[:1].upper()}{sentence[1:]}."
        elif block.kind == "introduction" and block.undone:
            yield f"{named(block.skill)} was added at trial {block.first:,}; that was taken back."
    for event in snapshot.control.history:
        if event.undone:
            continue
        match event.command:
            case Remove(skill=skill):
                yield f"{named(skill)} was removed at trial {event.trial:,}: it joins and stays."
            case SetParameter(key=key, value=value):
                yield (
                    f"{parameter_name(key)} was set to {value:g} at trial {event.trial:,}: it is"
                    f" {value_of(snapshot.spec, key):g}, the latest value, from the start."
                )
    for skill, timer in skills.items():
        if timer.at is not None and timer.at >= NEVER:
            yield f"{named(skill)} has not joined and is not planned to: it never joins."
    if not snapshot.control.schedule_on and any(block.state == "idle" for block in blocks):
        yield "What the schedule has ahead: it is not being followed."
