"""Commands that are given again before the learner has made a step: only the last one counts.

A key that is held down, or a slider that is shaken, sets one thing many times while no step is
made; the run is the same as if it had been set once. Its history says so, and stays short.
"""

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import replace
from itertools import takewhile

from learners.commands import (
    Command,
    Event,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    SetParameter,
    Teach,
)
from learners.control import Control, as_if, evolve


def _setting_of(command: Command) -> Hashable | None:
    """What a command sets, and sets anew if it is given again; None if it does anything else."""
    match command:
        case FreezeSelection() | FreezeSkills() | FollowSchedule() | Teach():
            return type(command)
        case SetParameter(key=key):
            return key
    return None


def in_its_place(control: Control, event: Event, since: Control) -> Control | None:
    """What holds after a command by hand that takes the place of one that it makes void.

    What a command and its contrary leave as it was leaves no note.

    Args:
        control: what held before it.
        event: the command, which can be carried out.
        since: what held at an earlier moment, so that not all is played again.

    Returns:
        What holds; None if the command makes none void.
    """
    void = _overruled(control.history, event)
    if void is None:
        return None
    history = _history_without(control.history, void)
    is_earlier = len(since.history) <= void
    before = as_if(control, history, event.trial, since if is_earlier else None)
    after = evolve(before, replace(event, number=len(history)))
    return before if replace(after, history=history) == before else after


def without_repeats(commands: Iterable[Command]) -> tuple[Command, ...]:
    """Commands that are given one after the other in one moment, without those that later ones make
    void. What holds after them is the same, but what is noted of it need not be."""
    kept = list[Command]()
    for command in commands:
        void = _repeated(command, reversed([*enumerate(kept)]))
        if void is not None:
            del kept[void]
        kept.append(command)
    return tuple(kept)


def _overruled(history: Sequence[Event], event: Event) -> int | None:
    """Number of the event that a command by hand, given before the same step, makes void.

    Between the two lie settings of other things alone, which bear any order.
    """
    command, step = event.command, event.step
    if isinstance(command, Explore):
        last = history[-1] if history else None
        if last is None or last.author != "hand" or last.step != step:
            return None
        is_again = isinstance(last.command, Explore) and last.command.skill == command.skill
        return last.number if is_again else None
    here = takewhile(lambda other: other.author == "hand" and other.step == step, reversed(history))
    return _repeated(command, ((other.number, other.command) for other in here))


def _repeated(command: Command, former: Iterable[tuple[int, Command]]) -> int | None:
    """Number of the one among former commands, the newest first, that sets what this one does.

    None if there is none, or if something else than settings lies between the two.
    """
    setting = _setting_of(command)
    for number, other in former:
        others = _setting_of(other)
        if setting is None or others is None:
            return None
        if others == setting:
            return number
    return None


def _history_without(history: tuple[Event, ...], number: int) -> tuple[Event, ...]:
    """A history without one of its events; the later ones move up."""
    later = (replace(event, number=event.number - 1) for event in history[number + 1 :])
    return (*history[:number], *later)
