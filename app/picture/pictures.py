"""From a snapshot to numbers on a board, and from numbers to colours: pure functions.

Arrays over the board are ``(y, x)``; the picture is in the prey's own frame, the prey facing
east, unless said otherwise.
"""

import functools
import itertools
import struct
import zlib
from collections.abc import Callable, Iterable, Mapping
from typing import Final, Literal, NamedTuple

import cmap
import numpy as np

from app.words.numbers import round_numbers
from app.words.placing import Room
from learners.measures import equivalent_distance
from sim import geometry
from sim.spec import N_HEADINGS, WorldSpec
from sim.world import CAPTURE, FLIGHT, TIMEOUT

FARTHEST_STEPS = 400.0
"""Upper end of the scale of equivalent distances: a little more than a circle at radius 60."""

Scale = Literal["steps", "linear"]
Colour = tuple[int, int, int]


class Theme(NamedTuple):
    """Colours of one kind of page, each ``(r, g, b)`` of 0...255."""

    unknown: Colour
    """The board where nothing is known."""
    lines: Colour
    border: Colour
    field: Colour
    """The visual field."""
    prey: Colour
    predator: Colour
    capture: Colour
    flight: Colour
    timeout: Colour
    loss: Colour
    zone: Colour
    """The circles between which trials start."""
    ink: Colour

    @property
    def is_dark(self) -> bool:
        """Whether the page is darker than what is written on it."""
        return sum(self.unknown) < sum(self.ink)

    def of_outcome(self, outcome: int) -> Colour:
        """Colour of a way to end a trial; that of the board for what is not known."""
        colours = {CAPTURE: self.capture, FLIGHT: self.flight, TIMEOUT: self.timeout}
        return colours.get(outcome, self.unknown)


Shape = Literal["circle", "diamond", "square"]
OUTCOME_SHAPES: Final[Mapping[int, Shape]] = {
    CAPTURE: "circle",
    FLIGHT: "diamond",
    TIMEOUT: "square",
}
"""Dots of ended trials, for those who cannot tell their colours apart."""

LIGHT = Theme(
    unknown=(244, 245, 247),
    lines=(222, 225, 230),
    border=(90, 98, 110),
    field=(60, 20, 90),
    prey=(20, 24, 32),
    predator=(213, 60, 0),
    capture=(0, 120, 180),
    flight=(80, 0, 160),
    timeout=(136, 141, 151),
    loss=(112, 0, 220),
    zone=(0, 130, 70),
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
    flight=(190, 120, 255),
    timeout=(120, 125, 135),
    loss=(105, 15, 255),
    zone=(120, 225, 140),
    ink=(232, 234, 240),
)


# Numbers ------------------------------------------------------------------------------------


class Known(NamedTuple):
    """A value map over one or more headings: what they say together of each place."""

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
    """Equivalent distances to capture, clipped to 0...``FARTHEST_STEPS``.

    NaN where there is none, see :func:`learners.measures.equivalent_distance`.
    """
    return np.clip(equivalent_distance(value, capture_reward, gamma), 0.0, FARTHEST_STEPS)


def known_of(values: np.ndarray, capture_reward: float, gamma: float) -> Known:
    """Sum up maps ``(heading, distance, direction)`` that are in one frame.

    Equivalent distances are averaged over the headings that have one.
    """
    steps = equivalent_steps(values, capture_reward, gamma)
    positive, negative = values > 0, values < 0
    n_positive, n_negative = positive.sum(axis=0), negative.sum(axis=0)
    return Known(
        steps=mean_of(np.nan_to_num(steps), n_positive, np.nan),
        gain=mean_of(np.where(positive, values, 0), n_positive, 0.0),
        positive_share=n_positive / len(values),
        loss=mean_of(np.where(negative, -values, 0), n_negative, 0.0),
        negative_share=n_negative / len(values),
    )


def mean_of(parts: np.ndarray, count: np.ndarray, where_none: float) -> np.ndarray:
    """Sum over the first axis divided by how many took part."""
    mean = np.full(count.shape, where_none)
    np.divide(parts.sum(axis=0, dtype=np.float64), count, out=mean, where=count > 0)
    return mean


# Scales of colours --------------------------------------------------------------------------


class Ruler(NamedTuple):
    """How a quantity is laid along a bar: from 0 at ``low`` to 1 at ``high``."""

    low: float
    high: float
    kind: Literal["linear", "root", "log"] = "linear"
    """``root`` gives the lower end more room than ``linear``, ``log`` each decade the same."""

    def place(self, quantity: np.ndarray | float) -> np.ndarray:
        """Place of a quantity along the bar, clipped to 0...1; NaN where there is none.

        In the middle, if the bar has no length.
        """
        quantity = np.asarray(quantity, dtype=np.float64)
        if not self.high > self.low:
            return np.where(np.isnan(quantity), np.nan, 0.5)
        clipped = np.clip(quantity, self.low, self.high)
        if self.kind == "log":
            return np.log(clipped / self.low) / np.log(self.high / self.low)
        part = (clipped - self.low) / (self.high - self.low)
        return np.sqrt(part) if self.kind == "root" else part


STEPS = Ruler(0.0, FARTHEST_STEPS, "root")
"""Equivalent distances, by the square root: most of the board lies in the first quarter."""


def nearness(steps: np.ndarray, ruler: Ruler = STEPS) -> np.ndarray:
    """Place on the colour scale of an equivalent distance: 1 at the prey, 0 at the far end."""
    return 1.0 - ruler.place(steps)


class Shading(NamedTuple):
    """How a value map becomes colours and heights."""

    scale: Scale
    gain: Ruler
    """Of equivalent distances where the scale is ``steps``, of values where it is linear."""
    penalty: float
    """Size of the value at which the scale of losses ends."""

    def level(self, known: Known) -> np.ndarray:
        """Place of the gains on the colour scale, 0...1; NaN where there is none."""
        if self.scale == "steps":
            return nearness(known.steps, self.gain)
        return self.gain.place(np.where(known.positive_share > 0, known.gain, np.nan))

    def loss_level(self, known: Known) -> np.ndarray:
        """Loss as a share of the full one, 0...1."""
        return np.clip(known.loss / max(self.penalty, 1e-9), 0.0, 1.0)


def fixed_shading(scale: Scale, reward: float, penalty: float) -> Shading:
    """The shading whose limits do not depend on what has been learned."""
    return Shading(scale, STEPS if scale == "steps" else Ruler(0.0, reward), penalty)


def fitted_shading(values: np.ndarray, gamma: float, fixed: Shading, reward: float) -> Shading:
    """A shading whose limits are the least and the most that is among values, if anything is."""
    gains, losses = values[values > 0], values[values < 0]
    gain = fixed.gain
    if len(gains):
        ends = np.array([gains.min(), gains.max()], dtype=np.float64)
        if fixed.scale == "steps":
            farthest, nearest = equivalent_steps(ends, reward, gamma)
            gain = Ruler(float(nearest), float(farthest), "root")
        else:
            gain = Ruler(float(ends[0]), float(ends[1]))
    penalty = float(-losses.min()) if len(losses) else fixed.penalty
    return Shading(fixed.scale, gain, penalty)


# Colours ------------------------------------------------------------------------------------


@functools.cache
def gain_colours() -> np.ndarray:
    """(256, 3) float64: from far from capture to certain capture; apart for all kinds of sight."""
    return cmap.Colormap("viridis")(np.linspace(0.12, 1.0, 256))[:, :3] * 255.0


@functools.lru_cache(maxsize=8)
def heat_colours(theme: Theme) -> np.ndarray:
    """(256, 3) float64: amounts, from hardly to very much; each step farther from the board."""
    if theme.is_dark:
        name, ends = "bids:inferno", (0.22, 0.97)
    else:
        name, ends = "colorbrewer:YlOrBr", (0.12, 1.0)
    return cmap.Colormap(name)(np.linspace(*ends, 256))[:, :3] * 255.0


COMPASS_COLOURS = np.array(
    [
        (251, 147, 180),
        (236, 140, 97),
        (165, 129, 0),
        (66, 117, 29),
        (0, 110, 91),
        (0, 114, 156),
        (104, 128, 212),
        (199, 143, 225),
    ],
    dtype=np.float64,
)
"""(direction, 3), counter-clockwise from east: a hue that goes round with the direction.

Lightness goes round with it, a quarter turn ahead of yellow and blue, so that without red or
green the eight still form a circle (OKLCH: 0.62 + 0.16 cos t, 0.13, t).
"""


@functools.lru_cache(maxsize=8)
def move_colours(theme: Theme) -> np.ndarray:
    """(move, 3) float64: a colour for each direction, and grey for staying."""
    eighths = np.arctan2(geometry.MOVES[:, 1], geometry.MOVES[:, 0]) / (np.pi / 4)
    colours = COMPASS_COLOURS[np.rint(eighths).astype(np.int64) % N_HEADINGS]
    colours[geometry.STAY] = theme.timeout
    return colours


OPTION_COLOURS = np.array(
    [
        (0, 114, 178),
        (230, 159, 0),
        (0, 158, 115),
        (204, 121, 167),
        (86, 180, 233),
        (213, 94, 0),
        (136, 34, 85),
        (153, 153, 51),
        (119, 119, 119),
        (136, 204, 238),
        (170, 68, 153),
        (221, 204, 119),
    ],
    dtype=np.float64,
)
"""(option, 3): the first six by Okabe and Ito, then by Tol: apart for all kinds of sight as far
as so many can be, and on light and dark boards."""


def palette(colours: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Colours of levels 0...1, ``(..., 3)``; NaN counts as 0."""
    index = np.nan_to_num(np.clip(level, 0, 1) * (len(colours) - 1)).astype(np.int64)
    return colours[index]


def over_board(colours: np.ndarray, cover: np.ndarray | float, theme: Theme) -> np.ndarray:
    """Colours that cover the empty board more or less, ``(..., 3) uint8``.

    Args:
        colours: ``(..., 3)``.
        cover: ``(...)``, from 0, the empty board, to 1.
        theme: colours of the page.
    """
    share = np.asarray(cover, dtype=np.float64)[..., None]
    board = np.array(theme.unknown, dtype=np.float64)
    return np.rint(board + (colours - board) * share).astype(np.uint8)


def shaded(known: Known, shading: Shading, theme: Theme) -> np.ndarray:
    """Colour of each state, ``(distance, direction, 3) uint8``.

    No colour where nothing is known; otherwise the hue says how good or bad, and how strongly it
    covers the board says how many headings know it.
    """
    board = np.array(theme.unknown, dtype=np.float64)
    gain = palette(gain_colours(), shading.level(known))
    loss = loss_colours(shading.loss_level(known), theme)
    up, down = known.positive_share[..., None], known.negative_share[..., None]
    return np.rint(board * (1 - up - down) + gain * up + loss * down).astype(np.uint8)


def shaded_heights(known: Known, shading: Shading) -> np.ndarray:
    """Height of each state, ``(distance, direction) float32``: -1...1, 0 where nothing is known.

    Gains rise as they brighten and losses sink as they darken; both by the share of headings.
    """
    up = np.nan_to_num(shading.level(known)) * known.positive_share
    down = np.cbrt(shading.loss_level(known)) * known.negative_share
    return (up - down).astype(np.float32)


def loss_colours(level: np.ndarray, theme: Theme) -> np.ndarray:
    """Colour of a loss of 0...1 of the full one, ``(..., 3) float64``; by its cube root.

    A slight loss hardly covers the board, so that what is gained stays the figure.
    """
    cover = 0.12 + 0.88 * np.cbrt(np.clip(level, 0, 1))[..., None]
    return np.array(theme.unknown) * (1 - cover) + np.array(theme.loss) * cover


# The board ----------------------------------------------------------------------------------


class Raster(NamedTuple):
    """A square of pixels over the board, row by row from the south-west."""

    cells: np.ndarray
    """(pixel,) int64: the board's cell under each pixel, ``y * size + x``."""
    states: np.ndarray
    """(pixel,) int64: its state, ``distance * n_directions + direction``."""
    seams: np.ndarray
    """(seam, 2) int64: neighbouring pixels of different states."""


def raster(world: WorldSpec, side: int | None = None) -> Raster:
    """The board in so many pixels along each side; one for each cell unless given."""
    return _raster(world.size, world.n_directions, world.n_distances, side or world.size)


@functools.lru_cache(maxsize=8)
def _raster(size: int, n_directions: int, n_distances: int, side: int) -> Raster:
    # By what it depends on alone, so that a change of the visual field finds it again.
    world = WorldSpec(size=size, n_directions=n_directions, n_distances=n_distances)
    nearest = (np.arange(side) * 2 + 1) * size // (2 * side)
    cells = (nearest[:, None] * size + nearest).ravel()
    states = geometry.skill_states(world).ravel()[cells]
    pixels = np.arange(side * side).reshape(side, side)
    pairs = np.concatenate(
        [
            np.stack([pixels[:, :-1].ravel(), pixels[:, 1:].ravel()], axis=1),
            np.stack([pixels[:-1].ravel(), pixels[1:].ravel()], axis=1),
        ]
    )
    return Raster(cells, states, pairs[states[pairs[:, 0]] != states[pairs[:, 1]]])


def on_raster(per_state: np.ndarray, raster: Raster) -> np.ndarray:
    """Spread states ``(distance, direction, ...)`` over pixels, ``(pixel, ...)``."""
    return per_state.reshape(-1, *per_state.shape[2:]).take(raster.states, axis=0)


# HTML and PNG -------------------------------------------------------------------------------

_TEXT_SHARE = 0.021
"""Width of a character of a legend as a share of its bar."""
_DECADES = 12
"""At most so many decades of a logarithmic bar are looked at for marks."""


def ticks(ruler: Ruler, write: Callable[[float], str]) -> list[tuple[float, str]]:
    """Marks along a bar, ``(place, text)`` by place: both ends, and round numbers that fit between.

    Texts stand inside the bar at its ends and are centred in its middle.
    """
    chosen: list[tuple[float, str]] = []
    room = Room(0.0, 1.0)
    for number in (ruler.high, ruler.low, *_round_numbers(ruler)):
        place, text = float(ruler.place(number)), write(number)
        width = (len(text) + 2) * _TEXT_SHARE
        if room.taken(place - place * width, place + (1 - place) * width):
            chosen.append((place, text))
    return sorted(chosen)


def _round_numbers(ruler: Ruler) -> Iterable[float]:
    """Numbers worth a mark between the ends of a bar, the most welcome first."""
    low, high = ruler.low, ruler.high
    if not high > low:
        return []
    if ruler.kind == "linear":
        return [low + (high - low) * part / 4 for part in (2, 1, 3)]
    top = int(np.ceil(np.log10(high)))
    if ruler.kind == "log":
        # Every other decade first, so that where not all have room the marks are even.
        decades = [*range(top, top - _DECADES, -2), *range(top - 1, top - _DECADES, -2)]
        numbers = [10.0**decade for decade in decades]
    else:
        upwards = round_numbers(10.0 ** (top - 3))
        numbers = reversed([*itertools.takewhile(lambda number: number < high, upwards)])
    return [number for number in numbers if low < number < high]


def bar_html(gradient: str, marks: Iterable[tuple[float, str]]) -> str:
    """A bar of colours with marks ``(place 0...1, text)`` under it."""
    labels = "".join(
        f'<span style="position:absolute;left:{100 * at:.1f}%;white-space:nowrap;'
        f'transform:translateX({-100 * at:.0f}%)">{text}</span>'
        for at, text in marks
    )
    return (
        f'<div style="height:0.9em;border-radius:3px;background:{gradient}"></div>'
        f'<div style="position:relative;height:1.5em">{labels}</div>'
    )


def swatch_html(background: str, text: str, width: str = "0.8em", shape: Shape = "square") -> str:
    """A patch of a colour, or of a gradient, and what it means."""
    forms = {"circle": "border-radius:50%", "diamond": "transform:rotate(45deg) scale(0.8)"}
    return (
        '<span style="white-space:nowrap;margin-right:0.6em"><span style="display:inline-block;'
        f"width:{width};height:0.8em;margin-right:0.3em;vertical-align:-0.1em;"
        f"{forms.get(shape, 'border-radius:2px')};"
        f'background:{background};box-shadow:inset 0 0 0 1px rgba(128,128,128,0.4)"></span>'
        f"{text}</span> "
    )


def gradient_css(colours: np.ndarray) -> str:
    """A horizontal CSS gradient through a list of colours."""
    stops = colours[:: max(len(colours) // 12, 1)]
    return "linear-gradient(to right," + ",".join(css(stop) for stop in stops) + ")"


def css(colour: Colour | np.ndarray) -> str:
    """A colour as CSS writes it."""
    red, green, blue = (round(float(part)) for part in colour)
    return f"rgb({red},{green},{blue})"


def png(image: np.ndarray) -> bytes:
    """A PNG file with a palette.

    Where an image has more than 256 colours, those that differ least become one.

    Args:
        image: ``(row, column, 3) uint8``, the first row on top.
    """
    index, colours = _with_palette(image)
    height, width = index.shape
    header = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)
    # Each row is led by the number of its filter, 0 for none.
    lines = np.zeros((height, width + 1), np.uint8)
    lines[:, 1:] = index
    parts = [
        (b"IHDR", header),
        (b"PLTE", colours.tobytes()),
        (b"IDAT", zlib.compress(lines.tobytes(), 6)),
        (b"IEND", b""),
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, data) for kind, data in parts)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _with_palette(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """An image as indices ``(row, column) uint8`` into colours ``(index, 3) uint8``."""
    for bits in (5, 4, 2):
        kept = (image >> (8 - bits)).astype(np.int32)
        code = (kept[..., 0] << 2 * bits) | (kept[..., 1] << bits) | kept[..., 2]
        met = np.zeros(1 << 3 * bits, bool)
        met[code] = True
        colours_met = np.flatnonzero(met)
        if len(colours_met) <= 256:
            break
    place = np.zeros(met.size, np.uint8)
    place[colours_met] = np.arange(len(colours_met))
    index = place[code]
    colours = np.zeros((len(colours_met), 3), np.uint8)
    colours[index] = image
    return index, colours
