"""The shape of a beam as made, in units of its rise and span.

It is w0 = sum a_n phi_n / 2 with phi_n = 1 - cos(2 n pi x). A discretisation starts at the
projection of w0, by slopes, on its own shapes; w0 need not be among them.
"""

import math
from collections.abc import Sequence

import numpy as np

from ..numerics.linalg import dot
from ..numerics.portable import sine
from ..values.kinds import Number

TERMS = 5
"""Number of cosines that describe a shape."""
BISTABILITY_LIMIT = 4 / math.sqrt(3)
"""Q above which a cosine without residual stress has a second shape."""
TILT = (8.986818915818128 / (2 * math.pi)) ** 2
"""Buckling load of the first antisymmetric shape over that of the first; tan(mu/2) = mu/2."""
PANELS = 80
"""Panels on half the span for Gauss's rule, whose POINTS and WEIGHTS follow."""
_OUTER, _INNER = (math.sqrt(5 + side * 2 * math.sqrt(10 / 7)) / 3 for side in (1, -1))
POINTS = np.array([-_OUTER, -_INNER, 0.0, _INNER, _OUTER])
WEIGHTS = np.array([322 - 13 * math.sqrt(70), 322 + 13 * math.sqrt(70)])
WEIGHTS = np.array([WEIGHTS[0], WEIGHTS[1], 512.0, WEIGHTS[1], WEIGHTS[0]]) / 1800
_N = np.arange(1, TERMS + 1)
_SQUARE = 1.0 * _N * _N


def coefficients(cosines: Sequence[Number]) -> np.ndarray:
    """Return the a_n, (..., TERMS), that put the midpoint at 1; cosines: a_2 to a_5, each (...)."""
    others = np.stack(np.broadcast_arrays(*cosines), axis=-1)
    first = 1.0 - others[..., 1] - others[..., 3]
    return np.concatenate([first[..., np.newaxis], others], axis=-1)


def slope_products(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points and weights of Gauss's rule on elements, and the slopes phi_n' there.

    nodes: x of the elements' ends on half the span, (elements + 1,)
    Shapes are (elements, points), (elements, points) and (elements, points, TERMS).
    """
    panels = -(-PANELS // (nodes.size - 1))
    share = ((np.arange(panels)[:, np.newaxis] + (1 + POINTS) / 2) / panels).ravel()
    width = np.diff(nodes)[:, np.newaxis]
    x = nodes[:-1, np.newaxis] + width * share
    weights = width * np.tile(WEIGHTS / panels, panels)
    sines = [[sine(n * turn) for n in _N.tolist()] for turn in x.ravel().tolist()]
    return x, weights, 2 * np.pi * _N * np.reshape(sines, (*x.shape, TERMS))


def modes_of(Q: np.ndarray, a: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return loads n^2, s_n = a_n n and EA/2L = 3/4 Q^2 of beams, as `arch.equilibria` takes them.

    Q: rise over thickness, (beams,); a: the a_n, (beams, TERMS)
    """
    terms = max(2, 1 + np.flatnonzero(a.any(axis=0)).max())
    s = (a * _N)[:, :terms]
    return np.broadcast_to(_SQUARE[:terms], s.shape), s, 0.75 * Q * Q


def midpoint(a: np.ndarray, growth: np.ndarray) -> Number:
    """Return w(L/2) over the rise of a shape whose coordinates a have grown, both (..., terms)."""
    odd = growth[..., ::2]
    return 1 + dot(a[..., : growth.shape[-1] : 2], odd - 1)
