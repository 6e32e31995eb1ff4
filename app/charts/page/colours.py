"""Colours of charts on the page, light or dark, and the rest of their style sheet.

Texts and axes take the colour of the page, and lines have colours that stand out from white and
from nearly black, so that one chart is right in both themes.
"""

import functools
from collections.abc import Sequence
from typing import Final

import cmap
import numpy as np

from app.charts.styles import COLOURS, THESIS_STYLES, Style
from app.picture.colours import from_linear, luminance, to_linear

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
_BRIGHTEST_ON_WHITE, _DARKEST_ON_BLACK = 0.295, 0.27
"""Luminance of lines: 3 to 1 against white, and nearly 5 to 1 against a dark page, where lines and
dots look thinner."""
_HEAT_COLOURS = 64


def colour_of(style: Style) -> str:
    """The colour of a style, as a name that the style sheet explains for light and dark pages.

    Black becomes the ink of the page; others keep their hue.
    """
    is_black = np.ptp(_parts(style.colour)) < 0.05
    return "currentColor" if is_black else f"var({_name_of(style.colour)})"


def shades_of(colour: str) -> tuple[str, str]:
    """A colour made to stand out from white, and from nearly black."""
    light = to_linear(_parts(colour))
    return (
        _hex(from_linear(light * min(_BRIGHTEST_ON_WHITE / luminance(light), 1))),
        _hex(from_linear(light * max(_DARKEST_ON_BLACK / luminance(light), 1))),
    )


def _name_of(colour: str) -> str:
    return f"--line-{colour[1:].lower()}"


def _parts(colour: str) -> np.ndarray:
    return np.asarray([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255


def _hex(parts: np.ndarray) -> str:
    return "#" + "".join(f"{round(255 * float(part)):02x}" for part in np.clip(parts, 0, 1))


@functools.cache
def style_sheet() -> str:
    """What the charts need of a style sheet."""
    colours = (*(style.colour for style in THESIS_STYLES.values()), *COLOURS)
    shades = {_name_of(colour): shades_of(colour) for colour in colours}
    light, dark = (
        "".join(f"{name}:{shade[theme]};" for name, shade in shades.items()) for theme in (0, 1)
    )
    return (
        f".pounce-results{{{light}}}"
        f'[data-mantine-color-scheme="dark"] .pounce-results{{{dark}}}{_RULES}'
    )


@functools.cache
def heat() -> tuple[Sequence[str], Sequence[str]]:
    """Colours from low to high, and what is written on each of them."""
    colours = cmap.Colormap("viridis")(np.linspace(0, 1, _HEAT_COLOURS))[:, :3]
    # Black and white are equally far from this luminance.
    inks = ["#000" if luminance(to_linear(colour)) > 0.18 else "#fff" for colour in colours]
    return [_hex(colour) for colour in colours], inks
