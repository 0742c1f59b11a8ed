"""The shape in which a beam is made, and what it leaves of a second stable one.

With rise and span 1 a shape is w0 = sum a_n phi_n / 2, phi_n = 1 - cos(2 n pi x): its projection
on what clamps allow, by the slopes; w0 itself need not meet them. Under the axial force r, in
units of the first buckling load, the beam is at rest where each term is a_n n^2 / (n^2 - r), and

    r = compression + 3/4 Q^2 sum a_n^2 n^2 (1 - (n^2 / (n^2 - r))^2).
"""

import math
from collections.abc import Sequence
from functools import cache

import numpy as np

from .numerics.linalg import dot, multiply
from .numerics.portable import sine

TERMS = 40
"""Cosines in which a shape is held: second shapes of arcs are then right to 2e-5 (at Q = 5)."""
COSINE, ARC, PARABOLA = SHAPES = "cosine", "arc", "parabola"
BISTABILITY_LIMIT = 4 / math.sqrt(3)
"""Q of a cosine without stress above which there is a second shape."""
SECOND = 4.0
"""Buckling load of the second symmetric shape over the first's: there state 2 is no longer stable.
"""
TILT = (8.986818915818128 / (2 * math.pi)) ** 2
"""Likewise of the first antisymmetric shape; tan(mu/2) = mu/2."""
MOST_BISTABILITY = 1e3
"""Above the limit of any shape that has one."""
NEWTON_STEPS, BISECTIONS = 100, 60
PANELS = 80
"""On half the span, of Gauss's rule with the points and weights below."""
_OUTER, _INNER = (math.sqrt(5 + side * 2 * math.sqrt(10 / 7)) / 3 for side in (1, -1))
POINTS = np.array([-_OUTER, -_INNER, 0.0, _INNER, _OUTER])
WEIGHTS = np.array([322 - 13 * math.sqrt(70), 322 + 13 * math.sqrt(70)])
WEIGHTS = np.array([WEIGHTS[0], WEIGHTS[1], 512.0, WEIGHTS[1], WEIGHTS[0]]) / 1800
_N = np.arange(1, TERMS + 1)
_SQUARE = 1.0 * _N * _N

Value = float | np.ndarray


def coefficients(shape: str | np.ndarray, steepness: Value, cosines: Sequence[Value]) -> np.ndarray:
    """The a_n of beams, (..., TERMS); the midpoint stays at 1, whatever the cosines add.

    shape: of SHAPES; steepness: rise over span; cosines: a_2, a_3, ... that are added
    """
    shape, steepness, *cosines = np.broadcast_arrays(shape, steepness, *cosines)
    # Parabola: 8 / (pi n)^2, from 4 x (1 - x).
    found = np.broadcast_to(8 / (np.pi * np.pi * _SQUARE), (*shape.shape, TERMS)).copy()
    found[shape == COSINE] = _N == 1
    arcs = shape == ARC
    if arcs.any():
        found[arcs] = _arc(np.asarray(steepness)[arcs])
    for n, added in enumerate(cosines, start=2):
        found[..., n - 1] += added
        if n % 2:
            found[..., 0] -= added
    return found


def slope_products(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points and weights of a rule on elements between nodes, and phi_n' there.

    nodes: of half the span, (elements + 1,)
    Returns (elements, points), (elements, points) and (elements, points, TERMS).
    """
    panels = -(-PANELS // (nodes.size - 1))
    share = ((np.arange(panels)[:, np.newaxis] + (1 + POINTS) / 2) / panels).ravel()
    width = np.diff(nodes)[:, np.newaxis]
    x = nodes[:-1, np.newaxis] + width * share
    weights = width * np.tile(WEIGHTS / panels, panels)
    sines = [[sine(n * one) for n in _N.tolist()] for one in x.ravel().tolist()]
    return x, weights, 2 * np.pi * _N * np.reshape(sines, (*x.shape, TERMS))


@cache
def _rule():
    x, weights, slopes = slope_products(np.array([0.0, 0.5]))
    return x[0], weights[0], slopes[0]


def _arc(steepness):
    """Of the circle through clamps and midpoint: w0' = -y / sqrt(R^2 - y^2), y = x - 1/2."""
    x, weights, slopes = _rule()
    radius = (0.25 + steepness * steepness) / (2 * steepness)
    y = 0.5 - x
    slope = y / np.sqrt(radius[:, np.newaxis] ** 2 - y * y) / steepness[:, np.newaxis]
    # Twice the half; phi_n' phi_n' integrates to 2 pi^2 n^2, and a_n counts phi_n / 2.
    return 2 * multiply(slope * weights, slopes) / (np.pi * np.pi * _SQUARE)


def midpoint(a: np.ndarray, r: Value) -> Value:
    """w(L/2) under the axial force r, over the rise."""
    share = _SQUARE / (_SQUARE - np.asarray(r)[..., np.newaxis])
    return 1 + dot(a[..., ::2], share[..., ::2] - 1)


def first_force(Q: Value, compression: Value, a: np.ndarray) -> Value:
    """The axial force in the first stable shape: the root below 1."""
    whole = 1 + abs(compression) + np.square(Q) * dot(a * a, _SQUARE)
    return _root(lambda r: _excess(Q, compression, a, r), -whole, 1.0)


def second_force(Q: Value, compression: Value, a: np.ndarray) -> Value:
    """The axial force in the second stable shape: the lower root above 1; one that must exist."""
    # There the excess grows with r.
    return _root(lambda r: -_excess(Q, compression, a, r), 1.0, _steepest(Q, a))


def least_compression(Q: Value, a: np.ndarray) -> Value:
    """Residual compression, over that of buckling, down to which there is a second stable shape."""
    return -_excess(Q, 0.0, a, _steepest(Q, a))


def least_bistability(a: np.ndarray) -> Value:
    """Q above which there is a second stable shape without stress."""
    return _root(lambda Q: least_compression(Q, a), 0.0, np.full(a.shape[:-1], MOST_BISTABILITY))


def least_compression_of_cosine(Q: Value) -> Value:
    """The same of a beam made as a cosine.

    It ends at c = w(L/2)/rise where the axial force 1 - 1/c reaches SECOND, or where the equilibria
    of `cosine_at_rest` meet, d/dc = 0, if that comes first.
    """
    arch = 0.75 * np.square(Q)
    fold = -1 / np.cbrt(2 * arch)
    c = np.minimum(fold, 1 / (1 - SECOND))
    return 1 - 1 / c - arch * (1 - c * c)


def cosine_at_rest(Q: Value, compression: Value, side: int) -> Value:
    """Outermost c = w(L/2)/rise on one side, 1 or -1, at which a cosine is at rest.

    compression + (3/4) Q^2 (1 - c^2) = 1 - 1/c, a cubic in c. By Newton's method from beyond the
    root, as far as it comes nearer.
    """
    arch = 0.75 * np.square(np.asarray(Q, float))
    linear, rest = (np.asarray(compression, float) + arch - 1) / arch, side / arch
    c = 1 + np.sqrt(np.maximum(linear, 0)) + 1 / arch
    for _ in range(NEWTON_STEPS):
        nearer = c - (c * (c * c - linear) - rest) / (3 * c * c - linear)
        if not (nearer < c).any():
            break
        c = np.minimum(nearer, c)
    return side * c


def _excess(Q, compression, a, r):
    """Of the force that the stretch gives, over r; above 1 concave, from and to minus infinity."""
    r = np.asarray(r)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = _SQUARE / (_SQUARE - r[..., np.newaxis])
        parts = np.where(a == 0, 0.0, a * a * _SQUARE * (1 - share * share))
    return compression + 0.75 * np.square(Q) * dot(parts, np.ones(TERMS)) - r


def _steepest(Q, a):
    """Where the excess is largest from 1 to SECOND."""

    def falls(r):
        share = _SQUARE / (_SQUARE - r[..., np.newaxis])
        return -1 - 1.5 * np.square(Q) * dot(a * a, share * share * share)

    return _root(falls, 1.0, SECOND)


def _root(falling, low, high):
    """Where a falling function changes sign, by bisection; an end if it does not between them."""
    low, high = np.broadcast_arrays(low, high)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        with np.errstate(divide="ignore", invalid="ignore"):
            above = falling(middle) > 0
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return (low + high) / 2
