"""Edits of what a schedule has ahead: each makes another schedule, or says why it cannot."""

import itertools
import math
from typing import Literal, NamedTuple

from app.live.snapshot import Snapshot
from app.schedule.blocks import NEVER, episode_id
from app.words.plain import named, plain
from learners.names import INTRODUCTION, MAX_TRIALS
from learners.schedule_spec import EpisodeSpec, ScheduleSpec, SkillTimer, TriggerSpec


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
    rule: TriggerSpec | None = None,
) -> ScheduleSpec:
    """Change a block's start, length and probability at once; what is None stays.

    A ``rule`` by which a skill joins takes the place of the trial in which it does, and a trial
    that of a rule. Numbers out of range become the nearest allowed one.

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
        timer = schedule.skills.get(skill, SkillTimer())
        new = SkillTimer(
            at=timer.at if at is None else _clamped(at, now.trial + 1, MAX_TRIALS),
            introduce=timer.introduce if at is None else None,
            freeze=timer.freeze if trials is None else _clamped(trials, 0, MAX_TRIALS),
        )
        if rule is not None:
            # Its own only where it is not the schedule's.
            own = None if rule == schedule.introduce else rule
            new = SkillTimer(introduce=own, freeze=new.freeze)
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
    joins_never = joins >= NEVER and schedule.rule_of(skill) is None
    if skill not in now.present and (joins <= now.trial or joins_never):
        raise ValueError(
            f"{named(skill)} has not joined and will not join; add it or plan when it joins first."
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
    return episode_id(len(schedule.episodes) - 1, schedule.episodes[-1].skill)


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
    is_planned = skill in schedule.skills or schedule.rule_of(skill) is not None
    if kind == "introduction" and is_planned:
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
        where=former.where,
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
            when = "by a rule" if joins >= NEVER else f"at {joins:,}"
            raise ValueError(
                f"{named(skill)} is to be explored at trial {first:,}, so it cannot join {when}."
                " Move or delete that exploration first."
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
    starts = [e.at for e in schedule.episodes if e.skill == skill and isinstance(e.at, int)]
    first = min((at for at in starts if at > now.trial), default=NEVER)
    if schedule.introduced_at(skill) <= first:
        return schedule
    kept = [e for e in schedule.episodes if e.skill != skill or e.at != INTRODUCTION]
    skills = {**schedule.skills, skill: SkillTimer(at=first, freeze=schedule.freeze_of(skill))}
    return schedule.model_copy(update={"skills": skills, "episodes": tuple(kept)})
