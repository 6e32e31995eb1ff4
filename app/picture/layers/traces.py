"""Eligibility now: which values what happens next is learned for."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.amounts import amount_legend, draw_amount
from app.picture.colours import TRACES, amount_colours, css
from app.picture.frames import in_frame
from app.picture.layer import Extras, Lack, Layer, Picture
from app.picture.legend import frame_in_words, legend, swatch
from app.picture.look import Look
from app.picture.options import has_moves, option_names
from app.picture.raster import Raster
from app.picture.shading import Ruler
from app.util.html import element
from app.words.numbers import counted, of_any_size
from app.words.plain import named
from learners.comparators.feudal import MOST_STEPS
from learners.kernel.layout import regions_of
from learners.kernel.state import LEAST_TRACE
from learners.learner_spec import LearnerSpec
from learners.names import COMMANDS

_RULER = Ruler(LEAST_TRACE, 1.0, "log")


def _eligible(snapshot: Snapshot) -> np.ndarray:
    """How much each state's values are learned for now, ``(heading, distance, direction)``."""
    if snapshot.eligibility is not None:
        return snapshot.eligibility.max(axis=-1).astype(np.float64)
    found = np.zeros(snapshot.value.shape)
    regions = regions_of(snapshot.spec)
    if regions is not None and snapshot.commanded is not None:
        within = regions.of_reading == snapshot.commanded.region
        found[snapshot.heading] = within.reshape(found.shape[1:])
    elif snapshot.held is not None:
        found.ravel()[snapshot.held.state] = 1.0
    return found


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    # All are of the trial's own heading, so a mean over eight would say an eighth of it.
    most = in_frame(_eligible(snapshot), snapshot, look).max(axis=0)
    return draw_amount(most, _RULER, TRACES, look, raster)


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    kind = _kind(snapshot.spec.learner)
    title = _TITLES[kind]
    if kind != "traces":
        full = swatch(css(amount_colours(TRACES, look.theme)[-1]), "here")
        frame = frame_in_words(snapshot, look, "that of the running trial's heading")
        return legend(look, title, [element("div", full)], frame)
    return amount_legend(
        snapshot, look, title, _RULER, TRACES, of_any_size, "nothing", "the most of its headings"
    )


_TITLES = {
    "traces": "Share of the next error that a place learns",
    "held": "Where the choice that holds was made",
    "command": "Region in which the command was given",
}


def _kind(learner: LearnerSpec) -> str:
    if learner.trace_decay is not None:
        return "traces"
    return "command" if learner.options == COMMANDS else "held"


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    kind = _kind(snapshot.spec.learner)
    if kind == "traces":
        if not _eligible(snapshot).any():
            return "Which places the next reward reaches: none, as a hunt begins without traces."
        return (
            "Which places learn from what happens next: those just come through, the latest most; a"
            " random move cuts off all before it."
        )
    names = option_names(snapshot)
    if kind == "command":
        held = snapshot.commanded
        if held is None:
            return "Where the command that holds was given: one is given with the next step."
        return (
            f"{named(names[held.command])} was commanded here {counted(held.steps, 'step')} ago,"
            f" and holds until this region is left, {MOST_STEPS} steps at most."
        )
    choice, spec = snapshot.held, snapshot.spec.learner.held
    if choice is None or spec is None:
        return "Where the choice that holds was made: one is made with the next step."
    until = "until the place changes, at most" if spec.until == "change" else ""
    name = names[choice.option]
    name = f"moving {name}" if has_moves(snapshot) else name
    kept = " ".join(part for part in (until, counted(spec.most, "step")) if part)
    return (
        f"{named(name)} was chosen here {counted(choice.steps, 'step')} ago, and is kept: {kept}."
    )


def _lacks(learner: LearnerSpec) -> Lack | None:
    if learner.trace_decay is not None or learner.held is not None or learner.options == COMMANDS:
        return None
    return Lack(
        "nothing is kept",
        "This learner learns from each step about that step alone: no earlier move has a trace, and"
        " nothing is kept for several steps.",
    )


def _titled(learner: LearnerSpec) -> str | None:
    if learner.trace_decay is not None or _lacks(learner) is not None:
        return None
    return "Command that holds" if learner.options == COMMANDS else "Choice that holds"


ELIGIBLE = Layer(
    "traces",
    "Eligibility now",
    _draw,
    _legend,
    _caption,
    heeds=frozenset({"frame"}),
    lacks=_lacks,
    titled=_titled,
)
