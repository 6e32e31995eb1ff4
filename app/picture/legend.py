"""What the colours of a layer mean, as HTML for a narrow panel: bars, swatches, and what is common.

Texts are escaped here, and what is markup already stays as it is.
"""

import itertools
from collections.abc import Callable, Iterable

import numpy as np
from markupsafe import Markup, escape

from app.live.snapshot import Snapshot
from app.picture.colours import css, gradient_css
from app.picture.frames import facing, folds, is_of_one
from app.picture.look import Look
from app.picture.shading import Ruler
from app.picture.theme import OUTCOME_SHAPES, Shape, Theme
from app.util.html import element, joined
from app.words.glossary import term
from app.words.numbers import round_numbers
from app.words.placing import Room
from sim.world import CAPTURE, FLIGHT, TIMEOUT

_TEXT_SHARE = 0.021
"""Width of a character of a legend as a share of its bar."""
_FRAME = "frame"
"""Class of the last row of a legend."""
_DECADES = 12
"""At most so many decades of a logarithmic bar are looked at for marks."""


def bar_marks(ruler: Ruler, write: Callable[[float], str]) -> list[tuple[float, str]]:
    """Marks along a bar, ``(place, text)`` by place: both ends, and round numbers that fit between.

    Texts stand inside the bar at its ends and are centred in its middle.
    """
    chosen: list[tuple[float, str]] = []
    room = Room(0.0, 1.0)
    for number in (ruler.high, ruler.low, *_round_numbers(ruler)):
        place, text = float(ruler.place(number)), write(number)
        width = (len(text) + 2) * _TEXT_SHARE
        if room.taken(place - place * width, place + (1 - place) * width):
            chosen.append((place, text))
    return sorted(chosen)


def _round_numbers(ruler: Ruler) -> Iterable[float]:
    """Numbers worth a mark between the ends of a bar, the most welcome first."""
    low, high = ruler.low, ruler.high
    if not high > low:
        return []
    if ruler.kind == "linear":
        return [low + (high - low) * part / 4 for part in (2, 1, 3)]
    top = int(np.ceil(np.log10(high)))
    if ruler.kind == "log":
        # Every other decade first, so that where not all have room the marks are even.
        decades = [*range(top, top - _DECADES, -2), *range(top - 1, top - _DECADES, -2)]
        numbers = [10.0**decade for decade in decades]
    else:
        upwards = round_numbers(10.0 ** (top - 3))
        numbers = reversed([*itertools.takewhile(lambda number: number < high, upwards)])
    return [number for number in numbers if low < number < high]


def bar(colours: np.ndarray, marks: Iterable[tuple[float, str]]) -> Markup:
    """A bar of colours ``(n, 3)`` from left to right with marks ``(place, text)`` under it."""
    labels = (
        element(
            "span",
            text,
            style=f"position:absolute;left:{100 * at:.1f}%;white-space:nowrap;"
            f"transform:translateX({-100 * at:.0f}%)",
        )
        for at, text in marks
    )
    strip = f"height:0.9em;border-radius:3px;background:{gradient_css(colours)}"
    below = element("div", joined(labels, ""), style="position:relative;height:1.5em")
    return element("div", "", style=strip) + below


def swatch(background: str, text: str, width: str = "0.8em", shape: Shape = "square") -> Markup:
    """A patch of a colour, or of a gradient, and what it means."""
    forms = {"circle": "border-radius:50%", "diamond": "transform:rotate(45deg) scale(0.8)"}
    patch = element(
        "span",
        "",
        style=f"display:inline-block;width:{width};height:0.8em;margin-right:0.3em;"
        f"vertical-align:-0.1em;{forms.get(shape, 'border-radius:2px')};"
        f"background:{background};box-shadow:inset 0 0 0 1px rgba(128,128,128,0.4)",
    )
    return element("span", patch + text, style="white-space:nowrap;margin-right:0.6em") + " "


def patch_of_board(look: Look, text: str) -> Markup:
    """What it means where the board is blank."""
    return swatch(css(look.theme.unknown), text)


def hatch(colour: str, text: str, falls: bool = False) -> Markup:
    """A patch of a hatch in a colour, and what it means; ``falls`` as on the board."""
    angle = 45 if falls else -45
    stripes = f"repeating-linear-gradient({angle}deg,{colour} 0 2px,transparent 2px 4px)"
    return swatch(stripes, text, width="1.4em")


def dots(colour: str, look: Look, text: str) -> Markup:
    """A patch of dots in a colour on the board, and what it means."""
    board = css(look.theme.unknown)
    lattice = f"radial-gradient({colour} 1.3px,{board} 1.5px) 0 0/4px 4px"
    return swatch(lattice, text, width="1.4em")


def limits(look: Look, low: str, high: str) -> Markup:
    """Where the colours begin and end, where that depends on what is there now."""
    if not look.fitted:
        return Markup()
    return element("div", f"Colours fitted to what is there now: {low} to {high}.")


def frame_in_words(snapshot: Snapshot, look: Look, each: str) -> Markup:
    """How the board lies, and what a place of a folded picture shows."""
    if folds(look):
        shown = f" are turned so that it looks right; each place shows {each}."
        return joined(["The prey's eight ", term("heading", "headings"), shown], "")
    if not is_of_one(look):
        return escape("Each heading by itself, north up; a click on one shows it alone.")
    return escape(f"North is up, and the prey looks {facing(snapshot, look)}.")


def legend(
    look: Look,
    title: Markup | str,
    parts: Iterable[Markup | str],
    frame: Markup | str,
    turns: bool = True,
) -> Markup:
    """A legend with what all of them share.

    Args:
        look: how the board is seen.
        title: what the colours stand for.
        parts: what explains the colours.
        frame: how the board lies, and what that means for the layer.
        turns: whether it matters to the layer where the prey looks.
    """
    signs = [_prey(look, turns), _predator(look.theme), _ends(look.theme)]
    content = (
        element("div", joined(signs, ""), class_="signs"),
        element("div", title, style="font-weight:600"),
        *parts,
        _circles(look),
        element("div", frame, class_=_FRAME, style="opacity:0.75"),
    )
    style = "padding:0 0.7em;font-size:0.8em;line-height:1.5;overflow-wrap:anywhere"
    return element("div", joined(content, ""), class_="pounce-legend", style=style)


def with_row(shown: Markup, row: Markup) -> Markup:
    """A legend with one more row, before what says how the board lies."""
    before, begins, after = shown.rpartition(f'<div class="{_FRAME}"')
    return before + element("div", row) + Markup(begins) + after


def _prey(look: Look, turns: bool) -> Markup:
    """The prey as it is drawn, and what belongs to it."""
    if not turns:
        return swatch(css(look.theme.prey), "prey", shape="circle")
    ink = css(look.theme.prey)
    sees = '<path d="M8 1A7 7 0 0 1 8 15Z"/>' if look.field else ""
    sign = Markup(
        '<svg viewBox="0 0 18 16" width="1.6em" height="1.4em" aria-hidden="true" fill="none"'
        f' stroke="{ink}" stroke-width="1.2" style="vertical-align:-0.35em">{sees}'
        f'<circle cx="8" cy="8" r="2" fill="{ink}"/></svg>'
    )
    text = "prey and what it sees" if look.field else "prey"
    return element("span", sign + text, style="white-space:nowrap;margin-right:0.6em") + " "


def _predator(theme: Theme) -> Markup:
    return swatch(css(theme.predator), "predator", shape="circle")


def _ends(theme: Theme) -> Markup:
    """How hunts end, as the dots that are left where they did."""
    kinds = {CAPTURE: "caught", FLIGHT: "noticed", TIMEOUT: "out of time"}
    ends = [
        swatch(css(theme.of_outcome(outcome)), kind, shape=OUTCOME_SHAPES[outcome])
        for outcome, kind in kinds.items()
    ]
    title = element("span", "Hunts that ended:", style="white-space:nowrap")
    return joined([title, " ", *ends], "")


def _circles(look: Look) -> Markup | str:
    """What the start zone is, where it is drawn."""
    if not look.start_zone:
        return ""
    zone = swatch(css(look.theme.zone), "trials start between them")
    return element("div", joined(["Circles: ", zone], ""))
