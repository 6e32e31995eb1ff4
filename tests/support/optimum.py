"""The exact optimum, by value iteration on the known model: cell by cell, heading by heading.

Problem: from a cell, for a prey of a heading, choose moves so that the discounted reward
100 * gamma^(steps - 1) of the capture is as large as can be. The model is that of section 4.1
without the step limit and without the sensors: the state is the cell itself.

Operator: V(heading, cell) <- max over moves of reward + gamma * V(heading, cell after the move),
where capture and flight have a value of 0 after them.

Stopping rule: nothing changes any more. Moves are certain, so the values are exact after as many
sweeps as the longest way to the prey has steps.

No learner of this project can do better from any start, whatever its options, its sensors and
its exploration, because every trial is one way through this model.
"""

from typing import NamedTuple

import numpy as np

GAMMA = 0.9
CAPTURE_REWARD = 100.0
FLIGHT_REWARD = -50.0

MOVES = [(dx, dy) for dy in (-1, 0, 1) for dx in (-1, 0, 1)]
HEADINGS = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]


class Model(NamedTuple):
    """What each move does, for all headings and cells at once."""

    next_x: np.ndarray
    """``(move, y, x) int64``."""
    next_y: np.ndarray
    """``(move, y, x) int64``."""
    flight: np.ndarray
    """``(move, heading, y, x) bool``."""
    capture: np.ndarray
    """``(move, heading, y, x) bool``."""


def model_of(size: int) -> Model:
    """The world of section 4.1 on a grid of a size."""
    prey = size // 2
    y, x = np.mgrid[0:size, 0:size]
    distance_squared = (x - prey) ** 2 + (y - prey) ** 2
    # distance <= 27 * size / 120, in whole numbers.
    near = distance_squared * 120**2 <= (27 * size) ** 2
    visible = np.array([near & ((x - prey) * hx + (y - prey) * hy > 0) for hx, hy in HEADINGS])

    next_x = np.array([np.clip(x + dx, 0, size - 1) for dx, _ in MOVES])
    next_y = np.array([np.clip(y + dy, 0, size - 1) for _, dy in MOVES])
    flight, capture = [], []
    for x_t, y_t in zip(next_x, next_y, strict=True):
        on_prey = (x_t == prey) & (y_t == prey)
        # A move onto the prey's cell is judged from the cell it came from.
        judged = np.where(on_prey, visible, visible[:, y_t, x_t])
        closer = distance_squared[y_t, x_t] < distance_squared
        flight.append(judged & closer)
        capture.append(on_prey & ~flight[-1])
    return Model(next_x, next_y, np.array(flight), np.array(capture))


def optimal_values(size: int, gamma: float = GAMMA) -> np.ndarray:
    """Largest discounted reward from each state, ``(heading, y, x) float64``.

    The prey's own cell is 0: a trial is over there.
    """
    model = model_of(size)
    ended = model.flight | model.capture
    reward = FLIGHT_REWARD * model.flight + CAPTURE_REWARD * model.capture
    values = np.zeros((len(HEADINGS), size, size))
    while True:
        best = np.full_like(values, -np.inf)
        for move in range(len(MOVES)):
            future = values[:, model.next_y[move], model.next_x[move]]
            future = np.where(ended[move], 0.0, future)
            np.maximum(best, reward[move] + gamma * future, out=best)
        best[:, size // 2, size // 2] = 0.0
        if np.array_equal(best, values):
            return values
        values = best
