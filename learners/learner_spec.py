"""Options and learning parameters, as a preset states them (section 4.2)."""

from collections.abc import Iterable, Iterator
from typing import Annotated, Final, Literal, Self, cast

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from learners.kernel.rows import MAX_ACTIONS
from learners.names import (
    COMMAND_NAMES,
    COMMANDS,
    MOVES,
    SEARCH,
    Rate,
    SkillName,
    did_you_mean,
    listed,
)
from learners.skill_spec import BUILT_IN, SkillWeights
from learners.skills import SPIRAL_PENALTY, LocalReward
from learners.template_spec import SELECTION, WAYS, TemplateSpec
from sim.spec import FiniteFloat, Problem, ProblemsError, Spec

_ALLOWED_OPTIONS: Final = (
    f"{MOVES}, {COMMANDS}, or a list of skills from {', '.join(BUILT_IN)} and those of"
    " custom_skills"
)


Selection = Literal[
    "learned",
    "best_happiness",
    "worst_unhappiness",
    "negotiated_unhappiness",
    "collective",
    "w_learning",
]


def _options(value: object) -> object:
    if value in (MOVES, COMMANDS):
        return value
    several = cast("Iterable[object]", value) if isinstance(value, list | tuple) else ()
    names = tuple(several)
    if not names or not all(isinstance(name, str) for name in names):
        raise ValueError(f"names no skills; allowed: {_ALLOWED_OPTIONS}")
    if len(set(names)) != len(names):
        raise ValueError("names a skill twice; allowed: each skill once")
    if len(names) > MAX_ACTIONS:
        raise ValueError(f"names {len(names)} skills; allowed: up to {MAX_ACTIONS}")
    return names


def _of_ones_own(skills: dict[str, SkillWeights]) -> dict[str, SkillWeights]:
    built_in = [name for name in skills if name in BUILT_IN]
    if built_in:
        message = "is the name of a built-in skill; allowed: another"
        raise ProblemsError([Problem((name,), name, message) for name in built_in])
    return skills


def _plain_zero(value: float) -> float:
    # There are two zeros, and which of them is the larger is up to each program.
    return value if np.float32(value) else 0.0


class HeldSpec(Spec):
    """A choice is kept for some steps, and learned from once, at its end (3.2 and 5.2)."""

    until: Literal["change", "steps"]
    """Whether it is kept until the main state changes, or always for ``most`` steps."""
    most: Annotated[int, Field(ge=1, le=1_000)] = 10
    """Steps for which it is kept at most."""
    discount: Literal["step", "choice"] = "step"
    """Whether what follows is discounted once for each step, or once for the choice."""


class LearnerSpec(Spec):
    """Options and learning parameters (section 4.2)."""

    options: Annotated[
        Literal["moves", "commands"] | tuple[str, ...],
        BeforeValidator(_options),
        Field(description=_ALLOWED_OPTIONS),
    ]
    """The nine primitive moves, the skills to select from, or the commands of a feudal manager."""
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

    held: HeldSpec | None = None
    """How long a choice is kept; one step unless given."""
    trace_decay: Rate | None = None
    """Share of each update that earlier moves get, from move to move (λ); without it, none."""
    region: Annotated[int, Field(ge=1, le=24)] = 3
    """Sectors and rings that the manager of commands takes for one."""
    selection: Selection = "learned"
    """How a skill is selected: by a table that is learned, or by a rule from the skills' own."""
    weights: dict[SkillName, Annotated[FiniteFloat, Field(ge=0, le=1_000)]] = Field(
        default_factory=dict
    )
    """Of skills where a rule selects; 1 unless given."""
    applicable: Rate | None = None
    """Only skills are selected whose largest value is at least this share of the largest that it
    ever was."""

    templates: Annotated[tuple[TemplateSpec, ...], Field(strict=False, max_length=32)] = ()
    """What tables begin with (section 2.3.2); of several for the same value the last counts."""

    @model_validator(mode="after")
    def _parts_go_together(self) -> Self:
        problems = list(clashes(self))
        if problems:
            raise ProblemsError(problems)
        return self

    @model_validator(mode="after")
    def _skills_are_known(self) -> Self:
        known = self.known_skills
        unknown = [
            f"{name[:40]!r}{did_you_mean(name, known)}" for name in self.skills if name not in known
        ]
        if unknown:
            message = (
                f"names no skill with {', '.join(unknown)};"
                f" allowed: {MOVES}, {COMMANDS}, or a list of skills from {listed(known)}"
            )
            raise ProblemsError([Problem(("options",), self.options, message)])
        return self

    @property
    def known_skills(self) -> tuple[str, ...]:
        """Every skill that the options may name: the built-in ones and one's own."""
        return (*BUILT_IN, *self.custom_skills)

    def skill_of(self, name: str) -> SkillWeights:
        """What a skill sees and earns, by its name."""
        return BUILT_IN[name] if name in BUILT_IN else self.custom_skills[name]

    def reward_of(self, skill: str) -> LocalReward:
        """Local reward of a skill by its name, as weights of the thesis's metrics."""
        return self.skill_of(skill).reward(self.spiral_penalty)

    @property
    def skills(self) -> tuple[str, ...]:
        """The skills among the options, in order; none if they are the primitive moves."""
        return tuple(self.options) if isinstance(self.options, tuple) else ()

    @property
    def sub_policies(self) -> tuple[str, ...]:
        """The options that choose their moves by tables of their own: the skills, or the commands.

        None if the options are the primitive moves.
        """
        return COMMAND_NAMES if self.options == COMMANDS else self.skills

    def sees_heading(self, sub_policy: str) -> bool:
        """Whether the table of a sub-policy tells the prey's headings apart."""
        if self.options == COMMANDS:
            return sub_policy == SEARCH
        return self.skill_of(sub_policy).sees is not None


def clashes(learner: LearnerSpec) -> Iterator[Problem]:
    """What cannot work together in a learner, each with the reason."""
    if learner.trace_decay is not None and learner.options != MOVES:
        message = f"needs moves, since a trace is of moves; allowed: none, or options: {MOVES}"
        yield Problem(("trace_decay",), learner.trace_decay, message)
    if learner.held is not None and (
        learner.trace_decay is not None or learner.options == COMMANDS
    ):
        what = (
            "traces go from move to move" if learner.trace_decay is not None else "a command holds"
        )
        message = f"does not go with this learner: {what}; allowed: none"
        yield Problem(("held",), learner.held.until, message)
    elif learner.held is not None and learner.selection != "learned":
        message = (
            f"keeps a choice, and {learner.selection} chooses anew in each step; allowed: none"
        )
        yield Problem(("held",), learner.held.until, message)
    if learner.selection != "learned":
        if not learner.skills:
            message = "selects between skills, and there are none; allowed: learned"
            yield Problem(("selection",), learner.selection, message)
        elif learner.skills_that_learn != "all":
            message = (
                "leaves a skill that never moves without an idea of what a move costs it, by which"
                " the rule of this learner selects; allowed: all"
            )
            yield Problem(("skills_that_learn",), learner.skills_that_learn, message)
    if learner.applicable is not None and (not learner.skills or learner.selection != "learned"):
        message = "needs skills between which a table selects; allowed: none"
        yield Problem(("applicable",), learner.applicable, message)
    for skill, weight in learner.weights.items():
        if learner.selection == "learned":
            message = "is a weight, and a learned selection has none; allowed: another selection"
            yield Problem(("weights", skill), weight, message)
        elif skill not in learner.skills:
            allowed = listed(learner.skills) or f"none, because the options are {learner.options}"
            message = f"is not among the learner's options; allowed: {allowed}"
            yield Problem(("weights", skill), weight, message)
    yield from _misplaced_templates(learner)


def _misplaced_templates(learner: LearnerSpec) -> Iterator[Problem]:
    tables = (SELECTION, *learner.skills)
    for index, template in enumerate(learner.templates):
        key = ("templates", index)
        if learner.options == COMMANDS:
            message = "is for moves or skills, and the options are commands; allowed: none"
            yield Problem((*key, "table"), template.table, message)
            continue
        if template.table not in tables:
            message = f"is no table of this learner; allowed: {', '.join(tables)}"
            yield Problem((*key, "table"), template.table, message)
            continue
        if template.table == SELECTION and learner.selection != "learned":
            message = f"is not learned, but by {learner.selection}; allowed: a skill"
            yield Problem((*key, "table"), template.table, message)
            continue
        is_of_skills = template.table == SELECTION and learner.skills
        allowed = learner.skills if is_of_skills else WAYS
        if template.prefer not in allowed:
            message = f"is not what this table is about; allowed: {', '.join(allowed)}"
            yield Problem((*key, "prefer"), template.prefer, message)
        is_blind = template.table != SELECTION and not learner.sees_heading(template.table)
        if is_blind and template.bearing != (0.0, 180.0):
            message = f"is not known to {template.table}, which does not see where the prey looks"
            yield Problem((*key, "bearing"), template.bearing, f"{message}; allowed: none")
