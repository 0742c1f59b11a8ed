"""Evenly spaced values, to 14 digits: the same on every machine, and in a finer range."""

from decimal import Context, Decimal

import numpy as np

_EXACT = Context(prec=40, traps=[])


def linear(start: float, stop: float, points: int) -> np.ndarray:
    """Values from start to stop, both ends counted, with equal differences, (points,)."""
    return _rounded(np.linspace(start, stop, points).tolist())


def geometric(start: float, stop: float, points: int) -> np.ndarray:
    """Values above 0 from start to stop, both ends counted, with equal ratios, (points,)."""
    if points == 1:
        return np.array([start])
    # In decimals, as a power of floats is rounded by the processor.
    value, ratio = Decimal(start), _EXACT.divide(Decimal(stop), Decimal(start))
    factor = _EXACT.power(ratio, _EXACT.divide(Decimal(1), Decimal(points - 1)))
    values = [value := _EXACT.multiply(value, factor) for _ in range(points - 2)]
    return _rounded([start, *values, stop])


def _rounded(values):
    return np.array([float(f"{value:.14g}") for value in values])
