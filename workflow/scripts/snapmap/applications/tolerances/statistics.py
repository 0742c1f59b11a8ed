"""Counts, quantiles and moments over the first axis, the samples; the same on every machine."""

import math

import numpy as np

from ...numerics.statistics import CONFIDENCE


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
