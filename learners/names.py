"""The words of a preset: what numbers and names in it may be, and how a message lists names."""

import difflib
from collections.abc import Iterable
from itertools import islice
from typing import Annotated, Final, Literal

from pydantic import BeforeValidator, Field

from sim.spec import FiniteFloat

MAX_TRIALS = 2_000_000
"""Trials a run may have: its log takes 33 bytes for each."""

MAX_VALUE: Final = 1e6
"""Size of a value that a preset may name."""

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

Script = Literal["flank"]
"""Policies that teach, see ``learners.policies.taught``."""

MOVES = "moves"
COMMANDS = "commands"
INTRODUCTION = "introduction"

SEARCH: Final = "search"
COMMAND_NAMES: Final = ("counterclockwise", "clockwise", "inwards", "outwards", SEARCH)
"""What the manager of a feudal learner may command, in the order of its options."""

_MOST_NAMES: Final = 40


def listed(names: Iterable[str]) -> str:
    """Names in a message: all of them, or as many as anyone would read."""
    first = list(islice(names, _MOST_NAMES + 1))
    return ", ".join(first if len(first) <= _MOST_NAMES else [*first[:_MOST_NAMES], "…"])


def did_you_mean(word: object, names: Iterable[str]) -> str:
    """A hint at the nearest of the first names; empty if none is near."""
    nearest = difflib.get_close_matches(str(word)[:80], list(islice(names, _MOST_NAMES)), n=1)
    return f" (did you mean {nearest[0]}?)" if nearest else ""


def _truth(value: object) -> object:
    if not isinstance(value, bool):
        raise ValueError("must be true or false; allowed: true, false")
    return value


Truth = Annotated[bool, BeforeValidator(_truth)]
