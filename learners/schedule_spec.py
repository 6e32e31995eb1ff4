"""When skills join and are explored, as a preset states it (section 3.3.4)."""

from collections.abc import Sequence
from typing import Annotated, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from learners.names import (
    INTRODUCTION,
    MAX_TRIALS,
    MAX_VALUE,
    Rate,
    Script,
    SkillName,
    Trials,
    Truth,
)
from sim.spec import FiniteFloat, Problem, ProblemsError, Spec


def _episode_start(value: object) -> object:
    is_trial = isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= MAX_TRIALS
    if value != INTRODUCTION and not is_trial:
        raise ValueError(
            f"is not a trial; allowed: {INTRODUCTION}, or a trial from 0 to {MAX_TRIALS}"
        )
    return value


class TriggerSpec(Spec):
    """A rule by which a skill joins once learning on without it brings little (section 4.3.3)."""

    by: Literal["novelty", "reach", "change"]
    """What is watched: visits of states that were not visited before with the repertoire, per
    trial; states whose value rose above 0 for the first time, per trial; or the change of the
    selection's values, per step."""
    window: Annotated[int, Field(ge=1, le=100_000)] = 500
    """Trials over which the mean of that is taken."""
    below: Annotated[FiniteFloat, Field(ge=0, le=1e6)] = 0.01
    """The skill joins once the mean is less than this."""


class SkillTimer(Spec):
    """When a skill joins, and for how long the selection does not learn then (section 3.3.4)."""

    at: Trials | None = None
    """Trial in which it joins; without one the rule says when, or it is there from trial 0 on."""
    introduce: TriggerSpec | None = None
    """Its own rule, in the place of the schedule's."""
    freeze: Trials = 0

    @model_validator(mode="after")
    def _joins_by_one_of_them(self) -> Self:
        if self.at is not None and self.introduce is not None:
            message = "stands beside a rule by which the skill joins; allowed: one of the two"
            raise ProblemsError([Problem(("at",), self.at, message)])
        return self


class WhereSpec(Spec):
    """In which states an exploration episode acts (section 5.2)."""

    value_at_most: Annotated[FiniteFloat, Field(ge=-MAX_VALUE, le=MAX_VALUE)]
    """The largest value of the present options but the explored one is at most this."""


class EpisodeSpec(Spec):
    """A biased exploration episode (section 3.3.4)."""

    skill: SkillName
    at: Annotated[Literal["introduction"] | int, BeforeValidator(_episode_start)] = INTRODUCTION
    """First trial, or ``introduction`` for whenever the skill joins."""
    duration: Annotated[int, Field(ge=1, le=MAX_TRIALS)]
    """In trials."""
    probability: Rate
    """Chance, at each step, that the skill is taken whatever the selection says."""
    where: WhereSpec | None = None
    """In which states; everywhere unless given."""


class TeachSpec(Spec):
    """Trials in which a script chooses the skill, and the learner learns from that (3.2)."""

    script: Script = "flank"
    trials: Annotated[int, Field(ge=1, le=MAX_TRIALS)]
    """From the first one on."""


class ScheduleSpec(Spec):
    """Skill timers and exploration episodes.

    A skill without a timer is present from trial 0, unless there is a rule by which skills join.
    """

    safe_introduction: Truth = True
    """Whether a skill joins without changing the utility of any state (section 3.3.4)."""
    introduce: TriggerSpec | None = None
    """The rule by which skills join that have neither a trial nor a rule of their own."""
    skills: dict[SkillName, SkillTimer] = Field(default_factory=dict)
    episodes: Annotated[tuple[EpisodeSpec, ...], Field(strict=False)] = ()
    teach: TeachSpec | None = None
    pretrain: Annotated[int, Field(ge=0, le=10_000_000)] = 0
    """Steps that each skill learns alone before the first trial (section 3.2)."""

    def rule_of(self, skill: str) -> TriggerSpec | None:
        """The rule by which a skill joins; None if it joins in a trial that is known."""
        timer = self.skills.get(skill)
        if timer is None:
            return self.introduce
        return None if timer.at is not None else timer.introduce or self.introduce

    def introduced_at(self, skill: str) -> int:
        """Trial in which a skill joins; ``MAX_TRIALS``, which never comes, if a rule says when."""
        if self.rule_of(skill) is not None:
            return MAX_TRIALS
        timer = self.skills.get(skill)
        return 0 if timer is None or timer.at is None else timer.at

    def with_a_first(self, skills: Sequence[str]) -> Self:
        """The same, but the first of all is there from trial 0 on if rules say when each joins."""
        if not skills or any(self.rule_of(skill) is None for skill in skills):
            return self
        first = SkillTimer(at=0, freeze=self.freeze_of(skills[0]))
        return self.model_copy(update={"skills": self.skills | {skills[0]: first}})

    def freeze_of(self, skill: str) -> int:
        """Trials for which the selection is frozen when a skill joins."""
        timer = self.skills.get(skill)
        return 0 if timer is None else timer.freeze

    def starts_at(self, episode: EpisodeSpec) -> int:
        """First trial of an episode; ``MAX_TRIALS`` if a rule says when its skill joins."""
        if episode.at == INTRODUCTION:
            return self.introduced_at(episode.skill)
        return int(episode.at)
