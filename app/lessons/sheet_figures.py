"""Figures of a printed sheet, in black and white: to be drawn into, and with what came of it.

All are SVG elements without scripts; lengths are in their own units, ``wide`` of which fill a line.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from app.documents.lesson_grammar import OCTANTS
from app.documents.lesson_questions import Asked
from app.lessons.spread import CurveBand, Spread
from app.util.html import Markup, element, joined
from app.words.numbers import ticks

_INK: Final = "#000"
_PALE: Final = "#999"
_WIDE: Final = 640
_LEFT, _RIGHT = 52, 28
_STRIP_HIGH: Final = 64
_FRAME_HIGH: Final = 250
_COMPASS: Final = 210
_RADIUS: Final = 78
_MOST_TICKS: Final = 8
_MOST_REWARDS: Final = 6


def _svg(wide: float, high: float, about: str, parts: Iterable[Markup]) -> Markup:
    content = joined([element("title", about), *parts], "")
    of = {"viewBox": f"0 0 {wide:g} {high:g}", "style": f"max-width:{wide:g}px"}
    return element("svg", content, class_="figure", role="img", **of)


def _line(x1: float, y1: float, x2: float, y2: float, colour: str = _INK, w: float = 1) -> Markup:
    return _shape(_way([(x1, y1), (x2, y2)]), stroke=colour, **{"stroke-width": f"{w:g}"})


def _way(points: Sequence[tuple[float, float]]) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)


def _words(x: float, y: float, text: str, anchor: str = "middle") -> Markup:
    place = {"x": f"{x:.1f}", "y": f"{y:.1f}", "text-anchor": anchor, "font-size": "12"}
    return element("text", text, **place)


def _shape(d: str, fill: str = "none", stroke: str = "none", **more: str) -> Markup:
    return element("path", "", d=d, fill=fill, stroke=stroke, **more)


# --- Octants -------------------------------------------------------------------------------------


def compass(about: str, filled: Mapping[str, float] | None = None, n: int = 0) -> Markup:
    """The eight octants round a prey that looks right.

    Args:
        about: what it is, for those who cannot see it.
        filled: in how many runs each is among those of the answer; None for an empty one.
        n: runs in all.
    """
    middle = _COMPASS / 2
    parts: list[Markup] = []
    for place, octant in enumerate(OCTANTS):
        corners = [_at(middle, (place + off) * 45, _RADIUS) for off in (-0.5, 0.5)]
        arc = (
            f"M{middle:g} {middle:g}L{corners[0][0]:.1f} {corners[0][1]:.1f}"
            f"A{_RADIUS} {_RADIUS} 0 0 0 {corners[1][0]:.1f} {corners[1][1]:.1f}Z"
        )
        count = (filled or {}).get(octant, 0)
        # Grey enough to be told from white on any printer, and numbers on it can be read.
        grey = 255 - round(105 * count / n) if n else 255
        parts.append(_shape(arc, f"rgb({grey},{grey},{grey})", _INK))
        if n:
            x, y = _at(middle, place * 45, _RADIUS * 0.68)
            parts.append(_words(x, y + 4, f"{count:.0f}"))
    # The prey, the way it looks, and what it sees.
    seen = _RADIUS * 0.36
    half = f"M{middle:g} {middle - seen:g}A{seen:g} {seen:g} 0 0 1 {middle:g} {middle + seen:g}Z"
    parts.append(_shape(half, "#fff", _INK, **{"stroke-dasharray": "3 3"}))
    parts.append(_line(middle, middle, middle + 24, middle, w=2.5))
    tip = [(middle + 33, middle), (middle + 22, middle - 5), (middle + 22, middle + 5)]
    parts.append(_shape(_way(tip) + "Z", _INK))
    parts.append(element("circle", "", cx=f"{middle:g}", cy=f"{middle:g}", r="5", fill=_INK))
    return _svg(_COMPASS, _COMPASS, about, parts)


def _at(middle: float, degrees: float, radius: float) -> tuple[float, float]:
    angle = math.radians(degrees)
    return middle + radius * math.cos(angle), middle - radius * math.sin(angle)


# --- Trials --------------------------------------------------------------------------------------


class Axis:
    """Numbers along a length of the page."""

    def __init__(self, low: float, high: float, first: float, last: float) -> None:
        """Lay the numbers from ``low`` to ``high`` from one place of the page to another."""
        self.low, self.high = low, high
        self._first, self._last = first, last

    def at(self, number: float) -> float:
        """Where a number is, at an end if it is beyond."""
        share = (number - self.low) / (self.high - self.low)
        return self._first + min(max(share, 0.0), 1.0) * (self._last - self._first)

    def marks(self, most: int) -> list[float]:
        """Round numbers on it."""
        return ticks(self.low, self.high, most)


def strip(
    about: str, first: int, end: int, shown: Mapping[int, str], marks: Sequence[float]
) -> Markup:
    """An axis of trials to mark one on, or with one stroke for each run.

    Args:
        about: what it is.
        first: trial at its left end.
        end: trial at its right end.
        shown: what is written at a round trial.
        marks: trials that runs have found; none for one to be drawn into.
    """
    axis = Axis(first, end, _LEFT, _WIDE - _RIGHT)
    base = _STRIP_HIGH - 24
    parts = [_line(axis.at(first), base, axis.at(end), base, w=1.5)]
    for trial, text in shown.items():
        parts.append(_line(axis.at(trial), base, axis.at(trial), base + 6))
        parts.append(_words(axis.at(trial), base + 20, text))
    parts += [_line(axis.at(trial), base - 26, axis.at(trial), base - 4, w=1.5) for trial in marks]
    return _svg(_WIDE, _STRIP_HIGH, about, parts)


def frame(
    about: str,
    asked: Asked,
    shown_x: Mapping[int, str],
    shown_y: Mapping[float, str],
    run: Sequence[tuple[float, float]] = (),
    band: CurveBand | None = None,
) -> Markup:
    """The frame of a curve: empty, to be drawn into, or with the run and what others did.

    Args:
        about: what it is.
        asked: the sketch that is asked for.
        shown_x: what is written at round trials.
        shown_y: what is written at round rewards.
        run: (trial, reward) of the lesson's own run.
        band: between the lowest and the highest of all runs.
    """
    low, high = reward_ends(asked)
    x = Axis(asked.first or 0, asked.end or 1, _LEFT, _WIDE - _RIGHT)
    y = Axis(low, high, _FRAME_HIGH - 28, 10)
    parts: list[Markup] = []
    for reward, text in shown_y.items():
        parts.append(_line(x.at(x.low), y.at(reward), x.at(x.high), y.at(reward), _PALE, 0.7))
        parts.append(_words(_LEFT - 8, y.at(reward) + 4, text, "end"))
    for trial, text in shown_x.items():
        parts.append(_line(x.at(trial), y.at(low), x.at(trial), y.at(high), _PALE, 0.7))
        parts.append(_words(x.at(trial), _FRAME_HIGH - 8, text))
    if band is not None:
        over = [(x.at(t), y.at(v)) for t, v in zip(band.at, band.high, strict=True)]
        under = [(x.at(t), y.at(v)) for t, v in zip(band.at, band.low, strict=True)]
        outline = _way([*over, *reversed(under)]) + "Z"
        parts.append(_shape(outline, "#ccc"))
    if run:
        way = _way([(x.at(t), y.at(v)) for t, v in run])
        parts.append(_shape(way, stroke=_INK, **{"stroke-width": "2"}))
    corner = f"M{_LEFT} 10H{_WIDE - _RIGHT}V{_FRAME_HIGH - 28}H{_LEFT}Z"
    parts.append(_shape(corner, stroke=_INK))
    return _svg(_WIDE, _FRAME_HIGH, about, parts)


def reward_ends(asked: Asked) -> tuple[float, float]:
    """The lowest and the highest reward of a frame."""
    low = -60.0 if asked.low is None else float(asked.low)
    high = 100.0 if asked.high is None else float(asked.high)
    return low, high


def trial_marks(first: int, end: int) -> list[int]:
    """Round trials of an axis."""
    return [round(trial) for trial in ticks(first, end, _MOST_TICKS, 1)]


def reward_marks(asked: Asked) -> list[float]:
    """Round rewards of a frame."""
    return ticks(*reward_ends(asked), _MOST_REWARDS)


def octants_of(spread: Spread) -> Mapping[str, float]:
    """In how many runs each octant is among those of the answer."""
    return {octant: float(spread.counts.get(octant, 0)) for octant in OCTANTS}
