"""State value: what each place is worth."""

from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.counted import counted_by
from app.picture.layer import Extras, Heeded, Layer, Picture
from app.picture.look import Look
from app.picture.raster import Raster
from app.picture.value_maps import (
    VALUE_HEEDS,
    counts,
    or_zero,
    state_value_picture,
    value_legend,
    value_shading,
)
from learners.learner_spec import LearnerSpec


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    return state_value_picture(snapshot, look, raster)


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    shading = value_shading(snapshot, look, or_zero(snapshot.value))
    return value_legend(snapshot, look, "of a place", shading)


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    if not or_zero(snapshot.value).any():
        return "Nothing has been learned yet: no place is worth anything."
    if not counts(snapshot):
        return (
            "No table says what a place is worth. What is seen is what the happiest skill expects"
            " of its own reward there."
        )
    if look.scale == "linear":
        return "What each place is worth: that falls so fast with distance that little else shows."
    return (
        "How near a capture is, as far as the learner knows: the brighter, the nearer. Where the"
        " thick line ends it, it knows of no way yet."
    )


def _titled(learner: LearnerSpec) -> str | None:
    return None if counted_by(learner) else "Best happiness"


def _ignores(learner: LearnerSpec, option: int) -> frozenset[Heeded]:
    return frozenset() if counted_by(learner) else frozenset({"scale", "flight"})


VALUE = Layer(
    "value",
    "State value",
    _draw,
    _legend,
    _caption,
    heeds=VALUE_HEEDS,
    titled=_titled,
    ignores=_ignores,
)
