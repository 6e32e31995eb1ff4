"""Learning curves on the page."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from app.analysis.estimates import Axis
from app.charts.greedy import joined_up
from app.charts.model import AXIS_UNITS, Curves, Line, Mark, clear_marks, levels
from app.charts.page import svg
from app.charts.page.colours import colour_of
from app.charts.page.svg import Frame, Scale
from app.charts.styles import Style
from app.charts.wording import few_in_words, short_label
from app.util.html import escaped
from app.words.numbers import counted, labelled_ticks

_SAMPLE_PX = 28
"""Length of a line in the legend."""
_LEAST_WIDTH = 1.5
"""Lines thinner than this are lost on a projector."""
_FAINT = 0.55
_GREY = 0.4
"""Opacity of lines that another one is told from."""
_NAME_ROOM_PX = 110


def curves_html(chart: Curves, frame: Frame) -> str:
    """Learning curves with their intervals, and the moments at which skills joined.

    Where a variant is chosen, the others turn grey.

    Args:
        chart: of one panel.
        frame: what it is drawn for.
    """
    (panel,) = chart.panels
    lines = panel.lines
    there = [line for line in lines if line.band.mean.size]
    marks = clear_marks(line for line in lines if frame.is_told(line.place))
    plot = _plot_of(chart, there, marks, frame)
    parts = [_axes(plot, chart.axis), _marks_drawn(marks, plot)]
    for line in sorted(lines, key=lambda line: line.place == frame.chosen):
        look = _look_of(line.style, frame.is_told(line.place))
        parts += [_greedy_curve(line, look, plot), _curve(line, look, plot)]
    if not there:
        middle = (plot.x.start + plot.x.end) / 2, (plot.y.start + plot.y.end) / 2
        parts.append(svg.text(*middle, "No curve yet", "middle"))
    return (
        _legend(frame, lines)
        + svg.picture(frame.width, plot.y.start + 36, "Learning curves", "".join(parts))
        + svg.note(
            _lines_in_words(max((line.n for line in lines), default=0)),
            _GREEDY_IN_WORDS if any(line.greedy is not None for line in lines) else "",
            _marks_in_words(lines) if marks else "",
            few_in_words(line.n for line in lines),
            frame.note,
        )
    )


_GREEDY_IN_WORDS: Final = (
    "Thin, with dots: greedy reward, in hunts without random moves in which nothing is learned."
)


def _lines_in_words(most_runs: int) -> str:
    if most_runs <= 1:
        return "Each line is one run."
    return (
        "Lines are means over runs, shaded their 95 % intervals; faint where some runs have ended."
    )


class _Plot(NamedTuple):
    """Where curves are drawn."""

    x: Scale
    y: Scale
    factor: float
    """From steps or trials to numbers of the x axis."""
    levels: Sequence[int]
    """How high the name of each mark is written."""


def _plot_of(chart: Curves, there: Sequence[Line], marks: Sequence[Mark], frame: Frame) -> _Plot:
    width = frame.width
    factor, _ = AXIS_UNITS[chart.axis]
    end = max((float(line.band.end[-1]) for line in there), default=0.0) * factor or 1.0
    heights = levels([mark.at * factor / end * width for mark in marks], _NAME_ROOM_PX)
    means = [line.band.mean for line in there]
    means += [line.greedy.reward for line in there if line.greedy is not None]
    numbers = [*(chart.ends or ()), *(value for mean in means for value in _finite(mean))]
    low, high = min(numbers, default=0.0), max(numbers, default=0.0)
    if low == high:
        low, high = svg.padded([low])
    y = svg.upwards(low, high, frame.tall, top=10.0 + 13 * (max(heights, default=-1) + 1))
    return _Plot(Scale(0.0, end, svg.gutter(low, high) + 16, width - 14), y, factor, heights)


def _axes(plot: _Plot, axis: Axis) -> str:
    x, y = plot.x, plot.y
    zero = (
        f'<path d="M{x.start:.1f} {y.at(0):.1f}H{x.end:.1f}" stroke="currentColor"'
        ' stroke-opacity="0.4"/>'
    )
    return (
        svg.y_axis(y, x.start, x.end)
        + svg.x_axis(
            x, labelled_ticks(0, x.high, 8), (y.end, y.start), AXIS_UNITS[axis][1], x.end + 14
        )
        + f'<text transform="translate(11 {(y.end + y.start) / 2:.1f}) rotate(-90)"'
        f' text-anchor="middle"{svg.DIM}>mean reward per trial</text>'
        + (zero if y.low < 0 < y.high else "")
    )


def _marks_in_words(lines: Sequence[Line]) -> str:
    """What the marks are, and whose if they are not everybody's."""
    whose = [line.label for line in lines if line.marks]
    if len(whose) in (1, 2) and len(whose) < len(lines):
        names = " and ".join(short_label(label, 40) for label in whose)
        return f"Dashed: a skill joins in {names}."
    return "Dashed: a skill joins."


def _finite(numbers: np.ndarray) -> list[float]:
    return numbers[np.isfinite(numbers)].tolist()


def _marks_drawn(marks: Sequence[Mark], plot: _Plot) -> str:
    x, top, bottom = plot.x, plot.y.end, plot.y.start
    parts: list[str] = []
    for (moment, name), level in zip(marks, plot.levels, strict=True):
        at = x.at(moment * plot.factor)
        if at > x.end + 0.5:
            continue
        is_late = x.end - at < _NAME_ROOM_PX
        high = top - 13 * level
        parts.append(
            f'<path d="M{at:.1f} {high - 9:.1f}V{bottom:.1f}" stroke="currentColor"'
            ' stroke-opacity="0.55" stroke-dasharray="5 3"/>'
            + svg.text(
                at - 4 if is_late else at + 4,
                high - 2,
                short_label(name, int(_NAME_ROOM_PX / svg.SMALL_CHARACTER_PX)),
                "end" if is_late else "start",
                svg.SMALL + svg.DIM,
            )
        )
    return f'<g class="joined">{"".join(parts)}</g>'


class _Look(NamedTuple):
    """How a line is drawn."""

    colour: str
    width: float
    opacity: float
    dashes: Sequence[float] = ()
    """Lengths of dashes and gaps in line widths."""
    has_band: bool = True

    def dashed(self, width: float) -> str:
        """Its dashes as an attribute, if the line is so wide; nothing for a solid one."""
        dashes = " ".join(f"{length * width:.1f}" for length in self.dashes)
        return f' stroke-dasharray="{dashes}"' if dashes else ""


def _look_of(style: Style, is_told: bool) -> _Look:
    """The look of a line, which is grey and alone where another one is told from it."""
    if not is_told:
        return _Look("currentColor", 1.0, _GREY, has_band=False)
    return _Look(colour_of(style), max(style.width, _LEAST_WIDTH), 1.0, style.dashes)


def _curve(line: Line, look: _Look, plot: _Plot) -> str:
    """A mean with its interval."""
    band = line.band
    if not band.mean.size:
        return ""
    across, up = _across(band.at, plot), [_up(v, plot) for v in (band.mean, band.low, band.high)]
    first, rest = slice(0, line.n_whole), slice(max(line.n_whole - 1, 0), None)
    parts: list[str] = []
    if look.has_band:
        parts.append(
            f'<path class="band" d="{_ribbon(across, up[1], up[2])}" fill="{look.colour}"'
            ' fill-opacity="0.2"/>'
        )
    thin = max(0.6 * look.width, 1.2)
    for piece, share, thick in ((first, 1.0, look.width), (rest, _FAINT, thin)):
        path = _line_path(across[piece], up[0][piece])
        if path and (share == 1.0 or line.n_whole < band.n.size):
            parts.append(
                f'<path d="{path}" fill="none" stroke="{look.colour}" stroke-width="{thick:.2g}"'
                f' stroke-opacity="{share * look.opacity:.2g}" stroke-linejoin="round"'
                f"{look.dashed(thick)}/>"
            )
    return f'<g class="curve" data-variant="{line.place}">{"".join(parts)}</g>'


def _greedy_curve(line: Line, look: _Look, plot: _Plot) -> str:
    """Greedy means with their dots, without their interval; behind the curve that they belong to.

    It ends with the scale, which is of the other curves.
    """
    if line.greedy is None or not look.has_band:
        return ""
    is_inside = line.greedy.at * plot.factor <= plot.x.high
    x, y = _across(line.greedy.at, plot)[is_inside], _up(line.greedy.reward, plot)[is_inside]
    path = "".join(_line_path(x[part], y[part]) for part in joined_up(x))
    if not path:
        return ""
    dots = "".join(f"M{a:.1f} {b:.1f}h0" for a, b in zip(x.tolist(), y.tolist(), strict=True))
    return (
        f'<g class="greedy" data-variant="{line.place}" fill="none" stroke="{look.colour}">'
        f'<path d="{path}" stroke-width="0.9"/>'
        f'<path d="{dots}" stroke-width="3" stroke-linecap="round"/></g>'
    )


def _across(at: np.ndarray, plot: _Plot) -> np.ndarray:
    return plot.x.start + at * plot.factor / plot.x.high * (plot.x.end - plot.x.start)


def _up(values: np.ndarray, plot: _Plot) -> np.ndarray:
    y = plot.y
    return y.start + (values - y.low) / (y.high - y.low) * (y.end - y.start)


def _stretches(there: np.ndarray) -> list[slice]:
    """Where something is there without a gap."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], there.astype(np.int8), [0]))))
    return [slice(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _points(x: np.ndarray, y: np.ndarray) -> str:
    return "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))


def _line_path(x: np.ndarray, y: np.ndarray) -> str:
    """A line with its gaps; a point between two gaps becomes a dash."""
    parts: list[str] = []
    for part in _stretches(np.isfinite(y)):
        alone = part.stop - part.start == 1
        start = f"M{x[part.start] - 1:.1f} {y[part.start]:.1f}h2"
        parts.append(start if alone else f"M{_points(x[part], y[part])}")
    return "".join(parts)


def _ribbon(x: np.ndarray, low: np.ndarray, high: np.ndarray) -> str:
    parts: list[str] = []
    for part in _stretches(np.isfinite(low) & np.isfinite(high)):
        back = slice(part.start, part.stop)
        upper, lower = _points(x[part], high[part]), _points(x[back][::-1], low[back][::-1])
        parts.append(f"M{upper}L{lower}Z")
    return "".join(parts)


_COUNT = " (99 runs)"
"""As long as what is said of the runs of a curve."""


def _legend(frame: Frame, lines: Sequence[Line]) -> str:
    """Names of curves: in one line if they fit, else in at least two columns."""
    width = frame.width
    characters = int((width / 2 - _SAMPLE_PX - 20) / svg.CHARACTER_PX) - len(_COUNT)
    entries = [_legend_entry(frame, line, characters) for line in lines]
    names = [short_label(line.label, characters) for line in lines]
    widths = [_SAMPLE_PX + 18 + len(name + _COUNT) * svg.CHARACTER_PX for name in names]
    columns = f' style="grid-template-columns:repeat(auto-fill,minmax({max(widths):.0f}px,1fr))"'
    # Characters are narrower than allowed for, and if some are not, a second line does no harm.
    look = 'class="legend"' if 0.93 * sum(widths) <= width else f'class="legend grid"{columns}'
    return f"<div {look}>{''.join(entries)}</div>"


def _legend_entry(frame: Frame, line: Line, characters: int) -> str:
    look = _look_of(line.style, frame.is_told(line.place))
    sample = (
        f'<svg width="{_SAMPLE_PX}" height="10" aria-hidden="true"><path d="M0 5H{_SAMPLE_PX}"'
        f' stroke="{look.colour}" stroke-width="{look.width}" stroke-opacity="{look.opacity:g}"'
        f"{look.dashed(look.width)}/></svg>"
    )
    name = escaped(short_label(line.label, characters))
    runs = counted(line.n, "run")
    text = f'<span><span class="name">{name}</span> ({runs})</span>'
    title = f' title="{escaped(line.label)}: choose"'
    return svg.link(frame.address, f"variant/{line.place}", sample + text, title)
