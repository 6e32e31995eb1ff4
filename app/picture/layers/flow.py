"""Policy flow: which way the predator would go if it never explored."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.arrows import arrows, at_places
from app.picture.colours import over_board
from app.picture.frames import TURNED, folds, in_frame
from app.picture.layer import Extras, Layer, Picture, spread
from app.picture.look import Look
from app.picture.options import greedy, has_moves, options_in_frame
from app.picture.raster import Raster
from app.picture.value_maps import FAINT, or_zero, state_value_map, value_legend, value_shading
from app.util.html import element
from sim.spec import N_HEADINGS


def _moves(snapshot: Snapshot, look: Look) -> np.ndarray:
    """The move that the whole hierarchy makes where arrows may be, ``(heading, place)``.

    In the frame of the picture; -1 for ties.
    """
    world = snapshot.spec.world
    if has_moves(snapshot):
        return at_places(greedy(options_in_frame(snapshot, look)), world)
    # Place by place, since skills may tell other states apart than the selection does.
    option = at_places(greedy(in_frame(snapshot.selection_q, snapshot, look)), world)
    of_skill = greedy(snapshot.skill_q)
    n_skill_states, of_skills = world.n_skill_states, world.of_skills
    every = np.arange(n_skill_states).reshape(of_skills.n_distances, of_skills.n_directions)
    state = at_places(in_frame(np.stack([every] * N_HEADINGS), snapshot, look), of_skills)
    # An option of -1 wraps to some skill here, and is taken out again below.
    move = of_skill.ravel().take(option * n_skill_states + state, mode="wrap")
    clear = (option >= 0) & (move >= 0)
    if folds(look):
        move = TURNED[np.arange(N_HEADINGS)[:, None], move]
    return np.where(clear, move, -1)


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    faint = over_board(state_value_map(snapshot, look), FAINT, look.theme)
    return spread(faint, raster, arrows(_moves(snapshot, look), snapshot.spec.world))


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    shading = value_shading(snapshot, look, or_zero(snapshot.value))
    none = "moves tie or the headings disagree" if folds(look) else "moves tie"
    ways = element("div", f"Arrows: the move that is made; none where {none}.")
    return value_legend(snapshot, look, "Faint: value of a state", shading, ways, FAINT)


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    if (_moves(snapshot, look) < 0).all():
        return "Which way the predator would go from each place: no move is clearly best yet."
    return "Which way the predator would go from each place if it never explored."


FLOW = Layer("flow", "Policy flow", _draw, _legend, _caption)
