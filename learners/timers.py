"""What a schedule has ahead, as the commands that it will give (sections 3.3.4 and 4.3.3)."""

from typing import NamedTuple

from learners.commands import Command, Explore, Introduce, Teach
from learners.names import INTRODUCTION
from learners.schedule_spec import EpisodeSpec, TriggerSpec
from learners.spec import RunSpec


class Timer(NamedTuple):
    """A command of the schedule and the trial before which it is given."""

    trial: int
    command: Command


class Awaited(NamedTuple):
    """The next skill that joins by a rule."""

    introduce: Introduce
    rule: TriggerSpec
    since: int
    """First trial that the rule looks at: the freeze of the latest introduction is over."""


def timers_of(spec: RunSpec) -> tuple[Timer, ...]:
    """The schedule as commands in the order in which they are given."""
    schedule = spec.schedule
    timers = [
        Timer(schedule.introduced_at(skill), Introduce(skill, schedule.freeze_of(skill)))
        for skill in spec.learner.skills
    ]
    timers += [
        Timer(int(episode.at), exploration_of(episode))
        for episode in schedule.episodes
        if episode.at != INTRODUCTION
    ]
    if schedule.teach is not None:
        timers.append(Timer(0, Teach(schedule.teach.script, schedule.teach.trials)))
    return tuple(sorted(timers, key=lambda timer: timer.trial))


def exploration_of(episode: EpisodeSpec) -> Explore:
    """An episode of the schedule as the command that begins it."""
    at_most = None if episode.where is None else episode.where.value_at_most
    return Explore(episode.skill, episode.duration, episode.probability, at_most)
