"""Thresholds near where they are expected, on amplitudes that do not depend on that."""

import math

import numpy as np

from ..solver.cells import Rows
from ..solver.models import Follows
from ..solver.settings import Settings
from .search import asker, near

MOVES = 0.004
"""Relative distance within which another step is expected to have the same threshold."""


def nearby(
    model: Follows,
    rows: Rows,
    settings: Settings,
    expected: np.ndarray,
    tolerance: float,
    within: float = MOVES,
) -> tuple[np.ndarray, np.ndarray]:
    """Find the lowest N that snaps where it is expected, (rows,); NaN where labels are others.

    within: how far from there at least, relative
    The place below it, which does not, comes first. N stands on a lattice in relative steps of at
    most `tolerance`.
    """
    size = 2 ** (1 - math.frexp(tolerance)[1])
    known, reach = np.flatnonzero(np.isfinite(expected)), math.ceil(2 * size * within)
    first = _place(expected[known], size) - reach

    def label(which, places):
        N = _amplitude(first[which, np.newaxis] + places, size)
        return np.isfinite(asker(model, rows.take(known[which]), settings)(N))

    place = near(label, np.arange(known.size), np.full(known.size, reach), 2 * reach)
    inside = (place > 0) & (place < 2 * reach)
    place = (first + place)[inside]
    ends = np.full((2, expected.size), np.nan)
    ends[:, known[inside]] = _amplitude(place - 1, size), _amplitude(place, size)
    return ends[0], ends[1]


def _place(N, size):
    """Find the first place not below N of a lattice with `size` steps from 2^n to 2^(n + 1)."""
    share, exponent = np.frexp(N)
    return exponent * np.int64(size) + np.ceil((2 * share - 1) * size).astype(np.int64)


def _amplitude(place, size):
    exponent, steps = np.divmod(place, size)
    return np.ldexp(0.5 + steps / (2 * size), exponent.astype(np.int32))
