"""The lanes of the schedule: when each skill is there, explored or frozen."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Final, Literal, NamedTuple

from app.charts.bar.axis import TimeAxis
from app.charts.bar.marks import CHARACTER
from app.schedule.blocks import FREEZES, FROZEN, NEVER, Block, Kind
from app.words.placing import Room
from app.words.plain import plain

FREEZE_LANE: Final = "frozen by hand"
TEACHING_LANE: Final = "taught"
_LEAST: Final = 1 / 120
"""Width of the shortest block, as a share of the axis."""

_NEAR: Final = 2 * CHARACTER
"""Farther from its block a text is as short as can be."""

Side = Literal["before", "after", "within"]
Shape = Literal["join", "forced", "taught", "frozen"]
"""What a block is drawn as."""
Half = Literal["whole", "upper", "lower"]
"""What part of the height of its lane a block takes."""


class Stretch(NamedTuple):
    """Where a skill can be chosen, or is going to be, in trials."""

    first: int
    until: int | None
    """The first trial after it; None if it goes on."""
    is_ahead: bool


class Piece(NamedTuple):
    """A block of the schedule in its lane."""

    block: Block
    kind: Shape
    half: Half
    is_chosen: bool

    @property
    def is_idle(self) -> bool:
        """Whether it is in the plan and will not happen as things stand."""
        return self.block.state == "idle"


class Label(NamedTuple):
    """A text in a lane."""

    before: str
    text: str
    """What is said on the narrowest page, too."""
    after: str
    at: float
    side: Side
    """Whether it ends at its place, begins there, or has it in its middle."""
    room: float
    """How far it may reach, as a share of the axis."""
    of: tuple[str, ...]
    """Ids of the blocks of which it is said."""


class Lane(NamedTuple):
    """What is drawn in one row."""

    name: str
    skill: str
    """Whose blocks these are; empty for those taught, or frozen by hand."""
    presence: tuple[Stretch, ...]
    pieces: tuple[Piece, ...]
    labels: tuple[Label, ...]


def _wide(text: str) -> float:
    """Width of a text with the room around it, as a share of the axis."""
    return (len(text) + 2.5) * CHARACTER


def lanes_of(
    blocks: Sequence[Block], skills: Iterable[str], axis: TimeAxis, chosen: str = ""
) -> tuple[Lane, ...]:
    """A lane for each skill, and others where a script taught and something was frozen by hand."""
    comes_next = next((block.id for block in blocks if _waits_for_its_rule(block)), "")
    lanes = [
        _lane(
            skill, plain(skill), [b for b in blocks if b.skill == skill], axis, chosen, comes_next
        )
        for skill in skills
    ]
    taught = [block for block in blocks if block.kind == "teaching"]
    freezes = [block for block in blocks if block.kind in FREEZES]
    for name, found in ((TEACHING_LANE, taught), (FREEZE_LANE, freezes)):
        if found:
            lanes.append(_lane("", name, found, axis, chosen, ""))
    return tuple(lanes)


def _waits_for_its_rule(block: Block) -> bool:
    """Whether its skill is to join by a rule; the first of these is the next one that does."""
    is_ahead = block.kind == "introduction" and block.state == "planned"
    return is_ahead and block.by_rule and block.first >= NEVER


def _lane(
    skill: str,
    name: str,
    blocks: Sequence[Block],
    axis: TimeAxis,
    chosen: str,
    comes_next: str,
) -> Lane:
    # One that another took the place of at once has held nothing.
    blocks = [
        block for block in blocks if block.kind == "introduction" or block.until != block.first
    ]
    shown = [block for block in blocks if not _is_beyond(block, axis)]
    drawn = [block for block in shown if block.kind != "presence"]
    # What is short is drawn over what is long.
    drawn.sort(key=lambda block: axis.of_trial(block.first) - _until(block, axis))
    return Lane(
        name=name,
        skill=skill,
        presence=tuple(_presence(shown, axis)),
        pieces=tuple(_piece(block, chosen) for block in drawn),
        labels=_Writer(axis, drawn, comes_next).labels(blocks),
    )


def _is_beyond(block: Block, axis: TimeAxis) -> bool:
    if axis.unit == "trials":
        return block.first > axis.end
    return block.first > axis.trial and axis.of_trial(block.first) >= 1.0


def _until(block: Block, axis: TimeAxis) -> float:
    return axis.now if block.until is None else axis.of_trial(block.until)


def _presence(blocks: Iterable[Block], axis: TimeAxis) -> Iterable[Stretch]:
    for block in blocks:
        if block.kind == "presence":
            yield Stretch(block.first, block.until, is_ahead=False)
            if block.until is None:
                yield Stretch(axis.trial, None, is_ahead=True)
        elif block.kind == "introduction" and block.state == "planned":
            yield Stretch(block.first, None, is_ahead=True)


_HALVES: Final[Mapping[Kind, Half]] = {FREEZES[0]: "upper", FREEZES[1]: "lower"}
_SHAPES: Final[Mapping[Kind, Shape]] = {
    "introduction": "join",
    "exploration": "forced",
    "teaching": "taught",
}


def _piece(block: Block, chosen: str) -> Piece:
    shape: Shape = _SHAPES.get(block.kind, "frozen")
    half: Half = _HALVES.get(block.kind, "whole")
    return Piece(block, shape, half, is_chosen=block.id == chosen)


class _Writer:
    """Finds room in a lane for what is said of its blocks."""

    def __init__(self, axis: TimeAxis, drawn: Iterable[Block], comes_next: str) -> None:
        """``comes_next`` is the id of the block whose skill is the next to join by a rule."""
        self._axis, self._comes_next = axis, comes_next
        self._taken = [self._span(block) for block in drawn]
        self._room = Room(0.0, 1.0)
        for span in self._taken:
            self._room.take(*span)
        self._labels: list[Label] = []

    def labels(self, blocks: Sequence[Block]) -> tuple[Label, ...]:
        """What is said of some blocks, some of which may be beyond the axis."""
        here = [block for block in blocks if not _is_beyond(block, self._axis)]
        explorations = [block for block in here if block.kind == "exploration"]
        # Explorations overlap where one by hand runs on into one that is planned.
        inside = Room(0.0, 1.0)
        rest = [block for block in explorations if not self._within(block, inside)]
        for stretch in self._stretches(rest, 5 * CHARACTER):
            chances = [f"{block.probability:.0%}" for block in stretch]
            self._beside(stretch, ", ".join(chances), " of steps" if len(chances) == 1 else "")
        freezes = [block for block in here if block.kind in FREEZES]
        for stretch in self._stretches(freezes, 0.0):
            kinds = {block.kind for block in stretch}
            self._beside(stretch, " and ".join(FROZEN[k] for k in FREEZES if k in kinds))
        for block in here:
            if block.kind == "teaching" and not block.undone:
                self._beside([block], "by a script")
        for block in blocks:
            # One that was taken back would say that a skill is there which is not.
            if block.kind == "introduction" and not block.undone:
                self._join(block, is_beyond=block not in here)
        return tuple(self._reaching(label) for label in self._labels)

    def _span(self, block: Block) -> tuple[float, float]:
        first = self._axis.of_trial(block.first)
        return first, max(_until(block, self._axis), first + _LEAST)

    def _stretches(self, blocks: Iterable[Block], near: float) -> list[list[Block]]:
        """Blocks between which there is no room for what is said of them."""
        stretches: list[list[Block]] = []
        for block in sorted(blocks, key=lambda block: block.first):
            first, _ = self._span(block)
            if stretches and first - self._span(stretches[-1][-1])[1] < near:
                stretches[-1].append(block)
            else:
                stretches.append([block])
        return stretches

    def _within(self, block: Block, inside: Room) -> bool:
        """Write in the middle of a block; returns whether there is room."""
        first, until = self._span(block)
        middle = (first + until) / 2
        for more in (" of steps", ""):
            text = f"{block.probability:.0%}{more}"
            width = _wide(text)
            if until - first >= width and inside.taken(middle - width / 2, middle + width / 2):
                chance = f"{block.probability:.0%}"
                label = Label("", chance, more, middle, "within", until - first, (block.id,))
                self._labels.append(label)
                return True
        return False

    def _beside(self, stretch: Sequence[Block], text: str, more: str = "") -> None:
        """Write right after blocks that follow one another, or as near to that as there is room."""
        until = max(self._span(block)[1] for block in stretch)
        for after, within in ((more, _NEAR), ("", math.inf)):
            spot = self._room.take_nearest(_wide(text + after), until, within)
            if spot is not None:
                self._put("", text, after, spot, stretch)
                return

    def _join(self, block: Block, is_beyond: bool) -> None:
        """Write when a skill joins: before that, or wherever in its lane there is room."""
        if block.first == 0:
            return
        before = "joins at " if block.state in ("planned", "idle") else "joined at "
        text, after, near = f"{block.first:,}", "", self._span(block)[0]
        if block.first >= NEVER:
            before, text, near = "", "not planned to join", 1.0
            if block.by_rule:
                is_next = block.id == self._comes_next
                text = "joins next, by its rule" if is_next else "joins by its rule"
        elif is_beyond:
            after, near = " \N{BLACK RIGHT-POINTING SMALL TRIANGLE}", 1.0
        elif block.by_rule:
            after = " by its rule"
        spot = self._room.take_nearest(_wide(before + text + after), near, math.inf)
        if spot is not None:
            self._put(before, text, after, spot, [block])

    def _put(
        self,
        before: str,
        text: str,
        after: str,
        spot: tuple[float, bool],
        blocks: Sequence[Block],
    ) -> None:
        edge, is_before = spot
        side: Side = "before" if is_before else "after"
        of = tuple(block.id for block in blocks)
        self._labels.append(Label(before, text, after, edge, side, 0.0, of))

    def _reaching(self, label: Label) -> Label:
        """The label with the room that it has up to the next thing in its lane.

        Where the bar is narrower than it was judged by, a text is cut there.
        """
        if label.side == "within":
            return label
        spots = [*self._taken, *((o.at, o.at) for o in self._labels if o is not label)]
        if label.side == "after":
            ends = [first for first, _ in spots if first > label.at]
            return label._replace(room=min(ends, default=1.0) - label.at)
        ends = [until for _, until in spots if until < label.at]
        return label._replace(room=label.at - max(ends, default=0.0))
