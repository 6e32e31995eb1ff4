"""What this project uses of it; SciPy itself is not typed."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

class _Distribution:
    def cdf(self, x: float) -> float: ...
    def ppf(self, q: float, df: float = ...) -> float: ...

class _RatioOfVariances:
    def sf(self, x: float, dfn: int, dfd: int) -> float: ...

f: _RatioOfVariances
norm: _Distribution
t: _Distribution

class ConfidenceInterval(NamedTuple):
    low: np.ndarray
    high: np.ndarray

class BootstrapResult:
    confidence_interval: ConfidenceInterval

def bootstrap(
    data: Sequence[np.ndarray],
    statistic: Callable[..., Any],
    *,
    n_resamples: int,
    batch: int,
    vectorized: bool,
    axis: int,
    confidence_level: float,
    method: str,
    rng: np.random.Generator,
) -> BootstrapResult: ...
