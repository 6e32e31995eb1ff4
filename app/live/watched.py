"""What rules watch along a run, as it is drawn: each stretch in which one was waited for.

A rule lets the next skill join once what it watches falls below a threshold
(:mod:`learners.triggers.watch`). Of each skill that joins by one, or is to, this is the course of
that, with what the rule's outlook was at each place: so whoever looks at an earlier moment sees
what was known there.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from learners.commands import DefineSkill, Event, FollowSchedule, Introduce, Remove, SetSchedule
from learners.control import Awaited, Control, awaited, evolve
from learners.run import Run
from learners.schedule_spec import TriggerSpec
from learners.triggers.watch import Statistic, outlook_of, statistic, watch_for

MOST_POINTS: Final = 200
"""Of each stretch."""
_MATTER: Final = (Introduce, Remove, SetSchedule, FollowSchedule, DefineSkill)
"""Commands after which another rule, or none, may be waited for."""
NEVER: Final = -1


class Watched(NamedTuple):
    """What a rule watched while its skill was the next one to join."""

    skill: str
    rule: TriggerSpec
    since: int
    """The first trial that it looks at."""
    until: int | None
    """The trial in which it was over: the skill joined, be it by hand, or something else was waited
    for from then on; None if it is waited for."""
    trials: np.ndarray
    """(point,) int64: trials before which it is known, the newest last."""
    values: np.ndarray
    """(point,) float64: its mean over the window that ends there."""
    fires: np.ndarray
    """(point,) int64: trial in which the rule would be met if it went on to fall as it did there,
    see :func:`learners.triggers.watch.outlook`; ``NEVER`` where it did not."""

    @property
    def key(self) -> tuple[str, TriggerSpec, int]:
        """What is watched, and from when on."""
        return self.skill, self.rule, self.since


def watched_along(run: Run, former: Sequence[Watched] = ()) -> tuple[Watched, ...]:
    """What rules have watched along a run so far, the one that is waited for last.

    Args:
        run: the run.
        former: what was found of it earlier, whose points stay.
    """
    control = run.control
    by_key = {watched.key: watched for watched in former}
    if not _has_rules(control):
        return ()
    found = [
        _watched(run, waited, until, by_key.get(_key(waited))) for waited, until in _waits(control)
    ]
    return tuple(one for one in found if one.until is None or one.trials.size)


def _has_rules(control: Control) -> bool:
    """Whether a skill joined by a rule, or can; it takes a while to look at all commands."""
    specs = control.preset, control.spec
    return any(
        spec.schedule.rule_of(skill) is not None for spec in specs for skill in spec.learner.skills
    ) or any(event.author == "trigger" for event in control.history)


def _waits(control: Control) -> Iterator[tuple[Awaited, int | None]]:
    """What was waited for, each with the trial in which that was over.

    What has been taken back counts as not done, as it does for the rules.
    """
    held = Control.at_start(control.preset)
    waited = awaited(held)
    for event in _that_hold(control.history):
        held = evolve(held, event)
        now = awaited(held)
        if (now and _key(now)) != (waited and _key(waited)):
            if waited is not None:
                yield waited, event.trial
            waited = now
    if waited is not None:
        yield waited, None


def _that_hold(history: Sequence[Event]) -> Iterator[Event]:
    """Events after which other rules may be waited for, but those that were taken back."""
    undone = {event.number for event in history if event.undone}
    for event in history:
        if isinstance(event.command, _MATTER) and not {event.number, event.cause} & undone:
            yield replace(event, undone=False)


def _key(waited: Awaited) -> tuple[str, TriggerSpec, int]:
    return waited.introduce.skill, waited.rule, waited.since


def _watched(run: Run, waited: Awaited, until: int | None, former: Watched | None) -> Watched:
    watch = watch_for(waited.rule, waited.since)
    known = statistic(run.state, watch)
    if until is not None:
        known = Statistic(*(part[known.trials <= until] for part in known))
    places = _places(known.trials)
    outlooks = dict[int, int]()
    if former is not None:
        outlooks = dict(zip(former.trials.tolist(), former.fires.tolist(), strict=True))
    fires: list[int] = []
    for place in places.tolist():
        trial = int(known.trials[place])
        if trial not in outlooks:
            met = outlook_of(Statistic(*(part[: place + 1] for part in known)), watch)
            outlooks[trial] = NEVER if met is None else met
        fires.append(outlooks[trial])
    return Watched(
        waited.introduce.skill,
        waited.rule,
        waited.since,
        until,
        known.trials[places],
        known.values[places],
        np.array(fires, np.int64),
    )


def _places(trials: np.ndarray) -> np.ndarray:
    """Which of the trials in a row are shown, ``(point,) int64``: round ones, and the last.

    They stay the same while more come, but for some that are left out.
    """
    every = 1
    while trials.size > every * MOST_POINTS:
        every *= 2
    shown = trials % every == 0
    shown[-1:] = True
    return np.flatnonzero(shown)
