"""What a run is made of, as a preset states it (validated, frozen).

A run is a function of a :class:`RunSpec`, a seed, and the commands given while it runs.
"""

import difflib
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from typing import Annotated, Final, Literal, Self

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationInfo,
    field_validator,
    model_validator,
)

from learners.kernel.rows import MAX_ACTIONS
from learners.skills import SKILLS, SPIRAL_PENALTY, LocalReward, rewards
from sim.spec import FiniteFloat, Problem, ProblemsError, Spec, WorldSpec

MAX_TRIALS = 2_000_000
"""Trials a run may have: its log takes 29 bytes for each."""

SkillName = Annotated[
    str,
    Field(
        pattern=r"^[a-z][a-z0-9_]*$",
        max_length=32,
        description="a name of up to 32 characters from a-z, 0-9 and _ that starts with a letter",
    ),
]
Weight = Annotated[FiniteFloat, Field(ge=-10, le=10)]
Rate = Annotated[FiniteFloat, Field(ge=0, le=1)]
Trials = Annotated[int, Field(ge=0, le=MAX_TRIALS)]

MOVES = "moves"
INTRODUCTION = "introduction"

_MOST_NAMES: Final = 32
_ALLOWED_OPTIONS: Final = (
    f"{MOVES}, or a list of skills from {', '.join(SKILLS)} and those of custom_skills"
)


def listed(names: Iterable[str]) -> str:
    """Names in a message: all of them, or as many as anyone would read."""
    first = list(islice(names, _MOST_NAMES + 1))
    return ", ".join(first if len(first) <= _MOST_NAMES else [*first[:_MOST_NAMES], "…"])


def did_you_mean(word: object, names: Iterable[str]) -> str:
    """A hint at the nearest of the first names; empty if none is near."""
    nearest = difflib.get_close_matches(str(word)[:80], list(islice(names, _MOST_NAMES)), n=1)
    return f" (did you mean {nearest[0]}?)" if nearest else ""


class SkillWeights(Spec):
    """A skill of one's own: its local reward is a weighted sum of those of the four skills."""

    approach: Weight = 0.0
    avoid: Weight = 0.0
    circle_clockwise: Weight = 0.0
    circle_counterclockwise: Weight = 0.0

    def reward(self, spiral_penalty: float) -> LocalReward:
        """The sum as weights of the three metrics, for circles that are charged so much."""
        of_skill = rewards(spiral_penalty)
        parts = [
            [weight * part for part in of_skill[skill]]
            for skill, weight in self.model_dump().items()
        ]
        return LocalReward(*(sum(column) for column in zip(*parts, strict=True)))


def _options(value: object) -> object:
    if value == MOVES:
        return MOVES
    names = value if isinstance(value, list | tuple) else []
    if not names or not all(isinstance(name, str) for name in names):
        raise ValueError(f"names no skills; allowed: {_ALLOWED_OPTIONS}")
    if len(set(names)) != len(names):
        raise ValueError("names a skill twice; allowed: each skill once")
    if len(names) > MAX_ACTIONS:
        raise ValueError(f"names {len(names)} skills; allowed: up to {MAX_ACTIONS}")
    return tuple(names)


def _episode_start(value: object) -> object:
    is_trial = isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= MAX_TRIALS
    if value != INTRODUCTION and not is_trial:
        raise ValueError(
            f"is not a trial; allowed: {INTRODUCTION}, or a trial from 0 to {MAX_TRIALS}"
        )
    return value


def _truth(value: object) -> object:
    if not isinstance(value, bool):
        raise ValueError("must be true or false; allowed: true, false")
    return value


Truth = Annotated[bool, BeforeValidator(_truth)]


def _of_ones_own(skills: dict[str, SkillWeights]) -> dict[str, SkillWeights]:
    built_in = [name for name in skills if name in SKILLS]
    if built_in:
        message = "is the name of a built-in skill; allowed: another"
        raise ProblemsError([Problem((name,), name, message) for name in built_in])
    return skills


def _plain_zero(value: float) -> float:
    # There are two zeros, and which of them is the larger is up to each program.
    return value if np.float32(value) else 0.0


class LearnerSpec(Spec):
    """Options and learning parameters (section 4.2)."""

    options: Annotated[
        Literal["moves"] | tuple[str, ...],
        BeforeValidator(_options),
        Field(description=_ALLOWED_OPTIONS),
    ]
    """The nine primitive moves, or the skills to select from."""
    alpha: Rate
    """Learning rate of the selection."""
    skill_alpha: Rate = 0.6
    """Learning rate of the skills."""
    gamma: Annotated[FiniteFloat, Field(ge=0, lt=1)] = 0.9
    """Discount per step, at both levels."""
    epsilon: Rate = 0.1
    """Chance of a random choice, at both levels."""
    initial_q: Annotated[FiniteFloat, Field(ge=-1e6, le=1e6), AfterValidator(_plain_zero)] = 0.0
    """Value of everything not yet tried, at both levels."""
    spiral_penalty: Annotated[FiniteFloat, Field(ge=0, le=1), AfterValidator(_plain_zero)] = (
        SPIRAL_PENALTY
    )
    """Share of the ground given up towards the prey that a circle is charged for."""
    local_rewards: Literal["signed", "binary"] = "signed"
    """Whether a local reward is what the move earned, or 1 where that is above 0 and else 0."""
    skills_that_learn: Literal["chosen", "all"] = "chosen"
    """Whether of the present skills the one that made the move learns from it, or each of them."""
    custom_skills: Annotated[dict[SkillName, SkillWeights], AfterValidator(_of_ones_own)] = Field(
        default_factory=dict
    )
    """Skills of one's own, by name; those among the options are learned."""

    @model_validator(mode="after")
    def _skills_are_known(self) -> Self:
        known = self.known_skills
        unknown = [
            f"{name[:40]!r}{did_you_mean(name, known)}" for name in self.skills if name not in known
        ]
        if unknown:
            message = (
                f"names no skill with {', '.join(unknown)};"
                f" allowed: {MOVES}, or a list of skills from {listed(known)}"
            )
            raise ProblemsError([Problem(("options",), self.options, message)])
        return self

    @property
    def known_skills(self) -> tuple[str, ...]:
        """Every skill that the options may name: the built-in ones and one's own."""
        return (*SKILLS, *self.custom_skills)

    def reward_of(self, skill: str) -> LocalReward:
        """Local reward of a skill by its name, as weights of the three metrics."""
        if skill in SKILLS:
            return rewards(self.spiral_penalty)[skill]
        return self.custom_skills[skill].reward(self.spiral_penalty)

    @property
    def skills(self) -> tuple[str, ...]:
        """The skills among the options, in order; none if they are the primitive moves."""
        return () if self.options == MOVES else tuple(self.options)


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


class RunSpec(Spec):
    """A preset: a world, a learner, the schedule of its skills, and a number of trials."""

    description: Annotated[str, Field(max_length=400)] = ""
    world: WorldSpec = Field(default_factory=WorldSpec)
    learner: LearnerSpec
    schedule: ScheduleSpec = Field(default_factory=ScheduleSpec)
    trials: Annotated[int, Field(ge=1, le=MAX_TRIALS)]

    @field_validator("schedule")
    @classmethod
    def _fits_the_learner(cls, schedule: ScheduleSpec, info: ValidationInfo) -> ScheduleSpec:
        # Compared as soon as these two are sound, whatever is wrong with the rest.
        learner = info.data.get("learner")
        problems = [] if learner is None else list(_misfits(schedule, learner))
        if problems:
            raise ProblemsError(problems)
        return schedule


def _misfits(schedule: ScheduleSpec, learner: LearnerSpec) -> Iterator[Problem]:
    """What does not go together in a schedule with the learner it is for."""
    yield from _unknown_skills(schedule, learner)
    yield from _no_first_skill(schedule, learner.skills)
    yield from _misplaced_episodes(schedule)


def _unknown_skills(schedule: ScheduleSpec, learner: LearnerSpec) -> Iterator[Problem]:
    allowed = ", ".join(learner.skills) or "none, because the options are moves"
    named: list[tuple[tuple[str | int, ...], str]] = [
        *((("skills", skill), skill) for skill in schedule.skills),
        *(
            (("episodes", index, "skill"), episode.skill)
            for index, episode in enumerate(schedule.episodes)
        ),
    ]
    for key, skill in named:
        if skill not in learner.skills:
            known = learner.known_skills
            hint = "" if skill in known else did_you_mean(skill, known)
            message = f"is not among the learner's options{hint}; allowed: {allowed}"
            yield Problem(key, skill, message)


def _no_first_skill(schedule: ScheduleSpec, skills: Sequence[str]) -> Iterator[Problem]:
    earliest = min(skills, key=schedule.introduced_at, default=None)
    if earliest is not None and schedule.introduced_at(earliest) > 0:
        yield Problem(
            ("skills", earliest, "at"),
            schedule.introduced_at(earliest),
            "leaves nothing to do before it; allowed: 0 for at least one skill",
        )


def _misplaced_episodes(schedule: ScheduleSpec) -> Iterator[Problem]:
    taken: dict[str, list[tuple[int, int]]] = {}
    for index, episode in enumerate(schedule.episodes):
        key = ("episodes", index, "at")
        first = schedule.starts_at(episode)
        joins = schedule.introduced_at(episode.skill)
        if first < joins:
            yield Problem(
                key,
                episode.at,
                f"starts before {episode.skill} joins; allowed: {joins} or later,"
                f" or {INTRODUCTION}",
            )
        for other_first, other_end in taken.get(episode.skill, []):
            if first < other_end and other_first < first + episode.duration:
                yield Problem(
                    key,
                    episode.at,
                    f"overlaps the episode of {episode.skill} from trial {other_first}"
                    f" to {other_end}; allowed: one at a time for each skill",
                )
                break
        taken.setdefault(episode.skill, []).append((first, first + episode.duration))
