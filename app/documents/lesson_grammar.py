"""What a lesson can ask of a run: moments, regions, measures, and what is checked of them.

These are closed lists, stated here so that a file can be judged without a run; how each measure is
found stands in ``app.lessons.measures``, and nothing in a file is ever evaluated.
"""

import re
from collections.abc import Callable, Collection, Mapping
from typing import Annotated, Any, Final, Literal, NamedTuple, Self, TypeGuard, cast

from pydantic import Field, PlainValidator, model_validator

from learners.names import MAX_TRIALS, SkillName, did_you_mean
from sim.spec import FiniteFloat, Problem, ProblemsError, Spec

MAX_STEPS: Final = 20_000_000
"""Of a race: several times as many as the thesis's learners make."""
MAX_WORD: Final = 100

# --- When ----------------------------------------------------------------------------------------


class Moment(NamedTuple):
    """A trial of a run, or so many trials from where a card was entered."""

    trials: int
    is_ahead: bool
    """Whether they are counted from where the card was entered."""
    captures: int | None = None
    """So many trials that end in a capture, counted from where the card was entered, instead of
    so many trials; it is the beginning of the trial after the last of them."""

    def after(self, began: int) -> int:
        """The trial that is meant where the card was entered in trial ``began``.

        Where captures are counted it is the earliest that it can be.
        """
        return began + (self.captures or self.trials) if self.is_ahead else self.trials

    def __str__(self) -> str:
        if self.captures is not None:
            return f"{{captures: {self.captures}}}"
        return f"+{self.trials}" if self.is_ahead else str(self.trials)


MOMENTS: Final = (
    f"a trial from 0 to {MAX_TRIALS}, +1 to +{MAX_TRIALS} trials from the card on,"
    f" or {{captures: 1 to {MAX_TRIALS}}}"
)
_AHEAD: Final = re.compile(r"\+([1-9][0-9]{0,6})")


def _is_trials(value: object, least: int = 0) -> TypeGuard[int]:
    """Whether it is so many trials, and a truth is none."""
    return isinstance(value, int) and not isinstance(value, bool) and least <= value <= MAX_TRIALS


def _moment(value: Any) -> Moment:
    if _is_trials(value):
        return Moment(value, False)
    if isinstance(value, dict):
        entries = cast("dict[str, Any]", value)
        count = entries.get("captures")
        if len(entries) == 1 and _is_trials(count, 1):
            return Moment(0, True, count)
    ahead = _AHEAD.fullmatch(value) if isinstance(value, str) else None
    if ahead is not None and _is_trials(count := int(ahead[1])):
        return Moment(count, True)
    raise ValueError(f"is no moment; allowed: {MOMENTS}")


At = Annotated[Moment, PlainValidator(_moment), Field(description=MOMENTS)]
"""A moment as a file states it."""


class Window(NamedTuple):
    """Trials that are averaged over: the last ones, or all from one to before another."""

    last: int | None
    first: int = 0
    end: int = 0


WINDOWS: Final = "so many of the last trials, or [first, end] in trials"


def _window(value: Any) -> Window:
    if _is_trials(value, 1):
        return Window(value)
    if isinstance(value, list):
        items = cast("list[Any]", value)
        if len(items) == 2 and all(map(_is_trials, items)) and items[0] < items[1]:
            return Window(None, items[0], items[1])
    raise ValueError(f"is no window; allowed: {WINDOWS}")


_Window = Annotated[Window, PlainValidator(_window), Field(description=WINDOWS)]

# --- Where ---------------------------------------------------------------------------------------

OCTANTS: Final = ("e", "ne", "n", "nw", "w", "sw", "s", "se")
"""Counter-clockwise, as seen by a prey that looks east: e is straight ahead of it."""
REGIONS: Final = (
    "behind",
    "ahead",
    "left_flank",
    "right_flank",
    "visual_field",
    "near",
    "far",
    *OCTANTS,
)
EACH_OCTANT: Final = "octants"
"""In the place of a region, where octants are predicted: each of them by itself."""


def _known(names: Collection[str], what: str) -> Callable[[Any], str]:
    def known(value: Any) -> str:
        if isinstance(value, str) and value in names:
            return value
        hint = did_you_mean(value, names) if isinstance(value, str) else ""
        raise ValueError(f"is no {what}{hint}; allowed: {', '.join(names)}")

    return known


Region = Annotated[
    str, PlainValidator(_known(REGIONS, "region")), Field(description=", ".join(REGIONS))
]
_REACHED: Final = (*REGIONS, EACH_OCTANT)
_Reached = Annotated[
    str, PlainValidator(_known(_REACHED, "region")), Field(description=", ".join(_REACHED))
]

LAYERS: Final = (
    "value",
    "option",
    "chosen",
    "advantage",
    "visits",
    "reach",
    "now",
    "success",
    "skill",
    "flow",
    "change",
    "stake",
    "traces",
)
LayerKey = Annotated[
    str, PlainValidator(_known(LAYERS, "layer")), Field(description=", ".join(LAYERS))
]

# --- What people do ------------------------------------------------------------------------------

COMMANDS: Final = (
    "introduce",
    "explore",
    "stop_exploring",
    "freeze_selection",
    "freeze_skills",
    "follow_schedule",
    "remove",
)
"""Of a learner."""
DEEDS: Final = (
    *COMMANDS,
    "step",
    "trial",
    "play",
    "run_to",
    "rewind",
    "mark",
    "start_again",
    "race",
    "fork",
    "experiment",
    "inspect",
    "show",
)
"""Whatever a lesson can ask for."""
CommandName = Annotated[
    str, PlainValidator(_known(COMMANDS, "command")), Field(description=", ".join(COMMANDS))
]
DeedName = Annotated[
    str, PlainValidator(_known(DEEDS, "command")), Field(description=", ".join(DEEDS))
]

# --- Measures ------------------------------------------------------------------------------------


class Opened(NamedTuple):
    """What somebody has opened: the answer to *why*, a layer, or a place of the board."""

    what: Literal["why", "layer", "cell"]
    layer: str | None = None
    region: str | None = None


def _opened(value: Any) -> Opened:
    if value == "why":
        return Opened("why")
    named = cast("dict[str, Any]", value) if isinstance(value, dict) else {}
    match list(named.items()):
        case [("layer", key)] if key in LAYERS:
            return Opened("layer", layer=key)
        case [("cell", region)] if region in REGIONS:
            return Opened("cell", region=region)
        case [("layer", key)]:
            hint, names = did_you_mean(key, LAYERS), LAYERS
        case [("cell", region)]:
            hint, names = did_you_mean(region, REGIONS), REGIONS
        case _:
            raise ValueError(f"is nothing to open; allowed: {_OPENED}")
    raise ValueError(f"is nothing to open{hint}; allowed: {', '.join(names)}")


_OPENED: Final = "why, {layer: KEY}, or {cell: REGION}"
_Opened = Annotated[Opened, PlainValidator(_opened), Field(description=_OPENED)]


class OfExperiment(Spec):
    """A number of an experiment's results."""

    name: Annotated[str, Field(max_length=64)]
    quantity: Annotated[str, Field(max_length=64)]
    """A column of the table of results."""
    variant: Annotated[str, Field(max_length=200)] | None = None
    """By its label; None where variants are ranked."""
    against: Annotated[str, Field(max_length=200)] | None = None
    """The variant of which the number is taken away; None for none."""


Answers = Literal["number", "word", "yes"]
"""What a measure finds: a number, a word of a closed list, or whether something is so."""

SHAPES: Final = ("traces", "cone", "arm", "open ring", "ring", "filled")
"""What the places that are worth something look like."""
DIRECTIONS: Final = ("clockwise", "counter-clockwise", "both ways", "not at all")
"""Which way value spreads."""

PLAIN_MEASURES: Final[Mapping[str, Answers]] = {
    "trial": "number",
    "step": "number",
    "value_states": "number",
    "behind_share": "number",
    "thinnest": "number",
    "shape": "word",
    "spread_direction": "word",
    "captures": "number",
    "success": "number",
    "first_divergence": "number",
}
"""Measures that need no arguments, ``measure: NAME`` in a file, and what each finds."""
MEASURES_OF: Final[Mapping[str, Answers]] = {
    "present": "yes",
    "reach": "number",
    "reward": "number",
    "change": "number",
    "leader": "word",
    "command": "yes",
    "opened": "yes",
    "experiment": "number",
}
"""Measures of something, ``NAME: of what`` in a file, and what each finds."""
MEASURE_NAMES: Final = (*PLAIN_MEASURES, *MEASURES_OF)
"""All of them."""


class Reading(NamedTuple):
    """A measure, and what it is of."""

    name: str
    args: Any
    """None; a skill (present), a region (reach), a `Window` (reward), two (change), steps (leader),
    a command's name (command), an `Opened`, or an `OfExperiment`."""

    @property
    def answers(self) -> Answers:
        """What it finds."""
        return PLAIN_MEASURES.get(self.name) or MEASURES_OF[self.name]


def _plain_measure(value: Any) -> str:
    if isinstance(value, str) and value in MEASURES_OF:
        raise ValueError(f"is a measure of something; allowed: {value}: OF WHAT in its place")
    return _known(PLAIN_MEASURES, "measure that stands alone")(value)


_PlainMeasure = Annotated[
    str, PlainValidator(_plain_measure), Field(description=", ".join(PLAIN_MEASURES))
]


class Measured(Spec):
    """A measure as a file states it."""

    measure: _PlainMeasure | None = None
    present: SkillName | None = None
    reach: _Reached | None = None
    reward: _Window | None = None
    change: (
        Annotated[tuple[_Window, _Window], Field(strict=False, description="two windows")] | None
    ) = None
    leader: Annotated[int, Field(ge=1, le=MAX_STEPS)] | None = None
    """Steps at which the leader of a race is asked for."""
    command: DeedName | None = None
    opened: _Opened | None = None
    experiment: OfExperiment | None = None

    @property
    def readings(self) -> tuple[Reading, ...]:
        """What is stated; one in a sound file, unless it is a check of several."""
        plain = () if self.measure is None else (Reading(self.measure, None),)
        stated = ((name, getattr(self, name)) for name in MEASURES_OF)
        return (*plain, *(Reading(name, of) for name, of in stated if of is not None))


OPERATORS: Final = ("above", "below", "between", "is")

_Number = Annotated[FiniteFloat, Field(ge=-1e12, le=1e12)]


def _word(value: Any) -> str | int:
    is_short = isinstance(value, str) and 0 < len(value) <= MAX_WORD
    is_number = isinstance(value, int) and not isinstance(value, bool)
    if not is_short and not is_number:
        raise ValueError(f"is nothing that a measure finds; allowed: {_WORDS}")
    return value


_WORDS: Final = "a word, or a whole number"
_Word = Annotated[str | int, PlainValidator(_word), Field(description=_WORDS)]


class Compared(Measured):
    """A measure, and what it is held against."""

    above: _Number | None = None
    below: _Number | None = None
    between: (
        Annotated[tuple[_Number, _Number], Field(strict=False, description="[lowest, highest]")]
        | None
    ) = None
    """Both ends belong to it."""
    equals: _Word | None = Field(None, alias="is")

    @property
    def operators(self) -> Mapping[str, Any]:
        """What is stated of them, by their names in a file."""
        found = {"above": self.above, "below": self.below, "between": self.between}
        stated = {**found, "is": self.equals}
        return {name: value for name, value in stated.items() if value is not None}

    def _mismatches(self, reading: Reading) -> list[Problem]:
        """What operators do not fit what a measure finds."""
        operators = self.operators
        allowed = {"number": OPERATORS, "word": ("is",), "yes": ()}[reading.answers]
        wrong = [name for name in operators if name not in allowed]
        if wrong:
            what = {"word": "finds a word", "yes": "is so or is not"}[reading.answers]
            fitting = ", ".join(allowed) or "none"
            message = f"does not fit {reading.name}, which {what}; allowed: {fitting}"
            return [Problem((name,), operators[name], message) for name in wrong]
        if self.between is not None and self.between[0] > self.between[1]:
            message = "is no range; allowed: [lowest, highest]"
            return [Problem(("between",), list(self.between), message)]
        return []


_Checks = Annotated[tuple["Check", ...], Field(strict=False, min_length=1)]


class Check(Compared):
    """What has to come true: of one measure, or of several checks."""

    by: At | None = None
    """Until when; None for whenever it may be."""
    holds_for: Annotated[int, Field(ge=1, le=MAX_TRIALS)] | None = Field(None, alias="for")
    """So many trials in a row; None where once is enough."""
    all_of: _Checks | None = Field(None, alias="all")
    any_of: _Checks | None = Field(None, alias="any")
    not_so: "Check | None" = Field(None, alias="not")

    @property
    def reading(self) -> Reading | None:
        """The measure that is looked at; None where it is a check of several."""
        return next(iter(self.readings), None)

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        several = {"all": self.all_of, "any": self.any_of, "not": self.not_so}
        parts = [name for name, part in several.items() if part is not None]
        stated = [*(reading.name for reading in self.readings), *parts]
        if len(stated) != 1:
            has = f"has {' and '.join(stated)}" if stated else "has nothing to look at"
            raise ValueError(f"{has}; allowed: one measure, or all, any or not")
        if parts:
            wrong = self.operators
            message = f"belongs to a measure, not to {parts[0]}; allowed: within it"
            problems = [Problem((name,), value, message) for name, value in wrong.items()]
        else:
            (reading,) = self.readings
            problems = self._mismatches(reading)
            if reading.answers != "yes" and not self.operators:
                message = (
                    f"holds {reading.name} against nothing; allowed: one of {', '.join(OPERATORS)}"
                )
                raise ValueError(message)
            if reading.args == EACH_OCTANT:
                message = "is of octants that are predicted; allowed: a region"
                problems.append(Problem((reading.name,), reading.args, message))
        if problems:
            raise ProblemsError(problems)
        return self


class Reveal(Compared):
    """What a prediction is held against: a measure, at a moment.

    Operators belong to a moment that is predicted, which is when it first came true, to octants,
    and to a choice of *yes* and *no*.
    """

    at: At | None = None
    """When it is looked at; None for the end of what the card runs to."""

    @property
    def reading(self) -> Reading:
        """The measure that is looked at."""
        return self.readings[0]

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        if len(self.readings) != 1:
            names = " and ".join(reading.name for reading in self.readings)
            raise ValueError(f"has {names or 'no measure'}; allowed: one measure")
        if problems := self._mismatches(self.reading):
            raise ProblemsError(problems)
        return self
