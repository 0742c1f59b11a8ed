"""Fields over two axes between the points of these: straight along either."""

import numpy as np

PARTS = 16
"""Of each interval between two points."""
FAR = 4.0
"""Reserves beyond are taken for this one, or one over it."""


def between(values: np.ndarray, axes: int = 2) -> np.ndarray:
    """Values between those of the last axes, (..., PARTS (n - 1) + 1); NaN beside NaN."""
    for axis in range(-axes, 0):
        last = values.shape[axis] - 1
        place = np.arange(PARTS * last + 1) / PARTS
        low = np.minimum(place.astype(int), last - 1)
        here, there = (np.moveaxis(values, axis, -1)[..., at] for at in (low, low + 1))
        share = place - low
        # A point itself is known whatever is beside it.
        part = np.where(share == 1, there, here + share * (there - here))
        values = np.moveaxis(np.where(share == 0, here, part), -1, axis)
    return values


def least_reserve(reserve: np.ndarray) -> np.ndarray:
    """The least of all requirements, (requirements, ...); NaN where it hangs on one not known."""
    least = np.fmin.reduce(reserve)
    return np.where(np.isnan(reserve).any(axis=0) & ~(least < 1), np.nan, least)


def reserves_between(reserve: np.ndarray) -> np.ndarray:
    """Reserves of requirements between points of two axes, (requirements, m, n), up to FAR."""
    return between(np.clip(reserve, 1 / FAR, FAR))
