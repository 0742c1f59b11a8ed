"""Sine, evenly spaced values: the same on every machine, whatever its libraries."""

from decimal import Context, Decimal
from math import copysign, factorial, pi

import numpy as np

SERIES = tuple((-1) ** n / factorial(2 * n + 1) for n in range(11, -1, -1))
"""Coefficients of the sine, highest power first; up to a right angle the next is below 1e-20."""
_EXACT = Context(prec=40, traps=[])


def sine(turns: float) -> float:
    """sin(2 pi turns) within two units in the last place."""
    return sine_of_rest(turns - round(turns))


def sine_of_rest(rest: float) -> float:
    """sin(2 pi rest), rest from -1/2 to 1/2."""
    if abs(rest) > 0.25:
        rest = copysign(0.5, rest) - rest
    angle = 2 * pi * rest
    square = angle * angle
    total = 0.0
    for coefficient in SERIES:
        total = total * square + coefficient
    return angle * total


def linear(start: float, stop: float, points: int) -> np.ndarray:
    """Values from start to stop, both ends counted, with equal differences, (points,)."""
    return _rounded(np.linspace(start, stop, points).tolist())


def geometric(start: float, stop: float, points: int) -> np.ndarray:
    """Values above 0 from start to stop, both ends counted, with equal ratios, (points,)."""
    if points == 1:
        return np.array([start])
    value, ratio = Decimal(start), _EXACT.divide(Decimal(stop), Decimal(start))
    factor = _EXACT.power(ratio, _EXACT.divide(Decimal(1), Decimal(points - 1)))
    values = [value := _EXACT.multiply(value, factor) for _ in range(points - 2)]
    return _rounded([start, *values, stop])


def evenly(size: int, most: int) -> list[int]:
    """Indices of at most so many of `size` values, evenly chosen, the first and last among them."""
    return np.unique(np.linspace(0, size - 1, min(size, most)).round().astype(int)).tolist()


def _rounded(values):
    """Round to 14 digits: so the values that a finer range shares with a coarser are the same."""
    return np.array([float(f"{value:.14g}") for value in values])
