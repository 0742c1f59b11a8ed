"""A sine and spaced values that are the same on every machine, whatever its libraries."""

from decimal import Context, Decimal
from math import copysign, factorial, ldexp, pi

import numpy as np

SERIES = tuple((-1) ** n / factorial(2 * n + 1) for n in range(11, -1, -1))
"""Taylor coefficients of sin, highest power first; the next term is below 1e-20 up to pi/2."""
ROOTS = 1.0, 1.189207115002721, 1.4142135623730951, 1.681792830507429
"""2^(n/4), n from 0 to 3."""
_EXACT = Context(prec=40, traps=[])


def sine(turns: float) -> float:
    """Return sin(2 pi turns), within two units in the last place."""
    return sine_of_rest(turns - round(turns))


def sine_of_rest(rest: float) -> float:
    """Return sin(2 pi rest), for rest from -1/2 to 1/2."""
    if abs(rest) > 0.25:
        rest = copysign(0.5, rest) - rest
    angle = 2 * pi * rest
    square = angle * angle
    total = 0.0
    for coefficient in SERIES:
        total = total * square + coefficient
    return angle * total


def sines(turns: np.ndarray) -> np.ndarray:
    """Return `sine` of each element, the same bits."""
    rest = turns - (np.rint(turns) + 0.0)  # Python's round has no -0
    rest = np.where(abs(rest) > 0.25, np.copysign(0.5, rest) - rest, rest)
    angle = 2 * pi * rest
    square, total = angle * angle, np.zeros(rest.shape)
    for coefficient in SERIES:
        total = total * square + coefficient
    return angle * total


def quarters(n: int) -> float:
    """Return 2^(n/4)."""
    return ldexp(ROOTS[n % 4], n // 4)


def linear(start: float, stop: float, points: int) -> np.ndarray:
    """Space values, (points,), by equal differences from start to stop, both included."""
    return _rounded(np.linspace(start, stop, points).tolist())


def geometric(start: float, stop: float, points: int) -> np.ndarray:
    """Space values above 0, (points,), by equal ratios from start to stop, both included."""
    if points == 1:
        return np.array([start])
    value, ratio = Decimal(start), _EXACT.divide(Decimal(stop), Decimal(start))
    factor = _EXACT.power(ratio, _EXACT.divide(Decimal(1), Decimal(points - 1)))
    values = [value := _EXACT.multiply(value, factor) for _ in range(points - 2)]
    return _rounded([start, *values, stop])


def evenly(size: int, most: int) -> list[int]:
    """Choose at most `most` indices of `size` values, evenly, with the first and the last."""
    return np.unique(np.linspace(0, size - 1, min(size, most)).round().astype(int)).tolist()


def _rounded(values):
    """Round to 14 digits, so that the values shared by a coarse and a fine range are equal."""
    return np.array([float(f"{value:.14g}") for value in values])
