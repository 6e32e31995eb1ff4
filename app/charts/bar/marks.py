"""Marks across the curve: where skills joined or left, and where a parameter was changed."""

from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

from app.charts.bar.axis import TimeAxis
from app.explain.commands import command_in_words
from app.live.places import Mark as Note
from app.words.numbers import counted
from app.words.placing import Room
from app.words.plain import plain, shortened
from learners.commands import Event, Introduce, Remove, SetParameter

_NEAR: Final = 0.008
"""Marks nearer than this share of the axis are drawn as one."""
CHARACTER: Final = 1 / 78
"""Width of a character of a name as a share of the axis, on the safe side, where it is shortest
beside two panels."""
_GUTTER: Final = 0.2
"""How far a name may reach out over what stands to the left of the axis."""
_MOST_LISTED: Final = 8
_MOST_CHARACTERS: Final = 24
"""Of what somebody wrote, where there is room, and where there is little."""
_FEW_CHARACTERS: Final = 10
_MOST_WRITTEN: Final = 8
"""Notes that come before the names of skills: there may be many."""


class Mark(NamedTuple):
    """A line across the curve."""

    at: float
    """Its place along the axis."""
    name: str
    """What is written at it; empty where there is no room."""
    more: str
    """What is written after that where the page is wide."""
    is_before: bool
    """Whether that stands to the left of it."""
    hint: str
    """All that it stands for, a line each."""
    room: float = 1.0
    """How far the name may reach, as a share of the axis: where the page is narrow, it is cut."""
    note: int | None = None
    """Number of the mark that somebody made with a text, if it is one."""


class _Spot(NamedTuple):
    at: float
    events: tuple[Event, ...]

    @property
    def joins(self) -> bool:
        return any(isinstance(event.command, Introduce) for event in self.events)

    @property
    def names(self) -> tuple[tuple[str, str], ...]:
        """What it may be called, in two parts, the longest first: by skills that join if any do."""
        joins = [event.command for event in self.events if isinstance(event.command, Introduce)]
        if joins:
            skills = ", ".join(plain(command.skill) for command in joins)
            return (skills, " joins" if len(joins) == 1 else " join"), (skills, "")
        one, *more = self.events
        return ((counted(len(self.events), "change") if more else _name(one), ""),)

    @property
    def number(self) -> None:
        """Nobody wrote it."""
        return None

    @property
    def hint(self) -> str:
        lines = [f"trial {event.trial:,}: {_name(event)}" for event in self.events[:_MOST_LISTED]]
        more = len(self.events) - _MOST_LISTED
        return "\n".join([*lines, f"and {more:,} more"] if more > 0 else lines)


class _Written(NamedTuple):
    at: float
    of: Note

    @property
    def names(self) -> tuple[tuple[str, str], ...]:
        """The text, or its beginning where that does not fit, or nothing but a sign."""
        beginning = shortened(self.of.text, _MOST_CHARACTERS)
        return (beginning, ""), (shortened(self.of.text, _FEW_CHARACTERS), "")

    @property
    def hint(self) -> str:
        return f"trial {self.of.trial:,}: {self.of.text}"

    @property
    def number(self) -> int:
        """By which it is told from others."""
        return self.of.number


def marks_of(
    history: Iterable[Event], axis: TimeAxis, notes: Iterable[Note] = ()
) -> tuple[Mark, ...]:
    """The marks of a run, from left to right; of those that are close, one for all.

    A skill that is there from the start has no mark; nor have explorations and freezes, which are
    bands. Notes, which somebody wrote, have one each.
    """
    spots = _spots([event for event in history if _is_marked(event)], axis)
    joins = [spot for spot in spots if spot.joins]
    others = [spot for spot in spots if not spot.joins]
    written = [_Written(axis.of_trial(note.trial), note) for note in notes]
    # What somebody wrote stands nowhere else, while when skills join is said in their lanes, too.
    newest, older = written[-_MOST_WRITTEN:], written[:-_MOST_WRITTEN]
    marks: list[Mark] = []
    for kind, clear_of in ((newest, []), (joins, newest), (older, []), (others, [])):
        marks += _named_of(kind, _room(marks, [*kind, *clear_of]))
    return tuple(_reaching(mark, marks) for mark in sorted(marks, key=lambda mark: mark.at))


def _room(marks: Iterable[Mark], spots: Iterable[_Spot | _Written]) -> Room:
    """What marks with their names, and the lines of spots, leave."""
    room = Room(-_GUTTER, 1.0)
    for at in [*(mark.at for mark in marks), *(spot.at for spot in spots)]:
        room.take(at - CHARACTER / 2, at + CHARACTER / 2)
    for mark in marks:
        away = CHARACTER / 2 + _wide(mark.name + mark.more)
        room.take(*((mark.at - away, mark.at) if mark.is_before else (mark.at, mark.at + away)))
    return room


def _wide(name: str) -> float:
    """Width of a name as a share of the axis."""
    return (len(name) + 0.5) * CHARACTER if name else 0.0


def _named_of(spots: Sequence[_Spot | _Written], room: Room) -> list[Mark]:
    return [_named(spot, room) for spot in reversed(spots)]


def _reaching(mark: Mark, marks: Sequence[Mark]) -> Mark:
    """The mark with the room that its name has up to that of the next."""
    away = [abs(o.at - mark.at) for o in marks if o.name and (o.at < mark.at) == mark.is_before]
    edge = mark.at + _GUTTER if mark.is_before else 1.0 - mark.at
    return mark._replace(room=min([edge, *(room for room in away if room)]))


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


def _named(spot: _Spot | _Written, room: Room) -> Mark:
    """A mark with the longest of its names that finds room, to the right of it or to the left."""
    beside = CHARACTER / 2
    for name, more in spot.names:
        width = _wide(name + more)
        if room.taken(spot.at + beside, spot.at + beside + width):
            return Mark(spot.at, name, more, False, spot.hint, note=spot.number)
        if room.taken(spot.at - beside - width, spot.at - beside):
            return Mark(spot.at, name, more, True, spot.hint, note=spot.number)
    return Mark(spot.at, "", "", False, spot.hint, note=spot.number)


def _name(event: Event) -> str:
    if isinstance(event.command, Introduce):
        by = " by its rule" if event.author == "trigger" else ""
        return f"{plain(event.command.skill)} joins{by}"
    return command_in_words(event.command)
