"""What a lesson's cards ask (validated, frozen), and the texts that people read on them."""

import re
from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal, cast

from pydantic import AfterValidator, Field, PlainValidator

from app.documents.lesson_grammar import OCTANTS, Reveal
from learners.names import MAX_TRIALS, Truth, did_you_mean
from sim.spec import FiniteFloat, Problem, ProblemsError, Spec

MAX_WORDS: Final = 45
"""Of a card, in any language."""
MAX_TEXT: Final = 1_000
MAX_OPTIONS: Final = 8
HANDLES: Final = 6
"""Of a curve that is sketched."""

# --- Texts ---------------------------------------------------------------------------------------

_OBEYED: Final = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ufffe\uffff]")
"""Control characters, and what turns the direction of writing for all that follows."""


def readable(text: str) -> str:
    if not text.strip():
        raise ValueError("is empty; allowed: a text")
    if found := _OBEYED.search(text):
        character = f"U+{ord(found[0]):04X}"
        raise ValueError(f"contains the control character {character}; allowed: what can be read")
    return text


def n_words(text: str) -> int:
    """Words of a text as a reader counts them: signs alone are none."""
    return sum(any(map(str.isalnum, word)) for word in text.split())


Text = Annotated[str, Field(max_length=MAX_TEXT), AfterValidator(readable)]
"""What people read, with ``**bold**`` and `` `code` `` as its only markup."""
Label = Annotated[str, Field(max_length=100), AfterValidator(readable)]
Id = Annotated[
    str,
    Field(
        pattern=r"^[a-z][a-z0-9_]*$",
        max_length=32,
        description="a name of up to 32 characters from a-z, 0-9 and _ that starts with a letter",
    ),
]


def each_once(stated: tuple[str, ...]) -> tuple[str, ...]:
    twice = [(n, item) for n, item in enumerate(stated) if item in stated[:n]]
    if twice:
        message = "is there twice; allowed: each once"
        raise ProblemsError([Problem((n,), item, message) for n, item in twice])
    return stated


# --- What is asked -------------------------------------------------------------------------------

QUESTIONS: Final[Mapping[str, str]] = {
    "choice": "one of several",
    "number": "a number",
    "direction": "which way, of several",
    "sectors": "octants of the board",
    "moment": "a trial, on the time bar",
    "sketch": "a curve of six handles",
    "order": "several, in their order",
}
"""Kinds of predictions, and in words what is answered."""
_WITH_OPTIONS: Final = ("choice", "direction", "order")

BELONG: Final[Mapping[str, tuple[str, ...]]] = {
    "options": _WITH_OPTIONS,
    "values": _WITH_OPTIONS,
    "low": ("number", "sketch"),
    "high": ("number", "sketch"),
    "unit": ("number",),
    "from": ("sketch", "moment"),
    "to": ("sketch", "moment"),
}
"""Of which questions a key is that not all have."""

QuestionKind = Literal["choice", "number", "direction", "sectors", "moment", "sketch", "order"]
_Key = str | int | float | tuple[str, ...]


def _right(value: Any) -> _Key:
    if isinstance(value, list):
        items = cast("list[Any]", value)
        if items and len(items) <= MAX_OPTIONS and all(isinstance(item, str) for item in items):
            return tuple(items)
    elif isinstance(value, str | int | float) and not isinstance(value, bool):
        return value
    raise ValueError(f"is no answer; allowed: {_ANSWERS}")


_ANSWERS: Final = "a text, a number, or a list of texts"
_Options = Annotated[tuple[Label, ...], Field(strict=False, min_length=2, max_length=MAX_OPTIONS)]


class Asked(Spec):
    """What somebody is to predict."""

    ask: QuestionKind | None = None
    text: Text | None = None
    options: Annotated[_Options, AfterValidator(each_once)] | None = None
    """As people read them."""
    values: Annotated[_Options, AfterValidator(each_once)] | None = None
    """What the measure says of each option where it is right; the options where not given."""
    low: FiniteFloat | None = None
    high: FiniteFloat | None = None
    unit: Label | None = None
    """Of a number."""
    first: Annotated[int, Field(ge=0, le=MAX_TRIALS)] | None = Field(None, alias="from")
    """First trial of what is predicted on the axis of trials."""
    end: Annotated[int, Field(ge=1, le=MAX_TRIALS)] | None = Field(None, alias="to")
    confidence: Truth = False
    """Whether 50, 70 or 90 per cent are asked for."""
    reveal: Reveal | None = None
    key: Annotated[_Key, PlainValidator(_right), Field(description=_ANSWERS)] | None = None
    """What is right, if that does not come from the measure."""
    varies: Truth = False
    """Whether it is right in some runs and not in others; then nothing is proved of it."""

    @property
    def choices(self) -> tuple[tuple[str, str], ...]:
        """The options, each as its value and the words for it; octants for sectors."""
        if self.ask == "sectors":
            return tuple((octant, octant) for octant in OCTANTS)
        return tuple(zip(self.values or self.options or (), self.options or (), strict=True))

    def misfits(self) -> list[Problem]:
        """What does not go together in a question."""
        problems = [*self._out_of_place(), *self._misplaced_options(), *self._ranges()]
        return problems or [*self._wrong_reveal(), *self._wrong_key()]

    def _out_of_place(self) -> list[Problem]:
        stated = {
            name: getattr(self, {"from": "first", "to": "end"}.get(name, name)) for name in BELONG
        }
        return [
            Problem((name,), value, f"does not belong to {self.ask}; allowed: {', '.join(kinds)}")
            for name, kinds in BELONG.items()
            if (value := stated[name]) is not None and self.ask not in kinds
        ]

    def _misplaced_options(self) -> list[Problem]:
        if self.text is None:
            return [Problem(("text",), ..., "is missing; allowed: a text")]
        if self.ask in _WITH_OPTIONS and self.options is None:
            message = f"is missing; allowed: 2 to {MAX_OPTIONS} texts"
            return [Problem(("options",), ..., message)]
        if self.values is not None and len(self.values) != len(self.options or ()):
            message = f"has {len(self.values)} items; allowed: one for each of the options"
            return [Problem(("values",), list(self.values), message)]
        return []

    def _ranges(self) -> list[Problem]:
        needed = {"number": ("low", "high"), "sketch": ("from", "to")}.get(self.ask or "", ())
        ends = {"low": self.low, "high": self.high, "from": self.first, "to": self.end}
        lacking = [name for name in needed if ends[name] is None]
        if lacking:
            return [Problem((name,), ..., "is missing; allowed: a number") for name in lacking]
        problems = [
            Problem((after,), ends[after], f"must be more than {before}, {ends[before]}")
            for before, after in (("low", "high"), ("from", "to"))
            if (low := ends[before]) is not None
            and (high := ends[after]) is not None
            and high <= low
        ]
        first, end = self.first or 0, self.end or 0
        if self.ask == "sketch" and not problems and end - first < HANDLES - 1:
            message = f"leaves no trial for each handle; allowed: from {first + HANDLES - 1} on"
            problems.append(Problem(("to",), end, message))
        return problems

    def _wrong_reveal(self) -> list[Problem]:
        if self.reveal is None:
            if self.key is None:
                message = "has nothing to reveal; allowed: reveal, or key"
                return [Problem(("ask",), self.ask, message)]
            return []
        reading = self.reveal.reading
        finds, compares = reading.answers, bool(self.reveal.operators)
        fits = {
            "choice": finds != "number" or compares,
            "number": finds == "number" and not compares,
            "direction": finds == "word" and not compares,
            "sectors": (reading.name, reading.args, compares) == ("reach", "octants", True),
            "moment": finds == "yes" or compares,
            "sketch": reading.name == "reward" and reading.args.last is not None,
            "order": reading.name == "experiment" and not compares,
        }
        if not fits[self.ask or "choice"]:
            said = {
                "choice": "a word, or a measure with an operator",
                "number": "a measure that finds a number",
                "direction": "a measure that finds a word",
                "sectors": "reach: octants, with an operator",
                "moment": "a measure with an operator",
                "sketch": "reward, of so many of the last trials",
                "order": "experiment",
            }
            message = f"does not answer {self.ask}; allowed: {said[self.ask or 'choice']}"
            return [Problem(("reveal",), reading.name, message)]
        if self.ask != "sectors" and reading.args == "octants":
            message = "is of octants that are predicted; allowed: a region"
            return [Problem(("reveal", "reach"), "octants", message)]
        return []

    def _wrong_key(self) -> list[Problem]:
        key, values = self.key, [value for value, _ in self.choices]
        if key is None:
            return []
        match self.ask:
            case "choice" | "direction":
                fits, allowed = key in values, ", ".join(values)
            case "sectors":
                fits = isinstance(key, tuple) and set(key) <= set(values)
                allowed = f"a list from {', '.join(values)}"
            case "order":
                fits = isinstance(key, tuple) and sorted(key) == sorted(values)
                allowed = f"a list of all of {', '.join(values)}"
            case "number":
                fits = isinstance(key, int | float) and (self.low or 0) <= key <= (self.high or 0)
                allowed = f"{self.low:g} to {self.high:g}"
            case "moment":
                fits = isinstance(key, int) and 0 <= key <= MAX_TRIALS
                allowed = f"a trial from 0 to {MAX_TRIALS}"
            case _:
                fits, allowed = False, "reveal instead of it"
        if fits:
            return []
        hint = did_you_mean(key, values) if isinstance(key, str) else ""
        shown = list(key) if isinstance(key, tuple) else key
        return [Problem(("key",), shown, f"is not among the answers{hint}; allowed: {allowed}")]
