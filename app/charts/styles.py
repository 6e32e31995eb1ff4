"""How lines look, on paper and on the page.

Colours are those of Okabe and Ito, which people with a colour vision deficiency can tell apart, and
every line differs in width and dashes as well, as in the thesis, so that a copy in black and white
still tells who is who.
"""

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple


class Style(NamedTuple):
    """How a line looks."""

    colour: str
    width: float
    dashes: tuple[float, ...] = ()
    """Lengths of dashes and gaps in line widths; none for a solid line."""


_SKY_BLUE: Final = "#56B4E9"
COLOURS: Final = (
    *("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", _SKY_BLUE, "#222222", "#B8A800"),
)
"""Of lines that have none of their own; after these, they come again."""
_DASHES: Final[Sequence[tuple[float, ...]]] = ((), (6, 2), (1.5, 1.5), (7, 2, 1.5, 2), (3, 1.5))
_LONG: Final = (12.0, 2.5)
THESIS_STYLES: Final[Mapping[str, Style]] = {
    "timed": Style("#005A8F", 2.6),
    "hierarchical_3": Style("#E69F00", 2.6, (3, 1)),
    "standard_q": Style("#111111", 1.1),
    "hierarchical_2": Style("#C2609A", 1.1, (5, 1.5, 1.5, 1.5)),
}
"""Dark and thick, light and thick, dark and thin, light and thin, as in Figure 4.1."""


def style_of(index: int) -> Style:
    """The style of one of several lines that have none of their own."""
    colour = COLOURS[index % len(COLOURS)]
    return Style(colour, 1.2 + 0.7 * (index % 2), _DASHES[index % len(_DASHES)])


def styles_of(presets: Sequence[str]) -> list[Style]:
    """Styles of variants that are shown together: the thesis's own where they are its learners."""
    if len(set(presets)) == len(presets) and set(presets) <= THESIS_STYLES.keys():
        return [THESIS_STYLES[preset] for preset in presets]
    styles = map(style_of, range(len(presets)))
    return [style._replace(dashes=_LONG) if _is_light_blue(style) else style for style in styles]


def _is_light_blue(style: Style) -> bool:
    """Whether a line, in colours that can be read on any page, would look like a solid blue one."""
    return style.colour == _SKY_BLUE and not style.dashes
