"""What the learner was asked for, in a few words."""

from app.words.numbers import counted
from app.words.plain import parameter_name, plain
from learners.commands import (
    Command,
    DefineSkill,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Remove,
    SetParameter,
    SetSchedule,
    StopExploring,
    StopTeaching,
    Teach,
    Undo,
)


def command_in_words(command: Command) -> str:
    """A command in a few words."""
    match command:
        case Introduce(skill=skill):
            return f"{plain(skill)} added"
        case Explore(skill=skill, probability=probability, value_at_most=value):
            where = "" if value is None else f" where nothing else is worth more than {value:g}"
            return f"{plain(skill)} explored at {probability:.0%}{where}"
        case StopExploring(skill=skill):
            return f"exploring {plain(skill)} stopped"
        case Teach(duration_trials=duration):
            return f"taught for {counted(duration, 'trial')}"
        case StopTeaching():
            return "teaching stopped"
        case FreezeSelection(frozen=frozen):
            return f"selection {'frozen' if frozen else 'learning again'}"
        case FreezeSkills(frozen=frozen):
            return f"skills {'frozen' if frozen else 'learning again'}"
        case FollowSchedule(on=on):
            return f"schedule {'on' if on else 'off'}"
        case DefineSkill(skill=skill):
            return f"{plain(skill)} defined"
        case Remove(skill=skill):
            return f"{plain(skill)} removed"
        case SetParameter(key=key, value=value):
            return f"{parameter_name(key)} = {value:g}"
        case SetSchedule():
            return "schedule edited"
        case Undo(number=number):
            return f"change {number} undone"
