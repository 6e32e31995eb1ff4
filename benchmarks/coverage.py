"""How often the interval of a mean holds the mean: ``python -m benchmarks.coverage``.

Runs are drawn from distributions whose mean is known: a normal one, one with two humps of equal
height, as runs that either find a way or do not, and one in which one run in five fails.
"""

from collections.abc import Callable, Mapping

import numpy as np

from app.analysis import estimates

REPETITIONS = 2_000
"""Samples of each kind: a share of 0.95 is known to within 0.01 by them."""
SIZES = (5, 10, 30, 100)
_SEED = 20

Draw = Callable[[np.random.Generator, int], np.ndarray]


def normal(rng: np.random.Generator, n: int) -> np.ndarray:
    """Runs that differ by chance alone."""
    return rng.normal(0, 1, n)


def two_humps(rng: np.random.Generator, n: int) -> np.ndarray:
    """Half of the runs lie high, half low, ten standard deviations apart."""
    return rng.normal(0, 1, n) + np.where(rng.random(n) < 0.5, 5, -5)


def one_in_five_fails(rng: np.random.Generator, n: int) -> np.ndarray:
    """One run in five lies ten standard deviations below the others."""
    return rng.normal(0, 1, n) + np.where(rng.random(n) < 0.2, -8, 2)


KINDS: Mapping[str, Draw] = {
    "normal": normal,
    "two humps": two_humps,
    "one in five fails": one_in_five_fails,
}
"""Distributions of mean 0, by name."""


def coverage(draw: Draw, n: int, repetitions: int = REPETITIONS) -> float:
    """Share of samples of ``n`` runs whose interval holds the mean, which is 0."""
    rng = np.random.default_rng(_SEED)
    held = 0
    for _ in range(repetitions):
        found = estimates.mean(list(draw(rng, n)), estimates.bootstrap_rng())
        held += found.low <= 0 <= found.high
    return held / repetitions


def main() -> None:
    """Print a table."""
    print("runs", *KINDS, sep="\t")
    for n in SIZES:
        print(n, *(f"{coverage(draw, n):.3f}" for draw in KINDS.values()), sep="\t")


if __name__ == "__main__":
    main()
