"""How far apart colours are for those who see them."""

import numpy as np

SIGHT = {
    "ordinary": np.eye(3),
    # Machado, Oliveira and Fernandes (2009), severity 1, on linear RGB.
    "protanopia": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "deuteranopia": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
}
JUST_NOTICEABLE = 2.3
"""CIE76 distance that a careful eye just sees (Mahy, Van Eycken and Oosterlinck 1994)."""
PLAINLY_APART = 6 * JUST_NOTICEABLE


def linear(colours: np.ndarray) -> np.ndarray:
    """Linear light of sRGB colours of 0...255."""
    part = np.asarray(colours, float) / 255
    return np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)


def lab(colours: np.ndarray, sight: np.ndarray) -> np.ndarray:
    """CIE L*a*b* (D65) of sRGB colours as somebody of that sight sees them."""
    to_xyz = np.array(
        [
            [0.4124564, 0.3575761, 0.1804375],
            [0.2126729, 0.7151522, 0.0721750],
            [0.0193339, 0.1191920, 0.9503041],
        ]
    )
    white = to_xyz @ np.ones(3)
    ratio = np.clip(linear(colours) @ sight.T, 0, 1) @ to_xyz.T / white
    root = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    x, y, z = np.moveaxis(root, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def nearest(some: np.ndarray, others: np.ndarray, sight: np.ndarray) -> float:
    """Smallest CIE76 distance between two sets of colours."""
    apart = lab(some, sight)[:, None] - lab(others, sight)[None]
    return float(np.linalg.norm(apart, axis=-1).min())
