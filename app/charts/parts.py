"""What charts are made of: what they are asked for, colours, scales, axes, texts and links."""

import functools
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Final, NamedTuple

import cmap
import numpy as np

from app.analysis.estimates import LEAST_RUNS, Estimate
from app.charts.paper import MOST_STYLES, SKY_BLUE, THESIS_STYLES, Style, style_of
from app.documents.variants import Variant
from app.results.gather import Gathering
from app.util.html import escaped

Address = Callable[[str], str]
"""What a link refers to, to call the lab with these words."""

LINK: Final = "var(--pounce-link)"
FAILED: Final = "var(--pounce-failed)"
"""Colours that the page's style sheet has for light and dark pages (``app/web/looks.css``)."""

_RULES: Final = (
    ".pounce-results svg{display:block;overflow:visible}"
    ".pounce-results svg a{color:inherit}"
    ".pounce-results svg a:hover text{text-decoration:underline}"
    ".pounce-results svg a:hover .mark{stroke:currentColor;fill-opacity:1}"
    ".pounce-results svg a:hover .zone{fill:currentColor;fill-opacity:.12}"
    ".pounce-results .cells a:hover path{stroke:currentColor;stroke-width:2}"
    ".pounce-results .legend{display:flex;flex-wrap:wrap;gap:1px 12px;margin:2px 0 4px}"
    ".pounce-results .grid{display:grid;column-gap:0}"
    ".pounce-results .legend a{display:inline-flex;align-items:center;gap:6px;color:inherit}"
    ".pounce-results .legend a:hover .name{text-decoration:underline}"
    ".pounce-results .note{opacity:.75;margin:2px 0}"
)
_FONT_PX = 12
CHARACTER_PX: Final = 6.5
"""Width of a character, on the safe side."""
SMALL_CHARACTER_PX: Final = 6.2
TITLE_CHARACTERS: Final = 80
"""Of a label in the hint of a dot or a cell, of which there may be hundreds."""
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
_BRIGHTEST_ON_WHITE, _DARKEST_ON_BLACK = 0.295, 0.27
"""Luminance of lines: 3 to 1 against white, and nearly 5 to 1 against a dark page, where lines and
dots look thinner."""


class Context(NamedTuple):
    """What every chart is asked for."""

    gathering: Gathering
    """What it is of."""
    address: Address
    """Of its links."""
    width: float
    """In pixels."""
    chosen: int | None = None
    """Place of the variant that stands out, if any."""
    tall: float = _PLOT_PX
    """Height within the axes of a chart, in pixels; of many rows it is more."""

    @property
    def variants(self) -> Sequence[Variant]:
        """Those of the experiment."""
        return self.gathering.experiment.variants

    def is_told(self, place: int) -> bool:
        """Whether a variant does not step back behind the chosen one."""
        return self.chosen in (None, place)


# --- Colours -------------------------------------------------------------------------------------


def styles_of(variants: Sequence[Variant]) -> list[Style]:
    """Styles of variants that are shown together: the thesis's own where they are its learners."""
    presets = [variant.preset for variant in variants]
    if len(set(presets)) == len(presets) and set(presets) <= THESIS_STYLES.keys():
        return [THESIS_STYLES[preset] for preset in presets]
    styles = map(style_of, range(len(variants)))
    return [style._replace(dashes=_LONG) if _is_light_blue(style) else style for style in styles]


_LONG = (12.0, 2.5)


def _is_light_blue(style: Style) -> bool:
    """Whether a line, in colours that can be read on any page, would look like a solid blue one."""
    return style.colour == SKY_BLUE and not style.dashes


def colour_of(style: Style) -> str:
    """The colour of a style, as a name that the style sheet explains for light and dark pages.

    Black becomes the ink of the page; others keep their hue.
    """
    is_black = np.ptp(_parts(style.colour)) < 0.05
    return "currentColor" if is_black else f"var({_name_of(style.colour)})"


def shades_of(colour: str) -> tuple[str, str]:
    """A colour made to stand out from white, and from nearly black."""
    linear = _linear(_parts(colour))
    luminance = _luminance(linear)
    return (
        _gamma(linear * min(_BRIGHTEST_ON_WHITE / luminance, 1)),
        _gamma(linear * max(_DARKEST_ON_BLACK / luminance, 1)),
    )


def _name_of(colour: str) -> str:
    return f"--line-{colour[1:].lower()}"


def _parts(colour: str) -> np.ndarray:
    return np.asarray([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255


def _gamma(linear: np.ndarray) -> str:
    return _hex(np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055))


def _linear(parts: np.ndarray) -> np.ndarray:
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


def _luminance(linear: np.ndarray) -> float:
    return float(linear @ np.array([0.2126, 0.7152, 0.0722]))


def _hex(parts: np.ndarray) -> str:
    return "#" + "".join(f"{round(255 * float(part)):02x}" for part in np.clip(parts, 0, 1))


@functools.cache
def style_sheet() -> str:
    """What the charts need of a style sheet."""
    styles = (*THESIS_STYLES.values(), *map(style_of, range(MOST_STYLES)))
    shades = {_name_of(style.colour): shades_of(style.colour) for style in styles}
    light, dark = (
        "".join(f"{name}:{shade[theme]};" for name, shade in shades.items()) for theme in (0, 1)
    )
    return (
        f".pounce-results{{{light}}}"
        f'[data-mantine-color-scheme="dark"] .pounce-results{{{dark}}}{_RULES}'
    )


_HEAT_COLOURS = 64


@functools.cache
def heat() -> tuple[Sequence[str], Sequence[str]]:
    """Colours from low to high, and what is written on each of them."""
    colours = cmap.Colormap("viridis")(np.linspace(0, 1, _HEAT_COLOURS))[:, :3]
    # Black and white are equally far from this luminance.
    inks = ["#000" if _luminance(_linear(colour)) > 0.18 else "#fff" for colour in colours]
    return [_hex(colour) for colour in colours], inks


# --- Scales and axes -----------------------------------------------------------------------------


def ticks(low: float, high: float, most: int) -> list[float]:
    """Round numbers (multiples of 1, 2 or 5 times a power of ten) from low to high."""
    width = _tick_width(low, high, most)
    first, last = math.ceil(low / width - 1e-9), math.floor(high / width + 1e-9)
    return [index * width for index in range(first, last + 1)]


def _tick_width(low: float, high: float, most: int) -> float:
    rough = max(high - low, 1e-12) / most
    power = 10.0 ** math.floor(math.log10(rough))
    return next(power * k for k in (1, 2, 5, 10) if power * k >= rough * (1 - 1e-9))


def labelled(low: float, high: float, most: int) -> list[tuple[float, str]]:
    """Ticks with what is written at them."""
    decimals = max(-math.floor(math.log10(_tick_width(low, high, most)) + 1e-9), 0)
    return [(tick, _signed(f"{tick:,.{decimals}f}")) for tick in ticks(low, high, most)]


def _signed(number: str) -> str:
    return number.replace("-", "\N{MINUS SIGN}")


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


def svg_text(
    x: float, y: float, text: str, anchor: str = "start", extra: str = "", title: str = ""
) -> str:
    """A text in a picture; ``extra`` are attributes as markup, ``title`` is its hint."""
    hint = f"<title>{escaped(title)}</title>" if title else ""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{extra}>{hint}{escaped(text)}</text>'
    )


def x_axis(
    scale: Scale, marks: Sequence[tuple[float, str]], top: float, bottom: float, label: str
) -> str:
    """An axis from left to right with its label, and a line upwards at each mark."""
    lines = "".join(f"M{scale.at(value):.1f} {top:.1f}V{bottom:.1f}" for value, _ in marks)
    names = "".join(svg_text(scale.at(value), bottom + 15, name, "middle") for value, name in marks)
    middle = (scale.start + scale.end) / 2
    most = int((scale.end - scale.start) * 1.2 / CHARACTER_PX)
    return (
        f'<path d="{lines}" stroke="currentColor" stroke-opacity="0.12" fill="none"/>'
        f'<path d="M{scale.start:.1f} {bottom:.1f}H{scale.end:.1f}" stroke="currentColor"'
        ' stroke-opacity="0.6"/>'
        f'<g class="x-ticks"{DIM}>{names}</g>'
        + svg_text(middle, bottom + 31, shortened(label, most), "middle", DIM)
    )


def y_axis(scale: Scale, left: float, right: float) -> str:
    """An axis upwards, whose numbers find room in a :func:`gutter`, and a line at each of them."""
    marks = labelled(scale.low, scale.high, _Y_TICKS)
    lines = "".join(f"M{left:.1f} {scale.at(value):.1f}H{right:.1f}" for value, _ in marks)
    names = "".join(svg_text(left - 6, scale.at(value), name, "end") for value, name in marks)
    return (
        f'<path d="{lines}" stroke="currentColor" stroke-opacity="0.12" fill="none"/>'
        f'<g class="y-ticks" dominant-baseline="central"{DIM}>{names}</g>'
    )


def gutter(low: float, high: float) -> float:
    """Room in pixels for the numbers of an axis upwards."""
    widest = max((len(name) for _, name in labelled(low, high, _Y_TICKS)), default=1)
    return widest * CHARACTER_PX + 12


def upwards(low: float, high: float, tall: float, top: float = _TOP_PX) -> Scale:
    """The scale of a chart so tall whose numbers go up."""
    return Scale(low, high, top + tall, top)


def quantity(context: Context) -> str:
    """The name of what a chart shows, above its upper left corner."""
    label = shortened(context.gathering.metric.label, int(context.width / CHARACTER_PX))
    return svg_text(2, 11, label, "start", DIM)


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
    # The name of the frame keeps the page where it is: the answer is shown nowhere.
    return f'<a href="{escaped(address(words))}" target="pounce-calls"{attributes}>{content}</a>'


# --- Texts ---------------------------------------------------------------------------------------


def shortened(text: str, characters: int) -> str:
    """A text that fits; of ``name, key=value``, as variants are called, the values stay."""
    if len(text) <= characters:
        return text
    parts = text.split(_BETWEEN)
    lengths = [len(f"…={part.rpartition('=')[2]}") if "=" in part else 1 for part in parts]
    lengths = [min(length, len(part)) for length, part in zip(lengths, parts, strict=True)]
    room = characters - len(_BETWEEN) * (len(parts) - 1) - sum(lengths)
    if room < 0 or len(parts) == 1:
        kept = max(characters - 1, 0)
        return f"{text[: kept - kept // 2]}…{text[len(text) - kept // 2 :]}"
    # First what lacks least, so that what it leaves is there for the others.
    order = sorted(range(len(parts)), key=lambda index: len(parts[index]) - lengths[index])
    for taken, index in enumerate(order):
        more = min(len(parts[index]) - lengths[index], room // (len(parts) - taken))
        lengths[index] += more
        room -= more
    return _BETWEEN.join(map(_cut, parts, lengths))


def _cut(part: str, characters: int) -> str:
    """Part of a label without the beginning of its key; a name without its end."""
    if len(part) <= characters:
        return part
    kept = characters - 1
    return f"…{part[len(part) - kept :]}" if "=" in part else f"{part[:kept]}…"


_BETWEEN = ", "


def shown_number(value: float, digits: int = 3) -> str:
    """A number with so many digits, also where they are zero; a dash where there is none."""
    if math.isnan(value):
        return "–"
    if abs(value) >= 10 ** max(digits, 3):
        return _signed(f"{value:,.0f}")
    return _signed(f"{value:#.{digits}g}".rstrip("."))


def shown_mean(estimate: Estimate) -> str:
    """A mean with its interval, all of them with as many digits."""
    value = shown_number(estimate.value)
    if math.isnan(estimate.low):
        return value
    return f"{value} [{shown_number(estimate.low)}, {shown_number(estimate.high)}]"


def runs_in_words(n: int) -> str:
    """How many runs there are."""
    return "1 run" if n == 1 else f"{n:,} runs"


def few_in_words(counts: Iterable[int]) -> str:
    """A warning where intervals cannot be wide enough, or where there are none."""
    there = {n for n in counts if n > 0}
    if there == {1}:
        return "One run has no interval."
    return (
        f"With fewer than {LEAST_RUNS} runs, intervals are too narrow"
        f"{', and of one there is none' if 1 in there else ''}."
        if any(n < LEAST_RUNS for n in there)
        else ""
    )


def described(variant: Variant, estimate: Estimate) -> str:
    """A variant with its mean, for a hint."""
    label = shortened(variant.label, TITLE_CHARACTERS)
    if not estimate.n:
        return f"{label}: no run yet"
    return f"{label}: {shown_mean(estimate)}, n = {estimate.n:,}"


def missing(gathering: Gathering) -> str:
    """Runs without a dot, in words."""
    failed = sum(1 for run in gathering.runs if run.error)
    without = sum(1 for run in gathering.runs if not run.error and math.isnan(run.value))
    return " ".join(
        [f"{runs_in_words(failed)} failed."] * (failed > 0)
        + [f"{runs_in_words(without)} without a value."] * (without > 0)
    )
