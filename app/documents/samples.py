"""Random search: a number of draws, each with a value of its own for every key that is varied.

Draw after draw, and in each draw key after key in the order of the file, a number from 0 up to 1 is
taken from NumPy's PCG64 generator, which the sample's seed starts, and placed in what the key
allows: evenly between the ends of a range, evenly on a scale of ratios between those of a
logarithmic one, or as the place in a list. So a file makes the same draws everywhere, and with a
higher count the first ones stay what they are. A draw that is there already is drawn again.
"""

import math
import re
from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Final, NamedTuple, Self, cast

import numpy as np
from pydantic import Field, PlainValidator, model_validator

from app.documents.ranges import Finite, Number
from app.documents.tree import Key, key_of
from sim.rng import MAX_SEED
from sim.spec import Problem, ProblemsError, Spec

MAX_DRAWS: Final = 10_000

_LEAST_WIDTH: Final = 1e-6
"""Of a range, as a share of its larger end: numbers in it are to differ in their digits."""
_LEAST_RATIO: Final = 1.1
"""Of the ends of a logarithmic range, for the same reason."""
_ALLOWED: Final = (
    "a list of values, {start, stop}, {log_start, log_stop},"
    " or {same_as: another key of the sample}"
)


def label_of(number: int) -> str:
    """What a draw is called: the first is number 1."""
    return f"draw {number}"


def is_draw(label: str) -> bool:
    """Whether a variant of such a label was drawn; results keep no other word of it."""
    return any(re.fullmatch(r"draw \d+", part) for part in label.split(", "))


class Between(Spec):
    """Any number between two ends, which belong to it; whole ones where both ends are whole."""

    start: Finite
    stop: Finite

    @model_validator(mode="after")
    def _is_wide_enough(self) -> Self:
        if self.start >= self.stop:
            raise ValueError("is no range; allowed: start below stop")
        largest = max(abs(self.start), abs(self.stop))
        if not self.is_whole and self.stop - self.start < _LEAST_WIDTH * largest:
            raise ValueError("is too narrow to draw from; allowed: ends that are farther apart")
        return self

    @property
    def is_whole(self) -> bool:
        """Whether whole numbers are drawn."""
        return isinstance(self.start, int) and isinstance(self.stop, int)

    @property
    def size(self) -> float:
        """How many numbers there are; infinite where they need not be whole."""
        return self.stop - self.start + 1 if self.is_whole else math.inf

    def at(self, share: float) -> Number:
        """The number at a place, 0 up to 1, in the range."""
        width = self.stop - self.start
        if self.is_whole:
            return min(self.start + math.floor(share * (width + 1)), self.stop)
        # With four or five digits that make a difference, as one would write it.
        found = round(self.start + share * width, 4 - math.floor(math.log10(width)))
        return float(min(max(found, self.start), self.stop))


class LogBetween(Spec):
    """The same on a scale of ratios: as often between 1 and 10 as between 10 and 100."""

    log_start: Finite
    log_stop: Finite

    @model_validator(mode="after")
    def _is_wide_enough(self) -> Self:
        if not 0 < self.log_start < self.log_stop:
            raise ValueError("is no range; allowed: 0 < log_start < log_stop")
        if not self.is_whole and self.log_stop < _LEAST_RATIO * self.log_start:
            message = f"log_stop at least {_LEAST_RATIO} times log_start"
            raise ValueError(f"is too narrow to draw from; allowed: {message}")
        return self

    @property
    def is_whole(self) -> bool:
        """Whether whole numbers are drawn."""
        return isinstance(self.log_start, int) and isinstance(self.log_stop, int)

    @property
    def size(self) -> float:
        """How many numbers there are; infinite where they need not be whole."""
        return self.log_stop - self.log_start + 1 if self.is_whole else math.inf

    def at(self, share: float) -> Number:
        """The number at a place, 0 up to 1, in the range."""
        first, last = self.log_start, self.log_stop
        if self.is_whole:
            # Up to the one after the last, so that the last is drawn as well.
            return min(math.floor(first * ((last + 1) / first) ** share), int(last))
        found = float(f"{first * (last / first) ** share:.6g}")
        return float(min(max(found, first), last))


class SameAs(Spec):
    """Whatever another key of the sample has in the same draw."""

    same_as: str


class Item(NamedTuple):
    """A value of a list, by its place."""

    place: int


Drawn = Number | Item
_Values = list[Any] | Between | LogBetween | SameAs


def _values(value: Any) -> _Values:
    if isinstance(value, list) and value:
        items = cast("list[Any]", value)
        written = list(map(repr, items))
        twice = [place for place, text in enumerate(written) if text in written[:place]]
        if twice:
            message = "is there twice; allowed: each once"
            raise ProblemsError([Problem((place,), items[place], message) for place in twice])
        return items
    for kind in (Between, LogBetween, SameAs):
        if isinstance(value, dict) and value.keys() == kind.model_fields.keys():
            return kind.model_validate(value)
    raise ValueError(f"has nothing to draw from; allowed: {_ALLOWED}")


class Sample(Spec):
    """Draws of a random search, each one choice of values for all of its keys."""

    count: Annotated[int, Field(ge=1, le=MAX_DRAWS)]
    """Draws, no two of them alike."""
    seed: Annotated[int, Field(ge=0, le=MAX_SEED)] = 0
    """Of the draws; it has nothing to do with the seeds of runs."""
    keys: Annotated[
        dict[Annotated[Key, PlainValidator(key_of)], Annotated[_Values, PlainValidator(_values)]],
        Field(min_length=1, description="keys of presets"),
    ]
    """What each key is drawn from."""

    @model_validator(mode="after")
    def _can_be_drawn(self) -> Self:
        problems: list[Problem] = []
        for key, values in self.keys.items():
            if isinstance(values, SameAs) and not self._is_drawn(values.same_as):
                drawn = (".".join(map(str, key)) for key in self._drawn)
                message = f"is not drawn; allowed: {', '.join(drawn) or 'none, as nothing is'}"
                name = ".".join(map(str, key))
                problems.append(Problem(("keys", name, "same_as"), values.same_as, message))
        n_all = math.prod(map(_size, self._drawn.values()))
        if not problems and self.count > n_all:
            message = f"is more than there are different draws; allowed: 1 to {n_all:.0f}"
            problems.append(Problem(("count",), self.count, message))
        if problems:
            raise ProblemsError(problems)
        return self

    @property
    def _drawn(self) -> dict[Key, list[Any] | Between | LogBetween]:
        """What is drawn by itself, in the order of the file."""
        return {key: of for key, of in self.keys.items() if not isinstance(of, SameAs)}

    def _is_drawn(self, name: str) -> bool:
        return tuple(name.split(".")) in self._drawn

    def draws(self) -> Iterator[Sequence[Drawn]]:
        """Each draw as a value for every key, in the order of the keys."""
        drawn = self._drawn
        rng = np.random.Generator(np.random.PCG64(self.seed))
        seen: set[tuple[Drawn, ...]] = set()
        while len(seen) < self.count:
            shares = rng.random(len(drawn)).tolist()
            found = tuple(map(_placed, drawn.values(), shares))
            if found in seen:
                continue
            seen.add(found)
            own = dict(zip(drawn, found, strict=True))
            yield [
                own[tuple(of.same_as.split("."))] if isinstance(of, SameAs) else own[key]
                for key, of in self.keys.items()
            ]


def _size(values: list[Any] | Between | LogBetween) -> float:
    return len(values) if isinstance(values, list) else values.size


def _placed(values: list[Any] | Between | LogBetween, share: float) -> Drawn:
    if isinstance(values, list):
        return Item(math.floor(share * len(values)))
    return values.at(share)
