"""Charts of the results of an experiment, as HTML whose parts are links: pure functions.

Texts and axes take the colour of the page, and lines have colours that stand out from white and
from nearly black, so that one chart is right in both themes. Every link calls the lab with words:
``variant/PLACE`` chooses a variant, ``open/KEY`` opens a run. Places are pixels of a picture that
is as wide as it is asked to be, and that shrinks with the page.
"""

import functools
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Final, NamedTuple

import cmap
import numpy as np

from app.experiments import Variant
from app.figures import (
    THESIS_STYLES,
    Axle,
    Style,
    grouped,
    style_of,
)
from app.gathered import MOST_CURVES, Curve, Gathering, RunFact
from app.markup import escaped
from app.narrate import plain
from app.statistics import LEAST_RUNS, Axis, Estimate
from app.sweep import Sweep

Address = Callable[[str], str]
"""What a link refers to, to call the lab with these words."""

_TOO_FEW = f"With fewer than {LEAST_RUNS} runs, intervals are too narrow."
MOST_ROWS: Final = 24
"""Variants that have a row of their own; more become columns without labels."""
MOST_COLUMNS: Final = 200
"""Variants that have a column of their own; of more, neighbours share one."""
MOST_DOTS: Final = 1_500
"""Runs that are drawn one by one."""
MOST_LINKED_DOTS: Final = 240
"""Dots that are links, which take a hundred times the room of one that is not."""

LINK: Final = "#1c7ed6"
FAILED: Final = "#e03131"

STYLE: Final = (
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
"""What the charts need of a style sheet."""

_UNITS: Final[dict[Axis, tuple[float, str]]] = {
    "steps": (1e-6, "simulation steps (millions)"),
    "trials": (1e-3, "trials (thousands)"),
}
_FONT_PX = 12
_CHARACTER_PX = 6.5
"""Width of a character, on the safe side."""
_BOLD_PX = 7.2
_TITLE_CHARACTERS = 80
"""Of a label in the hint of a dot or a cell, of which there may be hundreds."""
_SMALL_PX = 11
_SMALL_CHARACTER_PX = 6.2
_LARGEST_GUTTER = 0.36
"""Share of the width that labels of rows may take."""
_SAMPLE_PX = 28
"""Length of a line in the legend."""
_LEAST_WIDTH = 1.5
"""Lines thinner than this are lost on a projector."""
_FAINT = 0.55
_GREY = 0.4
"""Opacity of lines that another one is told from."""
_DARKEST, _BRIGHTEST = 0.15, 0.36
"""Luminance of lines: at least 2.5 to 1 against white, and 3 to 1 against a dark page."""


# --- Colours -------------------------------------------------------------------------------------


def styles_of(variants: Sequence[Variant]) -> list[Style]:
    """Styles of variants that are shown together: the thesis's own where they are its learners."""
    presets = [variant.preset for variant in variants]
    if len(set(presets)) == len(presets) and set(presets) <= THESIS_STYLES.keys():
        return [THESIS_STYLES[preset] for preset in presets]
    styles = [style_of(index) for index in range(len(variants))]
    # In colours that can be read on any page, the two solid blue lines would look alike.
    return [style._replace(dashes=_LONG) if k == 5 else style for k, style in enumerate(styles)]


_LONG = (12.0, 2.5)


@functools.cache
def colour_of(style: Style) -> str:
    """The colour of a style, made to stand out from white and from nearly black.

    Black becomes the ink of the page; others keep their hue.
    """
    parts = np.asarray([int(style.colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    if np.ptp(parts) < 0.05:
        return "currentColor"
    linear = _linear(parts)
    luminance = _luminance(linear)
    linear = linear * (np.clip(luminance, _DARKEST, _BRIGHTEST) / luminance)
    return _hex(np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055))


def _linear(parts: np.ndarray) -> np.ndarray:
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


def _luminance(linear: np.ndarray) -> float:
    return float(linear @ np.array([0.2126, 0.7152, 0.0722]))


def _hex(parts: np.ndarray) -> str:
    return "#" + "".join(f"{round(255 * float(part)):02x}" for part in np.clip(parts, 0, 1))


_HEAT_COLOURS = 64


@functools.cache
def _heat() -> tuple[Sequence[str], Sequence[str]]:
    """Colours from low to high, and what is written on each of them."""
    colours = cmap.Colormap("viridis")(np.linspace(0, 1, _HEAT_COLOURS))[:, :3]
    # Black and white are equally far from this luminance.
    inks = ["#000" if _luminance(_linear(colour)) > 0.18 else "#fff" for colour in colours]
    return [_hex(colour) for colour in colours], inks


# --- Scales and axes -----------------------------------------------------------------------------


def ticks(low: float, high: float, most: int = 6) -> list[float]:
    """Round numbers (multiples of 1, 2 or 5 times a power of ten) from low to high."""
    width = _tick_width(low, high, most)
    first, last = math.ceil(low / width - 1e-9), math.floor(high / width + 1e-9)
    return [index * width for index in range(first, last + 1)]


def _tick_width(low: float, high: float, most: int) -> float:
    rough = max(high - low, 1e-12) / most
    power = 10.0 ** math.floor(math.log10(rough))
    return next(power * k for k in (1, 2, 5, 10) if power * k >= rough * (1 - 1e-9))


def _labelled(low: float, high: float, most: int) -> list[tuple[float, str]]:
    """Ticks with what is written at them."""
    decimals = max(-math.floor(math.log10(_tick_width(low, high, most)) + 1e-9), 0)
    return [(tick, _signed(f"{tick:,.{decimals}f}")) for tick in ticks(low, high, most)]


def _signed(number: str) -> str:
    return number.replace("-", "\N{MINUS SIGN}")


class _Scale(NamedTuple):
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


def _padded(numbers: Iterable[float], share: float = 0.05) -> tuple[float, float]:
    """Ends of a scale on which all numbers find room."""
    there = [number for number in numbers if math.isfinite(number)]
    low, high = min(there, default=0.0), max(there, default=1.0)
    room = (high - low) * share or abs(high) * share or 0.5
    return low - room, high + room


def _text(
    x: float, y: float, text: str, anchor: str = "start", extra: str = "", title: str = ""
) -> str:
    hint = f"<title>{escaped(title)}</title>" if title else ""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{extra}>{hint}{escaped(text)}</text>'
    )


_DIM = ' fill-opacity="0.75"'
_SMALL = f' font-size="{_SMALL_PX}"'


def _x_axis(
    scale: _Scale, marks: Sequence[tuple[float, str]], top: float, bottom: float, label: str
) -> str:
    lines = "".join(f"M{scale.at(value):.1f} {top:.1f}V{bottom:.1f}" for value, _ in marks)
    names = "".join(_text(scale.at(value), bottom + 15, name, "middle") for value, name in marks)
    middle = (scale.start + scale.end) / 2
    most = int((scale.end - scale.start) * 1.2 / _CHARACTER_PX)
    return (
        f'<path d="{lines}" stroke="currentColor" stroke-opacity="0.12" fill="none"/>'
        f'<path d="M{scale.start:.1f} {bottom:.1f}H{scale.end:.1f}" stroke="currentColor"'
        ' stroke-opacity="0.6"/>'
        f'<g class="x-ticks"{_DIM}>{names}</g>'
        + _text(middle, bottom + 31, shortened(label, most), "middle", _DIM)
    )


def _y_axis(scale: _Scale, left: float, right: float, most: int = 5) -> str:
    marks = _labelled(scale.low, scale.high, most)
    lines = "".join(f"M{left:.1f} {scale.at(value):.1f}H{right:.1f}" for value, _ in marks)
    names = "".join(_text(left - 6, scale.at(value), name, "end") for value, name in marks)
    return (
        f'<path d="{lines}" stroke="currentColor" stroke-opacity="0.12" fill="none"/>'
        f'<g class="y-ticks" dominant-baseline="central"{_DIM}>{names}</g>'
    )


def _gutter(scale_low: float, scale_high: float, most: int = 5) -> float:
    """Room for the numbers of an axis on its left."""
    widest = max((len(name) for _, name in _labelled(scale_low, scale_high, most)), default=1)
    return widest * _CHARACTER_PX + 12


def _svg(width: float, height: float, label: str, content: str) -> str:
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}"'
        f' width="100%" style="max-width:{width:.0f}px" role="group" aria-label="{escaped(label)}"'
        f' font-size="{_FONT_PX}" fill="currentColor">{content}</svg>'
    )


def _note(*sentences: str) -> str:
    text = " ".join(sentence for sentence in sentences if sentence)
    return f'<p class="note">{escaped(text)}</p>' if text else ""


def link(address: Address, words: str, content: str, attributes: str = "") -> str:
    """A link that calls the lab; its content is markup already."""
    # The name of the frame keeps the page where it is: the answer is shown nowhere.
    return f'<a href="{escaped(address(words))}" target="pounce-calls"{attributes}>{content}</a>'


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


def _shown_mean(estimate: Estimate) -> str:
    """A mean with its interval, all of them with as many digits."""
    value = shown_number(estimate.value)
    if math.isnan(estimate.low):
        return value
    return f"{value} [{shown_number(estimate.low)}, {shown_number(estimate.high)}]"


def _runs_in_words(n: int) -> str:
    return "1 run" if n == 1 else f"{n:,} runs"


# --- Learning curves -----------------------------------------------------------------------------


def curves(
    gathering: Gathering,
    found: Sequence[Curve],
    axis: Axis,
    address: Address,
    width: float,
    chosen: int | None = None,
) -> str:
    """Learning curves with their intervals, and the moments at which skills joined.

    Args:
        gathering: what they are from.
        found: curves of at most ``MOST_CURVES`` variants.
        axis: what they are drawn against.
        address: of links.
        width: in pixels.
        chosen: place of the variant that is told from the others, which turn grey.
    """
    variants = [gathering.experiment.variants[curve.variant] for curve in found]
    styles = styles_of(variants)
    factor, unit = _UNITS[axis]
    told = [curve for curve in found if chosen in (None, curve.variant)]
    marks = _common_marks(told, axis)
    drawn = [curve for curve in found if curve.band.mean.size]
    end = max((float(curve.band.end[-1]) for curve in drawn), default=0.0) * factor or 1.0

    levels = _levels([at * factor / end * width for at, _ in marks])
    top = 10.0 + 13 * (max(levels, default=-1) + 1)
    bottom = top + min(max(0.32 * width, 200), 320)
    means = [value for curve in drawn for value in _finite(curve.band.mean)]
    low, high = min([gathering.low, *means]), max([gathering.high, *means])
    if low == high:
        low, high = _padded([low])
    left = _gutter(low, high) + 16
    x = _Scale(0.0, end, left, width - 14)
    y = _Scale(low, high, bottom, top)

    parts = [
        _y_axis(y, x.start, x.end),
        _x_axis(x, _labelled(0, end, 8), top, bottom, unit),
        f'<text transform="translate(11 {(top + bottom) / 2:.1f}) rotate(-90)"'
        f' text-anchor="middle"{_DIM}>mean reward per trial</text>',
    ]
    if low < 0 < high:
        parts.append(
            f'<path d="M{x.start:.1f} {y.at(0):.1f}H{x.end:.1f}" stroke="currentColor"'
            ' stroke-opacity="0.4"/>'
        )
    parts.append(_marks_drawn(marks, levels, x, factor, top, bottom))
    for curve, style in sorted(
        zip(found, styles, strict=True), key=lambda pair: pair[0].variant == chosen
    ):
        is_told = chosen in (None, curve.variant)
        parts.append(_curve(curve, style, is_told, x, y, factor))
    if not drawn:
        parts.append(_text((x.start + x.end) / 2, (top + bottom) / 2, "No curve yet", "middle"))
    left_out = len(gathering.experiment.variants) - len(found)
    return (
        _legend(variants, found, styles, address, width, chosen)
        + _svg(width, bottom + 36, "Learning curves", "".join(parts))
        + _note(
            "Lines are means over runs, shaded their 95 % intervals; faint where some runs have"
            " ended.",
            _marks_in_words(variants, found) if marks else "",
            _few_in_words(curve.n for curve in found),
            f"{left_out:,} other variants are not drawn; choose any of them in another chart."
            if left_out
            else "",
        )
    )


def _few_in_words(counts: Iterable[int]) -> str:
    """A warning where intervals cannot be wide enough."""
    return _TOO_FEW if any(0 < n < LEAST_RUNS for n in counts) else ""


def _marks_in_words(variants: Sequence[Variant], found: Sequence[Curve]) -> str:
    """What the marks are, and whose if they are not everybody's."""
    whose = [v.label for v, curve in zip(variants, found, strict=True) if curve.joined]
    if len(whose) in (1, 2) and len(whose) < len(found):
        names = " and ".join(shortened(label, 40) for label in whose)
        return f"Dashed: a skill joins in {names}."
    return "Dashed: a skill joins."


def _finite(numbers: np.ndarray) -> list[float]:
    return numbers[np.isfinite(numbers)].tolist()


def _common_marks(found: Sequence[Curve], axis: Axis) -> list[tuple[float, str]]:
    """When skills joined; nothing where curves differ in it, as nobody could see which is whose."""
    each = {
        tuple(sorted((m.step if axis == "steps" else m.trial, plain(m.skill)) for m in c.joined))
        for c in found
        if c.joined
    }
    return list(each.pop()) if len(each) == 1 else []


_NAME_ROOM_PX = 110


def _levels(places: Sequence[float]) -> list[int]:
    """How high each of several names in a row is written, so that none lies on the next one."""
    levels: list[int] = []
    following, level = math.inf, 0
    for place in reversed(places):
        level = level + 1 if following - place < _NAME_ROOM_PX else 0
        following = place
        levels.insert(0, level)
    return levels


def _marks_drawn(
    marks: Sequence[tuple[float, str]],
    levels: Sequence[int],
    x: _Scale,
    factor: float,
    top: float,
    bottom: float,
) -> str:
    parts = []
    for (moment, name), level in zip(marks, levels, strict=True):
        at = x.at(moment * factor)
        if at > x.end + 0.5:
            continue
        is_late = x.end - at < _NAME_ROOM_PX
        high = top - 13 * level
        parts.append(
            f'<path d="M{at:.1f} {high - 9:.1f}V{bottom:.1f}" stroke="currentColor"'
            ' stroke-opacity="0.55" stroke-dasharray="5 3"/>'
            + _text(
                at - 4 if is_late else at + 4,
                high - 2,
                shortened(name, int(_NAME_ROOM_PX / _SMALL_CHARACTER_PX)),
                "end" if is_late else "start",
                _SMALL + _DIM,
            )
        )
    return f'<g class="joined">{"".join(parts)}</g>'


def _curve(curve: Curve, style: Style, is_told: bool, x: _Scale, y: _Scale, factor: float) -> str:
    """A mean with its interval; the mean alone, and in grey, where another one is told from it."""
    band = curve.band
    if not band.mean.size:
        return ""
    across = x.start + band.middle * factor / x.high * (x.end - x.start)
    up = [y.start + (v - y.low) / (y.high - y.low) * (y.end - y.start) for v in band[2:5]]
    fewer = np.flatnonzero(band.n < curve.n)
    all_there = int(fewer[0]) if fewer.size else band.n.size
    first, rest = slice(0, all_there), slice(max(all_there - 1, 0), None)
    colour, width = _look_of(style, is_told)
    strength = 1.0 if is_told else _GREY
    parts = []
    if is_told:
        parts.append(
            f'<path class="band" d="{_ribbon(across, up[1], up[2])}" fill="{colour}"'
            ' fill-opacity="0.2"/>'
        )
    # The runs that go on longest may not be typical: what they alone say is drawn faintly.
    for piece, share, thick in ((first, 1.0, width), (rest, _FAINT, max(0.6 * width, 1.2))):
        path = _line_path(across[piece], up[0][piece])
        if path and (share == 1.0 or all_there < band.n.size):
            dashes = " ".join(f"{d * thick:.1f}" for d in style.dashes) if is_told else ""
            parts.append(
                f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="{thick:.2g}"'
                f' stroke-opacity="{share * strength:.2g}" stroke-linejoin="round"'
                + (f' stroke-dasharray="{dashes}"/>' if dashes else "/>")
            )
    return f'<g class="curve" data-variant="{curve.variant}">{"".join(parts)}</g>'


def _look_of(style: Style, is_told: bool) -> tuple[str, float]:
    """Colour and width of a line."""
    return (colour_of(style), max(style.width, _LEAST_WIDTH)) if is_told else ("currentColor", 1.0)


def _stretches(there: np.ndarray) -> list[slice]:
    """Where something is there without a gap."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], there.astype(np.int8), [0]))))
    return [slice(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _points(x: np.ndarray, y: np.ndarray) -> str:
    return "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))


def _line_path(x: np.ndarray, y: np.ndarray) -> str:
    """A line with its gaps; a point between two gaps becomes a dash."""
    parts = []
    for part in _stretches(np.isfinite(y)):
        alone = part.stop - part.start == 1
        start = f"M{x[part.start] - 1:.1f} {y[part.start]:.1f}h2"
        parts.append(start if alone else f"M{_points(x[part], y[part])}")
    return "".join(parts)


def _ribbon(x: np.ndarray, low: np.ndarray, high: np.ndarray) -> str:
    parts = []
    for part in _stretches(np.isfinite(low) & np.isfinite(high)):
        back = slice(part.start, part.stop)
        upper, lower = _points(x[part], high[part]), _points(x[back][::-1], low[back][::-1])
        parts.append(f"M{upper}L{lower}Z")
    return "".join(parts)


_COUNT = " (99 runs)"
"""As long as what is said of the runs of a curve."""


def _legend(
    variants: Sequence[Variant],
    found: Sequence[Curve],
    styles: Sequence[Style],
    address: Address,
    width: float,
    chosen: int | None,
) -> str:
    """Names of curves: in one line if they fit, else in at least two columns."""
    characters = int((width / 2 - _SAMPLE_PX - 20) / _CHARACTER_PX) - len(_COUNT)
    entries = [
        _legend_entry(variant, curve, style, chosen in (None, curve.variant), address, characters)
        for variant, curve, style in zip(variants, found, styles, strict=True)
    ]
    widths = [
        _SAMPLE_PX + 18 + len(shortened(v.label, characters) + _COUNT) * _CHARACTER_PX
        for v in variants
    ]
    columns = f' style="grid-template-columns:repeat(auto-fill,minmax({max(widths):.0f}px,1fr))"'
    # Characters are narrower than allowed for, and if some are not, a second line does no harm.
    look = 'class="legend"' if 0.93 * sum(widths) <= width else f'class="legend grid"{columns}'
    return f"<div {look}>{''.join(entries)}</div>"


def _legend_entry(
    variant: Variant,
    curve: Curve,
    style: Style,
    is_told: bool,
    address: Address,
    characters: int,
) -> str:
    colour, width = _look_of(style, is_told)
    dashes = " ".join(f"{d * width:.1f}" for d in style.dashes) if is_told else ""
    sample = (
        f'<svg width="{_SAMPLE_PX}" height="10" aria-hidden="true"><path d="M0 5H{_SAMPLE_PX}"'
        f' stroke="{colour}" stroke-width="{width}" stroke-opacity="{1 if is_told else _GREY}"'
        + (f' stroke-dasharray="{dashes}"/></svg>' if dashes else "/></svg>")
    )
    name = escaped(shortened(variant.label, characters))
    text = f'<span><span class="name">{name}</span> ({_runs_in_words(curve.n)})</span>'
    title = f' title="{escaped(variant.label)}: choose"'
    return link(address, f"variant/{curve.variant}", sample + text, title)


# --- Every run a dot -----------------------------------------------------------------------------


def runs(
    gathering: Gathering,
    estimates: Sequence[Estimate],
    address: Address,
    width: float,
    chosen: int | None = None,
) -> str:
    """Every run a dot at its value, with mean and interval of each variant.

    A row for each variant; a column for each where there are more than ``MOST_ROWS``.

    Args:
        gathering: the runs.
        estimates: means by the place of their variant.
        address: of links.
        width: in pixels.
        chosen: place of the variant that is highlighted.
    """
    if len(gathering.experiment.variants) <= MOST_ROWS:
        return _rows(gathering, estimates, address, width, chosen)
    return _columns(gathering, estimates, address, width, chosen)


def _with_value(gathering: Gathering) -> list[RunFact]:
    return [run for run in gathering.runs if not run.error and math.isfinite(run.value)]


def _value_range(dots: Sequence[RunFact], estimates: Sequence[Estimate]) -> tuple[float, float]:
    values = [run.value for run in dots]
    return _padded([*values, *(number for e in estimates for number in e[:3])])


def _jitter(seed: int) -> float:
    """A number from -0.5 to 0.5, the same for a seed every time; far apart for seeds in a row."""
    return (9 * (seed % 3) + 3 * (seed // 3 % 3) + seed // 9 % 3) / 26 - 0.5


def _missing(gathering: Gathering) -> str:
    """Runs without a dot, in words."""
    failed = sum(1 for run in gathering.runs if run.error)
    without = sum(1 for run in gathering.runs if not run.error and math.isnan(run.value))
    return " ".join(
        [f"{_runs_in_words(failed)} failed."] * (failed > 0)
        + [f"{_runs_in_words(without)} without a value."] * (without > 0)
    )


def _rows(
    gathering: Gathering,
    estimates: Sequence[Estimate],
    address: Address,
    width: float,
    chosen: int | None,
) -> str:
    variants = gathering.experiment.variants
    dots = _with_value(gathering)
    linked, plainly = _dots_by_use(dots, chosen)
    means = [_shown_mean(estimate) for estimate in estimates]
    counts = [f"n = {estimate.n:,}" for estimate in estimates]
    widest = max(len(variant.label) for variant in variants)
    left = min(widest * _BOLD_PX + 14, _LARGEST_GUTTER * width)
    count_px = max(map(len, counts)) * _CHARACTER_PX + 4
    right = width - max(map(len, means)) * _CHARACTER_PX - count_px - 16
    x = _Scale(*_value_range(dots, estimates), left, right)
    row = 26 if len(variants) <= MOST_CURVES else 18
    top, bottom = 4.0, 8.0 + row * len(variants)
    middles = [top + 2 + row * (place + 0.5) for place in range(len(variants))]
    colours = _row_colours(variants)

    parts = [
        _x_axis(
            x, _labelled(x.low, x.high, max(int((right - left) / 70), 2)), top, bottom,
            gathering.metric.label,
        )
    ]  # fmt: skip
    for place, (variant, middle) in enumerate(zip(variants, middles, strict=True)):
        strength = 1.0 if chosen in (None, place) else 0.35
        name = _text(
            left - 10,
            middle + 4,
            shortened(variant.label, int((left - 14) / _BOLD_PX)),
            "end",
            f' fill="{LINK}"' + (' font-weight="700"' if place == chosen else ""),
            title=variant.label,
        )
        by_row = [run for run in linked if run.variant == place]
        others = [run for run in plainly if run.variant == place]
        parts.append(
            link(address, f"variant/{place}", name)
            + f'<g class="row" data-variant="{place}" fill="{colours[place]}"'
            f' opacity="{strength}">'
            + _plain_dots(
                [(x.at(r.value), middle + _jitter(r.seed) * row * 0.6) for r in others],
                colours[place],
            )
            + '<g fill-opacity="0.75" stroke="transparent" stroke-width="2">'
            + "".join(
                _linked_dot(run, variant, x, middle + _jitter(run.seed) * row * 0.6, address)
                for run in by_row
            )
            + "</g>"
            + _mean_across(estimates[place], x, middle, row)
            + "</g>"
            + _text(right + 12, middle + 4, means[place])
            + _text(width - 2, middle + 4, counts[place], "end", _DIM)
        )
    return _svg(width, bottom + 36, "Every run", "".join(parts)) + _note(
        _few_in_words(estimate.n for estimate in estimates),
        _dots_in_words(linked, plainly, dots),
        _missing(gathering),
    )


def _row_colours(variants: Sequence[Variant]) -> list[str]:
    """As the curves have them where there are as few; one colour for all where there are more."""
    if len(variants) <= MOST_CURVES:
        return [colour_of(style) for style in styles_of(variants)]
    return [LINK] * len(variants)


def _dots_by_use(
    dots: Sequence[RunFact], chosen: int | None
) -> tuple[Sequence[RunFact], Sequence[RunFact]]:
    """Runs whose dots are links, and runs whose dots are only drawn."""
    if len(dots) <= MOST_LINKED_DOTS:
        return dots, ()
    mine = [run for run in dots if run.variant == chosen]
    if len(mine) > MOST_LINKED_DOTS:
        mine = []
    rest = () if len(dots) > MOST_DOTS else [r for r in dots if not mine or r.variant != chosen]
    return mine, rest


def _dots_in_words(
    linked: Sequence[RunFact], plainly: Sequence[RunFact], dots: Sequence[RunFact]
) -> str:
    mean = "the tick is the mean, the bar its 95 % interval."
    if len(linked) == len(dots):
        return f"Each dot is a run, which a click opens; {mean}"
    if plainly:
        which = "those of the chosen variant" if linked else "rows of the table"
        return f"Each dot is a run; a click opens {which}; {mean}"
    if linked:
        return f"Dots are the runs of the chosen variant, which a click opens; {mean}"
    return f"{len(dots):,} runs are too many to draw one by one: only means and intervals are."


def _linked_dot(run: RunFact, variant: Variant, x: _Scale, y: float, address: Address) -> str:
    value = shown_number(run.value)
    label = shortened(variant.label, _TITLE_CHARACTERS)
    title = f"{label}, seed {run.seed}: {value} - click to open this run in the lab"
    dot = f'<circle class="mark" cx="{x.at(run.value):.1f}" cy="{y:.1f}" r="3.5"/>'
    return link(address, f"open/{run.key}", f"<title>{escaped(title)}</title>{dot}")


def _plain_dots(places: Iterable[tuple[float, float]], colour: str) -> str:
    """Dots as one path: strokes without length have round ends."""
    path = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in places)
    if not path:
        return ""
    return (
        f'<path class="dots" d="{path}" stroke="{colour}" stroke-width="4" stroke-linecap="round"'
        ' stroke-opacity="0.55" fill="none"/>'
    )


def _mean_across(estimate: Estimate, x: _Scale, y: float, row: float) -> str:
    if math.isnan(estimate.value):
        return ""
    at, half = x.at(estimate.value), row * 0.36
    bar = ""
    if math.isfinite(estimate.low):
        bar = (
            f'<path class="interval" d="M{x.at(estimate.low):.1f} {y:.1f}'
            f'H{x.at(estimate.high):.1f}" stroke-width="5" stroke-opacity="0.4"/>'
        )
    return (
        f'<g stroke="currentColor" pointer-events="none">{bar}<path class="mean"'
        f' d="M{at:.1f} {y - half:.1f}v{2 * half:.1f}" stroke-width="3"/></g>'
    )


def _columns(
    gathering: Gathering,
    estimates: Sequence[Estimate],
    address: Address,
    width: float,
    chosen: int | None,
) -> str:
    variants = gathering.experiment.variants
    dots = _with_value(gathering)
    low, high = _value_range(dots, estimates)
    top = 22.0
    bottom = top + min(max(0.32 * width, 200), 320)
    left = _gutter(low, high)
    y = _Scale(low, high, bottom, top)
    x = _Scale(0.5, len(variants) + 0.5, left, width - 10)
    step = (x.end - x.start) / len(variants)
    whole = [(tick, name) for tick, name in _labelled(1, len(variants), 8) if tick == int(tick)]

    parts = [
        _text(2, 11, shortened(gathering.metric.label, int(width / _CHARACTER_PX)), "start", _DIM),
        _y_axis(y, x.start, x.end),
        _x_axis(x, whole, top, bottom, "variant, in the order of the experiment"),
    ]
    if chosen is not None:
        parts.append(
            f'<path class="chosen" d="M{x.at(chosen + 1):.1f} {top}V{bottom:.1f}" stroke="{LINK}"'
            f' stroke-opacity="0.35" stroke-width="{max(step, 4):.1f}"/>'
        )
    shown = dots if len(dots) <= MOST_DOTS else ()
    parts.append(
        _plain_dots(
            (
                (x.at(run.variant + 1) + _jitter(run.seed) * min(step, 12) * 0.6, y.at(run.value))
                for run in shown
            ),
            LINK,
        )
    )
    parts.append(_means_up(estimates, x, y, min(max(step * 0.8, 2), 12)))
    parts += _zones(variants, estimates, x, (top, bottom), address)
    has_intervals = any(math.isfinite(estimate.low) for estimate in estimates)
    interval = ", the line its 95 % interval" if has_intervals else ""
    mean = f"the dash is the mean{interval}. A click chooses a variant."
    return _svg(width, bottom + 36, "Every run", "".join(parts)) + _note(
        _few_in_words(estimate.n for estimate in estimates),
        f"Each dot is a run; {mean}"
        if shown
        else f"{len(dots):,} runs are too many to draw one by one: {mean}",
        _missing(gathering),
    )


def _means_up(estimates: Sequence[Estimate], x: _Scale, y: _Scale, wide: float) -> str:
    means, bars = [], []
    for place, estimate in enumerate(estimates):
        if math.isnan(estimate.value):
            continue
        at = x.at(place + 1)
        means.append(f"M{at - wide / 2:.1f} {y.at(estimate.value):.1f}h{wide:.1f}")
        if math.isfinite(estimate.low):
            bars.append(f"M{at:.1f} {y.at(estimate.low):.1f}V{y.at(estimate.high):.1f}")
    return (
        '<g stroke="currentColor" fill="none">'
        f'<path class="interval" d="{"".join(bars)}" stroke-opacity="0.5" stroke-width="1.5"/>'
        f'<path class="mean" d="{"".join(means)}" stroke-width="2.5"/></g>'
    )


def _zones(
    variants: Sequence[Variant],
    estimates: Sequence[Estimate],
    x: _Scale,
    ends: tuple[float, float],
    address: Address,
) -> Iterable[str]:
    """What can be clicked: each column; of columns too narrow for it, some with their highest."""
    together = math.ceil(len(variants) / MOST_COLUMNS)
    for first in range(0, len(variants), together):
        places = range(first, min(first + together, len(variants)))
        place = max(places, key=lambda p: np.nan_to_num(estimates[p].value, nan=-math.inf))
        a, b = x.at(first + 0.5), x.at(places[-1] + 1.5)
        highest = "" if together == 1 else f"highest of {places[0] + 1} to {places[-1] + 1}: "
        title = f"{highest}{_described(variants[place], estimates[place])}"
        yield link(
            address,
            f"variant/{place}",
            f"<title>{escaped(title)}</title>"
            f'<path class="zone" d="M{a:.1f} {ends[0]:.0f}H{b:.1f}V{ends[1]:.0f}H{a:.1f}Z"'
            ' fill="transparent"/>',
        )


def _described(variant: Variant, estimate: Estimate) -> str:
    label = shortened(variant.label, _TITLE_CHARACTERS)
    if not estimate.n:
        return f"{label}: no run yet"
    return f"{label}: {_shown_mean(estimate)}, n = {estimate.n:,}"


# --- Sweeps --------------------------------------------------------------------------------------


def plane(
    gathering: Gathering,
    sweep: Sweep,
    estimates: Sequence[Estimate],
    address: Address,
    width: float,
    chosen: int | None = None,
    own: int | None = None,
) -> str:
    """Two settings swept together: a map of the plane, each cell with its value.

    Cells have equal sizes whatever their values; those without runs stay hatched.

    Args:
        gathering: what it is from.
        sweep: with two axles; its places are those of the experiment.
        estimates: means by the place of their variant.
        address: of links.
        width: in pixels.
        chosen: place of the variant that is highlighted.
        own: place of the variant that has the preset's own values, if there is one.
    """
    across, up = sweep.axles
    n_across, n_up = len(across.values), len(up.values)
    there = [estimates[place].value for place in sweep.places.values()]
    low, high = _ends_of(there)
    names_up = [shortened(grouped(value), 16) for value in up.values]
    bar_gutter = _gutter(low, high) + 22
    left = max(map(len, names_up)) * _CHARACTER_PX + 12
    top, tall = 36.0, min(max(220 / n_up, 18), 34)
    bottom = top + tall * n_up
    right = width - bar_gutter - 14
    wide = (right - left) / n_across
    most = int(width / _CHARACTER_PX)

    parts = [
        _text(width - 2, 12, shortened(gathering.metric.label, most), "end", _DIM),
        _text(2, 28, f"↑ {shortened(up.label, int(right / _CHARACTER_PX))}", "start", _DIM),
        _text(
            (left + right) / 2,
            bottom + 32,
            f"{shortened(across.label, most - 2)} →",
            "middle",
            _DIM,
        ),
        _names_across(across, left, wide, bottom + 16),
        '<g class="y-ticks" dominant-baseline="central">',
        *(
            _text(left - 7, bottom - tall * (j + 0.5), name, "end", _DIM)
            for j, name in enumerate(names_up)
        ),
        "</g>",
        _colour_bar(right + 22, top, bottom, low, high),
    ]
    outline = ""
    parts.append(f'<g class="cells" text-anchor="middle"{_SMALL}>')
    for i in range(n_across):
        for j in range(n_up):
            box = _Box(left + wide * i, bottom - tall * (j + 1), wide, tall)
            place = sweep.places.get((i, j))
            if place is None:
                parts.append(_empty_cell(box))
                continue
            variant, estimate = gathering.experiment.variants[place], estimates[place]
            title = f"<title>{escaped(_described(variant, estimate))}</title>"
            cell = _cell(box, estimate.value, low, high)
            parts.append(link(address, f"variant/{place}", title + cell))
            if place == own:
                outline += (
                    f'<g class="own" fill="none" pointer-events="none"><path d="{box.path}"'
                    f' stroke="#fff" stroke-width="2"/><path d="{box.path}" stroke="#000"'
                    ' stroke-width="2" stroke-dasharray="4 4"/></g>'
                )
            if place == chosen:
                # White within black shows on every colour of the map.
                outline += (
                    f'<g class="chosen" fill="none" pointer-events="none"><path d="{box.path}"'
                    f' stroke="#000" stroke-width="5"/><path d="{box.path}" stroke="#fff"'
                    ' stroke-width="2"/></g>'
                )
    return _svg(
        width, bottom + 38, "Plane of two settings", f"{''.join(parts)}</g>{outline}"
    ) + _note(
        f"Each cell is the mean of {_each_in_words(estimates)}, its interval under the pointer; a"
        " click chooses it.",
        "" if own is None else "Dashed frame: the preset's own setting.",
        _few_in_words(estimate.n for estimate in estimates),
        _missing(gathering),
    )


def _each_in_words(estimates: Sequence[Estimate]) -> str:
    fewest, most = min(e.n for e in estimates), max(e.n for e in estimates)
    return _runs_in_words(most) if fewest == most else f"{fewest:,} to {_runs_in_words(most)}"


class _Box(NamedTuple):
    """Where a cell is drawn."""

    x: float
    y: float
    width: float
    height: float

    @property
    def path(self) -> str:
        """Its outline, with a gap to the next one."""
        w, h = self.width - 1, self.height - 1
        return f"M{self.x:.1f} {self.y:.1f}h{w:.1f}v{h:.1f}h{-w:.1f}z"


def _ends_of(values: Sequence[float]) -> tuple[float, float]:
    found = [value for value in values if math.isfinite(value)]
    low, high = min(found, default=0.0), max(found, default=1.0)
    return (low, high) if low < high else _padded([low])


def _cell(box: _Box, value: float, low: float, high: float) -> str:
    if math.isnan(value):
        return _empty_cell(box)
    colours, inks = _heat()
    index = round((value - low) / (high - low) * (_HEAT_COLOURS - 1))
    text = shown_number(value)
    name = ""
    if len(text) * _SMALL_CHARACTER_PX + 3 <= box.width:
        at = box.x + (box.width - 1) / 2, box.y + (box.height - 1) / 2 + 4
        name = f'<text x="{at[0]:.1f}" y="{at[1]:.1f}" fill="{inks[index]}">{text}</text>'
    return f'<path d="{box.path}" fill="{colours[index]}"/>{name}'


def _empty_cell(box: _Box) -> str:
    w, h = box.width - 1, box.height - 1
    # Lines from the lower left to the upper right, as far apart as a third of the height.
    hatching = "".join(
        f"M{box.x + k * w / 4:.1f} {box.y + h:.1f}l{w / 4:.1f} {-h:.1f}" for k in range(4)
    )
    return (
        f'<path class="empty" d="{box.path}" fill="transparent" stroke="currentColor"'
        f' stroke-opacity="0.25"/><path d="{hatching}" stroke="currentColor" stroke-opacity="0.2"/>'
    )


def _names_across(axle: Axle, left: float, wide: float, y: float) -> str:
    """Values of cells in a row; only as many as have room."""
    names = [grouped(value) for value in axle.values]
    room = max(int(3 * wide / _CHARACTER_PX), 4)
    names = [shortened(name, max(room, 8)) for name in names]
    every = math.ceil(max(len(name) * _CHARACTER_PX + 6 for name in names) / wide)
    texts = (
        _text(left + wide * (i + 0.5), y, name, "middle", _DIM)
        for i, name in enumerate(names)
        if i % every == 0
    )
    return f'<g class="x-ticks">{"".join(texts)}</g>'


def _colour_bar(x: float, top: float, bottom: float, low: float, high: float) -> str:
    colours, _ = _heat()
    shown = colours[::3]
    tall = (bottom - top) / len(shown)
    # A hair more than its share for each, so that no page shines through between two of them.
    stripes = "".join(
        f'<path d="M{x:.1f} {bottom - tall * (k + 1):.1f}h14v{tall + 0.4:.1f}h-14z"'
        f' fill="{colour}"/>'
        for k, colour in enumerate(shown)
    )
    scale = _Scale(low, high, bottom, top)
    names = "".join(
        _text(x + 19, scale.at(value) + 4, name, "start", _DIM)
        for value, name in _labelled(low, high, 5)
    )
    return f'<g class="colour-bar">{stripes}{names}</g>'


def line(
    gathering: Gathering,
    sweep: Sweep,
    estimates: Sequence[Estimate],
    address: Address,
    width: float,
    chosen: int | None = None,
) -> str:
    """One setting swept: means with intervals against its value.

    Args:
        gathering: what it is from.
        sweep: with one axle; its places are those of the experiment.
        estimates: means by the place of their variant.
        address: of links.
        width: in pixels.
        chosen: place of the variant that is highlighted.
    """
    (axle,) = sweep.axles
    there = {index: estimates[place] for (index,), place in sweep.places.items()}
    low, high = _padded([number for estimate in there.values() for number in estimate[:3]])
    left = _gutter(low, high)
    top = 22.0
    bottom = top + min(max(0.32 * width, 200), 320)
    y = _Scale(low, high, bottom, top)
    x, values = _values_across(axle, left + 20, width - 34)
    marks = _names_of(axle, x, values)

    drawn = [i for i in sorted(there) if math.isfinite(there[i].value)]
    path = "L".join(f"{x.at(values[i]):.1f} {y.at(there[i].value):.1f}" for i in drawn)
    parts = [
        _text(2, 11, shortened(gathering.metric.label, int(width / _CHARACTER_PX)), "start", _DIM),
        _y_axis(y, left, width - 10),
        _x_axis(x, marks, top, bottom, axle.label),
        f'<path d="M{path}" fill="none" stroke="{LINK}" stroke-opacity="0.5"/>' if path else "",
    ]
    for (index,), place in sweep.places.items():
        estimate, at = there[index], x.at(values[index])
        title = _described(gathering.experiment.variants[place], estimate)
        is_there = math.isfinite(estimate.value)
        high_up = y.at(estimate.value) if is_there else bottom
        if math.isfinite(estimate.low):
            parts.append(
                f'<path class="interval" d="M{at:.1f} {y.at(estimate.low):.1f}'
                f'V{y.at(estimate.high):.1f}" stroke="{LINK}" stroke-width="2"/>'
            )
        look = f'fill="{LINK}"' if is_there else 'fill="transparent"'
        ring = ' stroke="currentColor" stroke-width="2.5"' if place == chosen else ""
        faint = "" if is_there else ' stroke="currentColor" stroke-opacity="0.4"'
        radius = (4.5 if len(there) <= 40 else 3) + 2 * (place == chosen)
        dot = (
            f'<circle class="mark" cx="{at:.1f}" cy="{high_up:.1f}"'
            f' r="{radius:g}" {look}{ring or faint}/>'
        )
        parts.append(link(address, f"variant/{place}", f"<title>{escaped(title)}</title>{dot}"))
    n = [estimate.n for estimate in there.values()]
    each = f"{min(n):,}" if min(n) == max(n) else f"{min(n):,} to {max(n):,}"
    return _svg(width, bottom + 36, "One setting swept", "".join(parts)) + _note(
        _few_in_words(estimate.n for estimate in estimates),
        f"Means with their 95 % intervals, n = {each}; a click chooses a variant.",
        _missing(gathering),
    )


def _values_across(axle: Axle, start: float, end: float) -> tuple[_Scale, Sequence[float]]:
    """The scale of a setting, and where each of its values lies on it."""
    if not axle.is_numeric or (axle.is_crowded and not axle.is_logarithmic):
        n = len(axle.values)
        return _Scale(0, n - 1, start, end), [float(i) for i in range(n)]
    values = [float(value) for value in axle.values]
    return _Scale(min(values), max(values), start, end, axle.is_logarithmic), values


def _names_of(axle: Axle, x: _Scale, values: Sequence[float]) -> list[tuple[float, str]]:
    """Ticks at values of a setting that have room for their names; at round ones on a scale."""
    if axle.is_numeric and not axle.is_logarithmic and not axle.is_crowded:
        return _labelled(x.low, x.high, 8)
    named: list[tuple[float, str]] = []
    free = -math.inf
    for at, value in zip(values, axle.values, strict=True):
        name = shortened(grouped(value), 14)
        half = len(name) * _CHARACTER_PX / 2 + 3
        if x.at(at) - half >= free:
            named.append((at, name))
            free = x.at(at) + half
    return named
