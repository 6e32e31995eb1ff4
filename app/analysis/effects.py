"""What each setting of a design does, and what pairs of them do beyond that. Pure.

A design is a number of variants of one preset that differ in several settings: all combinations of
some values, or draws at random. Each variant has one number, the mean of its runs. It is taken for
a sum of one smooth function of each setting (an additive model), fitted by least squares:

    y = mean + f_1(x_1) + ... + f_k(x_k) + rest

A setting of numbers enters by its ranks among the variants, whatever its scale, in Legendre
polynomials up to the third degree; one of other values by a level for each. How much a setting
matters is the share of the variance between variants that its function accounts for beyond all the
others, less what as many random columns would (omega squared), tested by F. A pair of settings has
the share that products of their polynomials account for beyond the whole sum. Both are corrected
for their number by Holm's procedure. Bands are percentile bootstraps over variants.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from app.analysis import estimates
from app.analysis.axles import Axle
from app.analysis.significance import holm
from app.analysis.sweeps import axle_of, column_of

_MOST_DEGREES = 3
_MOST_PAIR_DEGREES = 2
_VARIANTS_PER_TERM = 3
"""Variants that a sum needs for each of its terms to be fitted at all."""
_MOST_LEVELS = 12
"""Values of a setting of numbers that its function is shown at, each; of more, it is a curve."""
_CURVE_POINTS = 41
_RIDGE = 1e-9
"""Keeps a resample in which a value is missing from having no solution; moves nothing else."""
SIGNIFICANT = 0.05


class Factor(NamedTuple):
    """A setting, and its value in each variant."""

    axle: Axle
    column: Sequence[Any]


class Response(NamedTuple):
    """The part of a setting in the sum, at some of its values, the others at their average."""

    axle: Axle
    values: Sequence[Any]
    mean: np.ndarray
    """(value,) float64."""
    low: np.ndarray
    high: np.ndarray


class Share(NamedTuple):
    """How much of the variance between variants something accounts for."""

    of_variance: float
    """0 to 1; what chance would account for is taken off, so that 0 is nothing."""
    p: float
    """Chance of so much or more if it made no difference, corrected for the number of shares."""

    @property
    def is_significant(self) -> bool:
        """Whether chance alone would hardly do that."""
        return self.p < SIGNIFICANT


class Analysis(NamedTuple):
    """What the settings of a design do to one number."""

    factors: Sequence[Factor]
    values: np.ndarray
    """(variant,) float64: what it was in each of the variants that have one."""
    used: Sequence[int]
    """Places of these among all variants."""
    responses: Sequence[Response]
    """Of each setting."""
    alone: Sequence[Share]
    """Of each setting."""
    together: Mapping[tuple[int, int], Share]
    """Of each pair of settings, by their places; what they do alone is not in it."""
    of_sum: float
    """Share of the variance that all settings account for, one by one, 0 to 1."""


def factors_of(variants: Sequence[Mapping[str, Any]], settings: Mapping[str, Any]) -> list[Factor]:
    """The settings in which draws differ; those that are always the same count as one.

    Args:
        variants: what each of them sets.
        settings: all settings of one of them, to call an episode by its skill.
    """
    shared = [key for key in variants[0] if all(key in overrides for overrides in variants)]
    bundles: dict[str, list[str]] = {}
    for key in shared:
        values = [repr(overrides[key]) for overrides in variants]
        if len(set(values)) > 1:
            bundles.setdefault("\0".join(values), []).append(key)
    columns = [column_of(bundle, variants) for bundle in bundles.values()]
    return [
        Factor(axle_of(bundle, column, settings), column)
        for bundle, column in zip(bundles.values(), columns, strict=True)
    ]


def analysed(factors: Sequence[Factor], values: Sequence[float]) -> Analysis | None:
    """What settings do; None where there are too few variants to tell, or all are the same.

    Args:
        factors: two or more settings.
        values: of each variant; those without one (NaN) are left out.
    """
    used = [place for place, value in enumerate(values) if math.isfinite(value)]
    found = np.asarray([values[place] for place in used], np.float64)
    kept = [factor._replace(column=[factor.column[k] for k in used]) for factor in factors]
    if len(kept) < 2 or not found.size or not np.ptp(found):
        return None
    terms = _terms_of(kept, found.size)
    if terms is None:
        return None
    fit = _Fit([term.columns(term.factor.column) for term in terms], found)
    pairs = {
        pair: products
        for pair in combinations(range(len(terms)), 2)
        if (products := _products(terms, pair, found.size - fit.n_terms)) is not None
    }
    together = [fit.share_beyond(products) for products in pairs.values()]
    return Analysis(
        factors=kept,
        values=found,
        used=used,
        responses=_responses(terms, fit, found),
        alone=_corrected([fit.share_of(place) for place in range(len(terms))]),
        together=dict(zip(pairs, _corrected(together), strict=True)),
        of_sum=fit.share,
    )


# --- Terms of the sum ----------------------------------------------------------------------------


class _Term(NamedTuple):
    """How a setting enters the sum."""

    factor: Factor
    degrees: int
    """Of its polynomials; for a setting of other values than numbers, its levels less one."""
    anchors: tuple[np.ndarray, np.ndarray]
    """Of a setting of numbers: its values, and their mean ranks scaled to -1 to 1."""
    means: np.ndarray
    """(degree,) float64: of the columns, over the variants, which are taken off."""

    def columns(self, values: Sequence[Any], degrees: int | None = None) -> np.ndarray:
        """Columns for some values of the setting, ``(value, degree) float64``, of mean 0."""
        found = _columns(self.factor.axle, self.anchors, values, self.degrees) - self.means
        return found[:, :degrees]


def _columns(
    axle: Axle, anchors: tuple[np.ndarray, np.ndarray], values: Sequence[Any], degrees: int
) -> np.ndarray:
    if not axle.is_numeric:
        levels = [list(axle.values).index(value) for value in values]
        return np.eye(len(axle.values))[levels][:, 1:]
    place = np.interp(np.asarray(values, np.float64), *anchors)
    return np.polynomial.legendre.legvander(place, degrees)[:, 1:]


def _terms_of(factors: Sequence[Factor], n: int) -> list[_Term] | None:
    """Terms of as high a degree as so many variants allow; None where they allow none."""
    for most in range(_MOST_DEGREES, 0, -1):
        degrees = [
            min(most, len(f.axle.values) - 1) if f.axle.is_numeric else len(f.axle.values) - 1
            for f in factors
        ]
        if _VARIANTS_PER_TERM * (1 + sum(degrees)) <= n:
            return [_term(factor, d) for factor, d in zip(factors, degrees, strict=True)]
    return None


def _term(factor: Factor, degrees: int) -> _Term:
    axle, column = factor
    anchors = (np.zeros(0), np.zeros(0))
    if axle.is_numeric:
        values, counts = np.unique(np.asarray(column, np.float64), return_counts=True)
        middle = np.cumsum(counts) - (counts - 1) / 2
        # From -1 for the lowest value to 1 for the highest.
        anchors = values, 2 * (middle - middle[0]) / (middle[-1] - middle[0]) - 1
    means = _columns(axle, anchors, column, degrees).mean(axis=0)
    return _Term(factor, degrees, anchors, means)


def _products(terms: Sequence[_Term], pair: tuple[int, int], spare: int) -> np.ndarray | None:
    """Products of the columns of two settings; None where too few variants are to spare."""
    for most in range(_MOST_PAIR_DEGREES, 0, -1):
        first, second = (
            terms[place].columns(
                terms[place].factor.column, most if terms[place].factor.axle.is_numeric else None
            )
            for place in pair
        )
        n_products = first.shape[1] * second.shape[1]
        if 2 * n_products < spare:
            return (first[:, :, np.newaxis] * second[:, np.newaxis, :]).reshape(-1, n_products)
    return None


# --- Least squares -------------------------------------------------------------------------------


class _Fit:
    """The sum, fitted to all variants."""

    def __init__(self, blocks: Sequence[np.ndarray], values: np.ndarray) -> None:
        """Each block is the columns of a setting, ``(variant, degree)``."""
        self._blocks = blocks
        self._values = values
        self._total = float(((values - values.mean()) ** 2).sum())
        self.matrix = np.column_stack([np.ones(values.size), *blocks])
        self.residual, self.n_terms = _squares_left(self.matrix, values)
        self._n_spare = values.size - self.n_terms

    @property
    def share(self) -> float:
        """Share of the variance that all of the sum accounts for, adjusted for its terms."""
        n = self._values.size
        return max(1 - (self.residual / self._n_spare) / (self._total / (n - 1)), 0.0)

    def share_of(self, place: int) -> Share:
        """What one setting accounts for beyond all others."""
        others = [block for k, block in enumerate(self._blocks) if k != place]
        matrix = np.column_stack([np.ones(self._values.size), *others])
        without, n_without = _squares_left(matrix, self._values)
        return self._share(without - self.residual, self.n_terms - n_without, self.residual)

    def share_beyond(self, products: np.ndarray) -> Share:
        """What further columns account for beyond the whole sum."""
        left, n_terms = _squares_left(np.column_stack([self.matrix, products]), self._values)
        return self._share(self.residual - left, n_terms - self.n_terms, left)

    def _share(self, squares: float, n_columns: int, residual: float) -> Share:
        from scipy import stats

        n_spare = self._n_spare - (n_columns if residual < self.residual else 0)
        if n_columns <= 0 or n_spare <= 0:
            return Share(0.0, 1.0)
        unit = residual / n_spare
        p = float(stats.f.sf(squares / n_columns / unit, n_columns, n_spare)) if unit else 0.0
        return Share(max((squares - n_columns * unit) / (self._total + unit), 0.0), p)


def _squares_left(matrix: np.ndarray, values: np.ndarray) -> tuple[float, int]:
    """Sum of squares that a fit leaves, and how many of its columns do not follow from others."""
    solution, _, rank, _ = np.linalg.lstsq(matrix, values, rcond=None)
    return float(((values - matrix @ solution) ** 2).sum()), int(rank)


def _corrected(shares: Sequence[Share]) -> list[Share]:
    p_values = holm([share.p for share in shares])
    return [share._replace(p=p) for share, p in zip(shares, p_values, strict=True)]


def _responses(terms: Sequence[_Term], fit: _Fit, values: np.ndarray) -> list[Response]:
    """The function of each setting, with its band."""
    solutions = _resampled(fit.matrix, values)
    fitted = np.linalg.lstsq(fit.matrix, values, rcond=None)[0]
    level = estimates.expanded_level(values.size)
    tails = [(1 - level) / 2, (1 + level) / 2]
    found: list[Response] = []
    start = 1
    for term in terms:
        shown = _shown_values(term.factor)
        columns = term.columns(shown)
        own = slice(start, start + columns.shape[1])
        mean = fitted[0] + columns @ fitted[own]
        samples = solutions[:, :1] + solutions[:, own] @ columns.T
        low, high = np.quantile(samples, tails, axis=0)
        found.append(Response(term.factor.axle, shown, mean, low, high))
        start = own.stop
    return found


def _shown_values(factor: Factor) -> Sequence[Any]:
    axle = factor.axle
    if not axle.is_numeric or len(axle.values) <= _MOST_LEVELS:
        return axle.values
    column = np.asarray(factor.column, np.float64)
    return np.quantile(column, np.linspace(0, 1, _CURVE_POINTS)).tolist()


def _resampled(matrix: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The solution for each resample of the variants, ``(resample, column) float64``."""
    n, n_columns = matrix.shape
    rng = estimates.bootstrap_rng()
    counts = rng.multinomial(n, np.full(n, 1 / n), size=estimates.RESAMPLES).astype(np.float64)
    squares = (matrix[:, :, np.newaxis] * matrix[:, np.newaxis, :]).reshape(n, -1)
    left: np.ndarray = (counts @ squares).reshape(-1, n_columns, n_columns) + _RIDGE * n * np.eye(
        n_columns
    )
    right: np.ndarray = counts @ (matrix * values[:, np.newaxis])
    return np.linalg.solve(left, right[:, :, np.newaxis])[:, :, 0]
