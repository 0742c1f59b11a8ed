"""Shares with their bounds, quantiles and moments, over samples in front; the same everywhere."""

import math

import numpy as np

DEVIATIONS = 1.959963984540054
"""Standard deviations about the mean within which 95 % of a normal distribution lie."""


def percents(*shares: float) -> str:
    """A share in per cent, or from the lowest of some to the highest: once if both read alike."""
    ends = dict.fromkeys(f"{100 * float(end):.1f}" for end in (min(shares), max(shares)))
    return f"{' to '.join(ends)} %"


def scope(share) -> str:
    """Say at which temperatures a yield counts, and what it leaves out, by its attributes.

    share: a DataArray of yields, as in the dataset of tolerances
    """
    words = {"temperatures": "at", "leaves_out": "without"}
    return "".join(
        f", {word} {share.attrs[key]}" for key, word in words.items() if key in share.attrs
    )


def wilson(count: np.ndarray, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Bounds at 95 % of the share that `count` of so many samples stand for (Wilson, 1927)."""
    z2 = DEVIATIONS * DEVIATIONS
    share = np.asarray(count) / samples
    middle = (share + z2 / (2 * samples)) / (1 + z2 / samples)
    spread = share * (1 - share) / samples + z2 / (4 * samples * samples)
    half = DEVIATIONS * np.sqrt(spread) / (1 + z2 / samples)
    return np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)


def count_below(N_first: np.ndarray, N: np.ndarray) -> np.ndarray:
    """How many of the samples, (samples, ...), are not above each N; (..., N). NaN is above all."""
    ordered = np.moveaxis(np.sort(N_first, axis=0), 0, -1)
    counts = [np.searchsorted(row, N, side="right") for row in ordered.reshape(-1, len(N_first))]
    return np.reshape(counts, (*N_first.shape[1:], len(N)))


def quantiles(N_first: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """N at which so large a share of the samples snaps, (shares, ...); NaN where it is less."""
    ordered = np.sort(N_first, axis=0)
    places = np.ceil(np.asarray(shares) * len(N_first) - 1e-9).astype(int) - 1
    return ordered[np.maximum(places, 0)]


def quantile_bounds(N_first: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Lower and upper bounds of `quantiles`, (2, shares, ...), each alone at 95 %.

    By order statistics, whatever the distribution; NaN where there are too few samples for one.
    """
    from scipy.stats import binom  # half a second, for which no config that is read has to wait

    size, shares = len(N_first), np.asarray(shares)
    least, most = binom.ppf([[0.05], [0.95]], size, shares).astype(int)
    ordered = np.sort(N_first, axis=0)
    ordered = np.concatenate([np.full_like(ordered[:1], np.nan), ordered, ordered[:1] * np.nan])
    return ordered[[least, most + 1]]


def moments(N_first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard deviation of what is not NaN among the samples, (...)."""
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
