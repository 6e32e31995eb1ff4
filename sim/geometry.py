"""Where things are: cells, headings, moves, sensor readings, and the fold.

The one place that says what x and y mean: x grows to the east, y to the north, and an
array over the board is indexed ``[y, x]``.
"""

import numpy as np

from sim.spec import N_HEADINGS, WorldSpec

N_MOVES = 9
STAY = 4

MOVES = np.array([(m % 3 - 1, m // 3 - 1) for m in range(N_MOVES)], dtype=np.int64)
"""(move, xy): the eight neighbours and staying, from south-west to north-east."""

HEADINGS = np.array(
    [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)], dtype=np.int64
)
"""(heading, xy): heading f points to f * 45 degrees, counter-clockwise from east."""


def prey_xy(spec: WorldSpec) -> tuple[int, int]:
    """The prey's cell: the middle of the grid."""
    return spec.size // 2, spec.size // 2


def offsets(spec: WorldSpec) -> tuple[np.ndarray, np.ndarray]:
    """East and north offset of each cell from the prey, each ``(y, x) int64``."""
    px, py = prey_xy(spec)
    axis = np.arange(spec.size, dtype=np.int64)
    dx, dy = np.meshgrid(axis - px, axis - py)
    return dx, dy


def ring_edges(spec: WorldSpec) -> np.ndarray:
    """Outer edge of each ring in cells, ``(ring,) float64``; the last reaches the far corner."""
    px, py = prey_xy(spec)
    far = np.hypot(max(px, spec.size - 1 - px), max(py, spec.size - 1 - py))
    return far * (np.arange(1, spec.n_distances + 1) / spec.n_distances) ** spec.ring_exponent


def readings(spec: WorldSpec) -> np.ndarray:
    """Reading of ring and direction at each cell, ``ring * n_directions + direction``.

    It is the selection's; that of skills is ``readings(spec.of_skills)``.

    Direction is the sector in which the predator stands as seen from the prey, the first
    centred on east (section 4.1.1 has it the other way round, which only renames sectors).
    Shape ``(y, x) int64``.
    """
    dx, dy = offsets(spec)
    width = 2 * np.pi / spec.n_directions
    direction = np.floor(np.arctan2(dy, dx) / width + 0.5).astype(np.int64) % spec.n_directions
    ring = np.searchsorted(ring_edges(spec), np.hypot(dx, dy) * (1 - 1e-12))
    return ring * spec.n_directions + direction


def visible(spec: WorldSpec) -> np.ndarray:
    """Whether a prey of each heading sees each cell, ``(heading, y, x) bool`` (section 4.1).

    The visual field is the half-disc in front of the prey: offset . heading > 0 and
    distance <= vision radius.
    """
    dx, dy = offsets(spec)
    ahead = HEADINGS[:, 0, None, None] * dx + HEADINGS[:, 1, None, None] * dy > 0
    return ahead & (dx * dx + dy * dy <= (spec.vision_radius * spec.scale) ** 2)


def fold(values: np.ndarray, n_directions: int) -> np.ndarray:
    """Turn each heading's map into the prey's own frame, heading east.

    Exact, because headings are whole numbers of sectors.

    Args:
        values: ``(heading, ring, direction, ...)``, any type.
        n_directions: sectors of the direction sensor.

    Returns:
        An array of the same shape whose direction axis counts from the prey's heading.
    """
    turned = [
        np.roll(values[heading], -heading * n_directions // N_HEADINGS, axis=1)
        for heading in range(N_HEADINGS)
    ]
    return np.stack(turned)
