"""Sobol's indices: shares of the variance of thresholds that values cause."""

import math
from functools import lru_cache

import numpy as np

from ...numerics.statistics import CONFIDENCE

RESAMPLES = 100
"""Number of bootstrap resamples for the confidence intervals."""
ENDS = (0.025, 0.975)
"""Quantiles of the resamples at the ends of an interval at 95 %."""
FEWEST = 16
"""Least number of samples for indices."""
DECIMALS = 6


def crossed(points: np.ndarray) -> np.ndarray:
    """Return copies of the first set of points, each with another draw from the second set.

    points: (2, samples, draws); returns (draws, samples, draws)
    """
    first, second = points
    return np.where(np.eye(first.shape[1], dtype=bool)[:, np.newaxis], second, first)


def indices(first: np.ndarray, second: np.ndarray, crossed: np.ndarray, seed: int) -> np.ndarray:
    """Estimate first-order and total indices by Saltelli et al. (2010), (2, 3, draws, outputs).

    first, second: values at two sets of points, (samples, outputs)
    crossed: values at the points of `crossed`, (draws, samples, outputs)
    The second axis holds an index and the ends of its interval. Samples with a NaN are left out.
    The indices are NaN with fewer than FEWEST samples, or if nothing scatters.
    """
    draws, _, outputs = crossed.shape
    result = np.full((2, 3, draws, outputs), np.nan)
    known = np.isfinite(first) & np.isfinite(second) & np.isfinite(crossed).all(axis=0)
    for i in range(outputs):
        places = np.flatnonzero(known[:, i])
        if places.size < FEWEST or np.ptp(first[places, i]) == 0:
            continue
        if draws == 1:
            result[..., i] = 1.0
            continue
        weights = _weights(places.size, seed)
        sets = _both_orders(first[places, i], second[places, i], crossed[:, places, i], weights)
        result[:, 0, :, i] = sets[..., 0]
        result[:, 1:, :, i] = np.moveaxis(np.quantile(sets[..., 1:], ENDS, axis=-1), 0, 1)
    return np.round(result, DECIMALS)


@lru_cache(maxsize=1)
def _weights(size, seed):
    """Weights of samples, (size, 1 + RESAMPLES): equal ones, then those of each resample."""
    even = np.full(size, 1 / size)
    drawn = np.random.default_rng(seed).multinomial(size, even, RESAMPLES)
    return np.column_stack([even, *drawn / size])


def _both_orders(first, second, crossed, weights):
    """First-order and total indices, (2, draws, sets), for weights of n samples, (n, sets)."""
    mean = first.mean()
    first, second, crossed = first - mean, second - mean, crossed - mean
    apart, middle = crossed - first, (first + second) @ weights / 2
    variance = (first * first + second * second) @ weights / 2 - middle * middle
    alone = (second * apart) @ weights - middle * (apart @ weights)
    return np.array([alone, (apart * apart) @ weights / 2]) / variance


def count_below(N_first: np.ndarray, N: np.ndarray) -> np.ndarray:
    """Count the samples, (samples, ...), that are not above each N, (..., N); NaN is above all."""
    ordered = np.moveaxis(np.sort(N_first, axis=0), 0, -1)
    counts = [np.searchsorted(row, N, side="right") for row in ordered.reshape(-1, len(N_first))]
    return np.reshape(counts, (*N_first.shape[1:], len(N)))


def quantiles(N_first: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Find the N at which each share of the samples snaps, (shares, ...); NaN if fewer do."""
    ordered = np.sort(N_first, axis=0)
    places = np.ceil(np.asarray(shares) * len(N_first) - 1e-9).astype(int) - 1
    return ordered[np.maximum(places, 0)]


def quantile_bounds(
    N_first: np.ndarray, shares: np.ndarray, confidence: float = CONFIDENCE
) -> np.ndarray:
    """Bound `quantiles` from below and above, (2, shares, ...), each alone at a confidence.

    Order statistics give bounds for any distribution; NaN if there are too few samples.
    """
    from scipy.stats import binom  # half a second, for which no config that is read has to wait

    size, shares = len(N_first), np.asarray(shares)
    least, most = binom.ppf([[1 - confidence], [confidence]], size, shares).astype(int)
    ordered = np.sort(N_first, axis=0)
    ordered = np.concatenate([np.full_like(ordered[:1], np.nan), ordered, ordered[:1] * np.nan])
    return ordered[[least, most + 1]]


def moments(N_first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and standard deviation of the samples that are not NaN, (...)."""
    mean, std = np.full((2, *N_first.shape[1:]), np.nan)
    for place in np.ndindex(mean.shape):
        values = N_first[(slice(None), *place)]
        values = values[np.isfinite(values)]
        if values.size:
            mean[place] = math.fsum(values) / values.size
        if values.size > 1:
            squares = math.fsum((values - mean[place]) ** 2)
            std[place] = math.sqrt(squares / (values.size - 1))
    return mean, std
