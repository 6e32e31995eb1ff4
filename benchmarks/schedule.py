"""A preset's schedule in trials and options, for programs that know no presets."""

import itertools
from typing import NamedTuple

from learners.names import INTRODUCTION
from learners.schedule_spec import EpisodeSpec
from learners.spec import RunSpec
from sim.geometry import N_MOVES


class Exploration(NamedTuple):
    """A biased exploration episode (section 3.3.4)."""

    option: int
    start: int
    """First trial."""
    duration: int
    """In trials."""
    probability: float


class Phase(NamedTuple):
    """The schedule from one of its events to the next."""

    first_trial: int
    until_trial: int
    present: tuple[int, ...]
    """Options."""
    joining: tuple[int, ...]
    """Options that join at the start of it."""
    frozen: bool
    """Whether the selection does not learn."""
    running: tuple[Exploration, ...]
    """The newest first."""


def explorations(spec: RunSpec) -> list[Exploration]:
    """All exploration episodes, the oldest first.

    Of those that start together, the ones that come with an introduction are the older, in the
    order of the skills among the options.
    """
    skills, schedule = spec.learner.skills, spec.schedule

    def age(episode: EpisodeSpec) -> tuple[int, int]:
        with_introduction = episode.at == INTRODUCTION
        order = skills.index(episode.skill) if with_introduction else len(skills)
        return schedule.starts_at(episode), order

    return [
        Exploration(
            skills.index(episode.skill),
            schedule.starts_at(episode),
            episode.duration,
            episode.probability,
        )
        for episode in sorted(schedule.episodes, key=age)
    ]


def phases(spec: RunSpec) -> list[Phase]:
    """The stretches of trials between the events of a schedule."""
    schedule, skills = spec.schedule, spec.learner.skills
    joins = [schedule.introduced_at(skill) for skill in skills]
    thaws = [schedule.introduced_at(skill) + schedule.freeze_of(skill) for skill in skills]
    bounds = {0, spec.trials, *joins, *thaws}
    for exploration in explorations(spec):
        bounds |= {exploration.start, exploration.start + exploration.duration}
    events = sorted(event for event in bounds if event <= spec.trials)
    return [
        Phase(
            first_trial=first,
            until_trial=until,
            present=tuple(option for option, at in enumerate(joins) if at <= first)
            or tuple(range(N_MOVES)),
            joining=tuple(option for option, at in enumerate(joins) if at == first),
            frozen=any(at <= first < thaw for at, thaw in zip(joins, thaws, strict=True)),
            running=tuple(
                episode
                for episode in reversed(explorations(spec))
                if episode.start <= first < episode.start + episode.duration
            ),
        )
        for first, until in itertools.pairwise(events)
    ]
