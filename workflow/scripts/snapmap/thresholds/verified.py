"""Thresholds as surfaces: a few rows are searched, the others verified where those expect them."""

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from ..solver.cells import Rows
from ..solver.models import Follows
from ..solver.settings import Settings
from ..study.axes import NAMES
from .search import asker

FEWEST = 8
"""Points of an axis from which on thresholds along it are a surface."""
SPACING, MOST = 5, 8
"""Points between two searched rows along an axis, and most such intervals, at first."""
TERMS = 4
"""Searched rows along an axis through which a cubic goes."""
WITHIN = 1e-3
"""How far from where it is expected a threshold may lie, relative, and at least its tolerance."""
BELOW, ABOVE = (0.7, 0.8, 0.87, 0.92, 0.95, 0.965), (1.005, 1.02, 1.05, 1.1, 1.2, 1.4, 1.9)
"""Where else labels must be those expected, over the threshold."""


class Expected(NamedTuple):
    """What searched rows are, or others between them are expected to be; (rows,).

    N: threshold; bar: of it, relative; level: of the models that decides
    clean: whether the threshold is one around which others may be expected
    """

    N: np.ndarray
    bar: np.ndarray
    level: np.ndarray
    clean: np.ndarray


def surfaces(
    axes: Mapping[str, np.ndarray], rows: np.ndarray, slow: np.ndarray
) -> list[tuple[np.ndarray, list[np.ndarray]]]:
    """Take a grid apart into surfaces, by the values of its axes alone.

    axes: by name; rows: numbers, of the axes' shape; slow: of f0, where rows are smooth along it
    Returns rows, (surfaces, n_1, ..., n_d), and d ascending axes, for slow pulses and others.
    """
    apart = []
    for is_slow in (True, False):
        part, kept = rows, {}
        for place, (key, values) in enumerate(axes.items()):
            if key in NAMES:
                continue
            order = np.argsort(values)
            if key == "f0":
                order = order[slow[order] == is_slow]
            part = part.take(order, place)
            if order.size >= FEWEST and (is_slow or key != "f0"):
                kept[place] = values[order]
        if kept and part.size:
            part = np.moveaxis(part, list(kept), range(-len(kept), 0))
            sizes = (values.size for values in kept.values())
            apart.append((part.reshape(-1, *sizes), list(kept.values())))
    return apart


def fill(
    rows: np.ndarray,
    axes: Sequence[np.ndarray],
    search: Callable[[np.ndarray], Expected],
    verify: Callable[[np.ndarray, Expected], np.ndarray],
) -> None:
    """Search some rows of surfaces, verify those between, and search what is not verified.

    rows: numbers, (surfaces, n_1, ..., n_d), -1 for none; axes: ascending values, (n_1,), ...
    search, verify: of numbers of rows, (n,); verify is given what is expected there, too, and
        returns where that holds
    Which rows are searched depends on the axes, and on what searched ones are: intervals are halved
    until all rows at the corners of one are clean, or verified, and what lies between holds.
    """
    left, done = rows >= 0, np.zeros(rows.shape, bool)
    known = Expected(*(np.full(rows.shape, blank) for blank in (np.nan, np.nan, 0, False)))

    def look(which):
        keep(which, search(rows[which]))

    def keep(which, values):
        done[which] = True
        for column, value in zip(known, values, strict=True):
            column[which] = value

    cubic, halvings = None, 0
    while left.any():
        places = [_places(x, halvings) for x in axes]
        corners, _ = _corners(np.nonzero(left), axes, places)
        needed = np.zeros(rows.shape, bool)
        for corner in corners:
            needed[corner] = True
        look(needed & (rows >= 0) & ~done)
        if cubic is None:
            cubic = _cubic(known.N, axes, places)
        left &= ~done
        corners, shares = _corners(np.nonzero(left), axes, places)
        clean = np.all([known.clean[corner] for corner in corners], axis=0)
        which = tuple(index[clean] for index in np.nonzero(left))
        corners = [tuple(index[clean] for index in corner) for corner in corners]
        apart = sum(
            share[clean] * (known.N[corner] / cubic[corner])
            for share, corner in zip(shares, corners, strict=True)
        )
        bar, level = (
            np.max([column[corner] for corner in corners], axis=0)
            for column in (known.bar, known.level)
        )
        expected = Expected(cubic[which] * apart, bar, level, clean[clean])
        holds = verify(rows[which], expected)
        keep(
            tuple(index[holds] for index in which),
            Expected(*(values[holds] for values in expected)),
        )
        left &= ~done
        halvings += 1


def at_first(rows: np.ndarray, axes: Sequence[np.ndarray]) -> np.ndarray:
    """Numbers of the rows that `fill` searches whatever they are, (n,)."""
    first = rows[np.ix_(range(len(rows)), *(_places(x, 0) for x in axes))]
    return first[first >= 0]


def _places(x, halvings):
    """Where rows of an axis are searched after so many halvings."""
    parts = min(max((x.size - 1) // SPACING, TERMS - 1), MOST) << halvings
    return np.arange(parts + 1) * (x.size - 1) // parts if parts < x.size else np.arange(x.size)


def _corners(where, axes, places):
    """Where the 2^d rows stand between which others do, and their shares of what lies there."""
    corners, shares = [where[:1]], [np.ones(where[0].size)]
    for index, x, at in zip(where[1:], axes, places, strict=True):
        low, high = at[np.searchsorted(at, index, "right") - 1], at[np.searchsorted(at, index)]
        share = (x[index] - x[low]) / np.where(high > low, x[high] - x[low], 1.0)
        sides = (low, 1 - share), (high, share)
        pairs = list(product(zip(corners, shares, strict=True), sides))
        corners = [(*corner, end) for (corner, _), (end, _) in pairs]
        shares = [all_of_it * part for (_, all_of_it), (_, part) in pairs]
    return corners, shares


def _cubic(N, axes, places):
    """N by cubics through the nearest places along each axis; 1 in surfaces that lack one."""
    for axis, (x, at) in enumerate(zip(axes, places, strict=True), 1):
        first = np.searchsorted(at, np.arange(x.size), "right") - TERMS // 2
        nodes = at[np.clip(first, 0, at.size - TERMS)[:, np.newaxis] + np.arange(TERMS)]
        total = 0.0
        for j in range(TERMS):
            weight = np.ones(x.size)
            for i in (*range(j), *range(j + 1, TERMS)):
                weight *= (x - x[nodes[:, i]]) / (x[nodes[:, j]] - x[nodes[:, i]])
            weight = weight.reshape(-1, *[1] * (N.ndim - 1 - axis))
            total = total + weight * N.take(nodes[:, j], axis)
        N = total
    lacks = np.isnan(N).any(axis=tuple(range(1, N.ndim)), keepdims=True)
    return np.where(lacks, 1.0, N)


def expected_labels(
    model: Follows, rows: Rows, settings: Settings, expected: np.ndarray
) -> np.ndarray:
    """Whether labels are those expected at all amplitudes of BELOW and ABOVE, (rows,)."""
    N = np.multiply.outer(expected, BELOW + ABOVE)
    quiet, snapping = np.hsplit(asker(model, rows, settings)(N), [len(BELOW)])
    return np.isnan(quiet).all(axis=1) & np.isfinite(snapping).all(axis=1)
