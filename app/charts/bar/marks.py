"""Marks across the curve: where skills joined or left, and where a parameter was changed."""

from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

from app.charts.bar.axis import TimeAxis
from app.words.numbers import counted
from app.words.placing import Room
from app.words.plain import PARAMETER_NAMES, plain
from learners.commands import Event, Introduce, Remove, SetParameter

_NEAR: Final = 0.008
"""Marks nearer than this share of the axis are drawn as one."""
CHARACTER: Final = 1 / 92
"""Width of a character of a name as a share of the axis, on the safe side, where it is shortest
beside two panels."""
_GUTTER: Final = 0.15
"""How far a name may reach out over what stands to the left of the axis."""
_MOST_LISTED: Final = 8


class Mark(NamedTuple):
    """A line across the curve."""

    at: float
    """Its place along the axis."""
    name: str
    """What is written at it; empty where there is no room."""
    is_before: bool
    """Whether that stands to the left of it."""
    hint: str
    """All that it stands for, a line each."""


class _Spot(NamedTuple):
    at: float
    events: tuple[Event, ...]

    @property
    def joins(self) -> bool:
        return any(isinstance(event.command, Introduce) for event in self.events)

    @property
    def name(self) -> str:
        """A skill that joins is what the curve is looked at for."""
        named = [event for event in self.events if isinstance(event.command, Introduce)]
        named = named or list(self.events)
        return _name(named[0]) if len(named) == 1 else _several(named)

    @property
    def hint(self) -> str:
        lines = [f"trial {event.trial:,}: {_name(event)}" for event in self.events[:_MOST_LISTED]]
        more = len(self.events) - _MOST_LISTED
        return "\n".join([*lines, f"and {more:,} more"] if more > 0 else lines)


def marks_of(history: Iterable[Event], axis: TimeAxis) -> tuple[Mark, ...]:
    """The marks of a run, from left to right; of those that are close, one for all.

    A skill that is there from the start has no mark; nor have explorations and freezes, which are
    bands.
    """
    spots = _spots([event for event in history if _is_marked(event)], axis)
    room = Room(-_GUTTER, 1.0)
    for spot in spots:
        room.take(spot.at - CHARACTER / 2, spot.at + CHARACTER / 2)
    sides: dict[int, bool] = {}
    # The newest first, but skills before all else.
    for place in sorted(range(len(spots)), key=lambda place: (not spots[place].joins, -place)):
        side = _side_of(spots[place], room)
        if side is not None:
            sides[place] = side
    return tuple(
        Mark(spot.at, spot.name if place in sides else "", sides.get(place, False), spot.hint)
        for place, spot in enumerate(spots)
    )


def _is_marked(event: Event) -> bool:
    if event.undone:
        return False
    if isinstance(event.command, Introduce):
        return event.step > 0
    return isinstance(event.command, Remove | SetParameter)


def _spots(events: Sequence[Event], axis: TimeAxis) -> list[_Spot]:
    spots: list[_Spot] = []
    for event in events:
        at = axis.of_trial(event.trial)
        if spots and at - spots[-1].at < _NEAR:
            spots[-1] = _Spot(spots[-1].at, (*spots[-1].events, event))
        else:
            spots.append(_Spot(at, (event,)))
    return spots


def _side_of(spot: _Spot, room: Room) -> bool | None:
    """Whether the name goes to the left of its mark; None if it finds no room."""
    width, beside = (len(spot.name) + 0.5) * CHARACTER, CHARACTER / 2
    if room.taken(spot.at + beside, spot.at + beside + width):
        return False
    return True if room.taken(spot.at - beside - width, spot.at - beside) else None


def _name(event: Event) -> str:
    match event.command:
        case Introduce(skill=skill):
            return f"{plain(skill)} joins"
        case Remove(skill=skill):
            return f"{plain(skill)} removed"
        case SetParameter(key=key, value=value):
            return f"{PARAMETER_NAMES[key]} = {value:g}"
    return ""


def _several(events: Sequence[Event]) -> str:
    """What several that are close are called."""
    skills = [event.command.skill for event in events if isinstance(event.command, Introduce)]
    if skills:
        return f"{', '.join(map(plain, skills))} join"
    return counted(len(events), "change")
