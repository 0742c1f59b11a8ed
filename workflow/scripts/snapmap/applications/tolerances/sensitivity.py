"""Which value the threshold owes its scatter to: Sobol's indices."""

from functools import lru_cache

import numpy as np

RESAMPLES = 100
"""For the confidence intervals."""
ENDS = (0.025, 0.975)
"""Shares of the resamples below the ends of an interval at 95 %."""
FEWEST = 16
"""Samples; of fewer, nothing is said."""
DECIMALS = 6


def crossed(points: np.ndarray) -> np.ndarray:
    """The first set of points, but each draw in turn from the second: (draws, samples, draws).

    points: (2, samples, draws)
    """
    first, second = points
    return np.where(np.eye(first.shape[1], dtype=bool)[:, np.newaxis], second, first)


def indices(first: np.ndarray, second: np.ndarray, crossed: np.ndarray, seed: int) -> np.ndarray:
    """First-order and total indices with the ends of their intervals, (2, 3, draws, outputs).

    first, second: values at two sets of points, (samples, outputs); crossed: at those of `crossed`,
        (draws, samples, outputs); samples without a value in any of them are left out
    Saltelli et al. (2010); NaN where there are fewer than FEWEST samples, or nothing scatters.
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
    """How much samples count, (size, 1 + RESAMPLES): all alike first, then as often as drawn."""
    even = np.full(size, 1 / size)
    drawn = np.random.default_rng(seed).multinomial(size, even, RESAMPLES)
    return np.column_stack([even, *drawn / size])


def _both_orders(first, second, crossed, weights):
    """First-order and total indices, (2, draws, sets), by sets of weights of samples, (n, sets)."""
    mean = first.mean()
    first, second, crossed = first - mean, second - mean, crossed - mean
    apart, middle = crossed - first, (first + second) @ weights / 2
    variance = (first * first + second * second) @ weights / 2 - middle * middle
    alone = (second * apart) @ weights - middle * (apart @ weights)
    return np.array([alone, (apart * apart) @ weights / 2]) / variance
