"""Bilinear interpolation of fields over two axes.

The reserve of a requirement is the threshold over the required N, or the inverse; above 1 the
requirement is met.
"""

import numpy as np

PARTS = 16
"""Number of parts of each interval between two points."""
FAR = 4.0
"""Reserves are clipped to this and its inverse."""


def between(values: np.ndarray, axes: int = 2) -> np.ndarray:
    """Interpolate along each of the last axes, n points to PARTS (n - 1) + 1; NaN beside NaN."""
    for axis in range(-axes, 0):
        last = values.shape[axis] - 1
        place = np.arange(PARTS * last + 1) / PARTS
        low = np.minimum(place.astype(int), last - 1)
        begin, end = (np.moveaxis(values, axis, -1)[..., point] for point in (low, low + 1))
        share = place - low
        # A point keeps its value even beside NaN.
        part = np.where(share == 1, end, begin + share * (end - begin))
        values = np.moveaxis(np.where(share == 0, begin, part), -1, axis)
    return values


def least_reserve(reserve: np.ndarray) -> np.ndarray:
    """Find the least reserve of all requirements; NaN where it depends on an unknown one.

    reserve: (requirements, ...)
    """
    least = np.fmin.reduce(reserve)
    return np.where(np.isnan(reserve).any(axis=0) & ~(least < 1), np.nan, least)


def reserves_between(reserve: np.ndarray) -> np.ndarray:
    """Interpolate reserves of requirements over two axes, (requirements, m, n), clipped to FAR."""
    return between(np.clip(reserve, 1 / FAR, FAR))
