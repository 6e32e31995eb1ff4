"""Fonts of this machine, for characters that the font of the figures lacks.

That font comes with matplotlib, so that a picture is the same on all machines as long as it has all
characters; others are looked for only then. None is fetched.
"""

import functools
import re
import threading
from collections.abc import Iterable, Sequence
from typing import Any, Final, NamedTuple

FAMILY: Final = "DejaVu Sans"
"""The font of the figures."""
_PLAIN_STYLES: Final = ("Regular", "Book", "Roman", "Normal", "Medium")

_LOCK = threading.Lock()


class Fonts(NamedTuple):
    """What a text is drawn with."""

    families: Sequence[str]
    """In the order in which a character is looked for in them."""
    missing: str
    """Characters that none of them has, each once, in the order of the text."""


def fonts_for(text: str) -> Fonts:
    """The font of the figures, and as few others as have what it lacks."""
    lacking = "".join(c for c in dict.fromkeys(text) if ord(c) not in _known() and _is_drawn(c))
    if not lacking:
        return Fonts((FAMILY,), "")
    with _LOCK:  # The list of fonts is one for the process.
        return _with_others(lacking, system_fonts())


def system_fonts() -> tuple[str, ...]:
    """Files of the fonts that are installed now."""
    from matplotlib import font_manager

    # Not the stored list of matplotlib, which lacks what was installed after it was made.
    return tuple(sorted(font_manager.findSystemFonts()))


@functools.cache
def _known() -> frozenset[int]:
    from matplotlib import font_manager

    font = font_manager.findfont(FAMILY, fallback_to_default=False)
    return frozenset(font_manager.get_font(font).get_charmap())


def _is_drawn(character: str) -> bool:
    """Whether a character has a picture of its own: line ends and joiners have none."""
    return character.isprintable() and not "\ufe00" <= character <= "\ufe0f"


@functools.lru_cache(maxsize=256)
def _with_others(lacking: str, paths: Sequence[str]) -> Fonts:
    covered = _covered(lacking, paths)
    families, rest = [FAMILY], set(lacking)
    while rest:
        path, name, characters = max(
            covered, key=lambda c: len(c[2] & rest), default=("", "", set())
        )
        if not characters & rest:
            break
        _register(path)
        families.append(name)
        rest -= characters
    return Fonts(tuple(families), "".join(c for c in lacking if c in rest))


def _covered(lacking: str, paths: Iterable[str]) -> "list[tuple[str, str, set[str]]]":
    """Fonts that have some of the characters: file, name of the family, and which; best first."""
    from matplotlib.ft2font import FT2Font, StyleFlags

    found = []
    for path in paths:
        try:
            font: Any = FT2Font(path)
        except (OSError, RuntimeError):  # Not all that is installed can be read.
            continue
        # What is made of pixels or colours has no outlines, and a last resort has boxes alone.
        if not font.scalable or re.search("Color|Last ?Resort", font.family_name):
            continue
        there = {c for c in lacking if font.get_char_index(ord(c))}
        if there:
            is_plain = font.style_flags == StyleFlags.NORMAL and font.style_name in _PLAIN_STYLES
            rank = not is_plain, "Sans" not in font.family_name, path
            found.append((rank, (path, font.family_name, there)))
    return [font for _, font in sorted(found, key=lambda pair: pair[0])]


def _register(path: str) -> None:
    from matplotlib.font_manager import fontManager

    if all(entry.fname != path for entry in fontManager.ttflist):
        fontManager.addfont(path)
