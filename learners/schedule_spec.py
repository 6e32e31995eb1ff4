"""When skills join and are explored, as a preset states it (section 3.3.4)."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from learners.names import INTRODUCTION, MAX_TRIALS, Rate, SkillName, Trials, Truth
from sim.spec import Spec


def _episode_start(value: object) -> object:
    is_trial = isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= MAX_TRIALS
    if value != INTRODUCTION and not is_trial:
        raise ValueError(
            f"is not a trial; allowed: {INTRODUCTION}, or a trial from 0 to {MAX_TRIALS}"
        )
    return value


class SkillTimer(Spec):
    """When a skill joins, and for how long the selection does not learn then (section 3.3.4)."""

    at: Trials
    freeze: Trials = 0


class EpisodeSpec(Spec):
    """A biased exploration episode (section 3.3.4)."""

    skill: SkillName
    at: Annotated[Literal["introduction"] | int, BeforeValidator(_episode_start)] = INTRODUCTION
    """First trial, or ``introduction`` for whenever the skill joins."""
    duration: Annotated[int, Field(ge=1, le=MAX_TRIALS)]
    """In trials."""
    probability: Rate
    """Chance, at each step, that the skill is taken whatever the selection says."""


class ScheduleSpec(Spec):
    """Skill timers and exploration episodes. A skill without a timer is present from trial 0."""

    safe_introduction: Truth = True
    """Whether a skill joins without changing the utility of any state (section 3.3.4)."""
    skills: dict[SkillName, SkillTimer] = Field(default_factory=dict)
    episodes: Annotated[tuple[EpisodeSpec, ...], Field(strict=False)] = ()

    def introduced_at(self, skill: str) -> int:
        """Trial in which a skill joins."""
        timer = self.skills.get(skill)
        return 0 if timer is None else timer.at

    def freeze_of(self, skill: str) -> int:
        """Trials for which the selection is frozen when a skill joins."""
        timer = self.skills.get(skill)
        return 0 if timer is None else timer.freeze

    def starts_at(self, episode: EpisodeSpec) -> int:
        """First trial of an episode."""
        if episode.at == INTRODUCTION:
            return self.introduced_at(episode.skill)
        return int(episode.at)
