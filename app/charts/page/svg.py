"""What charts on the page are made of: scales, axes, texts, links and what is said below them."""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Final, NamedTuple

from app.charts.wording import short_label
from app.util.html import escaped
from app.words.numbers import labelled_ticks

CALLS_FRAME: Final = "pounce-calls"
"""Name of the frame that links of the page are aimed at, so that the page stays where it is."""

Address = Callable[[str], str]
"""What a link refers to, to call the lab with these words."""

_FONT_PX = 12
CHARACTER_PX: Final = 6.5
"""Width of a character, on the safe side."""
SMALL_CHARACTER_PX: Final = 6.2
_TOP_PX = 22.0
"""Of a chart that has the name of its quantity above it."""
_PLOT_PX = 208.0
"""Height within the axes, on the smallest screen."""
DIM: Final = ' fill-opacity="0.75"'
"""Attributes of texts that step back, and of small ones."""
SMALL: Final = ' font-size="11"'
_Y_TICKS = 5
_PADDING = 0.05
"""Of a scale at both ends, as a share of it."""


class Frame(NamedTuple):
    """What a chart is drawn for."""

    address: Address
    """Of its links."""
    width: float
    """In pixels."""
    chosen: int | None = None
    """Place of the variant that stands out, if any."""
    tall: float = _PLOT_PX
    """Height within the axes of a chart, in pixels; of many rows it is more."""
    note: str = ""
    """What is said last below it, if anything."""

    def is_told(self, place: int) -> bool:
        """Whether a variant does not step back behind the chosen one."""
        return self.chosen in (None, place)


# --- Scales and axes -----------------------------------------------------------------------------


class Scale(NamedTuple):
    """From numbers to pixels."""

    low: float
    high: float
    start: float
    """Pixel of the low end, and of the high one."""
    end: float
    is_logarithmic: bool = False

    def at(self, value: float) -> float:
        """The pixel of a number."""
        low, high = self.low, self.high
        if self.is_logarithmic:
            low, high, value = math.log(low), math.log(high), math.log(value)
        return self.start + (value - low) / (high - low) * (self.end - self.start)


def padded(numbers: Iterable[float]) -> tuple[float, float]:
    """Ends of a scale on which all numbers find room."""
    there = [number for number in numbers if math.isfinite(number)]
    low, high = min(there, default=0.0), max(there, default=1.0)
    room = (high - low) * _PADDING or abs(high) * _PADDING or 0.5
    return low - room, high + room


def text(
    x: float, y: float, text: str, anchor: str = "start", extra: str = "", title: str = ""
) -> str:
    """A text in a picture; ``extra`` are attributes as markup, ``title`` is its hint."""
    hint = f"<title>{escaped(title)}</title>" if title else ""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{extra}>{hint}{escaped(text)}</text>'
    )


def x_axis(
    scale: Scale,
    marks: Sequence[tuple[float, str]],
    ends: tuple[float, float],
    label: str,
    width: float,
) -> str:
    """An axis from left to right with its label, and a line upwards at each mark.

    Args:
        scale: of the axis.
        marks: numbers, and what is written at them.
        ends: top and bottom of the lines, in pixels.
        label: below the axis, as near to its middle as a picture so wide lets it be.
        width: of the picture, in pixels.
    """
    top, bottom = ends
    lines = "".join(f"M{scale.at(value):.1f} {top:.1f}V{bottom:.1f}" for value, _ in marks)
    names = "".join(text(scale.at(value), bottom + 15, name, "middle") for value, name in marks)
    label = short_label(label, int(width / CHARACTER_PX))
    half = len(label) * CHARACTER_PX / 2
    middle = min(max((scale.start + scale.end) / 2, half), width - half)
    return (
        f'<path d="{lines}" stroke="currentColor" stroke-opacity="0.12" fill="none"/>'
        f'<path d="M{scale.start:.1f} {bottom:.1f}H{scale.end:.1f}" stroke="currentColor"'
        ' stroke-opacity="0.6"/>'
        f'<g class="x-ticks"{DIM}>{names}</g>' + text(middle, bottom + 31, label, "middle", DIM)
    )


def y_axis(scale: Scale, left: float, right: float) -> str:
    """An axis upwards, whose numbers find room in a :func:`gutter`, and a line at each of them."""
    marks = labelled_ticks(scale.low, scale.high, _Y_TICKS)
    lines = "".join(f"M{left:.1f} {scale.at(value):.1f}H{right:.1f}" for value, _ in marks)
    names = "".join(text(left - 6, scale.at(value), name, "end") for value, name in marks)
    return (
        f'<path d="{lines}" stroke="currentColor" stroke-opacity="0.12" fill="none"/>'
        f'<g class="y-ticks" dominant-baseline="central"{DIM}>{names}</g>'
    )


def gutter(low: float, high: float) -> float:
    """Room in pixels for the numbers of an axis upwards."""
    widest = max((len(name) for _, name in labelled_ticks(low, high, _Y_TICKS)), default=1)
    return widest * CHARACTER_PX + 12


def upwards(low: float, high: float, tall: float, top: float = _TOP_PX) -> Scale:
    """The scale of a chart so tall whose numbers go up."""
    return Scale(low, high, top + tall, top)


def quantity(what: str, width: float) -> str:
    """The name of what a chart shows, above its upper left corner."""
    label = short_label(what, int(width / CHARACTER_PX))
    return text(2, 11, label, "start", DIM)


def picture(width: float, height: float, label: str, content: str) -> str:
    """The whole of a picture, which shrinks with the page."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}"'
        f' width="100%" style="max-width:{width:.0f}px" role="group" aria-label="{escaped(label)}"'
        f' font-size="{_FONT_PX}" fill="currentColor">{content}</svg>'
    )


def note(*sentences: str) -> str:
    """What is said below a picture; sentences may be empty."""
    text = " ".join(sentence for sentence in sentences if sentence)
    return f'<p class="note">{escaped(text)}</p>' if text else ""


def link(address: Address, words: str, content: str, attributes: str = "") -> str:
    """A link that calls the lab; its content is markup already."""
    return f'<a href="{escaped(address(words))}" target="{CALLS_FRAME}"{attributes}>{content}</a>'


def frame_html() -> str:
    """The frame that answers to links go into; it stays empty.

    It has to stand where it is shown as long as the links are, so each panel has its own.
    """
    return f'<iframe name="{CALLS_FRAME}" title="" style="display:none"></iframe>'
