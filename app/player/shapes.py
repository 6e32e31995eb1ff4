"""A picture as shapes, which are written as SVG or painted as pixels.

Lengths are in pixels of the picture, ``x`` to the right and ``y`` down from its upper left corner;
colours are as CSS writes them, ``rgb(1,2,3)``.
"""

import base64
import functools
import io
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from app.util.html import Markup, element, escaped, joined

Points = Sequence[tuple[float, float]]
Anchor = Literal["start", "middle", "end"]

_FINER: Final = 2
"""Times as large as wanted a picture is painted, and made smaller then: so edges are smooth."""
_FONTS: Final = "'DejaVu Sans',Verdana,system-ui,sans-serif"
_ANCHORS: Final = {"start": "ls", "middle": "ms", "end": "rs"}


@dataclass(frozen=True)
class Pixels:
    """Colours of equal rectangles."""

    x: float
    y: float
    wide: float
    high: float
    colours: np.ndarray
    """(row, column, 4) uint8: red, green, blue and how opaque, from the upper left on."""


@dataclass(frozen=True)
class Lines:
    """Lines of one look."""

    ways: Sequence[Points]
    colour: str
    width: float


@dataclass(frozen=True)
class Area:
    """A filled polygon."""

    points: Points
    colour: str


@dataclass(frozen=True)
class Disc:
    """A filled circle."""

    x: float
    y: float
    radius: float
    colour: str


@dataclass(frozen=True)
class Box:
    """A filled rectangle."""

    x: float
    y: float
    wide: float
    high: float
    colour: str
    opacity: float = 1.0
    radius: float = 0.0


@dataclass(frozen=True)
class Words:
    """One line of text."""

    x: float
    y: float
    """Of the line that it stands on."""
    text: str
    size: float
    colour: str
    anchor: Anchor = "start"
    is_bold: bool = False


Shape = Pixels | Lines | Area | Disc | Box | Words


class Picture(NamedTuple):
    """Shapes in their order, the last on top."""

    wide: int
    high: int
    shapes: tuple[Shape, ...]
    about: str = ""
    """What it shows, for those who cannot see it."""


def width_of(text: str, size: float) -> float:
    """How wide a line of text is, by the letters that pictures are painted with."""
    return _font(size).getlength(text) * 1.04


@functools.lru_cache(maxsize=32)
def _font(size: float) -> ImageFont.FreeTypeFont:
    font = ImageFont.load_default(size)
    assert isinstance(font, ImageFont.FreeTypeFont)
    return font


# --- As SVG --------------------------------------------------------------------------------------


def svg_of(picture: Picture, ground: str | None = None) -> Markup:
    """The picture as an element that may stand in a page, or in a file of its own.

    Args:
        picture: the picture.
        ground: what it stands on; None if one sees through.
    """
    shapes = list(picture.shapes)
    if ground is not None:
        shapes.insert(0, Box(0, 0, picture.wide, picture.high, ground))
    content = joined([element("title", picture.about), *map(_svg, shapes)], "")
    return Markup(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {picture.wide} {picture.high}"'
        f' width="{picture.wide}" height="{picture.high}" role="img">{content}</svg>'
    )


def _svg(shape: Shape) -> Markup:
    match shape:
        case Pixels(x, y, wide, high, colours):
            data = base64.b64encode(_png(colours)).decode()
            return Markup(
                f'<image x="{_n(x)}" y="{_n(y)}" width="{_n(wide)}" height="{_n(high)}"'
                ' preserveAspectRatio="none" image-rendering="pixelated"'
                f' href="data:image/png;base64,{data}"/>'
            )
        case Lines(ways, colour, width):
            path = "".join(map(_path, ways))
            return Markup(
                f'<path d="{path}" fill="none" stroke="{escaped(colour)}"'
                f' stroke-width="{_n(width)}" stroke-linecap="round" stroke-linejoin="round"/>'
            )
        case Area(points, colour):
            return Markup(f'<path d="{_path(points)}Z" fill="{escaped(colour)}"/>')
        case Disc(x, y, radius, colour):
            return Markup(
                f'<circle cx="{_n(x)}" cy="{_n(y)}" r="{_n(radius)}" fill="{escaped(colour)}"/>'
            )
        case Box(x, y, wide, high, colour, opacity, radius):
            return Markup(
                f'<rect x="{_n(x)}" y="{_n(y)}" width="{_n(wide)}" height="{_n(high)}"'
                f' rx="{_n(radius)}" fill="{escaped(colour)}" fill-opacity="{_n(opacity)}"/>'
            )
        case Words(x, y, text, size, colour, anchor, is_bold):
            weight = ' font-weight="600"' if is_bold else ""
            return Markup(
                f'<text x="{_n(x)}" y="{_n(y)}" font-size="{_n(size)}" font-family="{_FONTS}"'
                f' text-anchor="{anchor}" fill="{escaped(colour)}"{weight}>{escaped(text)}</text>'
            )


def _path(points: Points) -> str:
    return "M" + "L".join(f"{_n(x)} {_n(y)}" for x, y in points)


def _n(number: float) -> str:
    return f"{number:.2f}".rstrip("0").rstrip(".")


def _png(colours: np.ndarray) -> bytes:
    """Few colours take few bytes."""
    flat = np.ascontiguousarray(colours).view("<u4").ravel()
    palette, places = np.unique(flat, return_inverse=True)
    image = Image.fromarray(colours, "RGBA")
    if len(palette) <= 256:
        parts = palette.astype("<u4").view(np.uint8).reshape(-1, 4)
        image = Image.fromarray(places.reshape(colours.shape[:2]).astype(np.uint8), "P")
        image.putpalette(parts[:, :3].tobytes())
        image.info["transparency"] = parts[:, 3].tobytes()
    buffer = io.BytesIO()
    image.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


# --- As pixels -----------------------------------------------------------------------------------


def painted(picture: Picture, ground: str, scale: int = 1) -> np.ndarray:
    """The picture as pixels, (row, column, 3) uint8, on a ground of one colour.

    Args:
        picture: the picture.
        ground: what it stands on.
        scale: pixels along a side for each that it is said to have.
    """
    brush = _Brush(picture, ground, scale * _FINER)
    for shape in picture.shapes:
        brush.paint(shape)
    small = picture.wide * scale, picture.high * scale
    return np.asarray(brush.image.resize(small, Image.Resampling.BOX))


def _rgb(colour: str) -> tuple[int, int, int]:
    red, green, blue = (int(part) for part in re.findall(r"\d+", colour)[:3])
    return red, green, blue


class _Brush:
    """Paints shapes, a scale larger than they are."""

    def __init__(self, picture: Picture, ground: str, scale: int) -> None:
        size = picture.wide * scale, picture.high * scale
        self.image = Image.new("RGB", size, _rgb(ground))
        self._draw = ImageDraw.Draw(self.image)
        self._scale = scale

    def paint(self, shape: Shape) -> None:
        match shape:
            case Pixels(x, y, wide, high, colours):
                left, top, right, bottom = (
                    round(each * self._scale) for each in (x, y, x + wide, y + high)
                )
                patch = Image.fromarray(colours, "RGBA")
                patch = patch.resize((right - left, bottom - top), Image.Resampling.NEAREST)
                self.image.paste(patch, (left, top), patch)
            case Lines(ways, colour, width):
                wide = max(round(width * self._scale), 1)
                for way in ways:
                    self._draw.line(self._scaled(way), _rgb(colour), wide, joint="curve")
            case Area(points, colour):
                self._draw.polygon(self._scaled(points), _rgb(colour))
            case Disc(x, y, radius, colour):
                corners = self._scaled([(x - radius, y - radius), (x + radius, y + radius)])
                self._draw.ellipse(corners, _rgb(colour))
            case Box():
                self._box(shape)
            case Words(x, y, text, size, colour, anchor, is_bold):
                self._draw.text(
                    (x * self._scale, y * self._scale),
                    text,
                    _rgb(colour),
                    _font(size * self._scale),
                    _ANCHORS[anchor],
                    stroke_width=self._scale / 4 if is_bold else 0,
                    stroke_fill=_rgb(colour),
                )

    def _scaled(self, points: Points) -> list[tuple[float, float]]:
        return [(x * self._scale, y * self._scale) for x, y in points]

    def _box(self, box: Box) -> None:
        corners = self._scaled([(box.x, box.y), (box.x + box.wide, box.y + box.high)])
        if box.opacity == 1.0:
            self._draw.rounded_rectangle(corners, box.radius * self._scale, _rgb(box.colour))
            return
        (left, top), (right, bottom) = ((round(x), round(y)) for x, y in corners)
        mask = Image.new("L", (max(right - left, 1), max(bottom - top, 1)), 0)
        ImageDraw.Draw(mask).rounded_rectangle(
            [(0, 0), (mask.width - 1, mask.height - 1)],
            box.radius * self._scale,
            round(255 * box.opacity),
        )
        self.image.paste(_rgb(box.colour), (left, top), mask)


def wrapped(text: str, size: float, wide: float) -> Iterable[str]:
    """A text in lines that are no wider than that, but for a word that is."""
    line = ""
    for word in text.split():
        longer = f"{line} {word}" if line else word
        if line and width_of(longer, size) > wide:
            yield line
            line = word
        else:
            line = longer
    if line:
        yield line
