"""What a page of the audience may wish, which is to look, and what a class may answer.

One struct a message, with bounds. There is nothing else that is read of what it sends.
"""

from typing import Annotated, Final

import msgspec
from msgspec import Meta

from app.audience.taps import Tap
from app.live.snapshot import Snapshot
from app.picture.layer import Layer
from app.picture.layers import LAYERS
from app.picture.look import FOLDED, OF_TRIAL, Look
from app.picture.options import option_names
from app.picture.theme import DARK, LIGHT
from app.words.plain import HEADING_NAMES, plain

MOST_MOMENTS: Final = 256
"""Moments of a line that one can look at, besides what happened in it: those that watchers wish
are the same as far as that can be, so that each is made once."""
_MOST: Final = 2**53

_FOR_PRESENTER: Final = ("success", "change")
OFFERED: Final = {key: layer for key, layer in LAYERS.items() if key not in _FOR_PRESENTER}
"""Layers that one can choose for oneself: what the others need is made for the presenter alone."""
_FRAMES: Final = {
    FOLDED: "All as one, prey looks right",
    **{heading: f"Prey faces {name}" for heading, name in enumerate(HEADING_NAMES)},
}


class _Wish(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="do"):
    """Something that a watcher wishes; tagged by what that is."""

    dark: bool


class Follow(_Wish, frozen=True, tag="follow"):
    """See what the presenter sees."""


class LookAround(_Wish, frozen=True, tag="look"):
    """See something else."""

    layer: Annotated[str, Meta(max_length=32)] = "value"
    of: Annotated[int, Meta(ge=0, le=63)] = 0
    """Which option or skill, where the layer is about one."""
    frame: Annotated[int, Meta(ge=FOLDED, le=len(HEADING_NAMES) - 1)] = FOLDED
    step: Annotated[int, Meta(ge=0, le=_MOST)] | None = None
    """Of the line that the presenter looks at; None for its newest moment."""


class LookOwn(_Wish, frozen=True, tag="own"):
    """See the learner of one's own."""


Wish = Follow | LookAround | LookOwn
"""All of them."""

MOST_PICKED: Final = 8
"""Octants in one answer: there are no more."""
_Option = Annotated[str, Meta(max_length=100)]
Value = (
    _Option
    | Annotated[int, Meta(ge=-_MOST, le=_MOST)]
    | Annotated[float, Meta(ge=-_MOST, le=_MOST)]
    | Annotated[tuple[Annotated[str, Meta(max_length=2)], ...], Meta(max_length=MOST_PICKED)]
)
"""What is answered: an option, a number, or octants."""


class Answer(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="do", tag="answer"):
    """What a seat of a class answers. Whether it is one to what is asked is judged by the poll."""

    ballot: Annotated[int, Meta(ge=1, le=_MOST)]
    """Which time that something is asked."""
    value: Value


Act = Answer | Tap
"""What is done by a class: each counts, and not the newest alone."""


def look_of(wish: LookAround) -> Look:
    """How somebody wants to see the board."""
    layer = OFFERED.get(wish.layer, LAYERS["value"])
    return Look(
        theme=DARK if wish.dark else LIGHT,
        layer=layer.key,
        option=wish.of if layer.about != "nothing" else 0,
        frame=wish.frame if "frame" in layer.heeds else OF_TRIAL,
    )


def themed(look: Look, dark: bool) -> Look:
    """The presenter's look as it is on a dark page, or a light one."""
    return look._replace(theme=DARK if dark else LIGHT)


def offered_step(step: int, end_step: int, events: tuple[int, ...]) -> int:
    """The moment that is looked at by whoever wishes a step: that of an event, or one of few.

    As the line grows, the few are twice as far apart now and then: then they are every second one
    of those that there were.
    """
    step = min(step, end_step)
    if step in events:
        return step
    apart = 1
    while apart * MOST_MOMENTS < end_step:
        apart *= 2
    return step - step % apart


def offer_of(snapshot: Snapshot) -> dict[str, object]:
    """What there is to choose from, for a page of the audience."""
    learner = snapshot.spec.learner
    skills = tuple(map(plain, learner.sub_policies))
    options = option_names(snapshot)

    def names_of(layer: Layer) -> tuple[str, ...]:
        return {"option": options, "skill": skills}.get(layer.about, ())

    return {
        "layers": [
            {
                "key": layer.key,
                "title": layer.title_of(learner),
                "of": names_of(layer),
                "headings": "frame" in layer.heeds,
            }
            for layer in OFFERED.values()
            if layer.lacks(learner) is None
        ],
        "headings": [[frame, name] for frame, name in _FRAMES.items()],
    }
