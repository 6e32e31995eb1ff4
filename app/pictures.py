"""From a snapshot to numbers on a board, and from numbers to colours: pure functions.

Arrays over the board are ``(y, x)``; the picture is in the prey's own frame, the prey facing
east, unless said otherwise.
"""

import functools
from typing import Literal, NamedTuple

import cmap
import numpy as np

from sim import geometry
from sim.spec import N_HEADINGS, WorldSpec

FARTHEST_STEPS = 400.0
"""Upper end of the scale of equivalent distances: a little more than a circle at radius 60."""

Scale = Literal["steps", "linear"]


class Theme(NamedTuple):
    """Colours of one kind of page, each ``(r, g, b)`` of 0...255."""

    unknown: tuple[int, int, int]
    """The board where nothing is known."""
    lines: tuple[int, int, int]
    border: tuple[int, int, int]
    field: tuple[int, int, int]
    """The visual field."""
    prey: tuple[int, int, int]
    predator: tuple[int, int, int]
    capture: tuple[int, int, int]
    flight: tuple[int, int, int]
    timeout: tuple[int, int, int]
    loss: tuple[int, int, int]
    ink: tuple[int, int, int]


LIGHT = Theme(
    unknown=(244, 245, 247),
    lines=(222, 225, 230),
    border=(90, 98, 110),
    field=(60, 20, 90),
    prey=(20, 24, 32),
    predator=(213, 60, 0),
    capture=(0, 120, 180),
    flight=(200, 30, 90),
    timeout=(110, 115, 125),
    loss=(196, 24, 110),
    ink=(30, 34, 42),
)
DARK = Theme(
    unknown=(30, 33, 40),
    lines=(48, 52, 62),
    border=(150, 158, 172),
    field=(245, 235, 255),
    prey=(250, 250, 252),
    predator=(255, 140, 60),
    capture=(90, 200, 255),
    flight=(255, 90, 150),
    timeout=(160, 165, 175),
    loss=(232, 70, 150),
    ink=(232, 234, 240),
)


class Known(NamedTuple):
    """A folded value map: what the eight headings say of each place in the prey's frame."""

    steps: np.ndarray
    """(distance, direction) float64: mean equivalent distance to capture, NaN where none."""
    gain: np.ndarray
    """(distance, direction) float64: mean of the values above 0, 0 where none."""
    positive_share: np.ndarray
    """(distance, direction) float64: share of headings whose value is above 0."""
    loss: np.ndarray
    """(distance, direction) float64: mean size of the values below 0, 0 where none."""
    negative_share: np.ndarray
    """(distance, direction) float64: share of headings whose value is below 0."""


def equivalent_steps(value: np.ndarray, capture_reward: float, gamma: float) -> np.ndarray:
    """Steps from certain capture that a value is worth: n = ln(V / reward) / ln(gamma).

    NaN where V <= 0; otherwise clipped to 0...``FARTHEST_STEPS``.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        steps = np.log(value.astype(np.float64) / capture_reward) / np.log(gamma)
    return np.where(value > 0, np.clip(steps, 0.0, FARTHEST_STEPS), np.nan)


def folded(value: np.ndarray, capture_reward: float, gamma: float) -> Known:
    """Fold a value map ``(heading, distance, direction)`` into the prey's frame.

    Equivalent distances are averaged over the headings that have one.
    """
    turned = geometry.fold(value, value.shape[2])
    steps = equivalent_steps(turned, capture_reward, gamma)
    positive, negative = turned > 0, turned < 0
    n_positive, n_negative = positive.sum(axis=0), negative.sum(axis=0)
    return Known(
        steps=_mean_of(np.nan_to_num(steps), n_positive, np.nan),
        gain=_mean_of(np.where(positive, turned, 0), n_positive, 0.0),
        positive_share=n_positive / N_HEADINGS,
        loss=_mean_of(np.where(negative, -turned, 0), n_negative, 0.0),
        negative_share=n_negative / N_HEADINGS,
    )


def _mean_of(parts: np.ndarray, count: np.ndarray, where_none: float) -> np.ndarray:
    """Sum over the headings divided by how many took part."""
    mean = np.full(count.shape, where_none)
    np.divide(parts.sum(axis=0, dtype=np.float64), count, out=mean, where=count > 0)
    return mean


@functools.cache
def gain_colours() -> np.ndarray:
    """(256, 3) float64: from far from capture to certain capture; apart for all kinds of sight."""
    return cmap.Colormap("viridis")(np.linspace(0.12, 1.0, 256))[:, :3] * 255.0


def palette(colours: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Colours of levels 0...1, ``(..., 3)``; NaN counts as 0."""
    index = np.nan_to_num(np.clip(level, 0, 1) * (len(colours) - 1)).astype(np.int64)
    return colours[index]


def state_colours(
    known: Known, scale: Scale, reward: float, penalty: float, theme: Theme
) -> np.ndarray:
    """Colour of each folded state, ``(distance, direction, 3) uint8``.

    No colour where nothing is known; otherwise the hue says how good or bad, and how strongly it
    covers the board says how many headings know it.

    Args:
        known: the folded map.
        scale: ``steps``, the equivalent distance to capture, or ``linear`` in value.
        reward: value of certain capture, the upper end of the linear scale.
        penalty: size of the value of certain flight, the end of the scale of losses.
        theme: colours of the page.
    """
    level = nearness(known.steps) if scale == "steps" else known.gain / max(reward, 1e-9)
    board = np.array(theme.unknown, dtype=np.float64)
    gain = palette(gain_colours(), level)
    loss = loss_colours(known.loss / max(penalty, 1e-9), theme)
    up, down = known.positive_share[..., None], known.negative_share[..., None]
    return np.rint(board * (1 - up - down) + gain * up + loss * down).astype(np.uint8)


def nearness(steps: np.ndarray) -> np.ndarray:
    """Place on the colour scale of an equivalent distance: 1 at the prey, 0 at the far end.

    By its square root, because most of the board lies within the first quarter of the scale.
    """
    return 1.0 - np.sqrt(steps / FARTHEST_STEPS)


def loss_colours(level: np.ndarray, theme: Theme) -> np.ndarray:
    """Colour of a loss of 0...1 of the full one, ``(..., 3) float64``; by its cube root.

    A slight loss hardly covers the board, so that what is gained stays the figure.
    """
    cover = 0.12 + 0.88 * np.cbrt(np.clip(level, 0, 1))[..., None]
    return np.array(theme.unknown) * (1 - cover) + np.array(theme.loss) * cover


@functools.lru_cache(maxsize=8)
def _skill_states(world: WorldSpec) -> np.ndarray:
    return geometry.skill_states(world)


def on_board(per_state: np.ndarray, world: WorldSpec) -> np.ndarray:
    """Spread folded states ``(distance, direction, ...)`` over the board, ``(y, x, ...)``."""
    flat = per_state.reshape(-1, *per_state.shape[2:])
    return flat[_skill_states(world)]


def gradient_css(colours: np.ndarray) -> str:
    """A horizontal CSS gradient through a list of colours."""
    stops = colours[:: max(len(colours) // 12, 1)]
    return "linear-gradient(to right," + ",".join(css(stop) for stop in stops) + ")"


def css(colour: tuple[int, int, int] | np.ndarray) -> str:
    """A colour as CSS writes it."""
    red, green, blue = (round(float(part)) for part in colour)
    return f"rgb({red},{green},{blue})"
