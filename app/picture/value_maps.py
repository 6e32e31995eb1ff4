"""Maps of value: what the layers share that show what a place is worth."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.colours import gain_colours, gradient_css, loss_colours, over_board
from app.picture.frames import in_frame
from app.picture.legend import (
    bar,
    bar_marks,
    frame_in_words,
    legend,
    limits,
    patch_of_board,
    swatch,
)
from app.picture.look import Look
from app.picture.shading import (
    Shading,
    fitted_shading,
    fixed_shading,
    known_of,
    shaded,
)
from app.picture.theme import Theme
from app.util.html import element, joined
from app.words.numbers import of_any_size

FAINT = 0.5
"""How strongly values cover the board below arrows, which are to be seen on it."""
_MEAN = "the mean over its eight headings, paler where fewer of them know anything"


def reward_of(snapshot: Snapshot) -> float:
    """Value of certain capture; never 0, for scales to end there."""
    world = snapshot.spec.world
    return max(world.capture_reward, world.flight_reward, 1e-9)


def penalty_of(snapshot: Snapshot) -> float:
    """Size of the value of certain flight."""
    world = snapshot.spec.world
    return max(-world.flight_reward, -world.capture_reward, 1e-9)


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
    reward = reward_of(snapshot)
    fixed = fixed_shading(look.scale, reward, penalty_of(snapshot))
    if not look.fitted:
        return fixed
    return fitted_shading(values, snapshot.spec.learner.gamma, fixed, reward)


def value_map(values: np.ndarray, shading: Shading, snapshot: Snapshot, look: Look) -> np.ndarray:
    """Colours of states, ``(distance, direction, 3) uint8``.

    Args:
        values: ``(heading, distance, direction)`` of the headings that take part.
        shading: their scale.
        snapshot: the moment.
        look: whose theme it is.
    """
    known = known_of(values, reward_of(snapshot), snapshot.spec.learner.gamma)
    return shaded(known, shading, look.theme)


def state_value_map(snapshot: Snapshot, look: Look) -> np.ndarray:
    """Colours of the values of states, as :func:`value_map`."""
    values = or_zero(snapshot.value)
    shading = value_shading(snapshot, look, values)
    return value_map(in_frame(values, snapshot, look), shading, snapshot, look)


# Legends ------------------------------------------------------------------------------------


def value_scale(shading: Shading, look: Look, cover: float = 1.0) -> list[Markup]:
    """The bar of a scale of gains, and its limits.

    Args:
        shading: the scale.
        look: how the board is seen.
        cover: how strongly the values cover the board, 0...1.
    """
    gain, colours = shading.gain, over_board(gain_colours(), cover, look.theme)
    if shading.scale == "steps":
        # Its low end is on the right, where the colours are brightest.
        marks = [(1.0 - place, text) for place, text in bar_marks(gain, _steps)]
        return [bar(colours, marks), limits(look, f"{_steps(gain.high)} steps", _steps(gain.low))]
    ends = of_any_size(gain.low), of_any_size(gain.high)
    return [bar(colours, bar_marks(gain, of_any_size)), limits(look, *ends)]


def _steps(steps: float) -> str:
    return f"{steps:.0f}" if steps >= 10 else f"{steps:.2g}"


def losses(shading: Shading, theme: Theme, text: str, cover: float = 1.0) -> Markup:
    """A swatch of the scale of losses, with its limits."""
    worst = loss_colours(np.linspace(0.0, 1.0, 12), theme)
    gradient = gradient_css(over_board(worst, cover, theme))
    return swatch(gradient, f"{text}, 0 to -{of_any_size(shading.penalty)}", width="4em")


def value_legend(
    snapshot: Snapshot,
    look: Look,
    what: str,
    shading: Shading,
    more: Markup | str = "",
    cover: float = 1.0,
) -> Markup:
    """Legend of a map of values of the global reward.

    Args:
        snapshot: the moment.
        look: how the board is seen.
        what: what has the values.
        shading: their scale.
        more: what else there is to know.
        cover: how strongly the values cover the board, 0...1.
    """
    measure = ", as steps to certain capture" if shading.scale == "steps" else ""
    known = losses(shading, look.theme, "expects flight", cover), patch_of_board(look, "not known")
    return legend(
        look,
        what + measure,
        [*value_scale(shading, look, cover), element("div", joined(known, "")), more],
        frame_in_words(snapshot, look, _MEAN),
    )
