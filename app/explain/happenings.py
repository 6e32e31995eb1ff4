"""What happened along a line, each with the very step: moments to go to, and to stop at.

Skills that join, freezes and explorations that end, what was done by hand, the first capture, and
marks. How things stood at the start is none: the beginning is gone to by itself.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Final, Literal, NamedTuple

import numpy as np

from app.explain.commands import command_in_words
from app.live.places import Mark
from app.words.plain import plain
from learners.commands import Event, Introduce, Undo
from learners.control import Control, evolve
from learners.spec import RunSpec
from sim.world import CAPTURE

Kind = Literal["join", "freeze", "exploration", "command", "capture", "mark"]
"""``freeze`` and ``exploration`` are their ends."""

MOST_BY_HAND: Final = 100
"""The newest of what was done by hand is named: a held key does thousands of things."""


class Happening(NamedTuple):
    """Something that happened along a line."""

    step: int
    """Steps made by then."""
    trial: int
    """Trials that had ended by then."""
    kind: Kind
    text: str
    """In a few words; of a mark, what somebody wrote."""


def happenings_of(
    control: Control,
    trial: int,
    step_of_trial: Callable[[int], int],
    first_capture: int | None = None,
    marks: Iterable[Mark] = (),
) -> tuple[Happening, ...]:
    """All that happened along a line, by step.

    Args:
        control: what holds where as much of the line is made as is known.
        trial: the running trial there; nothing is said of what comes later.
        step_of_trial: steps made when a trial begins, of those up to there.
        first_capture: the trial that ended in the first one, see :func:`first_capture_in`.
        marks: those that lie on the line.
    """
    found = [*_commands(control.history)]
    found += [
        Happening(step_of_trial(end), end, kind, text) for end, kind, text in _ends(control, trial)
    ]
    found += _pretraining(control.preset) if trial else ()
    if first_capture is not None and first_capture < trial:
        after = first_capture + 1
        found.append(Happening(step_of_trial(after), after, "capture", "the first capture"))
    found += [Happening(mark.place.step, mark.trial, "mark", mark.text) for mark in marks]
    return tuple(sorted(found, key=lambda one: one.step))


def first_capture_in(outcomes: np.ndarray) -> int | None:
    """The first trial that ended in a capture; None where none has.

    Args:
        outcomes: ``(trial,)`` how each trial ended, of those that have.
    """
    captures = outcomes == CAPTURE
    return int(captures.argmax()) if captures.any() else None


def _commands(history: tuple[Event, ...]) -> Iterator[Happening]:
    """Skills that joined, and what was done by hand, of that the newest."""
    by_hand = [event.number for event in history if event.author == "hand"]
    lost = set(by_hand[:-MOST_BY_HAND])
    for event in history:
        joins = isinstance(event.command, Introduce)
        if event.step == 0 or event.number in lost or not (joins or event.author == "hand"):
            continue
        kind: Kind = "join" if joins else "command"
        yield Happening(event.step, event.trial, kind, _said(event, history))


def _pretraining(preset: RunSpec) -> Iterator[Happening]:
    """Where each skill has learned alone, all of them before the first trial."""
    steps = preset.schedule.pretrain
    for number, skill in enumerate(preset.learner.skills if steps else (), 1):
        yield Happening(number * steps, 0, "exploration", f"{plain(skill)} has learned alone")


def _said(event: Event, history: tuple[Event, ...]) -> str:
    if isinstance(event.command, Introduce) and event.author != "hand":
        by_rule = " by its rule" if event.author == "trigger" else ""
        return f"{plain(event.command.skill)} joins{by_rule}"
    if isinstance(event.command, Undo):
        return f"undone: {command_in_words(history[event.command.number].command)}"
    return command_in_words(event.command)


def _ends(control: Control, trial: int) -> Iterator[tuple[int, Kind, str]]:
    """Freezes and explorations that were over in time, and not by a command: when, and which."""
    held = Control.at_start(control.preset)
    spans = pairwise([0, *(event.trial for event in control.history), trial])
    for event, (first, last) in zip((None, *control.history), spans, strict=True):
        if event is not None:
            # Whether it was undone later is no matter of its moment.
            held = evolve(held, replace(event, undone=False))
        if first < held.frozen_until <= last and not held.selection_frozen:
            yield held.frozen_until, "freeze", "the selection learns again"
        if first < held.taught_until <= last:
            yield held.taught_until, "exploration", "the script teaches no more"
        for episode in held.episodes:
            if first < episode.until_trial <= last:
                skill = plain(episode.skill)
                yield episode.until_trial, "exploration", f"exploring {skill} is over"
