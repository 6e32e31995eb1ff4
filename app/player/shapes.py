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


def svg_of(picture: Picture) -> Markup:
    """The picture as an element that may stand in a page, or in a file of its own."""
    content = joined([element("title", picture.about), *map(_svg, picture.shapes)], "")
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


def painted(picture: Picture, ground: str = "rgb(255,255,255)") -> np.ndarray:
    """The picture as pixels, (row, column, 3) uint8, on a ground of one colour."""
    size = picture.wide * _FINER, picture.high * _FINER
    image = Image.new("RGB", size, _rgb(ground))
    draw = ImageDraw.Draw(image)
    for shape in picture.shapes:
        _paint(image, draw, shape)
    small = image.resize((picture.wide, picture.high), Image.Resampling.BOX)
    return np.asarray(small)


def _rgb(colour: str) -> tuple[int, int, int]:
    red, green, blue = (int(part) for part in re.findall(r"\d+", colour)[:3])
    return red, green, blue


def _scaled(points: Points) -> list[tuple[float, float]]:
    return [(x * _FINER, y * _FINER) for x, y in points]


def _paint(image: Image.Image, draw: ImageDraw.ImageDraw, shape: Shape) -> None:
    match shape:
        case Pixels(x, y, wide, high, colours):
            left, top, right, bottom = (round(v * _FINER) for v in (x, y, x + wide, y + high))
            patch = Image.fromarray(colours, "RGBA")
            patch = patch.resize((right - left, bottom - top), Image.Resampling.NEAREST)
            image.paste(patch, (left, top), patch)
        case Lines(ways, colour, width):
            wide = max(round(width * _FINER), 1)
            for way in ways:
                draw.line(_scaled(way), _rgb(colour), wide, joint="curve")
        case Area(points, colour):
            draw.polygon(_scaled(points), _rgb(colour))
        case Disc(x, y, radius, colour):
            low, high = _scaled([(x - radius, y - radius), (x + radius, y + radius)])
            draw.ellipse([low, high], _rgb(colour))
        case Box():
            _paint_box(image, shape)
        case Words(x, y, text, size, colour, anchor, is_bold):
            draw.text(
                (x * _FINER, y * _FINER),
                text,
                _rgb(colour),
                _font(size * _FINER),
                _ANCHORS[anchor],
                stroke_width=_FINER / 4 if is_bold else 0,
                stroke_fill=_rgb(colour),
            )


def _paint_box(image: Image.Image, box: Box) -> None:
    mask = Image.new("L", image.size, 0)
    corners = _scaled([(box.x, box.y), (box.x + box.wide, box.y + box.high)])
    ImageDraw.Draw(mask).rounded_rectangle(corners, box.radius * _FINER, round(255 * box.opacity))
    image.paste(_rgb(box.colour), mask=mask)


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
