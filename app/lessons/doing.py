"""What a card asks to be done, as the commands and the runs that it comes to.

Both who plays a lesson without a page and the last hint, which does it, go by this.
"""

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from app.documents import presets
from app.documents.lesson_cards import Do, Given
from learners.commands import (
    Command,
    CommandError,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Remove,
    StopExploring,
)
from learners.control import Control
from learners.spec import RunSpec


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


def started_again(do: Do, spec: RunSpec) -> RunSpec:
    """The run that is begun by a card that has one started again.

    Args:
        do: what is to be done.
        spec: of the lesson's own run.

    Raises:
        CommandError: there is no such run.
    """
    try:
        base = spec if do.preset is None else presets.load(do.preset)
        return RunSpec.model_validate_json(
            _with(base, {str(key): value for key, value in do.set.items()}).model_dump_json()
        )
    except (presets.PresetError, ValidationError, LookupError, TypeError, ValueError) as error:
        raise CommandError(f"that run cannot be started: {error}") from None


def _with(spec: RunSpec, settings: Mapping[str, Any]) -> RunSpec:
    """A preset with some keys set, unless they are not there; judged anew."""
    tree: Any = spec.model_dump(mode="json")
    for name, value in settings.items():
        *path, last = name.split(".")
        node = tree
        for key in path:
            node = node[int(key) if isinstance(node, list) else key]
        node[int(last) if isinstance(node, list) else last] = value
    return RunSpec.model_validate(tree)
