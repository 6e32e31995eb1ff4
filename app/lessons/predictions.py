"""What people predict: an answer as it comes from a page, and how it compares with what came.

Nobody loses to luck. What one run does is partly chance, so an answer is held against this run and
twenty that differ by their seeds alone: it is *within* what they do or not, and there is no
mark. What counts as within:

- ``choice`` and ``direction``: what happened in this run, or in at least one of ten others;
- ``number`` and ``moment``: between the least and the largest of all runs;
- ``sectors``: it has every octant that nearly all runs have, and none that nearly none has;
- ``sketch``: at least four of six handles lie between the lowest and the highest curve;
- ``order``: no two options the wrong way round of which nearly all runs agree.

Nearly all are 19 of 20. Where the lesson states a key, what is right does not hang on any run; a
number may then be off by a twentieth of its scale.
"""

import itertools
import math
from collections.abc import Sequence
from typing import Any, Final, NamedTuple, cast

import numpy as np

from app.documents.lesson_grammar import OCTANTS
from app.documents.lesson_questions import HANDLES, Asked
from app.lessons.reveals import Answer
from app.lessons.spread import Spread, points_of
from app.lessons.words import IN_ENGLISH, Words
from learners.names import MAX_TRIALS

NEARLY_ALL: Final = 0.95
"""Share of the runs that a thing is true of, if nobody is to doubt it."""
SOME: Final = 0.1
"""Share of the runs in which something happened, if it could as well have been this one."""
HANDLES_WITHIN: Final = 4
"""Of these, so many at least lie within what runs do, if the sketch does."""
_MOST_REWARD: Final = 1e9
OFF: Final = 1 / 20
"""Of the scale of a number: how far off a key it may be."""


# --- Answers -------------------------------------------------------------------------------------


def answer_of(asked: Asked, value: Any) -> Answer:
    """An answer as a page sent it, or as it was kept.

    Args:
        asked: the question.
        value: decoded JSON.

    Raises:
        ValueError: it is no answer to the question.
    """
    match asked.ask:
        case "choice" | "direction":
            return _option(asked, value)
        case "number":
            return _number(value, asked.low or 0.0, math.inf if asked.high is None else asked.high)
        case "moment":
            first = float(asked.first or 0)
            return _number(value, first, float(MAX_TRIALS if asked.end is None else asked.end))
        case "sectors":
            octants = set(_texts(value, OCTANTS))
            return tuple(octant for octant in OCTANTS if octant in octants)
        case "order":
            values = [value for value, _ in asked.choices]
            order = _texts(value, values)
            if len(order) != len(values):
                raise ValueError("is no order of all options")
            return order
        case _:
            return _sketched(asked, value)


def _option(asked: Asked, value: Any) -> str:
    values = [value for value, _ in asked.choices]
    if not isinstance(value, str) or value not in values:
        raise ValueError("is none of the options")
    return value


def _number(value: Any, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ValueError("is no number of that scale")
    return float(value)


def _texts(value: Any, allowed: Sequence[str]) -> tuple[str, ...]:
    items = cast("list[Any]", value) if isinstance(value, list | tuple) else []
    is_known = all(isinstance(item, str) and item in allowed for item in items)
    if not isinstance(value, list | tuple) or not is_known or len(set(items)) != len(items):
        raise ValueError("is no list of what there is to choose")
    return tuple(items)


def _sketched(asked: Asked, value: Any) -> tuple[tuple[float, float], ...]:
    items = cast("list[Any]", value) if isinstance(value, list | tuple) else []
    if len(items) != HANDLES:
        raise ValueError(f"does not have {HANDLES} points")
    points: list[tuple[float, float]] = []
    for item in items:
        pair = cast("list[Any]", item) if isinstance(item, list | tuple) else []
        if len(pair) != 2:
            raise ValueError("has a point that is no pair")
        trial = _number(pair[0], float(asked.first or 0), float(asked.end or MAX_TRIALS))
        points.append((trial, _number(pair[1], -_MOST_REWARD, _MOST_REWARD)))
    if any(after[0] <= before[0] for before, after in itertools.pairwise(points)):
        raise ValueError("does not go from left to right")
    return tuple(points)


# --- Against what came ---------------------------------------------------------------------------


class Scored(NamedTuple):
    """How an answer compares with what came."""

    within: bool | None
    """Whether it is within what runs do; None if there is nothing to compare it with."""
    words: str
    """A sentence or two on what came, with a capital and a full stop."""


def scored(
    asked: Asked, answer: Answer, own: Answer, spread: Spread, words: Words = IN_ENGLISH
) -> Scored:
    """How an answer compares with this run and others.

    Args:
        asked: the question, in the language that is read.
        answer: what was predicted.
        own: what this run answers; None if it has no answer.
        spread: what others do; of no runs while they are not known.
        words: in which it is told.
    """
    if asked.key is not None and answer is not None:
        return _by_key(asked, answer, words)
    runs = spread if own is None else Spread((own, *spread.answers))
    if answer is None or not runs.n_answered:
        return Scored(None, words.say("score.no_answer"))
    match asked.ask:
        case "choice" | "direction":
            return _chosen(asked, answer, own, spread, words)
        case "number" | "moment":
            return _numbered(asked, answer, own, spread, words)
        case "sectors":
            return _sectors(answer, own, spread, words)
        case "order":
            return _ordered(asked, answer, own, spread, words)
        case _:
            return _drawn(answer, runs, words)


def is_right(asked: Asked, answer: Answer) -> bool:
    """Whether what a run answers is what the lesson states as the key."""
    key = asked.key
    if asked.ask == "sectors" and isinstance(key, tuple) and isinstance(answer, tuple):
        return set(key) == set(answer)
    if isinstance(key, int | float) and isinstance(answer, int | float):
        scale = abs((asked.high or 0.0) - (asked.low or 0.0))
        return abs(key - answer) <= OFF * scale
    return key == answer


def _by_key(asked: Asked, answer: Answer, words: Words) -> Scored:
    key = asked.key
    if isinstance(key, tuple):
        said = words.listed([_label(asked, str(value), words) for value in key])
    elif isinstance(key, int | float):
        said = words.written(f"{key:g}")
    else:
        said = _label(asked, str(key), words)
    return Scored(is_right(asked, answer), words.say("score.key", what=said))


def _label(asked: Asked, value: str, words: Words) -> str:
    if asked.ask == "sectors":
        return words.octant(value)
    return dict(asked.choices).get(value, value)


def _chosen(asked: Asked, answer: Answer, own: Answer, spread: Spread, words: Words) -> Scored:
    n = spread.counts.get(str(answer), 0)
    within = answer == own or (n > 0 and n >= SOME * spread.n)
    said: list[str] = []
    if own is not None:
        said.append(words.say("score.own", what=_label(asked, str(own), words)))
    if spread.n:
        ranked = sorted(spread.counts.items(), key=lambda item: -item[1])
        each = [
            f"{_label(asked, value, words)} {words.counted('in_of', spread.n, k=count)}"
            for value, count in ranked
        ]
        said.append(words.say("score.all", what=words.listed(each)))
    return Scored(within, " ".join(said))


def _numbered(asked: Asked, answer: Answer, own: Answer, spread: Spread, words: Words) -> Scored:
    band = spread.band
    all_of_them = (spread if own is None else Spread((own, *spread.answers))).band
    assert all_of_them is not None
    assert isinstance(answer, int | float)
    within = all_of_them.low <= answer <= all_of_them.high
    said: list[str] = []
    if isinstance(own, int | float):
        said.append(words.say("score.own", what=_measured(asked, own, words)))
    elif own is None and asked.ask == "moment":
        said.append(words.say("score.own_never"))
    if band is not None:
        ends = words.say("score.always")
        if band.low < band.high:
            ends = words.say("score.range", low=band.low, high=band.high)
        runs = words.counted("runs", spread.n)
        median = _measured(asked, band.median, words)
        said.append(words.say("score.spread", runs=runs, what=median, range=ends))
    missing = spread.n - spread.n_answered
    if missing and asked.ask == "moment":
        said.append(words.counted("score.never", spread.n, k=missing))
    return Scored(within, " ".join(said))


def _measured(asked: Asked, number: float, words: Words) -> str:
    """A number that was asked for, with its unit; of one alone without the word, which lessons have
    in the plural."""
    if asked.ask == "moment":
        return words.say("trial", trial=number)
    unit = "" if asked.unit is None or (number == 1 and asked.unit.isalpha()) else asked.unit
    return f"{words.number(number)} {unit}".rstrip()


def _sectors(answer: Answer, own: Answer, spread: Spread, words: Words) -> Scored:
    chosen = {str(item) for item in answer} if isinstance(answer, tuple) else set[str]()
    in_own = {str(item) for item in own} if isinstance(own, tuple) else None
    n_runs = spread.n_answered + (in_own is not None)
    missed, wrong = 0, 0
    for octant in OCTANTS:
        n = spread.counts.get(octant, 0) + (in_own is not None and octant in in_own)
        missed += n >= NEARLY_ALL * n_runs and octant not in chosen
        wrong += n <= (1 - NEARLY_ALL) * n_runs and octant in chosen
    said = [words.counted("score.missed", missed)] * (missed > 0)
    said += [words.counted("score.wrong", wrong)] * (wrong > 0)
    return Scored(not said, " ".join(said or [words.say("score.octants")]))


def _drawn(answer: Answer, runs: Spread, words: Words) -> Scored:
    curve, points = runs.curve, points_of(answer)
    if curve is None or not points:
        return Scored(None, words.say("score.no_curve"))
    trials = [trial for trial, _ in points]
    low, high = np.interp(trials, curve.at, curve.low), np.interp(trials, curve.at, curve.high)
    n = sum(
        bool(lowest <= reward <= highest)
        for (_, reward), lowest, highest in zip(points, low, high, strict=True)
    )
    key = "score.point" if n == 1 else "score.points"
    said = words.counted(key, runs.n, k=n, points=len(points))
    return Scored(n >= HANDLES_WITHIN, said)


def _ordered(asked: Asked, answer: Answer, own: Answer, spread: Spread, words: Words) -> Scored:
    order = [str(item) for item in answer] if isinstance(answer, tuple) else []
    runs = spread if spread.n else Spread((own,))
    pairs = [(one, other) for place, one in enumerate(order) for other in order[place + 1 :]]
    sure = [pair for pair in pairs if abs(runs.share_before(*pair) - 0.5) >= NEARLY_ALL - 0.5]
    wrong = [pair for pair in sure if runs.share_before(*pair) < 0.5]
    if not sure:
        return Scored(True, words.say("score.no_pairs"))
    said: list[str] = []
    if isinstance(own, tuple):
        labels = [_label(asked, str(value), words) for value in own]
        said.append(words.say("score.own", what=", ".join(labels)))
    said.append(words.counted("score.pairs", len(sure), k=len(sure) - len(wrong)))
    return Scored(not wrong, " ".join(said))
