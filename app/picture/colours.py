"""Scales of colours, and how colours lie over the board.

Arrays of colours are ``(..., 3)``, each part 0...255 unless said otherwise.
"""

import functools
from typing import Final, NamedTuple

import cmap
import numpy as np

from app.picture.theme import Colour, Theme
from sim import geometry
from sim.spec import N_HEADINGS


@functools.cache
def gain_colours() -> np.ndarray:
    """(256, 3) float64: from far from capture to certain capture; apart for all kinds of sight.

    Without the purple beginning of the map, which is too near to the colour of flight.
    """
    return cmap.Colormap("viridis")(np.linspace(0.32, 1.0, 256))[:, :3] * 255.0


class Ramp(NamedTuple):
    """Colours of amounts, from hardly to very much, on light pages and on dark ones.

    Three each: the ends and the middle. Each step is farther from the board.
    """

    light: tuple[Colour, Colour, Colour]
    dark: tuple[Colour, Colour, Colour]


TRACES: Final = Ramp(
    ((206, 230, 240), (76, 152, 184), (0, 66, 98)), ((30, 66, 88), (50, 140, 180), (130, 225, 255))
)
"""How often a place was visited: as tracks in snow."""
GLOW: Final = Ramp(
    ((255, 214, 214), (226, 84, 120), (128, 0, 50)),
    ((112, 36, 64), (222, 60, 116), (255, 150, 178)),
)
"""How much a value is changing."""
STAKES: Final = Ramp(
    ((240, 224, 184), (184, 128, 44), (92, 56, 8)), ((82, 62, 28), (176, 126, 48), (252, 224, 150))
)
"""How much a choice matters."""

NEARER: Final = Ramp(
    ((248, 206, 230), (224, 98, 168), (142, 0, 84)), ((96, 34, 74), (192, 62, 138), (255, 146, 210))
)
"""By how much a capture has come nearer; with the next for all kinds of sight apart."""
FARTHER: Final = Ramp(
    ((238, 220, 184), (180, 128, 52), (90, 58, 6)), ((84, 64, 24), (162, 112, 36), (240, 200, 116))
)
"""By how much it has gone farther away."""


@functools.lru_cache(maxsize=8)
def amount_colours(ramp: Ramp, theme: Theme) -> np.ndarray:
    """(256, 3) float64."""
    stops = np.array(ramp.dark if theme.is_dark else ramp.light, np.float64)
    places = np.linspace(0, len(stops) - 1, 256)
    below = np.minimum(places.astype(np.int64), len(stops) - 2)
    share = (places - below)[:, None]
    return stops[below] * (1 - share) + stops[below + 1] * share


COMPASS_COLOURS = np.array(
    [
        (251, 147, 180),
        (236, 140, 97),
        (165, 129, 0),
        (66, 117, 29),
        (0, 110, 91),
        (0, 114, 156),
        (104, 128, 212),
        (199, 143, 225),
    ],
    dtype=np.float64,
)
"""(direction, 3), counter-clockwise from east: a hue that goes round with the direction.

Lightness goes round with it, a quarter turn ahead of yellow and blue, so that without red or
green the eight still form a circle (OKLCH: 0.62 + 0.16 cos t, 0.13, t).
"""


@functools.lru_cache(maxsize=8)
def move_colours(theme: Theme) -> np.ndarray:
    """(move, 3) float64: a colour for each direction, and grey for staying."""
    eighths = np.arctan2(geometry.MOVES[:, 1], geometry.MOVES[:, 0]) / (np.pi / 4)
    colours = COMPASS_COLOURS[np.rint(eighths).astype(np.int64) % N_HEADINGS]
    colours[geometry.STAY] = theme.timeout
    return colours


OPTION_COLOURS = np.array(
    [
        (78, 200, 205),
        (200, 80, 148),
        (160, 112, 52),
        (244, 232, 80),
        (0, 110, 82),
        (110, 24, 84),
        (119, 119, 119),
        (204, 121, 167),
        (153, 153, 51),
        (136, 204, 238),
        (170, 68, 153),
        (221, 204, 119),
    ],
    dtype=np.float64,
)
"""(option, 3): the first six are apart for all kinds of sight, on light and dark boards, and none
is that of an outcome, of the predator or of forced exploration; more cannot all be so far apart."""


def palette(colours: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Colours of levels 0...1, ``(..., 3)``; NaN counts as 0."""
    index = np.nan_to_num(np.clip(level, 0, 1) * (len(colours) - 1)).astype(np.int64)
    return colours[index]


def over_board(colours: np.ndarray, cover: np.ndarray | float, theme: Theme) -> np.ndarray:
    """Colours that cover the empty board more or less, ``(..., 3) uint8``.

    Args:
        colours: ``(..., 3)``.
        cover: ``(...)``, from 0, the empty board, to 1.
        theme: colours of the page.
    """
    share = np.asarray(cover, dtype=np.float64)[..., None]
    board = np.array(theme.unknown, dtype=np.float64)
    return np.rint(board + (colours - board) * share).astype(np.uint8)


def gradient_css(colours: np.ndarray) -> str:
    """A horizontal CSS gradient through a list of colours."""
    stops = colours[:: max(len(colours) // 12, 1)]
    return "linear-gradient(to right," + ",".join(css(stop) for stop in stops) + ")"


def css(colour: Colour | np.ndarray) -> str:
    """A colour as CSS writes it."""
    red, green, blue = (round(float(part)) for part in colour)
    return f"rgb({red},{green},{blue})"


# sRGB ---------------------------------------------------------------------------------------


def to_linear(shares: np.ndarray) -> np.ndarray:
    """Linear light of the parts of sRGB colours, all 0...1."""
    return np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)


def from_linear(light: np.ndarray) -> np.ndarray:
    """Parts of sRGB colours from their linear light, all 0...1."""
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def luminance(light: np.ndarray) -> np.ndarray:
    """Luminance ``(...)`` of linear light ``(..., 3)``, 1 for white."""
    return light @ np.array([0.2126, 0.7152, 0.0722])
