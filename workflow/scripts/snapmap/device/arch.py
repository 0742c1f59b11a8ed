"""Equilibria of an arch: two stable shapes and the saddle between them, by one stretch equation.

Let v_j be the buckling modes (kappa v_j = N_j S v_j, v_j.S v_j = 1) and s_j = v_j.S q0 the
coordinates of the shape as made. Under the axial force N the beam is at rest where its coordinates
are s_j N_j / (N_j - N). The stretch of this shape must produce N itself,

    h(N) = N - N0 - axial sum s_j^2 (1 - (N_j / (N_j - N))^2) = 0,

with the residual compression N0 and axial = EA/2L. h is convex between the loads N_j. Its root
below N_1 is the first shape; of the roots between N_1 and N_2 the lower is the second shape and the
higher the saddle. If s_2 = 0, the second coordinate is free at N = N_2, which is the saddle if
there is no root below. To keep all digits the unknown is the distance d from a load, N = N_p (1 -
d); Newton's method starts close to that load, where h > 0, and never oversteps.
"""

from typing import NamedTuple

import numpy as np

from ..numerics.linalg import dot

NEWTON_STEPS, BISECTIONS = 200, 60
"""Most steps of Newton's method to a root; steps of bisection to the minimum of h."""
FAR = 1e6
"""Second load over the first for a beam of a single mode: it never gets there."""


class Equilibria(NamedTuple):
    """Equilibria of arches, (n, modes); without a second shape, it and the saddle are NaN.

    first, second: growth N_j / (N_j - N) of the coordinates s_j in the two stable shapes
    saddle: coordinates of the lowest saddle between them, in the units of s
    N_first, N_second: axial force in the two shapes, (n,), in the units of the loads
    """

    first: np.ndarray
    second: np.ndarray
    saddle: np.ndarray
    N_first: np.ndarray
    N_second: np.ndarray


def equilibria(
    loads: np.ndarray, s: np.ndarray, axial: np.ndarray, residual: np.ndarray
) -> Equilibria:
    """Find the equilibria of arches, in any consistent units.

    loads: N_j, ascending, (n, modes); s: s_j, (n, modes); axial: EA/2L, (n,); residual: N0, (n,)
    """
    modes = loads.shape[1]
    if modes == 1:
        # A single mode has its own saddle, wherever a second load would be.
        loads, s = np.append(loads, FAR * loads, axis=1), np.append(s, 0 * s, axis=1)
    arch = loads, s, axial, residual
    apart = loads[:, 1] / loads[:, 0]
    first = _root(*arch, 0, 1, np.full(apart.shape, np.inf))
    second = -_root(*arch, 0, -1, apart - 1)
    saddle = _root(*arch, 1, 1, 1 - 1 / apart)
    free = np.sqrt(np.maximum(-_stretch(*arch, 1, saddle)[0], 0) / axial)
    with np.errstate(invalid="ignore"):
        q = s * _growth(loads, 1, saddle)
    q[:, 1] = np.where(saddle == 0, free, q[:, 1])
    second = np.where(np.isnan(saddle), np.nan, second)
    q[np.isnan(second)] = np.nan
    return Equilibria(
        first=_growth(loads, 0, first)[:, :modes],
        second=_growth(loads, 0, second)[:, :modes],
        saddle=q[:, :modes],
        N_first=loads[:, 0] * (1 - first),
        N_second=loads[:, 0] * (1 - second),
    )


def least_residual(loads: np.ndarray, s: np.ndarray, axial: np.ndarray) -> np.ndarray:
    """Return the N0 above which there is a second shape, (n,): the minimum of h + N0."""
    low, high = np.zeros(axial.shape), 1 - loads[:, 0] / loads[:, 1]
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        falls = _stretch(loads, s, axial, 0.0, 1, middle)[1] < 0
        low, high = np.where(falls, middle, low), np.where(falls, high, middle)
    return _stretch(loads, s, axial, 0.0, 1, low)[0]


def _growth(loads, p, d):
    """Return N_j / (N_j - N) at N = N_p (1 - d), (n, modes)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        growth = loads / (loads - (loads[:, p] * (1 - d))[:, np.newaxis])
        growth[:, p] = 1 / d
    return growth


def _stretch(loads, s, axial, residual, p, d):
    """Return h at N = N_p (1 - d), and its derivative by d, both (n,)."""
    growth, ones = _growth(loads, p, d), np.ones_like(s)
    with np.errstate(invalid="ignore", over="ignore"):
        give = np.where(s == 0, 0.0, s * s * (1 - growth * growth))
        steep = np.where(s == 0, 0.0, s * s * growth * growth * growth / loads)
    N = loads[:, p] * (1 - d)
    slope = -loads[:, p] * (1 + 2 * axial * dot(steep, ones))
    return N - residual - axial * dot(give, ones), slope


def _root(loads, s, axial, residual, p, side, limit):
    """Find the |d| of the root next to load p, (n,); NaN if there is none below `limit`.

    side: sign of d, 1 for a root N < N_p, -1 for N > N_p
    """
    square = axial * s[:, p] * s[:, p]
    most = abs(residual) + axial * dot(s, s)
    d, left = np.sqrt(square / (square + most)), np.arange(len(s))
    for _ in range(NEWTON_STEPS):
        arch = loads[left], s[left], axial[left], residual[left]
        h, slope = _stretch(*arch, p, side * d[left])
        with np.errstate(divide="ignore", invalid="ignore"):
            step = np.where(h > 0, np.where(side * slope < 0, -side * h / slope, np.inf), 0.0)
        nearer = d[left] + step
        moves = nearer > d[left]
        d[left] = np.where(nearer < limit[left], nearer, np.nan)
        left = left[moves & (nearer < limit[left])]
        if not left.size:
            break
    return d
