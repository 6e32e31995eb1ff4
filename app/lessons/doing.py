"""What a card asks to be done, as the commands that it comes to.

Both who plays a lesson without a page and the last hint, which does it, go by this.
"""

from typing import Final

from app.documents.lesson_cards import Do, Given
from learners.commands import (
    Command,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Remove,
    StopExploring,
)
from learners.control import Control

EXPLORED: Final = (2_000, 0.95)
"""Trials and chance where nothing says how a skill is explored: as the thesis's schedule has it for
the first that joins."""


def commands_of(do: Do | Given, control: Control) -> tuple[Command, ...]:
    """The commands to a learner that something comes to; none if it is something else.

    Args:
        do: what is to be done.
        control: what holds where it is done, for what the file leaves to the preset.
    """
    skill, explore, on = do.skill or "", do.explore, bool(do.on)
    exploring = (Explore(skill, explore.trials, float(explore.chance)),) if explore else ()
    match do.command:
        case "introduce":
            freeze = control.spec.schedule.freeze_of(skill) if do.freeze is None else do.freeze
            return (Introduce(skill, freeze), *exploring)
        case "explore":
            return exploring
        case "stop_exploring":
            return (StopExploring(skill),)
        case "freeze_selection":
            return (FreezeSelection(on),)
        case "freeze_skills":
            return (FreezeSkills(on),)
        case "follow_schedule":
            return (FollowSchedule(on),)
        case "remove":
            return (Remove(skill),)
        case _:
            return ()


def swapped(commands: tuple[Command, ...], skill: str) -> tuple[Command, ...]:
    """The same commands with another skill that joins, and is explored, in the place of theirs."""
    found: list[Command] = []
    for command in commands:
        match command:
            case Introduce(freeze_trials=freeze):
                found.append(Introduce(skill, freeze))
            case Explore(duration_trials=trials, probability=chance):
                found.append(Explore(skill, trials, chance))
            case _:
                found.append(command)
    return tuple(found)
