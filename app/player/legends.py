"""A layer's legend as shapes: it is read from the HTML that the layer has it as.

What a colour means is decided by the layer alone, which says so in HTML
(:mod:`app.picture.legend`); a picture in a file has the same words and patches, in lines that fit
it.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from html.parser import HTMLParser
from typing import Final, Literal

import numpy as np

from app.player.shapes import Area, Box, Disc, Lines, Pixels, Shape, Words, width_of, wrapped

_COLOUR: Final = re.compile(r"rgb\([\d, ]+\)")
_PATCH: Final = 0.9
"""Side of a patch in sizes of the type, and room after it."""
_GAP: Final = 0.35
_APART: Final = 0.8
_LEADING: Final = 1.5
_WIDE_PATCH: Final = 1.5
_WAYS: Final = {sign: (number % 3 - 1, number // 3 - 1) for number, sign in enumerate("↙↓↘←·→↖↑↗")}
"""East and north, by the signs of moves."""


@dataclass
class _Item:
    """A word, or a patch with what it means, that stays on one line."""

    text: str = ""
    patch: str = ""
    """The style of its patch; "prey" of the prey's sign."""
    is_bold: bool = False
    is_quiet: bool = False
    letter: str = ""
    """In the patch."""


@dataclass
class _Row:
    """What stands on lines of its own."""

    kind: Literal["items", "bar", "marks"]
    items: list[_Item] = field(default_factory=list[_Item])
    colours: Sequence[str] = ()
    marks: list[tuple[float, str]] = field(default_factory=list[tuple[float, str]])


class _Reader(HTMLParser):
    """Takes a legend apart into rows."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[_Row] = []
        self._open: list[tuple[str, str]] = []
        """Elements that are open, and their styles."""
        self._whole: _Item | None = None
        """What is not to be broken into lines, while it is read."""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        style = dict(attrs).get("style") or ""
        if tag == "div" and "linear-gradient" in style and not style.startswith("display"):
            self.rows.append(_Row("bar", colours=_COLOUR.findall(style)))
        elif tag == "div" and "position:relative" in style:
            self.rows.append(_Row("marks"))
        elif tag == "div" and self._open:
            self.rows.append(_Row("items"))
        elif tag == "span" and "white-space:nowrap" in style and "absolute" not in style:
            self._whole = _Item()
            self._add(self._whole)
        elif tag == "span" and "background" in style:
            if self._whole is None:
                self._add(_Item(patch=style))
            else:
                self._whole.patch = style
        elif tag == "svg" and self._whole is not None:
            self._whole.patch = "prey"
        self._open.append((tag, style))

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Parts of a sign, which is drawn by what it is."""

    def handle_endtag(self, tag: str) -> None:
        while self._open:
            closed, style = self._open.pop()
            if closed == "span" and "white-space:nowrap" in style:
                self._whole = None
            if closed == tag:
                return

    def handle_data(self, data: str) -> None:
        styles = [style for _, style in self._open]
        row = self.rows[-1] if self.rows else None
        if row is None:
            return
        if row.kind == "marks":
            left = re.search(r"left:([\d.]+)%", styles[-1])
            row.marks.append((float(left[1]) / 100 if left else 0.0, data))
        elif self._whole is not None:
            self._whole.text += data
        elif row.items and row.items[-1].patch and "background" in styles[-1]:
            row.items[-1].letter = data
        else:
            is_bold = any("font-weight" in style for style in styles)
            is_quiet = any("opacity" in style for style in styles)
            # What follows a word without a blank stays with it.
            follows = bool(row.items and row.items[-1].text) and not data[:1].isspace()
            for number, word in enumerate(data.split()):
                if follows and number == 0 and not row.items[-1].text.endswith(" "):
                    row.items[-1].text += word
                else:
                    row.items.append(_Item(word, is_bold=is_bold, is_quiet=is_quiet))
            if row.items and data[-1:].isspace() and row.items[-1].text:
                row.items[-1].text += " "

    def _add(self, item: _Item) -> None:
        if not self.rows:
            self.rows.append(_Row("items"))
        self.rows[-1].items.append(item)


def legend_shapes(
    html: str, x: float, y: float, wide: float, size: float, inks: tuple[str, str]
) -> tuple[list[Shape], float]:
    """A legend as shapes, and how high it is.

    Args:
        html: as the layer has it.
        x: left edge.
        y: upper edge.
        wide: room there is.
        size: of the type.
        inks: colours of writing, and of what steps back.
    """
    reader = _Reader()
    reader.feed(html)
    shapes: list[Shape] = []
    top = y
    for row in reader.rows:
        if row.kind == "bar":
            shapes.append(_bar(row.colours, x, top + 0.3 * size, wide, 0.9 * size))
            top += 1.3 * size
        elif row.kind == "marks":
            shapes += _marks(row.marks, x, top + size, wide, size, inks[0])
            top += _LEADING * size
        else:
            found, high = _items(row.items, x, top, wide, size, inks)
            shapes += found
            top += high
    return shapes, top - y


def _bar(colours: Sequence[str], x: float, y: float, wide: float, high: float) -> Pixels:
    stops = np.array([_parts(colour) for colour in colours], float)
    along = np.linspace(0, len(stops) - 1, 256)
    parts = [np.interp(along, np.arange(len(stops)), stops[:, part]) for part in range(3)]
    pixels = np.full((1, 256, 4), 255, np.uint8)
    pixels[0, :, :3] = np.rint(np.stack(parts, axis=1))
    return Pixels(x, y, wide, high, pixels)


def _parts(colour: str) -> list[int]:
    return [int(part) for part in re.findall(r"\d+", colour)[:3]]


def _marks(
    marks: Iterable[tuple[float, str]], x: float, y: float, wide: float, size: float, ink: str
) -> Iterator[Shape]:
    for at, text in marks:
        # A text stands inside the bar at its ends, and is centred in its middle.
        left = x + at * wide - at * width_of(text, size)
        yield Words(left, y, text, size, ink)


def _items(
    items: Sequence[_Item], x: float, y: float, wide: float, size: float, inks: tuple[str, str]
) -> tuple[list[Shape], float]:
    shapes: list[Shape] = []
    left, line = x, y + 1.1 * size
    if items and not any(item.patch for item in items):
        text = " ".join(item.text.strip() for item in items)
        ink = inks[1] if items[0].is_quiet else inks[0]
        lines = list(wrapped(text, size, wide))
        for number, words in enumerate(lines):
            at = line + number * _LEADING * size
            shapes.append(Words(x, at, words, size, ink, is_bold=items[0].is_bold))
        return shapes, (len(lines) * _LEADING) * size
    for item in items:
        text = item.text.rstrip()
        patch = (_WIDE_PATCH if "1.4em" in item.patch else _PATCH) * size if item.patch else 0.0
        room = patch + (_GAP * size if patch and text else 0.0) + width_of(text, size)
        if left > x and left + room > x + wide:
            left, line = x, line + _LEADING * size
        if patch:
            shapes += _patch(item, left, line - 0.8 * size, patch, _PATCH * size, inks[0])
            left += patch + (_GAP * size if text else 0.15 * size)
        if text:
            ink = inks[1] if item.is_quiet else inks[0]
            shapes.append(Words(left, line, text, size, ink, is_bold=item.is_bold))
            left += width_of(text, size)
        if text:
            left += (_APART if patch else 0.3) * size
    return shapes, line - y + 0.4 * size


def _patch(item: _Item, x: float, y: float, wide: float, high: float, ink: str) -> Iterator[Shape]:
    style, colours = item.patch, _COLOUR.findall(item.patch)
    middle, half = y + high / 2, high / 2
    if style == "prey":
        centre = x + 0.3 * wide
        yield Disc(centre, middle, 0.28 * half, ink)
        angles = np.linspace(-np.pi / 2, np.pi / 2, 17).tolist()
        arc = [(centre + half * np.cos(a), middle + half * np.sin(a)) for a in angles]
        yield Lines([[*arc, arc[0]]], ink, 1.2)
    elif "repeating-linear" in style:
        rises = "(-45deg" in style
        slant = [
            [(x + at, y + high), (x + at + high, y)]
            if rises
            else [(x + at, y), (x + at + high, y + high)]
            for at in np.arange(0, wide - high + 0.1, 0.3 * high).tolist()
        ]
        yield Lines(slant, colours[0], 1.5)
    elif "radial" in style:
        yield Box(x, y, wide, high, colours[1])
        for east in np.arange(0.2, wide / high, 0.4).tolist():
            for north in (0.25, 0.65):
                side = 0.2 * high
                yield Box(x + east * high - side / 2, y + north * high, side, side, colours[0])
    elif "border-radius:50%" in style:
        yield Disc(x + half, middle, half, colours[0])
    elif "rotate" in style:
        around = [(x, middle), (x + half, y), (x + high, middle), (x + half, y + high)]
        yield Area(around, colours[0])
    else:
        yield Box(x - 0.6, y - 0.6, wide + 1.2, high + 1.2, "rgb(128,128,128)", radius=2)
        yield Box(x, y, wide, high, colours[0], radius=1.5)
    if item.letter in _WAYS:
        # Few fonts have arrows.
        east, north = _WAYS[item.letter]
        white = "color:#fff" in style
        yield from _arrow(x + wide / 2, middle, east, north, 0.32 * high, white)


def _arrow(
    x: float, y: float, east: int, north: int, long: float, is_white: bool
) -> Iterator[Shape]:
    ink = "rgb(255,255,255)" if is_white else "rgb(17,17,17)"
    size = np.hypot(east, north)
    if not size:
        yield Disc(x, y, 0.4 * long, ink)
        return
    dx, dy = long * east / size, -long * north / size
    tip, tail = (x + dx, y + dy), (x - dx, y - dy)
    wings = [(x + turn * dy * 0.7, y - turn * dx * 0.7) for turn in (1, -1)]
    yield Lines([[tail, tip], [wings[0], tip, wings[1]]], ink, 1.2)
