"""Chosen skill: the option of most value in each place."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.arrows import arrows, at_places
from app.picture.colours import css
from app.picture.frames import folds, in_frame
from app.picture.layer import Extras, Layer, Picture, spread
from app.picture.legend import frame_in_words, hatch, legend, patch_of_board, swatch
from app.picture.look import Look
from app.picture.options import (
    greedy,
    has_moves,
    kind_of,
    lone_option,
    option_colours,
    option_names,
    options_in_frame,
    present,
)
from app.picture.raster import Raster, on_raster
from app.picture.shading import SHOWN_FROM
from app.picture.value_maps import or_zero
from app.util.html import element, joined
from app.words.plain import MOVE_NAMES

_MOVE_SIGNS = "↙↓↘←·→↖↑↗"


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    choice = greedy(options_in_frame(snapshot, look))
    options = range(snapshot.selection_q.shape[-1])
    votes = np.stack([(choice == option).sum(axis=0, dtype=np.int8) for option in options])
    most, winner = votes.max(axis=0), votes.argmax(axis=0)
    # As many headings for another option would make the colour an accident.
    is_clear = ((votes == most).sum(axis=0) == 1) & (most >= _fewest(snapshot, len(choice)))
    board = np.array(look.theme.unknown, np.uint8)
    colours = option_colours(snapshot, look.theme)[winner].astype(np.uint8)
    picture = spread(np.where(is_clear[..., None], colours, board), raster)
    world = snapshot.spec.world
    is_split = on_raster(~is_clear & _is_learned(snapshot, look), raster)
    picture.colours[is_split & raster.rising] = look.theme.frozen
    if has_moves(snapshot):
        # Nine colours are too many to keep apart, so moves are drawn as what they are, too.
        ways = arrows(at_places(choice, world, raster.side), world, raster.side)
        return picture._replace(arrows=ways.ends)
    if lone_option(snapshot) is not None:
        return picture
    regions = on_raster(np.where(is_clear, winner, -1), raster)
    return picture._replace(regions=regions, names=option_names(snapshot))


def _fewest(snapshot: Snapshot, n_headings: int) -> float:
    """Headings that must choose an option for its colour: of nine moves hardly one has half."""
    return 1.0 if has_moves(snapshot) else SHOWN_FROM * n_headings


def _is_learned(snapshot: Snapshot, look: Look) -> np.ndarray:
    """Where any option has a value in any heading that takes part, ``(distance, direction)``."""
    return (or_zero(in_frame(snapshot.selection_q, snapshot, look)) != 0).any(axis=(0, -1))


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    colours, names = option_colours(snapshot, look.theme), option_names(snapshot)
    if has_moves(snapshot):
        key = _compass(colours)
    else:
        key = joined((swatch(css(colours[k]), names[k]) for k in present(snapshot)), "")
    kind = kind_of(snapshot)
    split = "headings disagree" if folds(look) else f"no {kind} clearly best"
    key += hatch(css(look.theme.frozen), split)
    part = element("div", key + patch_of_board(look, "nothing learned"))
    each = f"the {kind} that {_how_many(snapshot)} of its headings choose"
    frame = frame_in_words(snapshot, look, each)
    return legend(look, f"The {kind} of most value", [part], frame)


def _how_many(snapshot: Snapshot) -> str:
    return "most" if has_moves(snapshot) else "at least half"


def _compass(colours: np.ndarray) -> Markup:
    """The nine moves where they point."""
    cells = (
        element(
            "span",
            _MOVE_SIGNS[move],
            style=f"background:{css(colours[move])};text-align:center;border-radius:2px;"
            f"color:{'#fff' if colours[move].mean() < 128 else '#111'}",
            title=MOVE_NAMES[move],
        )
        for move in (6, 7, 8, 3, 4, 5, 0, 1, 2)
    )
    style = (
        "display:inline-grid;grid-template-columns:repeat(3,1.6em);gap:2px;"
        "vertical-align:middle;margin:0.2em 1em 0.2em 0"
    )
    return element("span", joined(cells, ""), style=style)


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    lone = lone_option(snapshot)
    if lone is not None:
        return f"{lone}, so there is no choice yet."
    kind = kind_of(snapshot)
    if folds(look):
        return (
            f"The {kind} that {_how_many(snapshot)} of the prey's headings would choose in each"
            " place; hatched where they disagree."
        )
    return (
        f"The {kind} that the learner takes in each place when it does not explore;"
        " hatched where none is clearly best."
    )


CHOSEN = Layer("chosen", "Chosen skill", _draw, _legend, _caption, heeds=frozenset({"frame"}))
