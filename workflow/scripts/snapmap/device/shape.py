"""The shape in which a beam is made.

With rise and span 1 a shape is w0 = sum a_n phi_n / 2, phi_n = 1 - cos(2 n pi x): its projection
on what clamps allow, by the slopes; w0 itself need not meet them.
"""

import math
from collections.abc import Sequence

import numpy as np

from ..numerics.linalg import dot
from ..numerics.portable import sine

TERMS = 5
"""Cosines in which a shape is held."""
BISTABILITY_LIMIT = 4 / math.sqrt(3)
"""Q of a cosine without stress above which there is a second shape."""
TILT = (8.986818915818128 / (2 * math.pi)) ** 2
"""Buckling load of the first antisymmetric shape over that of the first; tan(mu/2) = mu/2."""
PANELS = 80
"""Panels on half the span, each of Gauss's rule with the points and weights below."""
_OUTER, _INNER = (math.sqrt(5 + side * 2 * math.sqrt(10 / 7)) / 3 for side in (1, -1))
POINTS = np.array([-_OUTER, -_INNER, 0.0, _INNER, _OUTER])
WEIGHTS = np.array([322 - 13 * math.sqrt(70), 322 + 13 * math.sqrt(70)])
WEIGHTS = np.array([WEIGHTS[0], WEIGHTS[1], 512.0, WEIGHTS[1], WEIGHTS[0]]) / 1800
_N = np.arange(1, TERMS + 1)
_SQUARE = 1.0 * _N * _N

Value = float | np.ndarray


def coefficients(cosines: Sequence[Value]) -> np.ndarray:
    """The a_n of beams, (..., TERMS), the midpoint at 1; cosines: a_2, a_3, ..., (TERMS - 1,)."""
    others = np.stack(np.broadcast_arrays(*cosines), axis=-1)
    first = 1.0 - others[..., 1] - others[..., 3]
    return np.concatenate([first[..., np.newaxis], others], axis=-1)


def slope_products(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Give points and weights of Gauss's rule on elements between nodes, and phi_n' there.

    nodes: of half the span, (elements + 1,)
    Returns (elements, points), (elements, points) and (elements, points, TERMS).
    """
    panels = -(-PANELS // (nodes.size - 1))
    share = ((np.arange(panels)[:, np.newaxis] + (1 + POINTS) / 2) / panels).ravel()
    width = np.diff(nodes)[:, np.newaxis]
    x = nodes[:-1, np.newaxis] + width * share
    weights = width * np.tile(WEIGHTS / panels, panels)
    sines = [[sine(n * turn) for n in _N.tolist()] for turn in x.ravel().tolist()]
    return x, weights, 2 * np.pi * _N * np.reshape(sines, (*x.shape, TERMS))


def modes_of(Q: np.ndarray, a: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Loads n^2, s_n = a_n n and EA/2L = 3/4 Q^2, as `arch` takes them.

    Q: rise over thickness, (n,); a: the a_n, (n, TERMS)
    """
    terms = max(2, 1 + np.flatnonzero(a.any(axis=0)).max())
    s = (a * _N)[:, :terms]
    return np.broadcast_to(_SQUARE[:terms], s.shape), s, 0.75 * Q * Q


def midpoint(a: np.ndarray, growth: np.ndarray) -> Value:
    """w(L/2) over the rise of a shape whose coordinates grow so; both (..., terms)."""
    odd = growth[..., ::2]
    return 1 + dot(a[..., : growth.shape[-1] : 2], odd - 1)
