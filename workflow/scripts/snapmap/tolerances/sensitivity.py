"""Which value the threshold owes its scatter to: Sobol's indices."""

import numpy as np
from scipy.stats import bootstrap, sobol_indices

RESAMPLES = 100
"""For the confidence intervals."""
CONFIDENCE = 0.95
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
        # The library asks for a power of 2.
        places = places[: 1 << max(places.size.bit_length() - 1, 0)]
        if places.size < FEWEST or np.ptp(first[places, i]) == 0:
            continue
        if draws == 1:
            result[..., i] = 1.0
            continue
        values = first[places, i], second[places, i], crossed[:, places, i]
        result[:, 0, :, i] = _both_orders(*values)
        # The library's own bootstrap draws without a seed.
        interval = bootstrap(
            [np.arange(places.size)],
            lambda which, values=values: _both_orders(*(part[..., which] for part in values)),
            n_resamples=RESAMPLES,
            vectorized=False,
            confidence_level=CONFIDENCE,
            method="percentile",
            rng=np.random.default_rng(seed),
        ).confidence_interval
        result[:, 1, :, i], result[:, 2, :, i] = interval
    return np.round(result, DECIMALS)


def _both_orders(first, second, crossed):
    """First-order and total indices of one output, (2, draws)."""
    values = {"f_A": first[np.newaxis], "f_B": second[np.newaxis], "f_AB": crossed[:, np.newaxis]}
    of_order = sobol_indices(func=values, n=first.size)
    return np.array([of_order.first_order, of_order.total_order])
