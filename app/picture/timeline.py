"""The timeline as a picture: blocks in a lane for each skill, and where the run is."""

import math
from collections.abc import Iterable, Sequence

from app.live.snapshot import Snapshot
from app.picture.colours import css
from app.picture.theme import DARK, LIGHT, Theme
from app.schedule.blocks import FREEZES, FROZEN, NEVER, Block, described
from app.util.html import escaped
from app.words.numbers import in_short, ticks
from app.words.placing import Room
from app.words.plain import plain, shortened

_FONT_PX = 12
_CHARACTER_PX = 6.6
"""Width of a character of the labels, on the safe side."""
_TOP_PX, _AXIS_PX = 17, 17
"""Height of the caption above the lanes, and of the numbers below them."""
_LANE_PX, _LOW_LANE_PX = 17, 15
_MANY_LANES = 6
"""With more lanes than this each is lower."""
_LARGEST_GUTTER = 0.26
"""Share of the width that the names of the lanes may take."""
_RIGHT = 0.985
"""Where the trials end, as a share of the width."""

_MOST_TICKS = 8
"""Numbered trials after 0."""

_ROLES = {
    "ink": "ink",
    "page": "unknown",
    "line": "lines",
    "explore": "forced",
    "freeze": "frozen",
    "hand": "ink",
    "now": "ink",
    "idle": "timeout",
}
"""What the colours of a theme are used for here."""


def _solid(colour: str) -> str:
    return f'fill="{colour}" fill-opacity="0.85"'


def _dashed(colour: str) -> str:
    return (
        f'fill="{colour}" fill-opacity="0.12" stroke="{colour}" stroke-width="1.5"'
        ' stroke-dasharray="4 2.5"'
    )


_DOTTED = 'stroke-width="1.5" stroke-dasharray="2 4"'
"""Lines of skills that are to stay."""
_BOX = "M0 0H12V9H0Z"
_NOTCH_PX, _LINE_PX, _MARGIN_PX = 9, 3, 5
"""Width of the mark of what is by hand, of the line of a join, of the space beside a label."""
_NOTCH = f"M0 0H{_NOTCH_PX}L0 {_NOTCH_PX}Z"
_LEGEND = (
    ("by hand", _NOTCH, 'fill="var(--hand)"'),
    ("frozen", _BOX, _solid("var(--freeze)")),
    ("planned", _BOX, _dashed("var(--explore)")),
    ("explored", _BOX, _solid("var(--explore)")),
)
"""Text, shape and style of each swatch, the last one first."""


def axis_end(snapshot: Snapshot) -> int:
    """Last trial on the timeline: the run's last, or, once it goes on, that of the next stretch."""
    trials = snapshot.spec.trials
    return trials * max(math.ceil(snapshot.trial / trials), 1)


def timeline_svg(
    blocks: Sequence[Block],
    snapshot: Snapshot,
    theme: Theme | None,
    width: float,
    chosen: str = "",
    caption: str = "",
) -> str:
    """The timeline as one SVG element.

    Places along the trials are shares of the width, so that the picture fills whatever it is put
    into and its texts stay as large as they are.

    Args:
        blocks: what to draw, from :func:`blocks_of`.
        snapshot: the moment.
        theme: colours; None to take those that fit the page that it is shown in.
        width: pixels that there are at least, by which labels are judged to fit.
        chosen: id of the block that is highlighted.
        caption: a line of text above it.
    """
    picture = _Picture(snapshot, width)
    for block in blocks:
        if block.kind == "presence":
            picture.add_presence(block)
    for block in blocks:
        if block.kind == "introduction":
            picture.add_join_line(block)
    for kind in ("exploration", "introduction", *FREEZES):
        for block in blocks:
            if block.kind == kind:
                picture.add_block(block, chosen=block.id == chosen)
    picture.add_playhead()
    picture.add_labels(blocks)
    return picture.svg(theme, caption)


def _share(number: float) -> str:
    return f"{100 * number:.3f}%"


def _colours(theme: Theme) -> str:
    return ";".join(f"--{role}:{css(getattr(theme, name))}" for role, name in _ROLES.items())


_PAGE_STYLE = (
    f"<style>.pounce-timeline{{{_colours(LIGHT)}}}"
    f'[data-mantine-color-scheme="dark"] .pounce-timeline{{{_colours(DARK)}}}</style>'
)
"""Colours that follow the page: each browser has its own theme, and all are sent one picture."""


def _text_px(text: str) -> float:
    """Width of a label with its margins, on the safe side."""
    return len(text) * _CHARACTER_PX + 2 * _MARGIN_PX


class _Picture:
    """Collects the elements of a timeline."""

    def __init__(self, snapshot: Snapshot, width: float) -> None:
        self._snapshot = snapshot
        self._width = width
        self._end = axis_end(snapshot)
        self._skills = snapshot.spec.learner.skills
        names = [plain(skill) for skill in self._skills] + ["frozen by hand"]
        wanted = (max(map(len, names)) * _CHARACTER_PX + 14) / width
        self._left = min(wanted, _LARGEST_GUTTER)
        self._lane = _LANE_PX if len(names) <= _MANY_LANES else _LOW_LANE_PX
        self._bottom = _TOP_PX + self._lane * len(names)
        self._parts: list[str] = []
        self._add_lanes(names)
        self._add_axis()

    @property
    def _lane_characters(self) -> int:
        return max(int((self._left * self._width - 12) / _CHARACTER_PX), 2)

    def _x(self, trial: float) -> float:
        """Place of a trial, as a share of the width."""
        along = min(max(trial / self._end, 0.0), 1.0)
        return self._left + along * (_RIGHT - self._left)

    def _px(self, share: float) -> float:
        return share * self._width

    def _lane_top(self, skill: str) -> int:
        """Top of a skill's lane; that of freezes by hand has no skill and comes last."""
        lanes = [*self._skills, ""]
        return _TOP_PX + self._lane * lanes.index(skill)

    def _body(self, block: Block) -> tuple[float, float]:
        """Top and height of what is drawn for a block."""
        top, lane = self._lane_top(block.skill), self._lane
        if block.kind == "introduction":
            return top + 2, lane * 0.3
        if block.kind == "selection_freeze":
            return top + 2, (lane - 5) / 2
        if block.kind == "skills_freeze":
            return top + 3 + (lane - 5) / 2, (lane - 5) / 2
        return top + 2, lane - 4

    def _add_lanes(self, names: Sequence[str]) -> None:
        for place, name in enumerate(names):
            top = _TOP_PX + place * self._lane
            middle = top + self._lane / 2
            self._parts.append(
                f'<line x1="0" x2="{_share(_RIGHT)}" y1="{top}" y2="{top}" stroke="var(--line)"/>'
                f'<text x="4" y="{middle:g}" dominant-baseline="central">'
                f"<title>{escaped(name)}</title>"
                f"{escaped(shortened(name, self._lane_characters))}</text>"
            )

    def _add_axis(self) -> None:
        bottom = self._bottom
        self._parts.append(
            f'<line x1="{_share(self._left)}" x2="{_share(_RIGHT)}" y1="{bottom}" y2="{bottom}"'
            ' stroke="var(--ink)"/>'
            f'<text x="4" y="{bottom + 13}" opacity="0.75">trial</text>'
        )
        here = self._x(self._snapshot.trial)
        for tick in ticks(0, self._end, _MOST_TICKS, least=1):
            at = self._x(tick)
            self._parts.append(
                f'<line x1="{_share(at)}" x2="{_share(at)}" y1="{_TOP_PX}" y2="{bottom + 3}"'
                ' stroke="var(--line)"/>'
            )
            # The playhead's own number takes the place of those that it would cover.
            if self._px(abs(at - here)) > 58:
                anchor = "end" if at > 0.95 else "middle"
                self._parts.append(
                    f'<text x="{_share(at)}" y="{bottom + 14}" text-anchor="{anchor}"'
                    f' opacity="0.75">{in_short(tick, k_from=1e5)}</text>'
                )

    def add_presence(self, block: Block) -> None:
        """Draw that a skill is among the options, as a line through its lane."""
        middle = self._lane_top(block.skill) + self._lane / 2
        until = self._snapshot.trial if block.until is None else block.until
        self._line(self._x(block.first), self._x(until), middle, 'stroke-width="2"', 0.45)
        if block.until is None:
            self._line(self._x(until), _RIGHT, middle, _DOTTED, 0.4)

    def _line(self, x1: float, x2: float, y: float, style: str, opacity: float) -> None:
        self._parts.append(
            f'<line x1="{_share(x1)}" x2="{_share(x2)}" y1="{y:g}" y2="{y:g}" stroke="var(--ink)"'
            f' opacity="{opacity:g}" {style}/>'
        )

    def add_join_line(self, block: Block) -> None:
        """Mark where a skill joins, across its lane; and that it is to stay, if that is ahead."""
        if block.first > self._end:
            return
        top, at = self._lane_top(block.skill), self._x(block.first)
        ahead = block.state in ("planned", "idle")
        if block.state == "planned":
            self._line(at, _RIGHT, top + self._lane / 2, _DOTTED, 0.4)
        self._parts.append(
            f'<line x1="{_share(at)}" x2="{_share(at)}" y1="{top + 1}" y2="{top + self._lane - 1}"'
            f' stroke="var(--{self._role(block)})" stroke-width="{1.5 if ahead else 2.5}"'
            + (' stroke-dasharray="3 2"/>' if ahead else "/>")
        )

    @staticmethod
    def _role(block: Block) -> str:
        if block.state == "idle":
            return "idle"
        return "explore" if block.kind == "exploration" else "freeze"

    def add_block(self, block: Block, chosen: bool) -> None:
        """Draw a block: solid as far as it has come, dashed from there on."""
        if block.first > self._end:
            return
        now = self._snapshot.trial
        until = now if block.until is None else block.until
        begun = block.state in ("done", "running")
        self._parts.append(f"<g><title>{escaped(described(block))}</title>")
        if begun:
            self._rect(block, block.first, min(until, max(now, block.first)), solid=True)
        if until > now or not begun:
            self._rect(
                block, block.first if not begun else max(now, block.first), until, solid=False
            )
        if block.by_hand:
            self._notch(block)
        if chosen:
            self._halo(block, until)
        self._parts.append("</g>")

    def _rect(self, block: Block, first: float, until: float, solid: bool) -> None:
        top, height = self._body(block)
        colour = f"var(--{self._role(block)})"
        style = _solid(colour) if solid else _dashed(colour)
        least = 3 if block.kind == "introduction" and block.trials == 0 else 2
        self._parts.append(
            f'<rect x="{_share(self._x(first))}" y="{top:g}" height="{height:g}"'
            f' style="width:max({least}px,{_share(self._x(until) - self._x(first))})" {style}/>'
        )

    def _notch(self, block: Block) -> None:
        top, _ = self._body(block)
        self._parts.append(
            f'<svg x="{_share(self._x(block.first))}" y="{top:g}" overflow="visible">'
            f'<path d="{_NOTCH}" fill="var(--hand)"/></svg>'
        )

    def _halo(self, block: Block, until: float) -> None:
        top, lane = self._lane_top(block.skill), self._lane
        wide = _share(self._x(until) - self._x(block.first))
        self._parts.append(
            f'<rect x="{_share(self._x(block.first))}" y="{top + 0.5:g}" height="{lane - 1}"'
            f' style="width:max(7px,{wide})" fill="none" stroke="var(--ink)" stroke-width="2.5"'
            ' rx="2" class="chosen"/>'
        )

    def add_labels(self, blocks: Sequence[Block]) -> None:
        """Write on the lanes where there is room."""
        for skill in self._skills:
            mine = [b for b in blocks if b.skill == skill and b.kind != "presence"]
            room = self._room(mine)
            # Explorations overlap where one by hand runs on into one that is planned.
            inside = self._room([])
            explorations = [b for b in mine if b.kind == "exploration" and b.first <= self._end]
            # Those that go into their blocks leave the room beside the blocks to the others.
            outside = [block for block in explorations if not self._label_within(block, inside)]
            for block in mine:
                # One that was taken back would say that a skill is there which is not.
                if block.kind == "introduction" and not block.undone:
                    self._label_introduction(block, room)
            for block in outside:
                self._label_beside(skill, [block], f"{block.probability:.0%}", room)
        self._label_freezes([block for block in blocks if block.kind in FREEZES])

    def _room(self, blocks: Iterable[Block]) -> Room:
        """The room that blocks leave on their lane."""
        room = Room(self._px(self._left), self._px(_RIGHT))
        for block in blocks:
            if block.first <= self._end:
                room.take(*self._extent(block))
        return room

    def _extent(self, block: Block) -> tuple[float, float]:
        """Where what is drawn of a block begins and ends, in pixels."""
        now = self._snapshot.trial
        until = self._px(self._x(now if block.until is None else block.until))
        first = self._px(self._x(block.first))
        return first - _LINE_PX / 2, max(until, first + (_NOTCH_PX if block.by_hand else _LINE_PX))

    def _text(
        self, skill: str, share: float, text: str, anchor: str = "start", dx: float = 0.0
    ) -> None:
        """Write on a lane; with a rim, so that lines below do not make it hard to read."""
        middle = self._lane_top(skill) + self._lane / 2
        self._parts.append(
            f'<text x="{_share(share)}" dx="{dx:g}" y="{middle:g}" dominant-baseline="central"'
            f' text-anchor="{anchor}" font-size="11" stroke="var(--page)" stroke-width="3"'
            f' paint-order="stroke" pointer-events="none">{escaped(text)}</text>'
        )

    def _write(
        self, skill: str, text: str, room: Room, near: float, within: float = math.inf
    ) -> bool:
        """Write on a lane as near to a place as there is room; returns whether there is."""
        spot = room.take_nearest(_text_px(text), near, within)
        if spot is None:
            return False
        edge, is_before = spot
        anchor, dx = ("end", -_MARGIN_PX) if is_before else ("start", _MARGIN_PX)
        self._text(skill, edge / self._width, text, anchor, dx)
        return True

    def _label_within(self, block: Block, room: Room) -> bool:
        """Write in the middle of a block; returns whether there is room."""
        text = f"{block.probability:.0%}"
        first, until = self._x(block.first), self._x(block.first + block.trials)
        middle, width = (first + until) / 2, _text_px(text)
        left = self._px(middle) - width / 2
        if self._px(until - first) < width or not room.taken(left, left + width):
            return False
        self._text(block.skill, middle, text, "middle")
        return True

    def _label_beside(self, skill: str, stretch: Sequence[Block], text: str, room: Room) -> None:
        """Write right after blocks that follow one another, or else right before them."""
        first, until = zip(*map(self._extent, stretch), strict=True)
        if not self._write(skill, text, room, max(until), within=0):
            self._write(skill, text, room, min(first), within=0)

    def _label_introduction(self, block: Block, room: Room) -> None:
        """Write when a skill joins: before that, or wherever on its lane there is room."""
        ahead = block.state in ("planned", "idle")
        text = f"{'joins' if ahead else 'joined'} at {block.first:,}"
        if block.first <= self._end:
            self._write(block.skill, text, room, self._extent(block)[0])
        elif block.first >= NEVER:
            self._write(block.skill, "not planned to join", room, self._px(_RIGHT))
        else:
            self._write(block.skill, f"{text} ▸", room, self._px(_RIGHT))

    def _label_freezes(self, freezes: Sequence[Block]) -> None:
        """Say of each stretch of freezes by hand what was frozen in it."""
        room = self._room(freezes)
        stretches: list[list[Block]] = []
        for block in sorted(freezes, key=lambda block: block.first):
            if stretches and block.first <= self._end_of(stretches[-1]):
                stretches[-1].append(block)
            else:
                stretches.append([block])
        for stretch in stretches:
            kinds = {block.kind for block in stretch}
            text = " and ".join(FROZEN[kind] for kind in FREEZES if kind in kinds)
            self._label_beside("", stretch, text, room)

    def _end_of(self, blocks: Iterable[Block]) -> int:
        now = self._snapshot.trial
        return max(now if block.until is None else block.until for block in blocks)

    def add_playhead(self) -> None:
        """Draw where the run is."""
        at = self._x(self._snapshot.trial)
        anchor = "end" if at > 0.93 else "middle"
        self._parts.append(
            f'<line x1="{_share(at)}" x2="{_share(at)}" y1="{_TOP_PX}" y2="{self._bottom + 3}"'
            ' stroke="var(--now)" stroke-width="2" class="playhead"/>'
            f'<svg x="{_share(at)}" y="{_TOP_PX}" overflow="visible">'
            '<path d="M-5 0H5L0 7Z" fill="var(--now)"/></svg>'
            f'<text x="{_share(at)}" y="{self._bottom + 14}" text-anchor="{anchor}"'
            f' font-weight="700">{self._snapshot.trial:,}</text>'
        )

    def _legend(self) -> str:
        """Swatches, from the right edge inwards."""
        x, parts = 0.0, []
        for text, path, style in _LEGEND:
            x -= len(text) * 6.2 + 28
            parts.append(
                f'<path transform="translate({x:g} 3)" d="{path}" {style}/>'
                f'<text x="{x + 16:g}" y="12">{text}</text>'
            )
        return f'<svg x="{_share(_RIGHT)}" overflow="visible" font-size="11">{"".join(parts)}</svg>'

    def svg(self, theme: Theme | None, caption: str) -> str:
        """The whole picture."""
        height = self._bottom + _AXIS_PX
        colours = "" if theme is None else _colours(theme)
        characters = max(int((self._width - 300) / _CHARACTER_PX), 2)
        title = f"<title>{escaped(caption)}</title>" if len(caption) > characters else ""
        return (
            '<svg xmlns="http://www.w3.org/2000/svg" class="pounce-timeline" role="img"'
            f' aria-label="Timeline of the schedule" width="100%" height="{height}"'
            f' font-size="{_FONT_PX}" font-family="system-ui, sans-serif" fill="var(--ink)"'
            f' style="display:block;{colours}">'
            f"{_PAGE_STYLE if theme is None else ''}"
            f'<text x="4" y="12">{title}{escaped(shortened(caption, characters))}</text>'
            f"{self._legend()}{''.join(self._parts)}</svg>"
        )
