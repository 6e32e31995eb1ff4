"""Maps of value: what the layers share that show what a place is worth."""

from typing import Final

import numpy as np
from markupsafe import Markup, escape

from app.live.snapshot import Snapshot
from app.picture.colours import css, gain_colours, over_board, palette
from app.picture.contours import Contour, edges, isolines, segments
from app.picture.counted import STEPS_COUNTED, Counted, counted_by
from app.picture.frames import folds, in_frame
from app.picture.layer import Heeded, Over, Picture
from app.picture.legend import (
    bar,
    bar_marks,
    dots,
    frame_in_words,
    hatch,
    legend,
    limits,
    patch_of_board,
)
from app.picture.look import Look
from app.picture.raster import Raster, on_raster
from app.picture.shading import (
    SHOWN_FROM,
    Ruler,
    Shading,
    fitted_shading,
    fixed_shading,
    known_of,
)
from app.util.html import element, joined
from app.words.glossary import term
from app.words.numbers import of_any_size
from app.words.plain import joined_by_and
from learners.comparators.feudal import SEARCHED
from learners.kernel.state import weights_of
from learners.names import COMMANDS, SEARCH
from sim.spec import WorldSpec

VALUE_HEEDS: Final[frozenset[Heeded]] = frozenset({"frame", "scale", "fitted", "flight"})
HATCH_COVER = 0.4
"""How strongly a hatch covers the board."""
_LINE = (18, 62, 74)
"""A dark shade of the values' own colours, on light and on dark boards."""
_EDGE_ON_LIGHT, _EDGE_ON_DARK = (0, 88, 84), (170, 240, 205)
"""Shades of the values' colours as well, apart from them and from the board."""
_DOTS_LEVEL = 128
"""The colour in the legend of what few know, of the values' 256."""
_LEAST_EDGE = 12.0
"""Cells from the prey, on a grid of the standard size."""


def reward_of(snapshot: Snapshot) -> float:
    """Value of certain capture; never 0, for scales to end there."""
    world = snapshot.spec.world
    return max(world.capture_reward, world.flight_reward, 1e-9)


def penalty_of(snapshot: Snapshot) -> float:
    """Size of the value of certain flight."""
    world = snapshot.spec.world
    return max(-world.flight_reward, -world.capture_reward, 1e-9)


def own_most(snapshot: Snapshot, option: int) -> float:
    """What the own value of a skill, or of what obeys a command, is at most.

    Nothing earns more than that at every step; 0 of a skill that only has something to lose.
    """
    learner, world = snapshot.spec.learner, snapshot.spec.world
    if learner.options == COMMANDS:
        # What obeys is rewarded once, and then its task is over.
        searched = float(SEARCHED) * abs(world.capture_reward)
        return searched or 1.0 if learner.sub_policies[option] == SEARCH else 1.0
    skill = learner.skills[option]
    stated, weights = learner.skill_of(skill), learner.reward_of(skill)
    moves = max(abs(weights.gain), abs(weights.arc), abs(stated.behind))
    if not moves and stated.flight < 0:
        return 0.0
    # A move covers at most the diagonal of a cell, towards the prey or round it.
    earned = float(np.sqrt(2.0) * (moves or 1.0)) if learner.local_rewards == "signed" else 1.0
    return earned / (1.0 - learner.gamma)


def own_least(snapshot: Snapshot, option: int) -> float:
    """Size of what a skill has to lose at once: what it is punished with for flight, or 0."""
    learner = snapshot.spec.learner
    if not learner.skills:
        return 0.0
    return max(0.0, -learner.skill_of(learner.skills[option]).flight)


def counted_of(snapshot: Snapshot) -> Counted:
    """What the values of a learner count where they count anything."""
    return counted_by(snapshot.spec.learner) or STEPS_COUNTED


def counts(snapshot: Snapshot) -> bool:
    """Whether its values say how far off a capture is, and are not skills' own rewards."""
    return counted_by(snapshot.spec.learner) is not None


def or_zero(values: np.ndarray) -> np.ndarray:
    """Values, 0 where there is no option."""
    return np.where(np.isfinite(values), values, 0)


def value_shading(snapshot: Snapshot, look: Look, values: np.ndarray) -> Shading:
    """The scale of a value map.

    Limits are fitted to all eight headings whatever the frame, so that what is seen in one frame
    compares with the others.

    Args:
        snapshot: the moment.
        look: whether to fit.
        values: all values of the map, any shape, finite.
    """
    if not counts(snapshot):
        skills = range(len(snapshot.spec.learner.skills))
        weights = weights_of(snapshot.spec.learner)
        reward = max(float(weights[k]) * own_most(snapshot, k) for k in skills) or 1.0
        fixed = fixed_shading("linear", reward)
    else:
        reward = reward_of(snapshot)
        fixed = fixed_shading(look.scale, reward)
        if fixed.scale == "steps":
            farthest = counted_of(snapshot).farthest
            fixed = fixed._replace(gain=Ruler(0.0, farthest, "root"))
    if not look.fitted:
        return fixed
    return fitted_shading(values, snapshot.spec.learner.gamma, fixed, reward)


def value_picture(
    values: np.ndarray, shading: Shading, snapshot: Snapshot, look: Look, raster: Raster
) -> Picture:
    """Where the global reward is to be had, with a line round it.

    In full colour is what at least half of the headings know, dotted what fewer know; no colour is
    paler than another for that, since the front of what is learned would fade into the board. What
    expects flight is hatched, if it is wished: it is most of the board, and would cover the rest.

    Args:
        values: ``(heading, distance, direction)`` of the headings that take part.
        shading: their scale.
        snapshot: the moment.
        look: whose theme it is.
        raster: where it is drawn.
    """
    theme, world = look.theme, snapshot.spec.world
    known = known_of(values, reward_of(snapshot), snapshot.spec.learner.gamma)
    gain = np.rint(palette(gain_colours(), shading.level(known))).astype(np.uint8)
    is_shown = known.positive_share >= SHOWN_FROM
    colours = np.where(is_shown[..., None], gain, np.array(theme.unknown, np.uint8))
    pixels = on_raster(colours, raster)
    if look.flight:
        flees = on_raster((known.negative_share >= SHOWN_FROM) & ~is_shown, raster)
        pixels[flees & raster.rising] = over_board(np.array(theme.flight), HATCH_COVER, theme)
    few = on_raster((known.positive_share > 0) & ~is_shown, raster) & raster.dotted
    pixels[few] = on_raster(gain, raster)[few]

    def edges_of_known() -> tuple[Contour, ...]:
        edge = _EDGE_ON_DARK if theme.is_dark else _EDGE_ON_LIGHT
        return (Contour(edge_of(is_shown, world), edge, is_edge=True),)

    def within() -> Over:
        if shading.scale != "steps":
            return Over()
        steps = np.where(is_shown, known.steps, np.nan)
        lines = isolines(steps, world, counted_of(snapshot).lines)
        return Over(tuple(Contour(segments(line.points), _LINE) for line in lines))

    return Picture(pixels, edges=edges_of_known, within=within)


def edge_of(region: np.ndarray, world: WorldSpec) -> np.ndarray:
    """Segments round a region, without those that the prey's dot and arrow nearly cover."""
    parts = edges(region, world)
    return parts[np.hypot(parts[..., 0], parts[..., 1]).min(axis=1) > _LEAST_EDGE * world.scale]


def state_value_picture(snapshot: Snapshot, look: Look, raster: Raster) -> Picture:
    """The values of states, as :func:`value_picture`."""
    values = or_zero(snapshot.value)
    shading = value_shading(snapshot, look, values)
    return value_picture(in_frame(values, snapshot, look), shading, snapshot, look, raster)


# Legends ------------------------------------------------------------------------------------


def value_scale(shading: Shading, look: Look, nouns: str = "steps") -> list[Markup]:
    """The bar of a scale of gains, and its limits.

    Args:
        shading: the scale.
        look: how the board is seen.
        nouns: what is counted, where something is.
    """
    gain, colours = shading.gain, gain_colours()
    if shading.scale == "steps":
        # Its low end is on the right, where the colours are brightest.
        marks = [(1.0 - place, text) for place, text in bar_marks(gain, _steps)]
        if not look.fitted:
            marks = [(place, f"{text}+" if place == 0 else text) for place, text in marks]
        ends = f"{_steps(gain.high)} {nouns}", _steps(gain.low)
        return [bar(colours, marks), limits(look, *ends)]
    ends = of_any_size(gain.low), of_any_size(gain.high)
    return [bar(colours, bar_marks(gain, of_any_size)), limits(look, *ends)]


def _steps(steps: float) -> str:
    return f"{steps:.0f}" if steps >= 10 else f"{steps:.2g}"


def value_legend(snapshot: Snapshot, look: Look, of: str, shading: Shading) -> Markup:
    """Legend of a map of values of the global reward.

    Args:
        snapshot: the moment.
        look: how the board is seen.
        of: what has the values.
        shading: their scale.
    """
    theme = look.theme
    counted = counted_by(snapshot.spec.learner)
    title = joined([term("value", "Value"), of], " ")
    lines = Markup()
    if shading.scale == "steps":
        nouns = counted_of(snapshot).nouns
        # The term speaks of steps.
        to_capture = f"{nouns} to capture"
        title += ", as " + (term(to_capture) if nouns == "steps" else escape(to_capture))
        at = joined_by_and([_steps(steps) for steps in counted_of(snapshot).lines])
        lines = element(
            "div", f"Thick line: where value ends. Thin lines: {at} {nouns}.", class_="lines"
        )
    if counted is None:
        title = escape("Own reward that a skill expects, times its weight, of the happiest skill")
    key = [patch_of_board(look, "no value yet" if counted else "no skill expects any")]
    if look.flight:
        flees = css(over_board(np.array(theme.flight), HATCH_COVER, theme))
        key.append(hatch(flees, "expects to be noticed"))
    if folds(look):
        few = dots(css(gain_colours()[_DOTS_LEVEL]), look, "known for few headings")
        key.insert(0, few)
    return legend(
        look,
        title,
        [
            *value_scale(shading, look, counted_of(snapshot).nouns),
            element("div", joined(key, "")),
            lines,
        ],
        frame_in_words(snapshot, look, "the mean of those for which it has value"),
    )
