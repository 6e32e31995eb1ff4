"""Policy flow: which way the predator would go if it never explored."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.arrows import arrows, at_places
from app.picture.colours import css
from app.picture.frames import TURNED, folds, in_frame
from app.picture.layer import Extras, Layer, Picture, blank
from app.picture.legend import frame_in_words, legend, swatch
from app.picture.look import Look
from app.picture.options import (
    greedy,
    has_moves,
    option_colours,
    option_names,
    options_in_frame,
    present,
)
from app.picture.raster import Raster
from app.util.html import element, joined
from sim.spec import N_HEADINGS

_THIN = 0.72
"""Brightness of a colour that is meant for areas, where it is to be seen in a line on white."""


def _ways(snapshot: Snapshot, look: Look, side: int) -> tuple[np.ndarray, np.ndarray]:
    """What the whole hierarchy does where arrows may be, each ``(heading, place)``.

    Returns:
        Its move, in the frame of the picture, -1 for ties; and the option that makes it.
    """
    world = snapshot.spec.world
    if has_moves(snapshot):
        move = at_places(greedy(options_in_frame(snapshot, look)), world, side)
        return move, move
    # Place by place, since skills may tell other states apart than the selection does.
    option = at_places(greedy(in_frame(snapshot.choice_q, snapshot, look)), world, side)
    of_skill = greedy(snapshot.move_q)
    of_skills, per_skill = world.of_skills, of_skill[0].size
    shape = N_HEADINGS, of_skills.n_distances, of_skills.n_directions
    every = in_frame(np.arange(np.prod(shape)).reshape(shape), snapshot, look)
    # Of a heading that no skill sees nothing is left.
    state = at_places(every, of_skills, side) % per_skill
    # An option of -1 wraps to some skill here, and is taken out again below.
    move = of_skill.ravel().take(option * per_skill + state, mode="wrap")
    clear = (option >= 0) & (move >= 0)
    if folds(look):
        move = TURNED[np.arange(N_HEADINGS)[:, None], move]
    return np.where(clear, move, -1), np.where(clear, option, -1)


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    move, option = _ways(snapshot, look, raster.side)
    ways = arrows(move, snapshot.spec.world, raster.side)
    picture = blank(look, raster)._replace(arrows=ways.ends)
    if has_moves(snapshot):
        return picture
    # On the empty board, in the colour of who makes the move: a value below would be a second thing
    # to read, and pale beside them.
    takes = option[:, ways.shown]
    options = range(snapshot.selection_q.shape[-1])
    votes = np.stack([(takes == number).sum(axis=0) for number in options])
    return picture._replace(arrow_colours=_inks(snapshot, look)[votes.argmax(axis=0)])


def _inks(snapshot: Snapshot, look: Look) -> np.ndarray:
    """(option, 3) uint8: colours of options for what is thin."""
    darker = 1.0 if look.theme.is_dark else _THIN
    return np.rint(option_colours(snapshot, look.theme) * darker).astype(np.uint8)


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    none = "the best moves tie or the headings disagree" if folds(look) else "the best moves tie"
    parts: list[Markup] = []
    if not has_moves(snapshot):
        colours, names = _inks(snapshot, look), option_names(snapshot)
        key = (swatch(css(colours[option]), names[option]) for option in present(snapshot))
        parts.append(element("div", joined(["The move of ", *key], "")))
    parts.append(element("div", f"No arrow where {none}."))
    frame = frame_in_words(snapshot, look, "the mean way of its eight headings")
    return legend(look, "Arrows: the way the predator would go", parts, frame)


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    move, _ = _ways(snapshot, look, snapshot.spec.world.size)
    if (move < 0).all():
        return "Which way the predator would go from each place: no move is clearly best yet."
    return "Which way the predator would go from each place if it never moved at random."


FLOW = Layer("flow", "Policy flow", _draw, _legend, _caption, heeds=frozenset({"frame"}))
