"""Fields over two axes between the points of these: straight along either.

A reserve is how far a requirement is met: threshold over required N, or its inverse.
"""

import numpy as np

PARTS = 16
"""Parts into which each interval between two points is cut."""
FAR = 4.0
"""Reserves above this, or below its inverse, are taken for it."""


def between(values: np.ndarray, axes: int = 2) -> np.ndarray:
    """Values between those of the last axes, (..., PARTS (n - 1) + 1); NaN beside NaN."""
    for axis in range(-axes, 0):
        last = values.shape[axis] - 1
        place = np.arange(PARTS * last + 1) / PARTS
        low = np.minimum(place.astype(int), last - 1)
        begin, end = (np.moveaxis(values, axis, -1)[..., point] for point in (low, low + 1))
        share = place - low
        # A point itself is known whatever is beside it.
        part = np.where(share == 1, end, begin + share * (end - begin))
        values = np.moveaxis(np.where(share == 0, begin, part), -1, axis)
    return values


def least_reserve(reserve: np.ndarray) -> np.ndarray:
    """The least of all requirements, (requirements, ...); NaN where it hangs on one not known."""
    least = np.fmin.reduce(reserve)
    return np.where(np.isnan(reserve).any(axis=0) & ~(least < 1), np.nan, least)


def reserves_between(reserve: np.ndarray) -> np.ndarray:
    """Reserves of requirements between points of two axes, (requirements, m, n), up to FAR."""
    return between(np.clip(reserve, 1 / FAR, FAR))
