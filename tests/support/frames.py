"""Maps turned from the prey's own frame to the world's, for tests of what folds them."""

import numpy as np

from sim.spec import N_HEADINGS


def unfold(values: np.ndarray, n_directions: int) -> np.ndarray:
    """The inverse of :func:`sim.geometry.fold`."""
    turned = [
        np.roll(values[heading], heading * n_directions // N_HEADINGS, axis=1)
        for heading in range(N_HEADINGS)
    ]
    return np.stack(turned)
