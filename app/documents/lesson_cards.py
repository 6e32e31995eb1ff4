"""The cards of a lesson as its file states them (validated, frozen), and what may stand on one.

What does not go together within one card is said here, what does not in a whole lesson in
:mod:`app.documents.lesson_fits`.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal, Self

from pydantic import AfterValidator, Field, PlainValidator, model_validator

from app.documents.experiment_spec import Settings
from app.documents.lesson_grammar import (
    LAYERS,
    MAX_STEPS,
    MOMENTS,
    REGIONS,
    At,
    Check,
    CommandName,
    DeedName,
    LayerKey,
    Region,
)
from app.documents.lesson_questions import (
    MAX_TEXT,
    MAX_WORDS,
    QUESTIONS,
    Asked,
    Id,
    Text,
    each_once,
    n_words,
    readable,
)
from learners.names import MAX_TRIALS, Rate, SkillName, Truth, did_you_mean, listed
from sim.rng import MAX_SEED
from sim.spec import Problem, ProblemsError, Spec

MAX_HINTS: Final = 5

# --- Controls ------------------------------------------------------------------------------------

CONTROLS: Final[Mapping[str, str]] = {
    "play": "Play and pause",
    "step": "One step",
    "trial": "One trial",
    "speed": "Speed",
    **{f"layer.{key}": f"The layer {key}" for key in LAYERS},
    "headings": "Which headings are shown",
    "inspect": "Why a place has its value",
    "bar": "The time bar",
    "curve": "The curve of the reward",
    "scrub": "Moving to another moment",
    "plan": "Changing the plan",
    "add_skill": "Adding a skill",
    "explore": "Exploring a skill",
    "freeze": "Freezing tables",
    "undo": "Taking back what was done",
    "start_again": "Starting again",
    "side": "Runs side by side",
    "marks": "Marks of moments",
    "watch": "Watching a hunt",
    "experiments": "Experiments",
    "all": "Everything",
}
"""What a lesson can show or hide, and in words what it is."""


def _control(value: Any) -> str:
    if isinstance(value, str) and value in CONTROLS:
        return value
    hint = did_you_mean(value, CONTROLS) if isinstance(value, str) else ""
    raise ValueError(f"is no control{hint}; allowed: {listed(CONTROLS)}")


Control = Annotated[str, PlainValidator(_control), Field(description=", ".join(CONTROLS))]
Controls = Annotated[
    tuple[Control, ...], Field(strict=False, max_length=len(CONTROLS)), AfterValidator(each_once)
]


class Look(Spec):
    """How the board is to be seen while a card is read."""

    layer: LayerKey | None = None
    mark: Region | None = None
    """A region that is outlined."""
    frame: Literal["turned", "all", "trial"] | None = None
    """All headings turned so that the prey looks right, side by side, or that of the trial."""


# --- What is done --------------------------------------------------------------------------------


class Exploring(Spec):
    """How a skill is explored."""

    trials: Annotated[int, Field(ge=1, le=MAX_TRIALS)]
    chance: Rate


class Given(Spec):
    """One command to a learner."""

    command: CommandName
    skill: SkillName | None = None
    freeze: Annotated[int, Field(ge=0, le=MAX_TRIALS)] | None = None
    """Trials for which the selection is frozen when a skill joins; None for the preset's."""
    explore: Exploring | None = None
    """What is explored, or is to be right after a skill has joined."""
    on: Truth | None = None
    """Of a freeze, or of the schedule."""

    @model_validator(mode="after")
    def _goes_together(self) -> Self:
        _go_together(self)
        return self


NEEDS: Final[Mapping[str, tuple[tuple[str, ...], tuple[str, ...]]]] = {
    "introduce": (("skill",), ("freeze", "explore")),
    "explore": (("skill", "explore"), ()),
    "stop_exploring": (("skill",), ()),
    "freeze_selection": (("on",), ()),
    "freeze_skills": (("on",), ()),
    "follow_schedule": (("on",), ()),
    "remove": (("skill",), ()),
    "step": ((), ()),
    "trial": ((), ()),
    "play": ((), ()),
    "run_to": (("at",), ()),
    "rewind": (("at",), ()),
    "mark": ((), ("at",)),
    "start_again": ((), ("preset", "set", "seed")),
    "race": ((), ("presets", "steps")),
    "fork": (("at", "then"), ()),
    "experiment": (("name",), ()),
    "inspect": (("region",), ()),
    "show": (("layer",), ()),
}
"""What each command needs, and what else it may have."""


_STATED: Final = {
    "skill": "a skill",
    "explore": "{trials, chance}",
    "on": "true, false",
    "at": MOMENTS,
    "then": "a list of commands",
    "name": "an experiment",
    "region": ", ".join(REGIONS),
    "layer": ", ".join(LAYERS),
}


def _go_together(done: "Given | Do") -> None:
    needed, possible = NEEDS[done.command]
    fields = [name for name in type(done).model_fields if name != "command"]
    stated = {name: value for name in fields if (value := getattr(done, name)) not in (None, {})}
    allowed = ", ".join((*needed, *possible)) or "nothing else"
    problems = [
        Problem((name,), ..., f"is missing, which {done.command} needs; allowed: {_STATED[name]}")
        for name in needed
        if name not in stated
    ]
    problems += [
        Problem((name,), value, f"does not belong to {done.command}; allowed: {allowed}")
        for name, value in stated.items()
        if name not in (*needed, *possible)
    ]
    if problems:
        raise ProblemsError(problems)


class Do(Spec):
    """What is to be done: a command to the learner, or something with runs."""

    command: DeedName
    skill: SkillName | None = None
    freeze: Annotated[int, Field(ge=0, le=MAX_TRIALS)] | None = None
    explore: Exploring | None = None
    on: Truth | None = None
    at: At | None = None
    """Where it is run to, rewound to, marked or forked."""
    preset: Annotated[str, Field(max_length=1_024)] | None = None
    """Of a new start; None for the lesson's own."""
    set: Settings = Field(default_factory=dict)
    seed: Annotated[int, Field(ge=0, le=MAX_SEED)] | None = None
    presets: (
        Annotated[
            tuple[Annotated[str, Field(max_length=64)], ...],
            Field(strict=False, min_length=2, max_length=4),
        ]
        | None
    ) = None
    """Of a race; None for the thesis's four."""
    steps: Annotated[int, Field(ge=1, le=MAX_STEPS)] | None = None
    """How far a race goes; None for its end."""
    then: Annotated[tuple[Given, ...], Field(strict=False, min_length=1, max_length=8)] | None = (
        None
    )
    """What a fork gets."""
    name: Annotated[str, Field(max_length=64)] | None = None
    """Of an experiment."""
    region: Region | None = None
    """In which a place is looked into."""
    layer: LayerKey | None = None

    @model_validator(mode="after")
    def _goes_together(self) -> Self:
        _go_together(self)
        return self


# --- Cards ---------------------------------------------------------------------------------------

VERBS: Final = ("say", "ask", "do", "see", "why", "transfer", "free")
CardKind = Literal["say", "ask", "do", "see", "why", "transfer", "free"]


class See(Spec):
    """The same question as before, now that it can be seen."""

    same_as: Id


class Why(Spec):
    """An explanation, with a place that is looked into."""

    inspect: Region | None = None
    text: Text


class Swap(Spec):
    """The lesson's run once more with another skill in the place of the one that was added."""

    swap: SkillName


class Transfer(Asked):
    """A question on what was not shown: it is revealed by a run of its own."""

    run: Swap

    @model_validator(mode="after")
    def _goes_together(self) -> Self:
        if self.ask is None:
            kinds = ", ".join(QUESTIONS)
            raise ProblemsError([Problem(("ask",), ..., f"is missing; allowed: {kinds}")])
        if problems := self.misfits():
            raise ProblemsError(problems)
        return self


class Free(Spec):
    """Everything, to be tried out."""

    show: Literal["all"]


class DoIt(Spec):
    """The last hint: it is done."""

    do: Truth


def _hint(value: Any) -> str | DoIt:
    if isinstance(value, str):
        if len(value) > MAX_TEXT:
            raise ValueError(f"is too long; allowed: a text of up to {MAX_TEXT} characters")
        return readable(value)
    if value == {"do": True} and value["do"] is True:
        return DoIt(do=True)
    raise ValueError("is no hint; allowed: a text, or {do: true} as the last")


_Hint = Annotated[str | DoIt, PlainValidator(_hint), Field(description="a text, or {do: true}")]


class Card(Asked):
    """One step of a lesson."""

    id: Id = ""
    """Where a file gives none, ``step_3`` for the third."""
    say: Text | None = None
    do: Do | None = None
    see: See | None = None
    why: Why | None = None
    transfer: Transfer | None = None
    free: Free | None = None
    look: Look | None = None
    unlock: Controls = ()
    run: At | None = None
    """How far it learns when one goes on from here; None for not at all."""
    check: Check | None = None
    steps_of_help: Annotated[tuple[_Hint, ...], Field(strict=False, max_length=MAX_HINTS)] = Field(
        (), alias="hints"
    )
    notes: Text | None = None
    """For the teacher alone."""

    @property
    def kind(self) -> CardKind:
        """What is done with it."""
        return next(verb for verb in VERBS if getattr(self, verb) is not None)

    @property
    def words(self) -> str:
        """Its text, whatever its kind; empty if it has none."""
        within = self.why or self.transfer
        return self.say or self.text or (within and within.text) or ""

    @property
    def hints(self) -> tuple[str, ...]:
        """Hints that are texts, in their order."""
        return tuple(hint for hint in self.steps_of_help if isinstance(hint, str))

    @property
    def does_it(self) -> bool:
        """Whether the last hint does what is to be done."""
        return any(isinstance(hint, DoIt) for hint in self.steps_of_help)

    @property
    def question(self) -> Asked | None:
        """What it asks by itself; None where it asks nothing, or what another one does."""
        return self if self.ask is not None else self.transfer

    @model_validator(mode="after")
    def _goes_together(self) -> Self:
        verbs = [verb for verb in VERBS if getattr(self, verb) is not None]
        if len(verbs) != 1:
            has = f"has {' and '.join(verbs)}" if verbs else "has nothing to do"
            raise ValueError(f"{has}; allowed: one of {', '.join(VERBS)}")
        problems = [*self._strangers(verbs[0]), *self._wrong_hints()]
        if self.ask is not None:
            problems += self.misfits()
        if n_words(self.words) > MAX_WORDS:
            message = f"has {n_words(self.words)} words; allowed: up to {MAX_WORDS} on a card"
            problems.append(Problem(self.key_of_words, self.words, message))
        if problems:
            raise ProblemsError(problems)
        return self

    @property
    def key_of_words(self) -> tuple[str, ...]:
        """Where its text stands in a file."""
        kind = self.kind
        return {"say": ("say",), "why": ("why", "text"), "transfer": ("transfer", "text")}.get(
            kind, ("text",)
        )

    def _strangers(self, verb: str) -> list[Problem]:
        """What belongs to cards of other kinds."""
        of_question = tuple(name for name in Asked.model_fields if name not in ("ask", "text"))
        belong = {
            "text": ("ask", "do", "see", "free"),
            **dict.fromkeys(of_question, ("ask",)),
            "check": ("do",),
            "steps_of_help": ("do",),
        }
        problems: list[Problem] = []
        for name, verbs in belong.items():
            field, value = type(self).model_fields[name], getattr(self, name)
            if verb not in verbs and value != field.get_default():
                message = f"does not belong to {verb}; allowed: in {', '.join(verbs)}"
                problems.append(Problem((field.alias or name,), _shown(value), message))
        if verb == "do":
            needed = {"text": "a text", "check": "a check"}
            problems += [
                Problem((name,), ..., f"is missing, which do needs; allowed: {allowed}")
                for name, allowed in needed.items()
                if getattr(self, name) is None
            ]
        return problems

    def _wrong_hints(self) -> list[Problem]:
        return [
            Problem(("hints", n), {"do": True}, "is not the last hint; allowed: as the last")
            for n, hint in enumerate(self.steps_of_help[:-1])
            if isinstance(hint, DoIt)
        ]


def _shown(value: object) -> object:
    """A value as a problem quotes it, which has no models in it."""
    return "..." if isinstance(value, Spec | tuple) else value
