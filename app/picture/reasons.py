"""Layers that say why there is nothing to see of a learner, instead of an empty board."""

from functools import wraps

from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.layer import Extras, Layer, Picture, blank
from app.picture.legend import frame_in_words, legend
from app.picture.look import Look
from app.picture.raster import Raster


def reasoned(layer: Layer) -> Layer:
    """A layer that gives the reason where a learner lacks what it is about."""

    @wraps(layer.draw)
    def draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
        if layer.lacks(snapshot.spec.learner) is not None:
            return blank(look, raster)
        return layer.draw(snapshot, look, extras, raster)

    @wraps(layer.legend)
    def key(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
        lack = layer.lacks(snapshot.spec.learner)
        if lack is None:
            return layer.legend(snapshot, look, extras)
        turns = "frame" in layer.heeds_of(snapshot.spec.learner, look.option)
        frame = frame_in_words(snapshot, look, "nothing") if turns else "North is up."
        title = f"{layer.title_of(snapshot.spec.learner)}: {lack.word}"
        return legend(look, title, [], frame, turns=turns)

    @wraps(layer.caption)
    def caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
        lack = layer.lacks(snapshot.spec.learner)
        return layer.caption(snapshot, look, extras) if lack is None else lack.why

    return layer._replace(draw=draw, legend=key, caption=caption)
