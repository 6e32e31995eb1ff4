"""First reach: when value came to each place, with a line every so many trials."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.colours import css, gain_colours, palette
from app.picture.contours import Contour, Isoline, isolines, segments
from app.picture.frames import folds, in_frame
from app.picture.layer import Extras, Label, Layer, Over, Picture
from app.picture.legend import (
    bar,
    bar_marks,
    dots,
    frame_in_words,
    legend,
    limits,
    patch_of_board,
    swatch,
)
from app.picture.look import Look
from app.picture.raster import Raster, on_raster
from app.picture.shading import SHOWN_FROM, Ruler, mean_of
from app.util.html import element, joined
from app.words.numbers import round_numbers

MOST_LINES = 10
"""Isochrones that a picture has at most."""
_FEWEST_BETWEEN_LINES = 500
"""Trials from an isochrone to the next at least."""
_LINE = (18, 62, 74)
"""A dark shade of the colours that the lines run through, on light and on dark boards."""
_ROOM = 0.085
"""Between the middles of two numbers on the lines at least, as a share of the board's side."""
_REACH = 0.44
"""From the prey to a number at most, as a share of the board's side."""


def _ruler(snapshot: Snapshot, look: Look) -> Ruler:
    """Trials; by the square root, because value spreads fast at first and slowly later."""
    reached = snapshot.first_reach[snapshot.first_reach >= 0]
    if look.fitted and len(reached):
        return Ruler(float(reached.min()), float(reached.max()), "root")
    return Ruler(0.0, float(max(snapshot.spec.trials, snapshot.trial, 1)), "root")


def line_step(first_reach: np.ndarray) -> int:
    """Trials between isochrones, so that there are at most ``MOST_LINES`` of them."""
    reached = first_reach[first_reach >= 0]
    first, last = (int(reached.min()), int(reached.max())) if len(reached) else (0, 0)
    steps = map(int, round_numbers(_FEWEST_BETWEEN_LINES))
    return next(step for step in steps if last // step - first // step <= MOST_LINES)


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    theme = look.theme
    turned = in_frame(snapshot.first_reach, snapshot, look)
    reached = turned >= 0
    count = reached.sum(axis=0)
    trial = mean_of(np.where(reached, turned, 0), count, np.nan)
    is_shown = count >= SHOWN_FROM * len(turned)
    colours = palette(gain_colours(), 1.0 - _ruler(snapshot, look).place(trial))
    colours = np.rint(colours).astype(np.uint8)
    board = np.array(theme.unknown, np.uint8)
    pixels = on_raster(np.where(is_shown[..., None], colours, board), raster)
    few = on_raster((count > 0) & ~is_shown, raster) & raster.dotted
    pixels[few] = on_raster(colours, raster)[few]
    return Picture(pixels, within=lambda: _isochrones(np.where(is_shown, trial, np.nan), snapshot))


def _isochrones(trial: np.ndarray, snapshot: Snapshot) -> Over:
    """Lines through a map of trials, ``(distance, direction)``, with their numbers."""
    world, reach = snapshot.spec.world, snapshot.first_reach
    step = line_step(reach)
    levels = np.arange(1, MOST_LINES + 2) * step + reach.clip(0).min() // step * step
    room = _ROOM * world.size
    # Specks round a single state say nothing, and hide what they are in.
    lines = [line for line in isolines(trial, world, levels.tolist()) if _length(line) > room]
    return Over(
        tuple(Contour(segments(line.points), _LINE) for line in lines),
        _numbers(lines, room, _REACH * world.size),
    )


def _numbers(lines: list[Isoline], room: float, farthest: float) -> tuple[Label, ...]:
    """Trials of lines, each about the middle of the longest that it has, where there is room.

    Args:
        lines: the isochrones.
        room: between the middles of two at least, and from the prey, in cells.
        farthest: from the prey, in cells.
    """
    found: list[Label] = []
    for line in sorted(lines, key=_length, reverse=True):
        text = f"{line.level:,.0f}"
        taken = np.array([(0.0, 0.0), *((other.east, other.north) for other in found)])
        apart = np.hypot(*(line.points[:, None] - taken).transpose(2, 0, 1)).min(axis=1)
        free = np.flatnonzero((apart > room) & (np.hypot(*line.points.T) < farthest))
        if len(free) and text not in (other.text for other in found):
            chosen = free[np.abs(free - len(line.points) / 2).argmin()]
            found.append(Label(text, *line.points[chosen].tolist()))
    return tuple(found)


def _length(line: Isoline) -> float:
    """Along a line, in cells."""
    return float(np.hypot(*np.diff(line.points, axis=0).T).sum())


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    ruler, colours = _ruler(snapshot, look), gain_colours()
    step = f"a line every {line_step(snapshot.first_reach):,} trials"
    key = [swatch(css(_LINE), step), patch_of_board(look, "not yet")]
    if folds(look):
        key.insert(1, dots(css(colours[128]), look, "for few headings yet"))
    parts = [
        bar(colours[::-1], bar_marks(ruler, "{:,.0f}".format)),
        limits(look, f"trial {ruler.low:,.0f}", f"{ruler.high:,.0f}"),
        element("div", joined(key, "")),
    ]
    each = "the mean of the ways the prey can look for which value has come"
    frame = frame_in_words(snapshot, look, each)
    return legend(look, "Trial in which value first came", parts, frame)


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    if not (snapshot.first_reach >= 0).any():
        return "When value came to each place: it has not come to any yet."
    return (
        "When value came to each place: bright early, dark late. The numbers on the lines are"
        " trials."
    )


REACH = Layer("reach", "First reach", _draw, _legend, _caption)
