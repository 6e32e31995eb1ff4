"""Where an exploration by context acts, over what a layer shows.

Such an exploration takes its skill only in states in which no other present skill is worth more
than some value (section 5.2). These are hatched in the colour of forced exploration, with a line
round them, whatever the layer; of a folded picture, where that is so for half of the headings.
"""

from collections.abc import Sequence
from functools import wraps
from typing import Final

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.colours import css
from app.picture.contours import Contour
from app.picture.frames import in_frame
from app.picture.layer import Extras, Layer, Picture
from app.picture.legend import hatch, with_row
from app.picture.look import Look
from app.picture.raster import Raster, on_raster
from app.picture.value_maps import edge_of
from app.schedule.forced import Forced, forced_now
from app.words.plain import joined_by_and, plain

_SHARE: Final = 0.5
"""Of the headings that take part, to be hatched."""
_COVER: Final = 0.4
"""How strongly the hatch covers what is shown."""


def by_context(snapshot: Snapshot) -> list[Forced]:
    """Explorations that act now, but not everywhere; the newest first."""
    return [forced for forced in forced_now(snapshot) if forced.value_at_most is not None]


def acts_in(snapshot: Snapshot, forced: Sequence[Forced]) -> np.ndarray:
    """In which states explorations act, ``(heading, distance, direction) bool``: any of them."""
    found = np.zeros(snapshot.selection_q.shape[:3], bool)
    for one in forced:
        option = snapshot.spec.learner.skills.index(one.skill)
        others = np.delete(snapshot.selection_q, option, axis=-1)
        at_most = np.inf if one.value_at_most is None else one.value_at_most
        found |= others.max(axis=-1, initial=-np.inf) <= at_most
    return found


def said_where(forced: Sequence[Forced]) -> str:
    """What is done there, in words."""
    skills = joined_by_and([plain(one.skill) for one in forced])
    values = {one.value_at_most for one in forced}
    most = f"{values.pop():g}" if len(values) == 1 else "so much"
    are = "is" if len(forced) == 1 else "are"
    return f"where nothing else is worth more than {most}, {skills} {are} explored"


def showing_where(layer: Layer) -> Layer:
    """A layer that shows besides where an exploration by context acts."""

    @wraps(layer.draw)
    def draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
        picture = layer.draw(snapshot, look, extras, raster)
        forced = by_context(snapshot)
        return _over(picture, snapshot, look, raster, forced) if forced else picture

    @wraps(layer.legend)
    def legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
        shown = layer.legend(snapshot, look, extras)
        forced = by_context(snapshot)
        if not forced:
            return shown
        patch = hatch(css(look.theme.forced), "forced exploration acts here", falls=True)
        return with_row(shown, patch)

    @wraps(layer.caption)
    def caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
        shown = layer.caption(snapshot, look, extras)
        forced = by_context(snapshot)
        return f"{shown} Hatched: {said_where(forced)}." if forced else shown

    return layer._replace(draw=draw, legend=legend, caption=caption)


def _over(
    picture: Picture, snapshot: Snapshot, look: Look, raster: Raster, forced: Sequence[Forced]
) -> Picture:
    region = in_frame(acts_in(snapshot, forced), snapshot, look).mean(axis=0) >= _SHARE
    hatched = on_raster(region, raster) & raster.falling
    under, ink = picture.colours[hatched], np.array(look.theme.forced)
    colours = picture.colours.copy()
    colours[hatched] = np.rint((1 - _COVER) * under + _COVER * ink)

    def with_edge() -> tuple[Contour, ...]:
        edge = Contour(edge_of(region, snapshot.spec.world), look.theme.forced, is_edge=True)
        return (*picture.edges(), edge)

    return picture._replace(colours=colours, edges=with_edge)
