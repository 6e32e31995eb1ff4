"""The eight octants round the prey, as people name, choose and see them.

They are told in the prey's own frame, as a folded picture has it: straight ahead is east. Each is
45 degrees wide, half of that to either side of its middle, and reaches from the prey's cell to the
edge of the board. A line between two of them meets no cell's middle but the prey's: the tangent of
22.5 degrees is no fraction.
"""

import functools
import math
from collections.abc import Iterable
from typing import Final, NamedTuple

import numpy as np

from app.documents.lesson_grammar import OCTANTS
from app.picture.theme import Colour

_WIDE: Final = math.pi / 4
_ARC_POINTS: Final = 17
_ALONG_HATCH: Final = 193
"""Points of a line at which it is tried where it enters and leaves an octant."""
_FINER: Final = 2
"""Pixels of a fill are judged so many times as finely along each side, so that edges are smooth."""
_HARDLY: Final = 1e-9


def octant_at(east: float, north: float, heading: int = 0) -> str | None:
    """The octant of a place, None where the prey stands.

    Args:
        east: how far to the east of the prey the place is.
        north: how far to the north.
        heading: where the prey looks.
    """
    if east == 0 and north == 0:
        return None
    turned = math.atan2(north, east) / _WIDE - heading
    return OCTANTS[math.floor(turned + 0.5) % len(OCTANTS)]


def in_order(octants: Iterable[str]) -> tuple[str, ...]:
    """Each once, from straight ahead on."""
    chosen = set(octants)
    return tuple(octant for octant in OCTANTS if octant in chosen)


def middle(octant: str, radius: float, heading: int = 0) -> tuple[float, float]:
    """East and north of a place in the middle of an octant."""
    angle = _angle(octant, heading)
    return radius * math.cos(angle), radius * math.sin(angle)


def outline(octant: str, inner: float, outer: float, inset: float, heading: int = 0) -> np.ndarray:
    """The edge of an octant, ``(n, 2)``, closed.

    Args:
        octant: which.
        inner: radius at which it begins.
        outer: radius at which it ends.
        inset: how far its sides lie within it, so that neighbours can be told apart.
        heading: where the prey looks.
    """
    reach = math.asin(min(inset / outer, 1.0))
    half = _WIDE / 2
    arc = np.linspace(-half + reach, half - reach, _ARC_POINTS)
    far = outer * np.column_stack([np.cos(arc), np.sin(arc)])
    reach = math.asin(min(inset / inner, 1.0))
    back = np.linspace(half - reach, -half + reach, _ARC_POINTS)
    near = inner * np.column_stack([np.cos(back), np.sin(back)])
    points = np.concatenate([far, near, far[:1]])
    return _turned(points, _angle(octant, heading))


def hatch(octant: str, inner: float, outer: float, apart: float, heading: int = 0) -> np.ndarray:
    """Slanting lines within an octant, ``(n, 2, 2)`` from end to end."""
    along = np.linspace(-outer, outer, _ALONG_HATCH)
    lines: list[np.ndarray] = []
    for away in np.arange(-outer + apart / 2, outer, apart):
        # The same slant in all of them, so that several side by side are one field.
        points = np.column_stack([(along - away) / math.sqrt(2), (along + away) / math.sqrt(2)])
        radius = np.hypot(points[:, 0], points[:, 1])
        angle = np.arctan2(points[:, 1], points[:, 0]) - _angle(octant, heading)
        off = np.abs(np.angle(np.exp(1j * angle)))
        within = np.flatnonzero((off < _WIDE / 2) & (radius > inner) & (radius < outer))
        if len(within) > 1:
            lines.append(points[[within[0], within[-1]]])
    return np.stack(lines) if lines else np.zeros((0, 2, 2))


def borders(inner: float, outer: float, heading: int = 0) -> np.ndarray:
    """The lines between neighbours, ``(8, 2, 2)``."""
    angles = (np.arange(len(OCTANTS)) + 0.5 + heading) * _WIDE
    ways = np.column_stack([np.cos(angles), np.sin(angles)])
    return np.stack([inner * ways, outer * ways], axis=1)


class Fill(NamedTuple):
    """An octant, or a ring's part of one, in one colour that lets the board be seen."""

    octant: str
    inner: float
    outer: float
    colour: Colour
    strength: float
    """From 0, nothing, to 1, nothing else."""


def filled(fills: Iterable[Fill], units: float, side: int, heading: int = 0) -> np.ndarray:
    """A picture of fills, the later over the earlier, ``(y, x, 4) uint8`` from the south-west on.

    Args:
        fills: what is filled.
        units: width and height of the picture, with the prey in its middle.
        side: pixels along each.
        heading: where the prey looks.
    """
    octants, radius = _ground(units, side * _FINER)
    colours = np.zeros((*radius.shape, 3))
    alpha = np.zeros(radius.shape)
    for octant, inner, outer, colour, strength in fills:
        number = (OCTANTS.index(octant) + heading) % len(OCTANTS)
        there = (octants == number) & (radius >= inner) & (radius <= outer)
        under = alpha[there] * (1 - strength)
        mixed = strength * np.array(colour, float) + under[:, None] * colours[there]
        alpha[there] = strength + under
        colours[there] = mixed / np.maximum(alpha[there], _HARDLY)[:, None]
    weighed = _coarser(np.dstack([colours * alpha[..., None], alpha]))
    shown = weighed[..., 3]
    plain = weighed[..., :3] / np.maximum(shown, _HARDLY)[..., None]
    return np.rint(np.dstack([plain, 255 * shown])).astype(np.uint8)


@functools.lru_cache(maxsize=2)
def _ground(units: float, side: int) -> tuple[np.ndarray, np.ndarray]:
    """The number of the octant under each pixel, and how far it is from the prey, ``(y, x)``."""
    along = ((np.arange(side) + 0.5) / side - 0.5) * units
    east, north = np.meshgrid(along, along)
    numbers = np.floor(np.arctan2(north, east) / _WIDE + 0.5).astype(np.int8) % len(OCTANTS)
    return numbers, np.hypot(east, north)


def _coarser(fine: np.ndarray) -> np.ndarray:
    rows, columns, parts = fine.shape
    shape = (rows // _FINER, _FINER, columns // _FINER, _FINER, parts)
    return np.asarray(fine.reshape(shape).mean(axis=(1, 3)))


def _angle(octant: str, heading: int) -> float:
    return (OCTANTS.index(octant) + heading) * _WIDE


def _turned(points: np.ndarray, angle: float) -> np.ndarray:
    cos, sin = math.cos(angle), math.sin(angle)
    return points @ np.array([[cos, sin], [-sin, cos]])
