"""Commands that are given again before the learner has made a step: only the last one counts.

A key that is held down, or a slider that is shaken, sets one thing many times while no step is
made; the run is the same as if it had been set once. Its history says so, and stays short.
"""

from collections.abc import Hashable, Sequence
from dataclasses import replace

from learners.commands import (
    Command,
    Event,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    SetParameter,
)


def _setting_of(command: Command) -> Hashable | None:
    """What a command sets, and sets anew if it is given again; None if it does anything else."""
    match command:
        case FreezeSelection() | FreezeSkills() | FollowSchedule():
            return type(command)
        case SetParameter(key=key):
            return key
    return None


def overruled(history: Sequence[Event], command: Command, step: int) -> int | None:
    """Number of the event that a command by hand, given before a step, makes void; None if none.

    Between the two lie settings of other things alone, which bear any order.
    """
    if isinstance(command, Explore):
        last = history[-1] if history else None
        if last is None or last.author != "hand" or last.step != step:
            return None
        is_again = isinstance(last.command, Explore) and last.command.skill == command.skill
        return last.number if is_again else None
    setting = _setting_of(command)
    for event in reversed(history):
        others = _setting_of(event.command)
        if setting is None or others is None or event.author != "hand" or event.step != step:
            return None
        if others == setting:
            return event.number
    return None


def without(history: tuple[Event, ...], number: int) -> tuple[Event, ...]:
    """A history without one of its events; the later ones move up."""
    later = (replace(event, number=event.number - 1) for event in history[number + 1 :])
    return (*history[:number], *later)
