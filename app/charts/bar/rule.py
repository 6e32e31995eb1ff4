"""What rules watch, as data under the learning curve: how it goes, and where it lets a skill join.

Places are told in trials, as those of blocks are. Heights are logarithms: what is watched falls by
the same share again and again, and the threshold is a small part of where it began.
"""

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from app.live.snapshot import Snapshot
from app.live.watched import NEVER, Watched
from app.words.plain import named
from learners.schedule_spec import TriggerSpec

_BELOW: Final = 3.0
"""By so much the scale goes on below a threshold, as a factor."""
_ABOVE: Final = 10.0
"""The scale goes as far above it at least."""
_WATCHED: Final = {
    "novelty": ("new states", "per trial"),
    "reach": ("states reached", "per trial"),
    "change": ("change of value", "per step"),
}
"""What is watched, in a few words and on two lines."""


class Rule(NamedTuple):
    """A stretch in which a rule was waited for, or is."""

    skill: str
    """That joins by it."""
    first: int
    """The first trial that counts."""
    known: int
    """The trial before which its first window has ended."""
    until: int | None
    """The trial in which it was over; None if it is waited for."""
    met: bool
    """Whether it was met, and the skill joined by that."""
    below: float
    """The threshold."""
    trials: np.ndarray
    """(point,) int64: those before which it is known."""
    values: np.ndarray
    """(point,) float64: what is watched."""
    fires: np.ndarray
    """(point,) int64: when it would be met if it fell on as it did; ``NEVER`` if it did not."""
    ends: tuple[float, float]
    """Of the scale: what is seen lies between them."""
    what: tuple[str, str]
    """What is watched."""
    short: tuple[str, str]
    """Who joins, and below which number, in as few words as can be."""
    long: str
    """The same in a sentence that explains it."""


def rules_of(watched: Sequence[Watched], last: int | None = None) -> tuple[Rule, ...]:
    """What rules watched, one after the other.

    Args:
        watched: what there is of it.
        last: the trial after which nothing is to be seen; None if all is.
    """
    if last is not None:
        watched = [_seen(one, last) for one in watched if one.since <= last]
    return tuple(_rule(one, watched) for one in watched)


def _seen(one: Watched, last: int) -> Watched:
    """What there was of it in a trial."""
    shown = one.trials <= last
    return one._replace(
        until=None if one.until is None or one.until > last else one.until,
        trials=one.trials[shown],
        values=one.values[shown],
        fires=one.fires[shown],
    )


def _rule(one: Watched, all_of_them: Sequence[Watched]) -> Rule:
    alike = [other.values for other in all_of_them if other.rule == one.rule]
    low, high = _ends(one.rule.below, np.concatenate(alike))
    return Rule(
        skill=one.skill,
        first=one.since,
        known=one.since + one.rule.window,
        until=one.until,
        met=_is_met(one),
        below=one.rule.below,
        trials=one.trials,
        values=one.values,
        fires=one.fires,
        ends=(low, high),
        what=_WATCHED[one.rule.by],
        short=(named(one.skill), f"joins below {one.rule.below:g}"),
        long=long_of(one.skill, one.rule),
    )


def _is_met(one: Watched) -> bool:
    return (
        one.trials.size > 0
        and one.until == one.trials[-1]
        and bool(one.values[-1] < one.rule.below)
    )


def _ends(below: float, values: np.ndarray) -> tuple[float, float]:
    """Ends of the scale, both above 0."""
    positive = values[values > 0]
    threshold = below or float(positive.min(initial=1.0))
    highest = float(positive.max(initial=0.0))
    return threshold / _BELOW, max(highest * 1.1, threshold * _ABOVE * 1.1)


def long_of(skill: str, rule: TriggerSpec) -> str:
    """When a rule lets a skill join, in words."""
    window, below = f"the last {rule.window:,} trials", f"{rule.below:g}"
    if rule.by == "change":
        return f"{named(skill)} joins when values change by less than {below} a step in {window}"
    what = "visit" if rule.by == "novelty" else "give value to"
    return f"{named(skill)} joins when {window} {what} fewer than {below} new states a trial"


def outlook_in_words(watched: Watched, is_now: bool = True) -> str:
    """What a rule watches at the newest of its places, and when it would be met."""
    when, that = ("now", "this") if is_now else ("then", "that")
    if not watched.trials.size:
        return f"known from trial {watched.since + watched.rule.window:,} on"
    fires = int(watched.fires[-1])
    rate = "not falling" if fires == NEVER else f"at {that} rate at trial {fires:,}"
    return f"{shown_value(float(watched.values[-1]))} {when}; {rate}"


def shown_value(value: float) -> str:
    """What is watched as a number of two digits, as the scripts write it."""
    return f"{float(f'{value:.2g}'):g}"


def watched_at(snapshot: Snapshot) -> dict[str, Any] | None:
    """What a rule watches at a moment, as the scripts take it; None while none is known.

    Of what was watched along a run, only some places are sent with the bar.
    """
    one = next((one for one in snapshot.watched if one.until is None), None)
    if one is None or not one.trials.size:
        return None
    trial, fires = int(one.trials[-1]), int(one.fires[-1])
    return {"trial": trial, "value": float(one.values[-1]), "fires": fires}
