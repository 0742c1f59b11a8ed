"""Thresholds as surfaces: a few rows are searched, those between are verified where expected."""

import math
from collections.abc import Callable, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from ..solver.cells import Rows
from ..solver.model import Follows
from ..solver.search import asker, near
from ..solver.settings import Settings

FEWEST = 8
"""Points of an axis along which thresholds are a surface; of fewer each is searched."""
SPACING, MOST = 5, 8
"""Points from one searched row to the next, and at most so many intervals of an axis, at first."""
TERMS = 4
"""Searched rows along each axis, through which a cubic goes."""
WITHIN = 1e-3
"""How far from where it is expected, relative, a threshold may be."""
CLOSE = 1 - 0.002 * np.arange(10, 0, -1)
BELOW, ABOVE = np.array([0.7, 0.8, 0.87, 0.92, 0.95, 0.965]), np.array([1.005, 1.02, 1.05, 1.1, 1.2, 1.4, 1.9])
"""Where else labels are looked at, over the threshold expected; CLOSE, where the device rings."""


class Searched(NamedTuple):
    """What is expected from searched rows; (rows,).

    N: threshold; bar: relative; level: of the model that decided; clean: whether one may be
    expected between it and another such
    """

    N: np.ndarray
    bar: np.ndarray
    level: np.ndarray
    clean: np.ndarray


def fill(
    rows: np.ndarray,
    axes: Sequence[np.ndarray],
    search: Callable[[np.ndarray], Searched],
    verify: Callable[[np.ndarray, Searched], np.ndarray],
) -> None:
    """Search some rows of surfaces, verify those between them, and search what is not verified.

    rows: numbers, (surfaces, n_1, ..., n_d), -1 for none; axes: ascending values, (n_1,), ...
    search, verify: take numbers of rows, (n,); verify what is expected as well, and it returns of
        which rows that holds
    Which rows are searched depends on the axes and on what searched rows are: cells between them
    are halved until all corners of one are clean.
    """
    left, done = rows >= 0, np.zeros(rows.shape, bool)
    known = Searched(*(np.full(rows.shape, blank) for blank in (np.nan, np.nan, 0, False)))

    def look(which):
        done[which] = True
        for column, values in zip(known, search(rows[which]), strict=True):
            column[which] = values

    coarse, parts = None, [np.clip((x.size - 1) // SPACING, TERMS - 1, MOST) for x in axes]
    while left.any():
        places = [np.arange(n + 1) * (x.size - 1) // n for n, x in zip(parts, axes, strict=True)]
        corners, shares = _corners(np.nonzero(left), axes, places)
        needed = np.zeros(rows.shape, bool)
        for corner in corners:
            needed[corner] = True
        look(needed & (rows >= 0) & ~done)
        if coarse is None:
            coarse = _cubic(known.N, axes, places)
        clean = np.all([known.clean[corner] for corner in corners], axis=0) & ~done[left]
        which = tuple(index[clean] for index in np.nonzero(left))
        bar, level = (np.max([column[corner] for corner in corners], axis=0)[clean] for column in known[1:3])
        apart = sum(share * (known.N / coarse)[corner] for corner, share in zip(corners, shares, strict=True))
        expected = Searched(coarse[which] * apart[clean], bar, level, clean[clean])
        holds = verify(rows[which], expected)
        failed = np.zeros(rows.shape, bool)
        failed[tuple(index[~holds] for index in which)] = True
        look(failed)
        left[which] = False
        left &= ~done
        parts = [min(2 * n, x.size - 1) for n, x in zip(parts, axes, strict=True)]


def _corners(where, axes, places):
    """Indices of the searched rows around others, (2^d, d + 1, rows), and their shares, (2^d, rows)."""
    sides = []
    for index, x, at in zip(where[1:], axes, places, strict=True):
        low = at[np.searchsorted(at, index, side="right") - 1]
        high = at[np.searchsorted(at, index)]
        share = np.divide(x[index] - x[low], x[high] - x[low], out=np.zeros(index.size), where=high > low)
        sides.append(((low, 1 - share), (high, share)))
    corners, shares = [], []
    for chosen in product(*sides):
        corners.append((where[0], *(index for index, _ in chosen)))
        share = np.ones(where[0].size)
        for _, one in chosen:
            share = share * one
        shares.append(share)
    return corners, shares


def _cubic(N, axes, places):
    """Cubics through the four nearest of some places along each axis; 1 where one is missing."""
    for axis, (x, at) in enumerate(zip(axes, places, strict=True), 1):
        first = np.clip(np.searchsorted(at, np.arange(x.size), side="right") - 2, 0, at.size - TERMS)
        shape = (-1, *[1] * (N.ndim - 1 - axis))
        total = 0.0
        for j in range(TERMS):
            weight = np.ones(x.size)
            for i in range(TERMS):
                if i != j:
                    here, other = x[at[first + j]], x[at[first + i]]
                    weight *= (x - other) / (here - other)
            total = total + weight.reshape(shape) * N.take(at[first + j], axis)
        N = total
    lacks = np.isnan(N).any(axis=tuple(range(1, N.ndim)), keepdims=True)
    return np.where(lacks, 1.0, N)


def first_near(
    model: Follows, rows: Rows, settings: Settings, expected: np.ndarray, rings: np.ndarray, tolerance: float
) -> np.ndarray:
    """The lowest N that snaps, (rows,), where it is expected; NaN where labels tell otherwise.

    rings: rows that are looked at more closely
    N is one of a lattice in steps of up to `tolerance`, relative: it does not depend on what was
    expected.
    """
    ask = asker(model, rows, settings)
    size = 2 ** (1 - math.frexp(tolerance)[1])
    low, high = (_place(expected * end, size) for end in (1 - WITHIN, 1 + WITHIN))
    close = np.where(rings[:, np.newaxis], CLOSE, np.nan) * expected[:, np.newaxis]
    below, above = (np.multiply.outer(expected, ends) for ends in (BELOW, ABOVE))
    N = np.column_stack([below, close, _amplitude(low, size), _amplitude(high, size), above])
    t_snap = ask(N)
    quiet = np.isnan(t_snap[:, : -1 - ABOVE.size]).all(axis=1)
    holds = np.flatnonzero(quiet & np.isfinite(t_snap[:, -1 - ABOVE.size :]).all(axis=1))

    def snaps(numbers, places):
        some = rows.some(holds[numbers])
        return np.isfinite(asker(model, some, settings)(_amplitude(low[holds][numbers, np.newaxis] + places, size)))

    first = np.full(expected.size, np.nan)
    guess = _place(expected, size)
    bounds = np.zeros(holds.size, np.int64), (high - low)[holds]
    place = near(snaps, np.arange(holds.size), (guess - low)[holds], 2**62, *bounds)
    first[holds] = _amplitude(low[holds] + place, size)
    return first


def _place(N, size):
    """The first place not below N of a lattice with `size` even steps from 2^n to 2^(n + 1)."""
    share, exponent = np.frexp(N)
    return exponent * np.int64(size) + np.ceil((2 * share - 1) * size).astype(np.int64)


def _amplitude(place, size):
    exponent, steps = np.divmod(place, size)
    return np.ldexp(0.5 + steps / (2 * size), exponent.astype(int))
