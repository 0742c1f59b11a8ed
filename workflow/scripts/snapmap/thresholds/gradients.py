"""How thresholds change with a value of the device: from those along its axis, with errors."""

from collections.abc import Mapping

import numpy as np

from ..axes import COORDINATES, NAMES

FEWEST, TERMS = 3, 4
"""Points through which a parabola goes, and a cubic."""


def gradients(
    axes: Mapping[str, np.ndarray], N: np.ndarray, bars: np.ndarray, tolerance: float
) -> dict[str, tuple]:
    """Derivatives of N along axes of three points and more, but f0 and names, with their errors.

    axes: by name, internal units
    N, bars: of the axes' shape; NaN where there is no clean threshold
    tolerance: of the refinement in N, relative
    Returns `dN_d<value>` and `dN_d<value>_error`, per internal unit: dimensions, values, attributes
    """
    data = {}
    for place, (key, x) in enumerate(axes.items()):
        if key in (*NAMES, "f0") or x.size < FEWEST:
            continue
        order, about = np.argsort(x), COORDINATES[key]
        # A degree on its own scale has no inverse.
        unit = {"1": "1", "degC": "K-1"}.get(about["units"], f"({about['units']})-1")
        words = f"derivative of N_first in the {about['long_name']}"
        parts = slopes(x[order], *(np.moveaxis(a, place, 0)[order] for a in (N, bars)), tolerance)
        for of, name, part in zip(("", "error of the "), ("", "_error"), parts, strict=True):
            values = np.moveaxis(part[np.argsort(order)], 0, place)
            attributes = {"long_name": of + words, "units": unit}
            data[f"dN_d{key}{name}"] = tuple(axes), values, attributes
    return data


def slopes(
    x: np.ndarray, N: np.ndarray, bars: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """dN/dx and its error, (n, ...), of N with bars, (n, ...), at ascending x, (n,).

    By the cubic through the four nearest points (of three, the parabola), of all or of every
    second, fourth and so on, where that leaves less open; NaN where one of the nearest of all is.
    The error is what bars leave open, and how far the polynomial without the nearest other point
    differs, there or at the next points.
    """
    number, relative, stride = np.arange(x.size), bars / N, 1
    while stride == 1 or x.size // stride >= TERMS:
        apart = abs(np.subtract.outer(x, x))
        apart[np.subtract.outer(number, number) % stride > 0] = np.inf
        near = np.argsort(apart, axis=1, kind="stable")[:, :TERMS]
        found = _slope(x, N, near)
        rough = abs(found - _slope(x, N, np.delete(near, 1, axis=1)))
        beside = (rough[np.clip(number + step, 0, x.size - 1)] for step in (-stride, stride))
        # ASSUME: what bars of neighbours have in common is one relative error of all; the rest, and
        # the tolerance, are independent.
        common = relative[near].min(axis=1)
        own = N * (relative + tolerance)
        squares = sum((w * (own[at] - common * N[at])) ** 2 for w, at in _terms(x, near, N.ndim))
        left_open = np.fmax(np.fmax(*beside), rough) + common * abs(found) + np.sqrt(squares)
        if stride == 1:
            slope, error = found, left_open
        better = left_open < error
        slope, error = np.where(better, found, slope), np.where(better, left_open, error)
        stride *= 2
    return slope, error


def _slope(x, N, near):
    """The derivative of the polynomial through the points `near`, (n, terms), at the first."""
    return sum(weight * N[at] for weight, at in _terms(x, near, N.ndim))


def _terms(x, near, ndim):
    """Weights of N in it, (n, 1, ...) of so many dimensions, and of which points, (n,)."""
    away = (x[near] - x[near[:, :1]]).T.reshape(near.shape[1], -1, *[1] * (ndim - 1))
    own, others = 0.0, range(1, len(away))
    for j in others:
        weight = 1 / away[j]
        for i in others:
            weight = weight * (away[i] / (away[i] - away[j]) if i != j else 1.0)
        own = own - weight
        yield weight, near[:, j]
    yield own, near[:, 0]
